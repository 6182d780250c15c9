# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigid obstacles over time, as a run wrote their surfaces in surfaces.h5.

Lengths in m, times in s, points n × dim.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import h5py
import numpy as np

Facets = tuple[np.ndarray, np.ndarray]  # points n × dim, m, and their numbers in each segment or triangle


@dataclass(frozen=True)
class Obstacle:
    """Surface of an obstacle, segments in the plane, or of the half section in axial symmetry, and triangles in space: its points
    at the start and, if it moves, their displacements at each stored time (times × n × dim). If it changes its shape, each time has
    points and facets of its own, which begin at `first_point` and `first_facet` (times + 1).

    `flat`: a plane; `whole`: no part of it was left out. `gap`: gaps of its candidates in the undeformed body at the start (m);
    `normal`: directions out of the obstacle there (m × dim). `half`: the points are a half section, x ≥ 0, of an obstacle of
    revolution; `mirrored`: both halves of it are drawn."""

    name: str
    flat: bool
    whole: bool
    gap: np.ndarray
    normal: np.ndarray
    times: np.ndarray
    points: np.ndarray
    facets: np.ndarray
    displacement: np.ndarray | None = None
    first_point: np.ndarray | None = None
    first_facet: np.ndarray | None = None
    enlarged: float = 1.0
    shift: np.ndarray | float = 0.0
    half: bool = False
    mirrored: bool = False

    @property
    def moves(self) -> bool:
        return self.displacement is not None

    @property
    def rigid(self) -> bool:
        """Whether all points of the obstacle have the same displacement at each time."""
        return not self.moves or (self.first_point is None and bool(np.allclose(np.ptp(self.displacement, axis=1), 0)))

    def at(self, time: float) -> Facets:
        """Returns the surface at the stored time nearest to `time` (s)."""
        return both_halves(*self.own(time)) if self.mirrored else self.own(time)

    def own(self, time: float) -> Facets:
        """Returns the surface at that time as the run wrote it, without a mirror image."""
        if not self.moves:
            return self.points + self.shift, self.facets
        index = int(np.argmin(np.abs(self.times - time)))
        if self.first_point is None:
            return self.points + self.shift + self.enlarged * self.displacement[index], self.facets
        (start, end), (first, last) = self.first_point[index: index + 2], self.first_facet[index: index + 2]
        return self.points[start:end] + self.shift + self.enlarged * self.displacement[start:end], self.facets[first:last]

    def travel(self, time: float) -> np.ndarray:
        """Returns the displacement of a rigid obstacle."""
        if not self.moves or not len(self.points):
            return np.zeros(self.points.shape[1])
        return self.enlarged * self.displacement[int(np.argmin(np.abs(self.times - time))), 0]

    def drawn(self, enlarged: float, shift: np.ndarray) -> "Obstacle":
        """Returns the obstacle moved by `shift`, with its motion enlarged by a factor."""
        return replace(self, enlarged=enlarged, shift=shift)


def read_obstacles(file: Path, names: list[str], half: bool) -> list[Obstacle]:
    """Reads the obstacles of a run, which have these names; `half`: their half sections. Raises OSError, ValueError where the file is
    damaged."""
    try:
        with h5py.File(file, "r") as data:
            times = data["times"][()]
            return [read_obstacle(data[str(i)], name, times, half) for i, name in enumerate(names, 1)]
    except KeyError as missing:
        raise ValueError(f"it lacks {missing}") from None


def read_obstacle(group: h5py.Group, name: str, times: np.ndarray, half: bool) -> Obstacle:
    found = {key: dataset[()] for key, dataset in group.items()}
    flags = {"flat": bool(found["flat"][0]), "whole": bool(found["whole"][0]), "half": half}
    return Obstacle(**found | flags | {"name": name, "times": times})


def both_halves(points: np.ndarray, segments: np.ndarray) -> Facets:
    """Returns a half section, x ≥ 0, and its mirror image, whose segments are turned such that their normals point outwards too."""
    image = segments[:, ::-1] + len(points)
    return np.concatenate([points, points * [-1, 1]]), np.concatenate([segments, image])


def normals(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Returns the unit normals of the facets, which point out of the obstacle."""
    sides = points[facets[:, 1:]] - points[facets[:, :1]]
    way = sides[:, 0] @ np.array([[0.0, 1], [-1, 0]]) if points.shape[1] == 2 else np.cross(sides[:, 0], sides[:, 1])
    size = np.linalg.norm(way, axis=1, keepdims=True)
    return np.divide(way, size, out=np.zeros_like(way), where=size > 0)
