# SPDX-License-Identifier: BSD-3-Clause
"""Command line: reads the arguments, calls the library, converts errors to exit codes."""

from __future__ import annotations

import os
import platform
import sys
import tempfile
import traceback
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TextIO

import click

from tilth import __version__
from tilth.environment import set_environment, several_processes
from tilth.errors import (
    EXIT_ANALYSIS_FAILED,
    EXIT_BAD_INPUT,
    EXIT_BUG,
    EXIT_DONE,
    EXIT_INTERRUPTED,
    ISSUE_TRACKER,
    BadInput,
    Interrupted,
    TilthError,
    visible,
)
from tilth.interrupt import StopSignals, ignore_stop_signals
from tilth.memory_errors import REMEDY, is_memory_error, memory_sentence

_CASE = click.argument("case", metavar="CASE.toml", type=click.Path(path_type=Path))
_FOLDER = click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
_THREADS = click.option(
    "--threads",
    type=click.IntRange(min=1),
    help="Threads to compute with; all cores if not given. The results do not depend on it.",
)
_UNTIL = click.option(
    "--until",
    type=float,
    metavar="TIME",
    help="Stop at the first step that reaches this time of the schedule; `tilth resume` continues.",
)
_MEMORY_LIMIT = click.option(
    "--memory-limit",
    metavar="SIZE",
    help="Memory that the run may need by its estimate, such as 64GB or 500MiB, instead of what "
    "is available.",
)
_OUT = click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder of the results; default: next to the case file and named after it.",
)
_QUIET = click.option("--quiet", is_flag=True, help="Print nothing but errors.")


SHARED = ("run", "resume", "verify", "safety")
"""Commands that several processes carry out together; of others it is the first one alone."""

PICTURES = (".png", ".pdf", ".svg")


def _picture(context: click.Context, option: click.Parameter, file: Path | None) -> Path | None:
    """Refuses the name of a picture that is none of `PICTURES`."""
    if file is not None and file.suffix.lower() not in PICTURES:
        raise click.BadParameter(f"'{visible(str(file))}' does not end with {', '.join(PICTURES)}.")
    return file


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="tilth", message="%(prog)s %(version)s")
@click.pass_context
def cli(context: click.Context) -> None:
    """Implicit material point method for large deformations of soil.

    Exit codes: 0 done; 1 the analysis could not be finished, results so far are on disk; 2 the
    input is wrong; 3 interrupted; 4 a bug in tilth.
    """
    from tilth.analysis.available_memory import require_memory_of_program

    if several_processes():
        from tilth.mpi import begin_together

        if not begin_together() and context.invoked_subcommand not in SHARED:
            context.exit()
    require_memory_of_program()


@cli.command()
@_CASE
@_OUT
@_THREADS
@_UNTIL
@_MEMORY_LIMIT
@click.option("--overwrite", is_flag=True, help="Replace the results of an earlier run in DIR.")
@click.option(
    "--from",
    "start",
    metavar="DIR:STAGE",
    help="Go on from the end of a stage of the run in DIR; the stages up to it must be the same.",
)
@_QUIET
def run(
    case: Path,
    out: Path | None,
    threads: int | None,
    until: float | None,
    memory_limit: str | None,
    overwrite: bool,
    start: str | None,
    quiet: bool,
) -> None:
    """Run the analysis of a case file.

    Writes results.vtkhdf (for ParaView), history.csv, report.html and log.txt.
    """
    from tilth.case import load_case

    model = load_case(case)
    if not quiet:
        _say_what_runs(model.functions, model.user_laws)
    folder = _folder_of_results(case, out)
    from tilth.analysis import run as analysis
    from tilth.analysis.from_stage import parse_start

    try:
        result = analysis.run(
            model,
            folder,
            from_stage=None if start is None else parse_start(start),
            threads=threads,
            until=until,
            memory_limit=memory_limit,
            overwrite=overwrite,
            quiet=quiet,
        )
    except KeyboardInterrupt:
        raise _interrupted(folder) from None
    except BadInput as error:
        raise error if error.file else error.in_file(case) from None
    if not quiet:
        with suppress(BrokenPipeError):  # the run is done, whoever reads of it
            click.echo(_where(folder, result.finished))


