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
    """Residuals r(θ) of a scene's measurements as a function of its unknowns θ, for scipy.optimize.least_squares and similar functions.

    θ has the unknowns' values in the scene's units and order. Arrays are whole, and the same on every rank; arrays that are
    attributes are read-only. Results at the last θ are cached: the Jacobian after the residuals computes no motion. Members
    that take θ are collective. They raise SceneError if these values are impossible in the scene, SolverFailure, and
    KeyboardInterrupt.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._problem = _signorini.FitProblem(scene._scene)

    @property
    def names(self) -> list[str]:
        """Names of the unknowns. (n)"""
        return self._problem.names

    @cached_property
    def start(self) -> np.ndarray:
        """Start values of the scene. (n)"""
        return fixed(self._problem.start())

    @cached_property
    def lower(self) -> np.ndarray:
        """Lower bounds of the unknowns; physical limits, such as 0 for a density, where the scene gives no bounds. (n)"""
        return fixed(self._problem.lower())

    @cached_property
    def upper(self) -> np.ndarray:
        """Upper bounds of the unknowns; physical limits, such as 0.5 for Poisson's ratio, where the scene gives no bounds. (n)"""
        return fixed(self._problem.upper())

    @cached_property
    def measurements(self) -> dict[str, slice]:
        """Slice of each measurement, by its name, in the arrays times, measured, deviations and simulated()."""
        found, first = {}, 0
        for name, count in self._problem.measurements():
            if count:
                found[name] = slice(first, first + count)
            first += count
        return found

    @cached_property
    def times(self) -> np.ndarray:
        """Times of all data, s. (values)"""
        return fixed(self._problem.times())

    @cached_property
    def measured(self) -> np.ndarray:
        """Measured values, in SI units. (values)"""
        return fixed(self._problem.measured())

    @cached_property
    def deviations(self) -> np.ndarray:
        """Standard deviations of the measured values, in SI units. (values)"""
        return fixed(self._problem.deviations())

    def residuals(self, theta: ArrayLike) -> np.ndarray:
        """Returns (simulated − measured) / deviation, followed by the residuals of the priors. Computes one motion and one
        linearised motion for each unknown. (m)"""
        return self._problem.residuals(np.asarray(theta, dtype=float))

    def jacobian(self, theta: ArrayLike) -> np.ndarray:
        """Returns the Jacobian matrix of residuals() with respect to θ. (m × n)"""
        return self._problem.jacobian(np.asarray(theta, dtype=float)).T

    def simulated(self, theta: ArrayLike) -> np.ndarray:
        """Returns the simulated values of the measured quantities. (values)"""
        return self._problem.simulated(np.asarray(theta, dtype=float))

    @property
    def sweeps(self) -> int:
        """Number of motions computed so far, including linearised ones."""
        return self._problem.sweeps()
