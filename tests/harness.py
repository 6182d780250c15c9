# SPDX-License-Identifier: GPL-3.0-or-later
"""What the Python tests share: running the program, reading its tables."""

import csv
import json
import re
import shutil
import subprocess
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import resident

SIGNORINI = Path(shutil.which("signorini") or "signorini").resolve()  # of PATH, as ctest and ./dev exec set it
BUILD = SIGNORINI.parent
SOURCE = Path(__file__).resolve().parents[1]
FAULTS = BUILD / "tests" / "libsignorini-faults.so"  # preloaded into a program, lets its calls fail
HALF_DISC = SOURCE / "scenes" / "half-disc.toml"
HALF_BALL = SOURCE / "scenes" / "half-ball.toml"


def signorini(verb: str, scene: Path, out: Path | None = None, ranks: int = 1, **overrides: object) -> subprocess.CompletedProcess:
    """Runs a verb; an override key's double underscore stands for the dot. Fails unless the exit status is 0."""
    done = attempt(verb, scene, out, ranks, **overrides)
    assert done.returncode == 0, f"{done.args} ended with {done.returncode}:\n{done.stdout}{done.stderr}"
    return done


def attempt(verb: str, scene: Path, out: Path | None = None, ranks: int = 1, **overrides: object) -> subprocess.CompletedProcess:
    """The same, whatever the exit status."""
    command = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    command += [str(SIGNORINI), verb, str(scene)]
    if out:
        command += ["--out", str(out), *(["--replace"] if verb == "simulate" else [])]
    for key, value in overrides.items():
        command += ["--set", f"{key.replace('__', '.')}={toml(value)}"]
    return captured(command)


def captured(command: list[str], **more: object) -> subprocess.CompletedProcess:
    """subprocess.run of a command without input, what it prints as text; quicker where it is a run on one rank."""
    if command[0] != str(SIGNORINI):
        return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, **more)
    done = resident.run(command, **more)
    done.stdout, done.stderr = done.stdout.decode(), done.stderr.decode()
    return done


def preloadable(library: Path, folder: Path) -> str:
    """A name of a library, in a scratch folder, that LD_PRELOAD can take: names end at a space or a colon there."""
    link = folder / library.name
    if not link.is_symlink():
        link.symlink_to(library)
    return str(link)


def toml(value: object) -> str:
    """A value as TOML on one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


# Numbers that a table may lack, empty or nan; anywhere else their absence is an error (docs/reference/files.md).
MAY_LACK = {
    "steps.csv": re.compile("min_gap"),  # without a candidate
    "obstacles.csv": re.compile(".*min_gap"),
    "parameters.csv": re.compile("unit"),  # of a ratio
    "history.csv": re.compile("relative_distance_to_reference"),
    "study.csv": re.compile(r"tolerance|gradient|displacement|velocity|stress|strain|von_mises|pressure|.+_(error|estimate|effectivity|envelope)|J_estimate_.+"),
}


def table(file: Path) -> dict[str, np.ndarray]:
    """The columns of a CSV file: numbers, NaN where MAY_LACK allows none; texts if one is no number. Raises ValueError for numbers that lack."""
    with open(file) as lines:
        rows = list(csv.DictReader(lines))
    return {key: column([row[key] for row in rows], f"{file}: {key}", file.name in MAY_LACK and bool(MAY_LACK[file.name].fullmatch(key))) for key in rows[0]}


def column(texts: list[str], name: str, may_lack: bool) -> np.ndarray:
    try:
        numbers = np.array([float(text) if text else np.nan for text in texts])
    except ValueError:
        return np.array(texts)
    if np.isnan(numbers).any() and not may_lack:
        raise ValueError(f"{name}: no number in row {int(np.isnan(numbers).argmax()) + 1}")
    return numbers


def stored(out: Path, file: str, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes, cells and the values (times × nodes × 3, in the order of time) of a field of a run's `file`.h5."""
    import h5py

    with h5py.File(out / f"{file}.h5") as data:
        mesh, states = data["Mesh/mesh"], data[f"Function/{name}"]
        order = sorted(states, key=lambda key: float(key.replace("_", ".")))
        return mesh["geometry"][:], mesh["topology"][:], np.array([states[key][:] for key in order])


def grids(file: Path) -> dict[str, list[float]]:
    """Field name → times. The XDMF file has one collection, in which each time is one grid with the mesh and all fields, and every
    dataset that it refers to is in the HDF5 file, in the order of time."""
    import h5py

    (collection,) = xml.parse(file).findall("Domain/*")
    assert (collection.get("GridType"), collection.get("CollectionType")) == ("Collection", "Temporal")
    found: dict[str, list[float]] = {}
    with h5py.File(file.with_suffix(".h5")) as h5:
        for number, grid in enumerate(collection):
            fields = grid.findall("Attribute")
            assert grid.get("GridType") == "Uniform" and [one.tag for one in grid[:3]] == ["Time", "Topology", "Geometry"]
            assert {one.get("Name") for one in fields} == set(h5["Function"]) and len(fields) == len(grid) - 3
            for item in grid.iter("DataItem"):
                name, path = item.text.split(":")
                assert name == file.with_suffix(".h5").name, "the XDMF file points to another folder"
                assert list(h5[path].shape) == [int(n) for n in item.get("Dimensions").split()]
                assert h5[path].dtype.kind == item.get("NumberType")[0].lower() and h5[path].dtype.itemsize == int(item.get("Precision"))
            for one in fields:
                assert one.find("DataItem").text.endswith(f"/Function/{one.get('Name')}/{number:08}")
                found.setdefault(one.get("Name"), []).append(float(grid.find("Time").get("Value")))
        for name, times in found.items():
            assert np.array_equal(h5["times"][:], times) and times == sorted(set(times))
            assert list(h5["Function"][name]) == [f"{number:08}" for number in range(len(times))], "names in the order of time"
    return found


def boundary(cells: np.ndarray) -> np.ndarray:
    """The facets that belong to one cell only, their nodes ascending."""
    facets = np.concatenate([np.delete(cells, i, axis=1) for i in range(cells.shape[1])])
    facets, cells_there = np.unique(np.sort(facets, axis=1), axis=0, return_counts=True)
    return facets[cells_there == 1]


def relative(found: float, expected: float) -> float:
    return abs(found / expected - 1)


class Figures:
    """Prints figures beside what they should be and remembers whether one is off."""

    failed = False

    def show(self, name: str, found: float, expected: float, tolerance: float) -> None:
        holds = abs(found - expected) <= tolerance
        self.failed |= not holds
        print(f"  {'ok  ' if holds else 'FAIL'} {name:48} {found:10.5f}   expected {expected:9.5f} +- {tolerance:.2g}")

    def least(self, name: str, found: float, least: float) -> None:
        self.failed |= not found >= least
        print(f"  {'ok  ' if found >= least else 'FAIL'} {name:48} {found:10.3f}   at least {least:.3f}")
