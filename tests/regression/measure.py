# SPDX-License-Identifier: GPL-3.0-or-later
"""simulate --measure: which files it writes, over which it writes, and what of tables from elsewhere is said."""

import json
import re
import shutil
from pathlib import Path

import pytest
from harness import SIGNORINI, SOURCE, captured, table, toml

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


@pytest.fixture
def measured(tmp_path: Path) -> Path:
    """A folder with the scene's table, measured in a run."""
    run("simulate", scene(tmp_path, "data.csv"), "--measure", "--seed", "0", "--set", "material.young=50")
    assert len(table(tmp_path / "data.csv")["value"]) == STEPS and (tmp_path / "data.csv.measured").is_file()
    return tmp_path


def test_stays_without_replace(measured: Path) -> None:
    assert "exists and is not overwritten, since a fit may use it" in run("simulate", measured / "scene.toml", "--measure", "--quiet", status=2)


@pytest.mark.parametrize("ranks", (1, 2))
def test_replaced(measured: Path, ranks: int) -> None:
    first = (measured / "data.csv").read_bytes()
    run("simulate", measured / "scene.toml", "--measure", "--replace", "--seed", "1", ranks=ranks)
    assert (measured / "data.csv").read_bytes() != first


def test_killed_between_its_two_files(measured: Path) -> None:
    """Such a process leaves the note of data that are not there yet."""
    file, data = measured / "scene.toml", measured / "data.csv"
    first = data.read_bytes()
    for seed in ("1", "2"):
        run("simulate", file, "--measure", "--replace", "--seed", seed)
    last = data.read_bytes()
    data.write_bytes(first)
    run("simulate", file, "--measure", "--replace", "--seed", "2", status=2)  # replaced twice since
    data.write_bytes(last)
    run("simulate", file, "--measure", "--replace", "--seed", "3")
    data.write_bytes(last)
    run("simulate", file, "--measure", "--replace", "--seed", "2")
    note = (measured / "data.csv.measured").read_text()
    assert note.splitlines()[2:] == [digest(data.read_bytes()), digest(last)]


KEPT = {
    "data.csv": "data.csv has changed since simulate --measure wrote it",
    "record.csv": "record.csv was not written by simulate --measure (there is no record.csv.measured)",
    "link.csv": "record.csv was not written by",
    "mesh.geo": "mesh.geo was not written by",
    "wrong.toml": "wrong.toml was not written by",
    "new.csv": "new.csv.measured has the name of the note",
    "push.csv": "push.csv is a table that the scene reads",
    "out/steps.csv": "steps.csv is a file of the run itself",
    "./out/checkpoint.h5": "is a file of the run itself",
}


@pytest.mark.parametrize("name, ranks", [*((name, 1) for name in KEPT), ("record.csv", 2), ("out/steps.csv", 2)])
def test_kept(measured: Path, name: str, ranks: int) -> None:
    """Not a record from elsewhere, a mesh, the scene or what was edited since."""
    (measured / "data.csv").write_bytes((measured / "data.csv").read_bytes() + b"9,9\n")
    shutil.copy(SOURCE / "tests" / "data" / "square.geo", measured / "mesh.geo")
    (measured / "record.csv").write_text("time,value\n0,0\n1,1\n")
    push = b"time,value\n0,-1\n1,-1\n"
    (measured / "push.csv").write_bytes(push)
    first_line = (measured / "data.csv.measured").read_text().splitlines()[0]
    (measured / "push.csv.measured").write_text(first_line + "\n" + digest(push) + "\n")
    (measured / "new.csv.measured").write_text("a note of another kind\n")
    (measured / "link.csv").symlink_to(measured / "record.csv")
    file = scene(measured, name, "wrong")
    before = files(measured)
    options = ("--set", 'load.body=["0", {file = "push.csv", column = "value"}]') if name == "push.csv" else ()
    said = run("simulate", file, "--measure", "--replace", *options, ranks=ranks, status=2)
    assert f"--measure: {measured}" in said and KEPT[name] in said
    assert files(measured) == before


@pytest.mark.parametrize("name", ("drop-test", "find-the-wall", "two-materials"))
def test_shipped_tables_are_of_a_run(tmp_path: Path, name: str) -> None:
    shipped = SOURCE / "scenes" / "data" / f"{name}.csv"
    shutil.copy(shipped, tmp_path)
    shutil.copy(f"{shipped}.measured", tmp_path)
    run("simulate", scene(tmp_path, shipped.name), "--measure", "--replace")


