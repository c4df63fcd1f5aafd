# SPDX-License-Identifier: BSD-3-Clause
"""The folder of a study: what was asked for, a folder for each sample, and the table."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import math
import os
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomli_w

from tilth.case import named_files
from tilth.errors import BadInput, shown
from tilth.input_files import require_file, require_plain_files
from tilth.model import FunctionOutcome, Study
from tilth.output.disk import writing
from tilth.output.files import RESTORE, write_durably
from tilth.output.folder import remove_run
from tilth.output.lock import LOCK
from tilth.studies.samples import Sample, described

RECORD = "study.json"
TABLE = "study.csv"
STATISTICS = "statistics.csv"
PAGE = "study.html"
PICTURE = "study.png"
SAMPLES = "samples"
CASE = "case.toml"
RUN = "case"
OUTCOME = "outcome.json"
OUTPUT = "output.txt"
"""Of a sample: case, folder of the run, what came out of it, and what was printed, if anything."""

_TABLES = (TABLE, STATISTICS, PAGE, PICTURE)
_FORMULA = re.compile("(^|;)([\\s\"']*[=+\\-@\uff1d\uff0b\uff0d\uff20])")
"""The last four are the wide forms of the same signs."""
_SAMPLE = re.compile(r"[0-9]{4,}")


@dataclass(frozen=True)
class Taken:
    """What came out of a sample.

    Attributes:
        outcomes: one per outcome of the study; None where there is none.
        reason: why the sample failed; "" if it is done.
        ended: whether its process was ended from outside, so that it is worth another attempt.
    """

    outcomes: tuple[float | None, ...]
    reason: str
    ended: bool = False

    @property
    def status(self) -> str:
        """What the table says of it."""
        return "failed" if self.reason else "done"


def prepare(
    folder: Path, study: Study, entries: dict[str, Any], samples: Sequence[Sample], overwrite: bool
) -> None:
    """Records the study in its folder, or checks that the folder is that of the same study.

    Args:
        entries: of the case.
        overwrite: whether the folder of another study is emptied first: of tilth's files only.

    Raises:
        BadInput: it is not empty and has something else, or a study that differs in more than
            further samples. Nothing is changed then.
    """
    record = folder / RECORD
    asked = _record(study, entries, samples)
    if os.path.lexists(record):
        before = _read(record)
        if not overwrite:
            _require_same(folder, before, asked)
        else:
            _empty(folder)
    elif any(file.name != LOCK for file in folder.iterdir()):
        raise BadInput(
            f"the folder {folder} is not empty, and not that of a study",
            "choose another folder with --out (in Python out)",
        )
    with writing(record, AGAIN):
        write_durably(record, json.dumps(asked, indent=1).encode())
    with writing(folder / SAMPLES, AGAIN):
        (folder / SAMPLES).mkdir(exist_ok=True)


AGAIN = "put this right, then start the study again: it goes on where it stopped"


def read_record(folder: Path) -> tuple[Study, dict[str, Any]]:
    """Returns the study and the entries of its case; raises `BadInput` if that is impossible."""
    stored = _read(folder / RECORD)
    return Study.from_dict(stored["study"]), stored["case"]


def write_case(folder: Path, study: Study, sample: Sample) -> Path:
    """Writes the case of a sample into a folder of its own, which is returned.

    Raises:
        AnalysisFailed: it cannot be written.
        BadInput: something else than a file has the name of one of the sample's.
    """
    own = folder / SAMPLES / sample.folder
    require_plain_files(own / name for name in (CASE, OUTCOME, OUTPUT))
    values = described(study.vary, sample.values).replace("\n", " ")
    text = f"# Sample {sample.number}: {values}\n{tomli_w.dumps(sample.entries)}".encode()
    with writing(own / CASE, AGAIN):
        own.mkdir(exist_ok=True)
        if not (own / CASE).exists() or (own / CASE).read_bytes() != text:
            write_durably(own / CASE, text)
    return own


def write_outcome(
    own: Path, outcomes: Sequence[float | None], reason: str, *, ended: bool = False
) -> None:
    """Writes what came out of a sample into its folder."""
    content = {"outcomes": list(outcomes), "reason": reason, "ended": ended}
    write_durably(own / OUTCOME, json.dumps(content, indent=1).encode())


def read_outcome(folder: Path, sample: Sample, study: Study) -> Taken | None:
    """Returns what came out of a sample; None if it has not been run to its end."""
    file = folder / SAMPLES / sample.folder / OUTCOME
    try:
        require_file(file)
        content = json.loads(file.read_text(encoding="utf-8"))
        outcomes = tuple(None if o is None else float(o) for o in content["outcomes"])
        taken = Taken(outcomes, str(content["reason"]), bool(content["ended"]))
    except FileNotFoundError:
        return None
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        what = f"{file} cannot be read: {error}"
        raise BadInput(what, "delete it: the sample is run again then") from error
    if len(outcomes) != len(study.outcomes) or not all(
        o is None or math.isfinite(o) for o in outcomes
    ):
        raise BadInput(f"{file} is damaged", "delete it: the sample is run again then")
    return taken


def write_table(
    path: Path, headings: Sequence[str], samples: Sequence[Sample], taken: Mapping[int, Taken]
) -> None:
    """Writes a row for each sample: values, outcomes, status and reason.

    Args:
        headings: of values and outcomes.
        taken: by the number of the sample; those that are not there are "waiting".
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["sample", *headings, "status", "reason"])
    for sample in samples:
        values = [_cell(value) for value in sample.values]
        found = taken.get(sample.number)
        none = [""] * (len(headings) - len(values))
        outcomes = none if found is None else [_cell(o) for o in found.outcomes]
        reason = "" if found is None else _never_a_formula(found.reason)
        state = ["waiting", ""] if found is None else [found.status, reason]
        table.writerow([sample.number, *values, *outcomes, *state])
    with writing(path, AGAIN):
        write_durably(path, text.getvalue().encode())


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return repr(value)
    return _never_a_formula(value) if isinstance(value, str) else json.dumps(value)


