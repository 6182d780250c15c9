# SPDX-License-Identifier: GPL-3.0-or-later
"""Iterations of conjugate gradients for steps longer than a wave takes to cross an element, in space.

usage: ./dev bench courant [--sizes H …] [--courant C …] [--ranks N …] [--block-jacobi] [--json FILE]

The half ball under a constant force: it falls onto a plane that it touches from the start, for five steps. The Courant number is that
of the pressure wave, c τ / size. Iterations a solve (a contact step solves once for each active set that it tries), seconds of the
solver's set-up, which has the trials, and of a step; by the preconditioner that the program chooses and, if asked for, by block Jacobi too.
What that leaves unsolved after 2,000 iterations is shown as such. About twenty minutes, most of it for a million unknowns.
"""

import json
import tempfile
from pathlib import Path

import program

SCENE = """
[mesh]
file = "{meshes}/half-ball.geo"
size = {size!r}
[time]
step = {step!r}
end = {end!r}
[material]
density = 1.0
young = 1e8
poisson = 0.3
[[clamp]]
on = "top"
[load]
body = ["0", "0", "-1e5"]
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, 0, -15], normal = [0, 0, 1] }}
[output]
fields = []
tables = []
[run]
invariants = "off"
[solver]
linear = "iterative"
"""
SPEED = (1e8 * (1 - 0.3) / (1 + 0.3) / (1 - 2 * 0.3)) ** 0.5  # m/s, of pressure waves
STEPS = 5


def measure(folder: Path, size: float, courant: float, ranks: int, options: list[str]) -> dict | None:
    scene, out = folder / "long.toml", folder / "run"
    step = courant * size / SPEED
    scene.write_text(SCENE.format(meshes=program.ROOT / "meshes", size=size, step=step, end=STEPS * step))
    for file in out.glob("*"):
        file.unlink()
    try:
        program.output("signorini", "simulate", scene, "--out", out, "--quiet", *options, ranks=ranks, OMP_NUM_THREADS=1)
    except SystemExit as failed:
        if "DIVERGED_ITS" not in str(failed):
            raise
        return None
    run = json.loads((out / "run.json").read_text())
    assert run["counters"]["VIs solved"] > 0, "no contact occurred"
    c, t = run["counters"], run["timings"]
    return {"unknowns": run["free_unknowns"], "solver": run["solver"], "iterations": c["iterations of conjugate gradients"] / c["solves with D"],
            "solves": c["solves with D"], "setup": t["solver"]["seconds"], "step": t["forward"]["seconds"] / STEPS}  # fmt: skip


def main() -> int:
    parser = program.options("bench courant", __doc__)
    parser.add_argument("--sizes", nargs="+", type=float, default=[0.79, 0.52, 0.36, 0.242], metavar="H", help="element sizes, m")
    parser.add_argument("--courant", nargs="+", type=float, default=[1, 100, 1e4], metavar="C")
    parser.add_argument("--ranks", nargs="+", type=int, default=[2], metavar="N")
    parser.add_argument("--block-jacobi", action="store_true", help="by block Jacobi too")
    given = parser.parse_args()
    print("unknowns  ranks  Courant   as chosen: iterations a solve  set-up s  s a step  by"
          + "            block Jacobi: iterations  set-up s  s a step" * given.block_jacobi)  # fmt: skip
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for size in given.sizes:
            for ranks in given.ranks:
                for courant in given.courant:
                    chosen = measure(Path(name), size, courant, ranks, [])
                    plain = None
                    if given.block_jacobi:
                        plain = measure(Path(name), size, courant, ranks, ["--", "-step_pc_type", "pbjacobi"])
                    assert chosen, "the solver chosen did not solve"
                    rows.append({"size": size, "ranks": ranks, "courant": courant, "chosen": chosen, "block Jacobi": plain})
                    others = "more than 2000" if given.block_jacobi else ""
                    if plain:
                        others = f"{plain['iterations']:10.1f}  {plain['setup']:8.2f}  {plain['step']:8.2f}"
                    print(f"{chosen['unknowns']:8d}  {ranks:5d}  {courant:7g}   {chosen['iterations']:29.1f}  {chosen['setup']:8.2f}"
                          f"  {chosen['step']:8.2f}  {chosen['solver'].split(' (')[0]:16s}  {others:>36s}", flush=True)  # fmt: skip
    program.write(given.json, rows)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
