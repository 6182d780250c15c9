# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a run's page about a fit: fitted unknowns, the misfit, and unknowns that the data do not determine."""

import csv
import io
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from . import style
from .files import NotInRun, whole_text
from .report_parts import GREY, Chart, Gathering, Section, Table, dots, figure, line, packed, time_axis
from .run_folder import RunFolder

JOINT = 0.95  # modulus of the correlation of two unknowns above which each deviation is over three times that of a combination
ELLIPSES = {"39 %: one deviation along each axis": 1.0, "95 %": 5.991**0.5}  # of two unknowns; radii in standard deviations


@dataclass(frozen=True)
class Measured:
    """Measurement of measurements.csv, in SI."""

    time: np.ndarray
    value: np.ndarray
    deviation: np.ndarray
    simulated: np.ndarray


def measurements(run: RunFolder) -> dict[str, Measured]:
    """Reads the measurements by name. Raises NotInRun without measurements.csv."""
    file = run.path / "measurements.csv"
    if not file.is_file():
        raise NotInRun(f"there is no measurements.csv in {run.path}")
    rows: dict[str, list[list[float]]] = {}
    for row in csv.DictReader(io.StringIO(whole_text(file))):
        rows.setdefault(row["measurement"], []).append([float(row[name]) for name in ("time", "value", "deviation", "simulated")])
    return {name: Measured(*np.array(values).T) for name, values in rows.items()}


def sections(run: RunFolder, gather: Gathering) -> list[Section]:
    """Makes the parts of the page; none for a run that fitted nothing."""
    if not run.is_fit:
        return []
    fit = run.manifest["fit"]
    charts = [*gather("measured and simulated", compared, run), *gather("residuals", residuals, run),
              *gather("confidence", confidence, run), *gather("the fit's history", course, run)]  # fmt: skip
    return [Section("fit", "What was fitted", charts, [unknowns(run), *correlations(run), *times(run)], texts=list(fit["not_told"]))]


def facts(run: RunFolder) -> list[tuple[str, str]]:
    """Returns the misfit as a fact of the page."""
    if not run.is_fit:
        return []
    fit = run.manifest["fit"]
    determined = "" if fit["not_told"] else f" {determination(run)}"
    return [("Misfit", f"{fit['misfit']:.3g} standard deviations (root mean square of {fit['values']} values): about 1 if the model "
                       f"explains the data up to their noise.{determined}")]  # fmt: skip


def determination(run: RunFolder) -> str:
    """Returns a sentence on how well the data determine the unknowns, each of which has a finite deviation."""
    names = [one["name"] for one in run.manifest["unknowns_fitted"]]
    pairs = [(run.manifest["fit"]["correlations"][i][j], names[i], names[j]) for i, j in combinations(range(len(names)), 2)]
    r, first, second = max(pairs, key=lambda pair: abs(pair[0]), default=(0.0, "", ""))
    if abs(r) > JOINT:
        return f"The data determine {first} and {second} well only in combination (correlation {r:+.3f})."
    return "The data determine all unknowns."


def unit_of(run: RunFolder, name: str) -> str:
    """Returns the unit of a measurement's values, SI."""
    of = next(one["of"] for one in run.scene["measurement"] if one["name"] == name)
    return {"displacement": "m", "velocity": "m/s"}.get(of) or style.per_depth({"force": "N", "impulse": "N s"}[of], run.whole)


def shown(value: float | None, digits: int) -> str:
    return "undetermined" if value is None else f"{value:.{digits}g}"


def with_deviation(unknown: dict) -> str:
    """Returns the value of an unknown with its standard deviation."""
    if unknown["value"] is None or unknown["standard_deviation"] is None:
        return shown(unknown["value"], 6)
    return f"{unknown['value']:.6g} ± {unknown['standard_deviation']:.3g}"


def unknowns(run: RunFolder) -> Table:
    """Makes a table of the fitted unknowns, as in parameters.csv."""
    rows = []
    for one in run.manifest["unknowns_fitted"]:
        bounds = [f"{one[side]:.4g}" if one[side] is not None else "none" for side in ("lower", "upper")]
        rows.append([one["name"], shown(one["value"], 6), shown(one["standard_deviation"], 3), one["unit"], shown(one["start"], 4),
                     " … ".join(bounds) + (", at a bound" if one["at_bound"] else "")])  # fmt: skip
    return Table("Fitted values, with standard deviations that follow from the noise of the data",
                 ["Unknown", "Value", "Deviation", "Unit", "Start", "Bounds"], rows)  # fmt: skip


def correlations(run: RunFolder) -> list[Table]:
    names = [one["name"] for one in run.manifest["unknowns_fitted"]]
    if len(names) < 2:
        return []
    rows = [[name, *(f"{value:+.2f}" for value in row)] for name, row in zip(names, run.manifest["fit"]["correlations"])]
    values = ", ".join(f"{value:.3g}" for value in run.manifest["fit"]["singular_values"])
    return [Table(f"Correlations: near ±1, the data determine only a combination of the two unknowns. Singular values of the scaled derivatives: {values}",
                  ["", *names], rows)]  # fmt: skip


