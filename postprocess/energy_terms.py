# SPDX-License-Identifier: GPL-3.0-or-later
"""The terms of the energy account over the steps of a run; J, or J/m in plane strain and plane stress."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .run_folder import RunFolder

Columns = Mapping[str, np.ndarray]
DISSIPATION = ("viscous_dissipation", "foundation_dissipation", "drag_dissipation", "relaxation_dissipation", "rigid_dissipation")
ROUNDING = 1e-12  # relative to the largest energy
# Columns of energies that only runs with the effect have, and the names of their curves.
FURTHER = {"foundation_energy": "foundations", "relaxation_energy": "branches", "rigid_energy": "obstacles"}


def stored_energy(steps: Columns) -> np.ndarray:
    """Returns the kinetic and elastic energy at every time step, those of foundations, of branches that relax and of obstacles with mass included."""
    return steps["kinetic_energy"] + steps["elastic_energy"] + sum(further_energies(steps).values())


def further_energies(steps: Columns) -> dict[str, np.ndarray]:
    """Returns the energies of foundations, of branches and of obstacles with mass at every time step, by the names of their curves; only those that the run has."""
    return {name: steps[column] for column, name in FURTHER.items() if column in steps}


def dissipated_so_far(steps: Columns) -> np.ndarray:
    """Returns the energy dissipated until every time step by viscosity, dashpots, mass damping and relaxation."""
    return np.cumsum(sum(steps[name] for name in DISSIPATION if name in steps))


def works_of_friction(steps: Columns) -> dict[str, np.ndarray]:
    """Returns the energy lost to friction and the work of surfaces that move along themselves until every time step, by the names of
    their curves; only those that rounding does not explain."""
    columns = {"lost to friction so far": ("friction_work", -1), "work of moving surfaces so far": ("belt_work", 1)}
    works = {name: sign * np.cumsum(steps[column]) for name, (column, sign) in columns.items() if column in steps}
    return {name: work for name, work in works.items() if np.abs(work).max() > ROUNDING * stored_energy(steps).max()}


def work_of_others(run: "RunFolder") -> np.ndarray | None:
    """Returns the work of a control and of moving clamps until every time step; None if rounding explains it or the run did not write it."""
    steps, effects = run.steps, run.entry(lambda: run.manifest["effects"])
    loads = any(effects.get(name) for name in ("body load", "gravity", "traction", "point force"))
    if not (effects["control"] or effects["moving clamp"]) or (loads and "load_work" not in steps):
        return None
    work = np.cumsum(steps["external_work"] - steps.get("load_work", 0.0))
    return work if np.abs(work).max() > ROUNDING * stored_energy(steps).max() else None


def potential_of_loads(steps: Columns) -> np.ndarray | None:
    """Returns the potential energy of the scene's loads at every time step, 0 at its least; None if they do no work or the run did
    not write it."""
    work = np.cumsum(steps.get("load_work", 0.0))
    return work.max() - work if np.any(work) else None
