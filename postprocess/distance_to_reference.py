# SPDX-License-Identifier: GPL-3.0-or-later
"""Relative distance of the control to the reference control over the optimizer's iterations (seed, Fig. 7)."""

import sys
from pathlib import Path

import numpy as np

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .command_line import run_alone
from .files import NotInRun
from .run_folder import RunFolder


def draw(run: RunFolder) -> list[Path]:
    """Draws |u - u_ref| / |u_ref| in the norm of L2(0, T; L2), with its smallest value marked."""
    if run.is_fit:
        raise NotInRun("a fit has no reference control")
    iteration, distance = run.history["iteration"], run.history["relative_distance_to_reference"]
    if not np.isfinite(distance).any():
        raise NotInRun("the scene has no reference control (objective.desired.control)")
    best = int(np.nanargmin(distance))

    figure, axes = style.graph()
    axes.plot(iteration, distance, color=style.BLUE)
    axes.plot(iteration[best], distance[best], "o", color=style.VERMILION, clip_on=False, zorder=3,
              label=f"smallest: {distance[best]:.3f} at iteration {iteration[best]:.0f}")
    axes.set_xlabel("iteration")
    axes.set_ylabel(r"$\|u - u_\mathrm{ref}\| \,/\, \|u_\mathrm{ref}\|$ (relative)")
    axes.set_xlim(0, max(iteration[-1], 1))
    axes.set_ylim(bottom=0)
    axes.legend(loc="upper right")
    return [style.save(figure, run.path / "figures" / "distance_to_reference.png")]


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__))
