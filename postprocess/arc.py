# SPDX-License-Identifier: GPL-3.0-or-later
"""Places of contact candidates along the surface that they lie on."""

from dataclasses import dataclass

import numpy as np

from run_folder import Contact

JUMP = 2.5  # times the usual distance to the next candidate: there the surface has ended
LONGEST_JUMP = 0.3  # times the length of all parts, at most so wide is what is left blank


@dataclass(frozen=True)
class Arc:
    """Candidates of a plane body from end to end: their numbers in that order, positions (m) and the part of the surface that
    each belongs to, numbered from 0."""

    order: np.ndarray
    position: np.ndarray
    part: np.ndarray

    def edges(self) -> np.ndarray:
        """Positions (m) between which a row of a map lies: one for each candidate and one between two parts."""
        middle = (self.position[1:] + self.position[:-1]) / 2
        begin, end = np.append(-np.inf, middle), np.append(middle, np.inf)
        first, last = np.append(True, np.diff(self.part) > 0), np.append(np.diff(self.part) > 0, True)
        spacing = float(np.median(np.diff(self.position))) if len(self.position) > 1 else 1.0
        # At an end as far out as in, of a candidate on its own as far as others reach.
        begin = np.where(first, np.where(last, self.position - spacing / 2, 2 * self.position - end), begin)
        end = np.where(last, 2 * self.position - begin, end)
        return np.sort(np.concatenate([begin, end[last]]))

    def rows(self) -> np.ndarray:
        """The row of each candidate."""
        found = np.empty(len(self.order), int)
        found[self.order] = np.arange(len(self.order)) + self.part
        return found


def merged(contact: Contact) -> Contact:
    """One candidate for each node: the sum of the forces and the least gap of a node that several obstacles may touch."""
    points, node = np.unique(contact.points, axis=0, return_inverse=True)
    shape, node = (len(contact.times), len(points)), node.ravel()
    gap, force, pressure = np.full(shape, np.inf), np.zeros(shape), np.zeros(shape)
    np.minimum.at(gap, (slice(None), node), contact.gap)
    np.add.at(force, (slice(None), node), contact.force)
    if contact.pressure is not None:
        np.add.at(pressure, (slice(None), node), contact.pressure)
    return Contact(contact.times, points, np.zeros(len(points), int), gap, force, None if contact.pressure is None else pressure)


def arc_of(contact: Contact) -> Arc:
    """Candidates of a plane body, each node once, from end to end; 0 is where the one is that is pushed the most."""
    points, origin = contact.points, contact.most_pushed
    order = np.array(chain(points, origin))
    if closed(points[order]):
        # Cut open where it is farthest from there.
        order = np.roll(order, len(order) // 2 - np.flatnonzero(order == origin)[0])
    apart = np.linalg.norm(np.diff(points[order], axis=0), axis=1)
    spacing = np.array([usual(apart, k) for k in range(len(apart))])
    jumps = apart > JUMP * spacing
    length = apart[~jumps].sum()
    steps = np.where(jumps, np.minimum(apart, np.maximum(LONGEST_JUMP * length, JUMP * spacing)), apart)
    position = np.concatenate([[0.0], np.cumsum(steps)])
    return Arc(order, position - position[np.flatnonzero(order == origin)[0]], np.concatenate([[0], np.cumsum(jumps)]))


def usual(apart: np.ndarray, k: int) -> float:
    """The median of the distances beside the k-th one."""
    beside = np.concatenate([apart[max(0, k - 2): k], apart[k + 1: k + 3]])
    return float(np.median(beside)) if len(beside) else np.inf


def closed(curve: np.ndarray) -> bool:
    """Whether a curve's ends are as near to each other as its other points are."""
    apart = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    return len(curve) > 4 and bool(np.linalg.norm(curve[0] - curve[-1]) <= JUMP * np.median(apart))


def chain(points: np.ndarray, start: int) -> list[int]:
    """Points of a curve from end to end, the end with the smaller x first: from `start` on each joins the end that it is
    nearest to."""
    order, left = [start], np.delete(np.arange(len(points)), start)
    while left.size:
        apart = np.linalg.norm(points[left] - points[[order[0], order[-1]]][:, None], axis=2)
        end, which = np.unravel_index(np.argmin(apart), apart.shape)
        order.insert(0 if end == 0 else len(order), left[which])
        left = np.delete(left, which)
    return order if tuple(points[order[0]]) <= tuple(points[order[-1]]) else order[::-1]
