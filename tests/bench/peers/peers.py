# SPDX-License-Identifier: GPL-3.0-or-later
"""Milliseconds per forward step of the half disc, of signorini and of its peers, on the same mesh, nothing stored between steps.

usage: ./dev bench peers [SIZE …] [--repeats N] [--only PROGRAM[@SIZE] …] [--json FILE]    (sizes in m, default 0.5 0.25)

Only the loop over the steps is timed, the best of all repeats counts. FreeFem++ has no clock but that of CPU time, the
others count wall time: on a busy machine this is in favour of FreeFem++.
"""

import argparse
import csv
import json
import re
import shutil
import statistics
import sys
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from program import output  # noqa: E402

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
SCENE, GEOMETRY = ROOT / "scenes" / "half-disc.toml", ROOT / "meshes" / "half-disc.geo"
REFERENCE = "condensed"
TITLES = {REFERENCE: "signorini, condensed", "full": "signorini, full VI", "freefem": "FreeFem++, CHOLMOD", "freefem-mumps": "FreeFem++, MUMPS",
          "getfem": "GetFEM"}
FREEFEM = {"freefem": "CHOLMOD", "freefem-mumps": "MUMPS"}
TOUCH = 1e-9  # m; displacements are of the order of 1 m and gaps within it are rounding


@dataclass(frozen=True)
class Motion:
    """Nodes (n × 2, m, sorted) and their displacements at all times (times × n × 2, m)."""

    points: np.ndarray
    displacements: np.ndarray

    @classmethod
    def of(cls, points: np.ndarray, displacements: np.ndarray) -> "Motion":
        order = by_place(points)
        return cls(points[order], displacements[:, order])

    @classmethod
    def of_rows(cls, rows: np.ndarray) -> "Motion":
        """From a row of coordinates and one of displacements for every time, in pairs."""
        pairs = rows.reshape(len(rows), -1, 2)
        return cls.of(pairs[0], pairs[1:])

    def difference(self, other: "Motion") -> float:
        """The largest over the steps, relative to the largest displacement of the step."""
        if self.points.shape != other.points.shape or abs(self.points - other.points).max() > TOUCH:
            raise SystemExit("two programs have different nodes")
        errors = abs(self.displacements - other.displacements).max(axis=(1, 2))[1:]
        return float((errors / abs(other.displacements).max(axis=(1, 2))[1:]).max())


@dataclass(frozen=True)
class Contact:
    """Candidates (m × 2, m) and which of them carry a force at all times (times × m)."""

    points: np.ndarray
    active: np.ndarray

    def same(self, motion: Motion, plane: float) -> bool:
        """Whether the candidates that `motion` takes down to the plane are the active ones, at all times."""
        row = {tuple(p): i for i, p in enumerate(motion.points.round(6) + 0.0)}
        rows = [row[tuple(p)] for p in self.points.round(6) + 0.0]
        height = motion.points[rows, 1] + motion.displacements[:, rows, 1] - plane
        return np.array_equal(height <= TOUCH, self.active)


def by_place(points: np.ndarray) -> np.ndarray:
    return np.lexsort(points.round(6).T)


