# SPDX-License-Identifier: GPL-3.0-or-later
"""Part of a run's page about probes: a chart over time for each probe of probes.csv."""

import numpy as np

from . import style
from .files import NotInRun
from .report_parts import Chart, figure, line, time_axis
from .run_folder import RunFolder

UNITS = {"displacement": "m", "velocity": "m/s", "center": "m", "rotation": "rad"}
PER_DEPTH = {"reaction": "N", "force": "N", "impulse": "N s", "momentum": "kg m/s"}  # or per metre of depth, RunFolder.whole
LOOKS = [(style.BLUE, "solid"), (style.VERMILION, "dash"), (style.GREEN, "dashdot")]


def charts(run: RunFolder) -> list[Chart]:
    """Makes one chart for each probe, with a view for each of its quantities; none for a run without probes."""
    try:
        table = run.probes
    except NotInRun:
        return []
    probes: dict[str, dict[str, list[str]]] = {}
    for column in table:
        if "." in column:
            probe, quantity = column.rsplit(".", 1)
            probes.setdefault(probe, {}).setdefault(stem(quantity), []).append(column)
    return [Chart(f"probe-{i}", probe, {name: view(run, name, columns) for name, columns in quantities.items()})
            for i, (probe, quantities) in enumerate(probes.items(), 1)]


def stem(quantity: str) -> str:
    """Returns a quantity without the axis of a component."""
    return quantity[:-2] if quantity[-2:] in ("_x", "_y", "_z") else quantity


def unit_of(run: RunFolder, quantity: str) -> str:
    """Returns the SI unit of a quantity, empty for one that is unknown here."""
    return UNITS.get(quantity) or (style.per_depth(PER_DEPTH[quantity], run.whole) if quantity in PER_DEPTH else "")


def view(run: RunFolder, name: str, columns: list[str]) -> dict:
    """Makes a view of the components of a quantity."""
    unit = unit_of(run, name)
    values = [run.probes[column] for column in columns]
    factor, unit = style.prefixed(np.concatenate(values), unit) if unit else (1.0, "")
    times, title = time_axis(run.probes["time"])
    curves = [line(column.rsplit("_", 1)[-1] if len(columns) > 1 else name, times, part * factor, *look)
              for column, part, look in zip(columns, values, LOOKS)]  # fmt: skip
    return figure(curves, title, f"{name} ({unit})" if unit else name)
