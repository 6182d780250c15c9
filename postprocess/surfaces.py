# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces as triangles: where values at the corners of tetrahedra change their sign, and what is drawn of an obstacle."""

import numpy as np
from contourpy import contour_generator

from obstacles import HalfSpace, Round, Shape, normals

GRID = 160, 40  # cells along the longest side, in the plane and in space
COARSE = 80, 16  # of a surface that changes from frame to frame
SIXTHS = np.array([[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]])  # of a cube, whose
# corner 4i + 2j + k is the one at (i, j, k)

Triangles = tuple[np.ndarray, np.ndarray]  # points n × dim, m, and their numbers in each triangle


def zeros(cells: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where values at nodes, linear in tetrahedra (cells × 4, node numbers), are zero.

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
    """Values at nodes, carried to points between two of them."""
    first, second = values[pairs[:, 0]], values[pairs[:, 1]]
    return first + weight.reshape(-1, *[1] * (values.ndim - 1)) * (second - first)


def facing(triangles: np.ndarray, points: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Triangles turned counterclockwise as seen against a direction, one or that of each."""
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    turned = (np.cross(b - a, c - a) * way).sum(axis=1) < 0
    return np.where(turned[:, None], triangles[:, ::-1], triangles)


def grid(low: np.ndarray, high: np.ndarray, most: int) -> tuple[list[np.ndarray], np.ndarray]:
    """Coordinates along each axis of a box, and all points, the last axis' coordinate changing first."""
    cell = (high - low).max() / most
    axes = [np.linspace(a, b, max(2, round((b - a) / cell)) + 1) for a, b in zip(low, high)]
    return axes, np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(low))


def tetrahedra(shape: tuple[int, ...]) -> np.ndarray:
    """Those into which the cubes of a grid of so many points fall."""
    number = np.arange(np.prod(shape)).reshape(shape)
    cubes = np.stack([number[i: i + shape[0] - 1, j: j + shape[1] - 1, k: k + shape[2] - 1].ravel()
                      for i in (0, 1) for j in (0, 1) for k in (0, 1)], axis=1)  # fmt: skip
    return cubes[:, SIXTHS].reshape(-1, 4)


def seen_of(shape: Shape, time: float, box: np.ndarray, depth: float, changes: bool) -> Triangles:
    """What is drawn of an obstacle within a box (two corners): in the plane a band of this depth (m), in space its surface."""
    dim = box.shape[1]
    if isinstance(shape, HalfSpace):
        return plane(shape, time, box, depth)
    if (extent := shape.extent(time)) is not None:
        margin = 0.05 * np.array([[-1], [1]]) * shape.radius.at(time)
        box = np.array([np.maximum(box[0], (extent + margin)[0]), np.minimum(box[1], (extent + margin)[1])])
        if (box[0] >= box[1]).any():
            return np.empty((0, dim)), np.empty((0, 3), int)
    if dim == 2:
        return band(shape, time, box, depth, (COARSE if changes else GRID)[0])
    axes, points = grid(*box, (COARSE if changes else GRID)[1])
    pairs, weight, faces = zeros(tetrahedra(tuple(map(len, axes))), shape.height(points, time))
    surface = between(pairs, weight, points)
    return surface, facing(faces, surface, normals(shape, surface[faces].mean(axis=1), time, 1e-4 * (box[1] - box[0]).max()))


def plane(shape: HalfSpace, time: float, box: np.ndarray, depth: float) -> Triangles:
    """A strip below the line, in space a rectangle in the plane, as far as the box reaches."""
    point, normal = shape.point.at(time), shape.normal
    dim = len(normal)
    corners = box[[[i >> axis & 1 for axis in range(dim)] for i in range(2**dim)], range(dim)] - point
    across = [np.array([normal[1], -normal[0]])] if dim == 2 else plane_axes(normal)
    sides = [((corners @ axis).min(), (corners @ axis).max()) for axis in across]
    if dim == 2:
        across, sides = [*across, normal], [*sides, (-depth, 0.0)]
    (left, right), (low, high) = sides
    rectangle = np.array([[left, low], [right, low], [right, high], [left, high]])
    return point + rectangle @ np.array(across), np.array([[0, 1, 2], [0, 2, 3]])


def plane_axes(normal: np.ndarray) -> list[np.ndarray]:
    """Two unit vectors along a plane in space."""
    across = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    across /= np.linalg.norm(across)
    return [across, np.cross(normal, across)]


def band(shape: Shape, time: float, box: np.ndarray, depth: float, cells: int) -> Triangles:
    """A strip below a curve; all of a disc that is not much larger than the picture."""
    (x, y), points = grid(*box, cells)
    if isinstance(shape, Round) and shape.sign > 0 and (radius := float(shape.radius.at(time))) < (box[1] - box[0]).max():
        depth = radius
    heights = np.ma.masked_invalid(shape.height(points, time).reshape(len(x), len(y)))
    parts, faces, count = [], [], 0
    for line in contour_generator(x, y, heights.T).lines(0.0):
        under = line - depth * normals(shape, line, time, 1e-4 * (box[1] - box[0]).max())
        first = count + np.arange(len(line) - 1)
        faces += [np.stack([first, first + 1, first + len(line)], axis=1),
                  np.stack([first + 1, first + len(line) + 1, first + len(line)], axis=1)]  # fmt: skip
        parts += [line, under]
        count += 2 * len(line)
    return (np.concatenate(parts), np.concatenate(faces)) if parts else (np.empty((0, 2)), np.empty((0, 3), int))
