# SPDX-License-Identifier: BSD-3-Clause
"""The manual as a site: it builds without warnings, its links are right, it needs no network."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import urllib.parse
from html.parser import HTMLParser
from pathlib import Path

import pytest
from report_browser import complaints, opened
from script_module import module_of
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

ROOT = Path(__file__).parents[1]
LOADED_PAGE = "document.readyState === 'complete'"
LOADED = {
    "script": "src", "img": "src", "iframe": "src", "source": "src", "video": "src", "link": "href",
}  # fmt: skip


class Document(HTMLParser):
    """Collects what a page of the site loads, links to, and can be linked at."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.anchors.update(value for key in ("id", "name") if (value := values.get(key)))
        if tag in LOADED and (address := values.get(LOADED[tag])):
            self.loaded.append(address)
        if tag == "a" and (address := values.get("href")):
            self.links.append(address)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("manual") / "site"
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    quiet = os.environ | {"NO_MKDOCS_2_WARNING": "1"}  # of the theme, about its own future
    done = subprocess.run(command, cwd=ROOT, env=quiet, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "WARNING" not in done.stderr
    return folder


@pytest.fixture(scope="module")
def documents(site: Path) -> dict[Path, Document]:
    """Every page but that for unknown addresses, which only a web server shows."""
    pages = sorted(site.glob("**/*.html"))
    return {page: Document(page) for page in pages if page.name != "404.html"}


def is_external(address: str) -> bool:
    return address.startswith("//") or bool(urllib.parse.urlsplit(address).scheme)


@pytest.mark.slow
def test_links_lead_somewhere(site: Path, documents: dict[Path, Document]) -> None:
    broken = []
    for page, document in documents.items():
        for address in {*document.links, *document.loaded}:
            if is_external(address):
                continue
            parts = urllib.parse.urlsplit(address)
            path = urllib.parse.unquote(parts.path)
            file = (page.parent / path).resolve() if path else page
            heading = urllib.parse.unquote(parts.fragment)
            if not file.is_file():
                broken.append(f"{page.relative_to(site)}: {address}")
            elif heading and file in documents and heading not in documents[file].anchors:
                broken.append(f"{page.relative_to(site)}: {address}: no such heading")
    assert not broken


@pytest.mark.slow
def test_nothing_is_loaded_from_elsewhere(site: Path, documents: dict[Path, Document]) -> None:
    for page, document in documents.items():
        external = [address for address in document.loaded if is_external(address)]
        assert not external, f"{page.relative_to(site)}: {external}"
    for sheet in site.glob("**/*.css"):
        text = sheet.read_text(encoding="utf-8")
        addresses = re.findall(r"url\(\s*[\"']?([^)\"']+)", text)
        addresses += re.findall(r"@import\s+[\"']([^\"']+)", text)
        for address in addresses:
            assert address.startswith("data:") or not is_external(address), sheet.name


@pytest.mark.slow
def test_every_page_is_there(site: Path) -> None:
    for page in (ROOT / "docs").glob("**/*.md"):
        if page.parent.name == "assets":
            continue
        built = site / page.relative_to(ROOT / "docs")
        name = "index.html" if page.name == "README.md" else f"{page.stem}.html"
        assert (built.parent / name).is_file(), page
    for example in (ROOT / "examples").glob("*/README.md"):
        built = site / "examples" / example.parent.name / "index.html"
        text = re.sub(r"<[^>]+>", "", built.read_text(encoding="utf-8"))
        for case in example.parent.glob("*.toml"):
            assert case.name in text
            assert "format = 1" in text


@pytest.mark.slow
def test_a_browser_typesets_formulas_from_the_disk(site: Path) -> None:
    count = "return document.querySelectorAll(arguments[0]).length"
    total = 0
    with opened(site / "index.html", ready=LOADED_PAGE) as driver:
        for page in sorted(site.glob("theory/*.html")):
            driver.get(page.as_uri())
            marked = driver.execute_script(count, ".arithmatex")
            assert driver.execute_script(count, ".arithmatex .katex-html") == marked, page.name
            assert driver.execute_script(count, ".katex-error") == 0, page.name
            total += marked
        assert not complaints(driver)
    assert total > 500


@pytest.mark.slow
def test_a_browser_searches_from_the_disk(site: Path) -> None:
    with opened(site / "tutorial.html", ready=LOADED_PAGE) as driver:
        driver.execute_script("document.querySelector('[for=__search]').click()")
        field = driver.find_element(By.CSS_SELECTOR, "input.md-search__input")
        WebDriverWait(driver, 30).until(lambda _: field.is_displayed() and field.is_enabled())
        field.send_keys("volumetric locking")
        results = "a.md-search-result__link"
        found = WebDriverWait(driver, 60).until(lambda d: d.find_elements(By.CSS_SELECTOR, results))
        addresses = [link.get_attribute("href") or "" for link in found]
        assert any("theory/f_bar.html" in address for address in addresses), addresses
        assert not complaints(driver)


GENERATOR = ROOT / "docs" / "generate_verification.py"


def test_verification_is_up_to_date() -> None:
    """Run `python docs/generate_verification.py` where it is not."""
    module = module_of(GENERATOR)
    rows = json.loads(module.STORED.read_text(encoding="utf-8"))
    assert module.PAGE.read_text(encoding="utf-8") == module.page(rows)
    missed = [row for row in rows if not row["error"] <= row["tolerance"]]
    assert missed == [row for row in rows if not row["passed"]]
    assert module.PAGE.read_text(encoding="utf-8").count(", **missed** |") == len(missed)


def test_new_problems_of_the_verification_replace_stored_ones() -> None:
    module = module_of(GENERATOR)
    row = {"quantity": "height", "unit": "m", "computed": 1.0, "reference": 1.0, "error": 0.0}
    row |= {"tolerance": 0.1, "source": "theory", "passed": True, "seconds": 1.0}
    stored = [row | {"problem": "slope"}, row | {"problem": "collapse", "computed": 2.0}]
    merged = module.merged(stored, [row | {"problem": "collapse"}])
    assert [(r["problem"], r["computed"]) for r in merged] == [("collapse", 1.0), ("slope", 1.0)]
    assert "seconds" not in merged[0]
    with pytest.raises(ValueError, match="no such problem"):
        module.merged([], [row | {"problem": "sloop"}])


def test_every_example_is_in_the_gallery() -> None:
    gallery = (ROOT / "docs" / "gallery" / "README.md").read_text(encoding="utf-8")
    for example in (ROOT / "examples").glob("*/README.md"):
        name = example.parent.name
        assert f"](../../examples/{name})" in gallery, name
        assert f"](../../examples/{name}/" in gallery, f"{name}: no picture"


def commands() -> str:
    """All scripts that may draw, and all commands that start Python in a page."""
    folders = ("docs", "examples", "benchmarks")
    scripts = [file for folder in folders for file in (ROOT / folder).glob("**/*.py")]
    pages = [
        ROOT / "README.md",
        *(p for folder in folders for p in (ROOT / folder).glob("**/*.md")),
    ]
    found = [file.read_text(encoding="utf-8") for file in scripts]
    for page in pages:
        text = re.sub(r"^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
        lines = re.findall(r"`([^`]+)`", text) + re.findall(r"^ {4}(\S.*)$", text, re.MULTILINE)
        found += [" ".join(line.split()) for line in lines if "python" in line]
    return "\n".join(found)


def test_every_figure_has_the_command_that_makes_it() -> None:
    """A script names it, or a page gives a command with its name."""
    known = commands()
    for folder in ("docs", "examples"):
        for picture in sorted((ROOT / folder).glob("**/*.png")):
            if picture.name.endswith(".setup.png"):
                continue
            # `examples/make_pictures.py` names those of element tests as their case files
            drawn = (
                picture.parent.name == "element_tests" and picture.with_suffix(".toml").is_file()
            )
            assert drawn or re.search(rf"\b{re.escape(picture.name)}", known), picture
