# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the cases of the verification manual and writes its pages, docs/verification/*.md.

usage: python3 docs/verification.py [CASE…]        with the built `signorini` on PATH; two minutes for all

A case is a scene, a reference and tolerances. With names of cases only these are run; the table of all cases is made from their
pages. tests/regression/manual.py runs every case and compares it with its page.
"""

import json
import re
import shlex
import sys
import tempfile
import textwrap
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).resolve().parent
PAGES = HERE / "verification"
sys.path[:0] = [str(HERE.parent / "tests"), str(HERE)]

from exact_bar import BOUNCE  # noqa: E402
from harness import signorini, stored, table, toml  # noqa: E402
from pressed_disc import hertz, hertz_pressure, pressure  # noqa: E402
from standard_solid import Solid, at_ends, over_steps  # noqa: E402
from verification_case import Case, Figure, impact  # noqa: E402
from verification_friction import CASES as WITH_FRICTION  # noqa: E402
from verification_oblique import CASES as OBLIQUE  # noqa: E402
from verification_parts import CASES as OF_PARTS  # noqa: E402
from verification_rigid import CASES as WITH_MASS  # noqa: E402


def mean_force(out: Path, start: float, end: float) -> float:
    """Mean contact force over the middle half of a contact."""
    steps = table(out / "steps.csv")
    inside = abs(steps["time"] - (start + end) / 2) < (end - start) / 4
    return steps["normal_force"][inside].mean()


def truss(out: Path) -> list[Figure]:
    length, area, young, density, speed, gap = 2, 0.2, 200e9, 7800, 1.5, 1e-3
    c, found = np.sqrt(young / density), impact(out)
    start, lasts = gap / speed, 2 * length / c
    force = density * c * speed * area
    return [
        Figure("touch", "ms", 1e3 * start, 1e3 * found["start"], 4e-3),
        Figure("contact lasts", "ms", 1e3 * lasts, 1e3 * found["duration"], 1e-2),
        Figure("force", "MN", force / 1e6, mean_force(out, start, start + lasts) / 1e6, 5e-3),
        Figure("impulse", "N s", force * lasts, found["impulse"][1], 1e-2),
    ]


def rod(out: Path) -> list[Figure]:
    length, radius, young, density, speed = 0.254, 0.0127, 200e9, 7850, 4.4287
    c, found = np.sqrt(young / density), impact(out)
    nodes, cells, stress = stored(out, "state", "stress")
    with h5py.File(out / "state.h5") as file:
        times = file["times"][:]
    lower = nodes[cells][:, :, 2].mean(axis=1) < length / 2
    full = stress[np.argmin(abs(times - length / c))].reshape(len(cells), 9)[lower, 8].mean()
    return [
        Figure("contact lasts", "ms", 2e3 * length / c, 1e3 * found["duration"], 1e-2),
        Figure("force", "kN", density * c * speed * np.pi * radius**2 / 1e3, mean_force(out, 0, 2 * length / c) / 1e3, 5e-3),
        Figure("stress of the rod at rest", "MPa", -density * c * speed / 1e6, full / 1e6, 5e-3),
    ]


def clamped_bar(out: Path) -> list[Figure]:
    steps = table(out / "steps.csv")
    t, width = steps["time"], 0.1
    phase = t % 3
    exact = np.select([phase < 1, phase < 2], [(1 - phase) / 2, 0], (phase - 2) / 2)
    error = np.linalg.norm(steps["min_gap"] - exact) / np.linalg.norm(exact)
    energy = steps["kinetic_energy"] + steps["elastic_energy"]
    return [
        Figure("force of the first contact", "N/m", width / 2, mean_force(out, 1, 2), 5e-3),
        Figure("impulse of four contacts", "N s/m", 4 * width / 2, impact(out)["impulse"][1], 2e-2),
        Figure("error of the gap over 12 s, in L2", "", 0, error, 2e-2),
        Figure("energy lost after four contacts", "", 0, 1 - energy[-1] / energy[0], 1e-2),
    ]


def roller(out: Path) -> list[Figure]:
    load, radius, modulus = 35e6, 0.05, 70e9 / (1 - 0.3**2)
    width = np.sqrt(4 * load * radius / (np.pi * modulus))
    contact = table(out / "contact.csv")
    last = contact["step"] == contact["step"][-1]
    x, force = contact["x"][last], contact["force"][last]
    # The second moment of Hertz's pressure is P a²/4.
    return [
        Figure("force", "kN/mm", load / 1e6, 2 * force.sum() / 1e6, 5e-3),
        Figure("half-width", "mm", 1e3 * width, 1e3 * 2 * np.sqrt((x**2 * force).sum() / force.sum()), 2e-2),
        Figure("pressure in the middle", "MPa", 2 * load / (np.pi * width) / 1e6, contact["pressure"][last][np.argmin(x)] / 1e6, 2e-2),
    ]


SIZES = (0.25, 0.125, 0.0625)  # m, of the hammered bar's elements


def hammered_bar(*outs: Path) -> list[Figure]:
    impedance, depth, period = 30, 0.03, 0.4  # N s/m³, m, s
    position = lambda t: depth * np.sin(np.pi * np.minimum(t, period / 2) / period) ** 2  # noqa: E731
    work = impedance * (np.pi * depth / period) ** 2 * period / 4
    reflected = []
    for out in outs:
        steps = table(out / "steps.csv")
        reflected.append((steps["kinetic_energy"] + steps["elastic_energy"])[-1] / work)
        if out == outs[1]:
            exact = impedance * np.diff(position(steps["time"])) / np.diff(steps["time"])
            force = steps["normal_force"][1:]
            work_done, impulse = steps["contact_work"].sum(), abs(impact(out)["impulse"][1])
    return [
        Figure("impulse", "N s/m", impedance * depth, impulse, 1e-3),
        Figure("largest force", "N/m", impedance * np.pi * depth / period, force.max(), 5e-3),
        Figure("error of the force over time, in L2", "", 0, np.linalg.norm(force - exact) / np.linalg.norm(exact), 3e-2),
        Figure("work of the hammer", "J/m", work, work_done, 1e-3),
        *(Figure(f"energy left, elements of {size:g} m", "", 0, left, limit)
          for size, left, limit in zip(SIZES, reflected, (1e-4, 2.5e-5, 6e-6))),
    ]  # fmt: skip


def bar_on_springs(out: Path) -> list[Figure]:
    probe = table(out / "probes.csv")
    t, momentum = probe["time"], probe["bar.momentum_y"]
    turn = np.flatnonzero(np.sign(momentum[1:-1]) * np.sign(momentum[2:]) < 0)[-1] + 1
    turned = t[turn] + (t[turn + 1] - t[turn]) * momentum[turn] / (momentum[turn] - momentum[turn + 1])
    found = 3 * np.pi / turned  # the third time that it is at rest after the start, 1.5 periods
    stiffness, mass, young, length, x = 9, 10, 900, 10, 0.3110528482002977  # x tan x = stiffness · length / young
    return [
        Figure("frequency", "rad/s", x * np.sqrt(young / (mass / length)) / length, found, 1e-3),
        Figure("frequency by springs and a third of the bar in series", "rad/s",
               1 / np.sqrt(mass * (1 / stiffness + length / (3 * young))), found, 1e-3),
        Figure("frequency of a rigid bar, √(k/m)", "rad/s", np.sqrt(stiffness / mass), found, 2e-2),
    ]  # fmt: skip


SOLID = Solid.of(1e3, 0.3, [{"g": 0.5, "k": 0.2, "time": 1.0}])
RISE = 0.5  # s


def of_steps(t: np.ndarray, found: np.ndarray, exact: np.ndarray, times: tuple[float, ...], name: str, unit: str) -> list[Figure]:
    """Figures of the steps that begin at some times, and the largest difference relative to the largest value."""
    steps = [int(np.argmin(abs(t[:-1] - time))) for time in times]
    return [
        *(Figure(f"{name} at {(t[k] + t[k + 1]) / 2:.2f} s", unit, exact[k], found[k], 1e-3) for k in steps),
        Figure("largest difference / largest value", "", 0, abs(found - exact).max() / abs(exact).max(), 1e-3),
    ]


def relaxation(out: Path) -> list[Figure]:
    probe = table(out / "probes.csv")
    t, exact = probe["time"], at_ends(lambda s: 0.01 * SOLID.relaxation(s, RISE), probe["time"])
    return of_steps(t, probe["top.reaction_y"][1:], exact, (0.5, 1, 2, 4.98), "stress", "Pa")


def creep(out: Path) -> list[Figure]:
    probe = table(out / "probes.csv")
    t, moved = probe["time"], 1e3 * probe["top.displacement_y"]
    exact = over_steps(lambda s: 1e4 * SOLID.creep(s, RISE), t)
    return of_steps(t, (moved[1:] + moved[:-1]) / 2, exact, (0.5, 1, 2, 7.98), "displacement of the top", "mm")


def bar_impact(out: Path) -> list[Figure]:
    found, steps = impact(out), table(out / "steps.csv")
    force = (steps["normal_force"][1:-1] + steps["normal_force"][2:]) / 2  # single steps alternate about the force
    middle = abs(steps["time"][1:-1] - 5 / 6) < 1 / 6
    before, after = (json.loads((out / "run.json").read_text())["impact"][f"velocity_{when}"][1] for when in ("before", "after"))
    return [
        Figure("touch", "s", 0.5, found["start"], 1e-2),
        Figure("contact lasts", "s", 2 / 3, found["duration"], 2e-2),
        Figure("force", "N/m", 300, force[middle].mean(), 5e-3),
        Figure("impulse", "N s/m", 200, found["impulse"][1], 1e-2),
        Figure("velocity of the rebound / before", "", -1, after / before, 2e-2),
        Figure("energy that contact takes / energy", "", 0, -steps["contact_work"].sum() / 500, 1 / 160),
    ]


BOUNCING_SIZES = {0.1: 0.04, 0.05: 0.025}  # m, with the tolerance of the gap


def bouncing_bar(*outs: Path) -> list[Figure]:
    found = []
    for (size, tolerance), out in zip(BOUNCING_SIZES.items(), outs):
        steps, bounces = table(out / "steps.csv"), json.loads((out / "run.json").read_text())["impact"]["bounces"]
        exact = BOUNCE.gap(steps["time"])
        error = np.linalg.norm(steps["min_gap"] - exact) / np.linalg.norm(exact)
        found += [
            *(Figure(f"impulse of the {which} contact, elements of {size:g} m", "N s/m", 800 / 3, bounce["impulse"][1], 1e-2)
              for which, bounce in zip(("first", "second"), bounces, strict=True)),
            Figure(f"error of the gap in L2, elements of {size:g} m", "", 0, error, tolerance),
        ]  # fmt: skip
    return found


WAVE_RUNS = {1: ((0.5, 40), (0.25, 80)), 2: ((1.25, 160), (0.625, 640))}  # by degree: size (m), steps per period


def standing_wave(*outs: Path) -> list[Figure]:
    errors = []
    for out in outs:
        nodes, _, displacement = stored(out, "state", "displacement")
        with h5py.File(out / "state.h5") as file:
            times = file["times"][:]
        exact = 0.1 * np.sin(np.pi * nodes[:, 1] / 20) * np.cos(1.5 * np.pi * times)[:, None]
        errors.append(np.linalg.norm(displacement[:, :, 1] - exact) / np.linalg.norm(exact))
    return [
        Figure("error over time, degree 1, elements of 0.25 m", "", 0, errors[1], 3e-3),
        Figure("order, degree 1", "", 2, np.log2(errors[0] / errors[1]), 0.05),
        Figure("error over time, degree 2, elements of 0.625 m", "", 0, errors[3], 5e-5),
        Figure("order, degree 2, steps by the square of the size", "", 4, np.log2(errors[2] / errors[3]), 0.05),
    ]


def hertz_press(out: Path) -> list[Figure]:
    width, peak = hertz(10)
    x, length, force = pressure(out)
    exact, found = hertz_pressure(x, 10), force / length
    return [
        Figure("force", "N/m", 10, force.sum(), 1e-3),
        Figure("half-width", "m", width, 2 * np.sqrt((x**2 * force).sum() / force.sum()), 1.7e-2),
        Figure("largest pressure", "N/m²", peak, found.max(), 1.7e-2),
        Figure("error of the pressure in L2", "", 0, np.sqrt((length * (found - exact)**2).sum() / (length * exact**2).sum()), 0.1),
    ]  # fmt: skip


MODELS = ("plane-strain", "plane-stress", "axisymmetric")


def patch(*outs: Path) -> list[Figure]:
    found = []
    for model, out in zip(MODELS, outs):
        contact = table(out / "contact.csv")
        last, before = (contact["step"] == contact["step"][-1] - k for k in (0, 1))
        exact = 0.05 * 200 / (1 - 0.3**2 if model == "plane-strain" else 1)
        pressures = (contact["pressure"][last] + contact["pressure"][before]) / 2
        force = (contact["force"][last] + contact["force"][before]).sum() / 2
        area = np.pi if model == "axisymmetric" else 1
        found += [
            Figure(f"relative error of the force, {model}", "", 0, force / (exact * area) - 1, 1e-10),
            Figure(f"largest relative error of a node's pressure, {model}", "", 0, abs(pressures / exact - 1).max(), 1e-10),
        ]
    return found


@dataclass(frozen=True)
class Ball:
    """An elastic ball that hits a rigid plane, in Hertz's theory of impact, with or without its weight."""

    radius: float
    young: float
    poisson: float
    density: float
    speed: float
    gravity: float = 0

    @property
    def mass(self) -> float:
        return self.density * 4 / 3 * np.pi * self.radius**3

    @property
    def stiffness(self) -> float:
        """N/m^(3/2): the force is this times the approach to the power 3/2."""
        return 4 / 3 * self.young / (1 - self.poisson**2) * np.sqrt(self.radius)

    @property
    def approach(self) -> float:
        """m, the largest: the root of the balance of energy, by fixed points."""
        found = 0.0
        for _ in range(100):
            found = (5 * self.mass / (4 * self.stiffness) * (self.speed**2 + 2 * self.gravity * found)) ** 0.4
        return found

    @property
    def force(self) -> float:
        return self.stiffness * self.approach**1.5

    @property
    def duration(self) -> float:
        """s: twice the integral of 1/speed over the approach δ (1 − s²), whose speed vanishes like s."""
        s = (np.arange(10_000) + 0.5) / 10_000
        at = self.approach * (1 - s**2)
        speed = np.sqrt(self.speed**2 + 2 * self.gravity * at - 4 * self.stiffness * at**2.5 / (5 * self.mass))
        return 2 * (2 * self.approach * s / speed).mean()


