# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a page: sections of charts and tables, and numbers as plotly.js reads them."""

import base64
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .files import NotInRun
from .style import prefixed

GREY = "#8c8c8c"


@dataclass(frozen=True)
class Chart:
    """Chart of plotly.js. A selector shows one of several views (data and layout by name) at a time."""

    name: str
    title: str
    views: dict[str, dict]
    note: str = ""

    @staticmethod
    def single(name: str, title: str, view: dict, note: str = "") -> "Chart":
        """Makes a chart with a single view and no selector."""
        return Chart(name, title, {"": view}, note)


@dataclass(frozen=True)
class Table:
    """Rows of texts and numbers below a head."""

    title: str
    head: list[str]
    rows: list[list[object]]


@dataclass(frozen=True)
class Shaded:
    """Cell of a table with a background by a value between -1 (vermilion) and 1 (blue)."""

    text: str
    value: float

    def __str__(self) -> str:
        return self.text

    @property
    def colour(self) -> str:
        return f"rgba({'0, 114, 178' if self.value > 0 else '213, 94, 0'}, {0.5 * min(abs(self.value), 1):.2f})"


@dataclass(frozen=True)
class Section:
    """Part of the page under a heading."""

    name: str
    title: str
    charts: list[Chart] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)
    motions: list[dict] = field(default_factory=list)
    names: list[str] = field(default_factory=list)  # names of the motions, where there are several
    file: tuple[str, str] | None = None  # name and content, folded
    panel: str = ""  # part of a batch that the page's script draws: scatter, parallel or cases
    always: bool = False  # shown even with texts alone


@dataclass(frozen=True)
class Page:
    """Content of a page. `identity`: the run, study or batch that it shows; `facts`: names and values; `left_out`: names of the parts
    without data; `batch`: data of a batch's panels."""

    title: str
    kind: str
    identity: str
    facts: list[tuple[str, str]]
    sections: list[Section]
    left_out: list[str]
    batch: dict | None = None

    def shown(self) -> list[Section]:
        """Returns the sections of the page that are not empty."""
        return [s for s in self.sections if s.charts or any(table.rows for table in s.tables) or s.motions or s.file or s.panel or s.always]

    def revolved(self) -> bool:
        """Whether the page shows a body of revolution."""
        return any("revolved" in motion for section in self.sections for motion in section.motions)

    def data(self) -> dict:
        """Returns the data of the page's script."""
        motions = next((section.motions for section in self.sections if section.motions), [])
        charts = {chart.name: chart.views for section in self.sections for chart in section.charts}
        return {"charts": charts, "motions": motions} | ({"batch": self.batch} if self.batch else {})


class Gathering:
    """Collects the parts for which a folder has data, and the reasons why others are missing."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.missing: dict[str, list[str]] = {}

    def __call__(self, name: str, make: Callable, *given: object) -> list:
        """Returns a list with the result of `make`, empty if the run has no data for it."""
        try:
            return [make(*given)]
        except NotInRun as reason:
            # Folders mean nothing to readers of the page.
            self.missing.setdefault(str(reason).replace(f" in {self.folder}", ""), []).append(name)
            return []

    def left_out(self) -> list[str]:
        return [f"{', '.join(names)} ({reason})" for reason, names in self.missing.items()]


def packed(values: np.ndarray, kind: str = "f4") -> dict:
    """Packs an array as plotly.js reads it, of little-endian numbers of a kind such as f4, i2, u2, u1."""
    values = np.asarray(values)
    array = {"dtype": kind, "bdata": base64.b64encode(values.astype(f"<{kind}").tobytes()).decode()}
    return array | ({"shape": ",".join(map(str, values.shape))} if values.ndim > 1 else {})


def line(name: str, x: np.ndarray, y: np.ndarray, colour: str, dash: str = "solid", width: float = 2.2) -> dict:
    """Makes a trace of a curve."""
    return {"type": "scatter", "mode": "lines", "name": name, "x": packed(x), "y": packed(y),
            "line": {"color": colour, "dash": dash, "width": width}}


def dots(name: str, x: np.ndarray, y: np.ndarray, colour: str, symbol: str = "circle", size: float = 5) -> dict:
    """Makes a trace of points without a line."""
    return {"type": "scatter", "mode": "markers", "name": name, "x": packed(x), "y": packed(y),
            "marker": {"color": colour, "symbol": symbol, "size": size}}


def figure(data: list[dict], x: str, y: str, **layout: dict) -> dict:
    """Makes a view of traces with titles of axes. `layout`: further properties of the axes, as in plotly.js."""
    titles = {"xaxis": x, "yaxis": y}
    return {"data": data, "layout": {axis: {"title": {"text": title}} | layout.get(axis, {}) for axis, title in titles.items()}}


def time_axis(times: np.ndarray) -> tuple[np.ndarray, str]:
    """Returns times (s) in a short unit, and the title of the axis."""
    factor, unit = prefixed(times, "s")
    return times * factor, f"time ({unit})"


def quantity(value: float, unit: str) -> str:
    """Writes a number with its unit; an SI prefix keeps the number short."""
    factor, unit = prefixed(value, unit)
    return f"{value * factor:.4g} {unit}"


def whole(number: float) -> str:
    """Writes a whole number with separated thousands; an empty text for NaN."""
    return "" if np.isnan(number) else f"{number:,.0f}"
