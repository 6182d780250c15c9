"""Magnitude of the control over the undeformed body at one time, with the nodes in contact marked (seed, Fig. 5)."""

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

import style
from command_line import run_alone
from run_folder import Mesh, RunFolder, nearest


def draw(run: RunFolder, time: float | None = None) -> list[Path]:
    """Draws the stored time nearest to `time` (s)."""
    control = run.field("control.xdmf", "control")
    run.require_plane()
    time = run.figure_time() if time is None else time
    run.check_time(time)
    index = nearest(control.times, time)

    figure, axes = body_figure(control.mesh)
    magnitude = np.linalg.norm(control.at(index), axis=1)
    colours = axes.tripcolor(*control.mesh.points.T, control.mesh.triangles, magnitude, shading="gouraud",
                             cmap=style.FIELD_COLOURS, vmin=0, rasterized=True)
    figure.colorbar(colours, ax=axes, pad=0.02, label=f"control $|u|$ ({control_unit(run)})")
    style.show_time(axes, control.times[index])
    if run.has_contact:
        mark_contact(axes, run, control.times[index], control.mesh.size)
    return [style.save(figure, run.path / "figures" / "control_magnitude.png")]


def body_figure(mesh: Mesh) -> tuple[Figure, Axes]:
    """An empty figure that fits the undeformed body, with its outline."""
    width, height = np.ptp(mesh.points, axis=0)
    # The plot itself is about 0.66 of the width; labels and title above and below take 1.4 inches.
    figure = Figure(figsize=(style.WIDTH, np.clip(0.66 * style.WIDTH * height / width + 1.4, 2.5, 9)))
    axes = figure.add_subplot(aspect="equal", xlabel="$x$ (m)", ylabel="$y$ (m)")
    axes.grid(False)
    axes.margins(0.04)
    axes.add_collection(LineCollection(mesh.points[mesh.outline()], colors="black", linewidths=0.8))
    return figure, axes


def control_unit(run: RunFolder) -> str:
    """The body force that a control of one stands for."""
    mantissa, exponent = f"{run.scene['control']['scale']:e}".split("e")
    factor = "" if float(mantissa) == 1 else f"{float(mantissa):g}·"
    return f"{factor}$10^{{{int(exponent)}}}$ N/m³"


def mark_contact(axes: Axes, run: RunFolder, time: float, size: float) -> None:
    """Marks the nodes in contact at the stored time (s); the body's size (m) sets what counts as no gap."""
    index = nearest(run.contact.times, time)
    # The solver takes 1e-10 of the body's diameter as zero.
    nodes = run.contact.points[run.contact.touching(index, 1e-10 * size)]
    if len(nodes):
        axes.plot(*nodes.T, "o", color=style.VERMILLION, markeredgecolor="white", markersize=6, markeredgewidth=0.8,
                  linestyle="none", clip_on=False, label="in contact")
        axes.legend(loc="lower right", handletextpad=0.1)


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__, timed=True))
