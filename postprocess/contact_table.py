# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact of a run by candidates (contact.csv) and by obstacles (obstacles.csv), with friction also along the surfaces."""

from dataclasses import dataclass

import numpy as np

from .files import Table

STATUS = ["open", "weak", "strong"]  # of a candidate
MOTION = ["open", "free", "stick", "slip"]  # of a candidate of a run with friction; free: closed without friction
OPEN, FREE, STICK, SLIP = range(4)


@dataclass(frozen=True)
class Friction:
    """Friction of the candidates at the stored times: force on the body along the obstacle (N or N/m, times × m × dim), velocity
    relative to the obstacle along it (m/s, times × m × dim), and number of the motion in MOTION (times × m)."""

    force: np.ndarray
    velocity: np.ndarray
    motion: np.ndarray

    def of(self, own: np.ndarray) -> "Friction":
        """Returns the friction of the candidates `own` (flags)."""
        return Friction(self.force[:, own], self.velocity[:, own], self.motion[:, own])

    def by_node(self, node: np.ndarray, count: int) -> "Friction":
        """Merges the candidates of each node: forces and velocities are added, of which those of one candidate alone are not 0."""
        times, _, dim = self.force.shape
        force, velocity, motion = np.zeros((times, count, dim)), np.zeros((times, count, dim)), np.zeros((times, count), int)
        np.add.at(force, (slice(None), node), self.force)
        np.add.at(velocity, (slice(None), node), self.velocity)
        np.maximum.at(motion, (slice(None), node), self.motion)
        return Friction(force, velocity, motion)


@dataclass(frozen=True)
class Contact:
    """Candidates (points m × dim, m; obstacles m, numbers from 0) at the stored times (s): gap (m), normal force (N or N/m,
    RunFolder.whole), whether in contact, pressure (N/m²), each times × m; direction of the force (m × dim); friction, if any."""

    times: np.ndarray
    points: np.ndarray
    obstacle: np.ndarray
    gap: np.ndarray
    force: np.ndarray
    touches: np.ndarray
    normal: np.ndarray
    pressure: np.ndarray
    friction: Friction | None = None

    @property
    def most_pushed(self) -> int:
        """Number of the candidate with the largest force over time; without forces, of the candidate nearest to its obstacle."""
        total = self.force.sum(axis=0)
        return int(np.argmax(total) if total.any() else np.argmin(self.gap.min(axis=0)))

    @property
    def tangent(self) -> np.ndarray:
        """Normals in the plane, turned clockwise by 90° (m × 2): to the right above a floor."""
        return np.column_stack([self.normal[:, 1], -self.normal[:, 0]])

    @property
    def tangential_force(self) -> np.ndarray | None:
        """Friction forces (times × m): in the plane along `tangent`, in space their moduli; None without friction."""
        return None if self.friction is None else self._along_surface(self.friction.force)

    @property
    def slip_velocity(self) -> np.ndarray | None:
        """Velocities relative to the obstacle (times × m), as `tangential_force`; NaN where there is no contact."""
        if self.friction is None:
            return None
        return np.where(self.friction.motion == OPEN, np.nan, self._along_surface(self.friction.velocity))

    def _along_surface(self, vectors: np.ndarray) -> np.ndarray:
        if vectors.shape[2] == 2:
            return np.einsum("tmi,mi->tm", vectors, self.tangent)
        return np.linalg.norm(vectors, axis=2)

    def by_node(self) -> "Contact":
        """Merges the candidates of each node: forces and pressures are added, and the least gap is taken."""
        points, first, node = np.unique(self.points, axis=0, return_index=True, return_inverse=True)
        shape, node = (len(self.times), len(points)), node.ravel()
        gap, force, pressure, touches = np.full(shape, np.inf), np.zeros(shape), np.zeros(shape), np.zeros(shape, bool)
        np.minimum.at(gap, (slice(None), node), self.gap)
        np.add.at(force, (slice(None), node), self.force)
        np.add.at(pressure, (slice(None), node), self.pressure)
        np.logical_or.at(touches, (slice(None), node), self.touches)
        friction = None if self.friction is None else self.friction.by_node(node, len(points))
        return Contact(self.times, points, np.zeros(len(points), int), gap, force, touches, self.normal[first], pressure, friction)

    def of(self, obstacle: int) -> "Contact":
        """Returns the contact data of the candidates of one obstacle."""
        own = self.obstacle == obstacle
        friction = None if self.friction is None else self.friction.of(own)
        return Contact(self.times, self.points[own], self.obstacle[own], self.gap[:, own], self.force[:, own],
                       self.touches[:, own], self.normal[own], self.pressure[:, own], friction)  # fmt: skip


def contact_of(table: Table) -> Contact:
    """Makes the contact data of the columns of contact.csv. Raises ValueError if not every step has the same number of rows."""
    steps, first = np.unique(table["step"], return_index=True)
    shape = (len(steps), -1)
    gap, force, status, pressure = (table[name].reshape(shape) for name in ("gap", "force", "status", "pressure"))
    count = gap.shape[1]
    axes = [axis for axis in "xyz" if axis in table]
    points, normal = (np.column_stack([table[before + axis][:count] for axis in axes]) for before in ("", "normal_"))
    friction = None
    if "motion" in table:
        along, velocity = (np.stack([table[f"{name}_{axis}"].reshape(shape) for axis in axes], axis=2)
                           for name in ("tangential_force", "slip_velocity"))  # fmt: skip
        friction = Friction(along, velocity, table["motion"].reshape(shape).astype(int))
    return Contact(table["time"][first], points, table["obstacle"][:count].astype(int), gap, force,
                   status != STATUS.index("open"), normal, pressure, friction)  # fmt: skip


@dataclass(frozen=True)
class ObstacleSteps:
    """Contact with an obstacle at every time step: the sum of the moduli of its normal nodal forces and the resultant of all (steps,
    steps × dim; N or N/m, RunFolder.whole), and the number of candidates in contact."""

    name: str
    normal_force: np.ndarray
    active: np.ndarray
    resultant: np.ndarray
