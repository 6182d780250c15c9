# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases of the verification manual with friction: blocks on floors and inclines (docs/verification.py)."""

import json
from pathlib import Path

import numpy as np
from harness import table
from verification_case import Case, Figure

NO_TANGENTIAL_MASS = "contact-stabilized without tangential mass"
SCHEMES = {
    "contact-implicit": {},
    "contact-stabilized": {"time.scheme": "contact-stabilized"},
    "massless": {"contact.mass": "massless"},
    NO_TANGENTIAL_MASS: {"time.scheme": "contact-stabilized", "contact.mass": "massless-tangential"},
}
NAMES = [*SCHEMES, *(f"{scheme}, space" for scheme in SCHEMES)]
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


def creep(out: Path, after: float) -> float:
    """The largest change of a block's position after some time."""
    t, x, _ = block(out)
    return np.ptp(x[t >= after])


def acceleration(out: Path, start: float, end: float) -> float:
    t, _, v = block(out)
    i, k = (int(np.argmin(abs(t - time))) for time in (start, end))
    return (v[k] - v[i]) / (t[k] - t[i])


STEEPNESS = (0.9, 1.3)  # tan(angle) / coefficient of friction
INCLINE = 0.5, 9.81  # coefficient of friction, m/s²
TILT = 0.5  # s, within which gravity is tilted


def tilted(steepness: float) -> tuple[float, float]:
    """Gravity along the incline and towards it."""
    friction, gravity = INCLINE
    angle = np.arctan(steepness * friction)
    return round(gravity * np.sin(angle), 7), round(gravity * np.cos(angle), 7)


def tilting(steepness: float, in_space: bool = False) -> list[str]:
    """Gravity of a block whose floor becomes an incline within TILT: only the part along the incline grows."""
    down, normal = tilted(steepness)
    *downhill, towards = along(down, -normal) if in_space else (down, -normal)
    return [*(f"{part} * (t < {TILT} ? sin(pi*t/{2 * TILT:g})^2 : 1)" for part in downhill), str(towards)]


def incline(*outs: Path) -> list[Figure]:
    down, normal = tilted(STEEPNESS[1])
    found = []
    for scheme, stuck, slides in zip(SCHEMES, outs[::2], outs[1::2]):
        end = block(stuck)[0][-1]
        assert (sliding(stuck, 2 * TILT), sliding(slides, TILT)) == (0, 1)
        weight = json.loads((stuck / "run.json").read_text())["body"]["mass"] * tilted(STEEPNESS[0])[1]
        found += [
            Figure(f"0.9 times, normal force of the first step / weight, {scheme}", "", 1,
                   table(stuck / "steps.csv")["normal_force"][1] / weight, 1e-6),
            Figure(f"0.9 times, creep in the last 0.5 s, {scheme}", "m", 0, creep(stuck, 2 * TILT), 1e-11),
            Figure(f"1.3 times, relative error of the acceleration from the end of the tilt, {scheme}", "", 0,
                   acceleration(slides, TILT, end) / (down - INCLINE[0] * normal) - 1, 2e-6),
        ]  # fmt: skip
    return found


INCLINE_RUNS = by_scheme(*({"load.gravity": tilting(s)} for s in STEEPNESS))
INCLINE_SPACE_RUNS = by_scheme(*(SPACE | {"load.gravity": tilting(s, True)} for s in STEEPNESS))

FLOOR = 0.3, 10.0  # coefficient of friction, m/s²
PATH = 1 / (2 * FLOOR[0] * FLOOR[1])  # m, on which friction stops 1 m/s


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


BOUND, HEAVIER = 2e3, (1, 4)  # Pa; weights / that of the scene
BOUNDED = [*SCHEMES, "contact-implicit, space", f"{NO_TANGENTIAL_MASS}, space"]


