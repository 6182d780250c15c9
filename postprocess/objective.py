# SPDX-License-Identifier: GPL-3.0-or-later
"""Objective above its last value over the optimizer's iterations (seed, Fig. 6)."""

import sys
from pathlib import Path

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .command_line import run_alone
from .files import NotInRun
from .run_folder import RunFolder


def draw(run: RunFolder) -> list[Path]:
    """Draws J - J_last on a logarithmic scale."""
    iteration, objective = run.history["iteration"], run.history["objective"]
    above = objective - objective[-1]
    shown = above > 0  # a logarithmic axis cannot show the last value itself
    if not shown.any():
        raise NotInRun("the objective was never above its last value")
    # J is a time integral of squared L2 norms of a length; of a fit, of residuals in standard deviations.
    unit = "1" if run.is_fit else f"m{'⁵' if run.whole else '⁴'} s"
    last = f"J_{{{iteration[-1]:.0f}}}"

    figure, axes = style.graph()
    axes.semilogy(iteration[shown], above[shown], color=style.BLUE)
    axes.set_xlabel("iteration $i$")
    axes.set_ylabel(f"objective $J_i - {last}$ ({unit})")
    axes.set_xlim(0, iteration[-1])
    axes.text(0.97, 0.95, f"${last}$ = {objective[-1]:.4g} {unit}", transform=axes.transAxes, ha="right", va="top")
    return [style.save(figure, run.path / "figures" / "objective.png")]


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__))
