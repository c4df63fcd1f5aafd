# SPDX-License-Identifier: BSD-3-Clause
"""The factor of safety of a model at the end of its schedule, in memory."""

from __future__ import annotations

from tilth.analysis.march import march
from tilth.analysis.safety import SafetyResult, strength_reduction
from tilth.model import Model, StrengthReduction


def factor_of_safety(model: Model, tolerance: float = 0.005) -> float:
    """Returns the middle of the bracket of the factor of safety [-], with this width at most."""
    result = safety_at_end(model, tolerance)
    return 0.5 * (result.factor + result.above)


def safety_at_end(model: Model, tolerance: float = 0.005) -> SafetyResult:
    """Runs a model and reduces the strength at its end, to a tolerance of the factor [-]."""
    settings = StrengthReduction(tolerance=tolerance)
    return strength_reduction(march(model), model.schedule.end, settings)
