# SPDX-License-Identifier: BSD-3-Clause
"""README and docs are true: code blocks run, case files validate, links and commands exist."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import click
import pytest
from script_module import module_of

import tilth
from tilth.cli import cli

ROOT = Path(__file__).parents[1]
FOLDERS = ("docs", "examples", "benchmarks")
PAGES = sorted(page for folder in FOLDERS for page in (ROOT / folder).glob("**/*.md"))
PAGES += sorted(ROOT.glob("*.md"))


def blocks(page: Path, language: str) -> list[str]:
    """The fenced code blocks of a page in one language ("" for none named)."""
    text = page.read_text(encoding="utf-8")
    found = re.findall(r"^```([^`\n]*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [block for named, block in found if named == language]


def pages_with(language: str) -> Any:
    found = [page for page in PAGES if blocks(page, language)]
    return pytest.mark.parametrize("page", found, ids=lambda page: str(page.relative_to(ROOT)))


every_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


@pytest.fixture(scope="module")
def column(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that the README's first command writes."""
    folder = tmp_path_factory.mktemp("docs") / "column"
    model = tilth.load_case(ROOT / "examples" / "self_weight_column" / "case.toml")
    tilth.run(model, folder, quiet=True)
    return folder


@pages_with("python")
def test_python_blocks_run(
    page: Path, column: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All blocks of a page, one after the other, beside the folder of the README's first run."""
    shutil.copytree(column, tmp_path / "column")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "documented"}
    for block in blocks(page, "python"):
        exec(compile(block, str(page), "exec", dont_inherit=True), names)


@pages_with("toml")
def test_case_files_validate(page: Path, tmp_path: Path) -> None:
    for number, block in enumerate(blocks(page, "toml")):
        case = tmp_path / f"{number}.toml"
        case.write_text(block, encoding="utf-8")
        (tilth.load_element_case if "[[tests]]" in block else tilth.load_case)(case)


