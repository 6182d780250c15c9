# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps that the motion chooses: cases in which a longer look back would be too late, figures that nothing may change, and
orders of an accuracy that must not be called met.

    chosen_steps.py SIGNORINI SOURCE [frames [CASES]]

Each case is held against steps of one length that need not be chosen, or against what is known exactly. With a further argument,
`frames`, the choice itself is: the same steps, to the last bit, of bodies that are moved, mirrored, moved along the plane or given
in other units by powers of two, and on several ranks; in any other unit the same but for ties, of which a change of the tolerance in
its ninth digit decides.
"""

import json
import sys
import tempfile
from itertools import zip_longest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SIGNORINI, SOURCE, Figures, boundary, captured, grids, signorini, table, toml  # noqa: E402
from rotated import write_mesh  # noqa: E402
from soft_scenes import soft  # noqa: E402

import numpy as np  # noqa: E402

BALL, RING = SOURCE / "scenes" / "drop-ball.toml", SOURCE / "scenes" / "drop-ring.toml"
DATA = SOURCE / "tests" / "data"
POWERS = "2^-20 m, 2^10 s, 2^7 kg"
CHOSEN = {"step": "auto", "tolerance": 1e-2}


def run(scene: Path, out: Path, **overrides: object) -> dict:
    signorini("simulate", scene, out, **({"output__fields": [], "output__tables": ["steps", "probes"]} | overrides))
    return json.loads((out / "run.json").read_text())


def warned(of: dict) -> list[str]:
    return [one["name"] for one in of["warnings"]]


def near_at_the_start(folder: Path, figures: Figures) -> None:
    """Impacts within the first two steps, of whatever length: as with steps of one length, eight in the time t_w."""
    ball = {"initial": {"velocity": ["0", "0", "-1.98"]}, "contact__obstacle__point": [0, 0, -0.0201], "mesh__size": 8e-3}
    ring = {"initial": {"velocity": ["0", "-1.98"]}, "contact__obstacle__point": [0, -0.101]}
    cases = ((BALL, ball, {"quantity": "contact-force", "scheme": "contact-stabilized"}, 0.2, 2e-3, (1e-2,)),
             (RING, ring, {"quantity": "contact-force", "scheme": "contact-stabilized"}, 0.08, 0.08, (1e-2, 1e-3)))  # fmt: skip
    for scene, given, time, end, fine_end, tolerances in cases:
        found = {tolerance: run(scene, folder / "chosen", **given, time={"end": end, "step": "auto", "tolerance": tolerance} | time)
                 for tolerance in tolerances}  # fmt: skip
        steps = int(np.ceil(fine_end / (found[tolerances[0]]["steps"]["wave_time"] / 8)))
        fine = run(scene, folder / "fine", **given, time={"end": fine_end, "step": fine_end / steps, "scheme": time["scheme"]})["impact"]["all"]
        for tolerance, chosen in found.items():
            touch, energy = chosen["impact"]["all"], chosen["energy"]
            name = f"{scene.stem}, tolerance {tolerance:g}"
            assert fine["normal_impulse"] > 0 and touch["start"] < 0.01 * end, "nothing is hit at the start"
            figures.show(f"{name}: impulse", touch["normal_impulse"] / fine["normal_impulse"], 1, tolerance)
            figures.show(f"{name}: duration", touch["impulse_duration"] / fine["impulse_duration"], 1, 3 * tolerance)
            figures.show(f"{name}: peak of two steps", touch["normal_peak"] / fine["normal_peak"], 1, 0.05)
            lost = -energy["contact_work"] / (energy["kinetic_at_start"] + energy["elastic_at_start"])
            figures.show(f"{name}: energy lost in contact", lost, 0, 0.02)


def steel_disc(folder: Path, figures: Figures) -> None:
    """Waves cross it in a hundred thousandth of the run."""
    scene, end = folder / "steel.toml", 0.5
    scene.write_text(f"""[mesh]
