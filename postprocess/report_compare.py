# SPDX-License-Identifier: GPL-3.0-or-later
"""Page of two runs side by side: differences of their scenes and results, both bodies in motion, both curves in each chart."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from . import report_fit, report_motion, report_probes, style
from .animation import enlargement
from .files import NotInRun, Unreadable
from .report_contact import FROM_ZERO
from .report_control import components, resultant_of
from .report_fields import stored_fields
from .report_parts import Chart, Gathering, Page, Section, Table, figure, line, quantity
from .report_run import logarithmic, objective_unit, positive
from .energy_terms import dissipated_so_far, potential_of_loads, stored_energy, works_of_friction
from .friction_force import component, friction_forces, has_friction
from .run_folder import RunFolder

ROUNDING = 1e-9  # a relative difference up to this is none
STEPWISE = "active", "control-resultant"  # a row is valid for the step that ends there
LOOKS = [(style.BLUE, "solid"), (style.VERMILION, "dash")]
Two = tuple[RunFolder, RunFolder]
Curve = tuple[np.ndarray, np.ndarray]


def page(runs: Two) -> Page:
    """Makes the page. Raises NotInRun without run.json, Unreadable if a file is damaged or one body is plane, or of revolution, and the
    other is not."""
    labels, gather = labels_of(*(run.path for run in runs)), Gathering(runs[1].path)
    if kind_of(runs[0]) != kind_of(runs[1]):
        raise Unreadable(f"{runs[1].path}: found a body {kind_of(runs[1])}; expected one as in {runs[0].path}")
    identity, title = "; ".join(f"{label}: {run.identity}" for label, run in zip(labels, runs)), " and ".join(labels)
    return runs[0].entry(lambda: Page(title, "two runs", identity, [], sections_of(runs, labels, gather), gather.left_out()))


def kind_of(run: RunFolder) -> str:
    return "of revolution" if run.axisymmetric else "in the plane" if run.dim == 2 else "in space"


def sections_of(runs: Two, labels: list[str], gather: Gathering) -> list[Section]:
    """Makes all parts below the facts."""
    both = gather("the bodies in motion", motions, runs)

    def curves(name: str, title: str, what: str, views: Views) -> list[Chart]:
        return gather(title[0].lower() + title[1:], over_time, runs, labels, name, title, what, views)

    friction = any(has_friction(run) for run in runs)
    force = [*curves("contact-force", "Contact force, mean of two steps", "contact force", SPLIT if friction else CONTACT),
             *curves("active", "Candidates in contact", "candidates", MOTIONS if friction else ACTIVE)]  # fmt: skip
    others = [*curves("energies", "Energies", "energy", ENERGIES), *curves("probes", "Probes", "", probes_of(runs))]
    search = [*curves("control-resultant", "Resultant of the control", "force", control_of(runs)),
              *gather("objective", over_iterations, runs, labels, "objective", "Objective"),
              *gather("gradient norm", over_iterations, runs, labels, "gradient_norm", "Gradient norm")]  # fmt: skip
    fits = any(run.is_fit for run in runs)
    search += gather("decrement", over_iterations, runs, labels, "decrement", "Decrement") if fits else []
    return [
        Section("scenes", "What differs in the scenes", tables=[scene_differences(runs, labels)]),
        Section("results", "Results", tables=[results(runs, labels), *([unknowns(runs, labels)] if fits else [])]),
        Section("motion", "The bodies in motion", motions=both[0] if both else [], names=labels),
        Section("contact", "Contact", force),
        Section("energy", "Energies and probes", others),
        Section("control", "Control and convergence", search),
    ]


def labels_of(*folders: Path) -> list[str]:
    """Returns the folders' names from the first part in which they differ."""
    parts = [folder.resolve().parts for folder in folders]
    same = next((i for i, pair in enumerate(zip(*parts)) if len(set(pair)) > 1), min(map(len, parts)) - 1)
    return ["/".join(one[same:]) for one in parts]


