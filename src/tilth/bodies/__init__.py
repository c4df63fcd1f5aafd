# SPDX-License-Identifier: BSD-3-Clause
"""Bodies: from a declared shape to the initial material points."""

from tilth.bodies.discretise import discretise
from tilth.bodies.request import BodyPoints

__all__ = ["BodyPoints", "discretise"]
