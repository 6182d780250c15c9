# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions along the boundary of a plane body."""

from dataclasses import dataclass

import numpy as np

from .mesh import Mesh

LONGEST_BLANK = 0.3  # largest blank between two parts, relative to the length of all


@dataclass(frozen=True)
class Arc:
    """Points of the boundary from end to end: their numbers in that order, their positions (m), and the part of the boundary of
    each, numbered from 0."""

    order: np.ndarray
    position: np.ndarray
    part: np.ndarray

    def edges(self) -> np.ndarray:
        """Returns the positions (m) that bound the rows of a map: one row for each point and one between two parts."""
        middle = (self.position[1:] + self.position[:-1]) / 2
        begin, end = np.append(-np.inf, middle), np.append(middle, np.inf)
        first, last = np.append(True, np.diff(self.part) > 0), np.append(np.diff(self.part) > 0, True)
        spacing = float(np.median(np.diff(self.position))) if len(self.position) > 1 else 1.0
        # Ends reach outwards as they do inwards; an isolated point reaches as its neighbours do.
        begin = np.where(first, np.where(last, self.position - spacing / 2, 2 * self.position - end), begin)
        end = np.where(last, 2 * self.position - begin, end)
        return np.sort(np.concatenate([begin, end[last]]))

    def rows(self) -> np.ndarray:
        """Returns the row of each point."""
        found = np.empty(len(self.order), int)
        found[self.order] = np.arange(len(self.order)) + self.part
        return found


def arc_of(mesh: Mesh, points: np.ndarray, origin: int) -> Arc:
    """Orders points on the boundary, each once, from end to end; position 0 is that of the point with the number `origin`. A part
    ends where a node of the mesh that is no point lies before the next point."""
    order, position, part = [np.empty(0, int)], [np.empty(0)], [np.empty(0, int)]
    loops = mesh.loops()
    loop, along = places(mesh.points, loops, points)
    for number, nodes in enumerate(loops):
        own = np.flatnonzero(loop == number)
        if not len(own):
            continue
        own = own[np.argsort(along[own])]
        ends = np.append(0.0, lengths(mesh.points[nodes]).cumsum())
        length, at = ends[-1], along[own]
        begins = breaks(at, ends, length)
        if not begins.any():
            begins[(np.argmin(np.abs(own - origin)) + len(own) // 2 + 1) % len(own) if origin in own else 0] = True
        start = np.flatnonzero(begins)[0]
        own, at, begins = np.roll(own, -start), (np.roll(at, -start) - at[start]) % length, np.roll(begins, -start)
        if tuple(points[own[0]]) > tuple(points[own[-1]]):  # the end with the smaller x comes first
            own, at, begins = own[::-1], at[-1] - at[::-1], np.append(True, begins[:0:-1])
        order.append(own)
        position.append(at)
        part.append(np.cumsum(begins))
    return joined(points, order, position, part, origin)


def joined(points: np.ndarray, order: list[np.ndarray], position: list[np.ndarray], part: list[np.ndarray], origin: int) -> Arc:
    """Joins the parts of loops one behind the other, at their distances but at most LONGEST_BLANK."""
    numbers = np.concatenate(order)
    loop = np.repeat(np.arange(len(order)), [len(own) for own in order])
    steps, apart = np.diff(np.concatenate(position)), np.linalg.norm(np.diff(points[numbers], axis=0), axis=1)
    jumps = (np.diff(np.concatenate(part)) != 0) | (np.diff(loop) != 0)
    steps = np.where(np.diff(loop) != 0, apart, steps)
    length = steps[~jumps].sum() or apart.max(initial=0.0)
    steps = np.where(jumps, np.minimum(apart, LONGEST_BLANK * length), steps)
    along = np.append(0.0, steps.cumsum())
    return Arc(numbers, along - along[numbers == origin], np.append(0, jumps.cumsum()))


def breaks(at: np.ndarray, ends: np.ndarray, length: float) -> np.ndarray:
    """Flags the points at which a part begins: those with a node before them that is no point. `at`: places of the points along a
    closed line, ascending; `ends`: those of the nodes, the first one's twice."""
    hair = 1e-9 * length
    previous = np.roll(at, 1) - np.where(np.arange(len(at)) == 0, length, 0)
    nodes = np.concatenate([ends[:-1] - length, ends])
    return np.array([bool(((nodes > before + hair) & (nodes < here - hair)).any()) for before, here in zip(previous, at)])


def places(nodes: np.ndarray, loops: list[np.ndarray], points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns the loop of each point, and the point's place along it, m."""
    loop, along, least = np.zeros(len(points), int), np.zeros(len(points)), np.full(len(points), np.inf)
    for number, own in enumerate(loops):
        line = nodes[own]
        side, length = np.diff(line, axis=0), lengths(line)
        starts = np.append(0.0, length.cumsum())
        for i, x in enumerate(points):
            part = np.clip(((x - line[:-1]) * side).sum(axis=1) / length**2, 0, 1)
            off = np.linalg.norm(line[:-1] + part[:, None] * side - x, axis=1)
            nearest = int(np.argmin(off))
            if off[nearest] < least[i]:
                least[i], loop[i] = off[nearest], number
                along[i] = (starts[nearest] + part[nearest] * length[nearest]) % starts[-1]
    return loop, along


def lengths(line: np.ndarray) -> np.ndarray:
    """Returns the lengths of the segments of a line, m."""
    return np.linalg.norm(np.diff(line, axis=0), axis=1)
