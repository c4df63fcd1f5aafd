# SPDX-License-Identifier: BSD-3-Clause
"""Which step of a run is to be explained, as the user names it."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass

from tilth.analysis.stored_run import StoredRun
from tilth.comm import Communicator
from tilth.errors import BadInput
from tilth.model import Model
from tilth.model.problems import unknown_name

FORM = "give the number of a load step from 1 on, as in history.csv and in messages"
OR_OF_STAGE = ", or STAGE:STEP, counted from the start of a stage"


@dataclass(frozen=True)
class AskedStep:
    """The step that is to be explained.

    Attributes:
        number: of the step, from 1.
        stage: name of the stage from whose start it is counted; empty if from that of the run.
    """

    number: int
    stage: str = ""

    def __str__(self) -> str:
        return f"{self.stage}:{self.number}" if self.stage else f"{self.number}"

    @classmethod
    def of(cls, given: int | str, model: Model, comm: Communicator) -> AskedStep:
        """Returns the step that a user asks for: its number, or "STAGE:STEP".

        Raises:
            BadInput: it is no step of the model, or there are several processes.
        """
        stage, colon, last = str(given).rpartition(":")
        whole = last.strip()
        is_number = whole.isascii() and whole.isdigit() and len(whole) <= 9 and int(whole) > 0
        if isinstance(given, bool) or not is_number or (colon and not stage):
            remedy = FORM + (OR_OF_STAGE if model.stages else "")
            raise BadInput("is not the number of a step", remedy, key="explain", value=given)
        if comm.size > 1:
            raise BadInput(
                "a step is explained by one process only, and this run has several",
                f"stop a run before the step with --until, then: tilth resume DIR --explain {given}"
                " without mpiexec; a checkpoint goes on with any number of processes",
                key="explain",
                value=given,
            )
        if not stage:
            return cls(int(whole))
        if not model.stages:
            what = "names a stage, but the model has no stages"
            raise BadInput(what, f"give the number alone: {whole}", key="explain", value=given)
        loading = [each.stage.name for each in model.of_stages]
        if stage not in loading:
            if any(each.name == stage for each in model.stages):
                what = f"the stage {stage!r} is a strength reduction, which has no load steps"
                remedy = f"stages with load steps: {', '.join(loading)}"
            else:
                what, remedy = unknown_name("stage", stage, loading)
            raise BadInput(what, remedy, key="explain", value=given)
        return cls(int(whole), stage)

    def require_after(self, stored: StoredRun, model: Model) -> None:
        """Checks that the step comes after the point from which a run goes on.

        model: with which it goes on; its present stage may end later than that of the stored run.

        Raises:
            BadInput: it does not.
        """
        clock, before = stored.progress.clock, steps_before(stored)
        present, reached = model.of_stages[stored.progress.stage], clock.step
        ends = not clock.relaxing and present.schedule.snapped(clock.time) >= present.schedule.end
        is_over = self.stage in before and (ends or self.stage != present.stage.name)
        number = before.get(self.stage, reached) + self.number if self.stage else self.number
        if number <= reached or is_over:
            where = f"the state from which the run goes on, that after step {reached}"
            is_early = number <= reached
            raise BadInput(
                f"comes before {where}" if is_early else f"is of a stage that is over in {where}",
                f"name a later step, or begin a new run: tilth run CASE.toml --explain {self} "
                "--out ANOTHER_DIR",
                key="explain",
                value=f"{self}",
            )


def steps_before(stored: StoredRun) -> dict[str, int]:
    """Returns the numbers of steps before the stages that a run has begun, by their names."""
    if not stored.model.stages:
        return {}
    before: dict[str, int] = {}
    for row in csv.DictReader(io.StringIO(stored.rows.history.decode())):
        if int(row["step"]) > 0:
            before.setdefault(row["stage"], int(row["step"]) - 1)
    return before
