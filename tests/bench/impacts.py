# SPDX-License-Identifier: GPL-3.0-or-later
"""Random impacts with steps that the motion chooses, beside steps of one length an eighth of a wave's time through an element.

usage: ./dev bench impacts [--count N] [--seed TEXT] [--quantity NAME] [--json FILE]

Discs, rings, half discs, blocks and balls of any size, stiffness, density, viscosity and scheme hit planes at rest, moving planes and round
obstacles: from a touch at the start to flights of two lengths, sideways at up to 100 times the speed of the approach, under gravity with
rebounds, at rest. The reference is a motion on the same mesh that begins in flight one duration of contact before the touch. Compared are the
impulse of the first impact (until a pause of a quarter of it), that of the whole motion, the time from 1 to 99 % of it and the largest mean
force over four times t_w. Cases whose reference differs by more than a third of the tolerance between steps of t_w/8 and t_w/16 are listed and
not counted. Fails if one is off by more than three tolerances without a warning. About a second a case and tolerance.
"""

import json
import math
import os
import random
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import program

CIRCLE = """Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Point(3) = {0, 1, 0}; Point(4) = {-1, 0, 0}; Point(5) = {0, -1, 0};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Circle(3) = {4, 1, 5}; Circle(4) = {5, 1, 2}; Curve Loop(1) = {1, 2, 3, 4};
"""
HOLE = """Point(12) = {.7, 0, 0}; Point(13) = {0, .7, 0}; Point(14) = {-.7, 0, 0}; Point(15) = {0, -.7, 0};
Circle(11) = {12, 1, 13}; Circle(12) = {13, 1, 14}; Circle(13) = {14, 1, 15}; Circle(14) = {15, 1, 12}; Curve Loop(2) = {11, 12, 13, 14};
"""
BODIES = {  # the lowest point of each is at height −1; element size
    "disc": (CIRCLE + 'Plane Surface(1) = {1}; Physical Surface("body") = {1}; Physical Curve("low") = {3, 4};', 0.3),
    "ring": (CIRCLE + HOLE + 'Plane Surface(1) = {1, 2}; Physical Surface("body") = {1}; Physical Curve("low") = {3, 4};', 0.15),
    "half disc": ("""Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Point(4) = {-1, 0, 0}; Point(5) = {0, -1, 0};
Line(1) = {2, 1}; Line(2) = {1, 4}; Circle(3) = {4, 1, 5}; Circle(4) = {5, 1, 2}; Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1}; Physical Surface("body") = {1}; Physical Curve("low") = {3, 4};""", 0.25),
    "block": ("""Point(1) = {-.5, -1, 0}; Point(2) = {.5, -1, 0}; Point(3) = {.5, 0, 0}; Point(4) = {-.5, 0, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1}; Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1}; Physical Surface("body") = {1}; Physical Curve("low") = {1};""", 0.2),
    "ball": ("""SetFactory("OpenCASCADE"); Sphere(1) = {0, 0, 0, 1};
Physical Volume("body") = {1}; Physical Surface("low") = Surface{:};""", 0.5),
}
FIGURES = ("first impulse", "impulse", "duration", "peak")
WARNINGS = ("vibration", "accumulated error", "few steps in contact", "peak of the mesh", "rounding in flight")
FINE = (8, 16)  # steps of one length in the time in which a wave crosses an element


def drawn(rng: random.Random) -> dict:
    """Any case, in SI units."""
    mode = rng.choice(["flight"] * 6 + ["rebounds"] * 2 + ["rest"])
    obstacle = rng.choice(["plane"] * 7 + ["moving"] * 2 + ["round"] * 2)
    body = rng.choice(list(BODIES))
    if mode == "rest":
        body, obstacle = "block", "plane"
    length, young, density, poisson = 10 ** rng.uniform(-3, 1), 10 ** rng.uniform(5, math.log10(2e11)), 10 ** rng.uniform(3, 3.9), rng.uniform(0, 0.45)
    wave = math.sqrt(young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson)) / density)
    speed = wave * 10 ** rng.uniform(-5, math.log10(5e-2))
    gap = {"touch": 0.0, "tiny": 10 ** rng.uniform(-4, -2), "near": rng.uniform(0.01, 0.2), "far": rng.uniform(0, 2)}[
        rng.choice(["touch", "tiny", "far", "far", "near"])]  # fmt: skip
    crossing = length / wave
    contact = 6 * crossing * (wave / speed) ** 0.2 * (2.5 if body == "ring" else 1)  # about how long it lasts
    viscosity = {"none": 0.0, "weak": 10 ** rng.uniform(-3, -1.5), "strong": 10 ** rng.uniform(-1.5, 0)}[rng.choice(["none", "none", "weak", "strong"])]
    return {
        "body": body, "length": length, "young": young, "density": density, "poisson": poisson, "mode": mode, "obstacle": obstacle,
        "size": BODIES[body][1] * rng.uniform(0.8, 1.2), "contact": contact, "gap": 0.0 if mode == "rest" else gap * length,
        "speed": 0.0 if mode == "rest" else speed, "sideways": 0.0 if obstacle == "round" or rng.random() < 0.5 else speed * 10 ** rng.uniform(0, 2),
        "viscosity": young * crossing * viscosity, "scheme": rng.choice(["implicit", "stabilized", "massless"]),
        "gravity": {"flight": 0.0, "rebounds": 2 * speed / (contact * 10 ** rng.uniform(0.3, 1)), "rest": speed / contact}[mode],
        "share": rng.uniform(0.2, 1) if obstacle == "moving" else 0.0,  # of the approach that the obstacle makes
    }  # fmt: skip


