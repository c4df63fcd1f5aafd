# SPDX-License-Identifier: BSD-3-Clause
"""Command line: reads the arguments, calls the library, converts errors to exit codes."""

from __future__ import annotations

import importlib
import logging
import os
import platform
import sys
import tempfile
import traceback
import warnings
from collections.abc import Sequence
from contextlib import suppress
from typing import TextIO

import click

from tilth import __version__
from tilth.environment import USER_MODULE, set_environment, several_processes
from tilth.errors import (
    EXIT_ANALYSIS_FAILED,
    EXIT_BAD_INPUT,
    EXIT_BUG,
    EXIT_DONE,
    EXIT_INTERRUPTED,
    ISSUE_TRACKER,
    TilthError,
)
from tilth.interrupt import StopSignals, ignore_stop_signals
from tilth.memory_errors import REMEDY, is_memory_error, memory_sentence

COMMANDS = (
    "run",
    "check",
    "resume",
    "report",
    "plot",
    "movie",
    "export",
    "safety",
    "study",
    "element",
    "verify",
    "new",
    "schema",
    "completion",
)
"""Each is the function of its name in the module of its name in `tilth.commands`."""

SHARED = ("run", "resume", "verify", "safety")
"""Commands that several processes carry out together; of others it is the first one alone."""


class _Commands(click.Group):
    """Loads the module of a command when it is called: `tilth --version` is instant."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Returns the names of the commands, in the order of the help."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Returns the command of this name; None where there is none."""
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f"tilth.commands.{cmd_name}")
        command: click.Command = getattr(module, cmd_name)
        return command


@click.group(
    cls=_Commands,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, prog_name="tilth", message="%(prog)s %(version)s")
@click.pass_context
def cli(context: click.Context) -> None:
    """Implicit material point method for large deformations of soil.

    Exit codes: 0 done; 1 the analysis could not be finished, results so far are on disk, or a
    factor of safety is undecided; 2 the input is wrong; 3 interrupted; 4 a bug in tilth.
    """
    from tilth.available_memory import require_memory_of_program

    if several_processes():
        from tilth.mpi import begin_together

        if not begin_together() and context.invoked_subcommand not in SHARED:
            context.exit()
    require_memory_of_program()


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
        what = f"{file} cannot be written: {reason_of(error)}"
        _say_error(f"{what}\n  put this right, then start the command again")
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
    open_closed_streams()
    silence_libraries()
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


def open_closed_streams() -> None:
    """Opens the null device in place of standard streams that are closed, as by `>&-`.

    Else the first file that is opened gets the number of the stream, and what is printed there.
    """
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            null = os.open(os.devnull, os.O_RDWR)
            if null != number:
                os.dup2(null, number)
                os.close(null)
            os.set_inheritable(number, True)
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115


def silence_libraries() -> None:
    """Keeps warnings that libraries mean for programmers from the terminal of a user.

    Those of the user's own functions are shown. `python -W` and PYTHONWARNINGS decide otherwise.
    """
    if not sys.warnoptions:
        warnings.simplefilter("ignore")
        warnings.filterwarnings("default", module=USER_MODULE)
    logging.getLogger().addHandler(logging.NullHandler())


def _flush_or_forget(*streams: TextIO) -> None:
    """Drops text that nobody can read any more, at which Python would fail when it ends."""
    for stream in streams:
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
