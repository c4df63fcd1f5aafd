# SPDX-License-Identifier: BSD-3-Clause
"""What `tilth safety` runs and prints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from rich.console import Console
from rich.text import Text

from tilth.analysis.safety_run import safety
from tilth.analysis.safety_search import Trial
from tilth.case import load_case
from tilth.errors import AnalysisFailed, BadInput, visible
from tilth.model import StrengthReduction
from tilth.model.davis import DavisForm
from tilth.output.folder import load_model
from tilth.output.safety_files import TO_DECIDE, read_safety, whose_text
from tilth.report.safety import text_of


def find_safety(
    case: Path,
    folder: Path,
    *,
    tolerance: float,
    start: float,
    davis: DavisForm | None,
    threads: int | None,
    overwrite: bool,
    quiet: bool,
    say: Callable[[Sequence[str], Sequence[str]], None],
) -> None:
    """Finds the factor of safety of a case file, or of the run in a folder, and prints it.

    Args:
        case: the case file, or the folder itself.
        folder: of the results.
        tolerance, start, davis: of `StrengthReduction`.
        threads, overwrite, quiet: as in `safety`.
        say: announces the code of the user that is run.

    Raises:
        BadInput, AnalysisFailed, KeyboardInterrupt: as `safety`.
        AnalysisFailed: the factor is undecided; its files are written.
    """
    settings = StrengthReduction(tolerance=tolerance, start=start, davis=davis)
    is_run = case.is_dir()
    model = load_model(case) if is_run else load_case(case)
    console = Console(highlight=False, quiet=quiet)
    if not quiet:
        say(model.functions, model.user_laws)

    def on_trial(trial: Trial) -> None:
        moved = f"largest displacement {trial.displacement:.4g} {model.units.length}".rstrip()
        found = f"{trial.outcome.value} ({trial.failure})" if trial.failure else moved
        line = f"factor {trial.factor:<8.6g} {trial.iterations:3d} iterations  {found}"
        console.print(Text(visible(line)), soft_wrap=True)

    try:
        safety(
            case if is_run else model,
            None if is_run else folder,
            settings=settings,
            threads=threads,
            overwrite=overwrite,
            quiet=quiet,
            on_trial=on_trial,
        )
    except BadInput as error:
        raise error if error.file or is_run else error.in_file(case) from None
    summary = read_safety(folder)
    console.print(Text(text_of(summary)), soft_wrap=True)
    console.print(Text(visible(f"results in {folder}")), soft_wrap=True)
    if not summary.is_decided:
        raise AnalysisFailed(
            f"the factor of safety is undecided{whose_text(summary.davis)}: {summary.bracket}",
            TO_DECIDE,
        )