def scene(case: dict, later: float) -> str:
    """The motion from `later` (s) on, until when the body flies."""
    in_space = case["body"] == "ball"

    def vector(up: object, sideways: object = 0.0) -> list:
        return [sideways, 0.0, up] if in_space else [sideways, up]

    def expressions(values: list) -> str:
        return json.dumps([value if isinstance(value, str) else repr(value) for value in values])

    height, of_obstacle = -case["length"] - case["gap"], case["share"] * case["speed"]
    if case["obstacle"] == "round":
        radius = 3 * case["length"]
        obstacle = f'shape = "ball", center = {vector(height - radius)}, radius = {radius!r}'
    else:
        point = f"{height + of_obstacle * later!r} + {of_obstacle!r}*t" if of_obstacle else repr(height)
        obstacle = f'shape = "half-space", point = {expressions(vector(point))}, normal = {vector(1.0)}'
    own, g, side = case["speed"] - of_obstacle, case["gravity"], case["sideways"]
    text = f"""[mesh]
file = "mesh.geo"
size = {case["size"] * case["length"]!r}
[time]
end = 1.0
step = 1.0
[material]
density = {case["density"]!r}
young = {case["young"]!r}
poisson = {case["poisson"]!r}
viscosity = {{ bulk = {case["viscosity"]!r}, shear = {case["viscosity"]!r} }}
[contact]
on = "low"
obstacle = {{ {obstacle} }}
initial = "project"
mass = "{"massless" if case["scheme"] == "massless" else "consistent"}"
[initial]
velocity = {expressions(vector(-own - g * later, side))}
displacement = {expressions(vector(-own * later - g * later**2 / 2, side * later))}
[output]
fields = []
tables = ["steps"]
"""
    return text + (f"[load]\ngravity = {vector(-g)}\n" if g else "")


@dataclass
class Motion:
    time: np.ndarray
    force: np.ndarray
    manifest: dict

    def __post_init__(self) -> None:
        self.sums = np.concatenate([[0], np.cumsum(np.diff(self.time) * self.force[1:])])

    def figures(self, wave: float) -> dict[str, float]:
        return {"first impulse": self.first_impulse(20 * wave), "impulse": self.sums[-1], "duration": self.until(0.99) - self.until(0.01),
                "peak": self.peak(4 * wave)}  # fmt: skip

    def until(self, part: float) -> float:
        """The time until a part of the impulse is there."""
        if not self.sums[-1] > 0:
            return 0.0
        at = part * self.sums[-1]
        i = np.searchsorted(self.sums, at)
        return self.time[i - 1] + (at - self.sums[i - 1]) / (self.sums[i] - self.sums[i - 1]) * (self.time[i] - self.time[i - 1])

    def peak(self, window: float) -> float:
        """The largest mean over a window, or over two steps where these are longer."""
        steps = np.diff(self.time)
        windows = np.maximum(window, steps + np.concatenate([[0], steps[:-1]]))
        return ((self.sums[1:] - np.interp(self.time[1:] - windows, self.time, self.sums)) / windows).max()

    def first_impulse(self, pause: float) -> float:
        """Until a pause of a quarter of the contact so far, and of this time."""
        closed = np.flatnonzero(self.force > 0)
        if not len(closed):
            return 0.0
        begin, end = self.time[closed[0] - 1], self.time[closed[0]]
        for k in closed[1:]:
            if self.time[k - 1] - end > np.maximum(0.25 * (end - begin), pause):
                break
            end = self.time[k]
        return float(np.interp(end, self.time, self.sums))


def simulate(folder: Path, name: str, text: str, scheme: str, time: dict[str, object]) -> Motion:
    (folder / f"{name}.toml").write_text(text)
    if scheme == "stabilized":
        time = {**time, "scheme": "contact-stabilized"}
    table = "{" + ", ".join(f"{key} = {json.dumps(value)}" for key, value in time.items()) + "}"
    program.output("signorini", "simulate", folder / f"{name}.toml", "--out", folder / name, "--quiet", "--set", f"time={table}",
                   OMP_NUM_THREADS=1)  # fmt: skip
    steps = np.genfromtxt(folder / name / "steps.csv", delimiter=",", names=True)
    return Motion(steps["time"], steps["normal_force"], json.loads((folder / name / "run.json").read_text()))


