# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases of the verification manual with friction: oblique impacts and partial slip (docs/verification.py)."""

from pathlib import Path

import numpy as np
from harness import table
from verification_case import Case, Figure, impact
from verification_friction import HEADING, NAMES, NO_TANGENTIAL_MASS, SCHEMES, along, by_scheme

LAYER = 0.3, 1000.0, 100.0, 100 / np.sqrt(2)  # coefficient of friction, kg/m³, m/s, m/s: pressure and shear waves
GRIP = LAYER[0] * LAYER[2] / LAYER[3]  # tangential speed / normal speed above which the layer slides
ACROSS = np.array([-HEADING[1], HEADING[0]])
OBLIQUE = (("contact-implicit", 0.9), ("contact-implicit", 1.1), ("massless", 0.9), ("massless", 1.1), ("contact-stabilized", 0.5),
           ("contact-stabilized", 2.0), (NO_TANGENTIAL_MASS, 0.5), (NO_TANGENTIAL_MASS, 2.0))  # fmt: skip
OBLIQUE_SPACE = (("contact-implicit", 0.5), ("massless", 0.5), ("contact-stabilized", 2.0), (NO_TANGENTIAL_MASS, 0.5),
                 (NO_TANGENTIAL_MASS, 2.0))  # fmt: skip


