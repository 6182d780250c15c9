# SPDX-License-Identifier: GPL-3.0-or-later
"""What it costs to store a motion: seconds of output a stored time, however many there are, beside those of the steps.

usage: ./dev bench output [--sizes H …] [--frames N …] [--ranks N …] [--formats] [--json FILE]

The half disc under the constant force that its control problem desires. Each size runs with every step stored, for each number of
frames, and last with the default of output.every (up to 300 frames). Of the phases of run.json, `balances` is what is
summed up and monitored of every step, `output` fields and tables. --formats compares the formats of stored fields in turns instead,
every step stored, without tables. The largest run of the default takes 3 GB on disk and a minute or two.
"""

import json
import tempfile
from pathlib import Path

import numpy as np
import program
from program import ROOT

SCENE = """
[mesh]
file = "{meshes}/half-disc.geo"
size = {size!r}
[time]
end = {end!r}
step = 5e-5
[material]
density = 1.0
young = 1e8
poisson = 0.3
viscosity = {{ bulk = 1e4, shear = 1e4 }}
[[clamp]]
on = "top"
[load]
body = ["0", "-1e6"]
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, -15.75], normal = [0, 1] }}
"""


def row(folder: Path, size: float, frames: int, ranks: int, every: int | None, **keys: object) -> dict:
    scene, out = folder / "output.toml", folder / "out"
    scene.write_text(SCENE.format(meshes=ROOT / "meshes", size=size, end=frames * 5e-5))
    program.output("signorini", "simulate", scene, "--out", out, "--quiet",
                   *program.sets(({"output.every": every} if every else {}) | keys), ranks=ranks)  # fmt: skip
    run = json.loads((out / "run.json").read_text())
    assert run["counters"]["VIs solved"] > 0, "no contact occurred"
    seconds = {phase: run["timings"][phase]["seconds"] for phase in ("forward", "balances", "output")}
    steps = run["steps"]["done"]
    stored = run["steps"]["stored"]
    return {"size": size, "ranks": ranks, "unknowns": run["unknowns"], "steps": steps, "frames": stored, "seconds": seconds,
            "bytes": {path.name: path.stat().st_size for path in out.iterdir()}}  # fmt: skip


def show(r: dict) -> None:
    s, steps = r["seconds"], r["steps"]
    print(f"{r['size']:6g}  {r['unknowns']:8d}  {r['ranks']:5d}  {steps:6d}  {r['frames']:6d}  {1e6 * s['forward'] / steps:10.1f}"
          f"  {1e6 * s['balances'] / steps:8.1f}  {1e6 * s['output'] / steps:17.1f}  {1e6 * s['output'] / r['frames']:10.1f}  {s['output'] / s['forward']:12.3f}  {sum(r['bytes'].values()) / 1e6:7.1f}"
          f"  {r['bytes']['state.xdmf'] / 1e6:7.2f}", flush=True)  # fmt: skip


def compare_formats(folder: Path, size: float, frames: int) -> list[dict]:
    """Least seconds of output of several runs with each format in turn, and the sizes of the files."""
    formats = {"xdmf": ["xdmf"], "vtkhdf": ["vtkhdf"], "both": ["xdmf", "vtkhdf"]}
    runs = {name: [] for name in formats}
    for _ in range(5):
        for name, chosen in formats.items():
            runs[name].append(row(folder, size, frames, 1, 1, **{"output.format": chosen, "output.tables": []}))
    for name, found in runs.items():
        seconds = np.min([one["seconds"]["output"] for one in found])
        files = {file: size for file, size in found[0]["bytes"].items() if Path(file).stem in ("state", "obstacles")}
        print(f"{size:6g}  {found[0]['unknowns']:8d}  {frames:6d}  {name:6s}  {seconds:8.3f} s  {sum(files.values()) / 1e6:8.2f} MB  "
              + ", ".join(f"{file} {bytes_ / 1e6:.2f}" for file, bytes_ in sorted(files.items())), flush=True)  # fmt: skip
    return [one for found in runs.values() for one in found]


def main() -> int:
    parser = program.options("bench output", __doc__)
    parser.add_argument("--sizes", nargs="+", type=float, default=[1, 0.5, 0.25], metavar="H", help="element sizes, m")
    parser.add_argument("--frames", nargs="+", type=int, default=[1000, 10000], metavar="N")
    parser.add_argument("--ranks", nargs="+", type=int, default=[1], metavar="N")
    parser.add_argument("--formats", action="store_true", help="compare output.format")
    given = parser.parse_args()
    if given.formats:
        print("  size  unknowns  frames  format      output      files")
        with tempfile.TemporaryDirectory() as name:
            rows = [one for size in given.sizes for frames in given.frames for one in compare_formats(Path(name), size, frames)]
        program.write(given.json, rows)
        return 0
    print("  size  unknowns  ranks   steps  frames   us a step  balances  output, us a step  us a frame  output/steps       MB  of index")
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for size in given.sizes:
            for ranks in given.ranks:
                for frames, every in [*((frames, 1) for frames in given.frames), (int(np.min(given.frames)), None)]:
                    rows.append(row(Path(name), size, frames, ranks, every))
                    show(rows[-1])
    program.write(given.json, rows)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
