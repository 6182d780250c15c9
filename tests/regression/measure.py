# SPDX-License-Identifier: GPL-3.0-or-later
"""simulate --measure: which files it writes, over which it writes, and what of tables from elsewhere is said."""

import json
import re
import shutil
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SIGNORINI, SOURCE, captured, table, toml  # noqa: E402

import numpy as np  # noqa: E402

BLOCK = SOURCE / "tests" / "data" / "block.toml"
NO_OBJECTIVE = re.compile(r"\[objective\].*?\n\n", re.S)
STEPS = 30


def scene(folder: Path, file: str, name: str = "scene", column: str = "value", **more: object) -> Path:
    """The block with an unknown modulus, whose displacement at the top is measured."""
    text = NO_OBJECTIVE.sub("", BLOCK.read_text()).replace('"square.geo"', f'"{SOURCE / "tests" / "data" / "square.geo"}"')
    text = text.replace("[control]\nscale = 1.0\n", "")
    measured = {"of": "displacement", "component": "y", "point": [0.5, 1], "file": file, "column": column, "deviation": 0.01} | more
    text += '\n[[unknown]]\nof = "young"\nstart = 40.0\n[[measurement]]\n' + "".join(f"{key} = {toml(value)}\n" for key, value in measured.items())
    (folder / f"{name}.toml").write_text(text)
    return folder / f"{name}.toml"


def run(verb: str, file: Path, *options: str, ranks: int = 1, status: int = 0) -> str:
    start = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    done = captured([*start, str(SIGNORINI), verb, str(file), "--out", str(file.parent / "out"), *options])
    assert done.returncode == status, (options, done.returncode, done.stdout + done.stderr)
    return done.stdout + done.stderr


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file() and "out" not in path.parts}


def digest(content: bytes) -> str:
    """FNV-1a of a content and its length."""
    state = 0xCBF29CE484222325
    for byte in content + len(content).to_bytes(8, "little"):
        state = (state ^ byte) * 0x100000001B3 % 2**64
    return f"{state:016x}"


def overwritten(folder: Path) -> None:
    """Only what a run wrote: not a record from elsewhere, a mesh, the scene or what was edited since."""
    file = scene(folder, "data.csv")
    run("simulate", file, "--measure", "--seed", "0", "--set", "material.young=50")
    first = (folder / "data.csv").read_bytes()
    assert len(table(folder / "data.csv")["value"]) == STEPS and (folder / "data.csv.measured").is_file()
    assert "exists and stays as it is, since a fit may use it" in run("simulate", file, "--measure", "--quiet", status=2)
    for ranks, seed in ((1, "1"), (2, "2")):
        run("simulate", file, "--measure", "--replace", "--seed", seed, ranks=ranks)
        assert (folder / "data.csv").read_bytes() != first
    last = (folder / "data.csv").read_bytes()
    # A process that is killed between its two files leaves the note of data that are not there yet.
    (folder / "data.csv").write_bytes(first)
    run("simulate", file, "--measure", "--replace", "--seed", "2", status=2)  # replaced twice since
    (folder / "data.csv").write_bytes(last)
    run("simulate", file, "--measure", "--replace", "--seed", "3")
    (folder / "data.csv").write_bytes(last)
    run("simulate", file, "--measure", "--replace", "--seed", "2")
    note = (folder / "data.csv.measured").read_text()
    assert note.splitlines()[2:] == [digest((folder / "data.csv").read_bytes()), digest(last)], note

    (folder / "data.csv").write_bytes(last + b"9,9\n")
    shutil.copy(SOURCE / "tests" / "data" / "square.geo", folder / "mesh.geo")
    (folder / "record.csv").write_text("time,value\n0,0\n1,1\n")
    push = b"time,value\n0,-1\n1,-1\n"
    (folder / "push.csv").write_bytes(push)
    (folder / "push.csv.measured").write_text(note.splitlines()[0] + "\n" + digest(push) + "\n")
    (folder / "new.csv.measured").write_text("a note of another kind\n")
    (folder / "link.csv").symlink_to(folder / "record.csv")
    for name, text in (("data.csv", "data.csv has changed since simulate --measure wrote it"),
                       ("record.csv", "record.csv was not written by simulate --measure (there is no record.csv.measured)"),
                       ("link.csv", "record.csv was not written by"), ("mesh.geo", "mesh.geo was not written by"),
                       ("wrong.toml", "wrong.toml was not written by"), ("new.csv", "new.csv.measured is in the way"),
                       ("push.csv", "push.csv is a table that the scene reads"),
                       ("out/steps.csv", "steps.csv is a file of the run itself"), ("./out/checkpoint.h5", "is a file of the run itself")):  # fmt: skip
        file = scene(folder, name, "wrong")
        before = files(folder)
        options = ("--set", 'load.body=["0", {file = "push.csv", column = "value"}]') if name == "push.csv" else ()
        for ranks in (1, 2) if name in ("record.csv", "out/steps.csv") else (1,):
            said = run("simulate", file, "--measure", "--replace", *options, ranks=ranks, status=2)
            assert f"--measure: {folder}" in said and text in said, (name, said)
            assert files(folder) == before, name
    for name in ("drop-test", "find-the-wall", "two-materials"):
        shipped = SOURCE / "scenes" / "data" / f"{name}.csv"
        shutil.copy(shipped, folder)
        shutil.copy(f"{shipped}.measured", folder)
        run("simulate", scene(folder, shipped.name), "--measure", "--replace")
    print("--measure --replace: over what a run wrote alone")


