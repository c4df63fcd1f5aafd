# SPDX-License-Identifier: BSD-3-Clause
"""Runs the Kratos MPM input in the current folder; runs in the environment of Kratos.

Prints one line of JSON: points, steps, Newton iterations, user time of the load steps alone,
the quantity to compare, and the version of Kratos.
"""

import json
import sys
from pathlib import Path

import KratosMultiphysics as Kratos
import KratosMultiphysics.MPMApplication as Mpm
from KratosMultiphysics.MPMApplication.mpm_analysis import MpmAnalysis

sys.path.insert(0, str(Path(__file__).parents[1]))

from own_process import peak_memory, user_seconds


class Run(MpmAnalysis):
    """The analysis with forces on points, which counts iterations and time."""

    def __init__(self, model, parameters, task):
        super().__init__(model, parameters)
        self.task = task
        self.steps = self.iterations = 0
        self.seconds = 0.0
        self.failed = False
        self._end_time = parameters["problem_data"]["end_time"].GetDouble()

    def Initialize(self):  # noqa: N802
        super().Initialize()
        self.info = self._GetSolver().GetComputingModelPart().ProcessInfo
        self.points = list(self._GetSolver().GetComputingModelPart().Elements)
        self.loaded = [
            (self.at(place), [component / len(load["places"]) for component in load["force"]])
            for load in self.task["forces"]
            for place in load["places"]
        ]
        answer = self.task["answer"]
        self.watched = [self.at(place) for place in answer.get("places", [])]

    def value(self, point, variable):
        return point.CalculateOnIntegrationPoints(variable, self.info)[0]

    def at(self, place):
        """The material point nearest to a place at the start."""

        def distance(point):
            found = self.value(point, Mpm.MP_COORD)
            return sum((a - b) ** 2 for a, b in zip(found, place))  # noqa: B905

        return min(self.points, key=distance)

    def ApplyBoundaryConditions(self):  # noqa: N802
        super().ApplyBoundaryConditions()
        share = self.time / self.task["end"]
        for point, force in self.loaded:
            mass = self.value(point, Mpm.MP_MASS)
            acceleration = [share * component / mass for component in [*force, 0.0][:3]]
            point.SetValuesOnIntegrationPoints(
                Mpm.MP_VOLUME_ACCELERATION, [Kratos.Array3(acceleration)], self.info
            )

    def RunSolutionLoop(self):  # noqa: N802
        while self.KeepAdvancingSolutionLoop():
            before = user_seconds()
            self.time = self._AdvanceTime()
            self.InitializeSolutionStep()
            converged = self.SolveSolutionStep()
            self.steps += 1
            self.iterations += self.info[Kratos.NL_ITERATION_NUMBER]
            self.reaction = self.reactions()
            self.FinalizeSolutionStep()
            self.seconds += user_seconds() - before
            if not converged:
                self.failed = True
                break

    def reactions(self):
        answer = self.task["answer"]
        if answer["quantity"] != "reaction":
            return None
        part = self.model[f"Background_Grid.{answer['part']}"]
        variable = Kratos.KratosGlobals.GetVariable(f"REACTION_{answer['component'].upper()}")
        return sum(node.GetSolutionStepValue(variable) for node in part.Nodes)

    def answer(self):
        answer = self.task["answer"]
        if answer["quantity"] == "reaction":
            return answer["scale"] * self.reaction
        axis = "xyz".index(answer["component"])
        moves = [self.value(point, Mpm.MP_DISPLACEMENT)[axis] for point in self.watched]
        return answer["scale"] * sum(moves) / len(moves)


def main():
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    parameters = Kratos.Parameters(Path("parameters.json").read_text())
    run = Run(Kratos.Model(), parameters, json.loads(Path("task.json").read_text()))
    run.Run()
    done = {
        "points": len(run.points),
        "steps": run.steps,
        "iterations": run.iterations,
        "user_in_steps": run.seconds,
        "peak": peak_memory(),
        "answer": run.answer(),
        "converged": not run.failed,
        "version": Kratos.KratosGlobals.Kernel.Version(),
    }
    print(json.dumps(done))


if __name__ == "__main__":
    main()
