# SPDX-License-Identifier: GPL-3.0-or-later
"""Seconds of a contact step in units of the solve and products that no step can do without, all measured in the same run.

usage: ./dev bench [c0|scaling|space|effects|peers] [--ranks N …] [--sizes H …] [--repeats N] [--set KEY=VALUE] [--json FILE]

  c0       the half disc as shipped, at element sizes 0.5, 0.25, 0.125 and 0.0625 m (default; about 5 minutes)
  scaling  the half disc from 1 m to 1/32 m, time step in proportion, contact from the start (about 10 minutes)
  space    the half ball by conjugate gradients, from 20,000 to 400,000 unknowns, 100 steps (about half an hour)
  effects  the half disc with one effect after another: what each adds (about six minutes)
  peers    forward steps beside FreeFem++ and GetFEM (tests/bench/peers)

floor: one solve with D and the products with R and M, timed between the steps. Of each step's time over the repeats the
least counts. Times are noisy where others use the machine; the ratios are of neighbours in time.
"""

import json
import math
import tempfile
from pathlib import Path

import program
from program import ROOT

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


def measure(suite: str, size: float, ranks: int, repeats: int, more: list[str]) -> dict:
    scene, settings = overrides(suite, size)
    settings += more
    return json.loads(program.output("signorini-bench", scene, str(repeats), f"mesh.size={size!r}", *settings, ranks=ranks))


# The half disc, thrown down from its clamp; each effect adds to those before it, or takes the place of its name.
BODY = """
[mesh]
file = "{meshes}/half-disc.geo"
size = {size!r}
[time]
end = 7.5e-3
step = 5e-5
[[clamp]]
on = "top"
[initial]
velocity = ["0", "100*y"]
[material]
density = 1.0
young = 1e8
poisson = 0.3
"""
OBSTACLE = """
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, {height}], normal = [0, 1] }}
"""


def branches(*fractions: tuple[float, float]) -> str:
    """A Prony series with these g and k."""
    return "".join(f"[[material.prony]]\ng = {g}\nk = {k}\ntime = {10.0**-(4 - i)}\n" for i, (g, k) in enumerate(fractions))


def rubbed(contact: str, friction: float, belt: str = "") -> str:
    """A contact table with friction."""
    return contact.replace(" }\n", f"{belt} }}\nfriction = {friction}\n")


# Two discs that collide, of which the left one meets a plane or the right one.
DISCS = """
[mesh]
file = "{meshes}/two-discs.geo"
scale = {scale!r}
[time]
end = 0.1
step = 5e-4
[initial]
velocity = ["x < 0.51 ? 1 : 0", "0"]
[material]
density = 1.0
young = 1000.0
poisson = 0.3
"""
SIDE = '[contact]\non = "right side"\n'

SECTION = BODY.replace("half-disc.geo", "half-ball-section.geo")
EFFECTS = {
    "half section": {"body": SECTION},
    "half section, revolved": {"body": SECTION.replace("size =", 'model = "axisymmetric"\nsize =')},
    "elastic body": {"body": BODY},
    "+ viscosity": {"viscosity": "viscosity = { bulk = 1e4, shear = 1e4 }\n"},
    "+ contact never touched": {"contact": OBSTACLE.format(height=-100)},
    "+ contact": {"contact": OBSTACLE.format(height=-15.75)},
    "+ control": {"control": '[control]\nscale = 1e6\ninitial = ["0", "-0.1"]\n'},
    "+ objective": {"objective": '[objective]\ndesired = { control = ["0", "-1"] }\nalpha = 1e-2\ngamma = 7.5e-4\n'},
    "+ bounds": {"control": '[control]\nscale = 1e6\ninitial = ["0", "-0.1"]\nlower = -0.5\nupper = 0.5\n'},
    "+ Rayleigh damping": {"rayleigh": "[material.rayleigh]\nalpha = 10.0\nbeta = 1e-5\n"},
    "+ foundation": {"foundation": '[[foundation]]\non = "side"\nstiffness = { normal = 1e6 }\ndamping = { normal = 1e3 }\n'},
    "+ relaxation, g = k": {"prony": branches((0.3, 0.3))},
    "+ relaxation, g and k": {"prony": branches((0.3, 0.1))},
    "+ three branches": {"prony": branches((0.3, 0.1), (0.2, 0.1), (0.1, 0.2))},
    # beside "+ bounds"
    "+ friction, sticks": {"prony": "", "foundation": "", "rayleigh": "", "contact": rubbed(OBSTACLE.format(height=-15.75), 1)},
    "+ friction, slips": {"contact": rubbed(OBSTACLE.format(height=-15.75), 0.3, ', surface_velocity = ["1e3", "0"]')},
    # beside "+ bounds"
    "+ obstacle with mass": {"contact": OBSTACLE.format(height=-15.75).replace(" }\n", ", mass = 1e4 }\n")},
    "+ that turns": {"contact": OBSTACLE.format(height=-15.75).replace(" }\n", ", mass = 1e4, inertia = 1e6 }\n")},
    "two discs, plane": {
        "body": DISCS, "viscosity": "", "contact": SIDE + 'obstacle = { shape = "half-space", point = [0.51, 0], normal = [-1, 0] }\n',
        "control": '[control]\nscale = 1.0\ninitial = ["0", "-0.1"]\nlower = -0.5\nupper = 0.5\n',
    },
    "two discs, each other": {"contact": SIDE + 'against = "left side"\n'},
    "+ friction": {"contact": SIDE + 'against = "left side"\nfriction = 0.2\n'},
}  # fmt: skip