def _never_a_formula(text: str) -> str:
    """Returns a text that no spreadsheet computes: an apostrophe before = + - @ at its start.

    Also after a semicolon, at which spreadsheets of some languages divide a line.
    """
    return _FORMULA.sub(r"\1'\2", text)


def _record(study: Study, entries: dict[str, Any], samples: Sequence[Sample]) -> dict[str, Any]:
    """Returns all on which the outcomes depend, as JSON stores it."""
    files = named_files(entries)
    files |= {
        o.function.rpartition(":")[0] for o in study.outcomes if isinstance(o, FunctionOutcome)
    }
    record = {
        "study": study.to_dict(),
        "case": entries,
        "files": {
            file: hashlib.sha256(Path(file).read_bytes()).hexdigest() for file in sorted(files)
        },
        "samples": [list(sample.values) for sample in samples],
    }
    stored: dict[str, Any] = json.loads(json.dumps(record))
    return stored


def _read(record: Path) -> dict[str, Any]:
    try:
        require_file(record)
        stored = json.loads(record.read_text(encoding="utf-8"))
        parts = {"study": dict, "case": dict, "files": dict, "samples": list}
        if not all(isinstance(stored[name], kind) for name, kind in parts.items()):
            raise ValueError("it is not the record of a study")
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        raise BadInput(f"{record} cannot be read: {error}", RESTORE) from error
    result: dict[str, Any] = stored
    return result


def _require_same(folder: Path, before: Mapping[str, Any], asked: Mapping[str, Any]) -> None:
    """Checks that a study is that of the folder, or has further samples."""
    changes = []
    if before["case"] != asked["case"]:
        changes.append("the case file has changed")
    for file in sorted({*before["files"], *asked["files"]}):
        if before["files"].get(file) != asked["files"].get(file):
            changes.append(f"{file} has changed")
    for key, what in (("outcomes", "the outcomes have"), ("keep", "`keep` has")):
        if before["study"].get(key) != asked["study"].get(key):
            changes.append(f"{what} changed")
    count = len(before["samples"])
    of = [[entry.get("key") for entry in each["study"]["vary"]] for each in (before, asked)]
    if of[0] != of[1] or asked["samples"][:count] != before["samples"]:
        changes.append(f"its {count} samples are not the first ones of this study")
    if changes:
        raise BadInput(
            f"{folder} has the results of another study: {'; '.join(changes)}",
            "choose another folder with --out (in Python out), or replace that study with "
            "--overwrite (in Python overwrite=True)",
        )


def _empty(folder: Path) -> None:
    """Removes the files of a study, of each sample first its outcome, and what is empty then."""
    require_plain_files(folder / name for name in _TABLES)
    for name in _TABLES:
        (folder / name).unlink(missing_ok=True)
    if (folder / SAMPLES).is_dir():
        for own in (folder / SAMPLES).iterdir():
            if _SAMPLE.fullmatch(own.name) and own.is_dir() and not own.is_symlink():
                _remove_sample(own)


def _remove_sample(own: Path) -> None:
    for name in (OUTCOME, CASE, OUTPUT, LOCK):
        (own / name).unlink(missing_ok=True)
    if (own / RUN).is_dir() and not (own / RUN).is_symlink():
        remove_run(own / RUN)
    with suppress(OSError):  # it has other files, of a user's function
        own.rmdir()


def text_of(value: Any) -> str:
    """Returns a value of the table in words."""
    return f"{value:.6g}" if isinstance(value, float) else shown(value).strip('"')
