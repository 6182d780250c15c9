# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a batch in its folder: batch.json and cases.csv, one row for each case."""

import csv
import io
import json
import math
import re
import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from .files import Unreadable, whole_text
from .style import prefixed

AFTER_KEYS = ["outcome", "reason", "warnings", "steps"]
OUTCOMES = ["done", "failed"]
ROUNDING = 1e-9  # a relative range up to this is none
WITH_PREFIX = {"N", "N/m", "N s", "N s/m", "Pa", "s", "m", "m/s", "J", "J/m", "W", "Hz", "m/s²"}


def is_batch(folder: Path) -> bool:
    return (folder / "batch.json").is_file()


@dataclass(frozen=True)
class Case:
    """Row of cases.csv: the texts of its keys, and the numbers of its quantities (NaN where a cell is empty)."""

    name: str
    keys: list[str]
    done: bool
    reason: str
    warnings: str
    steps: float
    quantities: list[float]


@dataclass(frozen=True)
class Axis:
    """Values of a key, of one component of a key, or of a quantity, over all cases; NaN where a case has none.

    `values` of texts are their indices in `words`, which is empty for numbers. `unit` is that of `values`, and may have an SI prefix.
    """

    name: str
    title: str
    unit: str
    values: np.ndarray
    words: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        return f"{self.title} ({self.unit})" if self.unit else self.title

    @property
    def varies(self) -> bool:
        return varies(self.values)

    @property
    def logarithmic(self) -> bool:
        """Whether charts need a logarithmic scale: positive numbers over two decades or more, half of them below a fifth of the largest."""
        found = self.values[np.isfinite(self.values)]
        if self.words or len(found) == 0:
            return False
        return bool(found.min() > 0 and found.max() >= 100 * found.min() and np.median(found) <= found.max() / 5)


class BatchFolder:
    """Folder of one batch. Raises Unreadable where a file is damaged."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @cached_property
    def manifest(self) -> dict:
        """Content of batch.json."""
        file = self.path / "batch.json"
        try:
            found = json.loads(whole_text(file))
        except (OSError, ValueError, RecursionError) as error:
            raise Unreadable(f"{file}: cannot be read ({error})") from None
        if not isinstance(found, dict):
            raise Unreadable(f"{file}: found no object; run the batch again")
        return found

    @cached_property
    def cases(self) -> list[Case]:
        """Cases of cases.csv."""
        file, keys, quantities = self.path / "cases.csv", self.manifest["keys"], self.manifest["quantities"]
        try:
            header, *rows = csv.reader(io.StringIO(whole_text(file), newline=""), strict=True)
        except (OSError, ValueError, csv.Error) as error:
            raise Unreadable(f"{file}: cannot be read ({error})") from None
        for place, name in enumerate(["case", *keys, *AFTER_KEYS]):
            if header[place : place + 1] != [name]:
                raise Unreadable(f"{file}: there is no column {name} at place {place + 1}, where batch.json has it")
        written = header[1 + len(keys) + len(AFTER_KEYS) :]
        if missing := [name for name in quantities if name not in written] or [name for name in written if written.count(name) > 1]:
            raise Unreadable(f"{file}: there is no column {missing[0]}, or there are two")
        if unknown := [name for name in written if name not in quantities]:
            raise Unreadable(f"{file}: found the column {unknown[0]}, which batch.json does not list")
        done, failed = self.manifest["done"], self.manifest["failed"]
        if not rows or len(rows) != done + failed:
            raise Unreadable(f"{file}: found {len(rows)} rows, but batch.json counts {done + failed}; run the batch again")
        places = [written.index(name) for name in quantities]
        cases = []
        for number, row in enumerate(rows, 1):
            try:
                cases.append(case_of(row, len(keys), len(header), places))
            except ValueError as error:
                raise Unreadable(f"{file}: row {number} cannot be read ({error})") from None
        if sum(case.done for case in cases) != done:
            raise Unreadable(f"{file}: found {sum(case.done for case in cases)} cases that are done, but batch.json counts {done}")
        return cases

    @cached_property
    def done(self) -> np.ndarray:
        """Whether each case is done."""
        return np.array([case.done for case in self.cases])

    @cached_property
    def keys(self) -> dict[str, list[Axis]]:
        """Axes of each key: one, or of vectors one for each component that varies; none where the key has one value in all cases. In an
        empty cell the scene's own value holds."""
        return {key: axes_of(key, [case.keys[i] for case in self.cases], self.own(key)) for i, key in enumerate(self.manifest["keys"])}

    @cached_property
    def scene(self) -> dict:
        """Content of scene.toml; empty if there is none, or if it is damaged."""
        try:
            return tomllib.loads(whole_text(self.path / "scene.toml"))
        except (OSError, ValueError, RecursionError):
            return {}

    def own(self, key: str) -> dict[str, float | str]:
        """Value of a key in the scene, as entries_of(), which holds where a cell is empty; empty if the scene has none."""
        value = self.scene
        try:
            for part in key.split("."):
                value = value[int(part)] if isinstance(value, list) else value[part]
        except (LookupError, TypeError, ValueError):
            return {}
        return flattened(value)

    @cached_property
    def quantities(self) -> list[Axis]:
        """Axes of all quantities, in the order of batch.json. Those that vanish up to rounding are zero."""
        values = np.array([case.quantities for case in self.cases])
        sizes = np.nanmax(np.abs(values), axis=0, initial=0)
        kinds = [kind(name, given["unit"]) for name, given in self.manifest["quantities"].items()]
        largest = {one: sizes[[other == one for other in kinds]].max() for one in kinds}
        noise = sizes <= ROUNDING * np.array([largest[one] for one in kinds])
        values[:, noise] = np.where(np.isfinite(values[:, noise]), 0.0, np.nan)
        return [quantity_axis(name, str(given["title"]), str(given["unit"] or ""), values[:, i])
                for i, (name, given) in enumerate(self.manifest["quantities"].items())]  # fmt: skip


