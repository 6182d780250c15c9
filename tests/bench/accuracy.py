# SPDX-License-Identifier: GPL-3.0-or-later
"""What accuracy costs: studies of the cases whose solutions are known and of the half disc, and what each decade of a solver's
tolerance costs and buys.

usage: ./dev bench accuracy [CASE …] [--out FOLDER]

Leaves a study's folder for each case and work_precision.png in it; study.csv of each is committed as tests/bench/accuracy/CASE.csv.
  c0             the half disc: J, displacement and gradient against the finest rung
  drop-ring      a rubber ring and (drop-ball) a hard ball after a fall of 0.2 m, and (drop-test) a ball that hits a plate:
                 steps of one length beside those that the motion chooses, against the finest rung
  bar-impact     B2, bouncing-bar B3, hertz-press H1, standing-wave M1: against the exact solution
  prices         what --dry-run says of ladders in the plane and in space, and what they take: one line each
  solvers        tolerances of the iterative solver, of the full VI and of the optimizer: one line each
"""

import argparse
import csv
import json
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
SCENES = ROOT / "scenes"
ALL_SCHEMES = "contact-implicit,contact-stabilized,massless"


def steps(first: float, count: int) -> str:
    return ",".join(repr(first / 2**k) for k in range(count))


# Scene and options of each study. Ladders reach from what is too coarse to be of use to about a minute for a run.
STUDIES = {
    "c0": ("half-disc", ["--sizes", "2,1,0.5,0.25", "--steps", steps(2.5e-4, 5), "--degrees", "1,2", "--schemes", ALL_SCHEMES,
                         "--quantity", "J,displacement,gradient,impulse"]),
    "bar-impact": ("bar-impact", ["--sizes", "0.5,0.25,0.125,0.0625,0.03125", "--steps", steps(1 / 60, 5), "--degrees", "1,2",
                                  "--schemes", ALL_SCHEMES, "--quantity", "displacement,impulse,contact_start,contact_time,energy_loss,peak_force"]),
    "bouncing-bar": ("bouncing-bar", ["--set", "time.end=5.333333333333333", "--set", "time.step=0.005333333333333333",
                                      "--set", "exact.impulse=533.3333333333333", "--set",
                                      "exact.contact_time=1.3333333333333333", "--sizes", "1,0.5,0.25,0.125", "--steps",
                                      steps(1 / 30, 4), "--degrees", "1,2", "--schemes", ALL_SCHEMES, "--quantity",
                                      "displacement,impulse,contact_start,contact_time,energy_loss"]),
    "hertz-press": ("hertz-press", ["--sizes", "8,4,2,1,0.5", "--steps", "0.2,0.1,0.05", "--degrees", "1,2", "--schemes", ALL_SCHEMES,
                                    "--quantity", "pressure,displacement"]),
    "drop-ring": ("drop-ring", ["--sizes", "8e-3,4e-3,2e-3", "--steps", steps(1.12e-3, 5), "--tolerances", "8e-2,2e-2,5e-3,1.25e-3",
                                "--quantity", "displacement,impulse,contact_time"]),
    "drop-ball": ("drop-ball", ["--sizes", "6e-3,3e-3", "--steps", steps(4e-5, 3), "--tolerances", "1.6e-1,4e-2,1e-2,2.5e-3,6.25e-4",
                                "--quantity", "displacement,impulse,contact_time"]),
    "drop-test": ("drop-test", ["--sizes", "1e-2,5e-3,2.5e-3", "--steps", steps(2e-4, 4), "--tolerances", "3.2e-1,8e-2,2e-2,5e-3,1.25e-3",
                                "--quantity", "displacement,impulse,peak_force"]),
    "standing-wave": ("standing-wave", ["--sizes", "4,2,1,0.5,0.25", "--steps", steps(4 / 30, 6), "--degrees", "1,2"]),
}  # fmt: skip


def study(name: str, out: Path) -> None:
    scene, options = STUDIES[name]
    folder = out / name
    print(f"{name}: signorini study scenes/{scene}.toml {' '.join(options)}", flush=True)
    subprocess.run(["signorini", "study", SCENES / f"{scene}.toml", "--out", folder, *options], check=True)
    subprocess.run([sys.executable, ROOT / "postprocess" / "work_precision.py", folder], check=True)
    shutil.copy(folder / "study.csv", out / f"{name}.csv")


# Ladders of a few seconds each, in the plane and in space, with and without objective, of coarse and of fine meshes.
PRICED = {
    "half-disc": ["--sizes", "2,1,0.5", "--quantity", "J"],
    "half-disc, gradient": ["--sizes", "1,0.5", "--degrees", "1,2", "--quantity", "J,gradient"],
    "half-ball": ["--sizes", "3,2,1.5", "--quantity", "J,impulse"],
    "bar-impact": ["--schemes", ALL_SCHEMES],
    "bouncing-bar": ["--sizes", "1,0.5,0.25", "--steps", "0.016,0.008", "--quantity", "displacement,impulse"],
    "disc-drop": ["--sizes", "8,4,2", "--steps", "0.04,0.02", "--quantity", "impulse,contact_time"],
    "hertz-press": ["--sizes", "4,2,1", "--steps", "0.2,0.1", "--quantity", "pressure"],
    "standing-wave": [],
    "catch": ["--quantity", "J"],
}  # fmt: skip


