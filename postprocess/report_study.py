# SPDX-License-Identifier: GPL-3.0-or-later
"""Page of a study: the cost of accuracy by degree and scheme."""

import math

import numpy as np

from . import style
from .report_parts import GREY, Chart, Page, Section, Table, figure, packed, quantity, whole
from .run_folder import Unreadable
from .study_folder import Method, Rung, StudyFolder

COLOURS = [style.BLUE, style.VERMILION, style.GREEN, style.ORANGE, "#CC79A7", "#56B4E9"]
SYMBOLS = ["circle", "square", "diamond", "triangle-up", "x", "cross"]


def page(study: StudyFolder) -> Page:
    """Makes the page. Raises Unreadable if study.json or study.csv is not as a study writes it."""
    try:
        given = study.manifest
        facts = [("Rungs", whole(len(study.rungs))), ("Errors against", str(given["reference"])),
                 ("Seconds in all", quantity(np.nansum([rung["seconds"] for rung in study.rungs]), "s")),
                 ("Versions", ", ".join(f"{name} {version}" for name, version in given["versions"].items()))]
        sections = [Section("precision", "What accuracy costs", charts=[work_precision(study)], texts=list(given["sentences"])),
                    Section("orders", "Observed orders", tables=[orders(study)]),
                    Section("values", "Values and errors", tables=[values(study, name) for name in given["quantities"]]),
                    *([Section("searches", "What the optimizer's accuracy costs", tables=[searches(study)])] if study.searches else []),
                    Section("rungs", "All rungs", tables=[rungs(study)])]  # fmt: skip
        return Page(str(given["scene"]), "study", f"study of {given['scene']} with {len(study.rungs)} rungs", facts, sections, [])
    except KeyError as error:
        raise Unreadable(f"{study.path / 'study.json'}: there is no entry {error.args[0]}") from None
    except (TypeError, AttributeError) as error:
        raise Unreadable(f"{study.path / 'study.json'}: does not have the form that a study writes ({error})") from None


def work_precision(study: StudyFolder) -> Chart:
    """Makes the chart of error over seconds, a view for each quantity that has an error at all."""
    views = {heading(study, name): view(study, name) for name in study.manifest["quantities"]
             if any(rung[f"{name}_error"] > 0 for rung in study.rungs)}
    if not views:
        raise Unreadable(f"{study.path / 'study.csv'}: no rung has an error")
    return Chart("work-precision", "Error against time", views,
                 "Each mark is one rung. The dashed line joins the rungs that no faster rung equals, at the largest error of each rung and of "
                 "all finer rungs, so that errors which are small by coincidence do not count. The dotted line is the error bar of the "
                 "finest rung; errors below it have no meaning.")


def view(study: StudyFolder, name: str) -> dict:
    """Makes a view: one trace for each method, the Pareto front of rungs that no other beats in both, and the reference's error bar."""
    shown = [rung for rung in study.rungs if rung[f"{name}_error"] > 0]
    best = sorted((rung for rung in shown if rung[f"{name}_pareto"] == 1), key=lambda rung: rung["seconds"])
    data = [{"type": "scatter", "mode": "lines", "name": "Pareto front", **place(best, f"{name}_envelope"), "hoverinfo": "skip",
             "line": {"color": GREY, "dash": "dash", "shape": "hv", "width": 1.5}}]
    bar = study.manifest["quantities"][name]["bar"]
    if bar and bar["value"] > 0:
        ends = [extreme(rung["seconds"] for rung in shown) for extreme in (min, max)]
        data.append({"type": "scatter", "mode": "lines", "name": "Error bar of the finest rung", "x": packed(ends),
                     "y": packed([bar["value"]] * 2), "hoverinfo": "skip", "line": {"color": GREY, "dash": "dot", "width": 1.5}})  # fmt: skip
    for i, method in enumerate(study.methods):
        own = [rung for rung in shown if rung.method == method]
        front = [rung in best for rung in own]
        data.append({"type": "scatter", "mode": "markers", "name": str(method), **place(own, f"{name}_error"),
                     "text": [described(rung, name) for rung in own], "hovertemplate": "%{text}<extra></extra>",
                     "marker": {"color": COLOURS[i % len(COLOURS)], "symbol": SYMBOLS[i % len(SYMBOLS)], "size": 11,
                                "opacity": [1.0 if on else 0.55 for on in front],
                                "line": {"color": "black", "width": [1.5 if on else 0 for on in front]}}})  # fmt: skip
    scale = {"type": "log", "exponentformat": "power", "dtick": 1, "minor": {"ticks": "outside"}}
    return figure(data, "time of the run (s)", "relative error", xaxis=scale, yaxis=scale)


