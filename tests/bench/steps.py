# SPDX-License-Identifier: GPL-3.0-or-later
"""What steps of varying length save: errors and cost beside those of steps of one length.

usage: ./dev bench steps [SCENE …] [--json FILE]

By default the rubber ring and the hard ball that are dropped 0.2 m, which touch once, the half disc that is pushed onto its plane, and the bar that
hits it. Of drops, errors of the duration of contact, from 1 to 99 % of the impulse, of the impulse and of the sustained peak; of the others, the error of the
displacement of a point of the contact surface, in the mean square over time. All are relative to the motion of the shortest
steps of one length, within eight or so of which a wave crosses an element in contact: still shorter ones let single nodes bounce. Seconds are those of the time steps, and of the factorisations apart. The last columns are the steps, repeated ones included, and the seconds without
factorisations over those of steps of one length with the same error, by interpolation between these. About fifteen minutes, most of it for steps
of one length.
"""

import json
import tempfile
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import program

SCENES = {  # tolerances, and numbers of steps of one length
    "drop-ring": ((1e-3, 5e-3, 1e-2, 2e-2), (40000, 10000, 5000, 2500, 1000, 500, 250)),
    "drop-ball": ((1e-3, 3e-3, 1e-2), (82000, 41000, 20500, 10250, 5125)),
    "half-disc": ((1e-3, 3e-3, 1e-2, 3e-2), (9600, 4800, 2400, 1200, 600, 300, 150, 75)),
    "bar-impact": ((1e-3, 3e-3, 1e-2, 3e-2), (15360, 7680, 3840, 1920, 960, 480, 240, 120)),
}
CONTINUOUS = {  # a point of the contact surface, and what else the scene takes
    "half-disc": ("[0, -15]", {"mesh.size": 0.25, "control.initial": '["0", "-1"]'}),
    "bar-impact": ("[0, 0]", {"mesh.size": 0.05}),
}


def contact(run: dict) -> tuple[float, float, float]:
    """Duration (s), impulse (N s) and sustained peak (N) of contact."""
    found = run["impact"]["all"]
    assert found["contact_time"] > 0 and run["impact"]["ended"], "no contact occurred, or it had not ended"
    return found["impulse_duration"], found["normal_impulse"], found["sustained_peak"]


def motion(file: Path) -> np.ndarray:
    """Vertical displacement (m) of the probe at 1000 times, quadratic within each step."""
    table = np.genfromtxt(file, delimiter=",", names=True)
    t, y, v = table["time"], table["pointdisplacement_y"], table["pointvelocity_y"]
    at = np.linspace(0, t[-1], 1001)[1:]
    k = np.clip(np.searchsorted(t, at, side="left"), 1, len(t) - 1)
    tau = t[k] - t[k - 1]
    s = (at - t[k - 1]) / tau
    # Within a step the velocity is linear, and so the displacement quadratic.
    return y[k - 1] + s * (y[k] - y[k - 1]) + tau / 2 * s * (1 - s) * (v[k - 1] - v[k])


def measure(folder: Path, scene: str, settings: dict[str, object]) -> dict:
    out = folder / "run"
    if scene in CONTINUOUS:
        point, more = CONTINUOUS[scene]
        settings = {**settings, **more, "output.probe": f'[{{ name = "point", point = {point} }}]'}
    program.output("signorini", "simulate", program.ROOT / "scenes" / f"{scene}.toml", "--out", out, "--quiet",
                   *program.sets({"output.fields": "[]", "output.tables": '["steps", "probes"]', **settings}))
    run = json.loads((out / "run.json").read_text())
    found = {"motion": motion(out / "probes.csv")} if scene in CONTINUOUS else dict(zip(("duration", "impulse", "peak"), contact(run)))
    seconds = {phase: run["timings"][phase]["seconds"] for phase in ("forward", "solver", "balances")}
    factors = run["steps"].get("factorisation_seconds", seconds["solver"])
    return {"scene": scene, "steps": run["steps"]["done"], "again": run["steps"].get("made_again", 0), "lengths": run["steps"].get("factorisations", 1),
            "seconds": seconds["forward"] + seconds["solver"] - seconds["balances"] - factors, "factor_seconds": factors, "found": found}  # fmt: skip


def over_uniform(row: dict, uniform: list[dict], cost: Callable[[dict], float]) -> float | None:
    """The cost of a row over that of equal steps with the same error, the largest of all quantities; absent beyond their range."""
    ratios = []
    for name, error in row["errors"].items():
        known = sorted((one["errors"][name], cost(one)) for one in uniform)
        errors, costs = (np.log([one[i] for one in known]) for i in (0, 1))
        if not errors[0] <= np.log(error) <= errors[-1]:
            return None
        ratios.append(cost(row) / np.exp(np.interp(np.log(error), errors, costs)))
    return np.max(ratios)


def main() -> None:
    parser = program.options("bench steps", __doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    options = parser.parse_args()
    if unknown := set(options.scenes) - set(SCENES):
        parser.error(f"no scene {', '.join(unknown)}; choose from {', '.join(SCENES)}")
    rows = []
    for scene in options.scenes or SCENES:
        tolerances, counts = SCENES[scene]
        time = tomllib.loads((program.ROOT / "scenes" / f"{scene}.toml").read_text())["time"]
        of_scene: list[dict] = []
        for tolerance, count in [(t, None) for t in tolerances] + [(None, n) for n in counts]:
            kept = {key: value for key, value in time.items() if key not in ("step", "tolerance") and (tolerance or key in ("end", "scheme"))}
            table = {**kept, **({"step": "auto", "tolerance": tolerance} if tolerance else {"step": time["end"] / count})}
            settings = {"time": "{" + ", ".join(f"{key} = {json.dumps(value)}" for key, value in table.items()) + "}"}
            with tempfile.TemporaryDirectory() as folder:
                row = measure(Path(folder), scene, settings)
            of_scene.append(row)
            row["tolerance"] = tolerance
        finest = next(row for row in of_scene if row["tolerance"] is None)
        for row in of_scene:
            row["errors"] = {name: float(np.linalg.norm(value - finest["found"][name]) / np.linalg.norm(finest["found"][name]))
                             for name, value in row["found"].items()}  # fmt: skip
        uniform = [row for row in of_scene if row["tolerance"] is None and row is not finest]
        print(f"{scene:<11}{'steps':>7}{'again':>7}{'lengths':>9}{'seconds':>9}{'factors':>9}" + "".join(f"{name:>12}" for name in row["errors"]) + "  over one length")
        for row in of_scene:
            if row["tolerance"]:
                row["over_steps"] = over_uniform(row, uniform, lambda one: one["steps"] + one["again"])
                row["over_seconds"] = over_uniform(row, uniform, lambda one: one["seconds"])
            ratios = [f"{row[key]:.2f} of {key[5:]}" for key in ("over_steps", "over_seconds") if row.get(key)]
            print(f"{row['tolerance'] or '':<11}{row['steps']:>7}{row['again']:>7}{row['lengths']:>9}{row['seconds']:>9.2f}{row['factor_seconds']:>9.2f}"
                  + "".join(f"{'-' if row is finest else f'{error:.1e}':>12}" for error in row["errors"].values()) + "  " + ", ".join(ratios), flush=True)  # fmt: skip
        rows += [{key: value for key, value in row.items() if key != "found"} for row in of_scene]
    program.write(options.json, rows)


if __name__ == "__main__":
    main()