def largest_force(out: Path) -> float:
    """The largest mean over two steps."""
    force = table(out / "steps.csv")["normal_force"][1:]
    return (force[1:] + force[:-1]).max() / 2


STEEL = Ball(0.03128, 200e9, 0.3, 7800, 3.1316)
SLOW = 32  # times slower: the contact is 4 times smaller


def steel_ball(fast: Path, slow: Path) -> list[Figure]:
    slower = Ball(STEEL.radius, STEEL.young, STEEL.poisson, STEEL.density, STEEL.speed / SLOW)
    center = table(fast / "probes.csv")["ball.center_y"]
    forces = [largest_force(out) / ball.force for out, ball in ((fast, STEEL), (slow, slower))]
    durations = [impact(out)["duration"] / ball.duration for out, ball in ((fast, STEEL), (slow, slower))]
    in_the_limit = lambda ratios: (4 * ratios[1] - ratios[0]) / 3  # noqa: E731
    return [
        Figure("contact lasts", "µs", 1e6 * STEEL.duration, 1e6 * impact(fast)["duration"], 3.4e-2),
        Figure("largest force", "kN", STEEL.force / 1e3, forces[0] * STEEL.force / 1e3, 3.4e-2),
        Figure("approach of the centre of mass", "mm", 1e3 * STEEL.approach, 1e3 * (center[0] - center.min()), 3.4e-2),
        Figure("impulse", "N s", 2 * STEEL.mass * STEEL.speed, impact(fast)["impulse"][1], 2e-3),
        Figure("largest force, 32 times slower", "kN", slower.force / 1e3, forces[1] * slower.force / 1e3, 8.5e-3),
        Figure("force / Hertz's, in the limit a/R → 0", "", 1, in_the_limit(forces), 2e-3),
        Figure("duration / Hertz's, in the limit a/R → 0", "", 1, in_the_limit(durations), 4e-3),
    ]


