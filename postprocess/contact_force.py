"""Nodal contact force over the horizontal position of the undeformed body at one time (seed, Fig. 9)."""

import sys
from pathlib import Path

import numpy as np

import style
from command_line import run_alone
from run_folder import HalfSpace, RunFolder, nearest


def draw(run: RunFolder, time: float | None = None) -> list[Path]:
    """Draws the stored time nearest to `time` (s)."""
    run.require_contact()
    run.require_plane()
    contact = run.contact
    time = run.figure_time() if time is None else time
    run.check_time(time)
    index = nearest(contact.times, time)
    position = contact.points @ run.obstacle.tangent
    order = np.argsort(position)
    factor, unit = style.prefixed(contact.force[index], style.per_depth("N", run.dim))

    figure, axes = style.graph()
    position, force = position[order], contact.force[index][order] * factor
    axes.plot(position, force, "o-", color=style.BLUE, markersize=6, markevery=np.flatnonzero(force > 0).tolist())
    axes.set_xlabel(f"{position_name(run.obstacle)} (m)")
    axes.set_ylabel(f"nodal contact force ({unit})")
    axes.set_ylim(0, 1.06 * force.max() or 1)
    style.show_time(axes, contact.times[index])
    return [style.save(figure, run.path / "figures" / "contact_force.png")]


def position_name(obstacle: HalfSpace) -> str:
    """What the coordinate along the plane is: x above a floor."""
    horizontal = np.allclose(obstacle.tangent, [1, 0])
    return "horizontal position $x$" if horizontal else "position along the obstacle's plane"


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__, timed=True))
