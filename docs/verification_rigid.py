# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases of the verification manual with obstacles that have mass (docs/verification.py)."""

from pathlib import Path

import numpy as np
from harness import table
from verification_case import Case, Figure

HAMMERS = (1, 2, 4, 6)  # mass of the hammer / mass of the bar
# End of contact, largest force on the hammer and largest force at the clamp, with the times at which fronts bring these: L/c and ρ c v A.
SAINT_VENANT = {1: (3.0677, 2.1353, 2.2707, 2, 3), 2: (4.7086, 2.3679, 2.7358, 2, 3), 4: (5.8996, 2.9744, 3.2131, 4, 3),
                6: (7.4076, 3.4688, 3.5045, 4, 5)}  # fmt: skip
BEHIND, AHEAD = 0.1, 0.05  # of fronts, which the mesh smears


def saint_venant(*outs: Path) -> list[Figure]:
    found = []
    for mass, out in zip(HAMMERS, outs):
        probe = table(out / "probes.csv")
        t = (probe["time"][1:] + probe["time"][:-1]) / 2  # middles of steps
        hammer, clamp = probe["hammer.force_x"][1:] / 5e-4, -probe["far.reaction_x"][1:] / 5e-4
        scale = np.exp(t / mass)  # between fronts forces are polynomials times exp(−t/mass)

        def behind(force: np.ndarray, front: float, until: float) -> np.poly1d:
            there = (t > front + BEHIND) & (t < until - AHEAD)  # noqa: B023
            return np.poly1d(np.polyfit(t[there] - front, (force * scale)[there], 2))  # noqa: B023

        end, most, at_clamp, front, clamp_front = SAINT_VENANT[mass]
        last = 2 * np.floor(end / 2)
        gone = t[1:][(hammer[1:] < 1e-9) & (hammer[:-1] < 1e-9) & (t[1:] > last + 0.2)][0]
        roots = behind(hammer, last, gone).roots
        ended = last + min(root.real for root in roots if abs(root.imag) < 1e-9 and root.real > BEHIND)
        found += [
            Figure(f"contact ends, mass {mass}, L/c", "", end, ended, 5e-3),
            Figure(f"largest force on the hammer, mass {mass}, ρ c v A", "", most,
                   behind(hammer, front, min(front + 1, end))(0) * np.exp(-front / mass), 5e-3),
            Figure(f"largest force at the clamp, mass {mass}, ρ c v A", "", at_clamp,
                   behind(clamp, clamp_front, clamp_front + 1)(0) * np.exp(-clamp_front / mass), 5e-3),
        ]  # fmt: skip
    return found


def free_bar(*outs: Path) -> list[Figure]:
    found = []
    for mass, out in zip(HAMMERS, outs):
        probe = table(out / "probes.csv")
        hammer, bar = probe["hammer.velocity_x"][-1] / 0.01, probe["bar.momentum_x"][-1] / (0.05 * 0.01)
        after = float(np.exp(-2 / mass))
        t, force = probe["time"], probe["hammer.force_x"]
        found += [
            Figure(f"speed of the hammer afterwards, mass {mass}, v", "", after, hammer, 1e-2),
            Figure(f"speed of the bar afterwards, mass {mass}, v", "", mass * (1 - after), bar, 5e-3),
            Figure(f"contact lasts, mass {mass}, L/c", "", 2, float(t[np.flatnonzero(force > 0.05 * force.max())[-1]]), 2e-2),
        ]
    return found


def swinging_plate(out: Path) -> list[Figure]:
    mass, stiffness, damping, force = 2, 50, 2, 10
    decay, omega = damping / (2 * mass), np.sqrt(stiffness / mass - (damping / (2 * mass)) ** 2)
    probe, steps = table(out / "probes.csv"), table(out / "steps.csv")
    t, q = probe["time"], -probe["plate.displacement_y"]
    sag = force / stiffness
    exact = sag * (1 - np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t)))
    turn = int(np.argmax(q))
    return [
        Figure("largest displacement", "m", sag * (1 + np.exp(-np.pi * decay / omega)), float(q[turn]), 5e-3),
        Figure("time of it", "s", np.pi / omega, float(t[turn]), 5e-3),
        Figure("displacement over time, largest error / sag", "", 0, float(abs(q - exact).max() / sag), 5e-3),
        Figure("dissipated by the dashpot / work of the force", "",
               1 - stiffness * q[-1] / (2 * force) - mass * float(probe["plate.velocity_y"][-1]) ** 2 / (2 * force * q[-1]),
               float(steps["rigid_dissipation"].sum() / (force * q[-1])), 1e-4),
    ]  # fmt: skip