def compared(case: dict, tolerances: list[float], quantity: str, folder: Path) -> dict:
    """Figures of a case with chosen steps, and how far they are off."""
    dilated = "Volume{1};" if case["body"] == "ball" else "Surface{1};"
    (folder / "mesh.geo").write_text(f"{BODIES[case['body']][0]}\nDilate {{{{0, 0, 0}}, {case['length']!r}}} {{ {dilated} }}\n")
    speed, gravity, gap = case["speed"], case["gravity"], case["gap"]
    flight = (math.sqrt(speed**2 + 2 * gravity * gap) - speed) / gravity if gravity else gap / speed
    end = flight + case["contact"] * {"flight": 2.5, "rebounds": 12, "rest": 4}[case["mode"]]
    chosen = {tolerance: simulate(folder, f"tolerance-{tolerance}", scene(case, 0), case["scheme"],
                                  {"end": end, "step": "auto", "tolerance": tolerance, "quantity": quantity})
              for tolerance in tolerances}  # fmt: skip
    wave = chosen[tolerances[0]].manifest["steps"]["wave_time"]
    later = float(flight - np.minimum(flight, 0.4 * case["contact"]))
    fine = []
    for part in FINE:
        count = math.ceil((end - later) / (wave / part))
        fine.append(simulate(folder, f"fine-{part}", scene(case, later), case["scheme"], {"end": end - later, "step": (end - later) / count}).figures(wave))
    coarse, truth = fine

    def off(found: dict[str, float]) -> dict[str, float]:
        return {name: abs(found[name] - truth[name]) / truth[name] if truth[name] > 0 else float(found[name] > 0) for name in FIGURES}

    return {**case, "end": end, "truth": truth, "reference error": off(coarse),
            "chosen": {tolerance: {"errors": off(motion.figures(wave)), **{name: motion.manifest["steps"][name] for name in ("done", "made_again", "factorisations")},
                                   "warned": [one["name"] for one in motion.manifest["warnings"] if one["name"] in WARNINGS]}
                       for tolerance, motion in chosen.items()}}  # fmt: skip


def show(rows: list[dict], tolerance: float) -> list[str]:
    """Prints what a tolerance gives, and returns what is off by more than three of it in silence."""
    runs = [row["chosen"][tolerance] for row in rows]
    warned = [run for run in runs if run["warned"]]
    kinds = {name: sum(name in run["warned"] for run in runs) for name in WARNINGS}
    print(f"tolerance {tolerance:g}: warned of {len(warned)} of {len(runs)}: {', '.join(f'{name} {count}' for name, count in kinds.items())}; "
          f"{np.median([run['done'] for run in runs]):.0f} steps (median), {np.mean([run['made_again'] for run in runs]):.1f} made again and "
          f"{np.mean([run['factorisations'] for run in runs]):.1f} lengths (mean)")  # fmt: skip
    silent = []
    for name in FIGURES:
        counted = [(row, row["chosen"][tolerance]) for row in rows if row["truth"]["impulse"] > 0 and row["reference error"][name] <= tolerance / 3]
        told = [(row, run) for row, run in counted if name == "first impulse" or not run["warned"]]
        within = sum(run["errors"][name] <= tolerance for _, run in told)
        uncertain = [row["number"] for row in rows if row["reference error"][name] > tolerance / 3]
        print(f"  {name:13} within the tolerance in {within} of {len(told)}{'' if name == 'first impulse' else ' without a warning'}; "
              f"reference not certain: {len(uncertain)} {uncertain or ''}")  # fmt: skip
        silent += [f"case {row['number']}: {name} off by {run['errors'][name]:.1%} at {tolerance:g}" for row, run in counted
                   if not run["warned"] and run["errors"][name] > 3 * tolerance]  # fmt: skip
    return silent


def main() -> int:
    parser = program.options("bench impacts", __doc__)
    parser.add_argument("--count", type=int, default=200, help="cases")
    parser.add_argument("--seed", default="impacts", help="of the cases")
    parser.add_argument("--quantity", default="contact-force", choices=("contact-force", "displacement", "energy"), help="time.quantity")
    parser.add_argument("--tolerances", type=lambda text: [float(word) for word in text.split(",")], default=[1e-2, 1e-3], help="time.tolerance")
    options = parser.parse_args()

    def case(number: int) -> dict:
        with tempfile.TemporaryDirectory() as folder:
            return {"number": number, **compared(drawn(random.Random(f"{options.seed}/{number}")), options.tolerances, options.quantity, Path(folder))}

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        rows = list(pool.map(case, range(options.count)))
    program.write(options.json, rows)
    touched = sum(row["truth"]["impulse"] > 0 for row in rows)
    print(f"{touched} of {len(rows)} cases touch")
    silent = [text for tolerance in options.tolerances for text in show(rows, tolerance)]
    print("off by more than three tolerances without a warning:", *(silent or ["none"]), sep="\n  ")
    return 0 if touched > 0.8 * len(rows) and not silent else 1


if __name__ == "__main__":
    sys.exit(main())
