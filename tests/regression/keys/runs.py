# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs of small scenes with other values of keys, and what they leave."""

import functools
import itertools
import json
import re
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path

import h5py
import numpy as np
from harness import SOURCE, signorini, table

DATA = SOURCE / "tests" / "data"
BLOCK = DATA / "block.toml"  # a unit square, 30 steps of 0.02 s
ROUNDING = 1e-12  # of sums over some hundred numbers, relative
T = 0.6  # s

# The block far from its obstacle, at rest and without weight: what else acts on it is all that it feels.
FREE = {"contact__obstacle__point": [0, -100], "load__body": ["0", "0"], "initial__velocity": ["0", "0"]}
# What the resting block is away from this is one, everywhere and at all times.
ONE_AWAY = FREE | {"objective__desired": {"displacement": ["0", "1"]}}
FLAT = {"contact__obstacle__normal": [0, 1]}

# A fit of a stiff core in a soft matrix.
CORE = SOURCE / "scenes" / "two-materials.toml"
COARSE = {"mesh__size": 0.02, "time__end": 5e-3}
STIFF = {"of": "young", "on": "inclusion", "start": 3e7}


class Run:
    """What a run left in a new folder of `parent`."""

    numbers = itertools.count()

    def __init__(self, parent: Path, verb: str, scene: Path, overrides: dict[str, object]):
        self.folder = parent / str(next(Run.numbers))
        self.stdout = signorini(verb, scene, self.folder, **overrides).stdout

    @functools.cached_property
    def steps(self) -> dict[str, np.ndarray]:
        return table(self.folder / "steps.csv")

    @functools.cached_property
    def history(self) -> dict[str, np.ndarray]:
        return table(self.folder / "history.csv")

    @functools.cached_property
    def manifest(self) -> dict:
        return json.loads((self.folder / "run.json").read_text())

    @functools.cached_property
    def echo(self) -> dict:
        return tomllib.loads((self.folder / "scene.toml").read_text())

    @functools.cached_property
    def start(self) -> dict[str, np.ndarray]:
        """The candidates before the first step."""
        contact = table(self.folder / "contact.csv")
        return {name: column[contact["step"] == 0] for name, column in contact.items()}

    @functools.cached_property
    def points(self) -> np.ndarray:
        return self.mesh("geometry")

    def mesh(self, part: str) -> np.ndarray:
        with h5py.File(self.folder / "state.h5") as file:
            return file[f"Mesh/mesh/{part}"][:]

    def field(self, name: str, file: str = "state") -> np.ndarray:
        """Stored time × node or cell × component."""
        with h5py.File(self.folder / f"{file}.h5") as h5:
            stored = h5[f"Function/{name}"]
            return np.array([stored[t][:, :2] for t in sorted(stored, key=lambda t: float(t.replace("_", ".")))])

    def momentum(self) -> np.ndarray:
        """The momentum of the block (density 1) at the end, by nodal masses: exact for linear functions."""
        triangles, x = self.mesh("topology"), self.points
        sides = x[triangles[:, 1:]] - x[triangles[:, :1]]
        areas = abs(np.linalg.det(sides[:, :, :2])) / 2
        return (areas[:, None] / 3 * self.field("velocity")[-1][triangles].sum(axis=1)).sum(axis=0)

    def gaps(self, expected: Callable[[np.ndarray, np.ndarray], np.ndarray], rtol: float = ROUNDING) -> None:
        """Compares the first gaps with a function of x and y; there must be candidates in several places."""
        x, y = self.start["x"], self.start["y"]
        assert len(x) > 2
        near(self.start["gap"], expected(x, y), rtol)


Runner = Callable[..., Run]


def run(parent: Path, verb: str, scene: Path, overrides: dict[str, object]) -> Run:
    """A run whose scene.toml says what was asked for."""
    done = Run(parent, verb, scene, overrides)
    for path, given in overrides.items():
        found = get(done.echo, path.split("__"))
        assert says(found, given), f"{path} = {given!r} is echoed as {found!r}"
    return done


def simulate_in(parent: Path, scene: Path = BLOCK, **overrides: object) -> Run:
    return run(parent, "simulate", scene, overrides)


def optimize_in(parent: Path, scene: Path = BLOCK, iterations: int = 0, **overrides: object) -> Run:
    return run(parent, "optimize", scene, {"optimizer__max_iterations": iterations} | overrides)


def get(scene: dict, path: Sequence[str]) -> object:
    for name in path:
        scene = scene[int(name)] if name.isdigit() else scene[name]
    return scene


def says(found: object, given: object) -> bool:
    """True if a value of scene.toml is the given one, or a table has all that was given."""
    if isinstance(found, list) and isinstance(given, list):
        return len(found) == len(given) and all(map(says, found, given))
    if isinstance(given, dict):
        return all(name in found and says(found[name], value) for name, value in given.items())
    if isinstance(found, str) and found.startswith("/"):  # paths are echoed in full
        return found.endswith(given)
    return found == given or str(found) == str(given) or (isinstance(found, float) and found == float(given))


def near(found: object, expected: object, rtol: float = ROUNDING) -> None:
    size = np.abs(expected).max()
    assert np.shape(found) == np.shape(expected), f"{found}, not {expected}"
    assert np.allclose(found, expected, rtol=0, atol=rtol * (size if size > 0 else 1)), f"{found}, not {expected}"


def same(a: Run, b: Run, rounding: float = 0) -> None:
    """Asserts that two motions are the same, by energies, forces and gaps."""
    for name in ("time", "kinetic_energy", "elastic_energy", "contact_force_y", "active", "min_gap"):
        near(a.steps[name], b.steps[name], rounding)


def edited(copy: Path, *edits: tuple[str, str], source: Path = BLOCK) -> Path:
    """A copy of a file with other text, as --set cannot take a key away."""
    text = source.read_text().replace('"square.geo"', f'"{DATA / "square.geo"}"')
    for old, new in edits:
        text, count = re.subn(old, new, text)
        assert count, old
    copy.write_text(text)
    return copy
