# SPDX-License-Identifier: GPL-3.0-or-later
"""Obstacles beside a body whose displacements are drawn enlarged.

The gap of the candidate nearest to an obstacle is enlarged with the displacements, and so is the obstacle's motion: this
candidate touches in the picture when it does in the run. A curved body or obstacle may seem to overlap beside it.
"""

from dataclasses import dataclass

import numpy as np

from .obstacles import Facets, Obstacle
from .run_folder import RunFolder
from .surfaces import seen_of

BAND = 0.06  # thickness of a drawn obstacle in the plane, as a part of the body's size
WHOLE = 2.5  # largest size, relative to the body's, of an obstacle that a picture shows whole
NEAR = 0.25  # distance within which it is shown whole, as a part of the body's size
MARGIN = 0.1  # margin of a picture around the body, as a part of the body's size


@dataclass(frozen=True)
class Scenery:
    """Obstacle over the frames of a picture: the number of the shape in each frame, and its offset (frames × dim, m). `curves`: of
    a half section, the segments of each shape by which it is revolved."""

    name: str
    shapes: list[Facets]
    shape: list[int]
    offset: np.ndarray
    curves: list[np.ndarray]


def drawn_obstacles(run: RunFolder, enlarged: float) -> list[Obstacle]:
    """Returns the obstacles of a run as drawn beside displacements enlarged by a factor."""
    found = []
    for i, obstacle in enumerate(run.obstacles):
        shown = touching_ones(run, i, obstacle)
        closest = shown[np.argmin(obstacle.gap[shown])]
        way = obstacle.normal[closest]
        if obstacle.half and abs(way[1]) > 0.5:  # an obstacle of revolution stays on its axis
            way = np.array([0, 1 / way[1]])
        found.append(obstacle.drawn(enlarged, (1 - enlarged) * obstacle.gap[closest] * way))
    return found


def touching_ones(run: RunFolder, number: int, obstacle: Obstacle) -> np.ndarray:
    """Returns the numbers of those candidates of an obstacle that ever touch it; all if none does or contact.csv is absent."""
    everyone = np.arange(len(obstacle.gap))
    if not run.has_contact_table:
        return everyone
    pushed = run.contact.of(number).force.any(axis=0)
    return everyone[pushed] if pushed.any() else everyone


def scenery(obstacles: list[Obstacle], times: np.ndarray, position: np.ndarray, size: float) -> tuple[list[Scenery], np.ndarray]:
    """Returns the visible parts of obstacles near a body (frames × nodes × dim), and the box (two corners) of the picture."""
    near = [obstacle for obstacle in obstacles if comes_near(obstacle, times, position, size)]
    box = picture(near, times, position, size)
    return [over_frames(obstacle, times, size) for obstacle in near], box


def comes_near(obstacle: Obstacle, times: np.ndarray, position: np.ndarray, size: float) -> bool:
    """Whether any part of an obstacle, at any frame, is closer to the box around the body than the body's size."""
    shown = range(0, len(times), max(1, len(times) // 20))
    return any(within(obstacle.at(times[i]), position[i], size) for i in shown)


def within(surface: Facets, body: np.ndarray, distance: float) -> bool:
    """Whether the box around any facet is nearer than `distance` (m) to the box around the body."""
    points, facets = surface
    corners = points[facets]
    apart = np.maximum(corners.min(axis=1, initial=np.inf) - body.max(axis=0), body.min(axis=0) - corners.max(axis=1, initial=-np.inf))
    return bool((apart < distance).all(axis=1).any())


def picture(obstacles: list[Obstacle], times: np.ndarray, position: np.ndarray, size: float) -> np.ndarray:
    """Returns two corners of the box of the body at all times, a margin, and obstacles of the body's size while they are near."""
    low, high = (end(position.reshape(-1, position.shape[2]), axis=0) for end in (np.min, np.max))
    box = np.array([low - MARGIN * size, high + MARGIN * size])
    for obstacle in obstacles:
        for i, time in enumerate(times):
            points, _ = obstacle.at(time)
            if not obstacle.whole or not (np.ptp(points, axis=0) <= WHOLE * size).all():
                break
            if within(obstacle.at(time), position[i], NEAR * size):
                box = np.array([np.minimum(box[0], points.min(axis=0) - BAND * size), np.maximum(box[1], points.max(axis=0) + BAND * size)])
    return box


def over_frames(obstacle: Obstacle, times: np.ndarray, size: float) -> Scenery:
    """Returns an obstacle over frames, with one shape if it moves rigidly, else one for each frame."""
    count, depth = len(times), BAND * size
    rigid = obstacle.rigid
    shown = times[:1] if rigid else times
    shapes, curves = [seen_of(obstacle, time, depth) for time in shown], [obstacle.at(time)[1] for time in shown] if obstacle.half else []
    if not rigid:
        return Scenery(obstacle.name, shapes, list(range(count)), np.zeros((count, obstacle.points.shape[1])), curves)
    travel = np.stack([obstacle.travel(time) for time in times])
    return Scenery(obstacle.name, shapes, [0] * count, travel - travel[0], curves)


def main_normal(run: RunFolder) -> np.ndarray:
    """Returns the direction out of a plane; for another obstacle, or several, the axis nearest to that direction where the body is
    pushed the most. Raises NotInRun without contact.csv."""
    if (plane := run.plane_normal) is not None:
        return plane
    way = run.contact.normal[run.contact.most_pushed]
    axis = int(np.argmax(np.abs(way)))
    return np.sign(way[axis]) * np.eye(len(way))[axis]
