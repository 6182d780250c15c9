# SPDX-License-Identifier: GPL-3.0-or-later
"""Normal contact force over time, of each step and averaged over two neighbouring steps; with several obstacles their means. With
friction also the force along the obstacle.

In contact-implicit time stepping the force alternates from step to step, on every mesh and for every step size;
only the mean of two neighbouring steps converges. The force of a step acts all through it and is drawn in its middle.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .command_line import run_alone
from .files import NotInRun
from .friction_force import friction_forces, has_friction
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
    own, friction = each_obstacle(run), has_friction(run)
    if own:
        for (name, force), (colour, line) in zip(own.items(), LOOKS):
            axes.plot(times[1:-1], mean(force) * factor, line, color=colour, label=name)
        axes.set_ylabel(f"{label},\nmean of two steps ({unit})")
    else:
        # Row 0 is the initial state, in which no force has acted yet.
        middle = (times[1:] + times[:-1]) / 2
        axes.plot(middle, force[1:] * factor, ".-", color=style.GREY, linewidth=0.8, markersize=4,
                  label="normal, each step" if friction else "each step")  # fmt: skip
        axes.plot(times[1:-1], mean(force) * factor, color=style.VERMILION,
                  label="normal, mean" if friction else "mean of two neighbouring steps")  # fmt: skip
        axes.set_ylabel(f"{label} ({unit})")
    axes.set_ylim(bottom=0)
    add_friction(axes, run, times, factor, unit)
    style.legend_above(axes)
    return [style.save(figure, run.path / "figures" / "contact_force_history.png")]


def add_friction(axes: Axes, run: RunFolder, times: np.ndarray, factor: float, unit: str) -> None:
    """Adds the mean friction force of each obstacle that has friction, of a single one with its bound."""
    try:
        forces = friction_forces(run)
    except NotInRun:
        return
    colours = dict(zip(each_obstacle(run), (colour for colour, _ in LOOKS)))
    for name, force in forces.items():
        along = force.means()[1] * factor
        if not colours and (bound := force.bound()) is not None:
            both = -1 if force.signed else 1
            axes.plot(times[1:-1], bound * factor, ":", color=style.GREY, label=f"{'±' * force.signed}{force.coefficient:g} × normal")
            axes.plot(times[1:-1], both * bound * factor, ":", color=style.GREY)
        if not colours or name in colours:
            axes.plot(times[1:-1], along, color=colours.get(name, style.BLUE), linestyle="--" if not colours else "-", linewidth=1.4,
                      label=f"{name}, friction" if colours else "friction, mean")  # fmt: skip
    if any((force.tangential < 0).any() for force in forces.values()):
        axes.autoscale(axis="y")
    if forces:
        axes.set_ylabel("contact force" + ",\nmean of two steps" * bool(colours) + f" ({unit})")


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
