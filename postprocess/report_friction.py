# SPDX-License-Identifier: GPL-3.0-or-later
"""Part of a run's page about friction: forces along the obstacles, and candidates that slip and stick."""

import numpy as np

from . import style
from .files import NotInRun
from .friction_force import FrictionForce, friction_forces, has_friction, slip_and_stick
from .report_parts import GREY, Chart, figure, line, packed, time_axis
from .run_folder import RunFolder

FROM_ZERO = {"rangemode": "tozero"}
# Of the numbers in MOTION.
NAMES = ["open", "in contact, no friction", "sticks", "slips"]
COLOURS = ["#eceff1", GREY, style.SKY, style.VERMILION]
SPLIT = "normal force and friction"


def slip_stick(run: RunFolder) -> Chart:
    """Makes the chart of the numbers of candidates that slip and stick in every step."""
    run.require_contact()
    slip, stick = slip_and_stick(run)
    times, title = time_axis(run.steps["time"])
    # The wider curve shows beside the other where they coincide.
    curves = [line("stick", times, stick, style.SKY, width=4), line("slip", times, slip, style.VERMILION, width=1.8)]
    for curve in curves:
        curve["line"]["shape"] = "vh"  # row k is valid for the step that ends there
    ticks = {"dtick": 1} if max(slip.max(), stick.max()) < 10 else {}
    return Chart.single("slip-stick", "Candidates that slip and stick", figure(curves, title, "candidates", yaxis=FROM_ZERO | ticks))


def force_views(run: RunFolder) -> dict[str, dict]:
    """Makes views of the contact force split into its normal and tangential part, by the obstacles' names; none without friction or
    where the run did not write the parts."""
    try:
        forces = friction_forces(run)
    except NotInRun:
        return {}
    if len(run.steps["time"]) < 3:
        return {}
    unit = style.per_depth("N", run.whole)
    return {name: split_force(run, force, unit) for name, force in forces.items()}


def split_force(run: RunFolder, force: FrictionForce, unit: str) -> dict:
    """Makes a view of the normal and the friction force, means of two steps, and of the bound of friction."""
    normal, tangential = force.means()
    factor, unit = style.prefixed(np.concatenate([normal, tangential]), unit)
    times, title = time_axis(run.steps["time"])
    between, signed = times[1:-1], force.signed
    curves = [line("normal", between, normal * factor, style.BLUE)]
    if (bound := force.bound()) is not None:
        both = np.concatenate([bound, [np.nan], -bound]) if signed else bound
        over = np.concatenate([between, [np.nan], between]) if signed else between
        curves.append(line(f"{'±' * signed}{force.coefficient:g} × normal", over, both * factor, GREY, "dot", 1.5))
    curves.append(line("friction", between, tangential * factor, style.VERMILION, "dash"))
    return figure(curves, title, f"contact force ({unit}),<br>mean of two steps", xaxis={"range": [0, times[-1]]}, yaxis=FROM_ZERO)


def friction_note(run: RunFolder) -> str:
    """Explains the sign of friction forces; an empty text without friction."""
    if not has_friction(run):
        return ""
    if run.dim == 3:
        return "Friction is the modulus of the sum of the forces along the obstacle."
    return "Friction counts along the obstacle's normal turned clockwise: to the right above a floor."


def motion_map(times: np.ndarray, edges: np.ndarray, motion: np.ndarray, position: str, axis: dict) -> dict:
    """Makes a view of the candidates' motion (rows × times of numbers in MOTION, NaN where there is no candidate) between the rows' edges
    (m), by a colour for each motion."""
    found = [int(number) for number in np.unique(motion[~np.isnan(motion)])]
    level = np.where(np.isnan(motion), np.nan, np.searchsorted(found, np.nan_to_num(motion)))
    count = len(found)
    scale = [[(i + side) / count, COLOURS[number]] for i, number in enumerate(found) for side in (0, 1)]
    shown, title = time_axis(times)
    trace = {"type": "heatmap", "x": packed(shown), "y": packed(edges), "z": packed(level), "hoverinfo": "skip", "zmin": -0.5,
             "zmax": count - 0.5, "colorscale": scale,
             "colorbar": {"tickvals": list(range(count)), "ticktext": [NAMES[number] for number in found], "thickness": 14,
                          "outlinewidth": 0}}  # fmt: skip
    return figure([trace], title, position, yaxis=axis)
