# SPDX-License-Identifier: BSD-3-Clause
"""Brings pages from outside docs/ into the site and leads its links to them (hooks of mkdocs).

Links in the repository lead from file to file, so that they work where it is browsed. In the site

- README.md is the first page, an example's folder is its README with the case files below it;
- a folder in ``INDEXES`` is the page that lists what is in it;
- a notebook of ``docs/notebooks`` is a page with its texts, code and stored output;
- any other file, such as a source file, is a page with its text.
"""

from __future__ import annotations

import base64
import json
import posixpath
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[1]
DECISIONS = "decisions/README.md"
OUTSIDE = ("CONTRIBUTING.md", "CHANGELOG.md", "benchmarks/README.md")
INDEXES = {"docs/decisions": DECISIONS, "examples": "gallery/README.md"}
LANGUAGES = {".py": "python", ".pyi": "python", ".hpp": "cpp", ".cpp": "cpp", ".toml": "toml"}

CODE = re.compile(r"^(`{3,})[^\n]*\n.*?^\1`*\s*?$|(?<!`)`[^`\n]+`(?!`)", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")


def place_in_site(path: str) -> str:
    """Returns the site's name of a file or folder of the repository, relative to their roots."""
    if path in INDEXES:
        return INDEXES[path]
    if path == "README.md":
        return "index.md"
    if path.endswith(".ipynb"):
        path = f"{path.removesuffix('.ipynb')}.md"
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    if (ROOT / path).is_dir():
        return f"{path}/README.md"
    if path.endswith((".md", ".png", ".gif")):
        return path
    return f"files/{path}.md"


def place_in_repository(name: str) -> str:
    """Returns the file of the repository of which a page of the site has the text."""
    if name == "index.md":
        return "README.md"
    if name.startswith("notebooks/"):
        return f"docs/{name.removesuffix('.md')}.ipynb"
    return name if (ROOT / name).is_file() else f"docs/{name}"


def outside_code(text: str, change: Callable[[str], str]) -> str:
    """Returns the text with its parts outside code blocks and spans changed."""
    parts, end = [], 0
    for code in CODE.finditer(text):
        parts += [change(text[end : code.start()]), code.group()]
        end = code.end()
    return "".join([*parts, change(text[end:])])


def targets(text: str, folder: str) -> list[str]:
    """Returns the files and folders of the repository that a text in a folder links to."""
    found: list[str] = []

    def collect(part: str) -> str:
        found.extend(LINK.findall(part))
        return part

    outside_code(text, collect)
    paths = (target.partition("#")[0] for target in found if "://" not in target)
    return [posixpath.normpath(posixpath.join(folder, path)) for path in paths if path]


def in_site(text: str, folder: str, name: str) -> str:
    """Returns a text of a folder of the repository with its links as of a page of the site."""

    def lead(link: re.Match[str]) -> str:
        path, mark, heading = link.group(1).partition("#")
        if not path or "://" in link.group(1):
            return link.group()
        there = place_in_site(posixpath.normpath(posixpath.join(folder, path)))
        return f"]({posixpath.relpath(there, posixpath.dirname(name) or '.')}{mark}{heading})"

    return outside_code(text, lambda part: LINK.sub(lead, part))


def fenced(file: Path) -> str:
    """Returns the text of a file as a code block."""
    text = file.read_text(encoding="utf-8").rstrip()
    longest = max([2, *(len(run) for run in re.findall("`{3,}", text))])
    fence = "`" * (longest + 1)
    return f"{fence}{LANGUAGES.get(file.suffix, 'text')}\n{text}\n{fence}\n"


def example_page(folder: Path) -> str:
    """Returns an example's README with its case files."""
    text = (folder / "README.md").read_text(encoding="utf-8")
    first = folder / "case.toml"
    cases = [first, *sorted(set(folder.glob("*.toml")) - {first})]
    blocks = [f"### `{file.name}`\n\n{fenced(file)}" for file in cases]
    return "\n".join([text, "## Case files\n", *blocks])


def notebook_page(file: Path) -> tuple[str, dict[str, bytes]]:
    """Returns a notebook as a page, and its pictures by name."""
    parts, pictures = [], {}
    for number, cell in enumerate(json.loads(file.read_text(encoding="utf-8"))["cells"]):
        text = "".join(cell["source"])
        parts.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
        for output in cell.get("outputs", ()):
            data = output.get("data", {"text/plain": output.get("text", "")})
            if "image/png" in data:
                name = f"{file.stem}_{number}.png"
                pictures[name] = base64.b64decode(data["image/png"])
                parts.append(f"![output of the code above]({name})")
            else:
                parts.append(f"```text\n{''.join(data['text/plain']).rstrip()}\n```")
    parts.append(f"This page is the notebook `docs/notebooks/{file.name}`.")
    return "\n\n".join([*parts, ""]), pictures


def decisions_page() -> str:
    """Returns a page that lists the decisions by their titles."""
    lines = []
    for file in sorted((ROOT / "docs" / "decisions").glob("*.md")):
        title = file.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")
        number, _, words = title.partition(". ")
        lines.append(f"| {number} | [{words}](../docs/decisions/{file.name}) |")
    heading = "# Decisions\n\nWhat was decided where a change would be expensive, and why.\n"
    return "\n".join([heading, "| | |", "| --- | --- |", *lines, ""])


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Replaces names in the navigation that end in * by the pages of that folder."""
    config.nav = expanded(config.nav)
    return config


def expanded(entry: Any) -> Any:
    """Returns a list, section or page of the navigation without names that end in *."""
    if isinstance(entry, dict):
        return {title: expanded(value) for title, value in entry.items()}
    if not isinstance(entry, list):
        return entry
    pages: list[Any] = []
    for item in entry:
        if item == "examples/*":
            found = sorted((ROOT / "examples").glob("*/README.md"))
            pages += [f"examples/{file.parent.name}/README.md" for file in found]
        elif item == "decisions/*":
            found = sorted((ROOT / "docs" / "decisions").glob("*.md"))
            pages += [DECISIONS, *(f"decisions/{file.name}" for file in found)]
        else:
            pages.append(expanded(item))
    return pages


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the pages and pictures from outside docs/, and the files that pages link to."""
    texts = {path: (ROOT / path).read_text(encoding="utf-8") for path in OUTSIDE}
    texts["index.md"] = (ROOT / "README.md").read_text(encoding="utf-8")
    texts[DECISIONS] = decisions_page()
    for readme in sorted((ROOT / "examples").glob("*/README.md")):
        texts[f"examples/{readme.parent.name}/README.md"] = example_page(readme.parent)
    for notebook in sorted((ROOT / "docs" / "notebooks").glob("*.ipynb")):
        name = f"notebooks/{notebook.stem}.md"
        texts[name], pictures = notebook_page(notebook)
        for picture, content in pictures.items():
            files.append(File.generated(config, f"notebooks/{picture}", content=content))
    for name, text in texts.items():
        files.append(File.generated(config, name, content=text))
    for name in [file.src_uri for file in files if file.is_documentation_page()]:
        page = ROOT / place_in_repository(name)
        if name != DECISIONS and page.suffix == ".md":
            text = page.read_text(encoding="utf-8")
            add_linked(text, page.parent.relative_to(ROOT).as_posix(), files, config)
    return files


def add_linked(text: str, folder: str, files: Files, config: MkDocsConfig) -> None:
    """Adds the files that a text of a folder of the repository links to, where they are missing."""
    for path in targets(text, folder):
        name, source = place_in_site(path), ROOT / path
        if files.get_file_from_path(name) or not source.is_file():
            continue
        if name.startswith("files/"):
            page = f"# `{path}`\n\n{fenced(source)}"
            files.append(File.generated(config, name, content=page))
        else:
            files.append(File.generated(config, name, abs_src_path=str(source)))


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Leads the links of a page to their places in the site."""
    name = page.file.src_uri
    if name.startswith("files/"):
        page.meta["search"] = {"exclude": True}
        return markdown
    if name == "CHANGELOG.md":  # has every word, and would be the first result
        page.meta["search"] = {"boost": 0.1}
    folder = "decisions" if name == DECISIONS else posixpath.dirname(place_in_repository(name))
    return in_site(markdown, folder, name)
