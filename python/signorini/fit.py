# SPDX-License-Identifier: GPL-3.0-or-later
"""The unknowns and measurements of a scene as a least-squares problem."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from . import _signorini
from .problem import fixed

if TYPE_CHECKING:
    from .scene import Scene


class Fit:
    """Residuals r(θ) of a scene's measurements by its unknowns θ, for scipy.optimize.least_squares and the like.

    θ has the unknowns' values in the scene's units and order; arrays are whole, and the same on every rank; those that are attributes are read-only. What was
    computed at the last θ is known: the Jacobian after the residuals makes no motion. All members that take θ are
    collective, and raise SceneError where the scene is none with these values, SolverFailure, KeyboardInterrupt.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._problem = _signorini.FitProblem(scene._scene)

    @property
    def names(self) -> list[str]:
        """Of the unknowns. (n)"""
        return self._problem.names

    @cached_property
    def start(self) -> np.ndarray:
        """The values that the scene starts from. (n)"""
        return fixed(self._problem.start())

    @cached_property
    def lower(self) -> np.ndarray:
        """Lower bounds, those of the unknowns' nature where the scene gives none. (n)"""
        return fixed(self._problem.lower())

    @cached_property
    def upper(self) -> np.ndarray:
        """Upper bounds. (n)"""
        return fixed(self._problem.upper())

    @cached_property
    def measurements(self) -> dict[str, slice]:
        """Which entries of the arrays below belong to a measurement, by its name."""
        found, first = {}, 0
        for name, count in self._problem.measurements():
            if count:
                found[name] = slice(first, first + count)
            first += count
        return found

    @cached_property
    def times(self) -> np.ndarray:
        """Of all data, s. (values)"""
        return fixed(self._problem.times())

    @cached_property
    def measured(self) -> np.ndarray:
        """All data, in SI units. (values)"""
        return fixed(self._problem.measured())

    @cached_property
    def deviations(self) -> np.ndarray:
        """Their standard deviations. (values)"""
        return fixed(self._problem.deviations())

    def residuals(self, theta: ArrayLike) -> np.ndarray:
        """(simulated − measured) / deviation and, after them, those of the priors, by one motion and one linearised one for
        each unknown. (m)"""
        return self._problem.residuals(np.asarray(theta, dtype=float))

    def jacobian(self, theta: ArrayLike) -> np.ndarray:
        """The derivatives of residuals() by θ. (m × n)"""
        return self._problem.jacobian(np.asarray(theta, dtype=float)).T

    def simulated(self, theta: ArrayLike) -> np.ndarray:
        """What the motion gives of what was measured. (values)"""
        return self._problem.simulated(np.asarray(theta, dtype=float))

    @property
    def sweeps(self) -> int:
        """Motions made so far, linearised ones included."""
        return self._problem.sweeps()
