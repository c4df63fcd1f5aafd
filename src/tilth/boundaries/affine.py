# SPDX-License-Identifier: BSD-3-Clause
"""An affine motion of every active node: what element-like tests are driven by."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from tilth.boundaries.protocol import Floats, Prescribed
from tilth.grid import ActiveGrid
from tilth.model import AffineBoundary, Model


class Affine:
    """Prescribes x = F(t) X on all nodes: the increment is (F(after) F(before)^-1 - I) x."""

    def __init__(self, declared: AffineBoundary, model: Model) -> None:
        self.name = declared.name
        self._declared = declared
        self._model = model
        self._end = np.array(declared.deformation_gradient)

    def deformation_gradient(self, time: float) -> Floats:
        """Returns F at `time` [-], shape (dim, dim)."""
        factor = self._model.factor(self._declared, time)
        identity = np.eye(len(self._end))
        if self._declared.path == "linear":
            return np.asarray(identity + factor * (self._end - identity))
        from scipy.linalg import expm

        return np.asarray(expm(factor * self._logarithm))

    @cached_property
    def _logarithm(self) -> Floats:
        from scipy.linalg import logm

        return np.asarray(logm(self._end).real)

    def prescribe(self, active: ActiveGrid, before: float, after: float) -> Prescribed:
        """Returns the increment of all nodes from time `before` to `after`."""
        step = self.deformation_gradient(after) @ np.linalg.inv(self.deformation_gradient(before))
        increment = active.position @ (step - np.eye(len(step))).T
        return Prescribed(np.ones(increment.shape, dtype=bool), increment)