file = "{SOURCE / "meshes" / "disc.geo"}"
size = 3.0
[time]
end = {end}
step = "auto"
tolerance = 1e-2
[material]
density = 7800.0
young = 2e11
poisson = 0.3
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, -20.001], normal = [0, 1] }}
[initial]
velocity = ["0", "-1"]
""")
    chosen = run(scene, folder / "chosen")
    count = int(np.ceil(0.05 / (chosen["steps"]["wave_time"] / 8)))
    fine = run(scene, folder / "fine", time={"end": 0.05, "step": 0.05 / count})
    for name in ("normal_impulse", "impulse_duration", "sustained_peak"):
        assert fine["impact"]["ended"], "the disc has not left"
        figures.show(f"steel disc: {name.replace('_', ' ')}", chosen["impact"]["all"][name] / fine["impact"]["all"][name], 1,
                     0.03 if name != "normal_impulse" else 0.01)  # fmt: skip


def blows(folder: Path, figures: Figures) -> None:
    """1 N s within 2 ms, as an expression and as a series; a blow of 1 ms in five seconds at 10 kHz; a push on one element's edge."""
    times = np.arange(0, 50001) * 1e-4
    force = np.where((times > 2.1234) & (times < 2.1244), 1000.0, 0.0)
    np.savetxt(folder / "blow.csv", np.column_stack([times, force]), delimiter=",", header="time,push", comments="", fmt="%.17g")
    (folder / "push.csv").write_text("time,push\n0,0\n0.1231,0\n0.1231000001,500\n0.1251,500\n0.1251000001,0\n5,0\n")
    blow, push = ({"file": str(folder / f"{name}.csv"), "column": "push"} for name in ("blow", "push"))
    local = "(t > 0.5 && t < 0.502 ? 500 : 0)*exp(-((x - 0.3)/0.05)^2)"
    steady = "exp(-((x - 0.3)/0.05)^2)"
    expression = "t > 0.1231 && t < 0.1251 ? 500 : 0"

    def momentum(push: object, **time: object) -> float:
        scene = folder / "free.toml"
        scene.write_text(soft("square.geo", 0.05, 5, 0.1))
        done = run(scene, folder / "pushed", load={"traction": [{"on": "top", "value": ["0", push]}]},
                   output__probe=[{"name": "all", "body": True}], time={"end": 5, **time})  # fmt: skip
        assert done["steps"]["done"] > 2
        return float(table(folder / "pushed" / "probes.csv")["all.momentum_y"][-1])

    shape = momentum(steady, step=0.1) / 5
    sum_of_blow = float(np.sum(force) * 1e-4)
    for name, given, integral in (("expression", expression, 1.0), ("series", push, 1.0), ("blow of 1 ms", blow, sum_of_blow),
                                  ("local push", local, shape)):  # fmt: skip
        for steps, time in (("chosen", CHOSEN), ("of one length", {"step": 0.1})):
            found = momentum(given, **time)
            assert integral > 0.01
            figures.show(f"{name}, steps {steps}: momentum", found / integral, 1, 1e-9 if name != "series" else 1e-6)


def passage(folder: Path, figures: Figures) -> None:
    """A ball that moves through the whole body within a step; and one that does so slowly, of which nothing is said."""
    for speed, expected in ((200, True), (2, False)):
        ball = {"shape": "ball", "center": ["0.6", f"-0.5 + {speed}*t"], "radius": 0.3}
        done = run(DATA / "block.toml", folder / "passed", load={}, contact__obstacle=ball, time={"end": 0.2, "step": 0.01})
        figures.show(f"a ball at {speed} m/s: warned of", float("passage within a step" in warned(done)), float(expected), 0)


def frames_stored(folder: Path, figures: Figures) -> None:
    """The first step after each 300th of the time, the initial state, the last step and that of the largest force, however many steps."""
    done = run(RING, folder / "stored", output__fields=["displacement"], time__tolerance=1e-4, time__end=0.25)
    times = table(folder / "stored" / "steps.csv")["time"]
    assert len(times) > 600 and "every" not in (folder / "stored" / "scene.toml").read_text()
    part = np.floor(300 * times / times[-1] + 1e-9)
    force = table(folder / "stored" / "steps.csv")["normal_force"]
    assert force.max() > 0, "no contact"
    peak = [] if (at := times[force.argmax()]) in times[1:-1][part[1:-1] > part[:-2]] else [at]
    first = sorted([times[0], *times[1:-1][part[1:-1] > part[:-2]], times[-1], *peak])
    found = grids(folder / "stored" / "state.xdmf")["displacement"]
    figures.show(f"stored times of {len(times)} that are the first of a part", np.isclose(found, first, rtol=0, atol=1e-9).mean() if len(found) == len(first) else 0,
                 1, 0)  # fmt: skip
    assert done["steps"]["stored"] == len(found) <= 303