class Bench:
    """One mesh and what the programs need to run on it."""

    def __init__(self, size: float, folder: Path, threads: int) -> None:
        self.folder = folder
        self.threads = {"OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": str(threads)}
        self.mesh = folder / "half-disc.msh"
        output("gmsh", "-2", GEOMETRY, "-setnumber", "Mesh.MeshSizeMin", size, "-setnumber", "Mesh.MeshSizeMax", size,
               "-format", "msh22", "-o", self.mesh)  # fmt: skip
        groups = {name: int(tag) for tag, name in re.findall(r'^1 (\d+) "(.*)"$', self.mesh.read_text(), re.MULTILINE)}
        self.groups = [groups["top"], groups["contact"]]
        # A .msh takes no element size.
        self.scene = folder / "scene.toml"
        self.scene.write_text(re.sub(r"^size = .*\n", "", SCENE.read_text(), flags=re.MULTILINE))
        scene = tomllib.loads(self.scene.read_text())
        self.steps = round(scene["time"]["end"] / scene["time"]["step"])
        self.plane = scene["contact"]["obstacle"]["point"][1]

    def seconds(self, program: str) -> float:
        """Of all steps, in one run."""
        file = self.folder / program
        if program in FREEFEM:
            out = output("FreeFem++-nw", "-nw", "-v", 0, HERE / "half_disc.edp", self.mesh, file, *self.groups, FREEFEM[program],
                         FF_LOADPATH="/usr/lib/freefem++", **self.threads)  # fmt: skip
            return float(re.search(r"^(\S+) \d+$", out, re.MULTILINE)[1])  # plugins print too
        if program == "getfem":
            out = output("python3", HERE / "half_disc_getfem.py", self.mesh, file, *self.groups, **self.threads)
            return float(out.split()[-2])
        return self.simulate(program, "output.fields=[]", "output.tables=[]", 'run.invariants="off"')

    def simulate(self, program: str, *settings: str) -> float:
        """Seconds of all steps of signorini."""
        file = self.folder / program
        shutil.rmtree(file, ignore_errors=True)
        keys = [f'mesh.file="{self.mesh}"', 'control.initial=["0", "-1"]', f'solver.vi="{program}"', *settings]
        output("signorini", "simulate", self.scene, "--quiet", "--out", file, *(w for key in keys for w in ("--set", key)), **self.threads)
        return json.loads((file / "run.json").read_text())["timings"]["forward"]["seconds"]

    def motion(self, program: str) -> Motion:
        """Of the last run; of signorini, of one more that stores it."""
        file = self.folder / program
        if program not in FREEFEM and program != "getfem":
            self.simulate(program, "output.every=1")
        if program in FREEFEM:
            length = int(np.fromfile(file, np.int64, 1)[0])  # stands before every row
            return Motion.of_rows(np.fromfile(file).reshape(-1, length + 1)[:, 1:])
        if program == "getfem":
            return Motion.of_rows(np.load(file))
        with h5py.File(file / "state.h5") as state:
            fields = state["Function/displacement"]
            names = sorted(fields, key=lambda name: float(name.replace("_", ".")))
            points = state["Mesh/mesh/geometry"][:, :2]
            return Motion.of(points, np.array([fields[name][:, :2] for name in names]))

    def contact(self) -> Contact:
        """Of the reference's last run."""
        with open(self.folder / REFERENCE / "contact.csv") as lines:
            rows = [[float(row[key]) for key in ("x", "y", "force")] for row in csv.DictReader(lines)]
        table = np.array(rows).reshape(self.steps + 1, -1, 3)
        return Contact(table[0, :, :2], table[:, :, 2] > 0)


def measure(size: float, programs: list[str], repeats: int, threads: int) -> list[dict]:
    """One row of results per program, the reference first; their runs take turns."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(size, Path(folder), threads)
        turns = [[1e3 / bench.steps * bench.seconds(program) for program in programs] for _ in range(repeats)]
        for program, times in zip(programs, zip(*turns)):
            milliseconds = np.min(times)
            motion = bench.motion(program)
            if program == REFERENCE:
                first, reference, contact = milliseconds, motion, bench.contact()
            rows.append({"size": size, "nodes": len(motion.points), "program": TITLES[program], "ms_per_step": milliseconds, "median": statistics.median(times),
                         "ratio": milliseconds / first, "relative_difference": motion.difference(reference),
                         "same_active_sets": contact.same(motion, bench.plane)})  # fmt: skip
            print(line(rows[-1]), flush=True)
    return rows


def line(row: dict) -> str:
    return (f"{row['size']:6g}  {row['nodes']:7d}  {row['program']:22s}  {row['ms_per_step']:9.3f}  {row['median']:9.3f}  {row['ratio']:6.2f}"
            f"  {row['relative_difference']:10.1e}  {'same' if row['same_active_sets'] else 'differ'}")  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(prog="./dev bench peers", description=__doc__.split("\n")[0])
    parser.add_argument("sizes", nargs="*", type=float, default=[0.5, 0.25], metavar="SIZE", help="element size, m")
    parser.add_argument("--repeats", type=int, default=3, metavar="N", help="runs of each program, in turn, of which the best counts")
    parser.add_argument("--threads", type=int, default=1, metavar="N")
    parser.add_argument("--only", nargs="+", metavar="PROGRAM[@SIZE]", help=f"of {', '.join(TITLES)}; {REFERENCE} always runs")
    parser.add_argument("--json", type=Path, metavar="FILE", help="where the table goes too")
    given = parser.parse_args()
    known = set(TITLES) | {f"{name}@{size:g}" for name in TITLES for size in given.sizes}
    if unknown := set(given.only or []) - known:
        parser.error(f"--only: found {', '.join(sorted(unknown))}; choose from {', '.join(sorted(known))}")

    def wanted(program: str, size: float) -> bool:
        return given.only is None or program == REFERENCE or bool({program, f"{program}@{size:g}"} & set(given.only))

    print("  size    nodes  program                   ms/step     median   ratio  difference  active sets")
    rows = [row for size in given.sizes for row in measure(size, [p for p in TITLES if wanted(p, size)], given.repeats, given.threads)]
    if given.json:
        given.json.write_text(json.dumps(rows, indent=2) + "\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
