"""What steps of varying length save: errors and seconds beside those of steps of one length.

usage: ./dev bench steps [SCENE …] [--json FILE]

Scenes that touch once: by default the rubber ring and the hard ball that are dropped 0.2 m. Errors of the duration of contact, from the first touch to the
last release within a part of a step, and of its impulse are relative to the motion of the smallest tolerance; seconds are those of
the time steps with their factorisations. About ten minutes, most of it for steps of one length.
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


def measure(folder: Path, scene: str, settings: dict[str, object]) -> dict:
    out = folder / "run"
    program.output("signorini", "simulate", program.ROOT / "scenes" / f"{scene}.toml", "--out", out, "--quiet",
                   *program.sets({"output.fields": "[]", "output.tables": '["steps"]', **settings}))
    run = json.loads((out / "run.json").read_text())
    duration, impulse = contact(out / "steps.csv")
    seconds = run["timings"]["forward"]["seconds"] + run["timings"]["solver"]["seconds"] - run["timings"]["balances"]["seconds"]
    return {"scene": scene, "steps": run["steps"]["done"], "seconds": seconds, "duration": duration, "impulse": impulse,
            **{key: run["steps"][key] for key in ("made_again", "factorisations") if key in run["steps"]}}  # fmt: skip


def main() -> None:
    parser = program.options("bench steps", __doc__)
    parser.add_argument("scenes", nargs="*", choices=[*SCENES, []], default=list(SCENES), metavar="SCENE")
    options = parser.parse_args()
    rows = []
    print(f"{'scene':<11}{'steps':>7}{'again':>7}{'lengths':>9}{'seconds':>9}{'duration':>12}{'impulse':>12}", flush=True)
    for scene in options.scenes:
        tolerances, counts = SCENES[scene]
        time = tomllib.loads((program.ROOT / "scenes" / f"{scene}.toml").read_text())["time"]
        exact = None
        for tolerance, count in [(t, None) for t in tolerances] + [(None, n) for n in counts]:
            settings = ({"time.tolerance": tolerance} if tolerance else
                        {"time": f"{{end={time['end']!r}, step={time['end'] / count!r}, scheme=\"{time['scheme']}\"}}"})  # fmt: skip
            with tempfile.TemporaryDirectory() as folder:
                row = measure(Path(folder), scene, settings)
            exact = exact or row
            row["tolerance"] = tolerance
            errors = [abs(row[name] / exact[name] - 1) for name in ("duration", "impulse")]
            rows.append(row)
            print(f"{f'{scene}' if row is exact else '':<11}{row['steps']:>7}{row.get('made_again', ''):>7}{row.get('factorisations', 1):>9}"
                  f"{row['seconds']:>9.2f}" + "".join(f"{'-' if row is exact else f'{error:.1e}':>12}" for error in errors), flush=True)  # fmt: skip
    program.write(options.json, rows)


if __name__ == "__main__":
    main()
