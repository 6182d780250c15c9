# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases of the verification manual with friction (docs/verification.py)."""

import json
from pathlib import Path

import numpy as np
from harness import table
from verification_case import Case, Figure, impact

SCHEMES = {
    "contact-implicit": {},
    "contact-stabilized": {"time.scheme": "contact-stabilized"},
    "massless": {"contact.mass": "massless"},
}
HEADING = np.array([0.8, 0.6])  # direction of motions along a plane in space
SPACE = {"mesh.file": "cube.geo", "mesh.size": 0.5, "contact.obstacle.point": [0, 0, 0], "contact.obstacle.normal": [0, 0, 1]}


def energy(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())["energy"]


def by_scheme(*variants: dict[str, object]) -> tuple[dict[str, object], ...]:
    """Runs: each variant by each scheme, variants innermost."""
    return tuple(scheme | variant for scheme in SCHEMES.values() for variant in variants)


def along(vector: list[float], normal: float = 0) -> list[float]:
    """A vector of space with a length along HEADING and a component along z."""
    return [round(float(x), 8) for x in (*(vector * HEADING), normal)]


def sliding(out: Path, after: float) -> float:
    """Share of the candidates in contact that slip, after some time. There must be contact in each step."""
    steps = table(out / "steps.csv")
    late = steps["time"] > after
    closed = steps["slip"][late] + steps["stick"][late]
    assert late.any() and closed.all(), "the block leaves the plane"
    return steps["slip"][late].sum() / closed.sum()


