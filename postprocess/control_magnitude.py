# SPDX-License-Identifier: GPL-3.0-or-later
"""Magnitude of the control over the undeformed body at one time, with the nodes in contact marked (seed, Fig. 5).

A control of a part of a plane body's boundary is drawn there, with arrows. In space, the surface is shown, seen from the side.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.tri import Triangulation

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .command_line import run_alone
from .mesh import Mesh, Series
from .report_fields import nodal, support_of
from .run_folder import RunFolder, nearest
from .view import View, view_of

MOST_ARROWS = 40
ARROW = 0.15  # length of the longest, as a part of the body's size


def draw(run: RunFolder, time: float | None = None) -> list[Path]:
    """Draws the stored time nearest to `time` (s)."""
    control = run.field("control", "control")
    time = run.figure_time() if time is None else time
    run.check_time(time)
    index = nearest(control.times, time)

    view = view_of(run)
    mesh, cells = view.seen(control.mesh)
    support = support_of(run, control) if run.dim == 2 else None
    axes = body_axes(mesh, view, room=0.04 if support is None else 0.04 + ARROW)
    colours = inside(axes, control, index, mesh, cells) if support is None else on_boundary(axes, control, index, support)
    style.colour_bar(colours, axes, f"control $|u|$ ({control_unit(run)})")
    style.show_time(axes, control.times[index])
    if run.has_contact and run.has_contact_table:
        mark_contact(axes, run, view, control.times[index])
    return [style.save(axes.figure, run.path / "figures" / "control_magnitude.png")]


def inside(axes: Axes, control: Series, index: int, mesh: Mesh, cells: np.ndarray) -> ScalarMappable:
    """Draws colours all over the visible triangles, each of one of the body's cells."""
    magnitude = np.linalg.norm(control.at(index), axis=1)
    triangles = Triangulation(*mesh.points.T, mesh.cells)
    look = {"cmap": style.FIELD_COLOURS, "vmin": 0, "rasterized": True}
    if control.cellwise:
        return axes.tripcolor(triangles, facecolors=magnitude[cells], **look)
    return axes.tripcolor(triangles, magnitude, shading="gouraud", **look)


def on_boundary(axes: Axes, control: Series, index: int, support: np.ndarray) -> ScalarMappable:
    """Draws colours along the edges at whose nodes the control acts, and arrows that end there."""
    mesh, values = control.mesh, nodal(control, control.at(index), support)
    magnitude = np.linalg.norm(values, axis=1)
    largest = magnitude.max() or 1.0
    grey = {"facecolors": np.full(len(mesh.cells), 0.06), "cmap": "Greys", "vmin": 0, "vmax": 1, "rasterized": True}
    axes.tripcolor(Triangulation(*mesh.points.T, mesh.cells), **grey)
    edges = mesh.outline()
    edges = edges[support[edges].all(axis=1)]
    lines = LineCollection(mesh.points[edges], array=magnitude[edges].mean(axis=1), cmap=style.FIELD_COLOURS, linewidths=5, zorder=3)
    lines.set_clim(0, largest)
    axes.add_collection(lines, autolim=False)
    at = np.flatnonzero(support)
    at = at[:: -(-len(at) // MOST_ARROWS)]
    axes.quiver(*mesh.points[at].T, *values[at].T, angles="xy", scale_units="xy", scale=largest / (ARROW * mesh.size), pivot="tip",
                color="0.25", width=0.005, zorder=4)  # fmt: skip
    return lines


def body_axes(mesh: Mesh, view: View, room: float = 0.04) -> Axes:
    """Makes axes that fit the undeformed body, with its outline; `room`: margin as a part of its size."""
    margin = room * mesh.size
    axes = style.plan(mesh.points.min(axis=0) - margin, mesh.points.max(axis=0) + margin, view.names)
    axes.add_collection(LineCollection(mesh.points[mesh.outline()], colors="black", linewidths=0.8))
    return axes


def control_unit(run: RunFolder) -> str:
    """Returns the body force or the traction of a control of 1, as a unit."""
    scale, unit = run.entry(lambda: (run.scene["control"]["scale"], run.manifest["control_unit"]))
    mantissa, exponent = f"{scale:e}".split("e")
    if int(exponent) == 0:
        return unit if float(mantissa) == 1 else f"{float(mantissa):g} {unit}"
    factor = "" if float(mantissa) == 1 else f"{float(mantissa):g}·"
    return f"{factor}$10^{{{int(exponent)}}}$ {unit}"


def mark_contact(axes: Axes, run: RunFolder, view: View, time: float) -> None:
    """Marks the nodes in contact at the stored time (s)."""
    contact = run.contact
    nodes = contact.points[contact.touches[nearest(contact.times, time)]]
    if len(nodes):
        axes.plot(*view.project(nodes).T, "o", color=style.VERMILION, markeredgecolor="white", markersize=6, markeredgewidth=0.8,
                  linestyle="none", clip_on=False, label="in contact")
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1), borderpad=0, handletextpad=0.1)


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__, timed=True))