def soft_ball(out: Path) -> list[Figure]:
    fall, gravity = 0.081, 9.81
    ball = Ball(0.119, 591e3, 0.45, 700, np.sqrt(2 * gravity * fall), gravity)
    found, center = impact(out), table(out / "probes.csv")["ball.center_y"]
    return [
        Figure("touch", "ms", 1e3 * np.sqrt(2 * fall / gravity), 1e3 * found["start"], 1e-3),
        Figure("contact lasts", "ms", 1e3 * ball.duration, 1e3 * found["duration"], 0.18),
        Figure("largest force", "N", ball.force, largest_force(out), 0.18),
        Figure("approach of the centre of mass", "mm", 1e3 * ball.approach, 1e3 * (center[0] - center.min() - fall), 0.18),
    ]


def copper_bar(slender: Path, real: Path) -> list[Figure]:
    length, radius, young, density, speed = 32.4e-3, 3.2e-3, 117e9, 8930, 227
    c, start = np.sqrt(young / density), 1e-3 / speed
    at_end = []
    for out in (slender, real):
        energy = json.loads((out / "run.json").read_text())["energy"]
        at_end.append(energy["kinetic_at_end"] + energy["elastic_at_end"])
    after = json.loads((slender / "run.json").read_text())["impact"]["velocity_after"][1]
    force = density * c * speed * np.pi * radius**2
    return [
        Figure("contact lasts, ν = 0", "µs", 2e6 * length / c, 1e6 * impact(slender)["duration"], 1e-2),
        Figure("force, ν = 0", "kN", force / 1e3, mean_force(slender, start, start + 2 * length / c) / 1e3, 5e-3),
        Figure("velocity of the rebound, ν = 0", "m/s", speed, after, 1e-2),
        Figure("energy after the impact, ν = 0", "J", 239.61, at_end[0], 2e-3),
        Figure("energy after the impact, ν = 0.35", "J", 239.61, at_end[1], 2e-3),
    ]


def cone(out: Path) -> list[Figure]:
    slope, depth, modulus = 0.01, 3.14159265e-4, 1e9 / (1 - 0.3**2)
    radius = 2 * depth / (np.pi * slope)
    contact = table(out / "contact.csv")
    last = contact["step"] == contact["step"][-1]
    x, force = contact["x"][last], contact["force"][last]
    middle = np.argmin(abs(x - radius / 2))
    # The second moment of Sneddon's pressure is P a²/3.
    return [
        Figure("force", "N", np.pi * radius**2 * modulus * slope / 2, force.sum(), 1.5e-2),
        Figure("radius of the contact", "mm", 1e3 * radius, 1e3 * np.sqrt(3 * (x**2 * force).sum() / force.sum()), 1e-2),
        Figure("pressure at half of the radius", "MPa", modulus * slope / 2 * np.arccosh(radius / x[middle]) / 1e6,
               contact["pressure"][last][middle] / 1e6, 2e-2),
    ]  # fmt: skip