def times(run: RunFolder) -> list[Table]:
    compared = run.manifest["fit"]["contact_times"]
    rows = [[one["name"], one["unit"], f"{one['value']:.5g}", shown(one["simulated"], 5)] for one in compared]
    return [Table("Figures of contact, which were not fitted", ["Figure", "Unit", "Measured", "Simulated"], rows)] if rows else []


def band(x: np.ndarray, low: np.ndarray, high: np.ndarray, name: str) -> dict:
    """Makes a trace of the area between two curves."""
    return {"type": "scatter", "mode": "lines", "name": name, "x": packed(np.concatenate([x, x[::-1]])),
            "y": packed(np.concatenate([high, low[::-1]])), "fill": "toself", "fillcolor": "rgba(213, 94, 0, 0.18)",
            "line": {"width": 0}, "hoverinfo": "skip"}  # fmt: skip


def compared(run: RunFolder) -> Chart:
    """Makes the chart of data and simulation over time, a view for each measurement."""
    views = {}
    for name, one in measurements(run).items():
        time, title = time_axis(one.time)
        views[name] = figure([band(time, one.simulated - 2 * one.deviation, one.simulated + 2 * one.deviation, "±2 deviations"),
                              dots("measured", time, one.value, GREY, size=4),
                              line("simulated", time, one.simulated, style.VERMILION)], title, f"{name} ({unit_of(run, name)})")  # fmt: skip
    return Chart("measured", "Measured and simulated", views, "The band is the noise around the simulation: about 95 % of the data lie in it.")


def residuals(run: RunFolder) -> Chart:
    """Makes the chart of residuals in standard deviations, a view for each measurement."""
    views = {}
    for name, one in measurements(run).items():
        time, title = time_axis(one.time)
        views[name] = figure([dots("residual", time, (one.simulated - one.value) / one.deviation, style.BLUE, size=4)], title,
                             "residual (deviations)")  # fmt: skip
    return Chart("residuals-of-data", "Residuals", views, "Simulated minus measured values, in standard deviations; no pattern remains if the model explains the data.")


def confidence(run: RunFolder) -> Chart:
    """Makes the chart of confidence ellipses, a view for each pair of unknowns."""
    given, matrix = run.manifest["unknowns_fitted"], run.manifest["fit"]["correlations"]
    angle = np.linspace(0, 2 * np.pi, 181)
    views = {}
    for i, j in combinations(range(len(given)), 2):
        a, b = given[i], given[j]
        if a["standard_deviation"] is None or b["standard_deviation"] is None:
            continue
        correlation = matrix[i][j]
        curves = []
        for (name, radius), dash in zip(ELLIPSES.items(), ("solid", "dash")):
            # Points of the unit circle through the Cholesky factor of the correlations.
            x = radius * np.cos(angle)
            y = correlation * x + radius * np.sqrt(max(1 - correlation**2, 0)) * np.sin(angle)
            curves.append(line(name, a["value"] + a["standard_deviation"] * x, b["value"] + b["standard_deviation"] * y, style.BLUE, dash))
        curves.append(dots("fitted", np.array([a["value"]]), np.array([b["value"]]), style.VERMILION, size=9))
        views[f"{a['name']} and {b['name']}"] = figure(curves, axis_title(a), axis_title(b))
    if not views:
        raise NotInRun("the data do not determine two unknowns")
    return Chart("confidence", "Confidence", views, "Share of repeated measurements whose ellipse contains the true values, to first order.")


def axis_title(unknown: dict) -> str:
    return f"{unknown['name']} ({unknown['unit']})" if unknown["unit"] else unknown["name"]


def course(run: RunFolder) -> Chart:
    """Makes the chart of J and the unknowns over the iterations."""
    history = run.history
    iteration, objective = history["iteration"], history["objective"]
    logarithmic = {"type": "log", "exponentformat": "power"}
    views = {"J": figure([line("J", iteration, np.where(objective > 0, objective, np.nan), "black")], "iteration", "J", yaxis=logarithmic)}
    for column, title in (("decrement", "decrement (standard deviations)"), ("gradient_norm", "gradient norm")):
        if column in history:  # the latter with a control
            values = np.where(history[column] > 0, history[column], np.nan)
            views[column] = figure([line(column, iteration, values, style.BLUE)], "iteration", title, yaxis=logarithmic)
    for one in run.manifest["unknowns_fitted"]:
        views[one["name"]] = figure([line(one["name"], iteration, history[one["name"]], style.BLUE)], "iteration", axis_title(one))
    return Chart("course", "The course of the fit", views)
