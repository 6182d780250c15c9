# SPDX-License-Identifier: GPL-3.0-or-later
"""Part of a run's page about contact: forces over time, of each obstacle, and over the surface."""

from dataclasses import dataclass

import numpy as np

from . import style
from .boundary import Arc, arc_of
from .contact_table import Contact
from .files import NotInRun
from .report_friction import SPLIT, force_views, friction_note, motion_map
from .report_parts import GREY, Chart, figure, line, packed, time_axis
from .run_folder import RunFolder

MOST_COLUMNS = 400  # times in a map of the contact surface
RINGS = 40  # distances in such a map of a body in space
MOST_CURVES = 6
COLOURS = [style.BLUE, style.VERMILION, style.GREEN, style.ORANGE, "#CC79A7", "#56B4E9"]
DASHES = ["solid", "dash", "dashdot", "dot", "longdash", "longdashdot"]
FROM_ZERO = {"rangemode": "tozero"}
SIGNED = "friction", "slip velocity"
ALTERNATE = "Forces of single contact-implicit steps alternate about the true force; the mean of two steps converges to it."
WITHIN = "Each force acts during its whole step and is drawn at the middle of the step."


def contact_force(run: RunFolder) -> Chart:
    """Makes the chart of the force of every step and of the mean of two, which converges; with several obstacles also of each."""
    run.require_contact()
    unit = style.per_depth("N", run.whole)
    try:
        force, what = run.normal_force, "normal contact force"
    except NotInRun:  # no one normal
        force, what = np.linalg.norm(run.resultant, axis=1), "modulus of the resultant"
    everything = force_over_time(run, force, what, unit)
    views = {"all obstacles": everything}
    if len(run.obstacle_names) > 1:
        try:
            own = {steps.name: steps.normal_force for steps in run.obstacle_steps}
        except NotInRun:
            own = {}
        if own:
            shown = sorted(own, key=lambda name: -own[name].max())[:MOST_CURVES]
            views = {"each obstacle": means(run, {name: own[name] for name in own if name in shown}, unit)} | views
            views |= {name: force_over_time(run, force, "normal contact force", unit) for name, force in own.items()}
    note = " ".join([ALTERNATE] * (run.scene["time"]["scheme"] == "contact-implicit") + [WITHIN]
                    + ["For several obstacles, the moduli of their forces are added."] * (len(views) > 1))  # fmt: skip
    if split := force_views(run):
        several = len(run.obstacle_names) > 1
        views = {f"{name}: {SPLIT}" if several else SPLIT: view for name, view in split.items()} | (
            views if several else {"normal force of each step": everything})  # fmt: skip
        note += f" {friction_note(run)}"
    return Chart("contact-force", "Contact force over time", views, note)


def force_over_time(run: RunFolder, force: np.ndarray, what: str, unit: str) -> dict:
    """Makes a view with the force of each step and the mean of two."""
    factor, unit = style.prefixed(force, unit)
    times, title = time_axis(run.steps["time"])
    # Row 0 is the initial state, in which no force has acted yet.
    force = force[1:] * factor
    curves = [line("each step", (times[1:] + times[:-1]) / 2, force, GREY, width=1)]
    if len(force) > 1:
        curves.append(line("mean of two steps", times[1:-1], (force[1:] + force[:-1]) / 2, style.VERMILION))
    return figure(curves, title, f"{what} ({unit})", xaxis={"range": [0, times[-1]]}, yaxis=FROM_ZERO)


def means(run: RunFolder, forces: dict[str, np.ndarray], unit: str) -> dict:
    """Makes a view with the mean of two steps for each obstacle."""
    factor, unit = style.prefixed(max(forces.values(), key=np.max), unit)
    times, title = time_axis(run.steps["time"])
    curves = [line(name, times[1:-1], (force[2:] + force[1:-1]) / 2 * factor, *look)
              for (name, force), look in zip(forces.items(), zip(COLOURS, DASHES))]  # fmt: skip
    what = f"normal contact force ({unit}),<br>mean of two steps"
    return figure(curves, title, what, xaxis={"range": [0, times[-1]]}, yaxis=FROM_ZERO)


