# SPDX-License-Identifier: GPL-3.0-or-later
"""What a start on coarse meshes saves: sweeps on the finest mesh and seconds to J* + 1e-6, beside a start from nothing.

usage: ./dev bench coarse [--sizes H …] [--iterations N] [--repeats N] [--json FILE]

The half disc's control problem by `lbfgs`, with the scene's time step on every mesh. J* is the least value that any of the runs on a
mesh finds, of N iterations from the first guess and N/2 from coarse meshes; what is left of J after these is far below 1e-6. Seconds are all that a run takes until then: mesh and
factor, the desired motion, the coarse meshes with theirs, the search. Runs take turns, and the least times count. About ten minutes.
"""

import csv
import json
import tempfile
from pathlib import Path

import numpy as np
import program

SCENE = program.ROOT / "scenes" / "half-disc.toml"
NEAR = 1e-6  # of J*, about a ten thousandth of it
SET_UP = ("mesh", "assembly", "solver", "desired state")


def run(folder: Path, size: float, start: str, iterations: int) -> dict:
    """The history of a search and its coarse levels."""
    out = folder / f"{size}-{start}"
    values = {"mesh.size": size, "optimizer.start": f'"{start}"', "optimizer.max_iterations": iterations, "optimizer.checkpoint": 0,
            "output.fields": "[]"}  # fmt: skip
    program.output("signorini", "optimize", SCENE, "--out", out, "--quiet", *program.sets(values))
    manifest = json.loads((out / "run.json").read_text())
    with open(out / "history.csv") as rows:
        history = [{key: float(text) for key, text in row.items()} for row in csv.DictReader(rows) if row]
    return {"history": history, "levels": manifest["optimizer"]["coarse_levels"], "unknowns": manifest["free_unknowns"],
            "set_up": sum(manifest["timings"][phase]["seconds"] for phase in SET_UP)}  # fmt: skip


def reached(found: dict, value: float) -> dict:
    """Sweeps and seconds to a value of J."""
    row = next(row for row in found["history"] if row["objective"] <= value)
    return {"iteration": int(row["iteration"]), "forward": int(row["forward_sweeps"]), "adjoint": int(row["adjoint_sweeps"]),
            "seconds": found["set_up"] + row["seconds"]}  # fmt: skip


def measured(folder: Path, size: float, iterations: int, repeats: int) -> dict:
    runs = {"guess": [], "coarse": []}
    for _ in range(repeats):
        for start, found in runs.items():
            found.append(run(folder, size, start, iterations if start == "guess" else iterations // 2))
    least = np.min([row["objective"] for found in runs.values() for one in found for row in one["history"]])
    result = {"size": size, "unknowns": runs["guess"][0]["unknowns"], "least": least}
    for start, found in runs.items():
        to_value = [reached(one, least + NEAR) for one in found]
        result[start] = {**to_value[0], "seconds": np.min([one["seconds"] for one in to_value]),
                         "first": found[0]["history"][0]["objective"], "last": found[0]["history"][-1]["objective"]}  # fmt: skip
    result["levels"] = runs["coarse"][0]["levels"]
    result["seconds_of_levels"] = np.min([sum(level["seconds"] for level in one["levels"]) for one in runs["coarse"]])
    return result


def show(r: dict) -> None:
    a, b = r["guess"], r["coarse"]
    print(f"{r['size']:6g}  {r['unknowns']:8d}  {r['least']:.8f}  {b['first'] - r['least']:9.1e}"
          f"  {a['forward']:4d} + {a['adjoint']:3d}  {b['forward']:4d} + {b['adjoint']:3d}  {a['seconds']:8.2f}  {b['seconds']:8.2f}"
          f"  {r['seconds_of_levels']:8.2f}  {b['seconds'] / a['seconds']:6.2f}  {abs(a['last'] - b['last']):8.1e}", flush=True)  # fmt: skip
    for level in r["levels"]:
        print(f"        size {level['size']:g}, step {level['step']:.3g}: {level['free_unknowns']} unknowns, {level['iterations']} iterations,"
              f" {level['forward_sweeps']} + {level['adjoint_sweeps']} sweeps, {level['seconds']:.2f} s, J = {level['objective']:.8f}:"
              f" {level['stop_reason']}", flush=True)  # fmt: skip


def main() -> int:
    parser = program.options("bench coarse", __doc__)
    parser.add_argument("--sizes", nargs="+", type=float, default=[0.5, 0.25, 0.125], metavar="H", help="element sizes, m")
    parser.add_argument("--iterations", type=int, default=42, metavar="N")
    parser.add_argument("--repeats", type=int, default=1, metavar="N")
    given = parser.parse_args()
    print("                                            sweeps to J* + 1e-6             seconds          of coarse\n"
          "  size  unknowns  J*          J_0 - J*      guess       coarse     guess    coarse    meshes   ratio  of J")  # fmt: skip
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for size in given.sizes:
            rows.append(measured(Path(folder), size, given.iterations, given.repeats))
            show(rows[-1])
    program.write(given.json, rows)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
