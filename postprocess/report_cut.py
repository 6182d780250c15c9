# SPDX-License-Identifier: GPL-3.0-or-later
"""Body in space, cut open along a plane across x or y: the part of its surface beyond the plane, and the section."""

from dataclasses import dataclass, replace

import numpy as np

from .mesh import Mesh
from .surfaces import between, facing, zeros


@dataclass(frozen=True)
class Cut:
    """Points between pairs of the mesh's nodes (points × 2; weight of the second one), and triangles of the mesh's nodes and,
    numbered after them, these points. `name`: place of the plane."""

    pairs: np.ndarray
    weight: np.ndarray
    faces: np.ndarray
    count: int  # of the mesh's nodes
    name: str

    def renumbered(self, own: np.ndarray, count: int) -> "Cut":
        """Returns the cut with the nodes' new numbers `own`, of which there are `count`."""
        faces = np.where(self.faces < self.count, own[np.minimum(self.faces, self.count - 1)], self.faces - self.count + count)
        return replace(self, pairs=own[self.pairs], faces=faces, count=count)


def cut_open(mesh: Mesh, faces: np.ndarray, point: np.ndarray | None, eye: list[float]) -> Cut | None:
    """Removes the part of the body between the eye and a plane through the point, or through the middle without one. Returns None if
    the plane meets nothing."""
    axis = int(np.argmax(np.abs(eye[:2])))
    low, high = mesh.points[:, axis].min(), mesh.points[:, axis].max()
    place = (low + high) / 2 if point is None else np.clip(point[axis], *(low + np.array([0.2, 0.8]) * (high - low)))
    height = np.sign(eye[axis]) * (mesh.points[:, axis] - place)
    pairs, weight, section = zeros(mesh.cells, height)
    if not len(pairs):
        return None
    count = len(mesh.points)
    shell = clipped(faces, height, pairs, count)
    # The section has its own points, so that light does not round its edges.
    section = facing(section, between(pairs, weight, mesh.points), np.sign(eye[axis]) * np.eye(3)[axis]) + count + len(pairs)
    return Cut(np.tile(pairs, (2, 1)), np.tile(weight, 2), np.concatenate([shell, section]), count, f"{'xy'[axis]} = {place:.4g} m")


def clipped(faces: np.ndarray, height: np.ndarray, pairs: np.ndarray, count: int) -> np.ndarray:
    """Returns the parts of triangles where heights at the nodes are negative; points on edges are those of `pairs`, numbered from
    `count` on."""
    keys = pairs[:, 0] * count + pairs[:, 1]

    def edge(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return count + np.searchsorted(keys, np.minimum(a, b) * count + np.maximum(a, b))

    low = height[faces] < 0
    inside = low.sum(axis=1)
    # Turned such that the corner that differs from the two others is the first.
    first = np.where(inside == 1, np.argmax(low, axis=1), np.argmin(low, axis=1))
    a, b, c = np.take_along_axis(faces, (first[:, None] + np.arange(3)) % 3, axis=1).T
    one, two = inside == 1, inside == 2
    return np.concatenate([faces[inside == 3],
                           np.stack([a[one], edge(a[one], b[one]), edge(a[one], c[one])], axis=1),
                           np.stack([b[two], c[two], edge(a[two], c[two])], axis=1),
                           np.stack([b[two], edge(a[two], c[two]), edge(a[two], b[two])], axis=1)])  # fmt: skip