def scene_differences(runs: Two, labels: list[str]) -> Table:
    """Makes a table of keys that have different values in the two scenes."""
    first, second = (dict(entries(run.scene)) for run in runs)
    keys = [*first, *(key for key in second if key not in first)]
    rows = [[key, first.get(key, "–"), second.get(key, "–")] for key in keys if first.get(key) != second.get(key)]
    title = "Keys of scene.toml, every default written out" if rows else "The scenes are the same."
    return Table(title, ["Key", *labels], rows or [["none", "", ""]])


def entries(value: object, key: str = "") -> list[tuple[str, str]]:
    """Returns keys and values of a table and the tables within."""
    if isinstance(value, dict):
        return [entry for name, part in value.items() for entry in entries(part, f"{key}.{name}" if key else name)]
    if isinstance(value, list) and value and all(isinstance(part, dict) for part in value):
        return [entry for i, part in enumerate(value) for entry in entries(part, f"{key}.{i}")]
    return [(key, json.dumps(value, ensure_ascii=False))]


def results(runs: Two, labels: list[str]) -> Table:
    """Makes a table of numbers that both runs, or one of them, have."""
    rows = []
    for name, (measure, unit) in MEASURES.items():
        found = [measured(measure, run) for run in runs]
        if found != [None, None]:
            units = unit(runs[0])
            rows.append([name, *("–" if value is None else shown(value, units) for value in found), *difference(found, units)])
    return Table("Differences are the second run minus the first", ["Quantity", *labels, "Difference", "Relative"], rows)


def unknowns(runs: Two, labels: list[str]) -> Table:
    """Makes a table of the fitted unknowns; differences also in standard deviations, where both unknowns are identified."""
    found = [{one["name"]: one for one in run.manifest.get("unknowns_fitted", [])} for run in runs]
    rows = []
    for name in dict.fromkeys([*found[0], *found[1]]):
        ones = [fit.get(name) for fit in found]
        cells = ["–" if one is None else report_fit.with_deviation(one) for one in ones]
        rows.append([name, next(one["unit"] for one in ones if one), *cells, *in_deviations(ones)])
    return Table("Unknowns that were fitted, with their standard deviations", ["Unknown", "Unit", *labels, "Difference", "In its deviations"], rows)


def in_deviations(ones: list[dict | None]) -> list[str]:
    """Returns the second value minus the first, and this difference divided by its standard deviation for independent data."""
    if None in ones or None in (values := [one["value"] for one in ones]):
        return ["–", "–"]
    difference, deviations = values[1] - values[0], [one["standard_deviation"] for one in ones]
    scale = 0.0 if None in deviations else float(np.hypot(*deviations))
    return [f"{difference:.4g}", f"{difference / scale:+.2g}" if scale > 0 else "–"]


def measured(measure: Callable[[RunFolder], float], run: RunFolder) -> float | None:
    """Returns measure(run), a number; None if the run did not write the data."""
    try:
        value = measure(run)
    except (NotInRun, KeyError, TypeError):
        return None
    return None if value is None or not np.isfinite(value) else float(value)


def shown(value: float, unit: str) -> str:
    return quantity(value, unit) if unit and "⁴" not in unit and "⁵" not in unit else f"{value:.6g} {unit}".strip()


def difference(found: list[float | None], unit: str) -> list[str]:
    if None in found:
        return ["–", "–"]
    first, second = found
    if abs(second - first) <= ROUNDING * max(abs(first), abs(second)):
        return ["0", "0"]
    return [shown(second - first, unit), f"{100 * (second - first) / abs(first):+.3g} %" if first else "–"]


def mean_force(run: RunFolder) -> Curve:
    """Returns the mean contact force of each two neighbouring steps, over the times between these steps."""
    if not run.has_contact:
        raise NotInRun("the scene has no contact")
    force = run.normal_force
    return run.steps["time"][1:-1], (force[2:] + force[1:-1]) / 2


def mean_friction(run: RunFolder) -> Curve:
    """Returns the mean friction force of each two neighbouring steps: in the plane the sum along the obstacles' tangents, in space the
    modulus of the sum."""
    forces = friction_forces(run)
    if not forces:
        raise NotInRun("no obstacle has friction")
    total = sum(force.tangential for force in forces.values())
    return run.steps["time"][1:-1], component((total[2:] + total[1:-1]) / 2)


