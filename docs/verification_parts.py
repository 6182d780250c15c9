# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases of the verification manual with contact between two parts of the body (docs/verification.py)."""

import json
from pathlib import Path

import numpy as np
from harness import table
from verification_case import Case, Figure
from verification_oblique import partial_slip

# Of the bars: height, m; wave speed, m/s; gap, m; and of each run the impedances ρ c (N s/m³), the lengths (m).
HEIGHT, SPEED, GAP, MET = 0.1, 30.0, 0.01, 5.0
BARS = {"equal": (300, 300, 1, 1), "of impedances 3:2": (450, 300, 1, 1), "of lengths 1:2": (300, 300, 1, 2)}


def bars(*outs: Path) -> list[Figure]:
    found = []
    for (name, (left, right, short, other)), out in zip(BARS.items(), outs):
        z = np.array([left, right]) * HEIGHT
        force = z.prod() / z.sum() * 2 * MET
        steps, obstacles = table(out / "steps.csv"), table(out / "obstacles.csv")
        begin, lasts = GAP / (2 * MET), 2 * short / SPEED
        middle = abs(steps["time"] - begin - lasts / 2) < lasts / 4
        momentum = table(out / "bodies.csv")["momentum_x"].reshape(-1, 2)
        masses = z / SPEED * [short, other]
        v = MET * (z[0] - z[1]) / z.sum()  # of the ends in contact
        after = [2 * v - MET, (masses @ [MET, -MET] - masses[0] * (2 * v - MET)) / masses[1]]
        mean = -obstacles["force_x"][middle].mean()
        found += [
            Figure(f"force, {name}", "N/m", force, mean, 1e-4),
            Figure(f"impulse, {name}", "N s/m", force * lasts, -1 * (obstacles["force_x"][1:] @ np.diff(steps["time"])), 5e-3),
            Figure(f"velocity of the left bar after contact, {name}", "m/s", after[0], momentum[-1, 0] / masses[0], 1e-2),
            Figure(f"velocity of the right bar after contact, {name}", "m/s", after[1], momentum[-1, 1] / masses[1], 1e-2 if after[1] else 0.05),
            Figure(f"change of the momentum of both in 1728 steps / momentum of one, {name}", "", 0,
                   float(abs(momentum.sum(axis=1) - momentum[0].sum()).max() / momentum[0, 0]), 1e-10),
            Figure(f"momentum law of a step, residual / largest forces, {name}", "", 0, float(abs(steps["momentum_residual"]).max()), 1e-12),
        ]  # fmt: skip
    return found


AT = {2e-4: -1.05e-4, 4e-4: -1.55e-4, 6e-4: -5.54e-5, 8e-4: 9.92e-5, 1e-3: 2.99e-4}  # of SDNL111: s, m


def bar_on_bar(out: Path) -> list[Figure]:
    probe = table(out / "probes.csv")
    return [Figure(f"displacement of the end at {1e3 * t:g} ms", "mm", 1e3 * given, 1e3 * np.interp(t, probe["time"], probe["end.displacement_x"]), 1e-2)
            for t, given in AT.items()]  # fmt: skip


def cube_on_plate(out: Path) -> list[Figure]:
    each = table(out / "bodies.csv")
    momentum = each["momentum_z"].reshape(-1, 2)
    total = momentum.sum(axis=1)
    impact = json.loads((out / "run.json").read_text())["impact"]
    side = abs(np.stack([each["momentum_x"], each["momentum_y"]])).max()
    return [
        Figure("momentum of the cube before", "kg m/s", 0.6452, -momentum[0, 0], 1e-4),
        Figure("change of the momentum of both in 240 steps / momentum", "", 0, abs(total - total[0]).max() / abs(total[0]), 1e-10),
        Figure("momentum law of a step, residual / largest forces", "", 0, float(abs(table(out / "steps.csv")["momentum_residual"]).max()), 1e-12),
        Figure("change of that of the plate / impulse on the cube", "", 1, (momentum[0, 1] - momentum[-1, 1]) / impact["all"]["impulse"][2], 1e-10),
        Figure("lateral momentum of either / momentum", "", 0, side / abs(total[0]), 1e-10),
    ]


def cylinder_on_block(out: Path) -> list[Figure]:
    load, radius, modulus = 35e6, 0.05, 1 / ((1 - 0.3**2) * (1 / 210e9 + 1 / 70e9))
    width = np.sqrt(4 * load * radius / (np.pi * modulus))
    contact = table(out / "contact.csv")
    last = contact["step"] == contact["step"][-1]
    x, force, pressure = (contact[key][last] for key in ("x", "force", "pressure"))
    inside = x < 0.5 * width
    exact = 2 * load / (np.pi * width) * np.sqrt(1 - (x[inside] / width) ** 2)
    # The second moment of Hertz's pressure is P a²/4.
    return [
        Figure("force", "kN/mm", load / 1e6, 2 * force.sum() / 1e6, 5e-3),
        Figure("half-width", "mm", 1e3 * width, 1e3 * 2 * np.sqrt((x**2 * force).sum() / force.sum()), 1.5e-2),
        Figure("largest pressure", "MPa", 2 * load / (np.pi * width) / 1e6, pressure.max() / 1e6, 1.5e-2),
        Figure("error of the pressure in the inner half, in L2", "", 0, np.sqrt(((pressure[inside] - exact) ** 2).sum() / (exact**2).sum()), 1.5e-2),
    ]


