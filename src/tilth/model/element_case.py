# SPDX-License-Identifier: BSD-3-Clause
"""The complete declaration of element tests, from a case file or from Python."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, PlainValidator, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared, DeclaredFile
from tilth.model.cam_clay import ModifiedCamClay
from tilth.model.declaration import FORMAT, format_of, one
from tilth.model.element_tests import AnyElementTest, Names
from tilth.model.fields import AsTuple, CellName, Entries, Name, Text
from tilth.model.laws import Law
from tilth.model.materials import Material, codes_of, laws_of
from tilth.model.problems import dotted, rejection, unknown_name
from tilth.model.settings import Units

Panel = Literal["p-q", "q-strain", "volume-strain", "pressure-strain", "compression"]
PANELS: tuple[Panel, ...] = ("p-q", "q-strain", "volume-strain", "compression")
"""The panels of a picture whose panels are not given."""


class ElementPlot(Declared):
    """A picture of one or more tests, each with all its materials."""

    name: CellName
    """Name of the picture, unique; the file has this name."""
    panels: Annotated[Sequence[Panel], AsTuple, AfterValidator(one)] = PANELS
    """Its diagrams: "p-q", "q-strain", "volume-strain", "pressure-strain" (excess pore pressure),
    and "compression" (void ratio, or volumetric strain, over the logarithm of p); all but
    "pressure-strain" if not given.
    """
    tests: Names | None = None
    """Names of its tests; all if not given."""
    format: Literal["png", "svg", "pdf"] = "png"
    """Format of the file."""


class ElementCase(DeclaredFile):
    """Element tests with their materials and pictures; the names are those of the case file.

    Units are the user's and must be consistent. Compression is positive, for normal stresses and
    normal strains. Raises `BadInput` with every wrong entry.
    """

    format: Annotated[int, PlainValidator(format_of)] = FORMAT
    """Version of the case file's schema."""
    title: Text = ""
    """Title, shown above the pictures."""
    units: Units = Units()
    """Labels of the units."""
    materials: Annotated[Mapping[Name, Material], AfterValidator(one)]
    """a section [materials.NAME] for each material, as in an analysis."""
    tests: Annotated[Sequence[AnyElementTest], Entries, AsTuple, AfterValidator(one)]
    """a section [[tests]] for each test."""
    plots: Annotated[Sequence[ElementPlot], Entries, AsTuple] = (ElementPlot(name="plots"),)
    """Pictures; one of all tests if not given."""

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Any:
        if problems := [*self._references(), *self._varying(), *self._repeated_files()]:
            raise rejection(problems)
        return self

    def _references(self) -> Iterator[Problem]:
        """Yields names of materials and tests that are not declared."""
        for i, test in enumerate(self.tests):
            for name in test.material:
                material = self.materials.get(name)
                if material is None:
                    words = unknown_name("material", name, self.materials)
                    yield Problem(f"tests[{i}].material", *words, name)
                elif isinstance(material, ModifiedCamClay) and not material.has_preconsolidation:
                    key = dotted(("materials", name, "overconsolidation_ratio"))
                    remedy = "give exactly one of it and `preconsolidation_pressure`"
                    yield Problem(key, "missing", remedy)
        known = [test.name for test in self.tests]
        for i, plot in enumerate(self.plots):
            for name in plot.tests or ():
                if name not in known:
                    yield Problem(f"plots[{i}].tests", *unknown_name("test", name, known), name)

    def _varying(self) -> Iterator[Problem]:
        """Yields parameters that are not the same everywhere: a test has one point."""
        for name, material in self.materials.items():
            for key in type(material).model_fields:
                if isinstance(getattr(material, key), Declared):
                    what = "varies from place to place, but a specimen is one material point"
                    yield Problem(dotted(("materials", name, key)), what, "give a number")

    def _repeated_files(self) -> Iterator[Problem]:
        """Yields names that give the same file, also where capitals do not count."""
        files: dict[str, str] = {}
        for i, test in enumerate(self.tests):
            for material in test.material:
                yield from _repeated(files, table_of(test.name, material), f"tests[{i}].name")
        for i, plot in enumerate(self.plots):
            yield from _repeated(files, picture_of(plot), f"plots[{i}].name")

    @property
    def user_laws(self) -> tuple[str, ...]:
        """Laws of the user that the case names, as "file:name", each once: the tests run them."""
        return codes_of(self.materials)

    @cached_property
    def laws(self) -> dict[str, Law]:
        """The laws of the materials by their names; runs the code of the user.

        Raises:
            BadInput: a law of the user cannot be loaded.
        """
        return laws_of(self.materials)


def table_of(test: str, material: str) -> str:
    """Returns the name of the table of a test with one material, such as `drained.clay.csv`."""
    return f"{_file_name(test)}.{_file_name(material)}.csv"


def picture_of(plot: ElementPlot) -> str:
    """Returns the name of a picture's file."""
    return f"{_file_name(plot.name)}.{plot.format}"


def _file_name(name: str) -> str:
    """Returns a name without characters that file systems refuse, and not hidden."""
    return re.sub(r'[\\/:*?"<>|]', "_", name).strip(". ") or "_"


def _repeated(files: dict[str, str], file: str, key: str) -> Iterator[Problem]:
    first = files.setdefault(file.casefold(), key)
    if first != key:
        remedy = "give each entry a different name"
        yield Problem(key, f"gives the same file as {first}, {file}", remedy)
