# SPDX-License-Identifier: GPL-3.0-or-later
"""Part of a run's page that summarises impact and energy, from run.json."""

import numpy as np

from .friction_force import coefficients
from .report_parts import Table, quantity
from .run_folder import RunFolder
from .style import per_depth, prefixed


def impact(run: RunFolder) -> list[Table]:
    """Makes tables of contact with each obstacle and of the body before and after; none without a summary or without contact."""
    given = run.manifest.get("impact")
    if not given or not given["all"]["contact_time"]:
        return []
    rows = [touch(run, one["name"], one) for one in given["obstacles"]]
    if len(rows) > 1:
        rows.append(touch(run, "all", given["all"]))
    title = (f"Moduli of forces are added; the force of a step acts during the whole step. 1 to 99 %: time for this part of the impulse. Sustained: the largest mean "
             f"over {quantity(given['all']['sustained_over'], 's')}, which converges with step and size if the force is smooth. †: need not converge with step and size.")
    if any(one.get("peak_at_onset") for one in [*given["obstacles"], given["all"]]):
        title += " ∗: as contact begins, before a wave has crossed the body."
    head = ["Obstacle", "Contact from †", "to †", "In contact for †", "1 to 99 % in", "Impulse", "Resultant impulse", "Sustained peak", "Peak of two steps †"]
    tables = [Table(title, head, rows), *friction_impulses(run, given)]
    if given["velocity_before"]:
        body = [["Mass", quantity(given["mass"] * 1000, per_depth("g", run.whole))],
                ["Velocity of the centre of mass before", vector(given["velocity_before"], "m/s")],
                ["and after" if given["ended"] else "and at the end, still in contact", vector(given["velocity_after"], "m/s")]]
        if given["restitution"] is not None:
            body.append(["Restitution", f"{given['restitution']:.4g}"])
        stress = run.manifest.get("largest_von_mises")
        if stress:
            body.append(["Largest von Mises stress of the stored times",
                         f"{quantity(stress['value'], 'Pa')} at {vector(stress['point'], 'm')}, {quantity(stress['time'], 's')}{', as contact begins' if stress.get('at_onset') else ''}"])
        tables.append(Table(f"{given.get('body') or 'The body'} as a whole", ["Quantity", "Value"], body))
    if "bodies" in given:
        tables.append(Table("All bodies: velocities of their centres of mass", ["Body", "Mass", "At the start", "At the end"], [
            [one["name"], quantity(one["mass"] * 1000, per_depth("g", run.whole)), vector(one["velocity_at_start"], "m/s"),
             vector(one["velocity_at_end"], "m/s")] for one in given["bodies"]]))  # fmt: skip
    bounces = given.get("bounces", [])
    if len(bounces) > 1:
        most = 20
        title = f"Bounces one by one{f', the first {most} of {len(bounces)}' if len(bounces) > most else ''}: velocities of the centre of mass"
        impulse, force = per_depth("N s", run.whole), per_depth("N", run.whole)
        tables.append(Table(title, ["Contact from", "to", "Touches", "Impulse", "Peak force", "Velocity before", "Velocity after", "Restitution"], [
            [quantity(one["start"], "s"), quantity(one["end"], "s"), str(one.get("touches", 1)), vector(one["impulse"], impulse), quantity(one["peak"], force), vector(one["velocity_before"], "m/s"), vector(one["velocity_after"], "m/s"),
             "–" if one["restitution"] is None else f"{one['restitution']:.4g}"] for one in bounces[:most]]))  # fmt: skip
    return tables


def touch(run: RunFolder, name: str, given: dict) -> list[str]:
    """Makes the row of an obstacle, with dashes if it was not touched."""
    if not given["contact_time"]:
        return [name, "never", *["–"] * 7]
    force, impulse = per_depth("N", run.whole), per_depth("N s", run.whole)
    return [name, quantity(given["start"], "s"), quantity(given["end"], "s"), quantity(given["contact_time"], "s"),
            quantity(given["impulse_duration"], "s"), quantity(given["normal_impulse"], impulse), vector(given["impulse"], impulse),
            quantity(given["sustained_peak"], force),
            f"{quantity(given['normal_peak'], force)} at {quantity(given['peak_time'], 's')}{' ∗' if given.get('peak_at_onset') else ''}"]  # fmt: skip


