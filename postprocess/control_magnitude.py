"""Magnitude of the control over the undeformed body at one time, with the nodes in contact marked (seed, Fig. 5).

In space it is that on the surface, seen from the side.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.tri import Triangulation

import style
from command_line import run_alone
from run_folder import Mesh, RunFolder, nearest
from view import View, view_of


def draw(run: RunFolder, time: float | None = None) -> list[Path]:
    """Draws the stored time nearest to `time` (s)."""
    control = run.field("control.xdmf", "control")
    time = run.figure_time() if time is None else time
    run.check_time(time)
    index = nearest(control.times, time)

    view = view_of(run)
    mesh, cells = view.seen(control.mesh)
    axes = body_axes(mesh, view)
    magnitude = np.linalg.norm(control.at(index), axis=1)
    triangles = Triangulation(*mesh.points.T, mesh.cells)
    look = {"cmap": style.FIELD_COLOURS, "vmin": 0, "rasterized": True}
    colours = (axes.tripcolor(triangles, facecolors=magnitude[cells], **look) if control.cellwise
               else axes.tripcolor(triangles, magnitude, shading="gouraud", **look))  # fmt: skip
    style.colour_bar(colours, axes, f"control $|u|$ ({control_unit(run)})")
    style.show_time(axes, control.times[index])
    if run.has_contact and run.has_contact_table:
        mark_contact(axes, run, view, control.times[index], control.mesh.size)
    return [style.save(axes.figure, run.path / "figures" / "control_magnitude.png")]


def body_axes(mesh: Mesh, view: View) -> Axes:
    """Axes that fit the undeformed body, with its outline."""
    margin = 0.04 * mesh.size
    axes = style.plan(mesh.points.min(axis=0) - margin, mesh.points.max(axis=0) + margin, view.names)
    axes.add_collection(LineCollection(mesh.points[mesh.outline()], colors="black", linewidths=0.8))
    return axes


def control_unit(run: RunFolder) -> str:
    """The body force or the traction that a control of one stands for."""
    scale, unit = run.told(lambda: (run.scene["control"]["scale"], run.manifest["control_unit"]))
    mantissa, exponent = f"{scale:e}".split("e")
    if int(exponent) == 0:
        return unit if float(mantissa) == 1 else f"{float(mantissa):g} {unit}"
    factor = "" if float(mantissa) == 1 else f"{float(mantissa):g}·"
    return f"{factor}$10^{{{int(exponent)}}}$ {unit}"


def mark_contact(axes: Axes, run: RunFolder, view: View, time: float, size: float) -> None:
    """Marks the nodes in contact at the stored time (s); the body's size (m) sets what counts as no gap."""
    index = nearest(run.contact.times, time)
    # The solver takes 1e-10 of the body's diameter as zero.
    nodes = run.contact.points[run.contact.touching(index, 1e-10 * size)]
    if len(nodes):
        axes.plot(*view.project(nodes).T, "o", color=style.VERMILLION, markeredgecolor="white", markersize=6, markeredgewidth=0.8,
                  linestyle="none", clip_on=False, label="in contact")
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1), borderpad=0, handletextpad=0.1)


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__, timed=True))
