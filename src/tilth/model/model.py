# SPDX-License-Identifier: BSD-3-Clause
"""The complete declaration of a problem, from a case file or from Python."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from pydantic import model_validator

from tilth.errors import BadInput
from tilth.model.checks import problems_between_entries, state_variable_problems
from tilth.model.declaration import Declaration
from tilth.model.overview import html_table, overview
from tilth.model.problems import rejection, unknown_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Model(Declaration):
    """A declared, validated and immutable problem; the names are those of the case file.

    Units are the user's and must be consistent. Tension is positive; y is up in 2D, z is up in 3D;
    in axisymmetry x is the radius and y the axis. Raises `BadInput` with every wrong entry.
    """

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Any:
        if problems := problems_between_entries(self):
            raise rejection(problems)
        return self

    def __repr__(self) -> str:
        lists = ("bodies", "boundaries", "rigid_bodies", "loads", "stages", "track")
        counts = ((key, len(getattr(self, key))) for key in lists)
        said = "".join(f", {key}: {count}" for key, count in counts if count)
        return f"<Model {self.title!r}: {self.analysis.kind}{said}>"

    def __str__(self) -> str:
        return repr(self)

    def _repr_html_(self) -> str:
        return html_table(overview(self))

    def plot(self, parameter: str = "") -> Figure:
        """Returns the figure of the set-up, as `tilth check` draws it; runs functions of the model.

        Args:
            parameter: name of one that varies from place to place, or "layer": its field is drawn
                instead. A set-up with many stages has further figures "page_2" and so on.

        Raises:
            BadInput: the model cannot be computed, or has no such figure.
        """
        # the analysis imports the model, so the model imports its pictures only here, by their name
        figures = import_module("tilth.analysis.setup_picture").setup_figures(self)[1]
        if parameter not in figures:
            known = [name for name in figures if name]
            what = "figure or parameter that varies from place to place"
            raise BadInput(*unknown_name(what, parameter, known), key="parameter", value=parameter)
        figure: Figure = figures[parameter]
        return figure

    @property
    def initial_model(self) -> Model | None:
        """The model of the initial state, see `StageOfModel`; None in itself, without stages."""
        found = self.stage.initial
        assert found is None or isinstance(found, Model)
        return found

    def require_state_variables(self) -> None:
        """Checks names of state variables that only the user's code knows; runs this code.

        Raises:
            BadInput: `[[track]]` or `colour_by` names one that no law has.
        """
        known = {name: law.state_variables for name, law in self.laws.items()}
        if problems := [*state_variable_problems(self, known)]:
            raise BadInput.of(problems)
