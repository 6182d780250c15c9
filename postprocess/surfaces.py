# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces as triangles: zeros of values at the corners of tetrahedra, and the drawn part of an obstacle."""

import numpy as np

from .obstacles import Facets, Obstacle, normals


def zeros(cells: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Finds the zeros of values at nodes, linear in tetrahedra (cells × 4, node numbers).

    Returns the two nodes between which each point is (points × 2), the second one's weight, and triangles of these points.
    """
    cells = cells[np.isfinite(values[cells]).all(axis=1)]
    low = values[cells] < 0
    count = low.sum(axis=1)
    # Each tetrahedron's corners with those below zero first.
    ordered = np.take_along_axis(cells, np.argsort(~low, axis=1, kind="stable"), axis=1)
    one, two, three = (ordered[count == below] for below in (1, 2, 3))
    corners = np.concatenate([one[:, [[0, 1], [0, 2], [0, 3]]], three[:, [[0, 3], [1, 3], [2, 3]]],
                              two[:, [[0, 2], [0, 3], [1, 3]]], two[:, [[0, 2], [1, 3], [1, 2]]]])  # fmt: skip
    pairs, number = np.unique(np.sort(corners.reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    first, second = values[pairs].T
    return pairs, first / (first - second), number.reshape(-1, 3)


def between(pairs: np.ndarray, weight: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Interpolates nodal values linearly to points between pairs of nodes. `weight`: weight of the second node of each pair."""
    first, second = values[pairs[:, 0]], values[pairs[:, 1]]
    return first + weight.reshape(-1, *[1] * (values.ndim - 1)) * (second - first)


def facing(triangles: np.ndarray, points: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Turns triangles counterclockwise as seen against a direction, one for all or one for each."""
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    turned = (np.cross(b - a, c - a) * way).sum(axis=1) < 0
    return np.where(turned[:, None], triangles[:, ::-1], triangles)


def seen_of(obstacle: Obstacle, time: float, depth: float) -> Facets:
    """Returns the drawn part of an obstacle as triangles: in the plane a band of this depth (m) below the curve, in space its surface."""
    points, facets = obstacle.at(time)
    return band(points, facets, depth, obstacle.whole, obstacle.half) if points.shape[1] == 2 else (points, facets)


def band(line: np.ndarray, segments: np.ndarray, depth: float, whole: bool, half: bool = False) -> Facets:
    """Returns a strip below a curve, whose points come first; if the curve is whole and closes around the obstacle, all that is
    inside. `half`: the curve ends at the axis x = 0."""
    outwards = normals(line, segments)
    middle = line.mean(axis=0) if len(line) else np.zeros(2)
    if half:
        middle[0] = 0
    if whole and (((line[segments].mean(axis=1) - middle) * outwards).sum(axis=1) > 0).all():
        return np.vstack([line, middle]), np.column_stack([segments, np.full(len(segments), len(line))])
    # A point's normal is the mean of its segments'.
    way = np.zeros_like(line)
    np.add.at(way, segments, outwards[:, None])
    under = line - depth * way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12)
    below = segments + len(line)
    quads = np.concatenate([np.column_stack([segments, below[:, 0]]), np.column_stack([segments[:, 1], below[:, 1], below[:, 0]])])
    return np.vstack([line, under]), quads
