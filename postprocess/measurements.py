# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured and simulated values of a fit over time, with the noise of the data as a band."""

import sys
from pathlib import Path

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import report_fit, style
from .command_line import run_alone
from .run_folder import RunFolder


def draw(run: RunFolder) -> list[Path]:
    """Draws one picture for each measurement."""
    files = []
    for i, (name, one) in enumerate(report_fit.measurements(run).items(), 1):
        figure, axes = style.graph()
        times = style.time_axis(axes, one.time)
        axes.fill_between(times, one.simulated - 2 * one.deviation, one.simulated + 2 * one.deviation, color=style.VERMILION,
                          alpha=0.18, linewidth=0, label="±2 deviations")  # fmt: skip
        axes.plot(times, one.value, ".", color=style.GREY, markersize=4, label="measured")
        axes.plot(times, one.simulated, color=style.VERMILION, label="simulated")
        axes.set_ylabel(f"{name} ({report_fit.unit_of(run, name)})")
        style.legend_above(axes)
        files.append(style.save(figure, run.path / "figures" / f"measurements-{i}.png"))
    return files


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__))