TUBE_RATIOS = (0.3, 0.49, 0.499, 0.4999)


def tube(*outs: Path) -> list[Figure]:
    inner, outer, young = 3, 9, 1000
    found = []
    for poisson, out in zip(TUBE_RATIOS, outs):
        factor = (1 + poisson) * inner**2 / (young * (outer**2 - inner**2))
        moved = factor * (outer**2 / inner + (1 - 2 * poisson) * inner)
        probe = table(out / "probes.csv")
        found.append(Figure(f"displacement inside, ν = {poisson:g}", "mm", 1e3 * moved, 1e3 * probe["inside.displacement_x"][-1], 5e-4))
        if poisson == 0.49:
            found += [
                Figure("displacement outside, ν = 0.49", "mm", 1e3 * factor * (2 - 2 * poisson) * outer,
                       1e3 * probe["outside.displacement_x"][-1], 5e-4),
                Figure("force of the upper end, ν = 0.49", "N", 2 * np.pi * poisson * inner**2,
                       probe["upper.reaction_y"][-2:].mean(), 5e-4),
            ]  # fmt: skip
    return found


def root(of: Callable[[float], float], low: float, high: float) -> float:
    """The root of a function that changes its sign once between two numbers."""
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if of(low) * of(middle) <= 0 else (middle, high)
    return low


def frequencies(t: np.ndarray, signal: np.ndarray, modes: int) -> np.ndarray:
    """Hz, of the undamped vibrations in a record whose amplitude is above a thousandth of the largest, by a matrix pencil."""
    stride = max(1, len(t) // 400)
    t, signal = t[::stride], signal[::stride]
    windows = np.lib.stride_tricks.sliding_window_view(signal, len(signal) // 2)
    space = np.linalg.svd(windows, full_matrices=False)[2][: 2 * modes].T
    factors = np.linalg.eigvals(np.linalg.lstsq(space[:-1], space[1:], rcond=None)[0])
    amplitude = abs(np.linalg.lstsq(factors ** np.arange(len(signal))[:, None], signal, rcond=None)[0])
    return np.angle(factors[amplitude > 1e-3 * amplitude.max()]) / (2 * np.pi * (t[1] - t[0]))


def of_modes(t: np.ndarray, signal: np.ndarray, exact: dict[str, float], tolerance: float, modes: int = 20) -> list[Figure]:
    """Figures of frequencies, each beside the nearest one in a record."""
    found = frequencies(t, signal, modes)
    return [Figure(name, "Hz", one, found[np.argmin(abs(found - one))], tolerance) for name, one in exact.items()]


def sphere(out: Path) -> list[Figure]:
    inner, outer, young, poisson, density = 1.8, 6, 200e9, 0.3, 8000
    c, share = np.sqrt(young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson) * density)), poisson / (1 - poisson)

    def stress(r: float, k: float) -> np.ndarray:
        """Radial stress at r of the displacements j₁(k r) and y₁(k r), relative to the modulus."""
        z = k * r
        zero = np.array([np.sin(z), -np.cos(z)]) / z
        one = np.array([np.sin(z) / z - np.cos(z), -np.cos(z) / z - np.sin(z)]) / z
        return k * (zero - 2 * one / z) + 2 * share * one / r

    free = lambda frequency: np.linalg.det([stress(r, 2 * np.pi * frequency / c) for r in (inner, outer)])  # noqa: E731
    ranges = ((300, 500), (700, 1000), (1300, 1600), (2000, 2300))
    probe = table(out / "probes.csv")
    return of_modes(probe["time"], probe["inside.displacement_x"],
                    {f"frequency {i + 1}": root(free, *range) for i, range in enumerate(ranges)}, 2e-3)  # fmt: skip


def bessel(order: int, x: complex) -> complex:
    """The Bessel function of the first kind, by its integral over a period, which 100 points give to rounding for small |x|."""
    angle = 2 * np.pi * np.arange(100) / 100
    return np.cos(order * angle - x * np.sin(angle)).mean()


DISC_RUNS = (
    {"mesh.model": "plane-stress"},
    {"mesh.model": "axisymmetric", "mesh.file": "disc-section.geo", "initial.velocity": ["x", "0"]},
    {"mesh.model": "plane-strain"},
)


def disc(*outs: Path) -> list[Figure]:
    young, poisson, density = 200e9, 0.3, 7800
    plate = np.sqrt(young / (density * (1 - poisson**2))), poisson
    slice_of = np.sqrt(young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson) * density)), poisson / (1 - poisson)
    found = []
    for out, name, (c, share) in zip(outs, ("plate", "plate, revolved", "long cylinder"), (plate, plate, slice_of)):
        roots = [root(lambda x: x * bessel(0, x) - (1 - share) * bessel(1, x), *range) for range in ((1.5, 3), (4.5, 6.5))]
        probe = table(out / "probes.csv")
        exact = {f"{name}, frequency {i + 1}": x * c / (2 * np.pi) for i, x in enumerate(roots)}
        found += of_modes(probe["time"], probe["rim.displacement_x"], exact, 1e-3)
    return found


def ringing_rod(out: Path) -> list[Figure]:
    length, radius, young, poisson, density = 1, 0.05, 200e9, 0.3, 7800
    bar = np.sqrt(young / density) / (2 * length)
    pressure_wave = np.sqrt(young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson) * density))
    shear_wave = np.sqrt(young / (2 * (1 + poisson) * density))

    def free(frequency: float, k: float) -> float:
        """Pochhammer's equation, p being imaginary, divided by q."""
        p, q = (np.emath.sqrt((2 * np.pi * frequency / c) ** 2 - k**2) for c in (pressure_wave, shear_wave))
        a, b = p * radius, q * radius
        return (2 * p / radius * (q**2 + k**2) * bessel(1, a) * bessel(1, b) - (q**2 - k**2) ** 2 * bessel(0, a) * bessel(1, b)
                - 4 * k**2 * p * q * bessel(1, a) * bessel(0, b)).real  # fmt: skip

    exact = {f"frequency {n}": root(lambda x: free(x, n * np.pi / length), 0.95 * n * bar, 1.0001 * n * bar) for n in (1, 3, 5)}
    probe = table(out / "probes.csv")
    return of_modes(probe["time"], probe["end.displacement_y"], {"frequency 1 of a bar, c/2L": bar} | exact, 1e-3)


