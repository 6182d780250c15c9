# SPDX-License-Identifier: GPL-3.0-or-later
"""What a tolerance of the optimizer costs: sweeps, what is left of J, and whether the search ends with a certificate.

usage: ./dev bench tolerance [SCENE] [--tolerances T …] [--starts N] [--kernels NAME …] [--json FILE]

A scene's search (by default the half disc's) to each tolerance from N first guesses, its own and random ones of constant force, and from
its own with other kernels of OpenBLAS, whose rounding differs: which kinks a search comes by changes with the last digit. J* is the least
value that any run finds. A run is certified where it ends at a kink or with a small gradient. About fifteen minutes.
"""

import json
import random
import tempfile
from pathlib import Path

import numpy as np
import program

KERNELS = ["Prescott", "Nehalem", "Sandybridge", "Haswell", "Zen", "SkylakeX"]
SECONDS = 9  # column of history.csv
CERTIFIED = ("stationary at a kink", "gradient norm below tolerance")


def run(scene: Path, out: Path, tolerance: float, guess: list[float] | None, kernel: str | None) -> dict:
    values = {"optimizer.tolerance": tolerance, "optimizer.max_iterations": 1000, "optimizer.checkpoint": 0, "output.fields": "[]", "output.tables": '["history"]'}
    if guess:
        values["control.initial"] = json.dumps([repr(value) for value in guess])
    program.output("signorini", "optimize", scene, "--out", out, "--quiet", *program.sets(values),
                   allowed=(0, 1), **({"OPENBLAS_CORETYPE": kernel} if kernel else {}))  # fmt: skip
    found = json.loads((out / "run.json").read_text())
    return {"tolerance": tolerance, "guess": guess, "kernel": kernel, "objective": found["objective"]["value"], "stop_reason": found["stop_reason"],
            "forward": found["optimizer"]["forward_sweeps"], "adjoint": found["optimizer"]["adjoint_sweeps"],
            "seconds": float((out / "history.csv").read_text().splitlines()[-1].split(",")[SECONDS])}  # fmt: skip


def main() -> int:
    parser = program.options("bench tolerance", __doc__)
    parser.add_argument("scene", nargs="?", type=Path, default=program.ROOT / "scenes" / "half-disc.toml")
    parser.add_argument("--tolerances", nargs="+", type=float, default=[1e-3, 1e-4, 1e-5, 1e-6, 1e-7], metavar="T")
    parser.add_argument("--starts", type=int, default=10, metavar="N")
    parser.add_argument("--kernels", nargs="*", default=KERNELS, metavar="NAME")
    given = parser.parse_args()
    chosen = random.Random(1)
    guesses = [None] + [[round(chosen.uniform(-1, 1), 3), round(chosen.uniform(-1.5, 0.5), 3)] for _ in range(given.starts - 1)]
    cases = [(guess, None) for guess in guesses] + [(None, kernel) for kernel in given.kernels]
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for tolerance in given.tolerances:
            for guess, kernel in cases:
                rows.append(run(given.scene.absolute(), Path(name) / str(len(rows)), tolerance, guess, kernel))
                print(f"  {tolerance:g} {guess or 'own guess'} {kernel or ''}: {rows[-1]['forward']} + {rows[-1]['adjoint']} sweeps, "
                      f"J {rows[-1]['objective']:.12e}, {rows[-1]['stop_reason']}", flush=True)  # fmt: skip
    least = np.min([row["objective"] for row in rows])
    print("tolerance  runs  certified  forward sweeps: least, median, most  (J - J*)/J*: median, most  seconds: median")
    for tolerance in given.tolerances:
        own = [row for row in rows if row["tolerance"] == tolerance]
        sweeps, above = [row["forward"] for row in own], [row["objective"] / least - 1 for row in own]
        certified = sum(row["stop_reason"] in CERTIFIED for row in own)
        print(f"{tolerance:9g}  {len(own):4d}  {certified:9d}  {np.min(sweeps):21d}  {np.median(sweeps):6.0f}  {np.max(sweeps):4d}  {np.median(above):19.1e}  {np.max(above):7.1e}"
              f"  {np.median([row['seconds'] for row in own]):15.1f}")
    program.write(given.json, rows)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
