# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a study in its folder: study.json and study.csv, one row for each rung."""

import csv
import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeVar

from .run_folder import Unreadable, whole_text

OF_SEARCHES = ["tolerance", "J", "J_above_least", "iterations", "forward_sweeps", "adjoint_sweeps", "seconds"]
NUMBERS = ["size", "step", "degree", "unknowns", "steps", "seconds", "memory_bytes", "tolerance"]


Row = TypeVar("Row")


def is_study(folder: Path) -> bool:
    return (folder / "study.json").is_file()


@dataclass(frozen=True)
class Method:
    """Method of a rung: its properties besides size and step, such as degree and scheme."""

    degree: int
    scheme: str
    mass: str
    chosen: bool
    """Whether step lengths are chosen by a tolerance; else they are equal."""
    graded: bool
    """Whether meshes are graded by the error; else they have one size."""

    def __str__(self) -> str:
        return f"degree {self.degree}, {self.scheme}" + ("" if self.mass == "consistent" else f", {self.mass}") + (", steps chosen" if self.chosen else "") + (", graded" if self.graded else "")


@dataclass(frozen=True)
class Rung:
    """Run of a study: its numbers by column (NaN where a cell is empty), SI units, seconds and bytes."""

    name: str
    method: Method
    numbers: dict[str, float]

    @property
    def step(self) -> str:
        """Length of the rung's steps, s; for steps of varying length their tolerance."""
        return f"tolerance {self['tolerance']:g}" if self.method.chosen else f"{self['step']:g}"

    def __getitem__(self, column: str) -> float:
        return self.numbers[column]


@dataclass(frozen=True)
class Search:
    """Search of the optimum to one tolerance: its numbers by column (NaN where a cell is empty), and its stopping reason."""

    numbers: dict[str, float]
    stop_reason: str

    def __getitem__(self, column: str) -> float:
        return self.numbers[column]


class StudyFolder:
    """Folder of one study. Raises Unreadable where a file is damaged."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @cached_property
    def manifest(self) -> dict:
        """Content of study.json."""
        file = self.path / "study.json"
        try:
            return json.loads(whole_text(file))
        except (OSError, ValueError) as error:
            raise Unreadable(f"{file}: cannot be read ({error})") from None

    @cached_property
    def rungs(self) -> list[Rung]:
        """Rungs of study.csv."""
        parts = ("", "_error", "_estimate", "_effectivity", "_pareto", "_envelope")
        columns = NUMBERS + [f"{name}{part}" for name in self.manifest["quantities"] for part in parts]
        return self.rows("study.csv", self.manifest["rungs"], lambda row: rung_of(row, columns))

    @cached_property
    def searches(self) -> list[Search]:
        """Searches of search.csv; empty if the study has none."""
        count = self.manifest["searches"]
        return self.rows("search.csv", count, lambda row: Search({name: number(row[name]) for name in OF_SEARCHES}, row["stop_reason"])) if count else []

    def rows(self, name: str, count: int, read: Callable[[dict[str, str]], Row]) -> list[Row]:
        """Reads the rows of a table. Raises Unreadable unless there are `count`, as in study.json."""
        file = self.path / name
        try:
            rows = [read(row) for row in csv.DictReader(whole_text(file).splitlines())]
        except KeyError as error:
            raise Unreadable(f"{file}: there is no column {error.args[0]}") from None
        except (OSError, ValueError, TypeError, csv.Error) as error:
            raise Unreadable(f"{file}: cannot be read ({error})") from None
        if not rows or len(rows) != count:
            raise Unreadable(f"{file}: {len(rows)} rows, but study.json counts {count}; run the study again")
        return rows

    @property
    def methods(self) -> list[Method]:
        """Methods of the rungs, in their order."""
        return list(dict.fromkeys(rung.method for rung in self.rungs))


def rung_of(row: dict[str, str], columns: list[str]) -> Rung:
    method = Method(int(row["degree"]), row["scheme"], row["mass"], bool(row["tolerance"]), row["graded"] == "1")
    return Rung(row["rung"], method, {name: number(row[name]) for name in columns})


def number(cell: str | None) -> float:
    """Returns the number in a cell, NaN for an empty one. Raises ValueError without a cell, where a row ends early."""
    if cell is None:
        raise ValueError("a row has fewer cells than there are columns")
    return float(cell) if cell else math.nan
