# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinetic, elastic and total energy, the potential of the loads and the energy dissipated so far, over time."""

import sys
from pathlib import Path

import numpy as np

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .command_line import run_alone
from .run_folder import RunFolder, potential_of_loads


def draw(run: RunFolder) -> list[Path]:
    """Draws the energies at the time steps; the dissipation only for a body that has viscosity, the potential only where loads
    do work."""
    steps = run.steps
    kinetic, elastic = steps["kinetic_energy"], steps["elastic_energy"]
    dissipated = np.cumsum(steps["viscous_dissipation"])
    potential = potential_of_loads(steps)
    total = kinetic + elastic + (0 if potential is None else potential)
    factor, unit = style.prefixed(max(total.max(), dissipated[-1]), style.per_depth("J", run.dim))

    figure, axes = style.graph()
    times = style.time_axis(axes, steps["time"])
    axes.plot(times, kinetic * factor, color=style.BLUE, label="kinetic")
    axes.plot(times, elastic * factor, color=style.ORANGE, linestyle="--", label="elastic")
    if potential is not None:
        axes.plot(times, potential * factor, color=style.GREEN, linestyle=":", label="potential")
    axes.plot(times, total * factor, color="black", label="kinetic + elastic" if potential is None else "sum of these")
    if dissipated[-1] > 0:
        axes.plot(times, dissipated * factor, color=style.VERMILION, linestyle="-.", label="dissipated so far")
    style.shade_contact(axes, times, steps["active"])
    axes.set_ylabel(f"energy ({unit})")
    axes.set_ylim(bottom=0)
    style.legend_above(axes)
    return [style.save(figure, run.path / "figures" / "energy.png")]


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__))