def pressed_discs(out: Path) -> list[Figure]:
    modulus, radius = 200 / (2 * (1 - 0.3**2)), 0.5
    contact = table(out / "contact.csv")
    now = contact["step"] == 20  # whole normal load, nothing along the surface
    x, force, pressure, shear = (contact[key][now] for key in ("x", "force", "pressure", "tangential_force_x"))
    load = force.sum()
    width = np.sqrt(4 * load * radius / (np.pi * modulus))
    highest = 2 * load / (np.pi * width)
    exact = highest * np.sqrt(np.maximum(0, 1 - (x / width) ** 2))
    return [
        Figure("half-width", "m", width, 2 * np.sqrt((x**2 * force).sum() / load), 1.5e-2),
        Figure("largest pressure", "N/m²", highest, pressure.max(), 1.5e-2),
        Figure("error of the pressure in L2", "", 0, np.sqrt(((pressure - exact) ** 2).sum() / (exact**2).sum()), 0.05),
        Figure("friction of equal discs under normal load / μ P", "", 0, abs(shear).sum() / (0.4 * load), 0.02),
        *partial_slip(out, 0.36, "two discs"),
        *partial_slip(out, 0.75, "two discs"),
    ]


CASES = [
    Case(
        "colliding-bars", "Two bars collide",
        """Two bars of 1 m, 3 and 4 elements across, hit each other end to end with 5 m/s each; then the left one has 1.5 times the impedance,
        then the right one is twice as long.""",
        """Waves in one dimension: the ends in contact push with Z₁Z₂/(Z₁ + Z₂) (v₁ − v₂) until the wave is back from the nearer free end.
        Equal bars exchange their velocities; the longer one has L₁/L₂ of the relative velocity in the mean, and vibrates.""",
        "closed form",
        """The force is the mean over the middle half of the contact, in which no front arrives. Dispersion smears the front that ends the
        contact over some elements, from which the velocities miss 0.5 %. Momentum is exact; velocities
        are differences of displacements over a step, and their rounding adds up.""",
        bars, ({}, {"material.0.density": 15.0, "material.0.young": 13.5e3}, {"mesh.file": "../meshes/two-bars-1-2.geo"}),
        scene="../../scenes/two-bars.toml"),
    Case(
        "bar-on-bar", "A bar hits a clamped bar",
        """A steel bar of 1 m, held laterally, hits the end of an equal bar with 1 m/s; the far end of that bar is clamped. The gap is 10 µm.""",
        """The test SDNL111 of code_aster. In closed form the end moves at −1, −1/2, 1/2 and 1 m/s between the arrivals of waves.""",
        "published",
        "The published values have three digits. The front that ends the contact is smeared, from which the end lags by 1 µm.",
        bar_on_bar),
    Case(
        "cube-on-plate", "A cube hits a plate",
        """A steel cube of 25.4 mm hits the middle of a free plate of 254 × 254 × 25.4 mm at 5080 mm/s. Both are meshed freely with
        tetrahedra.""",
        """Altair's example of an impact: the momentum of 0.6452 Mg mm/s stays. What the cube loses the plate has, as the impulse of contact.""",
        "closed form",
        "Momentum is exact but for rounding, which adds up over the steps: velocities are differences of displacements over a step.",
        cube_on_plate),
    Case(
        "cylinder-on-block", "A cylinder is pressed onto a block",
        """A steel cylinder (R = 50 mm) is pressed onto an aluminium block with 35 kN per mm of depth, without friction. The meshes do not match;
        half of both is modelled.""",
        """NAFEMS R0094, CB1: Hertz's solution, half-width a = √(4 P R/(π E*)) = 6.21 mm and pressure 2 P/(π a) = 3585 MPa.""",
        "closed form",
        "The block is 16 a wide, and elements under the contact are a/25 and a/18: pressures of single nodes scatter by 1 %.",
        cylinder_on_block),
    Case(
        "pressed-discs", "Two discs are pressed together and pushed",
        """Two equal half discs of 1 m with meshes of 1:1.37 are pressed together by their flat sides, then pushed along each other. Friction
        with μ = 0.4 acts throughout.""",
        """Hertz for two cylinders: a = √(4 P R*/(π E*)), R* = R/2. Equal bodies move alike under the normal load and do not slip. Then
        Cattaneo's and Mindlin's solution: the middle sticks, with the half-width c = a √(1 − Q/(μ P)).""",
        "closed form",
        """The contact is 0.08 R wide on either side, and Hertz is of first order in a/R. An element is a/20, which is the resolution of the
        nodes that stick; the moment of the traction has more digits.""",
        pressed_discs),
]  # fmt: skip
