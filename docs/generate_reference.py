# SPDX-License-Identifier: BSD-3-Clause
"""Writes case_file.md and element_tests.md of docs/reference: `python docs/generate_reference.py`.

The meaning of a key is the text below its field in src/tilth/model, its type the name of its
field type, so the page states only what the program checks.
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any

from pydantic.fields import FieldInfo

from tilth import model
from tilth.model.base import Declared, meaning_of
from tilth.model.isotropic import AnyMaterial
from tilth.model.parameter_kinds import KINDS
from tilth.model.settings import COLOURS, COLOURS_OF_FLOW, COLOURS_OF_WATER

PAGE = Path(__file__).parent / "reference" / "case_file.md"
ELEMENT_PAGE = Path(__file__).parent / "reference" / "element_tests.md"

TYPE_DESCRIPTIONS = {
    "Text": "text",
    "Name": "text",
    "CellName": "text",
    "Label": "text",
    "FileName": "text",
    "bool": "true or false",
    "Real": "number",
    "Positive": "number > 0",
    "NotNegative": "number >= 0",
    "Fraction": "number in (0, 1]",
    "Share": "number in (0, 1)",
    "Angle": "number",
    "Tolerance": "number in [1e-15, 0.01]",
    "PoissonRatio": "number in (-1, 0.5), or [varying](#parameters-that-vary)",
    "SoilAngle": "number, 0 or in [0.001, 60], or [varying](#parameters-that-vary)",
    "Index": "number in (0, 0.9], or [varying](#parameters-that-vary)",
    "OverconsolidationRatio": "number >= 1, or [varying](#parameters-that-vary)",
    "CoefficientAtRest": 'number > 0, or `"1-sin_phi"`',
    "Overconsolidation": "number >= 1",
    "MaterialsAtRest": "table material = table, see below",
    "InitialStresses": "list of tables, see below",
    "InitialVelocities": "list of tables, see below",
    "InitialPorePressures": "list of tables, see below",
    "AngularVelocity": "number; in 3D a list of three",
    "Inertia": "table, see below",
    "RayleighDamping": "table, see below",
    "SpectralRadius": "number in [0, 1]",
    "Ground": "table, see [ground](#ground)",
    "GroundAcceleration": "table, see [acceleration](#acceleration)",
    "Count": "whole number >= 1",
    "CountOrZero": "whole number >= 0",
    "Flag": "true or false",
    "Vector": "list of numbers",
    "CountVector": "list of whole numbers >= 1",
    "Tensor": "list of numbers > 0, or a symmetric matrix",
    "PositivePerDirection": "number > 0, or a list of them",
    "CellSize": "number > 0, a list of them, or table axis = number or rows (place, size)",
    "CountPerDirection": "whole number >= 1, or a list of them",
    "Matrix": "list of rows",
    "WholeNumbers": "list of whole numbers >= 0",
    "Profile": "rows (arc length, value)",
    "Real | Table": "number, or rows (time, value)",
    "Table": "rows (time, factor)",
    "Times": "list of increasing numbers > 0",
    "VaryingShare": "number in (0, 1), or [varying](#parameters-that-vary)",
    "VaryingReal": "number, or [varying](#parameters-that-vary)",
    "VaryingModulus": "number > 0, or [varying](#parameters-that-vary)",
    "VaryingPositive": "number > 0, or [varying](#parameters-that-vary)",
    "VaryingNotNegative": "number >= 0, or [varying](#parameters-that-vary)",
    "DepthRows": "rows (depth, value)",
    "AxisRows": "rows (coordinate, value)",
    "Level": "number, rows (x, elevation), or table [`{ file = ... }`](#heights-in-a-file)",
    "Exponent": "number in [0, 1]",
    "RandomField": "table, see below",
    "Layers": "list of tables, see below",
    "Holes": "list of tables as [shapes](#shapes)",
    "Axis": '`"x"`, `"y"`, `"z"`',
    "Components": "list of axes",
    "Displacement": "table axis = number",
    "Ranges": "table axis = [least, greatest]",
    "Direction": "list of numbers, not all 0",
    "AxisOrDirection": '`"x"`, `"y"`, `"z"`, or a list of numbers',
    "Faces": 'list of `"x-"`, `"x+"`, `"y-"`, `"y+"`, `"z-"`, `"z+"`',
    "Numbers": "list of numbers",
    "KindsInOrder": "list of [kinds](#kinds-of-parameters)",
    "Kind": "one of the [kinds](#kinds-of-parameters)",
    "NumbersByName": "table name = number",
    "StateVariables": "list of tables, or a whole number",
    "PythonFunction": 'text `"file.py:name"`',
    "Limits": "table, see below",
    "Follow": "table, see below",
    "Surface": "table, see below",
    "Region": "table, see below",
    "Hydrostatic": "table, see below",
    "Rotation": "table, see [rotation](#rotation)",
    "Names": "text, or a list of texts",
    "Steps": "whole number, 1 to 100,000",
    "Strains": "number, or a list of numbers",
    "Pressures": "number > 0, or a list of them",
    "AxialStrain": "number > 0",
    "StressState": "table, see [stress states](#stress-states)",
    "Tables": "table component = rows (time, value)",
    "Geometry": "table, see [geometries](#geometries)",
    "Shape": "table, see [shapes](#shapes)",
    "StageName": "text",
    "FactorTolerance": "number >= 1e-4",
    "Schedule": "table, see [schedule](#schedule)",
    "EntryNames": "list of names",
    "TwoBodies": "list of two names",
    "Regions": "list of tables, see below",
    "ApexAngle": "number in [1, 180]",
    "NumberOrTable": "number, or rows (time, value)",
    "NumberOrTablePerAxis": "number, or rows (time, value); in 3D table axis = one of these",
    "TablesByAxis": "table axis = number, or rows (time, value)",
    "Springs": "table component = number > 0",
    "FrictionCoefficient": "number >= 0",
    "AdhesionFactor": "number in [0, 1]",
    "Contact": "table, see [contact](#contact)",
    "Contacts": "table body = [contact](#contact)",
    "GeometryList": "list of tables, see [geometries](#geometries)",
    "Factors": "table name = rows (time, factor)",
    "ExchangedMaterials": "table old = new",
    "Water": "table, see [water](#water)",
    "FlowBoundaryList": "list of tables, see below",
    "StageGrid": "table, see below",
    "Resets": 'list of `"displacement"`, `"plastic_strain"`',
}
"""Field type of the model -> its description on the page; a type without an entry is an error."""

HEADER = """<!-- Made by docs/generate_reference.py from src/tilth/model. Do not edit. -->
# The case file

