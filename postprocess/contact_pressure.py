# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact pressure over the position along the surface and time, averaged over two neighbouring steps where all are stored.

In space, the position is the distance from the node that is pushed the most. Bands without candidates are blank.
"""

import sys
from pathlib import Path

import numpy as np

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .command_line import run_alone
from .report_contact import along_surface, around_contact, rows_of, touched
from .run_folder import RunFolder


def draw(run: RunFolder) -> list[Path]:
    """Draws the pressure on the part of the surface that touches an obstacle at any time."""
    run.require_contact()
    contact = run.contact.by_node()
    place = along_surface(run, contact) if run.dim == 2 else around_contact(contact)
    times, pressure = contact.times, contact.pressure[1:]
    if run.stores_every_step and len(times) > 3:
        # The mean of two steps belongs to the time between them.
        times, pressure = (times[1:] + times[:-1]) / 2, (pressure[1:] + pressure[:-1]) / 2
    factor, unit = style.prefixed(pressure, "Pa")

    figure, axes = style.graph()
    edges = style.time_axis(axes, times)
    if not run.stores_every_step:  # each value next to the step that has it
        edges = np.concatenate([(edges[1:] + edges[:-1]) / 2, edges[-1:]])
        style.single_steps(axes, times)
    shown = rows_of(place, pressure, "pressure") * factor
    colours = axes.pcolormesh(edges, place.edges, np.ma.masked_invalid(shown), cmap=style.FIELD_COLOURS, vmin=0, rasterized=True)
    axes.set_ylim(*touched(contact, place))
    axes.set_ylabel(place.title.replace("<br>", "\n"))
    figure.colorbar(colours, label=f"contact pressure ({unit})")
    return [style.save(figure, run.path / "figures" / "contact_pressure.png")]


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__))