def test_readme_declares_the_model_of_the_example(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The Python block and the case file are the same problem, but for the curves tracked."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    (block,) = blocks(ROOT / "README.md", "python")
    exec(compile(block, "README.md", "exec"), names)
    case = tilth.load_case(ROOT / "examples" / "self_weight_column" / "case.toml")
    ours, theirs = names["model"].to_dict(), case.to_dict()
    for key in set(theirs) - {"track", "output"}:
        assert ours[key] == theirs[key], key
    height = names["result"].history["height [m]"][-1]
    assert f"# {height:.2f} m; in closed form 24.06 m" in block


def test_readme_has_two_commands_each_on_one_line() -> None:
    commands = [line for block in blocks(ROOT / "README.md", "") for line in block.splitlines()]
    start = "python3 -m venv .venv && .venv/bin/pip install "
    run = "&& .venv/bin/tilth run examples/self_weight_column/case.toml --out column"
    assert commands == [f"{start}. {run}", f'{start}".[test]" && .venv/bin/pytest']
    assert (ROOT / "examples" / "self_weight_column" / "case.toml").is_file()


def test_readme_begins_with_its_three_blocks_of_commands() -> None:
    """`.ci/bare_root` runs the first three blocks of the page."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    languages = re.findall(r"^```([^`\n]*)\n.*?^```$", text, re.MULTILINE | re.DOTALL)
    assert languages[:4] == ["", "", "sh", "python"]


def test_dockerfile_has_the_commands_of_the_readme() -> None:
    """Those for several processes, but for the run; `.ci/run` takes the same lines."""
    (block,) = blocks(ROOT / "README.md", "sh")
    install, build, _ = block.splitlines()
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    assert f"RUN {install}\n" in text
    assert f"RUN {build}\n" in text


@every_page
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if target.startswith("https://"):
            continue
        path, _, heading = target.partition("#")
        place = (page.parent / path).resolve() if path else page
        assert place.exists(), f"{target}: no such file"
        if heading:
            assert heading in anchors(place), f"{target}: no such heading"


@every_page
def test_a_command_makes_each_picture(page: Path) -> None:
    """Those of examples are made by make_pictures.py; of others the page names the script."""
    text = page.read_text(encoding="utf-8")
    of_examples = {p.resolve() for p in (ROOT / "examples").glob("*/*.png")}
    for target in re.findall(r"!\[[^\]]*\]\(([^)\s]+)\)", text):
        if (page.parent / target).resolve() not in of_examples:
            assert re.search(r"(docs|benchmarks)/\w+\.py", text), f"{target}: made by what?"


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, made as the usual renderers do."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings}


PLACES = ("src/", "cpp/", "docs/", "tests/", "examples/", "benchmarks/", ".ci/")


@every_page
def test_files_that_are_named_exist(page: Path) -> None:
    """Paths and tests in backticks; those that a how-to tells the reader to write are its own."""
    text = page.read_text(encoding="utf-8")
    to_write = set(re.findall(r"^## \d+\. .*`([^`]+)`$", text, re.MULTILINE))
    for name in set(re.findall(r"`([^`\s*]+)`", text)) - to_write:
        if name.startswith(PLACES):
            file, _, test = name.partition("::")
            assert (ROOT / file).exists(), f"{name}: no such file"
            if test:
                assert f"def {test}(" in (ROOT / file).read_text(), f"{name}: no such test"


@every_page
def test_commands_exist_with_their_options(page: Path) -> None:
    for line in re.findall(
        r"(?:^|`|&& |/)tilth ([a-z][^`\n|&]*)", page.read_text(encoding="utf-8")
    ):
        words = re.sub(r"[\[\]]", " ", line).split()
        command = cli.get_command(click.Context(cli), words[0])
        assert isinstance(command, click.Command), f"tilth {line}: no such command"
        known = {option for parameter in command.params for option in parameter.opts}
        options = {word for word in words if word.startswith("--")}
        assert options <= known | {"--help"}, f"tilth {line}: no such option"


def test_reference_of_case_files_is_up_to_date() -> None:
    """Run `python docs/generate_reference.py` where it is not."""
    generator = module_of(ROOT / "docs" / "generate_reference.py")
    assert generator.PAGE.read_text(encoding="utf-8") == generator.page()
    assert generator.ELEMENT_PAGE.read_text(encoding="utf-8") == generator.element_page()


def test_glossary_is_sorted_and_each_word_has_one_row_and_a_page() -> None:
    text = (ROOT / "docs" / "reference" / "glossary.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", text, re.MULTILINE)[1:]
    words = [word.lower() for word, _, _ in rows if not word.startswith("-")]
    assert words == sorted(set(words))
    assert len(words) >= 70
    for word, meaning, page in rows[1:]:
        assert meaning.endswith("."), word
        assert re.match(r"\[.+\]\(.+\.md", page), word


def test_changelog_has_this_version() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.search(rf"^## \[{re.escape(tilth.__version__)}\]", text, re.MULTILINE)


CHECK_MATERIAL = """
#include <cstdio>

#include "voce.hpp"

int main() {
  const double parameters[] = {1000.0, 0.3, 60.0, 90.0, 10.0};
  const auto material = tilth::material::Voce::from(parameters);
  const double before = 0.02, trial[3] = {0.2, -0.1, 0.03}, step = 1e-6;
  double tau[3], elastic[3], tangent[3][3], spare[3], high[3], low[3], none[3][3];
  double first[1], state[1], unused[1];
  const double no_stress[3] = {};
  if (!material.initial_state(no_stress, first)) return 1;
  if (!material.update(trial, before, first, state, tau, elastic, tangent)) return 1;
  double error = 0.0;
  for (int b = 0; b < 3; ++b) {
    double above[3] = {trial[0], trial[1], trial[2]}, below[3] = {trial[0], trial[1], trial[2]};
    above[b] += step, below[b] -= step;
    material.update(above, before, first, unused, high, spare, none);
    material.update(below, before, first, unused, low, spare, none);
    for (int a = 0; a < 3; ++a)
      error = std::fmax(error, std::fabs((high[a] - low[a]) / (2.0 * step) - tangent[a][b]));
  }
  static_assert(tilth::material::Law<tilth::material::Voce>);
  std::printf("%.17g %.17g %.17g %.17g %.17g %.3g\\n", tau[0], tau[1], tau[2], first[0], state[0],
              error);
}
"""

CHECK_BASIS = """
#include <cstdio>

#include "quadratic_spline.hpp"

int main() {
  using Spline = tilth::basis::QuadraticSpline;
  for (double x = -2.0; x < 2.0; x += 0.0625) {
    const auto support = Spline::support(x, x);
    double one = 0.0, linear = 0.0, slope = 0.0;
    for (int i = 0; i < support.count; ++i) {
      double value, derivative;
      Spline::evaluate(x - (support.first + i), 0.0, 1.0, 1.0, value, derivative);
      one += value;
      linear += value * (support.first + i);
      slope += derivative * (support.first + i);
    }
    if (std::fabs(one - 1) + std::fabs(linear - x) + std::fabs(slope - 1) > 1e-14) return 1;
  }
  std::puts("reproduces linear fields");
}
"""


def compiled_output(folder: Path, header: Path, program: str) -> str:
    """What a program prints that includes a documented header, compiled beside tilth's."""
    compiler = shutil.which("c++") or shutil.which("g++")
    assert compiler is not None, "a compiler is needed to install tilth"
    (folder / "check.cpp").write_text(program, encoding="utf-8")
    where = ROOT / "cpp" / "tilth" / header.parent.name
    arguments = ["-std=c++20", "-Wall", "-Wextra", "-Werror", f"-I{folder}", f"-I{where}"]
    program_file = folder / "check"
    command = [compiler, *arguments, str(folder / "check.cpp"), "-o", str(program_file)]
    subprocess.run(command, check=True, capture_output=True)
    return subprocess.run([program_file], check=True, capture_output=True, text=True).stdout


def test_documented_material_works(tmp_path: Path) -> None:
    (header,) = blocks(ROOT / "docs" / "howto" / "add_a_material.md", "cpp")
    place = tmp_path / "material" / "voce.hpp"
    (tmp_path / "voce.hpp").write_text(header, encoding="utf-8")
    words = compiled_output(tmp_path, place, CHECK_MATERIAL).split()
    *stress, first, strength, error = (float(word) for word in words)
    assert error < 1e-4  # of a tangent of about 1e3
    mean = sum(stress) / 3.0
    von_mises = (1.5 * sum((s - mean) ** 2 for s in stress)) ** 0.5
    assert first == 60.0 < von_mises < 90.0
    assert strength == pytest.approx(von_mises, rel=1e-12)


def test_documented_basis_works(tmp_path: Path) -> None:
    (header,) = blocks(ROOT / "docs" / "howto" / "add_a_basis.md", "cpp")
    place = tmp_path / "basis" / "quadratic_spline.hpp"
    (tmp_path / "quadratic_spline.hpp").write_text(header, encoding="utf-8")
    assert "reproduces" in compiled_output(tmp_path, place, CHECK_BASIS)
