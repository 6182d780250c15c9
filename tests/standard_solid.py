# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed forms of a linear viscoelastic solid with Prony branches whose strain or stress rises smoothly and then stays.

The rise is s(t) = (1 - cos(π t/rise))/2 up to t = rise and 1 afterwards: with a jump, a dynamic scheme would ring. Where the body
cannot move sideways the ratio of stress and strain is the constrained modulus K + 4 G/3, with any shares of both in the branches.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Solid:
    """Constrained moduli of a material: the long-term one, and each branch's with its time."""

    long_term: float  # Pa
    branches: tuple[tuple[float, float], ...]  # Pa, s

    @classmethod
    def of(cls, young: float, poisson: float, prony: list[dict]) -> "Solid":
        """The solid with these instantaneous constants and the scene's table `prony`."""
        bulk, shear = young / (3 * (1 - 2 * poisson)), young / (2 * (1 + poisson))
        branches = tuple((one["k"] * bulk + 4 / 3 * one["g"] * shear, one["time"]) for one in prony)
        return cls(bulk + 4 / 3 * shear - sum(modulus for modulus, _ in branches), branches)

    @property
    def instantaneous(self) -> float:
        return self.long_term + sum(modulus for modulus, _ in self.branches)

    def relaxation(self, t: np.ndarray, rise: float) -> np.ndarray:
        """Stress at time t where the strain is s(t)."""
        return self.long_term * risen(t, rise) + sum(modulus * branch(t, rise, time) for modulus, time in self.branches)

    def creep(self, t: np.ndarray, rise: float) -> np.ndarray:
        """Strain at time t where the stress is s(t); for one branch. Its time of retardation is longer than that of relaxation."""
        ((_, time),) = self.branches
        slow = time * self.instantaneous / self.long_term
        return risen(t, rise) / self.long_term - (1 / self.long_term - 1 / self.instantaneous) * branch(t, rise, slow)


def at_ends(exact: Callable[[np.ndarray], np.ndarray], t: np.ndarray) -> np.ndarray:
    """Means of the values at both ends of each step: what a force of a step is to the second order, whose displacements are at the ends."""
    return (exact(t[1:]) + exact(t[:-1])) / 2


def over_steps(exact: Callable[[np.ndarray], np.ndarray], t: np.ndarray) -> np.ndarray:
    """Means over each step, by Simpson's rule: what the mean displacement of a step is, whose loads act by their means."""
    return at_ends(exact, t) / 3 + 2 / 3 * exact((t[1:] + t[:-1]) / 2)


def risen(t: np.ndarray, rise: float) -> np.ndarray:
    """s(t)"""
    return (1 - np.cos(np.pi * np.minimum(t, rise) / rise)) / 2


def expression(rise: float) -> str:
    """s(t) as an expression of a scene."""
    return f"(t < {rise!r} ? 0.5*(1 - cos(pi*t/{rise!r})) : 1)"


def branch(t: np.ndarray, rise: float, time: float) -> np.ndarray:
    """q(t) with q' = s' - q/time and q(0) = 0."""
    w, end = np.pi / rise, np.minimum(t, rise)
    while_rising = w / 2 * (np.sin(w * end) / time - w * np.cos(w * end) + w * np.exp(-end / time)) / (time**-2 + w**2)
    return while_rising * np.exp(-(t - end) / time)
