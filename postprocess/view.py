# SPDX-License-Identifier: GPL-3.0-or-later
"""Projection of a body onto paper: a plane one as it is, one in space as seen from the side.

The line of sight of the side view lies in the plane in which the obstacle touches the most, which then appears as a line. It is as
level as that allows: the vertical axis is z.
"""

from dataclasses import dataclass

import numpy as np

from .files import NotInRun
from .mesh import Mesh
from .run_folder import RunFolder
from .scenery import main_normal


@dataclass(frozen=True)
class View:
    """Axes of the picture (2 × dim): unit vectors to the right and upwards, and their names."""

    axes: np.ndarray
    names: tuple[str, str]

    def project(self, x: np.ndarray) -> np.ndarray:
        """Returns vectors (… × dim) in the picture's coordinates (… × 2)."""
        return x @ self.axes.T

    def seen(self, mesh: Mesh) -> tuple[Mesh, np.ndarray]:
        """Returns the mesh on paper, in space those triangles of the surface that face the viewer, the farthest first; and the
        body's cell that each triangle shows.

        The mesh has all nodes of the body, so that nodal values keep their places.
        """
        if self.axes.shape[1] == 2:
            return mesh, np.arange(len(mesh.cells))
        to_viewer = np.cross(*self.axes)
        surface, cells = mesh.surface()
        corners = mesh.points[surface]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        facing = normals @ to_viewer > 1e-9 * np.linalg.norm(normals, axis=1)
        order = np.argsort(corners[facing].mean(axis=1) @ to_viewer)
        return Mesh(self.project(mesh.points), surface[facing][order]), cells[facing][order]


def longer_side(run: RunFolder) -> np.ndarray:
    """Returns the x axis, or the y axis if the body is longer along it."""
    for file, name in (("state", "displacement"), ("control", "control")):
        try:
            x, y, _ = np.ptp(run.field(file, name).mesh.points, axis=0)
            return np.eye(3)[int(y > 1.1 * x)]
        except NotInRun:
            continue
    return np.eye(3)[0]


def view_of(run: RunFolder) -> View:
    """Returns the view of a run's body."""
    if run.dim == 2:
        return View(np.eye(2), ("radius", "height") if run.axisymmetric else ("$x$", "$y$"))
    up = np.array([0.0, 0.0, 1.0])
    horizontal = longer_side(run)
    try:
        tilt = main_normal(run)[:2] if run.has_contact else np.zeros(2)
    except NotInRun:
        tilt = np.zeros(2)
    if np.linalg.norm(tilt) > 1e-9:
        horizontal[:2] = tilt / np.linalg.norm(tilt)
        horizontal *= 1 if horizontal[np.argmax(abs(horizontal))] > 0 else -1
    name = next((f"${axis}$" for axis, part in zip("xy", horizontal) if part > 1 - 1e-9), "horizontal")
    return View(np.stack([horizontal, up]), (name, "$z$"))
