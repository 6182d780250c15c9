# SPDX-License-Identifier: GPL-3.0-or-later
"""A bar that hits a plane once, and a bar that bounces: exact solutions (Doyen, Ern, Piperno 2011), and runs compared with them.

Tolerances come from the fronts. Linear elements with a consistent mass and Newmark steps carry waves of wave number k at
the frequency c k (1 + (k h)²/24 - (c k τ)²/12): after a path s a front is spread as the integral of an Airy function of the
width δ = |s ((c τ)²/4 - h²/8)|^(1/3), of order 2/3. Contact and its end, which the fronts bring, are early or late by as much,
and with them the gap; the mean square of the force, whose jumps are spread, is of order 1/3.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini, table

LENGTH, WAVE = 10.0, 30.0  # m, m/s
ENERGY = 500.0  # J/m², kinetic of the impact, potential of the fall
PERIOD = 16 / 3  # s, of the bounces
FASTEST = 10.0  # m/s, at which the gap changes
PEAK = 2.34  # widths δ from the front to where the integral of the Airy function first turns
MESH = SOURCE / "meshes" / "bar.geo"
ROUNDING = 1e-10 * ENERGY  # of thousands of steps, each to about 1e-14


@dataclass(frozen=True)
class Case:
    """A scene and its exact solution until `end` (s)."""

    scene: str
    end: float
    contacts: tuple[tuple[float, float], ...]  # s, from and to
    impulse: float  # N s/m², of each contact
    courant: tuple[float, float]  # c τ / h: with the impact on a step, and with it inside of one

    def gap(self, t: np.ndarray) -> np.ndarray:
        """m, of the lower end"""
        if self.scene == "bar-impact":
            return np.select([t < 1 / 2, t < 7 / 6], [5 - 10 * t, 0], 10 * (t - 7 / 6))
        t = t % PERIOD
        s = t - 5 / 3
        q = s % (2 / 3)
        flight = 10 * s - 5 * s**2 - 10 * q * (2 / 3 - q)
        return np.select([t < 1, t < 5 / 3, t < 11 / 3, t < 13 / 3], [5 - 5 * t**2, 0, flight, 0], 5 - 5 * (16 / 3 - t) ** 2)

    def force(self, t: np.ndarray) -> np.ndarray:
        """N/m²"""
        if self.scene == "bar-impact":
            (a, b) = self.contacts[0]
            return np.where((t > a) & (t < b), 300.0, 0)
        (a, b), (c, d) = self.contacts[:2]
        t = t % PERIOD
        return np.select([(t > a) & (t < b), (t > c) & (t < d)], [300 + 300 * (t - a), 300 + 300 * (d - t)], 0.0)


IMPACT = Case("bar-impact", 2, ((1 / 2, 7 / 6),), 200, (1, 1.41))
BOUNCE = Case("bouncing-bar", 16 / 3, ((1, 5 / 3), (11 / 3, 13 / 3)), 800 / 3, (1.5, 1.41))


@dataclass(frozen=True)
class Motion:
    """Series of a run with n elements per length: per step and metre of the width."""

    case: Case
    elements: int
    step: float
    time: np.ndarray
    gap: np.ndarray
    force: np.ndarray
    energy: np.ndarray  # with that of the weight; ENERGY at the start

    def contacts(self) -> list[slice]:
        """Steps with a force, divided where there is none for half a second."""
        pushed = np.flatnonzero(self.force > 0)
        assert len(pushed) > self.elements, "hardly any contact: the case says nothing"
        return [slice(p[0], p[-1] + 1) for p in np.split(pushed, np.flatnonzero(np.diff(pushed) * self.step > 0.5) + 1)]

    def two_step_force(self) -> np.ndarray:
        """Mean of the forces before and after each time but the first and the last."""
        return (self.force[1:-1] + self.force[2:]) / 2

    def delay(self, t: np.ndarray | float) -> np.ndarray:
        """s: by how much an event at t may be early or late: a step, and the width of a front since the first contact."""
        h = LENGTH / self.elements
        path = WAVE * np.maximum(0, t - self.case.contacts[0][0])
        return 1.001 * self.step + PEAK / WAVE * (path * abs((WAVE * self.step) ** 2 / 4 - h**2 / 8)) ** (1 / 3)

    def gap_error(self) -> float:
        exact = self.case.gap(self.time)
        return float(np.linalg.norm(self.gap - exact) / np.linalg.norm(exact))

    def force_error(self) -> float:
        exact = self.case.force(self.time[1:-1])
        return float(np.linalg.norm(self.two_step_force() - exact) / np.linalg.norm(exact))

    def energy_loss(self) -> float:
        return 1 - self.energy[-1] / ENERGY


def strip(width: float, folder: Path) -> Path:
    """The scenes' mesh at another width."""
    mesh = folder / f"bar-{width}.geo"
    mesh.write_text(MESH.read_text().replace("width = 1;", f"width = {width};"))
    assert f"width = {width};" in mesh.read_text()
    return mesh


def simulate(case: Case, out: Path, elements: int, courant: float, mesh: Path = MESH, width: float = 1,
             **overrides: object) -> Motion:  # fmt: skip
    step = courant * LENGTH / elements / WAVE
    count = int(case.end / step * (1 + 1e-12))
    signorini("simulate", SOURCE / "scenes" / f"{case.scene}.toml", out, mesh__size=LENGTH / elements, time__step=step,
              time__end=count * step, output__every=count, mesh__file=str(mesh), **overrides)  # fmt: skip
    return read(case, out, elements, step, width)


def read(case: Case, out: Path, elements: int, step: float, width: float = 1) -> Motion:
    steps = table(out / "steps.csv")
    energy = (steps["kinetic_energy"] + steps["elastic_energy"] - np.cumsum(steps["external_work"])) / width
    return Motion(case, elements, step, steps["step"] * step, steps["min_gap"], steps["contact_force_y"] / width,
                  energy + ENERGY - energy[0])  # fmt: skip


def compare(motion: Motion) -> None:
    """Asserts the figures of one run against the exact solution."""
    case, contacts = motion.case, motion.contacts()
    assert len(contacts) == len(case.contacts)
    for found, (start, end) in zip(contacts, case.contacts):
        assert motion.time[found.start - 1] == pytest.approx(start, abs=motion.delay(start)), "start of contact, s"
        assert motion.time[found.stop - 1] == pytest.approx(end, abs=motion.delay(end)), "end of contact, s"
        jumps = np.array([start + 1e-9, end - 1e-9])
        impulse = motion.step * motion.force[found].sum()
        assert impulse == pytest.approx(case.impulse, abs=case.force(jumps) @ motion.delay(jumps)), "impulse, N s/m²"
    assert (abs(motion.gap - case.gap(motion.time)) <= FASTEST * motion.delay(motion.time)).all(), "gap"
    # The kinetic energy of the node that hits may be lost, at most that of an element at each impact.
    assert abs(motion.energy_loss()) <= len(contacts) / motion.elements
    assert np.diff(motion.energy).max() <= ROUNDING, "energy rises"