@cli.command()
@_CASE
@click.option(
    "--picture",
    type=click.Path(path_type=Path, dir_okay=False),
    callback=_picture,
    metavar="FILE.png",
    help="Picture of the set-up (.png, .pdf, .svg); default: CASE.setup.png beside the case file.",
)
def check(case: Path, picture: Path | None) -> None:
    """Validate a case file without running it, and draw its set-up.

    With stages the picture has a panel for each. Each parameter that varies from place to place
    gets a picture of its own beside it. The first steps are taken, for about a second, to estimate
    the time of the run. Python functions that the case names are run.
    """
    from tilth.case import load_case
    from tilth.report.setup_data import Setup
    from tilth.report.summary import print_summary

    model = load_case(case)
    from tilth.analysis.available_memory import available_memory
    from tilth.analysis.memory import memory_of, require_memory_to_check
    from tilth.analysis.run import set_threads
    from tilth.analysis.run_time import time_text
    from tilth.analysis.setup import setup_figures
    from tilth.output.disk import is_of_the_disk, reason_of
    from tilth.report.texts import save

    file = case.with_suffix(".setup.png") if picture is None else picture
    _say_what_runs(model.functions, model.user_laws)
    try:
        estimate, available = memory_of(model), available_memory()
        too_large = require_memory_to_check(estimate, available)
        setup, figures = setup_figures(model)
        soil = setup if isinstance(setup, Setup) else setup.whole()
        set_threads(None)
        time = "not estimated" if too_large else time_text(model)
        print_summary(model, soil, estimate, available, time=time)
    except BadInput as error:
        raise error if error.file else error.in_file(case) from None
    files = {name: _beside(file, name) for name in figures}
    try:
        for name, figure in figures.items():
            save(figure, files[name])
    except OSError as error:
        if is_of_the_disk(error):
            raise
        problem = f"the picture cannot be written to {file}: {reason_of(error)}"
        raise BadInput(problem, "choose another file with --picture") from None
    for text in (*setup.warnings, *([too_large] if too_large else [])):
        click.echo(visible(f"warning: {text}"), err=True)
    for name, drawn in files.items():
        click.echo(visible(f"{name.replace('_', ' ') or 'set-up'} drawn in {drawn}"))


@cli.command()
@_FOLDER
@_THREADS
@_UNTIL
@_MEMORY_LIMIT
@_QUIET
def resume(
    folder: Path, threads: int | None, until: float | None, memory_limit: str | None, quiet: bool
) -> None:
    """Continue an interrupted run from its last complete step.

    The result is identical, bit for bit, to that of an uninterrupted run. The folder is code where
    its model names a Python function: that function is run.
    """
    from tilth.output.folder import MODEL, load_model, require_folder

    require_folder(folder)
    if not quiet and (folder / MODEL).exists():
        model = load_model(folder)
        _say_what_runs(model.functions, model.user_laws)
    from tilth.analysis import run as analysis

    try:
        result = analysis.resume(
            folder, threads=threads, until=until, memory_limit=memory_limit, quiet=quiet
        )
    except KeyboardInterrupt:
        raise _interrupted(folder) from None
    if not quiet:
        with suppress(BrokenPipeError):  # the run is done, whoever reads of it
            click.echo(_where(folder, result.finished))


@cli.command()
@_FOLDER
def report(folder: Path) -> None:
    """Write report.html again from the results of a run; no function of the model is run."""
    from tilth.output.folder import require_folder
    from tilth.output.lock import holder_of

    require_folder(folder)
    from tilth.analysis.setup import write_report

    click.echo(visible(f"report written to {write_report(folder)}"))
    if holder := holder_of(folder):
        note = f"the run is not finished and may replace the report at its end ({holder})"
        click.echo(visible(note))