def said_of_tables(folder: Path) -> None:
    """A unit in a column's name is that of its values; times of another unit, or that end early, are warned of."""
    file = scene(folder, "si.csv")
    run("simulate", file, "--measure", "--seed", "0", "--set", "material.young=50")
    given = table(folder / "si.csv")
    rows = zip(given["time"], given["value"])
    (folder / "units.csv").write_text("time [ms];value [mm]\n" + "".join(f"{1e3 * t:.17g};{1e3 * y:.17g}\n" for t, y in rows))
    fitted = {}
    for name in ("si", "units"):
        said = run("optimize", scene(folder, f"{name}.csv"))
        assert "warning: measurement" not in said, said
        fitted[name] = table(folder / "out" / "parameters.csv")["value"][0]
    assert abs(fitted["si"] / 50 - 1) < 1e-6 and abs(fitted["units"] / fitted["si"] - 1) < 1e-9, fitted
    half = "".join(f"{t:.17g},{y:.17g}\n" for t, y in zip(given["time"][:15], given["value"]))
    (folder / "half.csv").write_text("time,value\n" + half)
    tiny = "".join(f"{1e-3 * t:.17g},{y:.17g}\n" for t, y in zip(given["time"][:15], given["value"]))
    (folder / "tiny.csv").write_text("time,value\n" + tiny)
    for name, text in (("half", "half.csv: the data end at 0.3 s, the run at 0.6 s"), ("tiny", "a thousandth of the run's 0.6 s or less")):
        said = run("optimize", scene(folder, f"{name}.csv"), "--set", "optimizer.max_iterations=0")
        warnings = [one["message"] for one in json.loads((folder / "out" / "run.json").read_text())["warnings"] if one["name"] == "table"]
        assert len(warnings) == 1 and text in warnings[0] and f"warning: {warnings[0]}" in said and said.count(text) == 1, (warnings, said)
    (folder / "push.csv").write_text("time,push\n" + "".join(f"{t},{-t}\n" for t in range(0, 101)))  # of milliseconds
    push = ("--set", 'load.body=["0", {file = "push.csv", column = "push"}]')
    text = f"load.body: {folder}/push.csv: the run, from 0 to 0.6 s, uses one of 100 intervals of the table, from 0 to 100 s"
    for verb in ("simulate", "check", "info"):
        options = ("--replace",) if verb == "simulate" else ()
        assert text in captured([str(SIGNORINI), verb, str(scene(folder, "si.csv")), *push, *options,
                                 *(("--out", str(folder / "out")) if options else ())]).stdout  # fmt: skip
    assert text in json.loads((folder / "out" / "run.json").read_text())["warnings"][0]["message"]
    print("units of columns are converted, doubtful times are warned of")


def main() -> int:
    for part in (overwritten, said_of_tables):
        with tempfile.TemporaryDirectory() as name:
            part(Path(name).resolve())
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
