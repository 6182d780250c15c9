# SPDX-License-Identifier: GPL-3.0-or-later
"""The data of a page's charts and of figures, and what they must be: made anew from a run's files, by other code than postprocess/."""

import base64
import io
import json
import math
from contextlib import redirect_stdout
from pathlib import Path

import as_package  # noqa: F401
import numpy as np
from harness import stored
from recomputed import Run, near, same
from signorini.post import animation
from signorini.post import figures as all_figures
from signorini.post import report_compare
from signorini.post import report_motion
from signorini.post import report_run
from signorini.post import report_study
from signorini.post import style
from signorini.post import work_precision
from signorini.post.report_parts import Page, Table
from signorini.post.run_folder import RunFolder
from signorini.post.study_folder import StudyFolder

SINGLE = 1e-6  # pages have numbers of single precision
PREFIXES = ["n", "µ", "m", "", "k", "M", "G", "T"]


def prefix(values: object, unit: str) -> tuple[float, str]:
    """Factor and unit that bring the largest value between 1 and 1000."""
    largest = np.nanmax(np.abs(values), initial=0)
    if not largest or unit.startswith("kg"):
        return 1.0, unit
    power = np.max([math.floor(math.log10(largest * (1 + 1e-9)) / 3), -3])
    return 1000.0**-power, PREFIXES[power + 3] + unit


def quantity(value: float, unit: str) -> str:
    factor, unit = prefix(value, unit)
    return f"{value * factor:.4g} {unit}"


def vector(values: list[float], unit: str) -> str:
    factor, unit = prefix(values, unit)
    largest = np.max(np.abs(values))
    return "(" + ", ".join(f"{value * factor if abs(value) >= 1e-9 * largest else 0:.4g}" for value in values) + f") {unit}"


def numbers(packed: object) -> np.ndarray:
    if not isinstance(packed, dict):
        return np.array(packed)
    found = np.frombuffer(base64.b64decode(packed["bdata"]), "<" + packed["dtype"])
    return found.reshape([int(n) for n in packed["shape"].split(",")]) if "shape" in packed else found


def mean(force: np.ndarray) -> np.ndarray:
    return (force[2:] + force[1:-1]) / 2


def per_depth(run: Run, unit: str) -> str:
    return unit + "/m" * (run.dim == 2)


def compare(where: str, found: dict, title: tuple[str, str], curves: dict[str, tuple[object, object]]) -> None:
    """A view of a chart: the titles of its axes and its curves by name."""
    layout = found["layout"]
    same(f"{where}: axes", tuple(layout[axis]["title"]["text"] for axis in ("xaxis", "yaxis")), title)
    same(f"{where}: curves", [trace["name"] for trace in found["data"]], list(curves))
    for trace in found["data"]:
        if trace["name"] in curves:
            for axis, expected in zip("xy", curves[trace["name"]]):
                near(f"{where}: {trace['name']}, {axis}", numbers(trace[axis]), expected, SINGLE)


def views_of(page: Page) -> dict[str, dict]:
    return {chart.name: chart.views for section in page.sections for chart in section.charts}


def tables_of(page: Page) -> dict[str, Table]:
    return {table.head[0]: table for section in page.sections for table in section.tables}


# --- The page of a run ------------------------------------------------------------------------------------------------


def page(run: Run) -> None:
    """All charts and tables, and no others."""
    made = report_run.page(RunFolder(run.path))
    views, steps = views_of(made), run.steps
    factor, unit = prefix(steps["time"], "s")
    times, title = steps["time"] * factor, f"time ({unit})"
    expected = {"timings"} | contact_charts(run, views, times, title) | energy_charts(run, views, times, title)
    expected |= probe_charts(run, views, times, title) | search_charts(run, views, times, title)
    same("charts of the page", set(views) - {"contact-surface"}, expected)
    if run.manifest["candidates"]:
        surface(run, views["contact-surface"])
    phases = sorted(run.manifest["timings"].items(), key=lambda phase: phase[1]["seconds"])
    bars = views["timings"][""]["data"][0]
    same("phases", (bars["y"], bars["x"]), ([name for name, _ in phases], [phase["seconds"] for _, phase in phases]))
    same("calls", bars["text"], [f"{quantity(phase['seconds'], 's')}, calls: {phase['calls']:,}" for _, phase in phases])
    reach = views["timings"][""]["layout"]["xaxis"]["range"]
    same("the bars and their texts have room", reach[0] == 0 and 1.3 * np.max(bars["x"]) < reach[1] < 3 * np.max(bars["x"]), True)
    tables(run, tables_of(made))
    facts(run, dict(made.facts))
    motion(run, next(section.motions for section in made.sections if section.motions)[0])


def contact_charts(run: Run, views: dict, times: np.ndarray, title: str) -> set[str]:
    steps, force, table = run.steps, run.steps["normal_force"], run.table("obstacles")
    middles = (times[1:] + times[:-1]) / 2
    names = [one["name"] for one in run.manifest["impact"]["obstacles"]]
    own = {name: {key: values[table["obstacle"] == name] for key, values in table.items()} for name in names}

    def one(force: np.ndarray) -> tuple[tuple[str, str], dict]:
        factor, unit = prefix(force, per_depth(run, "N"))
        return ((title, f"normal contact force ({unit})"),
                {"each step": (middles, factor * force[1:]), "mean of two steps": (times[1:-1], factor * mean(force))})

    expected = {"all obstacles": one(force)}
    active = {"in contact": (times, steps["active"])}
    if len(names) > 1:
        factor, unit = prefix(force * 0 + np.max([own[name]["normal_force"].max() for name in names]), per_depth(run, "N"))
        by_size = sorted(names, key=lambda name: -own[name]["normal_force"].max())
        curves = {name: (times[1:-1], factor * mean(own[name]["normal_force"])) for name in names if name in by_size[:6]}
        each = (title, f"normal contact force ({unit}),<br>mean of two steps"), curves
        expected = {"each obstacle": each} | expected | {name: one(own[name]["normal_force"]) for name in names}
        active |= {name: (times, own[name]["active"]) for name in names}
    if steps["weak"].any():
        active["in weak contact: no gap and no force"] = times, steps["weak"]
    same("views of the contact force", list(views["contact-force"]), list(expected))
    for name, (titles, curves) in expected.items():
        compare(f"contact force, {name}", views["contact-force"][name], titles, curves)
    compare("candidates in contact", views["active"][""], (title, "candidates"), active)
    same("steps are drawn as such", {trace["line"]["shape"] for trace in views["active"][""]["data"]}, {"vh"})
    return {"contact-force", "active"}


def energy_charts(run: Run, views: dict, times: np.ndarray, title: str) -> set[str]:
    steps = run.steps
    kinetic, elastic, dissipated = steps["kinetic_energy"], steps["elastic_energy"], np.cumsum(steps["viscous_dissipation"])
    work = np.cumsum(steps["load_work"])
    potential = np.max(work) - work
    other = np.cumsum(steps["external_work"]) - work
    total = kinetic + elastic + potential
    factor, unit = prefix(np.max([total.max(), dissipated[-1]]), per_depth(run, "J"))
    curves = {"kinetic": kinetic, "elastic": elastic}
    if work.any():
        curves["potential of the loads"] = potential
    curves["kinetic + elastic" + " + potential" * bool(work.any())] = total
    if np.max(np.abs(other)) > 1e-12 * total.max():
        curves["work of control and clamps so far"] = other
    if dissipated[-1] > 0:
        curves["dissipated so far"] = dissipated
    compare("energies", views["energies"][""], (title, f"energy ({unit})"), {name: (times, factor * curve) for name, curve in curves.items()})
    hidden = lambda values: np.where(values > 0, values, np.nan)  # noqa: E731
    laws = {"energy law": np.abs(steps["energy_residual"]) / (kinetic + elastic).max(), "momentum law": steps["momentum_residual"],
            "contact condition": steps["complementarity"]}  # fmt: skip
    dots = {name: (times, hidden(law)) for name, law in laws.items() if law.any()}
    dots["run.tolerance"] = [times[0], times[-1]], [run.scene["run"]["tolerance"]] * 2
    compare("residuals", views["residuals"][""], (title, "relative residual"), dots)
    logarithmic("residuals", views["residuals"][""], [dots[name][1] for name in dots])
    return {"energies", "residuals"}


