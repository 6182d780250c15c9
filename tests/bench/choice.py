# SPDX-License-Identifier: GPL-3.0-or-later
"""What solver.linear = "auto" chooses, beside each way forced: seconds of forward runs and searches in the plane and in space.

usage: ./dev bench choice [--cases NAME …] [--ranks N …] [--steps N] [--sweeps N] [--repeats N] [--json FILE]

A half disc and a half ball, clamped at the top, are thrown onto a plane that they nearly touch. A run makes so many steps, a search
so many sweeps over them (of L-BFGS). Set-up of the solver and the steps count, not the mesh and its assembly; the ways take turns, and
of the repeats the quickest counts.. About half an hour.
"""

import json
import tempfile
from pathlib import Path

import numpy as np
import program
from program import ROOT

SCENE = """
[mesh]
file = "{meshes}/{mesh}.geo"
size = {size!r}
[time]
step = {step!r}
end = {end!r}
[[clamp]]
on = "top"
[initial]
velocity = [{still}, "100*{up}"]
[material]
density = 1.0
young = 1e8
poisson = 0.3
viscosity = {{ bulk = 1e4, shear = 1e4 }}
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [{below}, -15.01], normal = [{flat}, 1] }}
[output]
fields = []
tables = ["history"]
[run]
invariants = "off"
[solver]
linear = "{linear}"
"""
SEARCH = """
[control]
scale = 1e6
[objective]
desired = {{ displacement = [{still}, "-0.1"] }}
alpha = 1e-4
[optimizer]
start = "guess"
checkpoint = 0
tolerance = 1e-12
max_iterations = {iterations}
"""
CASES = {"disc": (2, 0.25), "disc-fine": (2, 0.125), "ball": (3, 0.97), "ball-fine": (3, 0.72)}
WAYS = ("auto", "direct", "iterative")
PHASES = ("solver", "forward", "adjoint", "linearised")


def measure(case: str, verb: str, ranks: int, steps: int, sweeps: int, linear: str, folder: Path) -> dict:
    dim, size = CASES[case]
    step = 1e-4 * size
    scene, out = folder / f"{case}.toml", folder / "run"
    flat = ["0"] * (dim - 1)
    text = SCENE + (SEARCH if verb == "optimize" else "")
    scene.write_text(text.format(meshes=ROOT / "meshes", mesh={2: "half-disc", 3: "half-ball"}[dim], size=size, step=step, end=steps * step,
                                 still=", ".join(['"0"'] * (dim - 1)), up="xyz"[dim - 1], below=", ".join(flat), flat=", ".join(flat),
                                 linear=linear, iterations=sweeps // 2 - 1))  # fmt: skip
    for file in out.glob("*"):
        file.unlink()
    program.output("signorini", verb, scene, "--out", out, "--quiet", ranks=ranks)
    run = json.loads((out / "run.json").read_text())
    assert run["counters"]["VIs solved"] > 0, "no contact occurred"
    seconds = {phase: run["timings"].get(phase, {"seconds": 0})["seconds"] for phase in PHASES}
    return {"case": case, "verb": verb, "ranks": ranks, "linear": linear, "free_unknowns": run["free_unknowns"], "solver": run["solver"],
            "sweeps": run.get("optimizer", {}).get("forward_sweeps", 1) + run["counters"].get("adjoint sweeps", 0),
            "phases": seconds, "seconds": sum(seconds.values())}  # fmt: skip


def main() -> int:
    parser = program.options("bench choice", __doc__)
    parser.add_argument("--cases", nargs="+", default=[*CASES], choices=[*CASES], metavar="NAME", help=", ".join(CASES))
    parser.add_argument("--verbs", nargs="+", default=["simulate", "optimize"], choices=["simulate", "optimize"])
    parser.add_argument("--ranks", nargs="+", type=int, default=[1, 2], metavar="N")
    parser.add_argument("--steps", type=int, default=50, metavar="N")
    parser.add_argument("--sweeps", type=int, default=50, metavar="N")
    parser.add_argument("--repeats", type=int, default=1, metavar="N")
    given = parser.parse_args()
    rows = []
    print("case       unknowns  verb      ranks  sweeps   seconds (set-up): auto               direct            iterative"
          "   auto/best  chosen", flush=True)  # fmt: skip
    with tempfile.TemporaryDirectory() as name:
        for case in given.cases:
            for verb in given.verbs:
                for ranks in given.ranks:
                    best: dict[str, dict] = {}
                    for _ in range(given.repeats):
                        for linear in WAYS:
                            row = measure(case, verb, ranks, given.steps, given.sweeps, linear, Path(name))
                            if linear not in best or row["seconds"] < best[linear]["seconds"]:
                                best[linear] = row
                    rows += best.values()
                    auto = best["auto"]
                    cells = [f"{best[linear]['seconds']:9.2f} ({best[linear]['phases']['solver']:7.2f})" for linear in WAYS]
                    ratio = auto["seconds"] / np.min([best[linear]["seconds"] for linear in WAYS[1:]])
                    print(f"{case:10s} {auto['free_unknowns']:8d}  {verb:8s}  {ranks:5d}  {auto['sweeps']:6d}   {cells[0]:>22s}  {cells[1]:>19s}"
                          f"  {cells[2]:>19s}   {ratio:9.2f}  {auto['solver']}", flush=True)  # fmt: skip
    program.write(given.json, rows)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
