# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodal contact force over the horizontal position, or the radius, of the undeformed body at one time (seed, Fig. 9).

In space, colours at the candidates' places show it, seen along the obstacle's normal. Beside a curved obstacle, or several, it
is drawn over the position along the surface. With friction the nodal force along the obstacle is drawn too, in space by arrows,
and marks show which candidates stick and slip.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .boundary import arc_of
from .command_line import run_alone
from .contact_table import SLIP, STICK, Contact
from .files import NotInRun
from .report_contact import origin
from .run_folder import RunFolder, nearest
from .scenery import main_normal


MOST_LABELS = 6  # along the axis of positions, whose numbers may have a sign and three digits
# Of the numbers of MOTION.
MARKS = {STICK: {"color": style.SKY, "marker": "s", "linestyle": "", "markeredgecolor": "black", "label": "sticks"},
         SLIP: {"color": style.VERMILION, "marker": "D", "linestyle": "", "markeredgecolor": "black", "label": "slips"}}  # fmt: skip


def draw(run: RunFolder, time: float | None = None) -> list[Path]:
    """Draws the stored time nearest to `time` (s)."""
    run.require_contact()
    contact = run.contact
    given, time = time, run.figure_time() if time is None else time
    run.check_time(time)
    index = nearest(contact.times, time)
    if given is None and not contact.force[index].any():  # of a run by an earlier version
        raise NotInRun("no stored step is in contact; output.every = 1 stores all steps")
    factor, unit = style.prefixed(contact.force[index], style.per_depth("N", run.whole))
    label = f"nodal contact force ({unit})"
    if run.dim == 3:
        axes = over_plane(main_normal(run), contact, index, factor, label)
    elif (normal := run.plane_normal) is not None:
        tangent = np.array([1.0, 0.0]) if run.axisymmetric else np.array([normal[1], -normal[0]])
        name = run.axis_names[0] if run.axisymmetric else position_name(tangent)
        axes = over_line(tangent, name, contact, index, factor, label)
    else:
        axes = over_arc(run, index, factor, label)
    style.show_time(axes, contact.times[index])
    return [style.save(axes.figure, run.path / "figures" / "contact_force.png")]


def over_line(tangent: np.ndarray, name: str, contact: Contact, index: int, factor: float, label: str) -> Axes:
    """Draws a curve over the position along the plane (m), which has a name."""
    position = contact.points @ tangent
    order = np.argsort(position)
    _, axes = style.graph()
    position, force = position[order], contact.force[index][order] * factor
    axes.plot(position, force, "o-", color=style.BLUE, markersize=6, markevery=np.flatnonzero(force > 0).tolist())
    axes.set_xlabel(f"{name} (m)")
    axes.xaxis.set_major_locator(MaxNLocator(MOST_LABELS))
    axes.set_ylabel(label)
    axes.set_ylim(0, 1.06 * force.max() or 1)
    if contact.friction is not None:
        add_friction(axes, contact, index, factor, position, [order])
    return axes


def over_arc(run: RunFolder, index: int, factor: float, label: str) -> Axes:
    """Draws a curve over the position along the surface (m), where the obstacle is curved or there are several; interrupted where
    the surface is."""
    contact = run.contact.by_node()
    arc = arc_of(run.boundary_mesh, contact.points, origin(run, contact))
    force = contact.force[index][arc.order] * factor
    _, axes = style.graph()
    for part in np.unique(arc.part):
        own = arc.part == part
        pushed = np.flatnonzero(force[own] > 0).tolist()
        axes.plot(arc.position[own], force[own], "o-", color=style.BLUE, markersize=6, markevery=pushed)
    axes.set_xlabel("position along the surface (m)")
    axes.xaxis.set_major_locator(MaxNLocator(MOST_LABELS))
    axes.set_ylabel(label)
    axes.set_ylim(0, 1.06 * force.max() or 1)
    if contact.friction is not None:
        add_friction(axes, contact, index, factor, arc.position, [arc.order[arc.part == part] for part in np.unique(arc.part)])
    return axes


def add_friction(axes: Axes, contact: Contact, index: int, factor: float, position: np.ndarray, parts: list[np.ndarray]) -> None:
    """Adds the friction force over the positions (m) of all parts of the surface, each candidates in order, and marks by motion."""
    order = np.concatenate(parts)
    along, motion = contact.tangential_force[index][order] * factor, contact.friction.motion[index][order]
    axes.lines[0].set_label("normal")
    for part, ends in zip(parts, np.cumsum([len(part) for part in parts])):
        own = slice(ends - len(part), ends)
        axes.plot(position[own], along[own], "--", color=style.VERMILION, label="friction" if ends == len(parts[0]) else None)
    for number, look in MARKS.items():
        if (on := motion == number).any():
            axes.plot(position[on], along[on], **look)
    axes.set_ylim(min(0, 1.15 * along.min()), axes.get_ylim()[1])
    style.legend_above(axes)


def over_plane(normal: np.ndarray, contact: Contact, index: int, factor: float, label: str) -> Axes:
    """Draws coloured dots at the candidates that carry a force, pale ones at the others."""
    points, force = contact.points, contact.force[index] * factor
    horizontal = np.allclose(normal[:2], 0)
    across = np.array([1.0, 0.0, 0.0]) if horizontal else np.cross(normal, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    along = np.column_stack([across, np.cross(normal, across)])
    position = points @ along
    low, high = position.min(axis=0), position.max(axis=0)
    margin = 0.05 * (high - low).max()
    names = ("$x$", "$y$") if horizontal and normal[2] > 0 else ("along the plane", "along the plane")
    axes = style.plan(low - margin, high + margin, names)
    pushed = force > 0
    axes.plot(*position[~pushed].T, "o", color=style.PALE, markeredgecolor=style.GREY, markersize=5)
    dots = axes.scatter(*position[pushed].T, c=force[pushed], s=60, cmap=style.FIELD_COLOURS, vmin=0, zorder=2)
    style.colour_bar(dots, axes, label)
    if contact.friction is not None:
        add_arrows(axes, position, contact.friction.force[index] @ along * factor, contact.friction.motion[index])
    return axes


def add_arrows(axes: Axes, position: np.ndarray, force: np.ndarray, motion: np.ndarray) -> None:
    """Adds the friction forces, the longest as long as a tenth of the picture, in a colour for each motion."""
    longest = np.linalg.norm(force, axis=1).max()
    length = 0.1 * max(np.diff(axes.get_xlim())[0], np.diff(axes.get_ylim())[0])
    shown = {number: look for number, look in MARKS.items() if longest and (motion == number).any()}
    for place, (number, look) in enumerate(reversed(shown.items())):
        on = motion == number
        axes.quiver(*position[on].T, *force[on].T, angles="xy", scale_units="xy", scale=longest / length, color=look["color"], width=0.008,
                    edgecolor="black", linewidth=0.5, zorder=3)  # fmt: skip
        axes.annotate(f"→ {look['label']}", (1, 1), (-70 * place, 6), xycoords="axes fraction", textcoords="offset points", ha="right",
                      fontsize=13, color=look["color"])  # fmt: skip


def position_name(tangent: np.ndarray) -> str:
    """Names the coordinate along the plane: x above a floor."""
    horizontal = np.allclose(tangent, [1, 0])
    return "horizontal position $x$" if horizontal else "position along the obstacle's plane"


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__, timed=True))