def touching(run: RunFolder) -> np.ndarray:
    """Returns the numbers of the steps that end in contact, from 0."""
    found = np.flatnonzero(run.steps["active"][1:] > 0)
    if not len(found):
        raise NotInRun("the body never touches the obstacle")
    return found


def pressure(run: RunFolder) -> np.ndarray:
    if not run.has_contact or (found := run.contact.pressure) is None:
        raise NotInRun("the run wrote no pressure")
    return found


def term(run: RunFolder, name: str) -> np.ndarray:
    """Returns a column that only runs with its effect have."""
    if name not in run.steps:
        raise NotInRun(f"the run has no {name}")
    return run.steps[name]


def step(run: RunFolder) -> np.ndarray:
    return np.diff(run.steps["time"])


def fixed(unit: str) -> Callable[[RunFolder], str]:
    return lambda run: unit


def depth(unit: str) -> Callable[[RunFolder], str]:
    return lambda run: style.per_depth(unit, run.whole)


MEASURES: dict[str, tuple[Callable[[RunFolder], float], Callable[[RunFolder], str]]] = {
    "Objective": (lambda run: run.manifest["objective"]["value"], objective_unit),
    "Misfit, standard deviations": (lambda run: run.manifest["fit"]["misfit"], fixed("")),
    "Objective of the fit": (lambda run: run.manifest["fit"]["objective"], fixed("")),
    "Iterations": (lambda run: run.manifest["optimizer"]["iterations"], fixed("")),
    "First contact, the start of its step": (lambda run: run.steps["time"][touching(run)[0]], fixed("s")),
    "In contact for": (lambda run: step(run)[touching(run)].sum(), fixed("s")),
    "Impulse of the contact forces": (lambda run: (run.normal_force[1:] * step(run)).sum(), depth("N s")),
    "Largest contact force, mean of two steps": (lambda run: mean_force(run)[1].max(), depth("N")),
    "Time of that": (lambda run: mean_force(run)[0][np.argmax(mean_force(run)[1])], fixed("s")),
    "Largest pressure of a step": (lambda run: pressure(run).max(), fixed("Pa")),
    "Restitution": (lambda run: run.manifest["impact"]["restitution"], fixed("")),
    "Largest kinetic energy": (lambda run: run.steps["kinetic_energy"].max(), depth("J")),
    "Largest elastic energy": (lambda run: run.steps["elastic_energy"].max(), depth("J")),
    "Kinetic energy at the end": (lambda run: run.steps["kinetic_energy"][-1], depth("J")),
    "Elastic energy at the end": (lambda run: run.steps["elastic_energy"][-1], depth("J")),
    "Dissipated by viscosity": (lambda run: run.steps["viscous_dissipation"].sum(), depth("J")),
    "Largest energy in foundations": (lambda run: term(run, "foundation_energy").max(), depth("J")),
    "Dissipated by dashpots of foundations": (lambda run: term(run, "foundation_dissipation").sum(), depth("J")),
    "Dissipated by mass damping": (lambda run: term(run, "drag_dissipation").sum(), depth("J")),
    "Largest energy in branches": (lambda run: term(run, "relaxation_energy").max(), depth("J")),
    "Dissipated by relaxation": (lambda run: term(run, "relaxation_dissipation").sum(), depth("J")),
    "Largest energy of obstacles with mass": (lambda run: term(run, "rigid_energy").max(), depth("J")),
    "Dissipated by dashpots of obstacles": (lambda run: term(run, "rigid_dissipation").sum(), depth("J")),
    "Work of contact": (lambda run: run.steps["contact_work"].sum(), depth("J")),
    "Work of friction": (lambda run: term(run, "friction_work").sum(), depth("J")),
    "Work of moving surfaces": (lambda run: term(run, "belt_work").sum(), depth("J")),
    "Modulus of the impulse of friction": (lambda run: np.linalg.norm(run.manifest["impact"]["all"]["friction_impulse"]), depth("N s")),
    "Most candidates that slip": (lambda run: term(run, "slip").max(), fixed("")),
    "Most candidates that stick": (lambda run: term(run, "stick").max(), fixed("")),
    "Unknowns": (lambda run: run.manifest["unknowns"], fixed("")),
    "Steps": (lambda run: run.manifest["steps"]["done"], fixed("")),
    "Peak memory": (lambda run: run.manifest["peak_memory_bytes"], fixed("B")),
}  # fmt: skip


