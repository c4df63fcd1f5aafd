# SPDX-License-Identifier: BSD-3-Clause
"""What several commands share: their options, and what they say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import click

from tilth.errors import AnalysisFailed, BadInput, Interrupted, visible
from tilth.input_files import absolute

CASE = click.argument("case", metavar="CASE.toml", type=click.Path(path_type=Path))
FOLDER = click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
MOST_THREADS = 1024
"""Of the core, and processes of a study."""

THREADS = click.option(
    "--threads",
    type=click.IntRange(min=1, max=MOST_THREADS),
    help="Threads to compute with; all cores if not given. The results do not depend on it.",
)
UNTIL = click.option(
    "--until",
    type=float,
    metavar="TIME",
    help="Stop at the first step that reaches this time of the schedule; `tilth resume` continues.",
)
MEMORY_LIMIT = click.option(
    "--memory-limit",
    metavar="SIZE",
    help="Memory that the run may need by its estimate, such as 64GB or 500MiB, instead of what "
    "is available.",
)
OUT = click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder of the results; default: next to the case file and named after it.",
)
EXPLAIN = click.option(
    "--explain",
    metavar="[STAGE:]STEP",
    help="Explain a load step, by its number in the run or in a stage: the forces "
    "of each term in each Newton iteration, where the residual is largest, and a picture of it.",
)
QUIET = click.option("--quiet", is_flag=True, help="Print nothing but errors.")


def folder_of_results(case: Path, out: Path | None) -> Path:
    """Returns the folder of the results: `out`, or one beside the case file and named after it."""
    folder = case.with_suffix(".results" if not case.suffix else "") if out is None else out
    if absolute(folder) == absolute(case.parent):
        raise BadInput(
            f"the results cannot go into {folder}, the folder of the case file itself",
            "choose another folder with --out",
        )
    return folder


def say_what_runs(functions: Sequence[str], laws: Sequence[str]) -> None:
    """Announces the code of the user that the command is about to run; laws: those among it."""
    for function in functions:
        file, _, name = function.rpartition(":")
        what = "law" if function in laws else "Python function"
        click.echo(visible(f"runs the {what} {name} in {file}"))


def where(folder: Path, finished: bool) -> str:
    """Returns the line that says where the results are, and how to go on if not finished."""
    line = f"results in {folder}"
    return visible(line if finished else f"{line}; continue with: tilth resume {folder}")


def require_decided(undecided: Mapping[str, str]) -> None:
    """Checks that no factor of safety of a stage is undecided; the run itself is complete.

    undecided: what is certain of those that are, by the stages' names.

    Raises:
        AnalysisFailed: one is.
    """
    if undecided:
        from tilth.output.safety_files import TO_DECIDE

        found = (f"in the stage {name!r}: {certain}" for name, certain in undecided.items())
        what = "the factor of safety is undecided"
        raise AnalysisFailed(f"{what} {'; and '.join(found)}", TO_DECIDE)


def interrupted(folder: Path) -> Interrupted:
    """Returns the error of a run in `folder` that was stopped: it says how to go on."""
    from tilth.output.folder import CHECKPOINT

    if (folder / CHECKPOINT).exists():
        return Interrupted(f"interrupted; continue with: tilth resume {folder}")
    return Interrupted("interrupted before the first checkpoint; start the run again")