def ordered(folder: Path, figures: Figures) -> None:
    """Of an impact at the start, of which a peak had been called met that was one of a single long step: what is met is so beside a
    run of half the size in steps of one length, and a peak that grows with them is not called so."""
    given = {"initial": {"velocity": ["0", "-1.98"]}, "contact__obstacle__point": [0, -0.101], "time__end": 0.08, "mesh__size": 6e-3}
    fine = given | {"mesh__size": 1.5e-3, "time": {"end": 0.08, "step": 2e-5, "scheme": "contact-stabilized"}}
    truth = run(RING, folder / "truth", **fine)["impact"]["all"]["normal_impulse"]
    words = [f"--set={key.replace('__', '.')}={toml(value)}" for key, value in given.items()]
    for quantity, budget in (("impulse", "100s"), ("peak_force", "4s")):
        out = folder / quantity
        done = captured([str(SIGNORINI), "simulate", str(RING), "--out", str(out), "--accuracy", "2e-2", "--quantity", quantity, "--budget", budget, *words])
        told = json.loads((out / "run.json").read_text())
        print(f"  {quantity}: {done.stdout.splitlines()[-2]}")
        assert done.returncode == (0 if told["accuracy"]["met"] else 1), done.stdout + done.stderr
        figures.show(f"{quantity} of 2 %: met", told["accuracy"]["met"], quantity == "impulse", 0)
        figures.show(f"{quantity} of 2 %: the impulse", told["impact"]["all"]["normal_impulse"] / truth, 1, 2e-2 if quantity == "impulse" else 0.1)


CASES = (near_at_the_start, steel_disc, blows, passage, frames_stored, ordered)


