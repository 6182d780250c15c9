# SPDX-License-Identifier: GPL-3.0-or-later
"""Force of friction of each obstacle at every time step, and the bound that Coulomb's law gives it."""

from dataclasses import dataclass

import numpy as np

from .files import NotInRun
from .run_folder import RunFolder


@dataclass(frozen=True)
class FrictionForce:
    """Contact with a frictional obstacle at every time step, N or N/m (RunFolder.whole): the sum of the moduli of the normal nodal
    forces (steps), the sum of the friction forces (steps × 1, in the plane along the tangents, or steps × 3), and the coefficient of
    friction, None if it varies."""

    normal: np.ndarray
    tangential: np.ndarray
    coefficient: float | None

    @property
    def signed(self) -> bool:
        """Whether the friction force has a sign, as in the plane."""
        return self.tangential.shape[1] == 1

    def means(self) -> tuple[np.ndarray, np.ndarray]:
        """Returns the normal force and the friction force, mean of each two neighbouring steps."""
        force = (self.tangential[2:] + self.tangential[1:-1]) / 2
        return (self.normal[2:] + self.normal[1:-1]) / 2, component(force)

    def bound(self) -> np.ndarray | None:
        """Returns the bound of the mean friction forces; None if the coefficient varies."""
        return None if self.coefficient is None else self.coefficient * self.means()[0]


def component(force: np.ndarray) -> np.ndarray:
    """Returns the friction force along the tangent (of steps × 1), or its modulus."""
    return force[:, 0] if force.shape[1] == 1 else np.linalg.norm(force, axis=1)


def coefficients(run: RunFolder) -> dict[str, float | None]:
    """Returns the coefficient of each obstacle with friction by the obstacle's name; None for one that varies or is fitted, and for a
    bound of the traction."""
    given = run.scene.get("contact", [])
    tables = given if isinstance(given, list) else [given]
    found = {name: table.get("friction", 0.0) for name, table in zip(run.obstacle_names, tables)}
    unknown = any(one.get("of") == "friction" for one in run.scene.get("unknown", []))  # whose start value the scene has
    return {name: None if unknown or isinstance(value, (str, dict)) else float(value) for name, value in found.items() if value != 0}


def has_friction(run: RunFolder) -> bool:
    """Whether an obstacle of the scene has friction."""
    return bool(coefficients(run))


def friction_forces(run: RunFolder) -> dict[str, FrictionForce]:
    """Returns the force of each obstacle with friction by the obstacle's name. Raises NotInRun if the run did not write the force
    along a curved obstacle at every step."""
    return {name: FrictionForce(normal_force(run, name), tangential(run, name), value) for name, value in coefficients(run).items()}


def normal_force(run: RunFolder, name: str) -> np.ndarray:
    """Returns the sum of the moduli of an obstacle's normal nodal forces at every time step."""
    if len(run.obstacle_names) == 1:
        return run.normal_force
    return run.obstacle_steps[run.obstacle_names.index(name)].normal_force


def tangential(run: RunFolder, name: str) -> np.ndarray:
    """Returns the sum of an obstacle's friction forces at every time step, of a plane obstacle from its resultant."""
    number = run.obstacle_names.index(name)
    obstacle = run.obstacles[number]
    if obstacle.flat and not run.axisymmetric:
        normal = obstacle.normal[0]
        resultant = run.resultant if len(run.obstacle_names) == 1 else run.obstacle_steps[number].resultant
        if run.dim == 2:
            return resultant @ np.array([[normal[1]], [-normal[0]]])
        return resultant - np.outer(resultant @ normal, normal)
    own = run.contact.of(number)
    if not run.stores_every_step or own.friction is None:
        raise NotInRun("the friction force along a curved obstacle is known at the stored steps only; output.every = 1 stores all")
    if run.dim == 2:
        return own.tangential_force.sum(axis=1)[:, None]
    return own.friction.force.sum(axis=1)


def slip_and_stick(run: RunFolder) -> tuple[np.ndarray, np.ndarray]:
    """Returns the numbers of candidates that slip and that stick in every time step. Raises NotInRun without friction."""
    if "slip" not in run.steps:
        raise NotInRun("no obstacle has friction")
    return run.steps["slip"], run.steps["stick"]
