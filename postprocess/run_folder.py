"""What a run left in its folder, as numpy arrays in SI units.

Which file holds what is listed in the manual under "What a run leaves in its folder". Files are read when
they are first asked for, so that a folder with a part of them serves the figures that need no more.
"""

import io
import json
import tomllib
import warnings
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import h5py
import numpy as np

SEED_TIME = 1.75e-3  # s, the time of the figures in Müller and Schiela (2017), in the middle of the first contact

T = TypeVar("T")


class NotInRun(Exception):
    """The run did not write, or had no reason to write, what a figure shows."""


class Unreadable(Exception):
    """The folder is no run's folder, or a file in it is damaged."""


class Table(dict[str, np.ndarray]):
    """The columns of a .csv file by name; asking for one that is not there raises Unreadable."""

    def __init__(self, file: Path, columns: Iterable[tuple[str, np.ndarray]]) -> None:
        super().__init__(columns)
        self.file = file

    def __missing__(self, name: str) -> np.ndarray:
        raise Unreadable(f"{self.file}: there is no column {name}")


@dataclass(frozen=True)
class Mesh:
    """Nodes (n × dim, m) and cells (triangles or tetrahedra, by their node numbers) of the undeformed body."""

    points: np.ndarray
    cells: np.ndarray

    @property
    def size(self) -> float:
        """The longest side of the box around the body, m."""
        return float(np.ptp(self.points, axis=0).max())

    def outline(self) -> np.ndarray:
        """Edges of the boundary of triangles (edges × 2, node numbers): those of one triangle only."""
        edges = np.sort(self.cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        distinct, count = np.unique(edges, axis=0, return_counts=True)
        return distinct[count == 1]

    def surface(self) -> tuple[np.ndarray, np.ndarray]:
        """Triangles of the boundary of tetrahedra (triangles × 3, node numbers), counterclockwise from outside, and the
        cell that each belongs to."""
        faces = self.cells[:, [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]].reshape(-1, 3)
        _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        outer = first[count == 1]
        a, b, c = np.moveaxis(self.points[faces[outer]], 1, 0)
        inside = self.points[self.cells[outer // 4]].mean(axis=1)
        inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), inside - a) > 0
        return np.where(inwards[:, None], faces[outer][:, ::-1], faces[outer]), outer // 4

    def boundary_nodes(self) -> np.ndarray:
        """Node numbers of the boundary, ascending."""
        return np.unique(self.outline() if self.points.shape[1] == 2 else self.surface()[0])


@dataclass(frozen=True)
class Series:
    """A vector field over time, of a value for each node or, `cellwise`, for each cell: the mesh, the stored times (s)
    and where each time's values are."""

    mesh: Mesh
    times: np.ndarray
    datasets: list[tuple[Path, str]]
    cellwise: bool

    def at(self, index: int) -> np.ndarray:
        """Values at times[index], nodes or cells × dim."""
        # Functions are padded with zeros to three components in the file.
        return read_dataset(*self.datasets[index])[:, : self.mesh.points.shape[1]]


@dataclass(frozen=True)
class Contact:
    """Gap (m) and normal force (N, in the plane N/m) of every candidate node (m × dim, m) at the stored times (s)."""

    times: np.ndarray
    points: np.ndarray
    gap: np.ndarray
    force: np.ndarray

    def touching(self, index: int, tolerance: float) -> np.ndarray:
        """Which candidates are in contact at times[index]: they carry a force or have no gap; tolerance in m."""
        return (self.force[index] > 0) | (self.gap[index] <= tolerance)


@dataclass(frozen=True)
class HalfSpace:
    """The rigid half-space (x - point)·normal ≤ 0; point in m, normal of length 1 and out of the obstacle."""

    point: np.ndarray
    normal: np.ndarray

    def height(self, x: np.ndarray) -> np.ndarray:
        """Distance of points (n × dim, m) from the plane, positive outside of the obstacle, m."""
        return (x - self.point) @ self.normal

    @property
    def tangent(self) -> np.ndarray:
        """Unit vector along the plane, to the right where the obstacle is a floor (two dimensions)."""
        return np.array([self.normal[1], -self.normal[0]])


class RunFolder:
    """The folder of one run. Raises Unreadable if there is no scene.toml in it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.is_dir():
            raise Unreadable(f"{path}: there is no such folder")
        if not (path / "scene.toml").is_file():
            raise Unreadable(f"{path}: this is not the folder of a run, since there is no scene.toml in it")

    @cached_property
    def scene(self) -> dict:
        """The scene with every default written out."""
        return self._read("scene.toml", read_scene)

    @cached_property
    def manifest(self) -> dict:
        """run.json."""
        return self._read("run.json", lambda file: json.loads(whole_text(file)))

    @property
    def verb(self) -> str:
        """What was run: simulate or optimize."""
        return str(self.manifest.get("verb", "run"))

    @cached_property
    def steps(self) -> Table:
        """steps.csv: energies and works (J, in the plane J/m), forces (N, N/m) of every time step after row 0."""
        table = self._table("steps.csv", lambda: self.steps_done + 1)
        if len(table["time"]) < 2:
            raise NotInRun("the run made no time step")
        return table

    @cached_property
    def history(self) -> Table:
        """history.csv: one row per iteration of the optimizer."""
        return self._table("history.csv", lambda: self.manifest["optimizer"]["iterations"] + 1)

    @cached_property
    def contact(self) -> Contact:
        """contact.csv, by stored step and candidate node."""
        table = self._table("contact.csv", lambda: self.stored_steps * self.manifest["candidates"])
        steps, first = np.unique(table["step"], return_index=True)
        shape = (len(steps), -1)
        try:
            gap, force = table["gap"].reshape(shape), table["force"].reshape(shape)
        except ValueError:
            raise Unreadable(f"{self.path / 'contact.csv'}: not every step has the same number of nodes") from None
        axes = [table[axis][: gap.shape[1]] for axis in "xyz" if axis in table]
        return Contact(table["time"][first], np.column_stack(axes), gap, force)

    @cached_property
    def obstacle(self) -> HalfSpace:
        """What the body may touch, in a scene with contact."""
        if isinstance(self.scene["contact"], list):
            raise NotInRun("several obstacles are not drawn, only one")
        obstacle = self.scene["contact"]["obstacle"]
        if obstacle["shape"] != "half-space":
            raise NotInRun(f"an obstacle of the shape \"{obstacle['shape']}\" is not drawn, only a half-space")
        if any(isinstance(coordinate, str) for coordinate in obstacle["point"]):
            raise NotInRun("an obstacle that moves is not drawn, only one at rest")
        normal = np.array(obstacle["normal"], dtype=float)
        return HalfSpace(np.array(obstacle["point"], dtype=float), normal / np.linalg.norm(normal))

    @property
    def has_contact(self) -> bool:
        return "contact" in self.scene

    @property
    def has_contact_table(self) -> bool:
        """Whether the run left contact.csv."""
        return (self.path / "contact.csv").is_file()

    @property
    def touches(self) -> bool:
        """Whether the body touches the obstacle at any time step, or, without steps.csv, at any stored one."""
        return self.has_contact and bool(self._contact_history[1].any())

    def require_contact(self) -> None:
        """Raises NotInRun if there is no contact force to draw."""
        if not self.has_contact:
            raise NotInRun("the scene has no contact")
        if not self.touches:
            raise NotInRun("the body never touches the obstacle")

    @property
    def dim(self) -> int:
        """Space dimension."""
        return len(self.scene["initial"]["displacement"])

    @cached_property
    def normal_force(self) -> np.ndarray:
        """Total contact force along the obstacle's normal at every time step, N (in the plane N/m)."""
        force = np.column_stack([self.steps[f"contact_force_{axis}"] for axis in "xyz"[: self.dim]])
        return force @ self.obstacle.normal

    def field(self, file: str, name: str) -> Series:
        """The function `name` of `file` (one of the .xdmf files)."""
        document = self._read(file, lambda path: ElementTree.fromstring(whole_text(path)))
        grids = document.findall(f".//Grid[@GridType='Collection'][@Name='{name}']/Grid")
        if not grids:
            raise NotInRun(f"{file} holds no {name}")
        times = np.array([float(grid.find("Time").get("Value")) for grid in grids])
        datasets = [self._reference(grid.find("Attribute/DataItem")) for grid in grids]
        points = read_dataset(*self._reference(document.find(".//Geometry/DataItem")))
        cells = read_dataset(*self._reference(document.find(".//Topology/DataItem")))
        centers = {grid.find("Attribute").get("Center") for grid in grids}
        return Series(Mesh(points, cells), times, datasets, centers == {"Cell"})

    def figure_time(self) -> float:
        """The time that shows contact best, s: the seed's if the body touches there, else that of the largest force."""
        inside = SEED_TIME <= self.last_time
        try:
            touches = self.touches
        except NotInRun:  # no table tells
            touches = False
        if not touches:
            return SEED_TIME if inside else self.last_time
        times, touching, force = self._contact_history
        if inside and touching[nearest(times, SEED_TIME)]:
            return SEED_TIME
        return float(times[np.argmax(force)])

    @property
    def last_time(self) -> float:
        """The time that the run reached, s."""
        return self.steps_done * self.scene["time"]["step"]

    @property
    def steps_done(self) -> int:
        """How many time steps the run made."""
        return self.told(lambda: int(self.manifest["steps"]["done"]))

    @property
    def stored_steps(self) -> int:
        """How many steps have rows in contact.csv: the initial state, every so manyth, and the last one."""
        return -(-self.steps_done // self.scene["output"]["every"]) + 1

    def check_time(self, time: float) -> None:
        """Raises Unreadable if the run did not reach the time (s)."""
        if not 0 <= time <= self.last_time * (1 + 1e-9):
            raise Unreadable(f"--time: found {time:g} s, allowed are 0 to {self.last_time:g} s, the times of this run")

    @property
    def _contact_history(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times (s), whether the body touches then, and the normal force (N, in the plane N/m).

        Of every time step from steps.csv, or, where a run left none, of the stored ones from contact.csv.
        """
        try:
            return self.steps["time"], self.steps["active"] > 0, self.normal_force
        except NotInRun:
            force = self.contact.force.sum(axis=1)
            return self.contact.times, force > 0, force

    def _reference(self, item: ElementTree.Element) -> tuple[Path, str]:
        """The file and the dataset that a DataItem such as `state.h5:/Mesh/mesh/geometry` names."""
        file, dataset = item.text.strip().split(":", 1)
        return self.path / file, dataset

    def told(self, entry: Callable[[], T]) -> T:
        """What run.json and scene.toml say. Raises Unreadable where they have no such entry."""
        try:
            return entry()
        except (KeyError, TypeError, AttributeError) as error:
            found = f"{type(error).__name__}: {error}"
            raise Unreadable(f"{self.path}: run.json or scene.toml is not as a run writes it ({found})") from None

    def _table(self, file: str, rows: Callable[[], int]) -> Table:
        """A .csv file with as many rows as run.json tells of, where there is one."""
        table = self._read(file, read_csv)
        found = len(next(iter(table.values())))
        if (self.path / "run.json").is_file() and found != (told := self.told(rows)):
            raise Unreadable(f"{self.path / file}: found {found} rows, but run.json tells of {told}: it was cut, or is of another run")
        return table

    def _read(self, file: str, read: Callable[[Path], T]) -> T:
        path = self.path / file
        if not path.is_file():
            verb = f", a run of {self.verb}" if (self.path / "run.json").is_file() else ""
            raise NotInRun(f"there is no {file} in {self.path}{verb}")
        try:
            return read(path)
        except (OSError, ValueError, ElementTree.ParseError) as error:
            raise Unreadable(f"{path}: cannot be read ({str(error).split(';')[0]})") from None


def whole_text(file: Path) -> str:
    """A text file that ends as every line of it does. Raises ValueError where it does not: then its end is missing."""
    text = file.read_text(encoding="utf-8")
    if not text.endswith("\n"):
        raise ValueError("its end is missing")
    return text


def read_scene(file: Path) -> dict:
    """scene.toml, which would be one without its last tables too. Raises ValueError where the last key is missing."""
    scene = tomllib.loads(whole_text(file))
    if "tables" not in scene.get("output", {}):
        raise ValueError("its end is missing")
    return scene


def read_csv(file: Path) -> Table:
    """A table below one line of column names. Raises ValueError where a row is not whole."""
    header, _, body = whole_text(file).partition("\n")
    names = header.split(",")
    with warnings.catch_warnings(action="ignore"):
        rows = np.loadtxt(io.StringIO(body), delimiter=",", ndmin=2)
    if rows.size == 0:
        raise ValueError("there are no rows below the column names")
    if rows.shape[1] != len(names):
        raise ValueError(f"{len(names)} column names above {rows.shape[1]} columns")
    return Table(file, zip(names, rows.T))


def read_dataset(file: Path, dataset: str) -> np.ndarray:
    """One dataset of an HDF5 file. Raises Unreadable if the file or the dataset is missing or damaged."""
    if not file.is_file():
        raise Unreadable(f"{file}: there is no such file")
    try:
        with h5py.File(file, "r") as data:
            return data[dataset][()]
    except (OSError, KeyError) as error:
        raise Unreadable(f"{file}: {dataset} cannot be read ({error})") from None


def nearest(times: np.ndarray, time: float) -> int:
    """Index of the stored time nearest to `time`, both in s."""
    return int(np.argmin(np.abs(times - time)))
