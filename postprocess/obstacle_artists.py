# SPDX-License-Identifier: GPL-3.0-or-later
"""Obstacles in a picture of matplotlib: in the plane what is inside of them, in space their surfaces seen from the side."""

import numpy as np
from contourpy import contour_generator
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from obstacles import Course, HalfSpace, Obstacle, Shape
from scenery import over_frames
from surfaces import GRID, grid
from view import View

GREY = "0.85"
ON_EDGE = 0.02  # a plane that leans no more than this from the line of sight is drawn as a line


class Inside:
    """The part of a plane picture that is inside of an obstacle."""

    def __init__(self, axes: Axes, shape: Shape) -> None:
        self.shape, self.moves = shape, shape.moves
        low, high = np.transpose([axes.get_xlim(), axes.get_ylim()])
        (self.x, self.y), self.points = grid(low, high, GRID[0])
        self.fill = axes.add_patch(PathPatch(Path(np.empty((0, 2))), color=GREY, linewidth=0, zorder=0.5))
        self.line = axes.add_collection(LineCollection([], colors="0.4", linewidths=1, zorder=0.6), autolim=False)
        self.artists: list[Artist] = [self.fill, self.line]

    def place(self, frame: int, time: float) -> None:
        height = np.ma.masked_invalid(self.shape.height(self.points, time).reshape(len(self.x), len(self.y)).T)
        contours = contour_generator(self.x, self.y, height, fill_type="OuterCode")
        points, codes = contours.filled(min(height.min() - 1, -1), 0.0)
        self.fill.set_path(Path(np.concatenate(points), np.concatenate(codes)) if points else Path(np.empty((0, 2))))
        self.line.set_segments(contours.lines(0.0))


class Surface:
    """The surface of an obstacle in space, seen from the side."""

    def __init__(self, axes: Axes, obstacle: Obstacle, view: View, times: np.ndarray, box: np.ndarray, size: float) -> None:
        self.scenery, self.view, self.moves = over_frames(obstacle, times, box, size), view, obstacle.shape.moves
        self.faces = axes.add_collection(PolyCollection([], zorder=0.5), autolim=False)
        self.artists: list[Artist] = [self.faces]

    def place(self, frame: int, time: float) -> None:
        points, faces = self.scenery.shapes[self.scenery.shape[frame]]
        points = points + self.scenery.offset[frame]
        to_viewer = np.cross(*self.view.axes)
        corners = points[faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        size = np.linalg.norm(normals, axis=1)
        shade = np.divide(np.abs(normals @ to_viewer), size, out=np.zeros_like(size), where=size > 0)
        order = np.argsort(corners.mean(axis=1) @ to_viewer)
        self.faces.set_verts(self.view.project(corners[order]))
        # Lighter where it faces the viewer.
        colours = to_rgb(GREY) * (0.75 + 0.25 * shade[order])[:, None]
        self.faces.set(facecolors=colours, edgecolors=colours, linewidths=0.3)


def obstacle_artists(axes: Axes, obstacles: list[Obstacle], view: View, times: np.ndarray, box: np.ndarray,
                     size: float) -> list[Inside | Surface]:
    """One for each obstacle; `box` holds what is seen of surfaces in space (two corners, m)."""
    return [Inside(axes, on_paper(obstacle.shape, view)) if is_flat(obstacle.shape, view)
            else Surface(axes, obstacle, view, times, box, size) for obstacle in obstacles]  # fmt: skip


def is_flat(shape: Shape, view: View) -> bool:
    """Whether an obstacle is the same all along the line of sight."""
    return view.axes.shape[1] == 2 or (isinstance(shape, HalfSpace) and np.linalg.norm(view.project(shape.normal)) > 1 - ON_EDGE)


def on_paper(shape: Shape, view: View) -> Shape:
    """An obstacle that is_flat() in the picture."""
    if view.axes.shape[1] == 2:
        return shape
    normal = view.project(shape.normal)
    return HalfSpace(Course(lambda time: view.project(shape.point.at(time)), shape.moves), normal / np.linalg.norm(normal))