@cli.command()
@click.argument("case", metavar="CASE.toml|DIR", type=click.Path(path_type=Path))
@_OUT
@click.option("--tolerance", type=float, default=0.01, show_default=True, help="Of the factor.")
@click.option("--start", type=float, default=1.0, show_default=True, help="Factor to try first.")
@_THREADS
@click.option("--overwrite", is_flag=True, help="Replace the results of an earlier run in DIR.")
@_QUIET
def safety(
    case: Path,
    out: Path | None,
    tolerance: float,
    start: float,
    threads: int | None,
    overwrite: bool,
    quiet: bool,
) -> None:
    """Run a case, then find its factor of safety by strength reduction.

    Or find that of an earlier run in the folder DIR, at its last checkpoint. Adds safety.csv,
    safety.png, safety.vtkhdf and safety.json to the folder of the results, and the mechanism to the
    report.
    """
    from tilth.analysis.safety_command import find_safety

    is_run = case.is_dir()
    if is_run and (out is not None or overwrite):
        raise BadInput(
            "--out and --overwrite are for case files", "leave them out for the folder of a run"
        )
    folder = case if is_run else _folder_of_results(case, out)
    try:
        find_safety(
            case, folder, tolerance=tolerance, start=start, threads=threads, overwrite=overwrite,
            quiet=quiet, say=_say_what_runs,
        )  # fmt: skip
    except KeyboardInterrupt:
        stopped = _interrupted(folder)
        raise Interrupted(f"{stopped.message}, then: tilth safety {folder}") from None


@cli.command()
@_CASE
@_OUT
@click.option("--overwrite", is_flag=True, help="Replace the results of earlier tests in DIR.")
@click.option(
    "--check",
    "only_check",
    is_flag=True,
    help="Compare the tangents of the materials with differences, instead; write nothing.",
)
@_QUIET
@click.pass_context
def element(
    context: click.Context,
    case: Path,
    out: Path | None,
    overwrite: bool,
    only_check: bool,
    quiet: bool,
) -> None:
    """Make the element tests of a case file: laboratory tests on one material point.

    Writes a table (CSV) of each test and material, and pictures. With --check exit code 1 if a
    tangent is out of its tolerance.
    """
    from tilth.case import load_element_case

    declared = load_element_case(case)
    _say_what_runs(declared.user_laws, declared.user_laws)
    folder = _folder_of_results(case, out)
    from tilth.element_tests.command import make_tests, print_check

    try:
        if only_check:
            context.exit(print_check(declared))
        make_tests(declared, folder, overwrite=overwrite, quiet=quiet)
    except BadInput as error:
        raise error if error.file else error.in_file(case) from None
    if not quiet:
        click.echo(visible(f"results in {folder}"))


@cli.command()
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option("--long", is_flag=True, help="Include the fine grids that take long.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")
@click.pass_context
def verify(context: click.Context, names: tuple[str, ...], long: bool, as_json: bool) -> None:
    """Compare with reference solutions: all problems, or those NAMEd.

    Exit code 1 if any row is out of its tolerance.
    """
    from tilth.verification import run_verification

    context.exit(run_verification(names, long=long, as_json=as_json))


def _folder_of_results(case: Path, out: Path | None) -> Path:
    """Returns the folder of the results: `out`, or one beside the case file and named after it."""
    folder = case.with_suffix(".results" if not case.suffix else "") if out is None else out
    if folder.resolve() == case.parent.resolve():
        raise BadInput(
            f"the results cannot go into {folder}, the folder of the case file itself",
            "choose another folder with --out",
        )
    return folder


def _say_what_runs(functions: Sequence[str], laws: Sequence[str]) -> None:
    """Announces the code of the user that the command is about to run; laws: those among it."""
    for function in functions:
        file, _, name = function.rpartition(":")
        what = "law" if function in laws else "Python function"
        click.echo(visible(f"runs the {what} {name} in {file}"))


def _beside(file: Path, name: str) -> Path:
    """Returns the file of a further picture: NAME.png is NAME.parameter.png."""
    return file.with_name(f"{file.stem}.{name}{file.suffix}") if name else file