def write_rows(file: Path, header: str, rows: list[tuple[float, float]], separator: str = ",") -> None:
    file.write_text(f"{header}\n" + "".join(f"{t:.17g}{separator}{y:.17g}\n" for t, y in rows))


def samples(folder: Path) -> list[tuple[float, float]]:
    """Times and values of the measured table."""
    given = table(folder / "data.csv")
    return list(zip(given["time"], given["value"]))


def test_units_of_columns_are_converted(measured: Path) -> None:
    write_rows(measured / "units.csv", "time [ms];value [mm]", [(1e3 * t, 1e3 * y) for t, y in samples(measured)], ";")
    fitted = {}
    for name in ("data", "units"):
        said = run("optimize", scene(measured, f"{name}.csv"))
        assert "warning: measurement" not in said
        fitted[name] = table(measured / "out" / "parameters.csv")["value"][0]
    assert fitted["data"] == pytest.approx(50, rel=1e-6) and fitted["units"] == pytest.approx(fitted["data"], rel=1e-9)


@pytest.mark.parametrize("scale, text", ((1, "table.csv: the data end at 0.3 s, but the run at 0.6 s"), (1e-3, "a thousandth of the run's 0.6 s or less")))
def test_doubtful_times_are_warned_of(measured: Path, scale: float, text: str) -> None:
    write_rows(measured / "table.csv", "time,value", [(scale * t, y) for t, y in samples(measured)[:15]])
    said = run("optimize", scene(measured, "table.csv"), "--set", "optimizer.max_iterations=0")
    warnings = [one["message"] for one in json.loads((measured / "out" / "run.json").read_text())["warnings"] if one["name"] == "table"]
    assert len(warnings) == 1 and text in warnings[0] and f"warning: {warnings[0]}" in said and said.count(text) == 1


@pytest.mark.parametrize("verb", ("simulate", "check", "info"))
def test_table_of_a_load_in_other_units(measured: Path, verb: str) -> None:
    (measured / "push.csv").write_text("time,push\n" + "".join(f"{t},{-t}\n" for t in range(0, 101)))  # of milliseconds
    command = [str(SIGNORINI), verb, str(measured / "scene.toml"), "--set", 'load.body=["0", {file = "push.csv", column = "push"}]']
    text = f"load.body: {measured}/push.csv: the run, from 0 to 0.6 s, uses one of 100 intervals of the table, whose times range from 0 to 100 s"
    if verb == "simulate":
        command += ["--replace", "--out", str(measured / "out")]
    assert text in captured(command).stdout
    if verb == "simulate":
        assert text in json.loads((measured / "out" / "run.json").read_text())["warnings"][0]["message"]


SLIDING = """[mesh]
file = "block.geo"
size = 0.2
[time]
end = 0.5
step = 1e-3
scheme = "contact-stabilized"
[material]
density = 1000.0
young = 1e7
poisson = 0.3
viscosity = { bulk = 2e5, shear = 1e5 }
[contact]
on = "bottom"
friction = 0.25
obstacle = { name = "incline", shape = "half-space", point = [0, 0], normal = [0, 1] }
[load]
gravity = [3.355218, -9.218385]
[initial]
static = true
velocity = ["0.4", "0"]
[[unknown]]
of = "initial.velocity"
component = "x"
name = "speed"
start = 1.0
[[measurement]]
of = "displacement"
component = "y"
point = [0.5, 1]
file = "rest.csv"
noise = 0.02
"""


def test_unknown_that_hardly_matters(tmp_path: Path) -> None:
    """The height of a block that slides down tells its speed by rounding only: the number that the search ends with is none of the block's."""
    file = tmp_path / "rest.toml"
    file.write_text(SLIDING.replace("block.geo", str(SOURCE / "meshes" / "block.geo")))
    run("simulate", file, "--measure", "--seed", "1")
    said = run("optimize", file)
    found = re.search(r"^speed +(\S+) +(\S+) ", said, re.MULTILINE)
    assert float(found[2]) > 1e3, "the speed is found: the case says nothing"
    assert re.search(r"^(The data do not determine speed\.|speed is poorly identified: its standard deviation is .* its first guess\.)", said, re.MULTILINE), said
