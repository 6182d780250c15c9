# SPDX-License-Identifier: GPL-3.0-or-later
"""What steps of varying length save: errors and seconds beside those of steps of one length.

usage: ./dev bench steps [SCENE …] [--json FILE]

By default the rubber ring and the hard ball that are dropped 0.2 m, which touch once, the half disc that is pushed onto its plane, and the bar that
hits it. Of drops, errors of the duration of contact, from the first touch to the last release within a part of a step, and of
its impulse; of the others, the error of the displacement of a point of the contact surface, in the mean square over time. All are relative to the
motion of the smallest tolerance; seconds are those of the time steps with their factorisations. About ten minutes, most of it
for steps of one length.
"""

import json
import tempfile
import tomllib
from pathlib import Path

import numpy as np
import program

SCENES = {  # tolerances, and numbers of steps of one length
    "drop-ring": ((1e-4, 1e-3, 5e-3, 2e-2, 1e-1), (10000, 2500, 1000, 500, 250)),
    "drop-ball": ((1e-4, 1e-3, 3e-3, 1e-2, 1e-1), (20500, 10250, 5125)),
    "half-disc": ((1e-6, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2), (4800, 2400, 1200, 600, 300, 150, 75)),
    "bar-impact": ((1e-6, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2), (7680, 3840, 1920, 960, 480, 240, 120)),
}
CONTINUOUS = {  # a point of the contact surface, and what else the scene takes
    "half-disc": ("[0, -15]", {"mesh.size": 0.25, "control.initial": '["0", "-1"]'}),
    "bar-impact": ("[0, 0]", {"mesh.size": 0.05}),
}


def contact(file: Path) -> tuple[float, float]:
    """Duration (s) and impulse (N s) of contact."""
    steps = np.genfromtxt(file, delimiter=",", names=True)
    time, gap, force = steps["time"], steps["min_gap"], steps["normal_force"]
    length = np.diff(time, prepend=np.nan)
    touching = np.flatnonzero(force > 0)
    assert len(touching) > 1, "no contact occurred"
    first, last = touching[0], touching[-1]
    assert last + 2 < len(time), "contact had not ended"

    def crossing(near: int, far: int, between: float, step: float) -> float:
        return min(step, between * gap[near] / (gap[far] - gap[near])) if gap[far] > gap[near] else step / 2

    start = time[first - 1] + crossing(first - 1, first - 2, length[first - 1], length[first])
    end = time[last + 1] - crossing(last + 1, last + 2, length[last + 2], length[last + 1])
    return end - start, float(np.sum(length[1:] * force[1:]))


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
    found = {"motion": motion(out / "probes.csv")} if scene in CONTINUOUS else dict(zip(("duration", "impulse"), contact(out / "steps.csv")))
    seconds = run["timings"]["forward"]["seconds"] + run["timings"]["solver"]["seconds"] - run["timings"]["balances"]["seconds"]
    return {"scene": scene, "steps": run["steps"]["done"], "seconds": seconds, "found": found,
            **{key: run["steps"][key] for key in ("made_again", "factorisations") if key in run["steps"]}}  # fmt: skip


def main() -> None:
    parser = program.options("bench steps", __doc__)
    parser.add_argument("scenes", nargs="*", choices=[*SCENES, []], default=list(SCENES), metavar="SCENE")
    options = parser.parse_args()
    rows = []
    for scene in options.scenes:
        tolerances, counts = SCENES[scene]
        time = tomllib.loads((program.ROOT / "scenes" / f"{scene}.toml").read_text())["time"]
        exact = None
        for tolerance, count in [(t, None) for t in tolerances] + [(None, n) for n in counts]:
            kept = {key: value for key, value in time.items() if key not in ("step", "tolerance") and (tolerance or key in ("end", "scheme"))}
            table = {**kept, **({"step": "auto", "tolerance": tolerance} if tolerance else {"step": time["end"] / count})}
            settings = {"time": "{" + ", ".join(f"{key} = {json.dumps(value)}" for key, value in table.items()) + "}"}
            with tempfile.TemporaryDirectory() as folder:
                row = measure(Path(folder), scene, settings)
            exact = exact or row
            row["tolerance"] = tolerance
            row["errors"] = {name: float(np.linalg.norm(value - exact["found"][name]) / np.linalg.norm(exact["found"][name]))
                             for name, value in row["found"].items()}  # fmt: skip
            if row is exact:
                print(f"{scene:<11}{'steps':>7}{'again':>7}{'lengths':>9}{'seconds':>9}" + "".join(f"{name:>12}" for name in row["errors"]))
            rows.append({key: value for key, value in row.items() if key != "found"})
            print(f"{'':<11}{row['steps']:>7}{row.get('made_again', ''):>7}{row.get('factorisations', 1):>9}"
                  f"{row['seconds']:>9.2f}" + "".join(f"{'-' if row is exact else f'{error:.1e}':>12}" for error in row["errors"].values()), flush=True)  # fmt: skip
    program.write(options.json, rows)


if __name__ == "__main__":
    main()
