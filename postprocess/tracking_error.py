# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance of the state to the desired state over time (seed, Fig. 8)."""

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
    """Draws the L2 norm of y - y_d."""
    steps = run.steps
    error = steps.get("tracking_error", np.array([np.nan]))
    if not np.isfinite(error).any():
        raise NotInRun("steps.csv has no tracking error; runs of optimize write it")

    figure, axes = style.graph()
    times = style.time_axis(axes, steps["time"])
    axes.plot(times, error, color=style.BLUE, label="distance to the desired state")
    style.shade_contact(axes, times, steps["active"])
    axes.set_ylabel(rf"$\|y - y_d\|_{{L^2}}$ ({'$m^{5/2}$' if run.whole else 'm²'})")
    axes.set_ylim(bottom=0)
    style.legend_above(axes)
    return [style.save(figure, run.path / "figures" / "tracking_error.png")]


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__))