def block(out: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, and displacement and velocity of the centre of a block along its motion: x in the plane, HEADING in space."""
    probe = table(out / "probes.csv")
    run = json.loads((out / "run.json").read_text())
    names = "xy" if len(run["body"]["extent"]) == 3 else "x"
    path, momentum = (np.stack([probe[f"block.{what}_{name}"] for name in names]) for what in ("center", "momentum"))
    heading = HEADING[: len(names)] if len(names) > 1 else np.ones(1)
    return probe["time"], heading @ (path - path[:, :1]), heading @ momentum / run["body"]["mass"]


def creep(out: Path) -> float:
    """The largest change of a block's position in the second half of a run."""
    t, x, _ = block(out)
    late = t >= t[-1] / 2
    return np.ptp(x[late])


def acceleration(out: Path, start: float, end: float) -> float:
    t, _, v = block(out)
    i, k = (int(np.argmin(abs(t - time))) for time in (start, end))
    return (v[k] - v[i]) / (t[k] - t[i])


STEEPNESS = (0.9, 1.3)  # tan(angle) / coefficient of friction
INCLINE = 0.5, 9.81  # coefficient of friction, m/s²


def tilted(steepness: float) -> tuple[float, float]:
    """Gravity along the incline and towards it."""
    friction, gravity = INCLINE
    angle = np.arctan(steepness * friction)
    return round(gravity * np.sin(angle), 7), round(gravity * np.cos(angle), 7)


def incline(*outs: Path) -> list[Figure]:
    down, normal = tilted(STEEPNESS[1])
    found = []
    for scheme, stuck, slides in zip(SCHEMES, outs[::2], outs[1::2]):
        end = block(stuck)[0][-1]
        assert (sliding(stuck, end / 2), sliding(slides, end / 2)) == (0, 1)
        found += [
            Figure(f"0.9 times, creep in the second half, {scheme}", "m", 0, creep(stuck), 1e-11),
            Figure(f"1.3 times, relative error of the acceleration in the second half, {scheme}", "", 0,
                   acceleration(slides, end / 2, end) / (down - INCLINE[0] * normal) - 1, 1e-5),
        ]  # fmt: skip
    return found


INCLINE_RUNS = by_scheme(*({"load.gravity": [tilted(s)[0], -tilted(s)[1]]} for s in STEEPNESS))
INCLINE_SPACE_RUNS = by_scheme(*(SPACE | {"load.gravity": along(tilted(s)[0], -tilted(s)[1])} for s in STEEPNESS))

FLOOR = 0.3, 10.0  # coefficient of friction, m/s²
PATH = 1 / (2 * FLOOR[0] * FLOOR[1])  # m, on which friction stops 1 m/s
NAMES = [*SCHEMES, *(f"{scheme}, space" for scheme in SCHEMES)]


def stopping_block(*outs: Path) -> list[Figure]:
    found = []
    for name, out in zip(NAMES, outs):
        assert sliding(out, 0.4) == 0 < sliding(out, 0)
        found.append(Figure(f"distance, {name}", "m", PATH, block(out)[1][-1], 1e-4))
    return [*found, Figure("work of friction / energy at the start", "", -1, energy(outs[0])["friction_work"] / 500, 1e-4)]


def belt(*outs: Path) -> list[Figure]:
    found = []
    for name, out in zip(NAMES, outs):
        t, x, _ = block(out)
        assert sliding(out, 0.4) == 0 < sliding(out, 0)
        found += [
            Figure(f"acceleration, {name}", "m/s²", FLOOR[0] * FLOOR[1], acceleration(out, 0.05, 0.3), 5e-5),
            Figure(f"slip path, {name}", "m", PATH, t[-1] - x[-1], 1e-4),
        ]
    excess = max((steps["contact_work"] - steps["belt_work"]).max() for steps in (table(out / "steps.csv") for out in outs))
    return [
        *found,
        Figure("work of the belt", "J", 1000, energy(outs[0])["belt_work"], 5e-4),
        Figure("work of friction", "J", -500, energy(outs[0])["friction_work"], 1e-4),
        Figure("largest work of contact less that of the belt in a step / energy, if above 0", "", 0, max(excess, 0) / 500, 1e-13),
    ]


STOPPING_RUNS = by_scheme({}) + by_scheme(SPACE | {"load.gravity": [0, 0, -10], "initial.velocity": list(map(str, along(1)))})
BELT_RUNS = by_scheme({}) + by_scheme(
    SPACE | {"load.gravity": [0, 0, -10], "contact.obstacle.surface_velocity": list(map(str, along(1)))})  # fmt: skip


def slope(*outs: Path) -> list[Figure]:
    down, normal = 4.3871575, 8.7743347
    found = []
    for scheme, slides, stuck in zip(SCHEMES, outs[::2], outs[1::2]):
        assert (sliding(slides, 2), sliding(stuck, 2)) == (1, 0)
        found += [
            Figure(f"μ = 0.49, relative error of the acceleration, {scheme}", "", 0,
                   acceleration(slides, 2, 4) / (down - 0.49 * normal) - 1, 5e-6),
            Figure(f"μ = 0.50, creep in the second half, {scheme}", "m", 0, creep(stuck), 1e-10),
        ]
    return [*found, Figure("μ = 0.50, whole displacement", "m", 0, abs(block(outs[1])[1]).max(), 2e-5)]


def friction_shoe(*outs: Path) -> list[Figure]:
    mass, stiffness, push, held = 7000, 24e3, 200e3, 21e3  # kg, N/m, N, N, of a metre of depth
    rate = np.sqrt(stiffness / mass)
    turn, first, second = np.pi / rate, 2 * (push - held) / stiffness, 4 * held / stiffness  # s, m, m: the turning points

    def exact(t: np.ndarray) -> np.ndarray:
        """Displacement of a rigid shoe, which slides there and back."""
        there, back = (push - held) / stiffness, (push + held) / stiffness
        cosine = np.cos(rate * t)
        return np.select([t < turn, t < 2 * turn], [there * (1 - cosine), back - (first - back) * cosine],
                         there + (second - there) * cosine)  # fmt: skip

    found = []
    for scheme, out in zip(SCHEMES, outs):
        probe = table(out / "probes.csv")
        t, x = probe["time"], probe["shoe.displacement_x"]
        assert sliding(out, 0) > 0.98
        found += [
            *(Figure(f"displacement at {time:g} s, {scheme}", "m", published, x[np.argmin(abs(t - time))], 1e-3)
              for time, published in ((1.7, 14.91), (3.4, 3.5))),
            Figure(f"error of the displacement over time, in L2, {scheme}", "", 0,
                   np.linalg.norm(x - exact(t)) / np.linalg.norm(exact(t)), 1e-3),
        ]  # fmt: skip
    travelled = 2 * first - second + exact(np.array(3.5)) - second
    work = energy(outs[0])["friction_work"]
    return [*found, Figure("work of friction, contact-implicit", "kJ", -held * travelled / 1e3, work / 1e3, 1e-3)]


LAYER = 0.3, 1000.0, 100.0, 100 / np.sqrt(2)  # coefficient of friction, kg/m³, m/s, m/s: pressure and shear waves
GRIP = LAYER[0] * LAYER[2] / LAYER[3]  # tangential speed / normal speed above which the layer slides
OBLIQUE = (("contact-implicit", 0.9), ("contact-implicit", 1.1), ("massless", 0.9), ("massless", 1.1),
           ("contact-stabilized", 0.5), ("contact-stabilized", 2.0))  # fmt: skip


def oblique_layer(*outs: Path) -> list[Figure]:
    friction, density, pressure_wave, shear_wave = LAYER
    push = density * pressure_wave  # Pa, of 1 m/s
    found = []
    for (scheme, speed), out in zip(OBLIQUE, outs):
        contact = table(out / "contact.csv")
        middle = abs(contact["x"]) < 1e-6
        t, area, motion = contact["time"][middle], contact["area"][middle], contact["motion"][middle]
        normal, shear = contact["force"][middle] / area, -contact["tangential_force_x"][middle] / area
        two_steps = lambda values: (values[1:] + values[:-1]) / 2  # noqa: E731
        half = (t[1:] > 5e-3) & (t[1:] < 15e-3)
        grips = speed < 1
        assert set(motion[1:][half]) == {"stick" if grips else "slip"}
        exact = density * shear_wave * speed * GRIP if grips else friction * push
        name = f"{speed:g} times, {scheme}"
        if scheme == "contact-stabilized":
            before = speed * GRIP
            after = before * (1 - 2 * shear_wave / pressure_wave) if grips else before - 2 * friction
            found.append(Figure(f"mean tangential velocity after / before, {name}", "", after / before,
                                1 - shear.sum() * (t[1] - t[0]) / density / before, 6e-2))  # fmt: skip
        if speed == 2:
            ratio = shear.sum() / normal.sum()
            found.append(Figure(f"impulse of the middle node, tangential / normal, {name}", "", friction, ratio, 1e-12))
        found += [
            Figure(f"pressure, {name}", "kPa", push / 1e3, two_steps(normal)[half].mean() / 1e3, 2e-3),
            Figure(f"shear traction, {name}", "kPa", exact / 1e3, two_steps(shear)[half].mean() / 1e3, 2e-3),
        ]
    return found


LAYER_RUNS = tuple(SCHEMES[scheme] | {"time.scheme": "contact-stabilized" if scheme == "contact-stabilized" else "contact-implicit",
                                      "initial.velocity": [f"{speed * GRIP:.8f}", "-1"]} for scheme, speed in OBLIQUE)  # fmt: skip


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


SOFT_START = """The weight starts at t = 0 and makes the block vibrate, until viscosity has damped it. """
CASES = [
    Case(
        "incline", "A block on an incline",
        """A block of 1 m lies on an incline with the coefficient of friction μ = 0.5. The tangent of the angle is 0.9 and 1.3 times μ.
        Runs by each scheme.""",
        """The block stays where it is if the tangent is below μ. Otherwise its acceleration is g (sin θ − μ cos θ), whatever its
        deformation.""",
        "closed form",
        SOFT_START + """In the second half of the run all nodes in contact stick or all slip. Creep is the largest change of the centre's
        position there, 1e-13 to 1e-12 m of vibration that is left.""",
        incline, INCLINE_RUNS),
    Case(
        "incline-space", "A block on an incline, in space",
        """A cube on an [incline](incline.md), which descends along the direction (0.8, 0.6) between the axes.""",
        """As in the plane.""",
        "closed form",
        """As in the plane. At the start the cube vibrates sideways too. As long as it slides, friction turns this velocity slowly into the
        direction of descent; this costs 1e-6 of the acceleration.""",
        incline, INCLINE_SPACE_RUNS, "incline.toml"),
    Case(
        "stopping-block", "Friction stops a block",
        """A block slides on a floor with v = 1 m/s, μ = 0.3 and g = 10 m/s². Runs by each scheme, in the plane and for a cube in space,
        which slides along the direction (0.8, 0.6).""",
        """The block stops after v²/(2 μ g) = 1/6 m.""",
        "closed form",
        """Friction leaves the block leaning by some µm and vibrating, with 3e-5 of its energy, in proportion to μ ρ g/E. The start of the
        weight changes nothing: the impulse of the floor is that of the weight.""",
        stopping_block, STOPPING_RUNS),
    Case(
        "belt", "A belt carries a block along",
        """A block is put on a belt that runs with V = 1 m/s; μ = 0.3 and g = 10 m/s². Runs by each scheme, in the plane and for a cube in
        space, with a belt along the direction (0.8, 0.6).""",
        """The block gains speed by μ g = 3 m/s² until it has that of the belt, and slips by V²/(2 μ g) = 1/6 m until then. The belt does
        the work m V²; half of it becomes the block's energy, half is lost to friction. Less the belt's work, that of contact is never
        above 0.""",
        "closed form",
        """As for the block that [friction stops](stopping-block.md). The work of the belt contains the vibration of the force that holds
        the block at the end.""",
        belt, BELT_RUNS),
    Case(
        "slope", "Slide or stick at the limit",
        """A block lies on a slope of 26.565°, whose tangent is 0.5 less 1.1e-6, with μ = 0.49 and μ = 0.50. Scene of PolyFEM's data
        (high-school physics, slope test), with a rigid slope. Runs by each scheme.""",
        """With μ = 0.49 the block slides with g (sin θ − μ cos θ) = 0.0877 m/s²; with μ = 0.50 it sticks.""",
        "closed form",
        """First the weight grows, then the slope is tilted. A weight that starts at once makes the block vibrate and slide a little: near
        the limit friction hardly brakes it again. While the slope is tilted the centre moves by 7 µm, most of it
        deformation.""",
        slope, by_scheme({"contact.friction": 0.49}, {"contact.friction": 0.5})),
    Case(
        "friction-shoe", "A friction shoe on springs",
        """A shoe, 1 m wide and high, of E = 210 GPa, ν = 0 and 7,000 kg/m³, is pressed onto a rigid frame with 70 kPa and pushed with 200
        kPa against two springs of 12 kN/m; μ = 0.3. Runs by each scheme.""",
        """code_aster, test SDNV104: 14.91 m at 1.7 s and 3.5 m at 3.4 s, the turning points 2 (F − μ N)/k and 4 μ N/k of a rigid mass
        that slides there and back, with half a period π √(m/k) = 1.697 s.""",
        "published, and closed form",
        """The published figures have three digits; code_aster's tolerance is 5 %. (There the loads grow within 0.07 s, here they act at
        once.) Steps of 0.01 s resolve the turning points to half a step, an error of the second order in the displacement.""",
        friction_shoe, by_scheme({})),
    Case(
        "oblique-layer", "A layer hits a floor obliquely",
        """An elastic layer of 1 m with ν = 0 hits a floor with μ = 0.3, at 1 m/s along the normal. Along the floor it has 0.5 to 2 times
        the speed above which it slides.""",
        """Waves of pressure and shear leave the floor. For 2 L/c_p the pressure is ρ c_p v_n. The floor holds the layer if v_t/v_n ≤ μ
        c_p/c_s: the shear traction is ρ c_s v_t, and the layer leaves with the mean velocity v_t (1 − 2 c_s/c_p). Otherwise the traction
        is μ ρ c_p v_n, and the velocity v_t − 2 μ v_n.""",
        "closed form",
        """Tractions are those of the middle node, as means of two steps over the middle half of the contact. The layer is 5 m wide: waves
        from its sides arrive after the contact, but for a part that the mesh lets ahead (3e-4). Dispersion spreads the fronts over some
        elements, by which the impulses are 1 % too small; the mean velocity after the impact is their difference from the momentum
        before.""",
        oblique_layer, LAYER_RUNS),
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
