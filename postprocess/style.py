# SPDX-License-Identifier: GPL-3.0-or-later
"""Appearance of all figures: common sizes and colours; figures are legible at half their size."""

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

# Okabe and Ito's palette: distinct with every kind of colour vision.
BLUE, VERMILION, GREEN, ORANGE, SKY = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#56B4E9"
GREY, PALE = "0.55", "0.92"
MARK = "signorini report"  # in all pictures of a run, which the next run in its folder removes
FIELD_COLOURS = "viridis"  # even in lightness, so it survives a grey print

WIDTH = 6.4  # inches; half of it is a journal's column
GRAPH_HEIGHT = 4.0
MARGINS = 0.85, 0.7, 1.25, 0.45  # inches to the left, below, to the right and above the plot of a body
PLAN, LEAST_PLAN = np.array([WIDTH - 2.1, 6.5]), np.array([3.6, 1.8])  # inches, largest and smallest place for it

matplotlib.rcParams.update(
    {
        "figure.dpi": 200,
        "figure.constrained_layout.use": True,
        "font.size": 14,
        "axes.labelsize": 14,
        "axes.titlesize": 14,
        "xtick.labelsize": 13,
        "ytick.labelsize": 13,
        "legend.fontsize": 13,
        "legend.frameon": False,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": "0.9",
        "grid.linewidth": 0.8,
        "axes.axisbelow": True,
        "axes.formatter.use_mathtext": True,
        "axes.formatter.limits": (-2, 4),
        "lines.linewidth": 2.2,
    }
)

PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}


def graph() -> tuple[Figure, Axes]:
    """Makes an empty figure for curves."""
    figure = Figure(figsize=(WIDTH, GRAPH_HEIGHT))
    return figure, figure.add_subplot()


def plan(low: np.ndarray, high: np.ndarray, names: tuple[str, str], dots_per_inch: float | None = None) -> Axes:
    """Makes axes of equal scale for the box between two corners (m), with room for a colour bar, in a figure of their own.

    The axes show more than the box if it is too slim for labels.
    """
    low, high = np.asarray(low), np.asarray(high)
    scale = min(PLAN / (high - low))
    room = np.maximum(0, LEAST_PLAN / scale - (high - low)) / 2
    low, high = low - room, high + room
    plot = scale * (high - low)
    left, bottom, right, top = MARGINS
    width, height = plot + (left + right, bottom + top)
    # Placed by hand: the automatic layout does not foresee that equal scales narrow the plot.
    figure = Figure(figsize=(width, height), dpi=dots_per_inch, layout="none")
    place = [left / width, bottom / height, plot[0] / width, plot[1] / height]
    axes = figure.add_axes(place, aspect="equal", xlabel=f"{names[0]} (m)", ylabel=f"{names[1]} (m)")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.grid(False)
    figure.draw_without_rendering()
    begins = axes.yaxis.get_tightbbox().x0 / figure.dpi
    if begins < 0:  # long numbers at the ticks need more room
        lack = 0.05 - begins
        figure.set_figwidth(width + lack)
        axes.set_position([(left + lack) / (width + lack), place[1], plot[0] / (width + lack), place[3]])
    return axes


def prefixed(values: np.ndarray | float, unit: str) -> tuple[float, str]:
    """Returns a factor and a prefixed unit with which the largest value (in `unit`) is between 1 and 1000. kg gets no further prefix."""
    largest = float(np.max(np.abs(values)))
    if largest == 0 or not np.isfinite(largest) or unit.startswith("kg"):
        return 1.0, unit
    # A hair more, so that a value of 1 that was rounded down counts as 1.
    power = int(3 * np.floor(np.log10(largest * (1 + 1e-9)) / 3))
    power = min(max(power, min(PREFIXES)), max(PREFIXES))
    return 10.0**-power, PREFIXES[power] + unit


def per_depth(unit: str, whole: bool) -> str:
    """Returns the unit of a force or energy: of the whole body (RunFolder.whole), else per metre of its depth."""
    return unit if whole else unit + "/m"


def time_axis(axes: Axes, times: np.ndarray) -> np.ndarray:
    """Labels the horizontal axis as time; returns the times (s) in the axis' unit."""
    factor, unit = prefixed(times, "s")
    axes.set_xlabel(f"time $t$ ({unit})")
    axes.set_xlim(times[0] * factor, times[-1] * factor)
    return times * factor


def show_time(axes: Axes, time: float) -> None:
    """Writes the time (s) above the axes."""
    factor, unit = prefixed(time, "s")
    axes.set_title(f"$t$ = {time * factor:.4g} {unit}", loc="left")


def single_steps(axes: Axes, times: np.ndarray) -> None:
    """Writes above the axes that values are those of the steps that end at the times (s), between which nothing is known."""
    factor, unit = prefixed(times, "s")
    apart = float(np.median(np.diff(times))) * factor
    axes.set_title(f"single steps, stored every {apart:.3g} {unit}", loc="left", fontsize="small")


def colour_bar(colours: ScalarMappable, axes: Axes, label: str) -> None:
    """Adds a colour bar to the right of the axes, as high as they are."""
    axes.figure.colorbar(colours, cax=axes.inset_axes([1.03, 0, 0.035, 1]), label=label)


def legend_above(axes: Axes) -> None:
    """Adds a legend that covers no curve."""
    axes.figure.legend(loc="outside upper center", ncols=3, columnspacing=1.2, handlelength=1.8)


def shade_contact(axes: Axes, times: np.ndarray, active: np.ndarray) -> None:
    """Shades the steps that end in contact; times in the axis' unit, active nodes per step."""
    touching = np.concatenate([[False], active[1:] > 0, [False]])
    starts, ends = np.flatnonzero(touching[1:] & ~touching[:-1]), np.flatnonzero(touching[:-1] & ~touching[1:])
    for i, (start, end) in enumerate(zip(starts, ends)):
        axes.axvspan(times[start], times[end], color=PALE, lw=0, zorder=0, label="in contact" if i == 0 else None)


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yields a temporary file to write; it becomes `path` when the block succeeds, and is removed otherwise."""
    path.parent.mkdir(exist_ok=True)
    partial = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        yield partial
        partial.replace(path)
    except OSError as error:
        error.filename = error.filename or path  # a full disk is found by write(), which has no name
        raise
    finally:
        partial.unlink(missing_ok=True)


def save(figure: Figure, path: Path) -> Path:
    """Writes the figure; returns the path."""
    picture = io.BytesIO()
    figure.savefig(picture, format=path.suffix[1:], metadata={"Comment": MARK})
    for attempts in (1, 0):
        try:
            with whole_file(path) as partial:
                partial.write_bytes(picture.getvalue())
            break
        except FileNotFoundError:  # a run has just taken the figures of an earlier one away
            if not attempts:
                raise
    return path