def energy(name: str) -> Callable[[RunFolder], Curve]:
    return lambda run: (run.steps["time"], run.steps[name])


def sum_of_energies(run: RunFolder) -> Curve:
    potential = potential_of_loads(run.steps)
    return run.steps["time"], stored_energy(run.steps) + (0 if potential is None else potential)


def potential(run: RunFolder) -> Curve:
    if (values := potential_of_loads(run.steps)) is None:
        raise NotInRun("loads do no work")
    return run.steps["time"], values


def work_of(name: str) -> Callable[[RunFolder], Curve]:
    """Returns the function of a work of friction; it raises NotInRun without one."""
    def curve(run: RunFolder) -> Curve:
        if (work := works_of_friction(run.steps).get(name)) is None:
            raise NotInRun("the run has no such work")
        return run.steps["time"], work

    return curve


Views = dict[str, tuple[Callable[[RunFolder], Curve], Callable[[RunFolder], str]]]
CONTACT: Views = {"": (mean_force, depth("N"))}
SPLIT: Views = {"normal": (mean_force, depth("N")), "friction": (mean_friction, depth("N"))}
ACTIVE: Views = {"": (lambda run: (run.steps["time"], run.steps["active"]), fixed(""))}
MOTIONS: Views = {"in contact": ACTIVE[""]} | {
    name: (lambda run, name=name: (run.steps["time"], term(run, name)), fixed("")) for name in ("slip", "stick")}  # fmt: skip
ENERGIES: Views = {
    "kinetic + elastic + potential of the loads": (sum_of_energies, depth("J")),
    "kinetic": (energy("kinetic_energy"), depth("J")),
    "elastic": (energy("elastic_energy"), depth("J")),
    "potential of the loads": (potential, depth("J")),
    "dissipated so far": (lambda run: (run.steps["time"], dissipated_so_far(run.steps)), depth("J")),
    "lost to friction so far": (work_of("lost to friction so far"), depth("J")),
    "work of moving surfaces so far": (work_of("work of moving surfaces so far"), depth("J")),
}


def probes_of(runs: Two) -> Views:
    """Returns a view for each column that both runs' probes.csv have."""
    try:
        first, second = (run.probes for run in runs)
    except NotInRun:
        return {}
    return {column: (lambda run, column=column: (run.probes["time"], run.probes[column]), probe_unit(column))
            for column in first if column in second and column not in ("step", "time")}  # fmt: skip


def probe_unit(column: str) -> Callable[[RunFolder], str]:
    return lambda run: report_probes.unit_of(run, report_probes.stem(column.rsplit(".", 1)[-1]))


def control_of(runs: Two) -> Views:
    """Returns a view of the control's resultant for each component."""
    def component(run: RunFolder, axis: int) -> Curve:
        control = run.field("control", "control")
        return control.times, resultant_of(run, control)[:, axis]

    return {name: (lambda run, axis=axis: component(run, axis), depth("N")) for axis, name in components(runs[0]).items()}


