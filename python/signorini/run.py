# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a run in its folder: tables, fields, its page. Files are read when first used, by signorini.post."""

from __future__ import annotations

import contextlib
import html
import io
import os
import subprocess
import sys
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from . import _signorini
from .post import files as _files
from .post import run_folder as _run_folder
from .world import RANK, from_root

if TYPE_CHECKING:
    import pandas

    Table = pandas.DataFrame | np.ndarray


def read(folder: str | os.PathLike) -> Run:
    """Returns the run whose results are in a folder. Raises SceneError if the folder has no results of a run."""
    return Run(Path(folder).absolute())


class Run:
    """Results of a run in its folder. Tables are DataFrames if pandas is installed, else structured arrays; columns and units
    are those of the page "Files and columns". Files are read when first used. Raises SceneError for files that the run did
    not write, that are damaged, or that another run replaced before they were read."""

    _scratch = None  # a scratch folder, which is removed with this object

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._stamp = self._manifest_bytes()
        with self._told():
            self._run = _run_folder.RunFolder(folder)
            self._manifest = None if self._stamp is None else self._run.manifest

    def _manifest_bytes(self) -> bytes | None:
        """Content of run.json, which differs for every run; None without, as while a new one is put in place."""
        try:
            return (self.folder / "run.json").read_bytes()
        except OSError:
            return None

    @contextlib.contextmanager
    def _told(self) -> Iterator[None]:
        """Turns errors of signorini.post into SceneError. Raises SceneError, too, if the files are another run's by now."""
        try:
            yield
        except (_files.NotInRun, _files.Unreadable) as error:
            self._require_same()
            raise _signorini.SceneError(str(error)) from None
        self._require_same()

    def _require_same(self) -> None:
        if self._manifest_bytes() != self._stamp and self.folder.is_dir():
            raise _signorini.SceneError(f"{self.folder}: another run was written to this folder after this run was read; signorini.read() reads the new run")

    def __repr__(self) -> str:
        return "\n".join([f"<signorini.Run {self.folder}: {self._run.identity}>", *(f"warning: {text}" for text in self.warnings)])

    @property
    def warnings(self) -> list[str]:
        """Warnings about the reliability of the results, in sentences."""
        return [one["message"] for one in self.manifest.get("warnings", [])]

    @property
    def manifest(self) -> dict:
        """Content of run.json."""
        with self._told() if self._manifest is None else contextlib.nullcontext():
            return self._run.manifest

    @property
    def scene(self) -> dict:
        """The resolved scene, with every default, as nested dicts."""
        with self._told():
            return self._run.scene

    @property
    def objective(self) -> float:
        """Value of the objective J of the run."""
        try:
            return self.manifest["objective"]["value"]
        except (KeyError, TypeError):
            raise _signorini.SceneError(f"{self.folder}: the run has no objective") from None

    # --- Tables ------------------------------------------------------------------------------------------

    @cached_property
    def steps(self) -> Table:
        """steps.csv: energies, works, forces of every time step after row 0."""
        return self.table("steps")

    @cached_property
    def contact(self) -> Table:
        """contact.csv: gap and force of every candidate at the stored times."""
        return self.table("contact")

    @cached_property
    def obstacles(self) -> Table:
        """obstacles.csv: forces and contact of every step and obstacle."""
        return self.table("obstacles")

    @cached_property
    def bodies(self) -> Table:
        """bodies.csv: motion and energy of every step and body; only with contact.against."""
        return self.table("bodies")

    @cached_property
    def history(self) -> Table:
        """history.csv: iterations of the optimizer after row 0."""
        return self.table("history")

    @cached_property
    def parameters(self) -> Table:
        """parameters.csv: the unknowns of a fit."""
        return self.table("parameters")

    @cached_property
    def scenarios(self) -> Table:
        """scenarios.csv: J of every scenario; only with tables [[scenario]]."""
        return self.table("scenarios")

    @cached_property
    def measurements(self) -> Table:
        """measurements.csv: measured values beside those of the fitted scene."""
        return self.table("measurements")

    @cached_property
    def probes(self) -> Table:
        """probes.csv: the probes of the scene at every step."""
        return self.table("probes")

    def table(self, name: str) -> Table:
        """Returns the table in a .csv file of the run. `name`: name of the file without .csv."""
        with self._told():
            text = self._run.read(f"{name}.csv", _files.whole_text)
        try:
            import pandas
        except ImportError:
            return np.genfromtxt(io.StringIO(text), delimiter=",", names=True, dtype=None, encoding=None, deletechars="")
        return pandas.read_csv(io.StringIO(text), float_precision="round_trip")

    # --- Fields ------------------------------------------------------------------------------------------

    def field(self, name: str, file: str | None = None) -> Field:
        """Returns a field over time, such as "displacement", "velocity", "control", "adjoint". `file`: name of its .xdmf or .vtkhdf
        file, without that ending; by default the file that has it."""
        files = [file] if file else ["state", name, "control", "adjoint"]
        for stem in files:
            if not self._run.has_fields(stem):
                continue
            with self._told():
                try:
                    return Field(name, self, self._run.field(stem, name))
                except _files.NotInRun:
                    continue
        raise _signorini.SceneError(f"{self.folder}: the run wrote no field {name}")

    @cached_property
    def mesh(self) -> object:
        """Mesh of the run's fields: `points` (nodes × dim, m) and `cells` (cells × corners, node numbers), undeformed."""
        for stem in ("state", "control", "adjoint"):
            if self._run.has_fields(stem):
                with self._told():
                    return self._run.mesh(stem)
        raise _signorini.SceneError(f"{self.folder}: the run wrote no field, and no mesh with it")

    # --- Page --------------------------------------------------------------------------------------------

    def report(self) -> Path:
        """Returns the path of the run's page, report.html, which rank 0 makes if it is missing. Collective."""
        with self._told():
            page, failure = self.folder / "report.html", None
        if RANK == 0 and not page.is_file():
            made = subprocess.run([sys.executable, Path(_files.__file__).with_name("report.py"), self.folder], capture_output=True, text=True)
            failure = made.stderr.strip() if made.returncode else None
        if failure := from_root(failure):
            raise _signorini.SceneError(failure)
        return page

    def show(self, height: int = 900) -> object:
        """Returns the page for a notebook, `height` pixels high."""
        return Page(self.report().read_text(encoding="utf-8"), height)

    def _repr_html_(self) -> str:
        """The run as a table for a notebook; show() has its page."""
        found = self.manifest
        rows = {"scene": found.get("scene"), "verb": found.get("verb"), "finished": found.get("finished"), "unknowns": found.get("unknowns"),
                "steps": found.get("steps", {}).get("done"), "J": found.get("objective", {}).get("value"), "folder": self.folder}  # fmt: skip
        cells = "".join(f"<tr><th>{name}</th><td>{html.escape(str(value))}</td></tr>" for name, value in rows.items() if value is not None)
        warned = "".join(f"<li>{html.escape(text)}</li>" for text in self.warnings)
        return f"<table>{cells}</table>" + (f"<ul>{warned}</ul>" if warned else "")