def membrane(out: Path) -> list[Figure]:
    across = {"frequency 1": 44.623, "frequency 2": 130.03, "frequency 4": 246.05, "frequency 5": 379.90}
    along = {"frequency 3": 162.70, "frequency 6": 391.44}
    probe = table(out / "probes.csv")
    found = [figure for exact, name in ((across, "y"), (along, "x"))
             for figure in of_modes(probe["time"], probe[f"tip.displacement_{name}"], exact, 1e-3)]  # fmt: skip
    return sorted(found, key=lambda figure: figure.name)


def ellipse(out: Path) -> list[Figure]:
    nodes, cells, stress = stored(out, "state", "stress")
    across = stress[-2:].mean(axis=0).reshape(len(cells), 9)[:, 4]
    x, y = (nodes[cells[:, :3]][:, :, :2].mean(axis=1) - [2, 0]).T
    near = np.hypot(x, y) < 0.06
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    return [Figure("stress at D", "MPa", 92.7, np.linalg.lstsq(terms[near], across[near], rcond=None)[0][0] / 1e6, 3e-3)]


def cavity(out: Path) -> list[Figure]:
    radius, load, young, poisson, density = 1, 1e6, 60e9, 0.25, 2625
    shear = young / (2 * (1 + poisson))
    c, slow = np.sqrt(young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson) * density)), np.sqrt(shear / density)
    decay = 2 * slow**2 / (c * radius)
    ring = np.sqrt((2 * slow / radius) ** 2 - decay**2)
    probe = table(out / "probes.csv")
    t, found = probe["time"], 2e6 * probe["wall.displacement_y"]
    static = 1e6 * load * radius / (4 * shear)
    exact = static * (1 - np.exp(-decay * t) * (np.cos(ring * t) - decay / ring * np.sin(ring * t)))
    return [
        Figure("largest displacement of the wall", "µm", exact.max(), found.max(), 5e-3),
        Figure("displacement of the wall at 2.5 ms", "µm", exact[-1], found[-1], 5e-3),
        Figure("error of the displacement over time, in L2", "", 0, np.linalg.norm(found - exact) / np.linalg.norm(exact), 5e-3),
    ]


FRONTS = """The touch is resolved to one step. Dispersion spreads wave fronts over some elements (with the order 2/3 of the element
size), by which contact ends about 1 % early or late, and its impulse is wrong by as much."""
SOLID_TEXT = """The branch has half of the instantaneous shear modulus G₀, a fifth of the bulk modulus K₀ and the time t₁ = 1 s, with E₀
= 1 kPa and ν₀ = 0.3. The block cannot move sideways, so that its modulus is M = K + 4 G/3, at first M₀ = 1,346 Pa, in the end M∞ = 923
Pa. The scheme is dynamic; the block is so light (0.1 g/m³, waves cross it within 0.3 ms) that its inertia is below 1e-6 of the stress.
A jump would make it ring: the {what} rises within 0.5 s as (1 − cos 2πt)/2."""