def seconds(text: str) -> float:
    """What the program writes as 0.3 s, 12 min or 1.5 h."""
    number, unit = text.split()
    return float(number) * {"s": 1, "min": 60, "h": 3600}[unit]


def prices(out: Path) -> None:
    """Priced and found, of whole ladders."""
    print(f"{'ladder':<24}{'rungs':>6}{'priced, s':>11}{'found, s':>10}{'found/priced':>14}{'pricing, s':>12}")
    for name, options in PRICED.items():
        folder = out / f"priced-{name.replace(', ', '-')}"
        shutil.rmtree(folder, ignore_errors=True)
        command = ["signorini", "study", SCENES / f"{name.split(',')[0]}.toml", *options]
        began = time.perf_counter()
        said = subprocess.run([*command, "--dry-run"], check=True, capture_output=True, text=True).stdout
        took = time.perf_counter() - began
        rungs, priced = re.search(r"^all (\d+): about (.+)$", said, re.MULTILINE).groups()
        said = subprocess.run([*command, "--out", folder], check=True, capture_output=True, text=True).stdout
        found = re.findall(r"; (\S+ \w+) so far$", said, re.MULTILINE)[-1]
        ratio = seconds(found) / seconds(priced)
        print(f"{name:<24}{rungs:>6}{seconds(priced):>11.3g}{seconds(found):>10.3g}{ratio:>14.2f}{took:>12.2g}", flush=True)


def run(verb: str, scene: str, out: Path, *settings: str, petsc: tuple[str, ...] = ()) -> dict:
    """run.json of a run whose first guess pushes onto the plane."""
    overrides = [word for setting in (*settings, "output.fields=[]") for word in ("--set", setting)]
    subprocess.run(["signorini", verb, SCENES / f"{scene}.toml", "--quiet", "--out", out, *overrides, "--", *petsc], check=True)
    return json.loads((out / "run.json").read_text())


def objective(run: dict) -> float:
    return run["objective"]["value"]


def solvers(out: Path) -> None:
    """Every decade of a tolerance: what it costs and how far J is off that at the tightest one."""
    guess = ('control.initial=["0", "0", "-0.9"]', "optimizer.max_iterations=0", "mesh.size=1.5", "time.step=1e-4")
    exact = objective(run("optimize", "half-ball", out / "solvers", *guess, 'solver.linear="direct"'))
    print(f"{'conjugate gradients':<28}{'tolerance':>10}{'s':>8}{'J off by':>12}")
    for decade in range(4, 14, 2):
        one = run("optimize", "half-ball", out / "solvers", *guess, 'solver.linear="iterative"', petsc=("-step_ksp_rtol", f"1e-{decade}"))
        seconds = one["timings"]["forward"]["seconds"] + one["timings"]["adjoint"]["seconds"]
        print(f"{'half-ball':<28}{f'1e-{decade}':>10}{seconds:>8.2f}{abs(objective(one) / exact - 1):>12.1e}", flush=True)
    guess = ('control.initial=["0", "-0.9"]', "optimizer.max_iterations=0", "mesh.size=1")
    exact = objective(run("optimize", "half-disc", out / "solvers", *guess))
    print(f"{'full VI':<28}{'tolerance':>10}{'s':>8}{'J off by':>12}")
    for decade in range(-8, 3, 2):  # in units of the gap tolerance, 1e-10 of the body
        one = run("optimize", "half-disc", out / "solvers", *guess, 'solver.vi="full"', petsc=("-full_vi_snes_atol", f"1e{-decade}"))
        print(f"{'half-disc':<28}{f'1e{-decade}':>10}{one['timings']['forward']['seconds']:>8.2f}{abs(objective(one) / exact - 1):>12.1e}",
              flush=True)  # fmt: skip
    run("optimize", "half-disc", out / "solvers", "mesh.size=1", "optimizer.max_iterations=1000", 'optimizer.method="projected-gradient"')
    with open(out / "solvers" / "history.csv") as lines:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]
    print(f"{'optimizer':<28}{'tolerance':>10}{'s':>8}{'J above last':>14}{'iterations':>12}")
    best, first = rows[-1]["objective"], rows[0]["gradient_norm"]
    for half in range(0, 12):
        tolerance = 10 ** (-half / 2)
        if met := next((row for row in rows if row["gradient_norm"] <= tolerance * first), None):
            print(f"{'half-disc':<28}{tolerance:>10.1e}{met['seconds']:>8.2f}{met['objective'] / best - 1:>14.1e}{met['iteration']:>12.0f}")


OTHERS = {"prices": prices, "solvers": solvers}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", choices=[*STUDIES, *OTHERS, []], metavar="CASE")
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "accuracy")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    for case in given.cases or [*STUDIES, *OTHERS]:
        OTHERS[case](given.out) if case in OTHERS else study(case, given.out)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
