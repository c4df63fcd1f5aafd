# SPDX-License-Identifier: BSD-3-Clause
"""Rules of CONTRIBUTING.md that no linter knows: length, licence lines, the core's stub."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

LONGEST = 500
ROOT = Path(__file__).parents[1]


def tracked_sources() -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files", "*.py", "*.hpp", "*.cpp", ".ci/run"],
        cwd=ROOT, check=True, capture_output=True, text=True,
    )  # fmt: skip
    return [ROOT / name for name in listed.stdout.split()]


def clashes(sources: list[Path]) -> list[str]:
    """Modules of tests that pytest would import by one name: those of no package."""
    loose = [
        source.name
        for source in sources
        if source.match("test_*.py") and not (source.parent / "__init__.py").exists()
    ]
    return [f"{name}: {n} modules have this name" for name, n in Counter(loose).items() if n > 1]


def problems() -> list[str]:
    found = []
    for source in tracked_sources():
        name = source.relative_to(ROOT)
        lines = source.read_text(encoding="utf-8").splitlines()
        if len(lines) > LONGEST:
            found.append(f"{name}: {len(lines)} lines, at most {LONGEST} are allowed")
        if source.suffix and not any("SPDX-License-Identifier" in line for line in lines[:2]):
            found.append(f"{name}: no SPDX licence line at the top")
    found += clashes(tracked_sources())
    with tempfile.TemporaryDirectory() as folder:
        stub = Path(folder) / "_core.pyi"
        generate = ["-m", "nanobind.stubgen", "-q", "-m", "tilth._core", "-o", str(stub)]
        subprocess.run([sys.executable, *generate], check=True)
        if stub.read_text() != (ROOT / "src/tilth/_core.pyi").read_text():
            found.append(f"src/tilth/_core.pyi is out of date: python {' '.join(generate[:-1])} it")
    return found


if __name__ == "__main__":
    sys.exit("\n".join(problems()) or 0)