def logarithmic(where: str, view: dict, curves: list) -> None:
    """Powers of ten where the curves span some, at most nine of them."""
    axis, shown = view["layout"]["yaxis"], np.concatenate([np.ravel(curve) for curve in curves])
    decades = np.log10(np.nanmax(shown) / np.nanmin(shown))
    same(f"{where}: axis", axis["type"], "log")
    if "dtick" in axis:
        same(f"{where}: powers of ten", decades > 1.3 and decades / axis["dtick"] <= 8 < decades / np.max([axis["dtick"] - 1, 1e-9]), True)
    else:
        same(f"{where}: no power of ten", decades <= 1.3, True)


def spectrum(where: str, view: dict, t: np.ndarray, parts: dict[str, np.ndarray], unit: str) -> None:
    """The sums of Fourier's integral at the frequencies of the record, for components that are more than rounding."""
    steps = np.diff(t)
    if np.ptp(steps) > 1e-6 * steps[0]:
        return  # interpolated
    n, tau = len(t), (t[-1] - t[0]) / len(steps)
    frequencies = np.arange(1, n // 2 + 1) / (n * tau)
    kernel = np.exp(-2j * np.pi * np.outer(np.arange(1, n // 2 + 1), np.arange(n)) / n)
    moduli = {axis: tau * abs(kernel @ values) for axis, values in parts.items()}
    most = np.max([np.max(modulus) for modulus in moduli.values()])
    compare(f"{where}: spectrum", view, ("frequency (Hz)", f"∣Fourier integral∣ ({unit} s)"),
            {axis: (frequencies, modulus) for axis, modulus in moduli.items() if np.max(modulus) > 1e-9 * most})
    same(f"{where}: axes", [view["layout"][axis]["type"] for axis in ("xaxis", "yaxis")], ["log", "log"])


def probe_charts(run: Run, views: dict, times: np.ndarray, title: str) -> set[str]:
    if not (run.path / "probes.csv").is_file():
        return set()
    units = {"displacement": "m", "velocity": "m/s", "center": "m", "rotation": "rad", "momentum": per_depth(run, "kg m/s"),
             "force": per_depth(run, "N"), "impulse": per_depth(run, "N s"), "reaction": per_depth(run, "N")}  # fmt: skip
    columns = run.table("probes")
    charts: dict[str, dict[str, dict]] = {}
    for column, values in columns.items():
        if "." in column:
            probe, name = column.split(".")
            parts = name.rsplit("_", 1)
            charts.setdefault(probe, {}).setdefault(parts[0], {})[parts[-1]] = values
    for number, (probe, shown) in enumerate(charts.items(), 1):
        spectra = [name for name in ("force",) if name in shown and len(times) > 2]
        same(f"views of {probe}", list(views[f"probe-{number}"]), [*shown, *(f"spectrum of the {name}" for name in spectra)])
        for name in spectra:
            spectrum(f"{probe}, {name}", views[f"probe-{number}"][f"spectrum of the {name}"], run.table("probes")["time"], shown[name], units[name])
        for name, parts in shown.items():
            factor, unit = prefix(list(parts.values()), units[name])
            compare(f"{probe}, {name}", views[f"probe-{number}"][name], (title, f"{name} ({unit})"),
                    {axis: (times, factor * values) for axis, values in parts.items()})  # fmt: skip
    return {f"probe-{number}" for number in range(1, len(charts) + 1)}


def search_charts(run: Run, views: dict, times: np.ndarray, title: str) -> set[str]:
    if "optimizer" not in run.manifest:
        return set()
    history, steps = run.table("history"), run.steps
    iteration, hidden = history["iteration"], lambda values: np.where(values > 0, values, np.nan)
    unit = "m⁴ s" if run.dim == 2 else "m⁵ s"
    names = {"objective": "J", "tracking": "tracking", "terminal": "end state", "control_cost": "cost of the control"}
    parts = {name: hidden(history[column]) for column, name in names.items() if history[column].any()}
    compare("objective", views["objective"][""], ("iteration", f"objective ({unit})"), {name: (iteration, part) for name, part in parts.items()})
    logarithmic("objective", views["objective"][""], list(parts.values()))
    norm = history["gradient_norm"]
    compare("gradient", views["gradient-norm"][""], ("iteration", "gradient norm"),
            {"gradient norm": (iteration, norm), "tolerance": ([0, iteration[-1]], [run.scene["optimizer"]["tolerance"] * norm[0]] * 2)})
    compare("distance", views["distance"][""], ("iteration", "‖u − u<sub>ref</sub>‖ / ‖u<sub>ref</sub>‖"),
            {"distance": (iteration, hidden(history["relative_distance_to_reference"]))})
    compare("tracking error", views["tracking-error"][""], (title, f"‖y − y<sub>d</sub>‖ ({'m²' if run.dim == 2 else 'm<sup>5/2</sup>'})"),
            {"distance": (times, steps["tracking_error"])})
    force = resultant(run)
    factor, unit = prefix(force, per_depth(run, "N"))
    charts = {"objective", "gradient-norm", "distance", "tracking-error", "control-resultant"}
    if "on" in run.scene["control"]:
        along_the_boundary(run, views["control-boundary"])
        charts.add("control-boundary")
    compare("control", views["control-resultant"][""], (title, f"force ({unit})"),
            {axis: (times[1:], factor * force[:, c]) for c, axis in enumerate("xyz"[: run.dim])})  # fmt: skip
    return charts


def resultant(run: Run) -> np.ndarray:
    """Of a control at nodes, of the body or of its top, stored at all steps."""
    u = stored(run.path, "control", "control")[2][..., : run.dim]
    if "on" in run.scene["control"]:
        return run.scene["control"]["scale"] * np.einsum("kic,i->kc", u, run.body.areas(top(run)))
    ones = np.tile(np.eye(run.dim), (len(run.body.points), 1))
    return run.scene["control"]["scale"] * u.reshape(len(u), -1) @ run.body.W @ ones


def top(run: Run) -> np.ndarray:
    return run.body.points[:, 1] > 1 - 1e-9


def along_the_boundary(run: Run, views: dict) -> None:
    """A control of the top, a row for each node from one end to the other."""
    on = np.flatnonzero(top(run))
    on = on[np.argsort(run.body.points[on, 0])]
    u = run.scene["control"]["scale"] * stored(run.path, "control", "control")[2][:, on, :2]
    parts = {"modulus": np.linalg.norm(u, axis=2), "x component": u[..., 0], "y component": u[..., 1]}
    same("maps of the control", list(views), [name for name, part in parts.items() if part.any()])
    times = run.steps["time"]
    middles = (times[1:] + times[:-1]) / 2
    most = np.linalg.norm(u, axis=2).sum(axis=0).argmax()
    for name, view in views.items():
        trace, factor_and_unit = view["data"][0], prefix(parts[name], "N/m²")
        near(f"control, {name}: times", numbers(trace["x"]), prefix(middles, "s")[0] * middles, SINGLE)
        near(f"control, {name}", numbers(trace["z"]), factor_and_unit[0] * parts[name].T, SINGLE)
        same(f"control, {name}: unit", trace["colorbar"]["title"]["text"], f"control ({factor_and_unit[1]})")
        edges = numbers(trace["y"])
        near(f"control, {name}: places", (edges[1:] + edges[:-1]) / 2, run.body.points[on, 0] - run.body.points[on[most], 0], 1e-5)
        far, signed = factor_and_unit[0] * np.max(np.abs(parts[name])), bool((parts[name] < 0).any())
        near(f"control, {name}: colours", [trace["zmin"], trace["zmax"]], [-far if signed else 0, far], 1e-9)


def arrows(run: Run, field: dict, frames: np.ndarray, nodes: np.ndarray) -> None:
    """Of a control of the top: the edges that carry it, and its vectors at their nodes, the longest 0.15 of the body's size."""
    on = np.flatnonzero(top(run)[nodes])
    u = stored(run.path, "control", "control")[2][..., :2]
    u = np.concatenate([u[:1], u])[frames][:, nodes]
    at = numbers(field["at"])
    same("arrows at nodes of the top", sorted(at), list(on))
    drawn = numbers(field["arrows"]["values"]) * field["arrows"]["scale"]
    near("arrows", drawn, np.moveaxis(u[:, at], 2, 1) * 0.15 / np.linalg.norm(u, axis=2).max(), 1e-4)
    edges = numbers(field["edges"])
    same("edges of the top", (len(edges), bool(np.isin(edges, on).all())), (len(on) - 1, True))


def candidates(run: Run, obstacle: str | None = None) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Places of nodes in contact.csv, each once, and their values at all times: the least gap and the sum of the rest."""
    rows, count = run.table("contact"), run.manifest["candidates"]
    each = {name: values.reshape(-1, count) for name, values in rows.items()}
    own = np.ones(count, bool) if obstacle is None else each["obstacle"][0] == obstacle
    points = np.stack([each[axis][0, own] for axis in "xyz"[: run.dim]], axis=1)
    places, node = np.unique(points, axis=0, return_inverse=True)
    found = {name: np.stack([each[name][:, own][:, node.ravel() == n].sum(axis=1) for n in range(len(places))], axis=1) for name in ("force", "pressure")}
    found["gap"] = np.stack([each["gap"][:, own][:, node.ravel() == n].min(axis=1) for n in range(len(places))], axis=1)
    return places, found


def surface(run: Run, views: dict) -> None:
    """The maps: in the plane a row for each node, next to its neighbours; in space rings about the node that is pushed the most."""
    names = [one["name"] for one in run.manifest["impact"]["obstacles"] if one["contact_time"]]
    kinds = ["pressure, mean of two steps", "pressure of each step", "force, mean of two steps", "force of each step", "gap"]
    lists = {"": None} if run.dim == 2 else {f"{name}: ": name for name in names}
    same("maps", list(views), [one + kind for one in lists for kind in kinds])
    times, units = run.steps["time"], {"pressure": "Pa", "force": per_depth(run, "N"), "gap": "m"}
    for start, obstacle in lists.items():
        points, values = candidates(run, obstacle)
        most = values["force"].sum(axis=0).argmax()
        for kind in kinds:
            what = kind.split(",")[0].split(" ")[0]
            shown = values[what].T
            at = {"gap": times, "mean": times[1:-1], "each": (times[1:] + times[:-1]) / 2}["gap" if what == "gap" else "mean" if "mean" in kind else "each"]
            shown = shown if what == "gap" else (shown[:, 2:] + shown[:, 1:-1]) / 2 if "mean" in kind else shown[:, 1:]
            view, where = views[start + kind], f"map of {start}{kind}"
            trace, edges = view["data"][0], numbers(view["data"][0]["y"])
            second, unit_of_time = prefix(at, "s")
            near(f"{where}: times", numbers(trace["x"]), second * at, SINGLE)
            same(f"{where}: time", view["layout"]["xaxis"]["title"]["text"], f"time ({unit_of_time})")
            if run.dim == 2:
                apart = np.linalg.norm(np.diff(points[np.argsort(np.arctan2(*(points - points.mean(axis=0)).T))], axis=0), axis=1)
                gaps = prefix(values["gap"], "m")[0] * values["gap"].T
                drawn = numbers(views[start + "gap"]["data"][0]["z"])
                row = [int(np.argmin(np.max(np.abs(drawn - gap), axis=1))) for gap in gaps]
                same(f"{where}: a row for each node", sorted(row), list(range(len(points))))
                order = np.argsort(row)
                near(f"{where}: neighbours", np.linalg.norm(np.diff(points[order], axis=0), axis=1), np.full(len(points) - 1, apart.mean()), 1e-6)
                near(f"{where}: edges", np.diff(edges), np.full(len(points), apart.mean()), SINGLE)
                near(f"{where}: 0 is where it is pushed the most", edges[row[most]] + edges[row[most] + 1], 0, 2e-6, 1)
                expected = shown[order]
            else:
                far = np.linalg.norm(points - points[most], axis=1)
                rings = np.max([1, round(math.sqrt(len(points)))])
                near(f"{where}: rings", edges, far.max() * np.arange(rings + 1) / rings, SINGLE)
                ring = np.minimum((far / far.max() * rings * (1 + 1e-12)).astype(int), rings - 1)
                worst = np.min if what == "gap" else np.max
                expected = np.array([worst(shown[ring == n], axis=0) if (ring == n).any() else shown[0] * np.nan for n in range(rings)])
            factor, unit = prefix(expected, units[what])
            near(where, numbers(trace["z"]), factor * expected, SINGLE)
            same(f"{where}: colours", trace["colorbar"]["title"]["text"], f"{what} ({unit})")
            near(f"{where}: least colour", trace["zmin"], np.min([0, np.nanmin(factor * expected)]), 1e-9, np.nanmax(np.abs(factor * expected)))
            same(f"{where}: small gaps are bright", trace["reversescale"], what == "gap")
            touched = np.asarray(row if run.dim == 2 else ring)[values["force"].any(axis=0)]
            pushed = touched.min(), touched.max()
            low, high = view["layout"]["yaxis"]["range"]
            same(f"{where}: what touches is in sight", edges[0] - 1e-6 <= low <= edges[pushed[0]] + 1e-6 and edges[pushed[1] + 1] - 1e-6 <= high <= edges[-1] + 1e-6, True)


def tables(run: Run, found: dict[str, Table]) -> None:
    """Where the energy went, contact and bounces, as run.json has them."""
    given, unit = run.manifest["energy"], per_depth(run, "J")
    terms = {"Kinetic and elastic at the start": given["kinetic_at_start"] + given["elastic_at_start"], "Work of the loads": given["load_work"],
             "Work of the control and of clamps": given["control_and_clamp_work"], "Work of contact": given["contact_work"],
             "Dissipated by viscosity": -given["viscous_dissipation"], "Kinetic and elastic at the end": given["kinetic_at_end"] + given["elastic_at_end"]}  # fmt: skip
    near("the account is closed", sum(list(terms.values())[:-1]), list(terms.values())[-1], 1e-9)
    factor, unit = prefix(list(terms.values()), unit)
    same("account of the energy", (found["Energy"].head, found["Energy"].rows),
         (["Energy", unit], [[name, f"{value * factor:.4g}"] for name, value in terms.items()
                             if abs(value) > 1e-12 * np.max(np.abs(list(terms.values()))) or name.startswith("Kinetic")]))  # fmt: skip
    worst = run.manifest["invariants"]
    same("worst residuals", found["Law, residual / scale"].rows, [[name, f"{one['worst']:.2g}", f"{one['step']:,}"] for name, one in worst.items()])
    impact, N, Ns = run.manifest["impact"], per_depth(run, "N"), per_depth(run, "N s")
    rows = []
    for one in [*impact["obstacles"], *([impact["all"] | {"name": "all"}] if len(impact["obstacles"]) > 1 else [])]:
        peak = "" if not one["contact_time"] else f"{quantity(one['normal_peak'], N)} at {quantity(one['peak_time'], 's')}" + " ∗" * one["peak_at_onset"]
        rows.append([one["name"], "never", *["–"] * 7] if not one["contact_time"] else
                    [one["name"], quantity(one["start"], "s"), quantity(one["end"], "s"), quantity(one["contact_time"], "s"),
                     quantity(one["impulse_duration"], "s"), quantity(one["normal_impulse"], Ns), vector(one["impulse"], Ns),
                     quantity(one["sustained_peak"], N), peak])  # fmt: skip
    same("contact", found["Obstacle"].rows, rows)
    same("over how long a peak is sustained", f"over {quantity(impact['all']['sustained_over'], 's')}," in found["Obstacle"].title, True)
    same("peaks at the onset", "as contact begins" in found["Obstacle"].title, any(one["peak_at_onset"] for one in [*impact["obstacles"], impact["all"]]))
    body = {"Mass": quantity(1000 * impact["mass"], per_depth(run, "g")), "Velocity of the centre of mass before": vector(impact["velocity_before"], "m/s"),
            "and after" if impact["ended"] else "and at the end, still in contact": vector(impact["velocity_after"], "m/s")}  # fmt: skip
    if impact["restitution"] is not None:
        body["Restitution"] = f"{impact['restitution']:.4g}"
    if stress := run.manifest.get("largest_von_mises"):
        body["Largest von Mises stress of the stored times"] = f"{quantity(stress['value'], 'Pa')} at {vector(stress['point'], 'm')}, {quantity(stress['time'], 's')}{', as contact begins' if stress['at_onset'] else ''}"
    same("the body as a whole", {row[0]: row[1] for row in found["Quantity"].rows}, body)
    if len(impact["bounces"]) > 1:
        same("bounces", found["Contact from"].rows,
             [[quantity(one["start"], "s"), quantity(one["end"], "s"), f"{one['touches']}", vector(one["impulse"], Ns), quantity(one["peak"], N),
               vector(one["velocity_before"], "m/s"), vector(one["velocity_after"], "m/s"),
               "–" if one["restitution"] is None else f"{one['restitution']:.4g}"] for one in impact["bounces"]])  # fmt: skip


def facts(run: Run, found: dict[str, str]) -> None:
    told, scene = run.manifest, run.scene
    expected = {"Ended by": told["stop_reason"], "Effects": ", ".join(name for name, on in told["effects"].items() if on),
                "Size": f"{told['unknowns']:,} unknowns, {told['free_unknowns']:,} of them free; {told['cells']:,} cells of degree "
                        f"{scene['mesh']['degree']}; {told['candidates']:,} contact candidates",
                "Time": f"{told['steps']['done']:,} steps of {quantity(scene['time']['step'], 's')}, to {quantity(run.steps['time'][-1], 's')}",
                "Scheme": scene["time"]["scheme"] + ", consistent mass", "Solver": told["solver"].split(" (")[0], "Ranks": f"{told['host']['ranks']}",
                "Peak memory": quantity(told["peak_memory_bytes"], "B"),
                "Versions": ", ".join(f"{name} {version}" for name, version in told["versions"].items())}  # fmt: skip
    if "optimizer" in told:
        done, J = told["optimizer"], told["objective"]
        expected["Iterations"] = f"{done['iterations']}, with {done['forward_sweeps']} forward and {done['adjoint_sweeps']} adjoint sweeps"
        unit = "m⁴ s" if run.dim == 2 else "m⁵ s"
        expected["Objective"] = f"{J['value']:.6g} {unit} = tracking {J['tracking']:.4g} + terminal {J['terminal']:.4g} + control cost {J['control_cost']:.4g}"
    if told["warnings"]:
        expected["Warning"] = told["warnings"][-1]["message"]
    same("facts", found, expected)


def enlargement(run: Run) -> float:
    """So many times that displacements below 2 % of the body's size become up to 5 %: 1, 2, 5, 10, …"""
    part = np.linalg.norm(run.y, axis=2).max() / np.ptp(run.body.points, axis=0).max()
    return 1.0 if part >= 0.02 else np.max([m * 10.0**e for m in (1, 2, 5) for e in range(9) if m * 10.0**e * part <= 0.05])


def box(run: Run, frames: np.ndarray, nodes: np.ndarray, enlarged: float) -> np.ndarray:
    """Two corners about the body at all times and a margin, and about balls of its size while they are near."""
    places, size = run.body.points[nodes] + enlarged * run.y[frames][:, nodes], np.ptp(run.body.points, axis=0).max()
    corners = np.array([places.min(axis=(0, 1)) - 0.1 * size, places.max(axis=(0, 1)) + 0.1 * size])
    contacts = run.scene.get("contact", [])
    for one in contacts if isinstance(contacts, list) else [contacts]:
        if one["obstacle"]["shape"] == "ball" and enlarged == 1:
            centre, radius = np.array(one["obstacle"]["center"], dtype=float), float(one["obstacle"]["radius"])
            if 2 * radius <= 2.5 * size and (np.linalg.norm(places - centre, axis=2) - radius).min() < 0.25 * size:
                corners = np.array([np.minimum(corners[0], centre - radius - 0.06 * size), np.maximum(corners[1], centre + radius + 0.06 * size)])
    return corners


def motion(run: Run, found: dict) -> None:
    """The body in motion: positions, fields, who touches, at the frames that are shown."""
    factor, unit = prefix(run.steps["time"], "s")
    times = np.array(found["times"]) / factor
    frames = np.array([np.abs(run.steps["time"] - time).argmin() for time in times])
    near("frames", times, run.steps["time"][frames], 1e-9)
    peak = int(np.argmax(run.steps["normal_force"]))
    stride = -(-(len(run.y) - 1) // 99)
    same("the step from frame to frame", list(frames), sorted({*range(0, len(run.y), stride), peak, len(run.y) - 1}))
    same("it opens at the peak", frames[found["start"]], peak)
    same("dimension and unit", (found["dim"], found["unit"]), (run.dim, unit))
    points = numbers(found["points"]).T
    nodes = np.array([np.abs(run.body.points - point).max(axis=1).argmin() for point in points])
    near("nodes", points, run.body.points[nodes], SINGLE)
    enlarged = enlargement(run)
    scale = "are true to scale" if enlarged == 1 else f"are drawn {enlarged:g} times as large"
    same("scale and count", found["note"].startswith(f"Displacements {scale}; " + ("all stored times" if len(frames) == len(run.y) else f"{len(frames)} of {len(run.y):,} stored times")), True)
    near("box", found["box"], box(run, frames, nodes, enlarged), SINGLE)

    def frames_of(packed: dict) -> np.ndarray:
        return numbers(packed["values"]) * packed["scale"]

    whole = enlarged * np.moveaxis(run.y[frames][:, nodes], 2, 1)
    near("displacements", frames_of(found["displacement"]), whole, 1e-4)
    fields = {"displacement": np.linalg.norm(run.y, axis=2), "velocity": np.linalg.norm(run.v, axis=2)}
    units = {"displacement": "m", "velocity": "m/s", "von Mises stress": "Pa", "contact pressure": "Pa"} | dict.fromkeys(
        (f"stress {one}" for one in ("xx", "yy", "zz", "xy", "yz", "xz")), "Pa") | dict.fromkeys(
        (f"strain {one}" for one in ("xx", "yy", "zz", "xy", "yz", "xz")), "")  # fmt: skip
    kept = [one["name"] for one in found["fields"]]
    if "von_mises" in run.scene["output"]["fields"]:
        share = np.zeros((len(run.body.points), len(run.body.cells)))
        for cell, own in enumerate(run.body.cells):
            share[own, cell] = 1
        share /= share.sum(axis=1, keepdims=True)
        fields["von Mises stress"] = stored(run.path, "state", "von_mises")[2][..., 0] @ share.T
        fields["contact pressure"] = stored(run.path, "state", "pressure")[2][..., 0]
        for name in ("stress", "strain"):
            tensor = stored(run.path, "state", name)[2].reshape(len(run.y), -1, 3, 3)
            for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)):
                if tensor[-1, :, i, j].any():
                    fields[f"{name} {'xyz'[i]}{'xyz'[j]}"] = tensor[..., i, j] @ share.T
    for name in ("control", "adjoint"):
        if (run.path / f"{name}.h5").is_file():
            u = stored(run.path, name, name)[2][..., : run.dim]
            fields[name] = np.linalg.norm(np.concatenate([u[:1], u]), axis=2)
            units[name] = "× control.scale" if name == "control" else ""
    same("fields", kept, list(fields))
    for one in found["fields"]:
        values = fields[one["name"]][frames][:, nodes]
        factor, unit = prefix(values, units[one["name"]]) if units[one["name"]] and "×" not in units[one["name"]] else (1.0, units[one["name"]])
        near(f"colours of {one['name']}", frames_of(one), factor * values, 1e-4)
        near(f"ends of {one['name']}", [one["least"], one["largest"]], [np.min([0, factor * values.min()]), np.max([0, factor * values.max()])], 1e-9)
        same(f"label of {one['name']}", one["label"], f"{one['name']} ({unit})" if unit else one["name"])
        same(f"{one['name']} belongs to a part of the boundary", "arrows" in one, one["name"] == "control" and "on" in run.scene["control"])
        if "arrows" in one:
            arrows(run, one, frames, nodes)
    rows, count = run.table("contact"), run.manifest["candidates"]
    each = {name: rows[name].reshape(-1, count) for name in ("force", "gap", *"xyz"[: run.dim])}
    touching = (each["force"] > 0) | (each["gap"] <= 1e-10)
    at = points[numbers(found["touching"]["nodes"])]
    near("candidates", at, np.stack([each[axis][0] for axis in "xyz"[: run.dim]], axis=1), SINGLE)
    same("who touches", (numbers(found["touching"]["on"]) == touching[frames]).all(), True)
    faces = numbers(found["faces"]).T
    if run.dim == 2:
        same("triangles", {frozenset(nodes[face]) for face in faces}, {frozenset(cell) for cell in run.body.cells})


# --- Two runs side by side --------------------------------------------------------------------------------------------


def comparison(first: Run, second: Run) -> None:
    """Numbers of both and their differences, and both curves."""
    made = report_compare.page((RunFolder(first.path), RunFolder(second.path)))
    runs, labels = (first, second), [first.path.name, second.path.name]

    def measures(run: Run) -> dict[str, tuple[float | None, str]]:
        steps, time, force = run.steps, run.steps["time"], run.steps["normal_force"]
        touching = np.flatnonzero(steps["active"][1:])
        N, J = per_depth(run, "N"), per_depth(run, "J")
        told, unit = run.manifest, "m⁴ s" if run.dim == 2 else "m⁵ s"
        peak = int(mean(force).argmax())
        return {"Objective": (told["objective"]["value"] if "objective" in told else None, unit),
                "Iterations": (told["optimizer"]["iterations"] if "optimizer" in told else None, ""),
                "First contact, the start of its step": (time[touching[0]], "s"), "In contact for": (np.diff(time)[touching].sum(), "s"),
                "Impulse of the contact forces": (force[1:] @ np.diff(time), per_depth(run, "N s")),
                "Largest contact force, mean of two steps": (mean(force).max(), N), "Time of that": (time[peak + 1], "s"),
                "Largest pressure of a step": (run.table("contact")["pressure"].max(), "Pa"),
                "Restitution": (told["impact"]["restitution"], ""), "Largest kinetic energy": (steps["kinetic_energy"].max(), J),
                "Largest elastic energy": (steps["elastic_energy"].max(), J), "Kinetic energy at the end": (steps["kinetic_energy"][-1], J),
                "Elastic energy at the end": (steps["elastic_energy"][-1], J), "Dissipated by viscosity": (steps["viscous_dissipation"].sum(), J),
                "Work of contact": (steps["contact_work"].sum(), J), "Unknowns": (told["unknowns"], ""), "Steps": (told["steps"]["done"], ""),
                "Peak memory": (told["peak_memory_bytes"], "B")}  # fmt: skip

    def shown(value: float, unit: str) -> str:
        return quantity(value, unit) if unit and "⁴" not in unit and "⁵" not in unit else f"{value:.6g} {unit}".strip()

    rows = []
    for (name, (a, unit)), (b, _) in zip(measures(first).items(), measures(second).values()):
        if a is None and b is None:
            continue
        off = ["–", "–"] if a is None or b is None else ["0", "0"] if abs(b - a) <= 1e-9 * np.max([abs(a), abs(b)]) else [
            shown(b - a, unit), f"{100 * (b - a) / abs(a):+.3g} %" if a else "–"]  # fmt: skip
        rows.append([name, *("–" if value is None else shown(value, unit) for value in (a, b)), *off])
    same("results", tables_of(made)["Quantity"].rows, rows)

    def flat(value: object, key: str = "") -> dict[str, object]:
        if isinstance(value, dict) or (isinstance(value, list) and value and isinstance(value[0], dict)):
            items = value.items() if isinstance(value, dict) else enumerate(value)
            return {name: one for part, inner in items for name, one in flat(inner, f"{key}.{part}" if key else str(part)).items()}
        return {key: value}

    scenes = [flat(run.scene) for run in runs]
    expected = {key for key in scenes[0] | scenes[1] if scenes[0].get(key, "–") != scenes[1].get(key, "–")}
    same("keys that differ", {row[0] for row in tables_of(made)["Key"].rows}, expected)
    second_, unit_of_time = prefix(np.max([run.steps["time"][-1] for run in runs]), "s")
    time, views = f"time ({unit_of_time})", views_of(made)

    def curves(where: str, view: dict, what: str, unit: str, curve: object) -> None:
        both = [curve(run) for run in runs]
        factor, unit = prefix(np.concatenate([values for _, values in both]), unit) if unit else (1.0, "")
        compare(where, view, (time, f"{what} ({unit})" if unit else what),
                {label: (second_ * times, factor * values) for label, (times, values) in zip(labels, both)})  # fmt: skip

    N, J = per_depth(first, "N"), per_depth(first, "J")
    work = lambda run: np.cumsum(run.steps["load_work"])  # noqa: E731
    potential = lambda run: work(run).max() - work(run)  # noqa: E731
    curves("contact of both", views["contact-force"][""], "contact force", N, lambda run: (run.steps["time"][1:-1], mean(run.steps["normal_force"])))
    curves("candidates of both", views["active"][""], "candidates", "", lambda run: (run.steps["time"], run.steps["active"]))
    if "optimizer" in first.manifest:
        histories, unit = [run.table("history") for run in runs], "m⁴ s" if first.dim == 2 else "m⁵ s"
        for column, name in (("objective", f"objective ({unit})"), ("gradient_norm", "gradient norm")):
            shown_curves = {label: (history["iteration"], history[column]) for label, history in zip(labels, histories)}
            compare(f"{column} of both", views[column.replace("_", "-")][""], ("iteration", name), shown_curves)
            logarithmic(f"{column} of both", views[column.replace("_", "-")][""], [history[column] for history in histories])
        for c, axis in enumerate("xyz"[: first.dim]):
            curves(f"control {axis} of both", views["control-resultant"][axis], "force", N, lambda run, c=c: (run.steps["time"][1:], resultant(run)[:, c]))
    energies = {"kinetic + elastic + potential of the loads": lambda run: run.steps["kinetic_energy"] + run.steps["elastic_energy"] + potential(run),
                "kinetic": lambda run: run.steps["kinetic_energy"], "elastic": lambda run: run.steps["elastic_energy"],
                "potential of the loads": potential, "dissipated so far": lambda run: np.cumsum(run.steps["viscous_dissipation"])}  # fmt: skip
    same("energies of both", list(views["energies"]), list(energies))
    for name, energy in energies.items():
        curves(f"{name} of both", views["energies"][name], "energy", J, lambda run, energy=energy: (run.steps["time"], energy(run)))
    bodies = next(section.motions for section in made.sections if section.motions)
    near("both bodies at the same times", bodies[0]["times"], bodies[1]["times"])
    ends = np.max([run.steps["time"][-1] for run in runs])
    near("to the end of the longer", np.max(bodies[0]["times"]), ends * prefix(ends, "s")[0], 1e-9)
    near("both in one box", bodies[0]["box"], bodies[1]["box"])
    alone = []
    for run, body in zip(runs, bodies):
        frames = np.array([np.abs(run.steps["time"] - time / prefix(ends, "s")[0]).argmin() for time in body["times"]])
        alone.append(box(run, frames, np.arange(len(run.body.points)), 1.0))
    near("which holds both", bodies[0]["box"], [np.min([one[0] for one in alone], axis=0), np.max([one[1] for one in alone], axis=0)], SINGLE)
    for one, two in zip(bodies[0]["fields"], bodies[1]["fields"]):
        same("both have the same colours", [one[key] for key in ("name", "label", "least", "largest")], [two[key] for key in ("name", "label", "least", "largest")])
    for run, body in zip(runs, bodies):
        frames = [np.abs(run.steps["time"] - time / prefix(ends, "s")[0]).argmin() for time in body["times"]]
        field = next(one for one in body["fields"] if one["name"] == "velocity")
        points = numbers(body["points"]).T
        nodes = np.array([np.abs(run.body.points - point).max(axis=1).argmin() for point in points])
        values = np.linalg.norm(run.v[frames][:, nodes], axis=2)
        top = np.max([np.linalg.norm(other.v, axis=2).max() for other in runs])
        same("in the unit of the larger", field["label"], f"velocity ({prefix(np.array([top]), 'm/s')[1]})")
        unit = {f"velocity ({PREFIXES[i]}m/s)": 1000.0 ** (3 - i) for i in range(len(PREFIXES))}[field["label"]]
        near("speeds of both", numbers(field["values"]) * field["scale"], unit * values, 1e-4, unit * top)


# --- Figures ----------------------------------------------------------------------------------------------------------


def figures(run: Run) -> None:
    """Every curve of the pictures, by its label, and the titles of the axes."""
    caught: dict[str, object] = {}
    save, style.save = style.save, lambda figure, path: caught.update({path.stem: figure}) or path
    try:
        folder = RunFolder(run.path)
        for name, draw in all_figures.figures(None).items():
            if name in ("objective", "distance_to_reference", "tracking_error", "contact_force_history", "contact_pressure", "energy", "control_history",
                        "contact_force", "control_magnitude"):  # fmt: skip
                with redirect_stdout(io.StringIO()):
                    try:
                        draw(folder)
                    except all_figures.NotInRun:
                        pass
    finally:
        style.save = save
    steps, force = run.steps, run.steps["normal_force"]
    factor, unit = prefix(steps["time"], "s")
    times, title = factor * steps["time"], f"time $t$ ({unit})"

    def curves(name: str, expected: dict, titles: tuple[str, str]) -> object:
        axes = caught[name].axes[0]
        same(f"{name}.png: axes", (axes.get_xlabel(), axes.get_ylabel()), titles)
        lines = {line.get_label() if not line.get_label().startswith("_") else "": line for line in axes.lines}
        same(f"{name}.png: curves", set(lines), set(expected))
        for label, (x, y) in expected.items():
            if label in lines:
                near(f"{name}.png: {label}, x", lines[label].get_xdata(), x, 1e-12)
                near(f"{name}.png: {label}, y", lines[label].get_ydata(), y, 1e-12)
        return axes

    def shaded(axes: object) -> None:
        """Bands from where contact begins to where it ends."""
        on = np.concatenate([[False], steps["active"][1:] > 0, [False]])
        begins, ends = times[np.flatnonzero(on[1:] & ~on[:-1])], times[np.flatnonzero(~on[1:] & on[:-1])]
        bands = [patch.get_extents().transformed(axes.transData.inverted()) for patch in axes.patches]
        near("bands of contact", [[band.x0, band.x1] for band in bands], np.stack([begins, ends], axis=1), 1e-9)

    work = np.cumsum(steps["load_work"])
    total = steps["kinetic_energy"] + steps["elastic_energy"] + work.max() - work
    dissipated = np.cumsum(steps["viscous_dissipation"])
    factor, unit = prefix(np.max([total.max(), dissipated[-1]]), per_depth(run, "J"))
    energy = {"kinetic": steps["kinetic_energy"], "elastic": steps["elastic_energy"]}
    energy |= {"potential": work.max() - work, "sum of these": total} if work.any() else {"kinetic + elastic": total}
    energy |= {"dissipated so far": dissipated} if dissipated[-1] > 0 else {}
    given = np.cumsum(steps["external_work"] - steps["load_work"])
    energy |= {"work of control and clamps so far": given} if np.abs(given).max() > 1e-12 * total.max() else {}
    axes = curves("energy", {name: (times, factor * one) for name, one in energy.items()}, (title, f"energy ({unit})"))
    shaded(axes)
    names = [one["name"] for one in run.manifest["impact"]["obstacles"]]
    factor, unit = prefix(force, per_depth(run, "N"))
    if len(names) > 1:
        table = run.table("obstacles")
        curves("contact_force_history", {name: (times[1:-1], factor * mean(table["normal_force"][table["obstacle"] == name])) for name in names},
               (title, f"normal contact force,\nmean of two steps ({unit})"))  # fmt: skip
    else:
        curves("contact_force_history", {"each step": ((times[1:] + times[:-1]) / 2, factor * force[1:]),
                                         "mean of two neighbouring steps": (times[1:-1], factor * mean(force))},
               (title, f"normal contact force ({unit})"))  # fmt: skip
    maps(run, caught, title)
    single_time(run, caught)
    if "optimizer" in run.manifest:
        search_figures(run, caught, curves, shaded, times, title)
    same("figures", set(caught), {"energy", "contact_force_history", "contact_pressure", "contact_force"} | (
        {"objective", "distance_to_reference", "tracking_error", "control_history", "control_magnitude"} if "optimizer" in run.manifest else set()))  # fmt: skip


def film(run: Run) -> None:
    """The frames of the film: where nodes and arrows are, and how large the forces are."""
    made, view = animation.read_motion(RunFolder(run.path)), np.eye(2)
    stride = -(-(len(run.y) - 1) // 75)
    shown = np.arange(0, len(run.y), stride)
    near("film: times", made.times, run.steps["time"][shown], 1e-9)
    near("film: displacements", made.magnitude, np.linalg.norm(run.y[shown], axis=2), 1e-12)
    enlarged = enlargement(run)
    near("film: scale", made.enlarged, enlarged)
    if run.dim == 3:
        view = made.view.axes
        near("film: seen from the side", view @ view.T, np.eye(2))
        same("film: upwards", list(view[1]), [0, 0, 1])
    near("film: places", made.position, (run.body.points + enlarged * run.y[shown]) @ view.T, 1e-12)
    rows, count = run.table("contact"), run.manifest["candidates"]
    each = {name: rows[name].reshape(-1, count) for name in rows if name != "obstacle"}
    points, normals = (np.stack([each[f"{start}{axis}"][0] for axis in "xyz"[: run.dim]], axis=1) for start in ("", "normal_"))
    nodes = np.array([np.abs(run.body.points - point).max(axis=1).argmin() for point in points])
    every = -(-count // len(made.forces.sizes[0]))
    window = np.max([2, stride])
    mean_force = [each["force"][np.max([1, k - window + 1]) : k + 1].mean(axis=0) if k else each["force"][0] for k in shown]
    near("film: forces", made.forces.sizes, np.array(mean_force)[:, ::every], 1e-12)
    near("film: arrows", made.forces.points, ((run.body.points + enlarged * run.y[shown])[:, nodes] @ view.T)[:, ::every], 1e-9)
    near("film: directions", made.forces.directions, (normals @ view.T)[::every], 1e-12)
    same("film: unit", made.forces.unit, per_depth(run, "N"))
    low, high = animation.view(made)
    same("film: all in the picture", bool((low <= made.position.min(axis=(0, 1))).all() and (high >= made.position.max(axis=(0, 1))).all()), True)


def enlargements() -> None:
    """Displacements below 2 % of the body's size are drawn 1, 2, 5, 10, … times as large, up to 5 %."""
    for largest, expected in ((0, 1), (0.03, 1), (0.02, 1), (0.019, 2), (0.011, 2), (0.0099, 5), (0.004, 10), (6e-4, 50), (1e-6, 50000)):
        same(f"enlarged, {largest}", animation.enlargement(2 * largest, 2.0), expected)
        if expected > 1:
            same("said of it", report_motion.scale_note(expected), f"Displacements are drawn {expected:g} times as large")
    for stored_times, numbers_of_one, peak in ((50, 100, 7), (101, 100, 3), (1000, 100, 333), (1000, 200_000, 333)):
        times = 0.1 * np.arange(stored_times)
        found = report_motion.frames(times, numbers_of_one, 0.1 * peak)
        stride = -(-(stored_times - 1) // (np.max([2, np.min([100, 2_000_000 // numbers_of_one])]) - 1))
        same(f"frames of {stored_times}", list(found), sorted({*range(0, stored_times, np.max([1, stride])), peak, stored_times - 1}))


def maps(run: Run, caught: dict, title: str) -> None:
    """The pressure over place and time is the page's."""
    axes = caught["contact_pressure"].axes[0]
    times, mesh = run.steps["time"], axes.collections[0]
    _, values = candidates(run)
    pressure = mean(values["pressure"])
    factor, unit = prefix(pressure, "Pa")
    edges = prefix(times, "s")[0] * (times[1:] + times[:-1]) / 2
    near("contact_pressure.png: times", mesh.get_coordinates()[0, :, 0], edges, 1e-9)
    same("contact_pressure.png: axes", (axes.get_xlabel(), caught["contact_pressure"].axes[1].get_ylabel()), (title, f"contact pressure ({unit})"))
    shown = np.ma.filled(mesh.get_array().astype(float), np.nan)
    if run.dim == 2:
        near("contact_pressure.png: pressures", np.sort(shown, axis=0), np.sort(factor * pressure.T, axis=0), 1e-12)
    near("contact_pressure.png: the largest", np.nanmax(shown, axis=0), factor * pressure.max(axis=1), 1e-12)
    near("contact_pressure.png: colours", [mesh.norm.vmin, mesh.norm.vmax], [0, np.nanmax(shown)], 1e-12)


def shown_step(run: Run) -> int:
    """That of 1.75 ms, of which the seed has its figures, where the body touches then; else that of the largest force."""
    seed = int(np.abs(run.steps["time"] - 1.75e-3).argmin())
    return seed if 1.75e-3 <= run.steps["time"][-1] and run.steps["normal_force"][seed] > 0 else int(run.steps["normal_force"].argmax())


def single_time(run: Run, caught: dict) -> None:
    """Forces of one step."""
    rows, count = run.table("contact"), run.manifest["candidates"]
    at = shown_step(run)
    figure = caught["contact_force"]
    axes = figure.axes[0]
    factor, unit = prefix(run.steps["time"][at], "s")
    same("contact_force.png: time", axes.get_title(loc="left"), f"$t$ = {run.steps['time'][at] * factor:.4g} {unit}")
    force = rows["force"].reshape(-1, count)[at]
    factor, unit = prefix(force, per_depth(run, "N"))
    if run.dim == 3:
        same("contact_force.png: colours", axes.child_axes[0].get_ylabel(), f"nodal contact force ({unit})")
        near("contact_force.png: forces", np.sort(axes.collections[0].get_array()), np.sort(factor * force[force > 0]), 1e-12)
        return
    same("contact_force.png: forces", axes.get_ylabel(), f"nodal contact force ({unit})")
    merged = candidates(run)[1]["force"][at]
    near("contact_force.png: from 0 to all", axes.get_ylim(), [0, 1.06 * factor * merged.max()], 1e-12)
    drawn = np.concatenate([line.get_ydata() for line in axes.lines])
    near("contact_force.png: forces of the nodes", np.sort(drawn), np.sort(factor * merged), 1e-12)
    if len(run.manifest["impact"]["obstacles"]) == 1:
        normal = np.array([rows["normal_x"][0], rows["normal_y"][0]])
        along = np.stack([rows["x"], rows["y"]], axis=1)[:count] @ [normal[1], -normal[0]]
        order = np.argsort(along)
        near("contact_force.png: places", axes.lines[0].get_xdata(), along[order], 1e-12)
        near("contact_force.png: each at its own", axes.lines[0].get_ydata(), factor * force[order], 1e-12)


def search_figures(run: Run, caught: dict, curves: object, shaded: object, times: np.ndarray, title: str) -> None:
    history, unit = run.table("history"), "m⁴ s" if run.dim == 2 else "m⁵ s"
    iteration, J, distance = history["iteration"], history["objective"], history["relative_distance_to_reference"]
    above, last = J > J[-1], f"J_{{{iteration[-1]:.0f}}}"
    axes = curves("objective", {"": (iteration[above], (J - J[-1])[above])}, ("iteration $i$", f"objective $J_i - {last}$ ({unit})"))
    same("objective.png: the last value", axes.texts[0].get_text(), f"${last}$ = {J[-1]:.4g} {unit}")
    best = int(distance.argmin())
    axes = caught["distance_to_reference"].axes[0]
    same("distance_to_reference.png: from 0 on", (axes.get_xlim(), axes.get_ylim()[0]), ((0, np.max([iteration[-1], 1])), 0))
    curves("distance_to_reference", {"": (iteration, distance), f"smallest: {distance[best]:.3f} at iteration {iteration[best]:.0f}": (iteration[[best]], distance[[best]])},
           ("iteration", r"$\|u - u_\mathrm{ref}\| \,/\, \|u_\mathrm{ref}\|$ (relative)"))  # fmt: skip
    shaded(curves("tracking_error", {"distance to the desired state": (times, run.steps["tracking_error"])},
                  (title, r"$\|y - y_d\|_{L^2}$ " + ("(m²)" if run.dim == 2 else "($m^{5/2}$)"))))  # fmt: skip
    force = resultant(run)
    factor, unit = prefix(force, per_depth(run, "N"))
    curves("control_history", {f"${axis}$": (times, factor * np.append(force[0, c], force[:, c])) for c, axis in enumerate("xyz"[: run.dim])},
           (title, f"resultant of the control ({unit})"))  # fmt: skip
    axes = caught["control_magnitude"].axes[0]
    at = shown_step(run)
    u = stored(run.path, "control", "control")[2][at - 1, :, : run.dim]
    factor, unit = prefix(run.steps["time"][at], "s")
    same("control_magnitude.png: time", axes.get_title(loc="left"), f"$t$ = {run.steps['time'][at] * factor:.4g} {unit}")
    colours = next(part for part in axes.collections if part.get_array() is not None)
    if "on" in run.scene["control"]:
        on = np.flatnonzero(top(run))
        on = on[np.argsort(run.body.points[on, 0])]
        size = np.linalg.norm(u, axis=1)
        lines = next(part for part in axes.collections if getattr(part, "get_linewidths", lambda: [0])()[0] == 5)
        near("control_magnitude.png: along the top", np.sort(lines.get_array()), np.sort((size[on][1:] + size[on][:-1]) / 2), 1e-12)
        near("control_magnitude.png: colours", lines.get_clim(), [0, size.max()], 1e-12)
        quiver = next(part for part in axes.collections if hasattr(part, "U"))
        near("control_magnitude.png: arrows", np.sort(np.hypot(quiver.U, quiver.V)), np.sort(size[on]), 1e-12)
        near("control_magnitude.png: the longest arrow", quiver.scale, size.max() / 0.15, 1e-12)
    elif run.dim == 2:
        near("control_magnitude.png: moduli", colours.get_array(), np.linalg.norm(u, axis=1), 1e-12)
        rows, count = run.table("contact"), run.manifest["candidates"]
        on = (rows["force"].reshape(-1, count)[at] > 0) | (rows["gap"].reshape(-1, count)[at] <= 1e-10)
        marks = [line for line in axes.lines if line.get_label() == "in contact"]
        same("control_magnitude.png: nodes in contact", len(marks[0].get_xdata()) if marks else 0, int(on.sum()))
        if marks:
            near("control_magnitude.png: their places", np.sort(marks[0].get_xdata()), np.sort(rows["x"][:count][on]), 1e-12)


# --- A study ----------------------------------------------------------------------------------------------------------


def study(folder: Path, rows: dict[str, np.ndarray], names: list[str]) -> None:
    """Its page and its pictures, from study.csv and study.json; methods are one."""
    given = json.loads((folder / "study.json").read_text())
    made = report_study.page(StudyFolder(folder))
    views = views_of(made)["work-precision"]
    titles = {name: given["quantities"][name]["title"] for name in names}
    text = lambda value, count=3: "" if math.isnan(value) else f"{value:.{count}g}"  # noqa: E731
    percent = lambda value: "" if math.isnan(value) else f"{100 * value:.3g} %"  # noqa: E731
    method = "degree 1, contact-implicit"
    same("views of a study", list(views), list(titles.values()))
    head, tables = [f"{size:g}" for size in rows["size"]], {table.title.split(":")[0].split(",")[0]: table for section in made.sections for table in section.tables}
    for name, title in titles.items():
        error, best, bar = rows[f"{name}_error"], np.flatnonzero(rows[f"{name}_pareto"] == 1), given["quantities"][name]["bar"]
        best, shown = best[np.argsort(rows["seconds"][best])], error > 0
        curves = {"Pareto front": (rows["seconds"][best], rows[f"{name}_envelope"][best])}
        if bar and bar["value"] > 0:
            curves["Error bar of the finest rung"] = [rows["seconds"][shown].min(), rows["seconds"][shown].max()], [bar["value"]] * 2
        curves[method] = rows["seconds"][shown], error[shown]
        compare(f"a study's {name}", views[title], ("time of the run (s)", "relative error"), curves)
        texts = views[title]["data"][-1]["text"]
        for n, one in zip(np.flatnonzero(shown), texts, strict=True):
            same("what is said of a rung", one, "<br>".join([
                f"<b>{method}</b>", f"size {rows['size'][n]:g} m, step {rows['step'][n]:g} s", f"{rows['unknowns'][n]:,.0f} unknowns, {rows['steps'][n]:,.0f} steps",
                f"error {percent(error[n])} in {quantity(rows['seconds'][n], 's')}", f"at this rung and all finer ones at most {percent(rows[f'{name}_envelope'][n])}",
                *([f"estimated {percent(rows[f'{name}_estimate'][n])}"] if np.isfinite(rows[f"{name}_estimate"][n]) else [])]))  # fmt: skip
        same("who is on the front", views[title]["data"][-1]["marker"]["line"]["width"], [1.5 if n in best else 0 for n in np.flatnonzero(shown)])
        table = next(table for key, table in tables.items() if key == title)
        same(f"values of {name}", table.rows,
             [[f"{n + 1}", head[n], f"{rows['step'][n]:g}", text(rows[name][n], 6), percent(error[n]),
               percent(rows[f"{name}_envelope"][n]) + " ★" * bool(rows[f"{name}_pareto"][n] == 1), percent(rows[f"{name}_estimate"][n]),
               text(rows[f"{name}_effectivity"][n])] for n in range(len(head))])  # fmt: skip
        unit = f", {given['quantities'][name]['unit']}" if given["quantities"][name]["unit"] else ""
        same(f"heading of {name}", table.title.startswith(f"{title}{unit}: errors against the {given['quantities'][name]['reference']}" + (f", {bar['words']}." if bar else ".")), True)
    same("what each rung took", next(table.rows for table in tables.values() if table.title.startswith("What each rung took")),
         [[f"{n + 1}", head[n], f"{rows['step'][n]:g}", method, f"{rows['unknowns'][n]:,.0f}", f"{rows['steps'][n]:,.0f}", text(rows["seconds"][n]),
           f"{rows['memory_bytes'][n] / 1e6:,.0f}"] for n in range(len(head))])  # fmt: skip
    same("facts of a study", [value for name, value in made.facts if name != "Versions"],
         [f"{len(head)}", given["reference"], quantity(rows["seconds"].sum(), "s")])  # fmt: skip
    same("sentences", made.sections[0].texts, given["sentences"])
    save, style.save = style.save, lambda figure, path: figure
    try:
        for name in names:
            axes = work_precision.draw(StudyFolder(folder), name).axes[0]
            shown = rows[f"{name}_error"] > 0
            near(f"{name}: seconds", axes.lines[0].get_xdata(), rows["seconds"][shown], 1e-12)
            near(f"{name}: errors", axes.lines[0].get_ydata(), rows[f"{name}_error"][shown], 1e-12)
            points = sorted(zip(rows["seconds"][shown], rows[f"{name}_error"][shown]))
            front = [point for i, point in enumerate(points) if all(point[1] < other[1] for other in points[:i])]
            near(f"{name}: front", np.stack(axes.lines[1].get_data(), axis=1), front, 1e-12)
            same(f"{name}: axes", (axes.get_xlabel(), axes.get_ylabel()), ("seconds", f"error of {titles[name]}"))
    finally:
        style.save = save
