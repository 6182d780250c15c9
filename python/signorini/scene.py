# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes: their motions, searches, checks and problems."""

import math
import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from . import _signorini
from .fit import Fit
from .problem import Problem
from .world import RANK, from_root, wait
from .run import Run, read

DONE, CHECK_FAILED, SOLVER_FAILED, INTERRUPTED = 0, 1, 3, 130  # exit statuses of the program


class Scene:
    """A scene file, with overrides: `Scene("half-disc.toml", {"mesh.size": 1})`. The file is read at once, and
    relative paths start from its folder: later changes of the file or of the current folder have no effect.

    An override's key is that of the program's --set, such as "contact.obstacle.point" or "material.0.young"; its value is
    a bool, a number, a text, a path, a list or array, or, for a whole table, a dict. Collective. Raises SceneError.
    """

    def __init__(self, file: str | os.PathLike, overrides: Mapping[str, object] | None = None) -> None:
        self._overrides = [f"{key}={toml(value)}" for key, value in (overrides or {}).items()]
        self._scene = _signorini.Scene(Path(file), self._overrides)

    def __repr__(self) -> str:
        return f"<signorini.Scene {self.file}{''.join(', ' + one for one in self._overrides)}>"

    @property
    def file(self) -> Path:
        """Absolute path of the scene file."""
        return self._scene.file

    @property
    def name(self) -> str:
        """Name of the scene file without its extension."""
        return self._scene.name

    @cached_property
    def text(self) -> str:
        """The scene as TOML with overrides and every default written out. The first access makes the mesh, on which some
        defaults depend. Collective. Raises SceneError."""
        return self._scene.text()

    def simulate(self, out: str | os.PathLike | None = None, *, quiet: bool = True, replace: bool = False) -> Run:
        """Computes the scene's motion, as the program's verb does, and returns the run.

        `out`: the folder for its files; by default a scratch folder that is removed with the run. `replace`: remove the results
        of a search in `out`. Collective. Raises SceneError, SolverFailure, OSError if `out` cannot be written, and
        KeyboardInterrupt at Ctrl-C, after the computed part of the motion has been written.
        """
        return self._run("simulate", out, quiet, replace=replace)

    def optimize(self, out: str | os.PathLike | None = None, *, quiet: bool = True, resume: bool = False) -> Run:
        """Solves the scene's control problem, or fits its unknowns, by the optimizer of the scene, and returns the run.

        `resume`: continue a search that was stopped in `out`. Other options and errors are those of simulate().
        """
        return self._run("optimize", out, quiet, resume=resume)

    def check(self, *, quiet: bool = True) -> bool:
        """Whether derivatives and discrete invariants are correct on this scene; prints a table unless `quiet`. Collective. Raises
        SceneError, SolverFailure, KeyboardInterrupt."""
        return self._status("check", Path(), quiet) == DONE

    def problem(self) -> Problem:
        """Returns the scene's control problem: J and its derivatives. Collective. Raises SceneError, SolverFailure, KeyboardInterrupt."""
        return Problem(self)

    def fit(self) -> Fit:
        """Returns the scene's unknowns and measurements as a least-squares problem. Collective. Raises SceneError, KeyboardInterrupt."""
        return Fit(self)

    def _status(self, verb: str, out: Path, quiet: bool, resume: bool = False, replace: bool = False) -> int:
        status = self._scene.run(verb, out, resume, replace, quiet)
        if status == INTERRUPTED:
            raise KeyboardInterrupt
        return status

    def _run(self, verb: str, out: str | os.PathLike | None, quiet: bool, **options: bool) -> Run:
        scratch = TemporaryDirectory(prefix="signorini-") if out is None and RANK == 0 else None
        folder = Path(from_root(scratch.name if scratch else None)) if out is None else Path(out).absolute()
        status = self._status(verb, folder, quiet, **options)
        wait()  # for the files
        run = read(folder)
        run._scratch = scratch
        if status == SOLVER_FAILED:
            raise _signorini.SolverFailure(f"{self.file}: {run.manifest['stop_reason']}"
                                           + ("" if out is None else f"; results until then are in {folder}"))  # fmt: skip
        return run


def toml(value: object) -> str:
    """Returns a value as TOML on one line."""
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)  # inf and nan are numbers of TOML
    if isinstance(value, str | os.PathLike):
        return '"' + "".join(escaped(letter) for letter in os.fspath(value)) + '"'
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{toml(str(key))} = {toml(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml, value)) + "]"
    raise TypeError(f"found an override of type {type(value).__name__}; expected a bool, number, text, path, list or dict")


def escaped(letter: str) -> str:
    """Returns a character as it is written in a TOML string, escaped if necessary."""
    return f"\\u{ord(letter):04x}" if letter in '"\\\x7f' or letter < " " else letter
