# SPDX-License-Identifier: GPL-3.0-or-later
"""What a study left in its folder: study.json and study.csv, one row for each rung of its ladders."""

import csv
import json
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from .run_folder import Unreadable, whole_text

NUMBERS = ["size", "step", "degree", "unknowns", "steps", "seconds", "memory_bytes", "tolerance"]


def is_study(folder: Path) -> bool:
    return (folder / "study.json").is_file()


@dataclass(frozen=True)
class Method:
    """What is compared at equal size and step."""

    degree: int
    scheme: str
    mass: str
    chosen: bool
    """Steps, by a tolerance; else they have one length."""
    graded: bool
    """Meshes, by the error; else of one size."""

    def __str__(self) -> str:
        return f"degree {self.degree}, {self.scheme}" + ("" if self.mass == "consistent" else f", {self.mass}") + (", steps chosen" if self.chosen else "") + (", graded" if self.graded else "")


@dataclass(frozen=True)
class Rung:
    """One run of a study: its numbers by column (NaN where a cell is empty), SI units, seconds and bytes."""

    name: str
    method: Method
    numbers: dict[str, float]

    @property
    def step(self) -> str:
        """The length of its steps, or the tolerance by which they were chosen."""
        return f"tolerance {self['tolerance']:g}" if self.method.chosen else f"{self['step']:g}"

    def __getitem__(self, column: str) -> float:
        return self.numbers[column]


class StudyFolder:
    """The folder of one study. Raises Unreadable where a file is damaged."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @cached_property
    def manifest(self) -> dict:
        """study.json."""
        file = self.path / "study.json"
        try:
            return json.loads(whole_text(file))
        except (OSError, ValueError) as error:
            raise Unreadable(f"{file}: cannot be read ({error})") from None

    @cached_property
    def rungs(self) -> list[Rung]:
        """study.csv."""
        file = self.path / "study.csv"
        parts = ("", "_error", "_estimate", "_effectivity", "_pareto", "_envelope")
        columns = NUMBERS + [f"{name}{part}" for name in self.manifest["quantities"] for part in parts]
        try:
            rows = [rung_of(row, columns) for row in csv.DictReader(whole_text(file).splitlines())]
        except KeyError as error:
            raise Unreadable(f"{file}: there is no column {error.args[0]}") from None
        except (OSError, ValueError, TypeError, csv.Error) as error:
            raise Unreadable(f"{file}: cannot be read ({error})") from None
        told = self.manifest["rungs"]
        if not rows or len(rows) != told:
            raise Unreadable(f"{file}: found {len(rows)} rows, allowed are the {told or 'several'} that study.json tells of")
        return rows

    @property
    def methods(self) -> list[Method]:
        """Those of the rungs, in their order."""
        return list(dict.fromkeys(rung.method for rung in self.rungs))


def rung_of(row: dict[str, str], columns: list[str]) -> Rung:
    method = Method(int(row["degree"]), row["scheme"], row["mass"], bool(row["tolerance"]), row["graded"] == "1")
    return Rung(row["rung"], method, {name: number(row[name]) for name in columns})


def number(cell: str | None) -> float:
    """NaN for an empty cell. A row that ends early has no cell at all."""
    if cell is None:
        raise ValueError("a row has fewer cells than there are columns")
    return float(cell) if cell else math.nan