def active_candidates(run: RunFolder) -> Chart:
    """Makes the chart of the number of candidates in contact after every step."""
    run.require_contact()
    steps = run.steps
    times, title = time_axis(steps["time"])
    curves = [line("in contact", times, steps["active"], "black" if len(run.obstacle_names) > 1 else style.BLUE)]
    if len(run.obstacle_names) > 1:
        try:
            curves += [line(own.name, times, own.active, *look) for own, look in zip(run.obstacle_steps, zip(COLOURS, DASHES))]
        except NotInRun:
            pass
    if steps["weak"].any():
        curves.append(line("in weak contact: no gap and no force", times, steps["weak"], style.ORANGE, "dot"))
    for curve in curves:
        curve["line"]["shape"] = "vh"  # row k is valid for the step that ends there
    ticks = {"dtick": 1} if steps["active"].max() < 10 else {}  # else the axis has halves
    view = figure(curves, title, "candidates", yaxis=FROM_ZERO | ticks)
    return Chart.single("active", "Candidates in contact", view)


def contact_surface(run: RunFolder) -> Chart:
    """Makes the chart of pressure, force and gap over place and time; bands without candidates are blank."""
    run.require_contact()
    names = run.obstacle_names
    if run.dim == 2:
        contact = run.contact.by_node()
        views = surface_views(run, contact, along_surface(run, contact))
        note = "Forces are nodal forces. Position 0 is the node with the largest force. Double-click to see all."
        if run.axisymmetric:
            note = "The force of a node is that on its ring. Position 0 is the node nearest to the axis. Double-click to see all."
    else:
        pushes = run.contact.force.any()
        apart = [run.contact.of(i) for i in range(len(names))]
        views = {f"{name}: {view}" if len(names) > 1 else view: shown for name, own in zip(names, apart) if own.force.any() or not pushes
                 for view, shown in surface_views(run, own, around_contact(own)).items()}  # fmt: skip
        note = ("Among nodes at about the same distance, the largest pressure or force, or the smallest gap, is shown. Double-click to "
                "see all.")  # fmt: skip
    return Chart("contact-surface", "Contact along the surface", views, note)


@dataclass(frozen=True)
class Place:
    """Rows of a map: their edges (m), the row of each candidate, and the name of the positions."""

    edges: np.ndarray
    rows: np.ndarray
    title: str


def along_surface(run: RunFolder, contact: Contact) -> Place:
    """Returns a row for each candidate of a plane body, each node once, and for each blank between two parts of the surface."""
    first = origin(run, contact)
    place = along(arc_of(run.boundary_mesh, contact.points, first))
    if run.axisymmetric and place.rows[first] == 0 and contact.points[first, 0] == 0:
        place.edges[0] = 0.0  # there is no surface beyond the axis
    return place


def origin(run: RunFolder, contact: Contact) -> int:
    """Returns the number of the candidate at position 0 along the surface: that with the largest force over time, of a body of
    revolution that nearest to the axis."""
    return int(np.argmin(contact.points[:, 0])) if run.axisymmetric else contact.most_pushed


def along(arc: Arc) -> Place:
    """Returns a row for each point of the boundary, and for each blank between two parts of it."""
    return Place(arc.edges(), arc.rows(), "position along the surface (m)")


def around_contact(contact: Contact) -> Place:
    """Returns a map's rows for a body in space: rings around the candidate with the largest force over time."""
    apart = np.linalg.norm(contact.points - contact.points[contact.most_pushed], axis=1)
    count = min(RINGS, max(1, round(np.sqrt(len(apart)))))
    edges = np.linspace(0, apart.max() or 1, count + 1)
    rows = np.clip(np.searchsorted(edges, apart, side="right") - 1, 0, count - 1)
    return Place(edges, rows, "distance from the node<br>pushed most (m)")


