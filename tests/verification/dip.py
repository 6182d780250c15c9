# SPDX-License-Identifier: GPL-3.0-or-later
"""Degree 2: how far the boundary dips below the obstacle between the nodes, at which alone the contact condition holds.

Displacements are quadratic along an edge, and so is the gap to a plane: it is known there from the nodes at the ends and in the
middle, which are all in contact.csv. A quadratic that is zero at two neighbouring nodes and g at the third dips g/8 between
them. That happens where contact ends within an edge of length h. Beyond the end of a contact of half-width a, Hertz's gap opens
like √(8a)/(3R) d^(3/2) at the distance d, and d ≤ h/2 at the third node: the dip is √a h^(3/2) / (24 R) at most. The gap at the
third node is of the order 1.5, and so is the dip.
"""

import functools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_BALL, HALF_DISC, boundary, signorini, stored, table

RADIUS = 15.0
SIZES = (2.0, 1.0, 0.5, 0.25)
# In space Hertz's gap opens 4/π times as fast (8√2/(3π) in place of 2√2/3).
BALL = {3.0: 2.5e-4, 2.0: 1.875e-4, 1.5: 1.25e-4}  # m, and the step, s
# Hertz's contact rests and is small beside the radius; of a moving one of up to R/5 the law gives the size within a factor.
MOTION = 2
# Between two nodes gaps are right to the rounding of lengths of the body's size.
ROUNDING = 1e-14 * RADIUS


def candidates(out: Path, axes: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions of the candidates, and their gaps and forces (steps × candidates)."""
    contact = table(out / "contact.csv")
    count = int((contact["step"] == contact["step"][0]).sum())
    points = np.column_stack([contact[axis][:count] for axis in axes])
    return points, contact["gap"].reshape(-1, count), contact["force"].reshape(-1, count)


def hertz(half_width: float, h: float) -> float:
    return np.sqrt(half_width) * h**1.5 / (24 * RADIUS)


def deepest(nodes: np.ndarray, forces: np.ndarray, inner: np.ndarray, h: float, bound: float) -> float:
    """The deepest dip, from the least gaps of the edges or faces (steps × these) whose longest edge is h. Fails beyond the bound."""
    assert (nodes >= -ROUNDING).all(), "a node is in the obstacle"
    touching = (forces > 0).sum(axis=1)
    assert (touching > 0).sum() > 10 and touching.max() > 4, "hardly any contact: the case says nothing"
    dip = -inner.min()
    dipping = (inner < -ROUNDING).sum(axis=1)
    print(f"at most {touching.max()} nodes in contact, the longest edge is {h:.3f} m; dip {dip:.2e} m, {dip / h:.2%} of it "
          f"and {dip / (2 * RADIUS):.1e} of the diameter; at most {dipping.max()} edges or faces dip")  # fmt: skip
    assert dip / bound <= MOTION, "beyond Hertz's bound"
    return dip


def half_disc(size: float, out: Path) -> tuple[float, float]:
    """The dip and the edge length."""
    signorini("simulate", HALF_DISC, out, mesh__size=size, mesh__degree=2, control__initial=["0", "-1"], output__fields=[])
    points, gap, force = candidates(out, "xy")
    order = np.argsort(points[:, 0])
    points, gap, force = points[order], gap[:, order], force[:, order]
    assert np.allclose(points[1::2], (points[:-2:2] + points[2::2]) / 2, rtol=0, atol=ROUNDING), "no chain of edges"
    first, middle, last = gap[:, :-2:2], gap[:, 1::2], gap[:, 2::2]
    curvature, slope = 2 * (first - 2 * middle + last), -3 * first + 4 * middle - last
    with np.errstate(divide="ignore", invalid="ignore"):
        lowest = np.where(curvature > 0, np.clip(-slope / (2 * curvature), 0, 1), 0)
    least = np.minimum(0, first + slope * lowest + curvature * lowest**2)
    h = np.linalg.norm(points[2::2] - points[:-2:2], axis=1).max()
    half_width = np.maximum(abs(points[:, 0])[(force > 0).any(axis=0)].max(), h)
    return deepest(gap, force, least, h, hertz(half_width, h)), h


def shape_functions(count: int) -> np.ndarray:
    """Those of a quadratic triangle, corners before the middles of 01, 12, 02, at points as dense as `count` to a side."""
    a = np.array([(i, j, count - i - j) for i in range(count + 1) for j in range(count + 1 - i)]) / count
    return np.column_stack([a * (2 * a - 1), 4 * a[:, 0] * a[:, 1], 4 * a[:, 1] * a[:, 2], 4 * a[:, 0] * a[:, 2]])


@pytest.fixture(scope="module")
def disc(tmp_path_factory: pytest.TempPathFactory) -> Callable[[float], tuple[float, float]]:
    """half_disc() by size; each motion is computed once."""
    return functools.cache(lambda size: half_disc(size, tmp_path_factory.mktemp("disc") / "out"))


@pytest.mark.parametrize("size", SIZES)
def test_half_disc(disc: Callable, size: float) -> None:
    disc(size)


def test_order(disc: Callable) -> None:
    dips, lengths = np.transpose([disc(size) for size in SIZES])
    print("orders", ", ".join(f"{order:.2f}" for order in np.log(dips[:-1] / dips[1:]) / np.log(lengths[:-1] / lengths[1:])))
    # Where an edge ends beside the end of contact is accidental; halfway to order 1, that of a dip in proportion to the edge.
    assert float(np.polyfit(np.log(lengths), np.log(dips), 1)[0]) >= 1.25, "order 1.5 is expected"


@pytest.mark.parametrize("size, step", BALL.items(), ids=[f"{size:g}" for size in BALL])
def test_half_ball(size: float, step: float, tmp_path: Path) -> None:
    out = tmp_path / "out"
    signorini("simulate", HALF_BALL, out, mesh__size=size, mesh__degree=2, time__step=step, control__initial=["0", "0", "-1"],
              output__fields=["displacement"])  # fmt: skip
    corners, cells, _ = stored(out, "state", "displacement")
    points, gap, force = candidates(out, "xyz")
    number = {tuple(point): i for i, point in enumerate(points.round(6) + 0.0)}
    faces = []
    for facet in boundary(cells):
        a, b, c = corners[facet]
        six = [number.get(tuple(point.round(6) + 0.0)) for point in (a, b, c, (a + b) / 2, (b + c) / 2, (a + c) / 2)]
        if None not in six:
            faces.append(six)
    faces = np.array(faces)
    least = np.minimum(0, np.einsum("pn,sfn->sfp", shape_functions(20), gap[:, faces]).min(axis=2))
    h = np.max([np.linalg.norm(points[faces[:, i]] - points[faces[:, j]], axis=1).max() for i, j in ((0, 1), (1, 2), (0, 2))])
    half_width = np.maximum(np.linalg.norm(points[:, :2], axis=1)[(force > 0).any(axis=0)].max(), h)
    deepest(gap, force, least, h, 4 / np.pi * hertz(half_width, h))
