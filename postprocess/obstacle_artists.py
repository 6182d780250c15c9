# SPDX-License-Identifier: GPL-3.0-or-later
"""Obstacles in a picture of matplotlib: in the plane their insides, in space their surfaces seen from the side."""

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb

from .obstacles import Facets, Obstacle, normals
from .scenery import BAND
from .surfaces import band
from .view import View

GREY = "0.85"
ON_EDGE = 0.02  # a plane that deviates no more than this from the line of sight is drawn as a line
FAR = 10.0  # thickness of a drawn plane, relative to the body's size


class Inside:
    """Inside of an obstacle in a picture; the obstacle is the same all along the line of sight."""

    def __init__(self, axes: Axes, obstacle: Obstacle, view: View, size: float) -> None:
        self.obstacle, self.view, self.moves = obstacle, view, obstacle.moves
        self.depth = (FAR if obstacle.flat else BAND) * size
        self.fill = axes.add_collection(PolyCollection([], facecolors=GREY, edgecolors=GREY, linewidths=0.3, zorder=0.5), autolim=False)
        self.line = axes.add_collection(LineCollection([], colors="0.4", linewidths=1, zorder=0.6), autolim=False)
        self.artists: list[Artist] = [self.fill, self.line]

    def place(self, time: float) -> None:
        points, segments = self.obstacle.at(time)
        if points.shape[1] == 3:
            points, segments = on_edge(self.view.project(points), self.view.project(self.obstacle.normal[0]))
        corners, triangles = band(points, segments, self.depth, self.obstacle.whole)
        self.fill.set_verts(corners[triangles])
        self.line.set_segments(points[segments])


class Surface:
    """Surface of an obstacle in space, seen from the side."""

    def __init__(self, axes: Axes, obstacle: Obstacle, view: View) -> None:
        self.obstacle, self.view, self.moves = obstacle, view, obstacle.moves
        self.faces = axes.add_collection(PolyCollection([], zorder=0.5), autolim=False)
        self.artists: list[Artist] = [self.faces]

    def place(self, time: float) -> None:
        points, faces = self.obstacle.at(time)
        to_viewer = np.cross(*self.view.axes)
        shade = np.abs(normals(points, faces) @ to_viewer)
        corners = points[faces]
        order = np.argsort(corners.mean(axis=1) @ to_viewer)
        self.faces.set_verts(self.view.project(corners[order]))
        # Lighter where it faces the viewer.
        colours = to_rgb(GREY) * (0.75 + 0.25 * shade[order])[:, None]
        self.faces.set(facecolors=colours, edgecolors=colours, linewidths=0.3)


def obstacle_artists(axes: Axes, obstacles: list[Obstacle], view: View, size: float) -> list[Inside | Surface]:
    """Makes one artist for each obstacle."""
    return [Inside(axes, obstacle, view, size) if is_flat(obstacle, view) else Surface(axes, obstacle, view) for obstacle in obstacles]


def is_flat(obstacle: Obstacle, view: View) -> bool:
    """Whether an obstacle is the same all along the line of sight."""
    return view.axes.shape[1] == 2 or (obstacle.flat and np.linalg.norm(view.project(obstacle.normal[0])) > 1 - ON_EDGE)


def on_edge(corners: np.ndarray, normal: np.ndarray) -> Facets:
    """Reduces a plane's corners on paper to one segment, with the obstacle to its right."""
    along = corners @ np.array([normal[1], -normal[0]])
    return corners[[np.argmin(along), np.argmax(along)]], np.array([[0, 1]])