def effects(size: float, repeats: int) -> list[dict]:
    rows, tables = [], {}
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "effects.toml"
        for name, added in EFFECTS.items():
            tables |= added
            text = "".join(tables.values()).replace("{meshes}", str(ROOT / "meshes"))
            scene.write_text(text.replace("{size!r}", repr(size)).replace("{scale!r}", repr(2 * size)))
            rows.append({"effect": name, "size": size} | json.loads(program.output("signorini-bench-effects", scene, str(repeats))))
    return rows


def print_effects(rows: list[dict]) -> None:
    print("\n    size  effects                   steps  in contact   us per step: forward     bare  gradient  iteration"
          "   solves a step: forward  gradient   MB: factor  operators  condensation   assembled")  # fmt: skip
    for r in rows:
        seconds = {k: f"{1e6 * v:.1f}" if v else "-" for k, v in r["seconds_per_step"].items()}
        solves = [f"{r['solves'][k] / r['steps']:.2f}" if r["solves"][k] else "-" for k in ("forward", "gradient")]
        forms = [k.removeprefix("assembled ") for k in r["counters"] if k.startswith("assembled ")]
        print(f"{r['size']:8g}  {r['effect']:24s} {r['steps']:6d}  {r['contact_steps']:10d}  {seconds['forward']:>21s}"
              f"  {seconds['bare']:>7s}  {seconds['gradient']:>8s}  {seconds['iteration']:>9s}  {solves[0]:>23s}  {solves[1]:>8s}"
              f"  {r['bytes']['factor'] / 1e6:11.1f}  {r['bytes']['operators'] / 1e6:9.1f}  {r['bytes']['condensation'] / 1e6:12.2f}"
              f"   {', '.join(forms)}")  # fmt: skip
    for r in rows:
        if bare := r["seconds_per_step"]["bare"]:
            print(f"\nsize {r['size']:g}, {r['effect']}: {r['seconds_per_step']['forward'] / bare:.3f} times a loop that has"
                  f" never heard of contact, loads or control (displacements differ by {r['difference_to_bare']:.1e})")  # fmt: skip


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
    print("\n    size  unknowns  ranks   ms per step: forward  adjoint   setup s: mesh  assembly  solver   MB of a gradient: factor"
          "  operators  condensation  mesh and program  six motions    peak  rest, %")  # fmt: skip
    for r in rows:
        s, t, b = r["seconds"], r["setup_seconds"], r["bytes"]
        solver = [b[k] / 1e6 for k in ("factor", "operators", "condensation")]
        mesh, motions = b["resident_after_setup"] / 1e6 - sum(solver), 6 * b["trajectory"] / 1e6
        peak = b["peak_of_gradient"] / 1e6
        rest = 100 * (peak - sum(solver) - mesh - motions) / peak
        print(f"{r['size']:8g}  {r['free_unknowns']:8d}  {r['ranks']:5d}  {1e3 * s['forward_step']:21.3f}"
              f"  {1e3 * s['adjoint_step']:7.3f}  {t['mesh']:14.2f}  {t['assembly']:8.2f}  {t['solver']:6.2f}"
              f"  {solver[0]:24.1f}  {solver[1]:9.1f}  {solver[2]:12.1f}  {mesh:16.0f}  {motions:11.0f}  {peak:6.0f}  {rest:7.1f}")  # fmt: skip


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
    parser = program.options("bench", __doc__)
    parser.add_argument("suite", nargs="?", default="c0", choices=[*SUITES, "effects"])
    parser.add_argument("--sizes", nargs="+", type=float, metavar="H", help="element sizes, m")
    parser.add_argument("--ranks", nargs="+", type=int, default=[1], metavar="N")
    parser.add_argument("--repeats", type=int, metavar="N", help="default 5; in space 1")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="of the scene; not for effects")
    given = parser.parse_args()
    repeats = given.repeats or (1 if given.suite == "space" else 5)
    rows = []
    if given.suite == "effects":
        for size in given.sizes or [0.5, 0.125]:
            rows += effects(size, given.repeats or 20)
        print_effects(rows)
    for size in [] if given.suite == "effects" else given.sizes or SUITES[given.suite]:
        for ranks in given.ranks:
            rows.append(measure(given.suite, size, ranks, repeats, given.set))
            print(f"size {size:g}, {ranks} rank{'s' * (ranks > 1)}: {rows[-1]['solver']}", flush=True)
    if given.suite != "effects":
        print_steps(rows)
        print_costs(rows)
        print_growth(rows)
    program.write(given.json, rows)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