def case_of(row: list[str], keys: int, columns: int, places: list[int]) -> Case:
    """Reads a row. `places`: those of the quantities behind the fixed columns. Raises ValueError if a cell is none that a batch writes."""
    if len(row) != columns:
        raise ValueError(f"{len(row)} cells below {columns} column names")
    first = 1 + keys + len(AFTER_KEYS)
    outcome, reason, warnings, steps = row[keys + 1 : first]
    if outcome not in OUTCOMES:
        raise ValueError(f"the outcome is neither {OUTCOMES[0]} nor {OUTCOMES[1]}")
    return Case(row[0], row[1 : keys + 1], outcome == "done", reason, warnings, number(steps), [number(row[first + place]) for place in places])


def number(cell: str) -> float:
    """Returns the number in a cell, NaN for an empty one and for what is not finite."""
    value = float(cell) if cell else math.nan
    return value if math.isfinite(value) else math.nan


def varies(values: np.ndarray) -> bool:
    """Whether finite values differ by more than rounding."""
    found = values[np.isfinite(values)]
    return len(found) > 1 and bool(np.ptp(found) > ROUNDING * np.abs(found).max())


def kind(name: str, unit: str | None) -> str:
    """Returns what quantities of equal kind share: the unit or, of probes, the quantity without the axis of a component."""
    return unit or re.sub(r"_[xyz]$", "", name.split(".")[-2] if name.count(".") > 1 else name)


def quantity_axis(name: str, title: str, unit: str, values: np.ndarray) -> Axis:
    """Makes the axis of a quantity; an SI prefix keeps its numbers short."""
    found = values[np.isfinite(values)]
    factor, prefixed_unit = prefixed(found, unit) if len(found) and unit in WITH_PREFIX else (1.0, unit)
    return Axis(name, title, prefixed_unit, values * factor)


def axes_of(key: str, cells: list[str], own: dict[str, float | str]) -> list[Axis]:
    """Makes the axes of a key from its cells. `own`: entries that hold where a cell is empty."""
    entries = [entries_of(cell) or own for cell in cells]
    forms = {tuple(one) for one in entries if one}
    if len(forms) != 1:  # numbers in some cases and vectors in others: no component is common to all
        entries, forms = [{"": cell} if cell else {} for cell in cells], {("",)}
    axes = [axis_of(key + index, [one.get(index) for one in entries]) for index in next(iter(forms))]
    return [axis for axis in axes if axis.varies]


def axis_of(name: str, entries: list[float | str | None]) -> Axis:
    """Makes an axis of numbers if all entries are, else one of words."""
    if not any(isinstance(entry, str) for entry in entries):
        return Axis(name, name, "", np.array([math.nan if entry is None else entry for entry in entries]))
    texts = [None if entry is None else entry if isinstance(entry, str) else f"{entry:.10g}" for entry in entries]
    words = tuple(dict.fromkeys(text for text in texts if text is not None))
    return Axis(name, name, "", np.array([math.nan if text is None else words.index(text) for text in texts]), words)


def entries_of(cell: str) -> dict[str, float | str]:
    """Returns the numbers and texts of a cell by the index of their component, such as [1], which is empty for a single value."""
    if not cell:
        return {}
    try:
        given = tomllib.loads(f"x = {cell}\n")
    except (ValueError, RecursionError):  # an expression without quotes
        given = {}
    return flattened(given["x"] if set(given) == {"x"} else cell)


def flattened(value: object, index: str = "") -> dict[str, float | str]:
    if isinstance(value, list) and value:
        return {name: entry for i, part in enumerate(value) for name, entry in flattened(part, f"{index}[{i}]").items()}
    if isinstance(value, dict) and value:
        return {name: entry for key, part in value.items() for name, entry in flattened(part, f"{index}.{key}").items()}
    if isinstance(value, bool):
        return {index: str(value).lower()}
    try:
        return {index: found if math.isfinite(found := float(value)) else str(value)}
    except (TypeError, ValueError, OverflowError):
        return {index: str(value)}
