# SPDX-License-Identifier: BSD-3-Clause
"""A headless Chromium that opens pages of reports and of the manual from the disk."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.support.ui import WebDriverWait

FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
)  # fmt: skip

_KNOWN = ("GPU stall due to ReadPixels", "willReadFrequently")
REPORT_READY = "typeof Tilth === 'object' && Tilth.ready === true"


@contextmanager
def opened(
    page: Path, size: tuple[int, int] = (1200, 900), dark: bool = False, ready: str = REPORT_READY
) -> Iterator[Any]:
    """Yields the driver of a browser that shows the page, once the JavaScript condition holds."""
    options = Options()
    for flag in FLAGS:
        options.add_argument(flag)
    options.binary_location = "/usr/bin/chromium"
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    service = webdriver.ChromeService("/usr/bin/chromedriver")
    driver = webdriver.Chrome(options=options, service=service)
    try:
        colours = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": colours})
        metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        driver.get(page.resolve().as_uri())
        WebDriverWait(driver, 60).until(lambda d: d.execute_script(f"return {ready}"))
        yield driver
    finally:
        driver.quit()


def complaints(driver: Any) -> list[str]:
    """Returns errors and warnings of the console, without those about slow graphics or tests."""
    told = [f"{entry['level']}: {entry['message']}" for entry in driver.get_log("browser")]
    return [text for text in told if not any(known in text for known in _KNOWN)]
