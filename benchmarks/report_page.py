# SPDX-License-Identifier: BSD-3-Clause
"""Opening time, size and frames per second of a report, and pictures of it, in headless Chromium.

python benchmarks/report_page.py FOLDER [--pictures NAME]

FOLDER is that of a run with a report. The browser draws without a graphics card (SwiftShader), so
the frames per second are a lower bound. ``--pictures docs/gallery/report_2d`` saves the page as
seen on a desktop, dark, and on a phone, as report_2d.png, report_2d_dark.png, report_2d_phone.png.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from report_browser import complaints, opened

DRAW = """
const view = Tilth.view, scene = view.scene, context = scene.renderer.getContext();
const pixel = new Uint8Array(4);
const done = () => context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, pixel);
scene.render(); done();
"""
TURN = f"""{DRAW}
let count = 0; const start = performance.now();
while (performance.now() - start < 3000) {{
  const at = scene.camera.position;
  if (scene.plane) scene.camera.zoom = 1 + 0.2 * Math.sin(count);
  else at.applyAxisAngle(scene.camera.up, 0.05);
  scene.camera.lookAt(0, 0, 0);
  scene.camera.updateProjectionMatrix(); scene.camera.updateMatrixWorld();
  scene.render(); done(); count += 1;
}}
scene.look(); scene.resize();
return 1000 * count / (performance.now() - start);
"""
SLIDE = f"""{DRAW}
let count = 0; const start = performance.now(), all = view.body.frames.length;
for (let k = 0; performance.now() - start < 3000; k++) {{
  await view.show(k % all); scene.render(); done(); count += 1;
}}
return 1000 * count / (performance.now() - start);
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--pictures", type=Path, help="beginning of the names of the pictures")
    given = parser.parse_args()
    page = given.folder / "report.html"
    with opened(page) as driver:
        driver.set_script_timeout(300)
        begin = time.perf_counter()
        driver.refresh()
        while not driver.execute_script("return typeof Tilth === 'object' && Tilth.ready === true"):
            time.sleep(0.02)
        opening = time.perf_counter() - begin
        frame = driver.execute_script("return Tilth.data.body.frames.at(-1)")
        outputs = driver.execute_script("return Tilth.data.body.frames.length")
        notes = driver.execute_script("return Tilth.data.body.notes.join(' ')")
        print(f"{page.stat().st_size / 1e6:.2f} MB, opened in {opening:.2f} s")
        print(f"{frame['count']:,} of {frame['total']:,} points, {outputs} outputs. {notes}")
        print(f"{driver.execute_script(TURN):.1f} frames per second turned or enlarged")
        print(f"{driver.execute_script(SLIDE):.1f} outputs per second on the slider")
        print("console:", complaints(driver) or "silent")
    if given.pictures:
        for suffix, size, dark in (
            ("", (1200, 1800), False),
            ("_dark", (1200, 1800), True),
            ("_phone", (390, 1800), False),
        ):
            with opened(page, size, dark) as driver:
                save(driver, Path(f"{given.pictures}{suffix}.png"))


def save(driver: Any, path: Path) -> None:
    """Saves what is visible, with at most 256 colours."""
    from io import BytesIO

    from PIL import Image

    time.sleep(1.0)  # layout and the first frames
    picture = Image.open(BytesIO(driver.get_screenshot_as_png())).convert("RGB")
    picture.quantize(256).save(path, optimize=True)


if __name__ == "__main__":
    main()
