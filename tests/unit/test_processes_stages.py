# SPDX-License-Identifier: BSD-3-Clause
"""Several processes find the serial run's result: stages, and the factor of safety."""

from __future__ import annotations

import pytest
from mpi_runs import assert_as_serial
from staged_problems import KINDS, staged_entries

from tilth import Model

several = pytest.mark.parametrize("processes", [2, 3])


@several
@pytest.mark.parametrize("kind", KINDS)
def test_soil_is_dug_placed_and_exchanged(kind: str, processes: int) -> None:
    """In five stages, with loads on surfaces, released forces, implicit walls and two grids."""
    assert_as_serial(Model.from_dict(staged_entries(kind)), processes)