A case file is [TOML](https://toml.io) text. The same names build the same model from Python:
`[analysis]` is `tilth.Analysis`, an entry of `[[bodies]]` is a `tilth.Body`, and so on. What is
declared is frozen; `model.model_copy(update={"schedule": schedule})` returns a changed copy,
validated like a new one.
`tilth check CASE.toml` validates a file, warns of probable mistakes, and draws its set-up
without running it.

* Units are the user's and must be consistent; `[units]` only labels them. Tension is positive. y is
  up in 2D, z is up in 3D; in axisymmetry x is the radius and y the axis.
* A key that is not listed here is refused, and so is a number in quotes. No material parameter,
  load or boundary condition has a default; numerical settings have.
* A number is at most 1e30 in magnitude, and one that must be greater than 0 is at least 1e-30, so
  that products of them (a force is density times acceleration times volume) stay within double
  precision. An angle is at most 1e6 degrees, a whole number at most 1,000,000,000. A direction has
  a component of at least 1e-30; the principal stretches of an affine motion are 1e-6 to 1e6.
* The soil and the grid's nodes with a condition are within 500,000 cells of `grid.origin`.
  Coordinates are at most 1e9 times the cell size, where their round-off is 1e-7 of a cell.
  Bodies, circles, boxes and footings are at least 1e-6 of a cell in size, and an implicit boundary
  passes through at most 1,000,000 cells (a spline through 2,000). There are at most 200 material
  points per cell and direction. A cell's edges differ by at most 10,000 times, and so do those of
  all cells of a graded grid; "a cell" above is then the smallest. Between the first and the last
  place of an axis there are at most 100,000 cells.
* A curve or polygon has at most 10,000 vertices, a table 100,000 rows; there are at most 1,000
  each of bodies, boundaries, rigid bodies, loads and tracked quantities. The file has at most 4 MB.
* A vector has one component per direction: two in plane strain and axisymmetry, three in 3D.
* A *factor* table holds rows (time, factor) with increasing times, the first of them 0; between
  its rows the factor is linear in time, beyond the last row it is constant.
* Paths are relative to the case file.
* A case file that names a Python function (`motion` of an implicit boundary, a geometry of type
  `"function"`, a material parameter, an initial stress) or a law of your own (materials
  `"user_python"`, `"user_compiled"`, `"user_umat"`) is code: `tilth run`, `tilth check`,
  `tilth element` and `tilth resume` say so and run that file with your rights. `tilth report` runs
  no such code.
* A text is one line of printable characters: a title has at most 200, a name 100, a unit 40. Names
  of bodies and of tracked quantities do not begin with `=`, `+`, `-` or `@`: they stand in tables,
  and a spreadsheet would take them for formulas.

A complete case, a block of soil that settles under its own weight and a prescribed plate:

```toml
format = 1
title = "Block under a plate"

[analysis]
kind = "plane_strain"

[grid]
cell_size = 0.5

[materials.clay]
model = "von_mises"
young_modulus = 1e6
poisson_ratio = 0.3
density = 1800.0
yield_stress = 5e4
hardening_modulus = 0.0

[[bodies]]
name = "block"
material = "clay"
shape = { type = "box", lower = [0, 0], upper = [4, 2] }
basis = "gimp"
points_per_cell = 2

[[boundaries]]
name = "base"
type = "plane"
axis = "y"
at = 0.0
condition = "fixed"

[[boundaries]]
name = "plate"
type = "plane"
axis = "y"
at = 2.0
range = { x = [1.0, 3.0] }
condition = "prescribed"
displacement = { x = 0.0, y = -0.05 }
factor = [[0, 0], [0.5, 0], [1, 1]]          # gravity first, then the plate

[[loads]]
type = "body_force"
acceleration = [0.0, -9.81]
factor = [[0, 0], [0.5, 1]]

[schedule]
steps = 20

[[track]]
name = "plate force"
quantity = "reaction"
boundary = "plate"
component = "y"
```
"""

ELEMENT_HEADER = """<!-- Made by docs/generate_reference.py from src/tilth/model. Do not edit. -->
# Case files of element tests

What `tilth element CASE.toml` reads; [test a material](../howto/test_a_material.md) has an example.
The rules of [case files](case_file.md) for numbers, texts and units apply here too. Compression is
positive, for normal stresses and normal strains; y is the vertical (axial) direction. A logarithmic
or shear strain is at most 5 in magnitude.

`[units]` and `[materials.NAME]` are as in an [analysis](case_file.md#materialsname), with numbers
as parameters.
"""

TOP_LEVEL = """## Top level

| key | type | default | meaning |
| --- | --- | --- | --- |
"""


def page() -> str:
    """Returns the text of docs/reference/case_file.md."""
    parts = [
        HEADER,
        TOP_LEVEL + "\n".join(_row(model.Model, key) for key in ("format", "title")),
        _section("`[units]`", model.Units),
        _section("`[analysis]`", model.Analysis),
        _section("`inertia` of `[analysis]`", model.Inertia, 3),
        _section("`damping` of `inertia`", model.RayleighDamping, 4),
        _section("`[grid]`", model.Grid),
        "[How to grade the grid](../howto/grade_the_grid.md) has an example.",
        _section("`[grid.limits]`", model.Limits, 3),
        _section("`[grid.follow]`", model.Follow, 3),
        "## `[materials.NAME]`\n\nBodies refer to a material by its NAME. The equations are in "
        "[mechanics](../theory/mechanics.md).",
        *_variants(
            "model", model.HenckyElastic, model.VonMises, model.Tresca, model.MohrCoulomb,
            model.DruckerPrager, model.ModifiedCamClay, model.UserPython, model.UserCompiled,
            model.UserUmat,
        ),
        "### Kinds of parameters\n\nEvery number of a law is of a kind. Strength reduction divides "
        "it by the factor of safety F or keeps it, as the kind says; a law of your own "
        "[declares the kinds of its numbers](../howto/write_your_own_material.md#factor-of-safety)."
        "\n\n" + _kinds(),
        "### Parameters that vary\n\nInstead of a number, a material parameter other than the "
        "density may be one of these tables. It is evaluated once at the initial position of each "
        "material point and then stays with the point; every value must be one that the parameter "
        "may have as a number. [How to vary a parameter](../howto/vary_a_parameter.md) has "
        "examples. A function may also be given as a text, `\"file.py:name\"`.",
        *(
            _section(f"`{{ {key} = ... }}`", cls, 4)
            for key, cls in (
                ("depth", model.ByDepth), ("axis", model.AlongAxis), ("file", model.GridFile),
                ("function", model.OfPosition), ("reference", model.ByStress),
                ("random", model.RandomField),
            )
        ),
        _section("`[[bodies]]`", model.Body),
        _section("`[[bodies.layers]]`", model.Layer, 3),
        "The rules of `domain_update` are compared in [domains](../theory/domains.md).",
        "### Shapes\n\nThe table `shape` of a body. The volumes of its material points sum to the "
        "volume of the shape to round-off.",
        *_variants("type", *model.shapes.SHAPES, level=4),
        _section("Heights in a file", model.HeightFile, 4),
        _section("`[bodies.surface]`", model.Surface, 3),
        "## `[[boundaries]]`\n\nEssential conditions; at least one. Two conditions on the same "
        "component of a node must prescribe the same value.",
        *_variants(
            "type", model.PlaneBoundary, model.NodeBoundary, model.ImplicitBoundary,
            model.AffineBoundary,
        ),
        "### Geometries\n\nThe table `geometry` of an implicit boundary or a rigid body: its "
        "position at time 0, independent of the grid lines, and the side on which the soil is.",
        *_variants("type", *model.geometry.GEOMETRIES, level=4),
        _section("Rotation", model.Rotation, 3),
        _section("Acceleration", model.GroundAcceleration, 3),
        _section("Ground", model.Ground, 3),
        "[How to shake the soil](../howto/shake_the_soil.md) has examples.",
        _section("Contact", model.Contact, 3),
        _section("`[[rigid_bodies]]`", model.RigidBody),
        "[How to press rigid bodies into soil](../howto/press_rigid_bodies_into_soil.md) has "
        "examples.",
        _section("`[[contact_pairs]]`", model.ContactPair),
        _section("`[water]`", model.Water),
        _section("`[flow]`", model.Flow),
        "### `[[flow.boundaries]]`\n\nWhere the excess pore pressure or the flux is given; nothing "
        "else lets water through.",
        *_variants(
            "type", model.PlaneFlowBoundary, model.ImplicitFlowBoundary, model.SurfaceFlowBoundary,
            level=4,
        ),
        _section("`[initial]`", model.Initial),
        "### `[[initial.stress]]`\n\nThe stress of bodies at time 0, an entry for each; bodies "
        "without an entry start without stress. The stress is the effective one and must not lie "
        "outside the yield surface. [Start with stress](../howto/start_with_stress.md) has an "
        "example, [stress at the start](../theory/initial_stress.md) what is solved.",
        *_variants(
            "type", model.GivenStress, model.AtRest, model.GravityStress, model.TableStress,
            model.StressOfRun, level=4,
        ),
        _section("A material in `materials` of a stress at rest", model.MaterialAtRest, 4),
        _section("`[[initial.velocity]]`", model.InitialVelocity, 3),
        _section("`[[initial.pore_pressure]]`", model.InitialPorePressure, 3),
        "## `[[loads]]`",
        *_variants(
            "type", model.BodyForce, model.SeismicLoad, model.PointForce, model.LineForce,
            model.SurfaceLoad,
        ),
        _section("`within` of a surface load", model.Region, 3),
        _section("`hydrostatic` of a surface load", model.Hydrostatic, 3),
        _section("`[schedule]`", model.Schedule),
        "## `[[stages]]`",
        *_variants("type", model.Stage, model.StrengthReductionStage),
        "[How to go through stages](../howto/stages.md) has examples.",
        _section("`[[stages.excavate]]`", model.ExcavatedRegion, 3),
        _section("`grid` of a stage", model.StageGrid, 3),
        _section("`[[track]]`", model.Track),
        _section("`[output]`", model.Output),
        "Names for `colour_by`: "
        + ", ".join(f"`{name}`" for name in COLOURS)
        + "; with `[water]` or `[flow]` also "
        + ", ".join(f"`{name}`" for name in COLOURS_OF_WATER)
        + "; with `[flow]` "
        + ", ".join(f"`{name}`" for name in COLOURS_OF_FLOW)
        + ".",
    ]  # fmt: skip
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


def element_page() -> str:
    """Returns the text of docs/reference/element_tests.md."""
    parts = [
        ELEMENT_HEADER,
        TOP_LEVEL + "\n".join(_row(model.ElementCase, key) for key in ("format", "title")),
        "## `[[tests]]`\n\nAt least one. Stages follow each other: a consolidation, the shearing, "
        "or one for each stress or strain of a list.",
        *_variants("type", *model.element_tests.TESTS),
        _section("Stress states", model.StressState, 3),
        _section("`[[plots]]`", model.ElementPlot),
    ]
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


def _section(heading: str, cls: type[Declared], level: int = 2) -> str:
    """Returns a heading, the docstring of the class and the table of its keys."""
    keys = sorted(cls.model_fields, key=lambda key: not _selects_kind(cls, key))
    if issubclass(cls, AnyMaterial):
        head = "| key | type | default | kind | meaning |\n| --- | --- | --- | --- | --- |"
    else:
        head = "| key | type | default | meaning |\n| --- | --- | --- | --- |"
    rows = "\n".join(_row(cls, key) for key in keys)
    return (
        f"{'#' * level} {heading}\n\n{inspect.getdoc(cls)} In Python: `tilth.{cls.__name__}`.\n\n"
        f"{head}\n{rows}"
    )


def _kinds() -> str:
    """Returns the table of the kinds of parameters."""
    effects = {
        None: "keeps it", "value": "divides it", "tangent": "divides its tangent",
        "limited": "keeps it, at most the reduced friction", "never": "refuses the law",
    }  # fmt: skip
    rows = "\n".join(
        f'| `"{kind}"` | {rules.unit} | {effects[rules.reduced]} | {_cell(rules.meaning)} |'
        for kind, rules in KINDS.items()
    )
    return f"| kind | unit | strength reduction | meaning |\n| --- | --- | --- | --- |\n{rows}"


def _variants(key: str, *classes: type[Declared], level: int = 3) -> list[str]:
    """Returns one section for each kind of an entry; its key `key` selects the kind."""
    return [_section(f'`{key} = "{cls.model_fields[key].default}"`', cls, level) for cls in classes]


def _row(cls: type[Declared], key: str) -> str:
    field = cls.model_fields[key]
    meaning = meaning_of(cls, key) or "Selects the kind of entry."
    name = field.alias or key
    kind = f" {cls.kinds.get(key, '-')} |" if issubclass(cls, AnyMaterial) else ""
    first = f"| `{name}` | {_type(cls, key)} | {_default(cls, key, field)} |"
    return f"{first}{kind} {_cell(meaning)} |"


def _type(cls: type[Declared], key: str) -> str:
    owner = next(base for base in cls.__mro__ if key in inspect.get_annotations(base))
    annotation = str(inspect.get_annotations(owner)[key])
    if key == "format":
        return "whole number"
    if key == "colour_by":
        return "one of the names below"
    if key == "domain_update":
        return _choices(model.bodies.DomainUpdate.__args__)
    if key == "kind" and cls is model.Analysis:
        return _choices(model.settings.Kind.__args__)
    if key == "kind" and cls is model.Track:
        return _choices(model.track.EnergyKind.__args__)
    if key == "quantity":
        return _choices(model.track.Quantity.__args__)
    if key == "davis":
        return _choices(model.davis.DavisForm.__args__)
    if key == "drainage":
        return _choices(model.element_tests.Drainage.__args__)
    if key == "panels":
        return f"list of {_choices(model.element_case.Panel.__args__)}"
    name = annotation.removesuffix(" | None")
    if name.startswith("Literal["):
        return _choices(re.findall(r'["\']([^"\']+)["\']', name))
    return TYPE_DESCRIPTIONS[name]


def _choices(values: Any) -> str:
    return ", ".join(f'`"{value}"`' for value in values)


def _default(cls: type[Declared], key: str, field: FieldInfo) -> str:
    if field.is_required() or key == "format" or _selects_kind(cls, key):
        return "required"
    if field.default in (None, ()) or field.default_factory is not None:
        return "-"
    value = field.default
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'`"{value}"`'
    if isinstance(value, tuple):
        return _choices(value)
    return "1/1024" if key == "minimum_step" else f"{value:g}"


def _selects_kind(cls: type[Declared], key: str) -> bool:
    """Returns whether a case file must contain the key although Python takes it from the class."""
    return key in ("type", "model") and cls not in (model.Analysis, model.Stage)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    ELEMENT_PAGE.write_text(element_page(), encoding="utf-8")