def crossing(t: np.ndarray, values: np.ndarray) -> float:
    """The first time at which a quantity falls through zero, linear between steps."""
    i = int(np.flatnonzero((values[1:] <= 0) & (values[:-1] > 0))[0])
    return float(t[i] + (t[i + 1] - t[i]) * values[i] / (values[i] - values[i + 1]))


class Fall:
    """A mass that has fallen onto a spring with a dashpot, in closed form, until the force on it vanishes."""

    def __init__(self, mass: float, gravity: float, stiffness: float, damping: float, gap: float, speed: float) -> None:
        self.touch = (np.sqrt(speed**2 + 2 * gravity * gap) - speed) / gravity
        self.speed = speed + gravity * self.touch
        matrix = np.array([[0, 1], [-stiffness / mass, -damping / mass]])
        rates, modes = np.linalg.eig(matrix)
        sag = mass * gravity / stiffness
        start = np.linalg.solve(modes, np.array([-sag, self.speed], dtype=complex))
        self.t = np.linspace(0, 2 * np.pi * np.sqrt(mass / stiffness), 200001)
        depth, self.velocity = (modes @ (start[:, None] * np.exp(np.outer(rates, self.t)))).real
        self.depth = depth + sag
        self.end = int(np.flatnonzero((stiffness * self.depth + damping * self.velocity)[1:] < 0)[0])

    @property
    def lasts(self) -> float:
        return float(self.t[self.end])


def spring(*outs: Path) -> list[Figure]:
    found = []
    for damping, out in zip((0.0, 5.0), outs):
        exact = Fall(1, 10, 100, damping, 2, 1)
        probe = table(out / "probes.csv")
        t, way, v = probe["time"], 1.5 + probe["block.center_y"], -probe["block.momentum_y"]  # mass 1
        force = probe["cell.force_y"]
        touch = crossing(t, way)
        pushed = force > 1e-6 * force.max()
        leaves = float(t[np.flatnonzero(pushed)[-1]])
        name = f"dashpot {damping:g} N s/m"
        found += [
            Figure(f"touch, {name}", "s", exact.touch, touch, 5e-3),
            Figure(f"speed then, {name}", "m/s", exact.speed, float(np.interp(touch, t, v)), 5e-3),
            Figure(f"depth, {name}", "m", exact.depth[: exact.end].max(), -way.min(), 5e-3),
            Figure(f"force lasts, {name}", "s", exact.lasts, leaves - touch, 5e-3),
            Figure(f"speed afterwards, {name}", "m/s", -exact.velocity[exact.end], -float(v[np.searchsorted(t, leaves) + 1]), 5e-3),
        ]
    return found


def flexible(out: Path) -> list[Figure]:
    exact = Fall(0.5, 386, 1973.92, 0, 1, 0)
    probe = table(out / "probes.csv")
    t, way = probe["time"], 0.5 + probe["block.center_y"]
    lowest = t[way.argmin()]
    return [
        Figure("touch", "s", exact.touch, crossing(t, way), 5e-3),
        Figure("time of the largest displacement", "s", exact.touch + exact.t[exact.depth[: exact.end].argmax()], float(lowest), 5e-3),
        Figure("displacement of the surface", "in", exact.depth[: exact.end].max(), -way.min(), 5e-3),
    ]


def ram(out: Path) -> list[Figure]:
    impedance, mass, speed = 6e6, 1.2e4, 4.0
    probe = table(out / "probes.csv")
    t, v, force = probe["time"], -probe["ram.velocity_y"], -probe["ram.force_y"]
    middle, exact = (t[1:] + t[:-1]) / 2, lambda x: impedance * speed * np.exp(-impedance * x / mass)
    count = 40  # steps in 0.2 ms, in which a wave passes twenty elements
    smooth = lambda f: np.convolve(f, np.ones(count) / count, "valid")  # noqa: E731
    off = smooth(force[1:] - exact(middle))
    around = abs(t - mass / impedance) < 1e-4
    return [
        Figure("force over time, error of its means over 0.2 ms in L2", "", 0, float(np.sqrt((off**2).sum() / (smooth(exact(middle)) ** 2).sum())), 5e-3),
        Figure("speed after m/Z, mean over 0.2 ms", "m/s", speed / np.e, float(v[around].mean()), 5e-3),
        Figure("way after m/Z", "mm", 1e3 * speed * mass / impedance * (1 - 1 / np.e), -1e3 * float(np.interp(mass / impedance, t, probe["ram.displacement_y"])), 5e-3),
        Figure("impulse until m/Z, mean over 0.2 ms", "kN s/m", mass * speed * (1 - 1 / np.e) / 1e3, float(-probe["ram.impulse_y"][around].mean()) / 1e3, 5e-3),
        Figure("part of the energy that the toe has absorbed at the end", "", 1 - np.exp(-2 * impedance * (t[-1] - 10 / 2500) / mass),
               float(table(out / "steps.csv")["foundation_dissipation"].sum() / (mass * speed**2 / 2)), 5e-3),
    ]  # fmt: skip