def _where(folder: Path, finished: bool) -> str:
    where = visible(f"results in {folder}")
    return where if finished else visible(f"{where}; continue with: tilth resume {folder}")


def _interrupted(folder: Path) -> Interrupted:
    from tilth.output.folder import CHECKPOINT

    if (folder / CHECKPOINT).exists():
        return Interrupted(f"interrupted; continue with: tilth resume {folder}")
    return Interrupted("interrupted before the first checkpoint; start the run again")


def run_command(arguments: Sequence[str]) -> int:
    """Runs `tilth ARGUMENTS`, prints any error as a plain message; returns the exit code.

    Ctrl-C, SIGTERM and SIGHUP end it with exit code 3.
    """
    with StopSignals() as stop:
        try:
            code = cli.main(list(arguments), prog_name="tilth", standalone_mode=False)
        except click.ClickException as error:
            with suppress(OSError):
                error.show()
            return EXIT_BAD_INPUT
        except TilthError as error:
            _say_error(str(error), None if error.exit_code == EXIT_INTERRUPTED else "red")
            return error.exit_code
        except (click.Abort, KeyboardInterrupt):
            _say_interrupted()
            return EXIT_INTERRUPTED
        except BrokenPipeError:  # as after `tilth verify | head`
            return EXIT_ANALYSIS_FAILED
        except Exception as error:
            if stop.requested:
                _say_interrupted()
                return EXIT_INTERRUPTED
            return _unforeseen(error, arguments)
        return code if isinstance(code, int) else EXIT_DONE


def _unforeseen(error: Exception, arguments: Sequence[str]) -> int:
    """Reports an exception that is no `TilthError`: a bug, if disk and memory suffice."""
    from tilth.output.disk import is_of_the_disk, reason_of

    if isinstance(error, OSError) and is_of_the_disk(error):
        file = f"{error.filename}" if error.filename else "a file"
        _say_error(f"{file} cannot be written: {reason_of(error)}")
        return EXIT_ANALYSIS_FAILED
    if is_memory_error(error):
        _say_error(f"{memory_sentence(error)}\n  {REMEDY}")
        return EXIT_ANALYSIS_FAILED
    _say_error(_bug_report(error, arguments))
    return EXIT_BUG


def _say_error(text: str, colour: str | None = "red") -> None:
    """Prints an error, if there still is a screen."""
    with suppress(OSError):
        click.secho(text, err=True, fg=colour)


def _say_interrupted() -> None:
    """Says so on a line of its own: the stop may come in the middle of a printed table."""
    _say_error("\ninterrupted", None)


def _bug_report(error: Exception, arguments: Sequence[str]) -> str:
    """Writes the traceback to a file; returns the message to the user.

    The traceback is in the message where no file can be written.
    """
    details = (
        f"tilth {__version__}, Python {platform.python_version()}, {platform.platform()}\n"
        f"tilth {' '.join(arguments)}\n\n{''.join(traceback.format_exception(error))}"
    )
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="tilth-bug-", suffix=".txt", encoding="utf-8", delete=False
        ) as file:
            file.write(details)
        where = file.name
    except OSError:
        where = f"this text:\n\n{details}"
    return (
        f"a bug in tilth: {type(error).__name__}: {error}\n"
        f"  please report it at {ISSUE_TRACKER}, with the case file and {where}"
    )


def main() -> None:
    """Entry point of the `tilth` command."""
    set_environment(os.environ)
    with StopSignals():
        try:
            code = run_command(sys.argv[1:])
        except KeyboardInterrupt:  # while the end was reported
            code = EXIT_INTERRUPTED
        ignore_stop_signals()
    if several_processes():
        from tilth.mpi import leave_together

        leave_together(code)
    _flush_or_forget(sys.stdout, sys.stderr)
    sys.exit(code)


def _flush_or_forget(*streams: TextIO) -> None:
    """Drops text that nobody can read any more, at which Python would fail when it ends."""
    for stream in streams:
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
