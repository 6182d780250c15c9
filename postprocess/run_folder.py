# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a run in its folder, as numpy arrays in SI units.

docs/reference/files.md lists the contents of the files. Files are read when first used, so that a folder with
a part of them suffices for the figures that need no others.
"""

import json
import tomllib
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import numpy as np

from .contact_table import MOTION, STATUS, Contact, ObstacleSteps, contact_of
from .field_files import FieldFile, VtkhdfFile, XdmfFile
from .files import NotInRun, Table, Unreadable, read_csv, whole_text
from .mesh import Mesh, Series
from .obstacles import Obstacle, normals, read_obstacles

SEED_TIME = 1.75e-3  # s, the time of the figures in Müller and Schiela (2017), in the middle of the first contact

T = TypeVar("T")


class RunFolder:
    """Folder of one run. Raises Unreadable if there is no scene.toml in it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.is_dir():
            raise Unreadable(f"{path}: there is no such folder")
        if not (path / "scene.toml").is_file():
            raise Unreadable(f"{path}: this is not the folder of a run, since there is no scene.toml in it")

    @cached_property
    def scene(self) -> dict:
        """Scene with every default written out."""
        return self.read("scene.toml", read_scene)

    @cached_property
    def manifest(self) -> dict:
        """Content of run.json."""
        return self.read("run.json", lambda file: json.loads(whole_text(file)))

    @property
    def is_fit(self) -> bool:
        """Whether unknowns were fitted to measurements."""
        return (self.path / "run.json").is_file() and "unknowns_fitted" in self.manifest

    @property
    def verb(self) -> str:
        """Verb of the run: simulate or optimize."""
        return str(self.manifest.get("verb", "run"))

    @property
    def identity(self) -> str:
        """Description of the run in the folder: verb, scene and time."""
        return self.entry(lambda: f"{self.verb} of {self.manifest['scene']}, finished "
                                 + str(self.manifest["finished"]).replace("T", " ").replace("Z", " UTC"))  # fmt: skip

    @cached_property
    def steps(self) -> Table:
        """steps.csv: energies and works (J or J/m, RunFolder.whole), forces (N, N/m) of every time step after row 0."""
        table = self._table("steps.csv", lambda: self.steps_done + 1)
        if len(table["time"]) < 2:
            raise NotInRun("the run made no time step")
        return table

    @property
    def has_indicators(self) -> bool:
        """Whether the run wrote each cell's share in the error."""
        return (self.path / "indicators.csv").is_file()

    @cached_property
    def indicators(self) -> Table:
        """indicators.csv: the corners of each cell (m) and its share in the error, relative."""
        return self._table("indicators.csv", lambda: int(self.manifest["cells"]))

    @cached_property
    def history(self) -> Table:
        """history.csv: one row per iteration of the optimizer."""
        return self._table("history.csv", lambda: self.manifest["optimizer"]["iterations"] + 1)

    @cached_property
    def contact(self) -> Contact:
        """contact.csv: contact by stored step and candidate."""
        table = self._table("contact.csv", lambda: self.stored_steps * self.manifest["candidates"])
        try:
            return contact_of(table)
        except ValueError:
            raise Unreadable(f"{self.path / 'contact.csv'}: not every step has the same number of nodes") from None

    @cached_property
    def obstacles(self) -> list[Obstacle]:
        """Surfaces of the obstacles, in the scene's order."""
        return self.read("surfaces.h5", lambda file: read_obstacles(file, self.obstacle_names, self.axisymmetric))

    @property
    def plane_normal(self) -> np.ndarray | None:
        """Outward normal of the obstacle if the scene has only one and it is a plane; else None."""
        if not self.has_contact or len(self.obstacle_names) > 1 or not self.obstacles[0].flat:
            return None
        return self.obstacles[0].normal[0] if self.has_pairs else normals(self.obstacles[0].points, self.obstacles[0].facets)[0]

    @cached_property
    def obstacle_steps(self) -> list[ObstacleSteps]:
        """obstacles.csv: contact of each obstacle over the steps, in the scene's order."""
        table = self.read("obstacles.csv", lambda file: read_csv(file, {"obstacle": self.obstacle_names}))
        numbers = np.unique(table["obstacle"])
        rows = [table["obstacle"] == number for number in numbers]
        if any(own.sum() != self.steps_done + 1 for own in rows) or len(rows) != len(self.obstacle_names):
            raise Unreadable(f"{self.path / 'obstacles.csv'}: the number of rows is not that of steps times obstacles")
        force, active = table["normal_force"], table["active"]
        resultant = np.column_stack([table[f"force_{axis}"] for axis in "xyz"[: self.dim]])
        return [ObstacleSteps(name, force[own], active[own], resultant[own]) for name, own in zip(self.obstacle_names, rows)]

    @cached_property
    def probes(self) -> Table:
        """probes.csv: the probes of the scene, one row per time step."""
        return self._table("probes.csv", lambda: self.steps_done + 1)

    @property
    def obstacle_names(self) -> list[str]:
        """Names of the obstacles: those that the scene gives, or numbers."""
        given = self.scene.get("contact", [])
        tables = given if isinstance(given, list) else [given]
        return [f"{table['on']}/{table['against']}" if "against" in table else table["obstacle"].get("name", f"obstacle {i}")
                for i, table in enumerate(tables, 1)]  # fmt: skip

    @property
    def has_pairs(self) -> bool:
        """Whether parts of the body are in contact with each other."""
        given = self.scene.get("contact", [])
        return any("against" in table for table in (given if isinstance(given, list) else [given]))

    @property
    def has_contact(self) -> bool:
        return "contact" in self.scene

    @property
    def has_contact_table(self) -> bool:
        """Whether the run wrote contact.csv."""
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

    @cached_property
    def dim(self) -> int:
        """Space dimension. Raises NotInRun where no file gives it."""
        for table, key in (("initial", "displacement"), ("initial", "velocity"), ("control", "initial")):
            if isinstance(given := self.scene.get(table, {}).get(key), list):
                return len(given)
        try:
            return 3 if "contact_force_z" in self.steps else 2
        except NotInRun:
            pass
        if (stored := self._any_fields()) is not None:
            return stored.dim
        return self.contact.points.shape[1]

    @cached_property
    def model(self) -> str:
        """Kind of body: "space", "plane-strain", "plane-stress" or "axisymmetric"; one in the plane of a run that names none is in
        plane strain."""
        named = self.entry(lambda: self.manifest.get("body", {}).get("model")) if (self.path / "run.json").is_file() else None
        named = named or self.entry(lambda: self.scene["mesh"].get("model"))
        return str(named or ("plane-strain" if self.dim == 2 else "space"))

    @property
    def axisymmetric(self) -> bool:
        """Whether the mesh is the half section, x ≥ 0, of a body of revolution."""
        return self.model == "axisymmetric"

    @property
    def whole(self) -> bool:
        """Whether masses, forces and energies are those of the whole body; else they are per metre of its depth."""
        return self.model in ("space", "axisymmetric")

    @property
    def axis_names(self) -> list[str]:
        """Names of the coordinates."""
        return ["radius", "height"] if self.axisymmetric else list("xyz"[: self.dim])

    @cached_property
    def normal_force(self) -> np.ndarray:
        """Sum of the moduli of all nodal contact forces at every time step, N or N/m (`whole`). Raises NotInRun if the run wrote
        the resultant of several directions only."""
        if "normal_force" in self.steps:
            return self.steps["normal_force"]
        if (normal := self.plane_normal) is None:
            raise NotInRun("the run wrote only the resultant of the contact forces")
        return self.resultant @ normal

    @property
    def resultant(self) -> np.ndarray:
        """Resultant of the contact forces at every time step (steps × dim), N or N/m (`whole`); of parts in contact with each other, of
        the forces on the groups contact.on."""
        if self.has_pairs:
            return np.sum([one.resultant for one in self.obstacle_steps], axis=0)
        return np.column_stack([self.steps[f"contact_force_{axis}"] for axis in "xyz"[: self.dim]])

    @property
    def peak_time(self) -> float | None:
        """End of the step with the largest contact force, which is stored, s; None without contact or without a table of
        forces."""
        try:
            if not self.touches:
                return None
        except NotInRun:
            return None
        times, _, force = self._contact_history
        return float(times[first_largest(force)])

    def field(self, file: str, name: str) -> Series:
        """Returns the field `name` of "state", "control" or "adjoint"."""
        if (series := self._fields(file).series(name)) is None:
            raise NotInRun(f"{file} holds no {name}")
        return series

    def mesh(self, file: str) -> Mesh:
        """Returns the mesh of the fields of "state", "control" or "adjoint"."""
        return self._fields(file).mesh()

    @cached_property
    def boundary_mesh(self) -> Mesh:
        """Mesh of any field. Raises NotInRun where the run wrote none."""
        if (stored := self._any_fields()) is None:
            raise NotInRun("the run wrote no field, and no mesh with it")
        return stored.mesh()

    def has_fields(self, file: str) -> bool:
        """Whether the run wrote fields of "state", "control" or "adjoint"."""
        return any((self.path / f"{file}.{ending}").is_file() for ending in ("xdmf", "vtkhdf"))

    def _fields(self, file: str) -> FieldFile:
        if (self.path / f"{file}.xdmf").is_file() or not self.has_fields(file):
            return self.read(f"{file}.xdmf", XdmfFile)
        return self.read(f"{file}.vtkhdf", VtkhdfFile)

    def _any_fields(self) -> FieldFile | None:
        return next((self._fields(file) for file in ("state", "control", "adjoint") if self.has_fields(file)), None)

    def figure_time(self) -> float:
        """Returns the time that shows contact best, s: the seed's if contact is stored there, else that of the largest force."""
        inside = SEED_TIME <= self.last_time
        peak = self.peak_time
        if peak is None:
            return SEED_TIME if inside else self.last_time
        times, force = (self.contact.times, self.contact.force.sum(axis=1)) if self.has_contact_table else self._contact_history[::2]
        if inside and force[nearest(times, SEED_TIME)] > 0:
            return SEED_TIME
        return peak

    @property
    def last_time(self) -> float:
        """Last time of the computed motion, s."""
        time = self.scene["time"]
        if time["step"] != "auto":
            return self.steps_done * time["step"]
        return float(time["end"] if self.steps_done == self.entry(lambda: self.manifest["steps"]["asked"]) else self.steps["time"][-1])

    def middles(self, times: np.ndarray) -> np.ndarray:
        """Returns the middles (s) of the steps that end at these times (s); if lengths vary, by steps.csv."""
        step = self.scene["time"]["step"]
        if step != "auto":
            return times - step / 2
        ends = self.steps["time"]
        found = np.clip(np.searchsorted(ends, times * (1 - 1e-12)), 1, len(ends) - 1)
        return times - (ends[found] - ends[found - 1]) / 2

    @property
    def steps_done(self) -> int:
        """Number of time steps that the run made."""
        return self.entry(lambda: int(self.manifest["steps"]["done"]))

    @property
    def stored_steps(self) -> int:
        """Number of steps with rows in contact.csv: the initial state, some of the others, and the last one."""
        return self.entry(lambda: int(self.manifest["steps"]["stored"]))

    @property
    def stores_every_step(self) -> bool:
        return self.stored_steps == self.steps_done + 1

    def check_time(self, time: float) -> None:
        """Raises Unreadable if the run did not reach the time (s)."""
        if not 0 <= time <= self.last_time * (1 + 1e-9):
            raise Unreadable(f"--time: found {time:g} s; expected 0 to {self.last_time:g} s, the times of this run")

    @property
    def _contact_history(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times (s), whether the body touches then, and the normal force (N or N/m, `whole`).

        Every time step from steps.csv or, without it, the stored ones from contact.csv.
        """
        try:
            steps = self.steps
            try:
                force = self.normal_force
            except NotInRun:
                force = np.linalg.norm(self.resultant, axis=1)
            return steps["time"], steps["active"] > 0, force
        except NotInRun:
            force = self.contact.force.sum(axis=1)
            return self.contact.times, force > 0, force

    def entry(self, read: Callable[[], T]) -> T:
        """Returns read(), an entry of run.json or scene.toml. Raises Unreadable if there is no such entry."""
        try:
            return read()
        except (KeyError, TypeError, AttributeError) as error:
            found = f"{type(error).__name__}: {error}"
            raise Unreadable(f"{self.path}: run.json or scene.toml does not have the form that a run writes ({found})") from None

    def _table(self, file: str, rows: Callable[[], int]) -> Table:
        """Reads a .csv file. Raises Unreadable unless it has as many rows as run.json counts, if there is one."""
        words = {"obstacle": self.obstacle_names, "status": STATUS, "motion": MOTION} if file == "contact.csv" else {}
        table = self.read(file, lambda path: read_csv(path, words))
        found = len(next(iter(table.values())))
        if (self.path / "run.json").is_file() and found != (counted := self.entry(rows)):
            raise Unreadable(f"{self.path / file}: found {found} rows, but run.json counts {counted}: the file was cut, or belongs to another run")
        return table

    def read(self, file: str, read: Callable[[Path], T]) -> T:
        """Returns `read` of the path of a file of the folder. Raises NotInRun if the file is missing, Unreadable if it is damaged."""
        path = self.path / file
        if not path.is_file():
            verb = f", a run of {self.verb}" if (self.path / "run.json").is_file() else ""
            raise NotInRun(f"there is no {file} in {self.path}{verb}")
        try:
            return read(path)
        except (OSError, ValueError, ElementTree.ParseError) as error:
            raise Unreadable(f"{path}: cannot be read ({str(error).split(';')[0]})") from None


def read_scene(file: Path) -> dict:
    """Reads scene.toml. Raises ValueError if its last key is missing, since a part of the file is valid TOML, too."""
    scene = tomllib.loads(whole_text(file, with_names=True))
    if "tables" not in scene.get("output", {}):
        raise ValueError("the end of the file is missing")
    return scene


def first_largest(force: np.ndarray) -> int:
    """Returns the step of the largest force, as the program stores it: the first of those that differ by rounding alone."""
    found, rounding = 0, 1e-9
    for step in np.flatnonzero(force[1:] > np.maximum.accumulate(force)[:-1]) + 1:
        if force[step] > (1 + rounding) * force[found]:
            found = int(step)
    return found


def nearest(times: np.ndarray, time: float) -> int:
    """Returns the index of the stored time nearest to `time`, both in s."""
    return int(np.argmin(np.abs(times - time)))