CASES = [
    Case(
        "saint-venant", "A hammer strikes a clamped bar",
        """A rigid hammer of 1, 2, 4 and 6 times the mass of an elastic bar strikes its end; the other end is clamped. Waves return again and
        again, until the hammer leaves the bar.""",
        """Saint-Venant's solution: between the times at which fronts arrive, the forces are polynomials times exp(−ρ c A t/m). The ends of
        contact and the largest forces, which fronts bring, are its exact values.""",
        "closed form",
        """320 elements smear fronts over 0.1 L/c. The largest forces are those behind the fronts: quadratic polynomials times exp(−ρ c A t/m),
        fitted to the force from 0.1 L/c behind the front to the next one. The end is the zero of such a fit.""",
        saint_venant, tuple({"contact.obstacle.mass": 0.05 * mass, "time.end": end} for mass, end in zip(HAMMERS, (4.0, 5.0, 6.25, 8.0)))),
    Case(
        "free-bar", "A hammer strikes a free bar",
        """A rigid hammer of 1, 2, 4 and 6 times the mass of an elastic bar strikes its end; the bar is free.""",
        """The wave comes back from the free end after 2 L/c and takes the bar away: until then the speed of the hammer falls as
        exp(−ρ c A t/m). The bar has what the hammer has lost, so that speeds afterwards are e^(−2 M/m) and m/M times the rest.""",
        "closed form",
        "The front that ends contact is smeared over some hundredths of L/c, which leaves 0.001 v to the hammer.",
        free_bar, tuple({"contact.obstacle.mass": 0.05 * mass} for mass in HAMMERS)),
    Case(
        "swinging-plate", "A plate on a spring and a dashpot",
        """A plate of 2 kg/m on a spring of 50 N/m/m and a dashpot of 2 N s/m/m is pushed by 10 N/m from t = 0 on.""",
        """A damped oscillator: the plate swings about its sag F/k with ω = √(k/m − (c/2m)²).""",
        "closed form",
        "A step is a 250th of the period: the trapezoidal rule is slow by (ωτ)²/12.",
        swinging_plate),
    Case(
        "cell-drop", "A mass falls on a spring",
        """A mass of 1 kg/m has a gap of 2 m and a speed of 1 m/s, g = 10 m/s², and falls on a load cell without mass: a spring of 100 N/m/m
        without and with a dashpot of 5 N s/m/m. Mass 0 is possible with springs.""",
        """The test V5.01.108 of code_aster: a mass on a spring, in closed form, until the force on it vanishes.""",
        "closed form",
        """The mass is an elastic block, 1e5 times as stiff as the spring. Times are resolved to half a step, 0.1 ms.""",
        spring, ({}, {"contact.obstacle.damping": 5.0})),
    Case(
        "flexible-surface", "A mass falls on a flexible surface",
        """ANSYS's verification case VM65, in its units (inches, pounds): a ball of 0.5 lbf s²/in falls from 1 in on a spring of 1973.92
        lbf/in, g = 386 in/s².""",
        """The ball touches after 0.07198 s; the largest displacement is 0.5507 in, after 0.10044 s.""",
        "closed form", "As in the case before.", flexible),
    Case(
        "ram", "A ram falls on a pile with an absorbing toe",
        """A ram of 12 t/m hits a pile, a wall of concrete 10 m high and 1 m thick, with 4 m/s. The toe absorbs waves.""",
        """An endless pile: the force is Z v exp(−Z t/m) with Z = ρ c A = 6e6 N s/m².""",
        "closed form",
        "Fronts are smeared over some elements, so that forces are compared as means over 0.2 ms, in which a wave passes twenty elements.",
        ram, scene="../../scenes/ram.toml"),
]  # fmt: skip
