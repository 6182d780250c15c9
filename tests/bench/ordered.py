"""Accuracy on demand: optima ordered to a relative error of J, their true errors, and their price.

usage: ./dev bench ordered [SCENE …] [--accuracy A,B,…] [--reference R] [--json FILE]

Each of the scenes (default: half-disc, half-ball, catch) is solved by `optimize --accuracy` to each error (default 1e-2 and
1e-3), and once more at the size and step with which that ended. The true error is that to the same scene ordered to a much
smaller error, by default the fifth part of the smallest. About an hour, most of it for the references.
"""

import json
import tempfile
import time
import tomllib
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
    options = parser.parse_args()
    asked = sorted((float(one) for one in options.accuracy.split(",")), reverse=True)
    rows = []
    print(f"{'scene':<12}{'asked':>8}{'estimated':>11}{'true error':>12}{'unknowns':>10}{'steps':>7}{'rounds':>7}{'seconds':>9}{'of one run':>11}")
    for name in options.scenes:
        scene = program.ROOT / "scenes" / f"{name}.toml"
        with tempfile.TemporaryDirectory() as folder:
            best, _ = optimum(Path(folder) / "reference", scene, "--accuracy", options.reference or asked[-1] / 5)
            exact = best["objective"]["value"]
            for error in asked:
                out = Path(folder) / f"{error}"
                run, seconds = optimum(out, scene, "--accuracy", error)
                _, alone = optimum(Path(folder) / "alone", out / "scene.toml")
                row = {"scene": name, "asked": error, "estimated": run["accuracy"]["estimated"],
                       "error": run["objective"]["value"] / exact - 1, "unknowns": run["unknowns"], "steps": run["steps"]["done"],
                       "rounds": 1 + len(run["optimizer"]["coarse_levels"]), "seconds": seconds, "alone": alone}  # fmt: skip
                rows.append(row)
                print(f"{name:<12}{error:>8.0e}{row['estimated']:>11.1e}{row['error']:>+12.1e}{row['unknowns']:>10}{row['steps']:>7}"
                      f"{row['rounds']:>7}{seconds:>9.1f}{seconds / alone:>11.2f}", flush=True)  # fmt: skip
            print(f"{'':<12}reference: J = {exact:.8e}, estimated error {best['accuracy']['estimated']:.1e}", flush=True)
    program.write(options.json, rows)


if __name__ == "__main__":
    main()