CASES = [
    Case(
        "truss", "A truss hits a rigid wall",
        """A truss of 2 m, 0.2 m², E = 200 GPa and 7,800 kg/m³ flies at 1.5 m/s onto a rigid wall 1 mm away. Its plane model is a strip
        with ν = 0.""",
        """Abaqus Benchmarks Manual, 1.3.15, *Truss impact on a rigid wall*: touch at 6.67e-4 s, contact for 7.9e-4 s, force 11.8 MN,
        momentum 9,360 kg m/s. These are the closed forms d/v, 2L/c, ρ c v A and 2ρ L A v with c = √(E/ρ) = 5,064 m/s. (The manual has
        c+v in place of c, 0.03 % more, which small strain leaves out.)""",
        "closed form", FRONTS, truss),
    Case(
        "rod", "A dropped rod lands on its end",
        """A steel rod of 254 mm and 25.4 mm diameter, E = 200 GPa and 7,850 kg/m³, is dropped from 1 m and lands on its end at 4.43
        m/s. Its model in space is a prism of 12 sides with the rod's area, and ν = 0.""",
        """M. Ozen's example of a drop test (SimuTech), by the theory of waves in a rod: contact for 2L/c = 0.1006 ms, force ρ c v A =
        88.9 kN, stress ρ c v = 175 MPa, under which the whole rod is at rest after 50.3 µs.""",
        "closed form", FRONTS + " The stress is the mean over the lower half of the rod.", rod),
    Case(
        "clamped-bar", "A clamped bar hits an obstacle again and again",
        """A bar of 1 m with the wave speed 1 m/s, clamped at its upper end, is released from the uniform compression u = (1 − y)/2. Its
        lower end moves down at 0.5 m/s, touches after 1 s, rests for 1 s and returns within 1 s.""",
        """The program demo_dynamic_contact_1D of GetFEM has this problem and its solution by characteristics: the period is 3 s; in its
        three seconds the gap is (1 − t)/2, 0 and (t − 2)/2, and the stress in contact is 0.5 Pa.""",
        "closed form",
        """Fronts run through the bar for 12 s. They spread on the way, and the gap's error grows, with the order 2/3 of the element
        size. Contact takes the kinetic energy of the nodes that hit.""",
        clamped_bar),
    Case(
        "roller", "A rigid roller is pressed into a block",
        """An aluminium block (E = 70 GPa, ν = 0.3), 200 mm wide and high, is pressed with 35 kN per mm of its depth against a rigid
        roller of 50 mm radius. Viscosity damps the motion, so that the block is at rest in the end. The scene has half of it.""",
        """NAFEMS R0094, *Advanced Finite Element Contact Benchmarks*, CB1, whose roller is of steel. For a rigid roller Hertz's theory
        gives the half-width a = √(4 P R (1 − ν²)/(π E)) = 5.382 mm and the pressure 2 P/(π a) = 4,140 MPa.""",
        "closed form",
        """Hertz replaces the circle by a parabola, the program the obstacle's normals by those at the undeformed nodes; each changes
        the figures by about (a/R)² = 1.2 %. The block is 37 half-widths wide.""",
        roller),
    Case(
        "hammered-bar", "A hammer strikes a bar with an absorbing end",
        """A hammer moves the upper end of an elastic bar, 1 m wide, by 3 cm within 0.2 s and goes back. The lower end is an absorbing
        boundary.""",
        """The bar behaves like an endless one: the force is Z v with Z = ρ c = 30 N s/m³ and the speed v of the hammer, the impulse is
        0.9 N s/m and the work ∫ Z v² dt. The whole work leaves through the lower end (Lysmer, Kuhlemeyer 1969).""",
        "closed form",
        """The force of contact-stabilized steps lags behind the hammer by about a quarter of the time in which a wave crosses an
        element, an error of the first order. The energy that is left in the bar falls at least with the square of the element size.""",
        hammered_bar, tuple({"mesh.size": size, "time.step": size / 60} for size in SIZES), "../../scenes/hammered-bar.toml"),
    Case(
        "bar-on-springs", "A bar swings on springs",
        """An elastic bar of 10 m and 10 kg/m stands on springs of 9 N/m³ and swings up and down in its first mode.""",
        """With x tan x = k L/E the mode is cos(x (1 − y/L)) and its frequency x c/L; here x = 0.31105. To first order the bar yields
        like a third of its length in series with the springs. A rigid bar has √(k/m).""",
        "closed form",
        """A step is a hundredth of the period, by which Newmark's scheme is slow by (ωτ)²/12 = 0.03 %. A rigid bar is faster by k L/(6
        E) = 1.7 %.""",
        bar_on_springs, scene="../../scenes/bar-on-springs.toml"),
    Case(
        "relaxation", "Stress relaxes at a fixed strain",
        "A block of a standard linear solid (one branch) is stretched by 1 % and held there. " + SOLID_TEXT.format(what="strain"),
        """σ = M∞ ε + (M₀ − M∞) q with q̇ = ε̇ − q/t₁, in closed form for this rise. At fixed strain q falls as exp(−t/t₁).""",
        "closed form",
        """The midpoint rule integrates the branch with steps of a fiftieth of its time: second order, 3e-5. Stresses are those of a
        step, beside the means of the exact ones at its ends.""",
        relaxation),
    Case(
        "creep", "Strain creeps at a fixed stress",
        "A block of a standard linear solid (one branch) is loaded by 10 Pa, and the load stays. " + SOLID_TEXT.format(what="load"),
        """ε = σ/M∞ − (1/M∞ − 1/M₀) r with ṙ = σ̇ − r/t₂, in closed form for this rise. The time of retardation t₂ = t₁ M₀/M∞ = 1.458 s
        is longer than that of relaxation.""",
        "closed form",
        """As for relaxation. Displacements are means of two successive times, beside the exact means over the step: next to no inertia
        leaves a ripple that alternates from step to step.""",
        creep),
    Case(
        "bar-impact", "A bar hits a plane",
        """An elastic bar of 10 m, 1 m wide, with E = 900 Pa and 1 kg/m³, flies upright onto a plane at 10 m/s.""",
        """D. Doyen, A. Ern, S. Piperno, SIAM J. Sci. Comput. 33 (2011): the bar touches at 0.5 s, rests and pushes with ρ c v = 300 N/m
        for 2L/c = 2/3 s, and leaves undeformed at its speed.""",
        "closed form",
        FRONTS + """ The rebound is wrong by twice as much as the impulse. Contact takes at most the kinetic energy of the nodes that
        hit, that of half an element: 1/160. The force is the mean over two steps, averaged over the middle half of the contact.""",
        bar_impact, scene="../../scenes/bar-impact.toml"),
    Case(
        "bouncing-bar", "A bar bounces under its weight",
        """The bar that [hits a plane](bar-impact.md) falls from rest under 10 N/m³ and touches the plane after 1 s, with 10 m/s.
        The run ends shortly before the bar is at its height again, at 16/3 s.""",
        """D. Doyen, A. Ern, S. Piperno (2011): from 1 to 5/3 s the bar rests on the plane, and the force grows from 300 to 500 N/m. It
        flies vibrating. The second contact, from 11/3 to 13/3 s, is the first one backwards. Each impulse is 800/3 N s/m.""",
        "closed form",
        """As for the single impact. The vibration brings the second touch. The gap has the error of the wave fronts, of the order
        2/3 of the element size.""",
        bouncing_bar, tuple({"mesh.size": size, "time.step": size / 20, "time.end": 5.25} for size in BOUNCING_SIZES),
        "../../scenes/bouncing-bar.toml"),
    Case(
        "standing-wave", "A standing wave",
        """A bar that is clamped at one end rings in its first mode for one period, without contact. Runs with elements of degree 1 and
        2.""",
        """u = 0.1 m sin(π y/20) cos(1.5 π t): the bar is 10 m long, and its waves run at 30 m/s.""",
        "closed form",
        """Steps and linear elements are of second order. Quadratic elements carry waves with an error of the fourth order at their
        nodes: with steps in proportion to the square of the element size the error falls with the fourth order.""",
        standing_wave,
        tuple({"mesh.degree": degree, "mesh.size": size, "time.step": 4 / 3 / count}
              for degree in (1, 2) for size, count in WAVE_RUNS[degree]),
        "../../scenes/standing-wave.toml"),
    Case(
        "hertz-press", "A half disc is pressed onto a plane",
        """A half disc of 8 m, with E = 200 Pa and ν = 0.3 in plane strain, is pressed onto a plane with 10 N per metre of depth until
        it rests.""",
        """H. Hertz (1882): the pressure p₀ √(1 − (x/a)²) with a = 2 √(P R (1 − ν²)/(π E)) = 0.681 m and p₀ = 2 P/(π a) = 9.35 N/m².""",
        "closed form",
        """Hertz takes the disc for a half-space and its circle for a parabola, wrong by (a/R)² = 0.7 %. The mesh finds the ends of
        contact to within an element h = a/10: half-width and largest pressure are wrong by (h/a)² more, the profile in L2 by h/a.""",
        hertz_press, ({"output.every": 1},), "../../scenes/hertz-press.toml"),
    Case(
        "patch", "The patch test of contact",
        """A block of 1 m with ν = 0.3 is pressed onto a plane until it is 5 % shorter. Its sides are free, and its top slides. Runs in
        plane strain, in plane stress and, for a cylinder of radius 1 m, in axial symmetry; the mesh is unstructured.""",
        """Stress is uniform: the pressure is 0.05 E = 10 N/m², in plane strain 0.05 E/(1 − ν²) = 10.99 N/m², at every node. The
        force of the cylinder is 10 π N.""",
        "closed form",
        """A uniform strain is in each space, so that only rounding is left. At rest forces of successive steps alternate by 2e-6, and
        their mean is taken.""",
        patch, tuple({"mesh.model": model} for model in MODELS)),
    Case(
        "steel-ball", "A steel ball hits a plane",
        """A steel ball of 1 kg (R = 31.28 mm, E = 200 GPa, ν = 0.3) that was dropped from 0.5 m hits a rigid plane at 3.13 m/s. A
        second run is 32 times slower. The model is axially symmetric.""",
        """Hertz's theory of impact: F = K δ^(3/2) with K = 4/3 √R E/(1 − ν²), the largest approach δ = (5 m v²/(4 K))^(2/5) = 0.141 mm,
        contact for 2.943 δ/v = 132.6 µs, force 86.87 kN. The contact has the radius a = √(R δ) = 2.1 mm.""",
        "closed form",
        """Hertz measures the approach from infinity. At the distance R the half-space still moves, by (2/3π)(3 − 2ν)/(1 − ν) a/R = 0.73
        a/R of δ. This makes the ball stiffer, by which force and duration change by 0.44 a/R: 2.9 % and, in the slow run, 0.7 %. The
        tolerance is a/2R. In the limit a/R → 0, by both runs, the theory is exact. The duration is resolved to one step (0.2 %), and
        the polygon has 0.12 % less mass than the ball.""",
        steel_ball, ({}, {"initial.velocity": ["0", f"{-STEEL.speed / SLOW:.8g}"], "time.step": 5e-7, "time.end": 3e-4})),
    Case(
        "soft-ball", "A soft ball falls to the floor",
        """A ball of R = 0.119 m, E = 591 kPa, ν = 0.45 and 700 kg/m³ falls 81 mm to the floor, which it meets at 1.26 m/s. Scene of
        PolyFEM's data (a bouncing ball).""",
        """Free fall, then Hertz's theory of impact with the weight: m δ̈ = m g − K δ^(3/2). Without the weight it gives 35.6 ms, 643 N
        and 15.3 mm.""",
        "closed form, of first order in a/R",
        """The approach is 14 % of R and the radius of contact a = 0.37 R. As for the steel ball the tolerance is a/2R: the case is a
        bound. Strains reach 19 %, which a warning reports.""",
        soft_ball),
    Case(
        "copper-bar", "A metal bar hits a rigid wall",
        """A copper bar of 32.4 mm and 6.4 mm diameter, with E = 117 GPa, ν = 0.35 and 8,930 kg/m³, hits a rigid wall at 227 m/s and
        stays elastic. The model is axially symmetric, its contact nodes have no mass. The first run has ν = 0.""",
        """Ansys Technology Showcase, *Impact of a metal bar on a rigid wall*: a rigid bar leaves at 227 m/s with 239.61 J. There,
        contact without impact constraints made 383 m/s and 683 J of it. An elastic bar without lateral contraction leaves as a rigid
        one: contact lasts 2L/c with the force ρ c v A, and no vibration is left.""",
        "closed form",
        FRONTS + """ The stated data give 239.8 J, 0.1 % more than the published energy. With ν = 0.35 lateral vibration keeps a part of
        the energy; only the sum is compared. Strains reach 12 %, which a warning reports.""",
        copper_bar, ({"material.poisson": 0.0}, {})),
    Case(
        "cone", "A cone is pressed into a block",
        """A rigid cone with a slope of 1 : 100, a signed distance, moves 0.314 mm into a block with E = 1 GPa and ν = 0.3, until it
        rests. The model is axially symmetric.""",
        """I. N. Sneddon, Int. J. Engng. Sci. 3 (1965), for a half-space: contact of the radius a = 2 δ/(π β) = 20 mm for the depth δ
        and the slope β, pressure E β arcosh(a/r)/(2 (1 − ν²)), force π a² E β/(2 (1 − ν²)).""",
        "closed form",
        """The block is 160 times as large as the contact. This makes it stiffer by (1 − ν²) P/(π E H δ) = 0.2 %, the force larger by
        twice as much. The surface also moves towards the axis, which Sneddon's condition neglects: (1 − 2ν) β/(2 − 2ν) = 0.3 % of the
        force (Hay, Bolshakov, Pharr 1999). An element is a/20.""",
        cone),
    Case(
        "tube", "A thick tube under pressure",
        """A tube with the radii 3 and 9 m, E = 1,000 Pa and a pressure of 1 Pa inside cannot stretch along its axis. Poisson's ratios
        up to nearly 0.5. The model is axially symmetric, of degree 2.""",
        """R. H. MacNeal, R. L. Harder, *A proposed standard set of problems to test finite element accuracy* (1985): 5.0399, 5.0602 and
        5.0623 mm for ν = 0.49, 0.499 and 0.4999, from Lamé's solution.""",
        "closed form",
        """Degree 2 does not lock: the error is below 0.02 % for each ν. Inertia is below 1e-4 of the stress.""",
        tube, tuple({"material.poisson": poisson} for poisson in TUBE_RATIOS)),
    Case(
        "sphere", "A hollow sphere breathes",
        """A thick hollow sphere with the radii 1.8 and 6 m, E = 200 GPa, ν = 0.3 and 8,000 kg/m³ begins to move with a radial velocity.
        The model is axially symmetric, of degree 2; a matrix pencil finds the frequencies in the displacement inside.""",
        """NAFEMS FV42, *Thick hollow sphere: uniform radial vibration*: 369.91, 838.03, 1451.2 and 2117.0 Hz. These are roots of the
        closed form by spherical Bessel functions, computed here.""",
        "closed form",
        """The inner sphere is a polygon with edges h = R/10, by (h/R)²/12 = 0.08 % smaller in the mean. Newmark's steps make the fourth
        mode slow by (ωτ)²/12 = 0.02 %.""",
        sphere),
    Case(
        "disc", "A disc breathes",
        """A free disc of 1 m radius, E = 200 GPa, ν = 0.3 and 7,800 kg/m³, expands uniformly at first. Runs in plane stress (a plate),
        as a plate of 2 cm thickness in axial symmetry, and in plane strain (a long cylinder).""",
        """The displacement is J₁(k r), and x = k R solves x J₀(x) = (1 − ν) J₁(x): 2.0488, 5.3894 (A. E. H. Love, *A Treatise on the
        Mathematical Theory of Elasticity*). Waves run at √(E/(ρ (1 − ν²))). In plane strain the speed is that of pressure waves, and
        ν/(1 − ν) stands in place of ν.""",
        "closed form",
        """The rim is a polygon with edges of 5 cm, by 0.02 % smaller in the mean. Newmark's steps make the second mode slow by (ωτ)²/12
        = 0.01 %. The thickness of the plate changes its frequencies by 1e-5.""",
        disc, DISC_RUNS),
    Case(
        "ringing-rod", "A rod rings",
        """A free steel rod of 1 m and 10 cm diameter, with ν = 0.3, rings along its length. The model is axially symmetric.""",
        """Long waves run at the speed of a bar, c = √(E/ρ), shorter ones slower. Mode n has the wave number n π/L, and Pochhammer's
        equation for waves in a cylinder (1876; Chree 1889) gives its frequency, 0.06 %, 0.5 % and 1.5 % below n c/2L.""",
        "closed form",
        """Newmark's steps make the fifth mode slow by (ωτ)²/12 = 0.05 %. Pochhammer's waves leave a little shear stress on the flat
        ends.""",
        ringing_rod),
    Case(
        "membrane", "A tapered membrane vibrates",
        """A membrane of 10 m, 5 m wide at its clamped root and 1 m at its tip, with E = 200 GPa, ν = 0.3 and 8,000 kg/m³, vibrates in
        its plane, in plane stress. A matrix pencil finds the frequencies in the displacement of the tip.""",
        """NAFEMS FV32, *Cantilevered tapered membrane*: six frequencies, of a converged computation.""",
        "published",
        """Newmark's steps make the sixth mode slow by (ωτ)²/12 = 0.03 %; the published figures have four digits.""",
        membrane),
    Case(
        "ellipse", "An elliptic membrane",
        """An elliptic plate with an elliptic hole, of E = 210 GPa and ν = 0.3, has a tension of 10 MPa on its outer edge. A quarter of
        it, in plane stress, of degree 2.""",
        """NAFEMS LE1, *Elliptic membrane*: the tangential stress at the point D = (2, 0) of the inner edge is 92.7 MPa.""",
        "published",
        """A quadratic through the means of the cells within 6 cm gives the stress at the edge. The mesh makes it 0.1 % too large, an error
        of the second order. The reference has three digits.""",
        ellipse),
    Case(
        "cavity", "A pressure rises in a cavity",
        """A pressure of 1 MPa rises suddenly in a spherical cavity of 1 m radius in a large solid with E = 60 GPa, ν = 0.25 and 2,625
        kg/m³. The model is axially symmetric and reaches to 9 m; it ends before a wave returns from there.""",
        """The potential f(t − (r − a)/c)/r of the spherical wave obeys f̈ + 2η ḟ + ω² f = −p a/ρ with ω = 2 c_s/a and η = 2 c_s²/(c a):
        the wall overshoots p a/(4 G) by 26 % and rings (J. A. Sharpe 1942, F. G. Blake 1952).""",
        "closed form",
        """The jump of the pressure excites waves that the mesh does not resolve. They ripple the displacement by 0.2 %, on finer meshes by
        less. The displacement is twice the mean of its axial component over the half sphere.""",
        cavity),
    *WITH_FRICTION,
    *WITH_MASS, *OF_PARTS,
    *OBLIQUE,
]  # fmt: skip