class Page:
    """An HTML page within a notebook, where it is the value of a cell; IPython.display.display() shows it elsewhere."""

    def __init__(self, text: str, height: int) -> None:
        self.text, self.height = text, height

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{html.escape(self.text)}" style="width:100%;height:{self.height}px;border:0"></iframe>'


class Field:
    """A field over time. Values are read from the file when used: field[3] has those of one stored time, field.values all of them
    (times × nodes or cells × components; of strain and stress times × cells × 3 × 3)."""

    def __init__(self, name: str, run: Run, series: object) -> None:
        self.name = name
        self._run = run  # whose scratch folder stays as long
        self._series = series

    def __repr__(self) -> str:
        return f"<signorini.Field {self.name} at {len(self)} times>"

    @property
    def mesh(self) -> object:
        """Undeformed mesh of the field: `points` (nodes × dim, m) and `cells` (cells × corners, node numbers)."""
        return self._series.mesh

    @property
    def times(self) -> np.ndarray:
        """Times at which the field is stored, s."""
        return self._series.times

    @property
    def cellwise(self) -> bool:
        """Whether the field has a value for each cell; else it has one for each node."""
        return self._series.cellwise

    def __len__(self) -> int:
        return len(self._series.times)

    def __getitem__(self, index: int) -> np.ndarray:
        """Returns the values at times[index]. (nodes or cells × components; tensors: cells × 3 × 3)"""
        with self._run._told():
            return self._series.values(range(len(self))[index])

    @cached_property
    def values(self) -> np.ndarray:
        """Values at all stored times. (times × nodes or cells × components; tensors: times × cells × 3 × 3)"""
        return np.array([self[index] for index in range(len(self))])