def friction_impulses(run: RunFolder, given: dict) -> list[Table]:
    """Makes a table of the impulses along the normals and of friction; none without friction."""
    known, unit = coefficients(run), per_depth("N s", run.whole)
    touched = [one for one in given["obstacles"] if one["name"] in known and one["contact_time"] and "friction_impulse" in one]
    if not touched:
        return []
    rows = [[one["name"], "varies" if known[one["name"]] is None else f"{known[one['name']]:g}", quantity(one["normal_impulse"], unit),
             vector(one["friction_impulse"], unit), ratio(one)] for one in touched]  # fmt: skip
    title = "Friction. The ratio of both impulses is at most the coefficient, which it equals if all candidates slip in one direction."
    if run.axisymmetric:
        title += " Radial forces have no resultant."
    return [Table(title, ["With friction", "Coefficient", "Normal impulse", "Friction impulse", "Ratio"], rows)]


def ratio(given: dict) -> str:
    """Writes the modulus of the friction impulse divided by the impulse along the normals."""
    normal = given["normal_impulse"]
    return f"{float(np.linalg.norm(given['friction_impulse'])) / normal:.4g}" if normal else "–"


def vector(components: list[float], unit: str) -> str:
    """Writes a vector's components with one prefix; those within rounding of the largest are 0."""
    parts = np.array(components)
    parts[np.abs(parts) < 1e-9 * np.abs(parts).max(initial=0)] = 0
    factor, unit = prefixed(parts, unit)
    return f"({', '.join(f'{part * factor:.4g}' for part in parts)}) {unit}"


def energy_account(run: RunFolder) -> list[Table]:
    """Makes a table of gains and losses of energy; none without a summary."""
    given = run.manifest.get("energy")
    if not given:
        return []
    unit = per_depth("J", run.whole)
    foundation = given.get("foundation_at_start", 0), given.get("foundation_at_end", 0)
    terms = {"Kinetic and elastic at the start": given["kinetic_at_start"] + given["elastic_at_start"],
             "Springs of foundations at the start": foundation[0], "Obstacles with mass at the start": given.get("rigid_at_start", 0),
             "Work of the loads": given["load_work"], "Work of the control and of clamps": given["control_and_clamp_work"],
             **contact_works(given), "Dissipated by viscosity": -given["viscous_dissipation"],
             "Dissipated by dashpots of foundations": -given.get("foundation_dissipation", 0),
             "Dissipated by mass damping": -given.get("drag_dissipation", 0),
             "Dissipated by relaxation": -given.get("relaxation_dissipation", 0),
             "Dissipated by dashpots of obstacles": -given.get("rigid_dissipation", 0),
             "Obstacles with mass at the end": -given.get("rigid_at_end", 0),
             "Springs of foundations at the end": -foundation[1], "Branches at the end": -given.get("relaxation_at_end", 0),
             "Kinetic and elastic at the end": given["kinetic_at_end"] + given["elastic_at_end"]}  # fmt: skip
    factor, unit = prefixed(np.array(list(terms.values())), unit)
    rounding = 1e-12 * max(abs(value) for value in terms.values())
    rows = [[name, f"{value * factor:.4g}"] for name, value in terms.items() if abs(value) > rounding or name.startswith("Kinetic")]
    return [Table("Energy account: the last line is the sum of the lines above", ["Energy", unit], rows)]


def contact_works(given: dict) -> dict[str, float]:
    """Returns the work of contact; with friction that along the normals, that of friction by slip, and that of surfaces that move along
    themselves."""
    if "friction_work" not in given:
        return {"Work of contact": given["contact_work"]}
    friction, belts = given["friction_work"], given["belt_work"]
    return {"Work of contact along the normals": given["contact_work"] - friction - belts, "Work of friction": friction,
            "Work of moving surfaces": belts}  # fmt: skip
