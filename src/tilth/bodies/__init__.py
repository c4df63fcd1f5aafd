# SPDX-License-Identifier: BSD-3-Clause
"""Initial material points of bodies, from their declared shapes."""

from tilth.bodies.discretise import discretise
from tilth.bodies.request import BodyPoints

__all__ = ["BodyPoints", "discretise"]
