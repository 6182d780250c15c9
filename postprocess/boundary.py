# SPDX-License-Identifier: GPL-3.0-or-later
"""Places along the boundary of a plane body."""

from dataclasses import dataclass

import numpy as np

from .mesh import Mesh

LONGEST_BLANK = 0.3  # times the length of all parts, at most so wide is what is left blank between two


@dataclass(frozen=True)
class Arc:
    """Points of the boundary from end to end: their numbers in that order, positions (m) and the part of the boundary that each
    belongs to, numbered from 0."""

    order: np.ndarray
    position: np.ndarray
    part: np.ndarray

    def edges(self) -> np.ndarray:
        """Positions (m) between which a row of a map lies: one for each point and one between two parts."""
        middle = (self.position[1:] + self.position[:-1]) / 2
        begin, end = np.append(-np.inf, middle), np.append(middle, np.inf)
        first, last = np.append(True, np.diff(self.part) > 0), np.append(np.diff(self.part) > 0, True)
        spacing = float(np.median(np.diff(self.position))) if len(self.position) > 1 else 1.0
        # At an end as far out as in, of a point on its own as far as others reach.
        begin = np.where(first, np.where(last, self.position - spacing / 2, 2 * self.position - end), begin)
        end = np.where(last, 2 * self.position - begin, end)
        return np.sort(np.concatenate([begin, end[last]]))

    def rows(self) -> np.ndarray:
        """The row of each point."""
        found = np.empty(len(self.order), int)
        found[self.order] = np.arange(len(self.order)) + self.part
        return found


def arc_of(mesh: Mesh, points: np.ndarray, origin: int) -> Arc:
    """Points on the boundary, each once, from end to end; 0 is where the one with the number `origin` is. A part ends where a node
    of the mesh lies before the next point that is none of them."""
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
    """The loops' parts one behind the other, as far apart as they are but not too far."""
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
    """Where a part begins: of points at these places along a closed line, ascending, those with a node before them that is no
    point. `ends`: the nodes' places, the first one's twice."""
    hair = 1e-9 * length
    previous = np.roll(at, 1) - np.where(np.arange(len(at)) == 0, length, 0)
    nodes = np.concatenate([ends[:-1] - length, ends])
    return np.array([bool(((nodes > before + hair) & (nodes < here - hair)).any()) for before, here in zip(previous, at)])


def places(nodes: np.ndarray, loops: list[np.ndarray], points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The loop of each point, and how far along it the point is, m."""
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
    """Lengths of the segments of a line, m."""
    return np.linalg.norm(np.diff(line, axis=0), axis=1)