def disc(rings: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """A mesh of a disc of radius 1 m: rings of 6, 12, 18 … triangles' corners."""
    points, cells, before = [[0.0, 0.0]], [], [0]
    for ring in range(1, rings + 1):
        angles = 2 * np.pi * (np.arange(6 * ring) + 0.25) / (6 * ring)
        own = list(range(len(points), len(points) + 6 * ring))
        points += [[ring / rings * np.cos(angle), ring / rings * np.sin(angle)] for angle in angles]
        for side in range(6):
            for i in range(ring):
                outer = [own[(side * ring + i + j) % len(own)] for j in (0, 1)]
                inner = [before[(side * (ring - 1) + i + j) % len(before)] for j in (0, 1)]
                cells.append([outer[0], outer[1], inner[0]])
                if i < ring - 1:
                    cells.append([inner[0], outer[1], inner[1]])
        before = own
    return np.array(points), np.array(cells)


class Case:
    """A disc that falls onto a plane, in SI units times those of `unit` (m, s, kg), its frame moved and mirrored."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.wave, self.poisson = 10 ** rng.uniform(1, 3), rng.uniform(0, 0.4)
        self.speed = self.wave * 10 ** rng.uniform(-4, -1.5)
        self.gap = 2.0 ** rng.uniform(-8, 0) if seed % 3 else 0.0
        self.viscosity = 10 ** rng.uniform(-3, -1) if seed % 2 else 0.0
        self.scheme = ("contact-implicit", "contact-stabilized", "massless")[seed % 3]
        self.tolerance = (1e-2, 1e-3)[seed % 2]

    def steps(self, folder: Path, unit: tuple[float, float, float] = (1, 1, 1), moved: tuple[float, float] = (0, 0), mirrored: bool = False,
              sideways: float = 0, ranks: int = 1, tolerance: float = 1) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Ends of the steps (in the unit) and levels below an eighth of the time; asserts contact."""
        length, second, kg = unit
        points, cells = disc()
        if mirrored:
            points, cells = points * [-1, 1], cells[:, [1, 0, 2]]
        facets = boundary(cells)
        low = points[facets][:, :, 1].max(axis=1) < 0.3
        points = (points + moved) * length
        write_mesh(folder / "disc.msh", points, cells, {"low": facets[low], "high": facets[~low]})
        end = (self.gap / self.speed + 40 / self.wave) * second
        density, modulus = 1000 * kg / length**2, 1000 * self.wave**2 * kg / second**2  # of the plane, per depth of 1
        scene = folder / "disc.toml"
        scheme = "contact-stabilized" if self.scheme == "contact-stabilized" else "contact-implicit"
        eta = self.viscosity * modulus * second / self.wave
        scene.write_text(f"""[mesh]
file = "disc.msh"
[time]
end = {end!r}
step = "auto"
tolerance = {self.tolerance * tolerance!r}
scheme = "{scheme}"
[material]
density = {density!r}
young = {modulus!r}
poisson = {self.poisson!r}
viscosity = {{ bulk = {eta!r}, shear = {eta!r} }}
[contact]
on = "low"
obstacle = {{ shape = "half-space", point = [{moved[0] * length!r}, {(moved[1] - 1 - self.gap) * length!r}], normal = [0, 1] }}
initial = "project"
mass = "{"massless" if self.scheme == "massless" else "consistent"}"
[initial]
velocity = ["{sideways * self.speed * length / second!r}", "{-self.speed * length / second!r}"]
""")
        signorini("simulate", scene, folder / "run", ranks=ranks, output__fields=[], output__tables=["steps"])
        rows = table(folder / "run" / "steps.csv")
        assert np.max(rows["normal_force"]) > 0, "no contact occurred"
        return rows["time"] / second, np.round(np.log2(end / 8 / np.diff(rows["time"]))).astype(int)


def same(one: np.ndarray, other: np.ndarray) -> bool:
    return len(one) == len(other) and bool((one == other).all())


def choices(folder: Path, figures: Figures) -> None:
    ties = several = 0
    frames = {"moved": {"moved": (64.0, -128.0)}, "mirrored": {"mirrored": True}, "100 v along the plane": {"sideways": 100},
              POWERS: {"unit": (2.0**-20, 2.0**10, 2.0**7)}, "2 ranks": {"ranks": 2}, "3 ranks": {"ranks": 3}}  # fmt: skip
    others = {"mm, ms, g": (1e3, 1e3, 1e3), "inch, h, lb": (39.37, 1 / 3600, 2.2046)}
    counts = dict.fromkeys([*frames, *others], 0)
    seeds = range(int(sys.argv[4]) if sys.argv[4:] else 6)
    for seed in seeds:
        case = Case(seed)
        times, levels = case.steps(folder)
        several += len(set(levels)) > 1

        def tie(found: np.ndarray, case: Case = case) -> bool:
            """Whether a change of the tolerance in its ninth digit makes the same choice."""
            return any(same(found, case.steps(folder, tolerance=1 + sign * 1e-9)[1]) for sign in (1, -1))

        for name, frame in frames.items():
            there, found = case.steps(folder, **frame)
            # Powers of two change no digit of a length, though its decimal ones in the table.
            bits = same(levels, found) and (name == POWERS or same(times, there))
            counts[name] += bits or bool(print(f"  seed {seed}, {name}: {first_difference(levels, found)}"))
        for name, unit in others.items():
            _, found = case.steps(folder, unit=unit)
            if not same(levels, found):
                assert tie(found), f"seed {seed}, {name}: {first_difference(levels, found)}, and no tie"
                ties += 1
            counts[name] += 1
    assert several > len(seeds) / 2, "one length alone says nothing"
    for name, count in counts.items():
        figures.show(f"{name}: the same steps", count / len(seeds), 1, 0)
    print(f"  {ties} of {len(others) * len(seeds)} choices in other units were ties")


def first_difference(one: np.ndarray, other: np.ndarray) -> str:
    k = next((k for k, (a, b) in enumerate(zip_longest(one, other)) if a != b), None)
    return "the same levels" if k is None else f"step {k + 1} of {len(one)} and {len(other)}: levels {one[k:k + 2]} and {other[k:k + 2]}"


def main() -> int:
    figures = Figures()
    with tempfile.TemporaryDirectory() as name:
        for part in (choices,) if sys.argv[3:4] == ["frames"] else CASES:
            part(Path(name), figures)
    return int(figures.failed)


if __name__ == "__main__":
    raise SystemExit(main())
