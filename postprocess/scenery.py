# SPDX-License-Identifier: GPL-3.0-or-later
"""Obstacles beside a body whose displacements are drawn enlarged.

The gap of the candidate nearest to an obstacle is enlarged with the displacements, and so is the obstacle's motion: this
candidate is seen to touch when it does. A curved body or obstacle may seem to overlap beside it.
"""

from dataclasses import dataclass

import numpy as np

from mesh import Mesh
from obstacles import Obstacle, normals
from run_folder import RunFolder
from surfaces import Triangles, seen_of

BAND = 0.06  # thickness of what is drawn of an obstacle in the plane, as a part of the body's size
WHOLE = 2.5  # an obstacle up to so many times as large as the body is drawn whole
NEAR = 0.25  # where it comes as near as this, likewise
MARGIN = 0.1  # of a picture around the body, likewise
SPACING = 1e-4  # of differences, likewise


@dataclass(frozen=True)
class Scenery:
    """An obstacle over the frames of a picture: which of `shapes` is seen in each frame, and how far off (frames × dim, m)."""

    name: str
    shapes: list[Triangles]
    shape: list[int]
    offset: np.ndarray


def drawn_obstacles(run: RunFolder, mesh: Mesh, enlarged: float) -> list[Obstacle]:
    """Those of a run as they are drawn beside displacements so many times as large."""
    found = []
    for i, obstacle in enumerate(run.obstacles):
        points = candidates(run, i, mesh)
        height = obstacle.shape.height(points, 0.0)
        closest = int(np.argmin(height))
        way = normals(obstacle.shape, points[[closest]], 0.0, SPACING * mesh.size)[0]
        found.append(Obstacle(obstacle.name, obstacle.shape.drawn(enlarged, (1 - enlarged) * height[closest] * way)))
    return found


def candidates(run: RunFolder, obstacle: int, mesh: Mesh) -> np.ndarray:
    """Places of those of an obstacle that ever touch it, of all of them if none does, of the mesh's nodes if no table tells, m."""
    if not run.has_contact_table:
        return mesh.points
    contact = run.contact.of(obstacle)
    pushed = contact.force.any(axis=0)
    return contact.points[pushed] if pushed.any() else contact.points


def scenery(obstacles: list[Obstacle], times: np.ndarray, position: np.ndarray, size: float) -> tuple[list[Scenery], np.ndarray]:
    """What is seen of obstacles near a body (frames × nodes × dim), and the box (two corners) that holds it all."""
    near = [obstacle for obstacle in obstacles if comes_near(obstacle, times, position, size)]
    box = picture(near, times, position, size)
    return [over_frames(obstacle, times, box, size) for obstacle in near], box


def comes_near(obstacle: Obstacle, times: np.ndarray, position: np.ndarray, size: float) -> bool:
    """Whether any node ever is within the body's size of the obstacle."""
    shown = range(0, len(times), max(1, len(times) // 20))
    return any(obstacle.shape.height(position[i], times[i]).min() < size for i in shown)


def picture(obstacles: list[Obstacle], times: np.ndarray, position: np.ndarray, size: float) -> np.ndarray:
    """Two corners of the box that holds the body at all times, a margin, and obstacles of the body's size while they are near."""
    low, high = (end(position.reshape(-1, position.shape[2]), axis=0) for end in (np.min, np.max))
    box = np.array([low - MARGIN * size, high + MARGIN * size])
    for obstacle in obstacles:
        for i, time in enumerate(times):
            extent = obstacle.shape.extent(time)
            if extent is None or not (np.ptp(extent, axis=0) <= WHOLE * size).all():
                break
            if obstacle.shape.height(position[i], time).min() < NEAR * size:
                box = np.array([np.minimum(box[0], extent[0] - BAND * size), np.maximum(box[1], extent[1] + BAND * size)])
    return box


def over_frames(obstacle: Obstacle, times: np.ndarray, box: np.ndarray, size: float) -> Scenery:
    """One shape for an obstacle that keeps it, else one for each frame."""
    shape, count, depth = obstacle.shape, len(times), BAND * size
    still = np.zeros((count, box.shape[1]))
    if not shape.moves:
        return Scenery(obstacle.name, [seen_of(shape, 0.0, box, depth, False)], [0] * count, still)
    if not shape.rigid:
        return Scenery(obstacle.name, [seen_of(shape, time, box, depth, True) for time in times], list(range(count)), still)
    travel = np.stack([shape.travel(time) for time in times])
    # That of the frame in which the most of it is in the picture.
    main = middle_frame(shape, times, box)
    points, faces = seen_of(shape, times[main], box, depth, False)
    return Scenery(obstacle.name, [(points, faces)], [0] * count, travel - travel[main])


def middle_frame(shape: object, times: np.ndarray, box: np.ndarray) -> int:
    """The frame in which the obstacle is nearest to the middle of the box."""
    middle = box.mean(axis=0, keepdims=True)
    return int(np.argmin([abs(shape.height(middle, time)[0]) for time in times]))


def main_normal(run: RunFolder) -> np.ndarray:
    """The direction out of a plane; of another obstacle, or of several, the axis next to that where the body is pushed the most.
    Raises NotInRun where no table tells."""
    if (plane := run.half_space) is not None:
        return plane.normal
    way = directions(run)[run.contact.most_pushed]
    axis = int(np.argmax(np.abs(way)))
    return np.sign(way[axis]) * np.eye(len(way))[axis]


def directions(run: RunFolder) -> np.ndarray:
    """Directions in which obstacles push candidates (candidates × dim): those that the run wrote, else those at the start."""
    contact = run.contact
    if contact.normal is not None:
        return contact.normal
    found, size = np.zeros_like(contact.points), float(np.ptp(contact.points, axis=0).max())
    for i, obstacle in enumerate(run.obstacles):
        own = contact.obstacle == i
        found[own] = normals(obstacle.shape, contact.points[own], 0.0, SPACING * size)
    return found