def place(rungs: list[Rung], column: str) -> dict:
    return {"x": packed([rung["seconds"] for rung in rungs]), "y": packed([rung[column] for rung in rungs])}


def described(rung: Rung, name: str) -> str:
    """Describes a rung, for the label of its mark."""
    lines = [f"<b>{rung.method}</b>", f"size {rung['size']:g} m, " + (f"steps of {rung['step']:.2g} s on average, {rung.step}" if rung.method.chosen else f"step {rung.step} s"),
             f"{whole(rung['unknowns'])} unknowns, {whole(rung['steps'])} steps",
             f"error {percent(rung[f'{name}_error'])} in {quantity(rung['seconds'], 's')}",
             f"at this rung and all finer ones at most {percent(rung[f'{name}_envelope'])}"]  # fmt: skip
    if not math.isnan(rung[f"{name}_estimate"]):
        lines.append(f"estimated {percent(rung[f'{name}_estimate'])}")
    return "<br>".join(lines)


def heading(study: StudyFolder, name: str) -> str:
    return str(study.manifest["quantities"][name]["title"])


def orders(study: StudyFolder) -> Table:
    rows = [[heading(study, order["quantity"]), str(Method(order["degree"], order["scheme"], order["mass"], order["steps"] == "chosen", order["mesh"] == "graded")),
             *(observed(order, part) for part in ("space", "time", "both"))] for order in study.manifest["orders"]]  # fmt: skip
    return Table("Orders with which errors fall with the element size, the time step, and both refined together, and "
                 "their range from rung to rung. Not in the asymptotic range: differences of successive rungs change sign, do not "
                 "fall, or fall faster than the method's errors can",
                 ["Quantity", "Method", "Space", "Time", "Both"], rows)


def observed(order: dict, part: str) -> str:
    if order.get(part) is None:
        return digits(None)
    least, largest = order["scatter"][part]
    if not order["asymptotic"][part]:
        return f"not in the asymptotic range ({least:.1f} to {largest:.1f})"
    return f"{order[part]:.2f} ({least:.2f} to {largest:.2f})"


def values(study: StudyFolder, name: str) -> Table:
    """Makes a table of values beside errors, of one quantity."""
    what = study.manifest["quantities"][name]
    unit = f", {what['unit']}" if what["unit"] and any(not math.isnan(rung[name]) for rung in study.rungs) else ""
    bar = f", {what['bar']['words']}" if what["bar"] else ""
    title = (f"{heading(study, name)}{unit}: errors against the {what['reference']}{bar}. At most: the largest error of this rung and all finer "
             "ones. ★: no faster rung has a smaller error")  # fmt: skip
    one = len(study.methods) == 1
    rows = [[rung.name, f"{rung['size']:g}", rung.step, *([] if one else [str(rung.method)]), digits(rung[name], 6),
             percent(rung[f"{name}_error"]), percent(rung[f"{name}_envelope"]) + (" ★" if rung[f"{name}_pareto"] == 1 else ""),
             percent(rung[f"{name}_estimate"]), digits(rung[f"{name}_effectivity"])] for rung in study.rungs]  # fmt: skip
    head = ["Rung", "Size (m)", "Step (s)", *([] if one else ["Method"]), "Value", "Error", "At most", "Estimate", "Effectivity"]
    return Table(title, head, rows)


def rungs(study: StudyFolder) -> Table:
    head = ["Rung", "Size (m)", "Step (s)", "Method", "Unknowns", "Steps", "Time (s)", "Memory (MB)"]
    rows = [[rung.name, f"{rung['size']:g}", rung.step, str(rung.method), whole(rung["unknowns"]), whole(rung["steps"]),
             digits(rung["seconds"]), whole(rung["memory_bytes"] / 1e6)] for rung in study.rungs]  # fmt: skip
    return Table("What each rung took", head, rows)


def searches(study: StudyFolder) -> Table:
    head = ["Tolerance", "Sweeps, forward + adjoint", "Time (s)", "J", "Above the least", "Ends"]
    rows = [[f"{search['tolerance']:g}", f"{whole(search['forward_sweeps'])} + {whole(search['adjoint_sweeps'])}", digits(search["seconds"]), digits(search["J"], 8),
             digits(search["J_above_least"], 2), search.stop_reason] for search in study.searches]  # fmt: skip
    return Table("Searches of the optimum on the scene's own mesh and steps, by optimizer.tolerance; relative excess of J over the least value found", head, rows)


def digits(value: float | None, count: int = 3) -> str:
    return "" if value is None or math.isnan(value) else f"{value:.{count}g}"


def percent(value: float) -> str:
    return "" if math.isnan(value) else f"{100 * value:.3g} %"
