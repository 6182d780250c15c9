"""Total normal contact force over time, of each step and averaged over two neighbouring steps.

In contact-implicit time stepping the force alternates from step to step, on every mesh and for every step size;
the mean of two neighbouring steps is what converges.
"""

import sys
from pathlib import Path

import style
from command_line import run_alone
from run_folder import NotInRun, RunFolder


def draw(run: RunFolder) -> list[Path]:
    """Draws the force of every step, not of the stored ones only."""
    run.require_contact()
    factor, unit = style.prefixed(run.normal_force, style.per_depth("N", run.dim))
    # Row 0 is the initial state, in which no force has acted yet.
    force = run.normal_force[1:] * factor
    if len(force) < 2:
        raise NotInRun("there are fewer than two time steps")

    figure, axes = style.graph()
    times = style.time_axis(axes, run.steps["time"])[1:]
    axes.plot(times, force, ".-", color=style.GREY, linewidth=0.8, markersize=4, label="each step")
    axes.plot((times[1:] + times[:-1]) / 2, (force[1:] + force[:-1]) / 2, color=style.VERMILLION,
              label="mean of two neighbouring steps")
    axes.set_ylabel(f"normal contact force ({unit})")
    axes.set_ylim(bottom=0)
    style.legend_above(axes)
    return [style.save(figure, run.path / "figures" / "contact_force_history.png")]


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__))