def options(run: dict[str, object]) -> str:
    """Options of the command line, numbers with ten digits."""
    return "".join(f" --set {key}={value:.10g}" if isinstance(value, int | float) else " --set " + shlex.quote(f"{key}={toml(value)}")
                   for key, value in run.items())  # fmt: skip


def commands(case: Case) -> str:
    path = (PAGES / case.file).resolve().relative_to(HERE.parent)
    many = len(case.runs) > 1
    return "".join(f"signorini simulate {path}{options(run)}" + (f" --out results/{case.name}-{i + 1}" if many else "") + "\n"
                   for i, run in enumerate(case.runs))  # fmt: skip


def run(case: Case, folder: Path) -> list[Figure]:
    """Makes the runs of a case below `folder`."""
    outs = [folder / f"{case.name}-{i + 1}" for i in range(len(case.runs))]
    for out, overrides in zip(outs, case.runs):
        signorini("simulate", PAGES / case.file, out, **{key.replace(".", "__"): value for key, value in overrides.items()})
    return case.figures(*outs)


def rows(lines: list[list[str]]) -> str:
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def page(case: Case, figures: list[Figure], seconds: float) -> str:
    head = ["figure", "reference", "got", "deviation", "tolerance"]
    texts = [f"**Problem.** {case.problem}", f"**Reference** ({case.kind}). {case.reference}", f"**Tolerance.** {case.tolerance}"]
    prose = "\n\n".join(textwrap.fill(" ".join(text.split()), 140) for text in texts)
    return (f"# {case.title}\n\n{prose}\n\n" + rows([head, ["---"] * len(head), *(figure.cells() for figure in figures)])
            + f"\nSeconds: {seconds:.1f}.\n\n```sh\n{commands(case)}```\n\n```{{literalinclude}} {case.file}\n```\n")  # fmt: skip


