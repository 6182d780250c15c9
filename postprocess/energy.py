# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinetic, elastic and total energy, the potential of the loads, the energy dissipated so far, the work of a control and of moving clamps,
and with friction the energy lost to it and the work of surfaces that move along themselves, over time."""

import sys
from pathlib import Path

import numpy as np

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .command_line import run_alone
from .energy_terms import dissipated_so_far, further_energies, potential_of_loads, stored_energy, work_of_others, works_of_friction
from .run_folder import RunFolder

FRICTION_LOOKS = {"lost to friction so far": ("lost to friction", style.VERMILION, ":"),
                  "work of moving surfaces so far": ("moving surfaces", "#CC79A7", "--")}  # fmt: skip
LOOKS = {"foundations": (style.SKY, (0, (3, 1, 1, 1))), "branches": (style.ORANGE, ":"), "obstacles": (style.GREEN, (0, (5, 1)))}


def draw(run: RunFolder) -> list[Path]:
    """Draws the energies at the time steps; the dissipation only if there is any, the potential only where loads do work."""
    steps = run.steps
    kinetic, elastic = steps["kinetic_energy"], steps["elastic_energy"]
    dissipated, further = dissipated_so_far(steps), further_energies(steps)
    potential = potential_of_loads(steps)
    total = stored_energy(steps) + (0 if potential is None else potential)
    friction = works_of_friction(steps)
    given = work_of_others(run)
    largest = max(total.max(), dissipated[-1], *(np.abs(work).max() for work in friction.values()))
    factor, unit = style.prefixed(largest, style.per_depth("J", run.whole))

    figure, axes = style.graph()
    times = style.time_axis(axes, steps["time"])
    axes.plot(times, kinetic * factor, color=style.BLUE, label="kinetic")
    axes.plot(times, elastic * factor, color=style.ORANGE, linestyle="--", label="elastic")
    for name, energy in further.items():
        color, linestyle = LOOKS[name]
        axes.plot(times, energy * factor, color=color, linestyle=linestyle, label=name)
    if potential is not None:
        axes.plot(times, potential * factor, color=style.GREEN, linestyle=":", label="potential")
        axes.set_title("potential: falls by the work of the loads, least value 0", loc="left", fontsize="small")
    axes.plot(times, total * factor, color="black", label="kinetic + elastic" if potential is None and not further else "sum of these")
    if dissipated[-1] > 0:
        axes.plot(times, dissipated * factor, color=style.VERMILION, linestyle="-.", label="dissipated so far")
    if given is not None:
        axes.plot(times, given * factor, color="#CC79A7", linestyle=(0, (5, 1)), label="work of control and clamps so far")
    for name, work in friction.items():
        label, color, linestyle = FRICTION_LOOKS[name]
        axes.plot(times, work * factor, color=color, linestyle=linestyle, label=label)
    style.shade_contact(axes, times, steps["active"])
    axes.set_ylabel(f"energy ({unit})")
    if all(work.min() >= -1e-9 * largest for work in [*friction.values(), *([] if given is None else [given])]):
        axes.set_ylim(bottom=0)
    style.legend_above(axes)
    return [style.save(figure, run.path / "figures" / "energy.png")]


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__))
