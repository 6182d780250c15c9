# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws all figures of a run into RUN_FOLDER/figures, and reports each figure without data in one line."""

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import (
    animation,
    contact_force,
    contact_force_history,
    contact_pressure,
    control_history,
    control_magnitude,
    distance_to_reference,
    energy,
    measurements,
    objective,
    tracking_error,
)
from .command_line import Parents, arguments, complain, say
from .files import NotInRun, Unreadable
from .run_folder import RunFolder


def figures(time: float | None) -> dict[str, Callable[[RunFolder], list[Path]]]:
    """Returns the figures by the name of their files; `time` (s) is for those that show one time."""
    return {
        "objective": objective.draw,
        "distance_to_reference": distance_to_reference.draw,
        "tracking_error": tracking_error.draw,
        "control_magnitude": partial(control_magnitude.draw, time=time),
        "control_history": control_history.draw,
        "contact_force": partial(contact_force.draw, time=time),
        "contact_force_history": contact_force_history.draw,
        "contact_pressure": contact_pressure.draw,
        "energy": energy.draw,
        "measurements": measurements.draw,
        "animation": animation.draw,
    }


def draw_all(run: RunFolder, time: float | None) -> int:
    """Draws all figures that have data; returns the exit status, 2 if a file is damaged."""
    status = 0
    for name, draw in figures(time).items():
        # A figure of an earlier run in the same folder must not pass for one of this run.
        for old in (run.path / "figures").glob(f"{name}[.-]*"):
            old.unlink()
        try:
            for path in draw(run):
                say(path)
        except NotInRun as reason:
            say(f"no {name}: {reason}")
        except (Unreadable, OSError) as error:
            complain(error)
            status = 2
    return status


def main(parents: Parents = ()) -> int:
    given = arguments(__doc__, timed=True, parents=parents)
    try:
        run = RunFolder(given.run_folder)
        if given.time is not None:
            run.check_time(given.time)
    except (NotInRun, Unreadable) as error:
        complain(error)
        return 2
    return draw_all(run, given.time)


if __name__ == "__main__":
    sys.exit(main())