def index(pages: dict[str, str]) -> str:
    """The page of all cases, from their pages."""
    head = ["case", "figure", "kind", "reference", "got", "deviation", "tolerance", "seconds"]
    lines = [head, ["---"] * len(head)]
    for case in CASES:
        seconds = re.search(r"(?m)^Seconds: (\S+)\.$", pages[case.name])[1]
        for i, (name, *numbers) in enumerate(cells(pages[case.name])):
            first = [f"[{case.title}]({case.name}.md)", name, case.kind, *numbers, seconds]
            lines.append(first if i == 0 else ["", name, "", *numbers, ""])
    return f"""# Verification

These cases compare the program with closed forms, many of them those of published examples, and with published values. Each page has the
problem, the reference and its kind, the tolerance with its reason, what was got, the command and the scene. A test runs every case and
compares it with its page (`tests/regression/manual.py`); `./dev exec python3 docs/verification.py` writes the pages anew. Deviations are
relative to the reference, and absolute where it is 0. Seconds are those of all runs of a case, with the program's start, on a 2-core
virtual machine.

{rows(lines)}
Other tests compare scenes with known solutions too: Hertz's pressure, bars that bounce, patch tests, discs
([Accuracy](../measurements/accuracy.md), [Hard cases](../measurements/hard-cases.md)).

```{{toctree}}
:hidden:

{chr(10).join(case.name for case in CASES)}
```
"""


def cells(text: str) -> list[list[str]]:
    """The rows of a page's table: figure, reference, got, deviation, tolerance."""
    return [line.strip("|\n ").split(" | ") for line in re.findall(r"(?m)^\| .*\|$", text)[2:]]


def main() -> None:
    names = sys.argv[1:] or [case.name for case in CASES]
    for case in (case for case in CASES if case.name in names):
        with tempfile.TemporaryDirectory() as folder:
            start = time.monotonic()
            figures = run(case, Path(folder))
            (PAGES / f"{case.name}.md").write_text(page(case, figures, time.monotonic() - start))
        for figure in figures:
            print(f"{case.name}: {', '.join(figure.cells())}{'' if figure.holds else '   OUTSIDE'}", flush=True)
    (PAGES / "index.md").write_text(index({case.name: (PAGES / f"{case.name}.md").read_text() for case in CASES}))


if __name__ == "__main__":
    main()
