# SPDX-License-Identifier: GPL-3.0-or-later
"""Part of a run's page about the control: its resultant over time, and its values along the boundary."""

import numpy as np

from . import style
from .boundary import arc_of
from .files import NotInRun
from .mesh import Series
from .report_contact import MOST_COLUMNS, Place, along, heatmap
from .report_fields import area, nodal, support_of
from .report_parts import Chart, dots, figure, line, time_axis
from .run_folder import RunFolder

LOOKS = [(style.BLUE, "solid"), (style.VERMILION, "dash"), (style.GREEN, "dashdot")]


def resultant(run: RunFolder) -> Chart:
    """Makes the chart of the components of the control's resultant."""
    control = run.field("control", "control")
    force = resultant_of(run, control)
    factor, unit = style.prefixed(force, style.per_depth("N", run.whole))
    times, title = time_axis(control.times)
    shown = [(name, times, force[:, axis] * factor, *look) for (axis, name), look in zip(components(run).items(), LOOKS)]
    if run.stores_every_step:
        curves = [line(*one) for one in shown]
        for curve in curves:
            curve["line"]["shape"] = "vh"  # a control is constant in the step that ends there
    else:  # of the steps between nothing is known
        curves = [dots(name, at, values, colour) for name, at, values, colour, _ in shown]
    return Chart.single("control-resultant", "Resultant of the control over time", figure(curves, title, f"force ({unit})"))


def resultant_of(run: RunFolder, control: Series) -> np.ndarray:
    """Returns the control's integral over the body or the boundary at its times (times × dim), N or N/m (RunFolder.whole); of a body
    of revolution the radial component is 0."""
    scale = run.entry(lambda: float(run.scene["control"]["scale"]))
    weight = weights(control, support_of(run, control), run.axisymmetric)
    force = scale * np.stack([weight @ control.at(i) for i in range(len(control.times))])
    return force * [0, 1] if run.axisymmetric else force


def components(run: RunFolder) -> dict[int, str]:
    """Returns the components that a resultant can have, by number, and their names: around an axis radial forces cancel."""
    return {1: "y"} if run.axisymmetric else dict(enumerate("xyz"[: run.dim]))


def weights(control: Series, support: np.ndarray | None, revolved: bool) -> np.ndarray:
    """Returns the weight of a value at each node or in each cell: the integral of its function over the body or, if the nodes of a
    part of the boundary are given, over that (m to m³). `revolved`: of a half section, x ≥ 0, over all around the axis."""
    mesh, count = control.mesh, len(control.mesh.cells if control.cellwise else control.mesh.points)
    if support is None:
        facets, owner = mesh.cells, np.arange(len(mesh.cells))
        size = np.abs(np.linalg.det(mesh.points[facets[:, 1:]] - mesh.points[facets[:, :1]])) / (2 if facets.shape[1] == 3 else 6)
    else:
        facets, owner = mesh.facets()
        on = support[facets].all(axis=1)
        facets, owner = facets[on], owner[on]
        size = area(mesh, facets)
    found = np.zeros(count)
    around = 2 * np.pi * mesh.points[facets, 0] if revolved else np.ones(facets.shape)  # circumferences, linear on a facet
    mean = around.mean(axis=1)
    if control.cellwise:
        np.add.at(found, owner, size * mean)
        return found
    corners = facets.shape[1]
    for corner, own in zip(facets.T, around.T):
        np.add.at(found, corner, size / corners * (corners * mean + own) / (corners + 1))
    return found


def boundary(run: RunFolder) -> list[Chart]:
    """Makes the chart of a control of a part of a plane body's boundary, over place and time; none for other controls."""
    try:
        control = run.field("control", "control")
    except NotInRun:
        return []
    support = support_of(run, control)
    if support is None or run.dim == 3 or not support.any():
        return []
    scale, every = run.entry(lambda: float(run.scene["control"]["scale"])), -(-len(control.times) // MOST_COLUMNS)
    values = scale * np.stack([nodal(control, control.at(i), support)[support] for i in range(0, len(control.times), every)])
    size = np.linalg.norm(values, axis=2)
    place = along(arc_of(control.mesh, control.mesh.points[support], int(np.argmax(size.sum(axis=0)))))
    parts = {"modulus": size} | {f"{axis} component": values[:, :, i] for i, axis in enumerate("xy") if values[:, :, i].any()}
    views = {name: over_boundary(run.middles(control.times[::every]), place, part) for name, part in parts.items()}
    return [Chart("control-boundary", "Control along the boundary", views, "Position 0 is the place of the largest control.")]


def over_boundary(times: np.ndarray, place: Place, values: np.ndarray) -> dict:
    """Makes a view of values (times × nodes, N/m²) by colours."""
    shown = np.full((len(place.edges) - 1, len(times)), np.nan)
    shown[place.rows] = values.T
    factor, unit = style.prefixed(values, "N/m²")
    far, signed = np.abs(values).max() * factor or 1.0, bool((values < 0).any())
    times, title = time_axis(times)
    colours = {"colorscale": "RdBu" if signed else "Viridis", "zmin": -far if signed else 0, "zmax": far}
    return figure([heatmap(times, place.edges, shown * factor, "control", unit) | colours], title, place.title)