def middle_node(out: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times, motions, pressures and tangential tractions, on the floor, of the contact node in the middle of a layer."""
    contact = table(out / "contact.csv")
    middle = (abs(contact["x"]) < 1e-6) & (abs(contact["y"]) < 1e-6)
    area = contact["area"][middle]
    shear = -np.stack([contact[f"tangential_force_{name}"][middle] for name in "xy"]) / area
    return contact["time"][middle], contact["motion"][middle], contact["force"][middle] / area, shear


def oblique_layer(*outs: Path) -> list[Figure]:
    friction, density, pressure_wave, shear_wave = LAYER
    push = density * pressure_wave  # Pa, of 1 m/s
    found = []
    for (scheme, speed), out in zip(OBLIQUE, outs):
        t, motion, normal, (shear, _) = middle_node(out)
        half = (t[1:] > 5e-3) & (t[1:] < 15e-3)
        grips, single = speed < 1, scheme == NO_TANGENTIAL_MASS
        mean = lambda values: (values[1:] if single else (values[1:] + values[:-1]) / 2)[half].mean()  # noqa: B023, E731
        assert set(motion[1:][half]) == {"stick" if grips else "slip"}
        exact = density * shear_wave * speed * GRIP if grips else friction * push
        name = f"{speed:g} times, {scheme}"
        if "stabilized" in scheme:
            before = speed * GRIP
            after = before * (1 - 2 * shear_wave / pressure_wave) if grips else before - 2 * friction
            found.append(Figure(f"mean tangential velocity after / before, {name}", "", after / before,
                                1 - shear.sum() * (t[1] - t[0]) / density / before, 6e-2))  # fmt: skip
        if speed == 2:
            ratio = shear.sum() / normal.sum()
            found.append(Figure(f"impulse of the middle node, tangential / normal, {name}", "", friction, ratio, 1e-3 if single else 1e-12))
        if single and grips:
            alternates = np.sqrt((np.diff(shear[1:][half], 2) ** 2).mean()) / 4
            found.append(Figure(f"part of the shear traction that alternates / mean, {name}", "", 0, alternates / exact, 2e-3))
        found += [
            Figure(f"pressure, {name}", "kPa", push / 1e3, mean(normal) / 1e3, 2e-3),
            Figure(f"shear traction, {name}", "kPa", exact / 1e3, mean(shear) / 1e3, 2e-3),
        ]
    return found


def oblique_slab(*outs: Path) -> list[Figure]:
    friction, density, pressure_wave, shear_wave = LAYER
    push = density * pressure_wave
    found = []
    for (scheme, speed), out in zip(OBLIQUE_SPACE, outs):
        t, motion, normal, shear = middle_node(out)
        inside = (t > 3e-3) & (t < 9e-3)
        assert set(motion[inside]) == {"stick" if speed < 1 else "slip"}
        weight = np.sin(np.pi * (t[inside] - 3e-3) / 6e-3) ** 2
        mean = lambda values: np.average(values[inside], weights=weight)  # noqa: B023, E731
        exact = density * shear_wave * speed * GRIP if speed < 1 else friction * push
        name = f"{speed:g} times, {scheme}"
        found += [
            Figure(f"pressure, {name}", "kPa", push / 1e3, mean(normal) / 1e3, 1e-2 if scheme == "massless" else 2e-3),
            Figure(f"shear traction, {name}", "kPa", exact / 1e3, mean(HEADING @ shear) / 1e3,
                   1e-2 if scheme == NO_TANGENTIAL_MASS and speed < 1 else 2e-3),
            Figure(f"traction across the direction of motion / shear traction, {name}", "", 0,
                   mean(ACROSS @ shear) / exact, 2e-3),
        ]  # fmt: skip
    return found


LAYER_RUNS = tuple({"time.scheme": "contact-implicit"} | SCHEMES[scheme] | {"initial.velocity": [f"{speed * GRIP:.8f}", "-1"]}
                   for scheme, speed in OBLIQUE)  # fmt: skip
SLAB_RUNS = tuple({"time.scheme": "contact-implicit"} | SCHEMES[scheme]
                  | {"initial.velocity": list(map(str, along(speed * GRIP, -1)))} for scheme, speed in OBLIQUE_SPACE)  # fmt: skip


def oblique_disc(*outs: Path) -> list[Figure]:
    found = []
    for name, out in zip(NAMES, outs):
        steps, hit = table(out / "steps.csv"), impact(out)
        assert steps["slip"].sum() > 100 and steps["stick"].sum() == 0 and steps["slip"].max() >= 3
        ratio = np.linalg.norm(hit["friction_impulse"]) / hit["normal_impulse"]
        found.append(Figure(f"impulse, tangential / normal, {name}", "", 0.2, ratio, 1e-3 if "space" in name else 1e-12))
    return found


DISC_RUNS = by_scheme({}) + by_scheme({
    "mesh.file": "../../meshes/ball.geo", "mesh.size": 0.004, "time.end": 2.5e-3, "time.step": 1e-5,
    "initial.velocity": ["1.2", "0.9", "-0.5"], "contact.obstacle.point": [0, 0, -0.0201],
    "contact.obstacle.normal": [0, 0, 1]})  # fmt: skip

LOADS = (0.2, 0.4, 0.6, 0.8)  # tangential force / (coefficient of friction · normal force)


def cattaneo(*outs: Path) -> list[Figure]:
    fine = [figure for load in LOADS for figure in partial_slip(outs[0], load, "contact-implicit")]
    return fine + [partial_slip(out, LOADS[2], f"{scheme}, elements twice as large")[1] for scheme, out in zip(SCHEMES, outs[1:])]


def partial_slip(out: Path, load: float, run: str) -> list[Figure]:
    """Figures of the part that sticks, at the step whose tangential force is nearest to a load: by nodes and by a moment."""
    friction, step = 0.4, 20  # the normal load is whole after step 20
    contact = table(out / "contact.csv")
    numbers, count = np.unique(contact["step"], return_counts=True)
    order = np.lexsort((contact["x"], contact["step"]))
    x, force, shear, motion = (contact[key][order].reshape(len(numbers), count[0])
                               for key in ("x", "force", "tangential_force_x", "motion"))  # fmt: skip
    shear = -shear
    ratio = np.zeros(len(numbers))
    ratio[step + 1 :] = shear[step + 1 :].sum(axis=1) / (friction * force[step + 1 :].sum(axis=1))
    k = int(np.argmin(abs(ratio - load)))
    assert set(motion[k]) == {"stick", "slip", "open"}
    edges = (x[k][1:] + x[k][:-1]) / 2  # between nodes
    half_width = lambda inside: (edges[np.flatnonzero(inside)[-1]] - edges[np.flatnonzero(inside)[0] - 1]) / 2  # noqa: E731
    total, width = force[k].sum(), half_width(motion[k] != "open")
    middle = (x[k] * force[k]).sum() / total
    squared = 4 * ((x[k] - middle) ** 2 * force[k]).sum() / total  # of the contact's half-width
    moment = 4 * ((x[k] - middle) ** 2 * shear[k]).sum() / (friction * total * squared)  # 1 − (c/a)⁴
    exact = np.sqrt(1 - ratio[k])
    name = f"Q/(μ P) = {load:g}: c/a less the formula's, by the"
    return [
        Figure(f"{name} nodes that stick, {run}", "", 0, half_width(motion[k] == "stick") / width - exact, 0.045),
        Figure(f"{name} second moment of the traction, {run}", "", 0, (1 - moment) ** 0.25 - exact, 5e-3),
    ]


CASES = [
    Case(
        "oblique-layer", "A layer hits a floor obliquely",
        """An elastic layer of 1 m with ν = 0 hits a floor with μ = 0.3, at 1 m/s along the normal. Along the floor it has 0.5 to 2 times
        the speed above which it slides.""",
        """Waves of pressure and shear leave the floor. For 2 L/c_p the pressure is ρ c_p v_n. The floor holds the layer if v_t/v_n ≤ μ
        c_p/c_s: the shear traction is ρ c_s v_t, and the layer leaves with the mean velocity v_t (1 − 2 c_s/c_p). Otherwise the traction
        is μ ρ c_p v_n, and the velocity v_t − 2 μ v_n.""",
        "closed form",
        """Tractions are those of the middle node over the middle half of the contact: means of two steps, and without tangential mass
        those of single steps. There the shear traction of a node that sticks alternates by 7e-4 of its mean, in the other schemes by up
        to 0.6. It rings after the front instead, by 11 % at 5 ms and below 1 % from 12 ms on; means of two steps do not change this. The
        layer is 5 m wide: waves from its sides arrive after the contact, but for a part that the mesh lets ahead (3e-4). Dispersion spreads the
        fronts over some elements, by which the impulses are 1 % too small; the mean velocity after the impact is their difference from
        the momentum before. Without tangential mass the middle node sticks in the first step even where the layer slides, which costs 8e-5
        of the impulse.""",
        oblique_layer, LAYER_RUNS),
    Case(
        "oblique-slab", "A slab hits a floor obliquely",
        """An elastic slab, 1 m thick and 2 m wide in both directions, hits a floor as the [layer](oblique-layer.md) does. Its
        velocity along the floor has the direction (0.8, 0.6), and is 0.5 and 2 times the speed above which it slides.""",
        """That of the layer, in the middle of the slab, until waves from its sides arrive there after 10 ms. The traction is opposite to
        the motion.""",
        "closed form",
        """Tractions are those of the middle node from 3 to 9 ms, as means with the weight sin²: alternation from step to step and ringing
        after the fronts contribute little. Where contact nodes have no mass in a direction in which they do not move, what is left of the
        ringing is below 1 %. Elements are 1/32 m through the thickness and 1/4 m along the floor; these let a part of the waves from the
        sides ahead (1e-3).""",
        oblique_slab, SLAB_RUNS),
    Case(
        "oblique-disc", "A disc slides along a wall",
        """An elastic disc of 1 m diameter hits a wall with μ = 0.2, at 0.5 m/s along the normal and 1.5 m/s along the wall. Runs by each
        scheme, and for a ball of 4 cm in space.""",
        """Coulomb's law holds at each node and step; if all nodes slip in one direction, the tangential impulse is μ times the normal
        one.""",
        "closed form",
        """In the plane only rounding is left. In space the surface also moves across the direction of sliding, by which friction differs a
        little in direction from node to node.""",
        oblique_disc, DISC_RUNS),
    Case(
        "cattaneo", "Partial slip under a disc",
        """A half disc of 8 m, with E = 200 Pa and ν = 0.3 in plane strain, is pressed onto a plane without friction (P = 12.3 N/m), then
        pushed along it with μ = 0.4. Runs by each scheme.""",
        """C. Cattaneo (1938), R. D. Mindlin (1949): the middle sticks, with the half-width c = a √(1 − Q/(μ P)), and the rest of the
        contact slips. The traction is μ times the pressure, less that on a contact of the half-width c: its second moment is μ P a²/4
        (1 − (c/a)⁴).""",
        "closed form",
        """An element is 0.044 a, within which nodes find the edge of the part that sticks. The formula takes pressure and traction for
        uncoupled, which is not exact on a rigid plane: friction that acts under the normal load too makes nodes slip before Q does.""",
        cattaneo, ({}, *by_scheme({"mesh.scale": 1.0}))),
]  # fmt: skip
