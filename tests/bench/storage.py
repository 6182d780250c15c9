# SPDX-License-Identifier: GPL-3.0-or-later
"""What it costs to keep the states of a motion elsewhere than in memory, or to make them again: peak memory and seconds of an
optimization with as many steps as a long run has.

usage: ./dev bench storage [--sizes H …] [--steps N] [--iterations N] [--repeats N] [--json FILE]

The half disc, not clamped, is thrown onto a plane; a traction on its flat top is the control. Without iterations a run is one
value and one gradient; of the repeats the quickest counts. Checkpoints take a seventh and a hundredth of what all states of a motion
do. A run with 0.2 million unknowns and 2,000 steps: --sizes 0.0625 --iterations 1 --repeats 1 (about an hour, 8 GB in memory; all fields are stored, 20 GB on disk).
"""

import json
import tempfile
from pathlib import Path

import program
from program import ROOT

SCENE = """
[mesh]
file = "{meshes}/half-disc.geo"
size = {size!r}
[time]
end = 7.5e-3
step = {step!r}
[material]
density = 1.0
young = 1e8
poisson = 0.3
viscosity = {{ bulk = 1e4, shear = 1e4 }}
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, -15.1], normal = [0, 1] }}
[initial]
velocity = ["0", "-200"]
[control]
on = "top"
scale = 1e6
[objective]
desired = {{ displacement = ["0", "-0.75"] }}
alpha = 1e-4
[optimizer]
max_iterations = {iterations}
[trajectory]
{trajectory}
[output]
tables = ["history"]
[run]
invariants = "off"
"""


def storages(unknowns: int, steps: int) -> dict[str, str]:
    """By name."""
    whole = 8 * unknowns * steps
    budget = {part: f'storage = "checkpoints"\nbudget = {whole / part:.6g}' for part in (7, 100)}
    return {"memory": 'storage = "memory"', "disk": 'storage = "disk"'} | {f"checkpoints, 1/{part}": text for part, text in budget.items()}


def run(folder: Path, size: float, steps: int, iterations: int, trajectory: str) -> dict:
    scene = folder / "storage.toml"
    scene.write_text(SCENE.format(meshes=ROOT / "meshes", size=size, step=7.5e-3 / steps, iterations=iterations, trajectory=trajectory))
    program.output("signorini", "optimize", scene, "--out", folder / "out", "--quiet")
    found = json.loads((folder / "out/run.json").read_text())
    found["history"] = [line.split(",")[:9] for line in (folder / "out/history.csv").read_text().splitlines()]
    assert found["counters"]["VIs solved"] > 0, "no contact occurred"
    return found


def row(storage: str, run: dict) -> dict:
    seconds = {phase: run["timings"].get(phase, {"seconds": 0})["seconds"] for phase in
               ("forward", "objective", "adjoint", "states written", "states read", "states recomputed")}  # fmt: skip
    sweeps = run["optimizer"]
    return {"storage": storage, "free_unknowns": run["free_unknowns"], "steps": run["steps"]["asked"],
            "forward_sweeps": sweeps["forward_sweeps"], "seconds": seconds,
            "adjoint_sweeps": run["counters"]["adjoint sweeps"],  # that of the stored adjoint state too
            "recomputed_steps": run["counters"]["recomputed steps"], "peak_memory_bytes": run["peak_memory_bytes"]}  # fmt: skip


def seconds(run: dict) -> float:
    return sum(row("", run)["seconds"].values())


def show(r: dict, first: dict) -> None:
    s = r["seconds"]
    whole, usual = sum(s.values()), sum(first["seconds"].values())
    again = r["recomputed_steps"] / (r["steps"] * r["adjoint_sweeps"])
    print(f"{r['free_unknowns']:9d}  {r['steps']:5d}  {r['storage']:18s}  {r['peak_memory_bytes'] / 1e9:7.2f}  {r['forward_sweeps']:7d}"
          f"  {r['adjoint_sweeps']:7d}  {whole:7.1f}  {whole / usual:8.2f}  {s['states written']:7.1f}  {s['states read']:6.1f}"
          f"  {s['states recomputed']:8.1f}  {again:15.2f}", flush=True)  # fmt: skip


def main() -> int:
    parser = program.options("bench storage", __doc__)
    parser.add_argument("--sizes", nargs="+", type=float, default=[0.5, 0.25], metavar="H", help="element sizes, m")
    parser.add_argument("--steps", type=int, default=2000, metavar="N")
    parser.add_argument("--iterations", type=int, default=0, metavar="N")
    parser.add_argument("--repeats", type=int, default=3, metavar="N")
    given = parser.parse_args()
    print(" unknowns  steps  storage             peak GB  forward  adjoint  seconds  / memory  written    read  made anew"
          "  steps anew / step")  # fmt: skip
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for size in given.sizes:
            first, history = None, None
            unknowns = run(folder, size, 2, 0, 'storage = "memory"')["unknowns"]
            for storage, trajectory in storages(unknowns, given.steps).items():
                found = min((run(folder, size, given.steps, given.iterations, trajectory) for _ in range(given.repeats)), key=seconds)
                history = history or found["history"]
                assert found["history"] == history, f"{storage}: another search than that from memory"
                rows.append(row(storage, found))
                first = first or rows[-1]
                show(rows[-1], first)
    print("The searches are the same to the last bit.")
    program.write(given.json, rows)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
