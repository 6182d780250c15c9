# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh of a body and fields on it over time."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .files import read_dataset


@dataclass(frozen=True)
class Mesh:
    """Nodes (n × dim, m) and cells (triangles or tetrahedra, by their node numbers) of the undeformed body."""

    points: np.ndarray
    cells: np.ndarray

    @property
    def size(self) -> float:
        """Longest side of the box around the body, m."""
        return float(np.ptp(self.points, axis=0).max())

    def outline(self) -> np.ndarray:
        """Returns the boundary edges of a plane body, which belong to one triangle only (edges × 2, node numbers)."""
        return self._edges()[0]

    def loops(self) -> list[np.ndarray]:
        """Returns the closed boundary lines of a plane body: for each the node numbers in order, with the first node repeated at the end."""
        beside: dict[int, list[int]] = {}
        for a, b in self.outline().tolist():
            beside.setdefault(a, []).append(b)
            beside.setdefault(b, []).append(a)
        found = []
        while beside:
            line = [min(beside)]
            while line[-1] in beside:
                here = line[-1]
                line.append(beside[here].pop())
                beside[line[-1]].remove(here)
                for node in {here, line[-1]}:
                    if not beside[node]:
                        del beside[node]
            found.append(np.array(line))
        return found

    def surface(self) -> tuple[np.ndarray, np.ndarray]:
        """Returns the triangles of the boundary of tetrahedra (triangles × 3, node numbers), counterclockwise from outside, and
        the cell of each."""
        faces = self.cells[:, [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]].reshape(-1, 3)
        _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        outer = first[count == 1]
        a, b, c = np.moveaxis(self.points[faces[outer]], 1, 0)
        inside = self.points[self.cells[outer // 4]].mean(axis=1)
        inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), inside - a) > 0
        return np.where(inwards[:, None], faces[outer][:, ::-1], faces[outer]), outer // 4

    def facets(self) -> tuple[np.ndarray, np.ndarray]:
        """Returns the boundary facets of the body (edges in the plane, triangles in space), and the cell that each belongs to."""
        return self._edges() if self.points.shape[1] == 2 else self.surface()

    def _edges(self) -> tuple[np.ndarray, np.ndarray]:
        edges = np.sort(self.cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        distinct, first, count = np.unique(edges, axis=0, return_index=True, return_counts=True)
        return distinct[count == 1], first[count == 1] // 3

    def mirrored(self) -> tuple["Mesh", np.ndarray]:
        """Returns a half section, x ≥ 0, joined with its mirror image, and the half's node for each node; those off the axis come
        again as the image's."""
        count, off = len(self.points), np.flatnonzero(self.off_axis())
        image = np.arange(count)
        image[off] = count + np.arange(len(off))
        source = np.append(np.arange(count), off)
        points = self.points[source]
        points[count:, 0] *= -1
        return Mesh(points, np.concatenate([self.cells, image[self.cells[:, ::-1]]])), source

    def rim(self) -> np.ndarray:
        """Returns the boundary edges of a half section, x ≥ 0, that are not on the axis, with the body to their left."""
        edges, cells = self._edges()
        a, b, inside = self.points[edges[:, 0]], self.points[edges[:, 1]], self.points[self.cells[cells]].mean(axis=1)
        left = (b - a)[:, 0] * (inside - a)[:, 1] > (b - a)[:, 1] * (inside - a)[:, 0]
        return np.where(left[:, None], edges, edges[:, ::-1])[self.off_axis()[edges].any(axis=1)]

    def off_axis(self) -> np.ndarray:
        """Flags the nodes of a half section that are not on the axis x = 0."""
        return self.points[:, 0] > 1e-9 * self.size

    def boundary_nodes(self) -> np.ndarray:
        """Returns the node numbers of the boundary, ascending."""
        return np.unique(self.facets()[0])


@dataclass(frozen=True)
class Series:
    """Field over time, with a value for each node or, if `cellwise`, for each cell: mesh, stored times (s), and file and dataset of
    each time's values."""

    mesh: Mesh
    times: np.ndarray
    datasets: list[tuple[Path, str]]
    cellwise: bool

    def at(self, index: int) -> np.ndarray:
        """Returns the vectors of the field at times[index] (nodes or cells × dim)."""
        # Functions are padded with zeros to three components in the file.
        return self.components(index)[:, : self.mesh.points.shape[1]]

    def components(self, index: int) -> np.ndarray:
        """Returns all components in the file at times[index], nodes or cells × 1, 3 or, row by row, 9."""
        values = read_dataset(*self.datasets[index])
        return values.reshape(len(values), -1)

    def values(self, index: int) -> np.ndarray:
        """Returns the values at times[index], nodes or cells × 1, dim or, of a tensor, 3 × 3."""
        values = self.components(index)
        if values.shape[1] == 9:
            return values.reshape(-1, 3, 3)
        return values[:, : self.mesh.points.shape[1]] if values.shape[1] == 3 else values