def surface_views(run: RunFolder, contact: Contact, place: Place) -> dict[str, dict]:
    """Makes the views, first the means of two steps, which mean more than single steps. Parts that never touch are out of sight at first."""
    times, views, axis = contact.times, {}, {"range": touched(contact, place)}
    values = {"pressure": (contact.pressure, "Pa"), "force": (contact.force, style.per_depth("N", run.whole))}
    if contact.friction is not None:
        values["friction"] = contact.tangential_force, style.per_depth("N", run.whole)
    for what, (of, unit) in values.items():
        if run.stores_every_step and len(times) > 2:
            views[f"{what}, mean of two steps"] = surface_map(times[1:-1], place, (of[2:] + of[1:-1]) / 2, unit, what, axis)
        # Forces act in the step that ends at a stored time.
        views[f"{what} of each step"] = surface_map(run.middles(times[1:]), place, of[1:], unit, what, axis)
    if contact.friction is not None:
        middles, slip = run.middles(times[1:]), contact.slip_velocity[1:]
        views["slip velocity"] = surface_map(middles, place, slip, "m/s", "slip velocity", axis)
        every = -(-len(middles) // MOST_COLUMNS)
        motion = rows_of(place, contact.friction.motion[1::every].astype(float), "motion")
        views["stick and slip"] = motion_map(middles[::every], place.edges, motion, place.title, axis)
    views["gap"] = surface_map(times, place, contact.gap, "m", "gap", axis)
    return views


def touched(contact: Contact, place: Place) -> list[float]:
    """Returns the positions (m) between which contact is, with some room; those of the whole surface if no force acts."""
    pushed = contact.force.any(axis=0)
    rows = place.rows[pushed] if pushed.any() else place.rows
    low, high = place.edges[rows.min()], place.edges[rows.max() + 1]
    room = max((high - low) / 2, 2 * np.median(np.diff(place.edges)))
    return [max(low - room, place.edges[0]), min(high + room, place.edges[-1])]


def rows_of(place: Place, values: np.ndarray, what: str) -> np.ndarray:
    """Arranges values (times × candidates) in the rows of a map (rows × times): the largest or, of gaps, the least of those that are
    numbers; NaN without any."""
    extreme, start = (np.fmin, np.inf) if what == "gap" else (np.fmax, -np.inf)
    shown = np.full((len(place.edges) - 1, len(values)), start)
    extreme.at(shown, place.rows, values.T)
    shown[~np.isfinite(shown)] = np.nan
    return shown


def surface_map(times: np.ndarray, place: Place, values: np.ndarray, unit: str, what: str, axis: dict) -> dict:
    """Makes a view of values (times × candidates) by colours over time and place: the largest value or the least gap there."""
    every = -(-len(times) // MOST_COLUMNS)
    shown = rows_of(place, values[::every], what)
    factor, unit = style.prefixed(np.nanmax(np.abs(shown), initial=0), unit)
    times, title = time_axis(times[::every])
    colours = {"colorscale": "Viridis", "reversescale": what == "gap", "zmin": min(0, float(np.nanmin(shown)) * factor)}
    if what in SIGNED and np.nanmin(shown, initial=0) < 0:
        far = float(np.nanmax(np.abs(shown))) * factor
        colours = {"colorscale": "RdBu", "zmin": -far, "zmax": far}
    return figure([heatmap(times, place.edges, shown * factor, what, unit) | colours], title, place.title, yaxis=axis)


def heatmap(times: np.ndarray, edges: np.ndarray, values: np.ndarray, what: str, unit: str) -> dict:
    """Makes a trace of values (rows × times, NaN where there is nothing) between the rows' edges (m)."""
    return {"type": "heatmap", "x": packed(times), "y": packed(edges), "z": packed(values), "hoverongaps": False,
            "hovertemplate": f"%{{x:.4g}}, %{{y:.3g}} m<br>{what} %{{z:.3g}} {unit}<extra></extra>",
            "colorbar": {"title": {"text": f"{what} ({unit})", "side": "right"}, "thickness": 14, "outlinewidth": 0}}  # fmt: skip
