# SPDX-License-Identifier: GPL-3.0-or-later
"""Accuracy on demand: optima ordered to a relative error of J, their true errors, and their price.

usage: ./dev bench ordered [SCENE …] [--accuracy A,B,…] [--reference R] [--sizes uniform,auto] [--json FILE]

Each of the scenes (default: half-disc, half-ball, catch) is solved by `optimize --accuracy` to each error (default 1e-2 and
1e-3), with elements of one size and with sizes that vary, and once more at the size and step with which the former ended.
The true error is that to the same scene ordered to a much smaller error, by default the fifth part of the smallest, with
elements of one size. About an hour, most of it for the references.
"""

import itertools
import json
import tempfile
import time
from pathlib import Path

import program

SCENES = ("half-disc", "half-ball", "catch")


def optimum(folder: Path, scene: Path, *options: object) -> tuple[dict, float]:
    """run.json and seconds of an optimize."""
    start = time.perf_counter()
    program.output("signorini", "optimize", scene, "--out", folder, "--quiet", *options, allowed=(0, 1))
    return json.loads((folder / "run.json").read_text()), time.perf_counter() - start


def main() -> None:
    parser = program.options("bench ordered", __doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", default=list(SCENES))
    parser.add_argument("--accuracy", default="1e-2,1e-3")
    parser.add_argument("--reference", type=float)
    parser.add_argument("--sizes", default="uniform,auto")
    options = parser.parse_args()
    asked = sorted((float(one) for one in options.accuracy.split(",")), reverse=True)
    rows = []
    print(f"{'scene':<11}{'sizes':<9}{'asked':>8}{'estimated':>11}{'true error':>12}{'unknowns':>10}{'steps':>7}{'rounds':>7}{'seconds':>9}{'of one run':>11}",
          flush=True)  # fmt: skip
    for name in options.scenes:
        scene = program.ROOT / "scenes" / f"{name}.toml"
        with tempfile.TemporaryDirectory() as folder:
            best, passed = optimum(Path(folder) / "reference", scene, "--accuracy", options.reference or asked[-1] / 5)
            exact = best["objective"]["value"]
            print(f"{name:<11}reference: J = {exact:.8e}, estimated error {best['accuracy']['estimated']:.1e}, {passed:.0f} s", flush=True)
            for sizes, error in itertools.product(options.sizes.split(","), asked):
                out = Path(folder) / f"{sizes}-{error}"
                run, seconds = optimum(out, scene, "--accuracy", error, *(["--set", "mesh.size=auto"] if sizes == "auto" else []))
                alone = optimum(Path(folder) / "alone", out / "scene.toml")[1] if sizes == "uniform" else None
                row = {"scene": name, "sizes": sizes, "asked": error, "estimated": run["accuracy"]["estimated"],
                       "error": run["objective"]["value"] / exact - 1, "unknowns": run["unknowns"], "steps": run["steps"]["done"],
                       "rounds": 1 + len(run["optimizer"]["coarse_levels"]), "seconds": seconds, "alone": alone}  # fmt: skip
                rows.append(row)
                print(f"{'':<11}{sizes:<9}{error:>8.0e}{row['estimated']:>11.1e}{row['error']:>+12.1e}{row['unknowns']:>10}{row['steps']:>7}"
                      f"{row['rounds']:>7}{seconds:>9.1f}{seconds / alone if alone else '':>11.3}", flush=True)  # fmt: skip
    program.write(options.json, rows)


if __name__ == "__main__":
    main()
