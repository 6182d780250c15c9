# SPDX-License-Identifier: GPL-3.0-or-later
"""Normal contact force over time, of each step and averaged over two neighbouring steps; with several obstacles their means.

In contact-implicit time stepping the force alternates from step to step, on every mesh and for every step size;
only the mean of two neighbouring steps converges. The force of a step acts all through it and is drawn in its middle.
"""

import sys
from pathlib import Path

import numpy as np

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .command_line import run_alone
from .files import NotInRun
from .run_folder import RunFolder

LOOKS = [(style.BLUE, "-"), (style.VERMILION, "--"), (style.GREEN, "-."), (style.ORANGE, ":")]


def draw(run: RunFolder) -> list[Path]:
    """Draws the contact force of every step, not only of the stored steps."""
    run.require_contact()
    if len(run.steps["time"]) < 3:
        raise NotInRun("there are fewer than two time steps")
    try:
        force, label = run.normal_force, "normal contact force"
    except NotInRun:
        force, label = np.linalg.norm(run.resultant, axis=1), "resultant contact force"
    factor, unit = style.prefixed(force, style.per_depth("N", run.whole))

    figure, axes = style.graph()
    times = style.time_axis(axes, run.steps["time"])
    own = each_obstacle(run)
    if own:
        for (name, force), (colour, line) in zip(own.items(), LOOKS):
            axes.plot(times[1:-1], mean(force) * factor, line, color=colour, label=name)
        axes.set_ylabel(f"{label},\nmean of two steps ({unit})")
    else:
        # Row 0 is the initial state, in which no force has acted yet.
        middle = (times[1:] + times[:-1]) / 2
        axes.plot(middle, force[1:] * factor, ".-", color=style.GREY, linewidth=0.8, markersize=4, label="each step")
        axes.plot(times[1:-1], mean(force) * factor, color=style.VERMILION, label="mean of two neighbouring steps")
        axes.set_ylabel(f"{label} ({unit})")
    axes.set_ylim(bottom=0)
    style.legend_above(axes)
    return [style.save(figure, run.path / "figures" / "contact_force_history.png")]


def each_obstacle(run: RunFolder) -> dict[str, np.ndarray]:
    """Returns the forces of those of several obstacles that push the most, by name; none for one obstacle or without obstacles.csv."""
    if len(run.obstacle_names) < 2:
        return {}
    try:
        steps = sorted(run.obstacle_steps, key=lambda own: -own.normal_force.max())[: len(LOOKS)]
    except NotInRun:
        return {}
    return {own.name: own.normal_force for own in sorted(steps, key=lambda own: run.obstacle_names.index(own.name))}


def mean(force: np.ndarray) -> np.ndarray:
    """Returns the mean force of each two neighbouring steps, which belongs to the time between them."""
    return (force[2:] + force[1:-1]) / 2


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__))
