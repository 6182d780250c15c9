# SPDX-License-Identifier: GPL-3.0-or-later
"""B2 and B3, a bar hits a plane once and a bar bounces: figures against the exact solutions (Doyen, Ern, Piperno 2011).

Contact-implicit forces alternate about the exact one in contact, on every mesh. Displacements, energy, impulses, contact
times and the mean of two neighbouring forces converge, and they alone are tested.

Tolerances come from the fronts. Linear elements with a consistent mass and Newmark steps carry waves of wave number k at
the frequency c k (1 + (k h)²/24 - (c k τ)²/12): after a path s a front is spread as the integral of an Airy function of the
width δ = |s ((c τ)²/4 - h²/8)|^(1/3), of order 2/3. What the fronts bring, contact and its end, is early or late by as much,
and with it the gap; the mean square of the force, whose jumps are spread, is of order 1/3.
"""

import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SOURCE, Figures, signorini, table  # noqa: E402

import numpy as np  # noqa: E402

LENGTH, WAVE = 10.0, 30.0  # m, m/s
ENERGY = 500.0  # J/m², kinetic of the impact, potential of the fall
PERIOD = 16 / 3  # s, of the bounces
FASTEST = 10.0  # m/s, at which the gap changes
PEAK = 2.34  # widths δ from the front to where the integral of the Airy function first turns
MESH = SOURCE / "meshes" / "bar.geo"
THIN = 0.001  # m, in place of 1
ELEMENTS = (50, 100, 200, 400)
ROUNDING = 1e-10 * ENERGY  # of thousands of steps, each to about 1e-14


@dataclass(frozen=True)
class Case:
    """A scene and its exact solution until `end` (s)."""

    scene: str
    end: float
    contacts: list[tuple[float, float]]  # s, from and to
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


IMPACT = Case("bar-impact", 2, [(1 / 2, 7 / 6)], 200, (1, 1.41))
BOUNCE = Case("bouncing-bar", 16 / 3, [(1, 5 / 3), (11 / 3, 13 / 3)], 800 / 3, (1.5, 1.41))


@dataclass(frozen=True)
class Motion:
    """What a run of n elements per length left: per step and metre of its width."""

    case: Case
    elements: int
    step: float
    time: np.ndarray
    gap: np.ndarray
    force: np.ndarray
    energy: np.ndarray  # with that of the weight, of which none is lost at the start

    def contacts(self) -> list[slice]:
        """Steps with a force, parted where there is none for half a second."""
        pushed = np.flatnonzero(self.force > 0)
        assert len(pushed) > self.elements, "hardly any contact: the case says nothing"
        return [slice(p[0], p[-1] + 1) for p in np.split(pushed, np.flatnonzero(np.diff(pushed) * self.step > 0.5) + 1)]

    def two_step_force(self) -> np.ndarray:
        """Mean of the forces before and after each time but the first and the last."""
        return (self.force[1:-1] + self.force[2:]) / 2

    def delay(self, t: np.ndarray | float) -> np.ndarray:
        """s: by how much what happens at t may be early or late: a step, and the width of a front since the first contact."""
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


def heading(motion: Motion) -> str:
    return f"{motion.case.scene}, {motion.elements} elements, step {motion.step:.5f} s:"


def compare(motion: Motion, figures: Figures) -> None:
    """The figures of one run against the exact solution."""
    case = motion.case
    contacts = motion.contacts()
    assert len(contacts) == len(case.contacts), f"{len(contacts)} contacts"
    for found, (start, end) in zip(contacts, case.contacts):
        for name, time, exact in (("start", motion.time[found.start - 1], start), ("end", motion.time[found.stop - 1], end)):
            figures.show(f"{name} of contact, s", time, exact, motion.delay(exact))
        jumps = np.array([start + 1e-9, end - 1e-9])
        figures.show("impulse, N s/m²", motion.step * motion.force[found].sum(), case.impulse,
                     case.force(jumps) @ motion.delay(jumps))  # fmt: skip
    deviation = abs(motion.gap - case.gap(motion.time)) / (FASTEST * motion.delay(motion.time))
    figures.show("gap: error / (10 m/s x delay)", deviation.max(), 0, 1)
    # What the node that hits has of kinetic energy may be lost, at most that of an element at each impact.
    figures.show("energy at the end, of the first", 1 - motion.energy_loss(), 1, len(contacts) / motion.elements)
    figures.show("largest rise of energy in a step", np.maximum(0, np.diff(motion.energy).max()), 0, ROUNDING)


