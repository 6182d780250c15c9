# SPDX-License-Identifier: GPL-3.0-or-later
"""Resultant of the control over time, by its components."""

import sys
from pathlib import Path

import numpy as np

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .command_line import run_alone
from .report_control import components, resultant_of
from .run_folder import RunFolder

LOOKS = [(style.BLUE, "-"), (style.VERMILION, "--"), (style.GREEN, "-.")]


def draw(run: RunFolder) -> list[Path]:
    """Draws the resultant of the control in each step."""
    control = run.field("control", "control")
    force = resultant_of(run, control)
    factor, unit = style.prefixed(force, style.per_depth("N", run.whole))

    figure, axes = style.graph()
    starts = np.concatenate([[0.0], control.times])
    times = style.time_axis(axes, starts)
    for (axis, name), (colour, dash) in zip(components(run).items(), LOOKS):
        values = force[:, axis] * factor
        if run.stores_every_step:
            axes.step(times, np.append(values[0], values), where="pre", color=colour, linestyle=dash, label=f"${name}$")
        else:
            axes.plot(times[1:], values, color=colour, linestyle="none", marker="o", markersize=4, label=f"${name}$")
    if not run.stores_every_step:
        style.single_steps(axes, starts)
    axes.set_ylabel(f"resultant of the control ({unit})")
    style.legend_above(axes)
    return [style.save(figure, run.path / "figures" / "control_history.png")]


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__))
