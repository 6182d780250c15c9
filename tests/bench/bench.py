"""Seconds of a contact step in units of the solve and products that no step can do without, all measured in the same run.

usage: ./dev bench [c0|scaling|space|peers] [--ranks N …] [--sizes H …] [--repeats N] [--json FILE]

  c0       the half disc as shipped, at element sizes 0.5, 0.25, 0.125 and 0.0625 m (default; about 3 minutes)
  scaling  the half disc from 1 m to 1/32 m, time step in proportion, contact from the start (about 10 minutes)
  space    the half ball by conjugate gradients, from 20,000 to 400,000 unknowns, 100 steps (about half an hour)
  peers    forward steps beside FreeFem++ and GetFEM (tests/bench/peers)

floor: one solve with D and the products with R and M, timed between the steps. Of each step's time over the repeats the
least counts. Times are noisy where others use the machine; the ratios are of neighbours in time.
"""

import argparse
import json
import math
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]
DISC, BALL = ROOT / "scenes" / "half-disc.toml", ROOT / "scenes" / "half-ball.toml"


def overrides(suite: str, size: float) -> tuple[Path, list[str]]:
    """The scene of a suite at one size, near the reference control, where the gradient is not zero."""
    step = 5e-5 * size / 0.5
    if suite == "c0":
        return DISC, ['control.initial=["0", "-0.9"]']
    if suite == "scaling":  # touching at once, so that few steps show contact
        return DISC, ['control.initial=["0", "-0.9"]', f"time.step={step!r}", f"time.end={40 * step!r}",
                      "contact.obstacle.point=[0, -15]"]  # fmt: skip
    return BALL, ['control.initial=["0", "0", "-0.9"]', f"time.step={step!r}", f"time.end={100 * step!r}",
                  'solver.linear="iterative"']  # fmt: skip


SUITES = {"c0": [0.5, 0.25, 0.125, 0.0625], "scaling": [2.0**-k for k in range(6)], "space": [0.97, 0.48, 0.33]}


def measure(suite: str, size: float, ranks: int, repeats: int) -> dict:
    scene, settings = overrides(suite, size)
    command = ["signorini-bench", str(scene), str(repeats), f"mesh.size={size!r}", *settings]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks), *command]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"signorini-bench ended with {done.returncode}:\n{done.stderr}")
    return json.loads(done.stdout)


def print_steps(rows: list[dict]) -> None:
    print("\n    size  unknowns  ranks  solver               steps  in contact   solve ms  products ms   step/floor: free"
          "  contact   adjoint: free  contact   gradient/forward")  # fmt: skip
    for r in rows:
        s, q = r["seconds"], r["ratios"]
        cell = {k: f"{v:.3f}" if v else "-" for k, v in q.items()}
        print(f"{r['size']:8g}  {r['free_unknowns']:8d}  {r['ranks']:5d}  {r['solver'].split(' (')[0]:20s} {r['steps']:5d}"
              f"  {r['contact_steps']:10d}  {1e3 * s['solve']:9.3f}  {1e3 * s['products']:11.3f}"
              f"  {cell['contact_free_step']:>17s}  {cell['contact_step']:>7s}  {cell['adjoint_contact_free_step']:>14s}"
              f"  {cell['adjoint_contact_step']:>7s}  {q['gradient']:17.2f}")  # fmt: skip


def print_costs(rows: list[dict]) -> None:
    print("\n    size  unknowns  ranks   ms per step: forward  adjoint   setup s: mesh  assembly  solver   MB: factor  operators"
          "  condensation  trajectory    rest    peak")  # fmt: skip
    for r in rows:
        s, t, b = r["seconds"], r["setup_seconds"], r["bytes"]
        parts = ("factor", "operators", "condensation", "trajectory")
        megabytes = [b[k] / 1e6 for k in parts]
        megabytes += [b["peak"] / 1e6 - sum(megabytes), b["peak"] / 1e6]
        print(f"{r['size']:8g}  {r['free_unknowns']:8d}  {r['ranks']:5d}  {1e3 * s['forward_step']:21.3f}"
              f"  {1e3 * s['adjoint_step']:7.3f}  {t['mesh']:14.2f}  {t['assembly']:8.2f}  {t['solver']:6.2f}"
              f"  {megabytes[0]:11.1f}  {megabytes[1]:9.1f}  {megabytes[2]:12.1f}  {megabytes[3]:10.1f}  {megabytes[4]:6.0f}"
              f"  {megabytes[5]:6.0f}")  # fmt: skip


def print_growth(rows: list[dict]) -> None:
    """Exponents of growth in the unknowns, over the whole series (least squares) and from each size to the next."""
    quantities = {
        "seconds per forward step": lambda r: r["seconds"]["forward_step"],
        "factor, operators, condensation": lambda r: sum(r["bytes"][k] for k in ("factor", "operators", "condensation")),
    }
    for ranks in sorted({r["ranks"] for r in rows}):
        series = [r for r in rows if r["ranks"] == ranks]
        if len(series) < 2:
            continue
        n = [math.log(r["free_unknowns"]) for r in series]
        print(f"\ngrowth like n^p on {ranks} rank{'s' * (ranks > 1)}:")
        for name, value in quantities.items():
            v = [math.log(value(r)) for r in series]
            slope = sum((a - sum(n) / len(n)) * b for a, b in zip(n, v)) / sum((a - sum(n) / len(n)) ** 2 for a in n)
            local = [(v[i + 1] - v[i]) / (n[i + 1] - n[i]) for i in range(len(n) - 1)]
            print(f"  {name}: p = {slope:.2f} (from size to size {', '.join(f'{p:.2f}' for p in local)})")


def main() -> int:
    parser = argparse.ArgumentParser(prog="./dev bench", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("suite", nargs="?", default="c0", choices=SUITES)
    parser.add_argument("--sizes", nargs="+", type=float, metavar="H", help="element sizes, m")
    parser.add_argument("--ranks", nargs="+", type=int, default=[1], metavar="N")
    parser.add_argument("--repeats", type=int, metavar="N", help="default 5; in space 1")
    parser.add_argument("--json", type=Path, metavar="FILE", help="where the figures go too")
    given = parser.parse_args()
    repeats = given.repeats or (1 if given.suite == "space" else 5)
    rows = []
    for size in given.sizes or SUITES[given.suite]:
        for ranks in given.ranks:
            rows.append(measure(given.suite, size, ranks, repeats))
            print(f"size {size:g}, {ranks} rank{'s' * (ranks > 1)}: {rows[-1]['solver']}", flush=True)
    print_steps(rows)
    print_costs(rows)
    print_growth(rows)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=2) + "\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