def rates(case: Case, courant: float, folder: Path, figures: Figures) -> None:
    motions = [simulate(case, folder / "out", n, courant) for n in ELEMENTS]
    print(heading(motions[1]))
    compare(motions[1], figures)
    for motion in motions:
        raw = motion.force[motion.contacts()[0]]
        print(f"    {motion.elements:4} elements: relative error of the gap {motion.gap_error():.5f}, of the two-step force "
              f"{motion.force_error():.4f}; raw force {raw.min():.0f} to {raw.max():.0f} N/m²")  # fmt: skip

    def order(errors: list[float]) -> float:
        return float(np.polyfit(np.log([1 / n for n in ELEMENTS]), np.log(errors), 1)[0])

    # Above the orders 1/2 and 1/4 of a scheme whose fronts are spread by damping, as h^(1/2).
    figures.least("order of the gap, 2/3 expected", order([m.gap_error() for m in motions]), 1 / 2)
    figures.least("order of the two-step force, 1/3 expected", order([m.force_error() for m in motions]), 1 / 4)


def as_shipped(folder: Path, figures: Figures) -> None:
    print("The scenes as shipped:")
    signorini("simulate", SOURCE / "scenes" / "bar-impact.toml", folder / "out")
    motion = read(IMPACT, folder / "out", 80, 1 / 240)
    print(heading(motion))
    compare(motion, figures)
    inside = (motion.time[1:-1] > 0.55) & (motion.time[1:-1] < 1.1)
    # At either end of the window half a pair of alternating forces, none above 600, is cut.
    figures.show("mean force on (0.55, 1.1), N/m²", motion.two_step_force()[inside].mean(), 300, 300 * motion.step / 0.55)
    signorini("simulate", SOURCE / "scenes" / "bouncing-bar.toml", folder / "out")
    motion = read(BOUNCE, folder / "out", 100, 5e-3)
    assert len(motion.contacts()) == 6, f"{len(motion.contacts())} contacts"
    figures.show("bouncing-bar: energy after six impacts", 1 - motion.energy_loss(), 1, 6 / motion.elements)


def one_dimension(folder: Path, figures: Figures) -> None:
    """Figures of an independent implementation of the same scheme in one dimension. The edges of a strip share out mass
    otherwise than a bar does; one as thin as 1/100 of an element cannot answer to that, and is the bar. Both must agree far
    better than either does with the exact solution, here to 1/20 of that distance, and to the figure's last digit."""
    thin = strip(THIN, folder)
    print("A thin strip, beside the same scheme in one dimension:")
    aligned = simulate(IMPACT, folder / "out", 80, 1, thin, THIN)
    figures.show("bar-impact, 80 elements: energy", 1 - aligned.energy_loss(), 0.9984, 0.0016 / 20 + 5e-5)
    unaligned = simulate(IMPACT, folder / "out", 100, 1.41, thin, THIN)
    figures.show("bar-impact, 4.7 ms: energy", 1 - unaligned.energy_loss(), 0.9928, 0.0072 / 20 + 5e-5)
    rebound = unaligned.step * unaligned.force.sum() / LENGTH - 10
    figures.show("bar-impact, 4.7 ms: mean velocity, m/s", rebound, 9.812, 0.188 / 20 + 5e-4)
    period = simulate(BOUNCE, folder / "out", 100, 1.5, thin, THIN)
    figures.show("bouncing-bar: relative error of the gap", period.gap_error(), 0.028, 0.028 / 20 + 5e-4)
    longer = simulate(replace(BOUNCE, end=16.0), folder / "out", 100, 1.5, thin, THIN)
    figures.show("bouncing-bar: energy after six impacts", 1 - longer.energy_loss(), 0.9745, 0.0255 / 20 + 5e-5)


def main() -> int:
    figures = Figures()
    with tempfile.TemporaryDirectory() as folder:
        for case in (IMPACT, BOUNCE):
            for courant in case.courant:
                rates(case, courant, Path(folder), figures)
        as_shipped(Path(folder), figures)
        one_dimension(Path(folder), figures)
    return 1 if figures.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