def bounded_block(*outs: Path) -> list[Figure]:
    mass, area = 1000, 1  # kg and m² in space, kg/m and m in the plane
    found = []
    for name, light, heavy in zip(BOUNDED, outs[::2], outs[1::2]):
        assert sliding(light, 0.55) == sliding(heavy, 0.55) == 0 < sliding(light, 0)
        distance, of_heavy = block(light)[1][-1], block(heavy)[1][-1]
        found += [
            Figure(f"deceleration, {name}", "m/s²", BOUND * area / mass, -acceleration(light, 0.05, 0.45), 1e-8),
            Figure(f"distance, {name}", "m", mass / (2 * BOUND * area), distance, 1e-4),
            Figure(f"distance with four times the weight less that, {name}", "m", 0, of_heavy - distance, 1e-8),
        ]
    return [*found, Figure("work of friction / energy at the start", "", -1, energy(outs[0])["friction_work"] / 500, 1e-4)]


BOUNDED_RUNS = tuple(
    (SCHEMES[name.removesuffix(", space")] | (SPACE | {"initial.velocity": list(map(str, along(1)))} if "space" in name else {}))
    | {"load.gravity": [0, 0, -10 * times] if "space" in name else [0, -10 * times]}
    for name in BOUNDED for times in HEAVIER)  # fmt: skip


def slope(*outs: Path) -> list[Figure]:
    down, normal = 4.3871575, 8.7743347
    found = []
    for scheme, slides, stuck in zip(SCHEMES, outs[::2], outs[1::2]):
        assert (sliding(slides, 2), sliding(stuck, 2)) == (1, 0)
        found += [
            Figure(f"μ = 0.49, relative error of the acceleration, {scheme}", "", 0,
                   acceleration(slides, 2, 4) / (down - 0.49 * normal) - 1, 5e-6),
            Figure(f"μ = 0.50, creep in the last 2 s, {scheme}", "m", 0, creep(stuck, 2), 1e-10),
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


CASES = [
    Case(
        "incline", "A block on an incline",
        """A block of 1 m lies on a floor with the coefficient of friction μ = 0.5, in the equilibrium under its weight. Within 0.5 s the
        floor becomes an incline: the tangent of its angle is 0.9 and 1.3 times μ. Runs by each scheme.""",
        """The block stays where it is if the tangent is below μ. Otherwise its acceleration is g (sin θ − μ cos θ), whatever its
        deformation.""",
        "closed form",
        """`initial.static` is the equilibrium without friction. With it the floor bears the weight from the first step on (without it 0.7
        of the weight), and the acceleration needs no settling. Under a gravity that is tilted from the start the block would shear
        suddenly, with or without the static start. While it is tilted the block shears by 0.7 mm and single nodes slip; afterwards
        viscosity brings it to rest, to 1e-12 m after 0.5 s.""",
        incline, INCLINE_RUNS),
    Case(
        "incline-space", "A block on an incline, in space",
        """A cube on an [incline](incline.md), which descends along the direction (0.8, 0.6) between the axes.""",
        """As in the plane.""",
        "closed form",
        """As in the plane. The tilt makes the cube vibrate sideways too. As long as it slides, friction turns this velocity slowly into the
        direction of descent, which costs some 1e-7 of the acceleration.""",
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
        "bounded-friction", "Friction with a given bound stops a block",
        """A block of 1000 kg slides on a floor with v = 1 m/s. Friction is Tresca's, with the bound s = 2 kPa of the traction on the lower
        face of A = 1 m². Runs by each scheme with g = 10 and 40 m/s², and for a cube in space, which slides along the direction (0.8,
        0.6).""",
        """The deceleration is s A/m = 2 m/s², the distance m v²/(2 s A) = 0.25 m. Neither depends on the weight.""",
        "closed form",
        """The distance is too small by 1e-5, as for the block that [Coulomb friction stops](stopping-block.md): friction leaves the block
        leaning, in proportion to s/E. The deceleration is measured from 0.05 s on, when the vibration of the start is damped. The weight
        starts at t = 0 and makes the block vibrate. In the plane this changes the distance by rounding. In space nodes move sideways
        too, which turns the direction of their friction: 1e-9 m.""",
        bounded_block, BOUNDED_RUNS),
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
]  # fmt: skip