def over_time(runs: Two, labels: list[str], name: str, title: str, what: str, views: Views) -> Chart:
    """Makes a chart with a curve for each run that has one. `what`: title of the values; by default each view's name."""
    drawn = {}
    for view, (curve, unit_of) in views.items():
        found = [(label, *values, *look) for label, run, look in zip(labels, runs, LOOKS) if (values := drawn_curve(curve, run))]
        if not found:
            continue
        second, unit_of_time = style.prefixed(max(times[-1] for _, times, *_ in found), "s")
        everything = np.concatenate([values for _, _, values, *_ in found])
        factor, unit = style.prefixed(everything, unit_of(runs[0])) if unit_of(runs[0]) else (1.0, "")
        curves = [line(label, times * second, values * factor, *look) for label, times, values, *look in found]
        for trace in curves:
            trace["line"]["shape"] = "vh" if name in STEPWISE else "linear"
        axis = f"{what or view} ({unit})" if unit else what or view
        drawn[view] = figure(curves, f"time ({unit_of_time})", axis, yaxis=FROM_ZERO if (everything >= 0).all() else {})
    if not drawn:
        raise NotInRun("neither run wrote it")
    return Chart(name, title, drawn)


def drawn_curve(curve: Callable[[RunFolder], Curve], run: RunFolder) -> Curve | None:
    try:
        return curve(run)
    except NotInRun:
        return None


def over_iterations(runs: Two, labels: list[str], column: str, title: str) -> Chart:
    """Makes a chart of a column of history.csv, with a curve for each run that has it."""
    curves, shown_values, units = [], [], []
    for label, run, look in zip(labels, runs, LOOKS):
        try:
            history = run.history
        except NotInRun:
            continue
        if column in history and (history[column] > 0).any():  # fits have other columns
            curves.append(line(label, history["iteration"], positive(history[column]), *look))
            shown_values.append(history[column])
            units.append("" if run.is_fit else f" ({objective_unit(run)})")
    if not curves:
        raise NotInRun(f"history.csv of neither run has values of {column}")
    if column == "objective" and len(set(units)) > 1:
        raise NotInRun("J of a fit counts standard deviations, that of a control does not")
    unit = units[0] if column == "objective" else ""
    view = figure(curves, "iteration", title.lower() + unit, yaxis=logarithmic(*shown_values))
    return Chart.single(column.replace("_", "-"), title, view)


def motions(runs: Two) -> list[dict]:
    """Returns the motions of both bodies at the same times, with the same colours, enlargement and box."""
    series = [run.field("state", "displacement") for run in runs]
    longest = max(series, key=lambda one: (one.times[-1], len(one.times)))
    numbers = sum(len(one.mesh.boundary_nodes() if run.dim == 3 else one.mesh.points) * (run.dim + len(stored_fields(run)))
                  for one, run in zip(series, runs))  # fmt: skip
    times = longest.times[report_motion.frames(longest.times, numbers, runs[0].peak_time or 0.0)]
    farthest = [max(np.linalg.norm(one.at(i), axis=1).max() for i in range(len(one.times))) for one in series]
    enlarged = min(enlargement(far, one.mesh.size) for far, one in zip(farthest, series))
    return alike([report_motion.motion(run, times, enlarged) for run in runs], times, series)


def alike(found: list[dict], times: np.ndarray, series: list) -> list[dict]:
    """Reduces two motions to the fields that both have, in the same units."""
    first, second = found
    names = [field["name"] for field in first["fields"] if field["name"] in {other["name"] for other in second["fields"]}]
    for one in found:
        one["fields"] = [next(field for field in one["fields"] if field["name"] == name) for name in names]
    for pair in zip(first["fields"], second["fields"]):
        least = min(pair, key=lambda field: field["factor"])
        label, factor = least["label"], least["factor"]
        for field in pair:
            ratio = factor / field["factor"]
            field.update(label=label, factor=factor, **{key: field[key] * ratio for key in ("scale", "least", "largest")})
        extremes = min(field["least"] for field in pair), max(field["largest"] for field in pair)
        for field in pair:
            field.update(least=extremes[0], largest=extremes[1])
    boxes = np.array([one["box"] for one in found])
    for one, own in zip(found, series):
        one.update(box=[boxes[:, 0].min(axis=0).tolist(), boxes[:, 1].max(axis=0).tolist()], eye=first["eye"], start=first["start"])
        if own.times[-1] < times[-1] * (1 - 1e-9):
            one["note"] += f" It ends at {quantity(own.times[-1], 's')} and stays as it is then."
    return found
