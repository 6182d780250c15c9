# SPDX-License-Identifier: GPL-3.0-or-later
"""Part of a run's page about probes: a chart over time for each probe of probes.csv."""

import numpy as np

from . import shock, style
from .files import NotInRun
from .report_parts import Chart, figure, line, time_axis
from .run_folder import RunFolder

UNITS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s²", "center": "m", "rotation": "rad", "rate": "rad/s"}
PER_DEPTH = {"reaction": "N", "force": "N", "impulse": "N s", "momentum": "kg m/s"}  # or per metre of depth, RunFolder.whole
ROUNDING = 1e-9  # of the largest component
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
    return [Chart(f"probe-{i}", probe, {name: view(run, name, columns) for name, columns in quantities.items()} | spectra(run, quantities))
            for i, (probe, quantities) in enumerate(probes.items(), 1)]


def spectra(run: RunFolder, quantities: dict[str, list[str]]) -> dict[str, dict]:
    """Makes views over frequency: Fourier's of a force and an acceleration, and shock response spectra of an acceleration."""
    views = {}
    for name in ("force", "acceleration"):
        if columns := quantities.get(name):
            times, values = run.probes["time"], np.stack([run.probes[column] for column in columns], axis=1)
            if len(times) > 2:
                views[f"spectrum of the {name}"] = over_frequency(*shock.spectrum(times, values), columns, f"∣Fourier integral∣ ({unit_of(run, name)} s)")
            if len(times) > 2 and name == "acceleration":
                views["shock response"] = over_frequency(*shock.shock_response(times, values), columns, f"largest acceleration, Q = {shock.Q:g} (m/s²)")
    return views


def over_frequency(frequencies: np.ndarray, values: np.ndarray, columns: list[str], title: str) -> dict:
    """Makes a view of a spectrum's components, on logarithmic axes; components that vanish up to rounding are left out."""
    curves = [line(column.rsplit("_", 1)[-1] if len(columns) > 1 else "modulus", frequencies, part, *look)
              for column, part, look in zip(columns, values.T, LOOKS) if part.max() > ROUNDING * values.max()]  # fmt: skip
    return figure(curves, "frequency (Hz)", title, xaxis={"type": "log"}, yaxis={"type": "log"})


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
