# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigid obstacles of a scene: where they are at a time, and where they are drawn.

Lengths in m, times in s, points n × dim. Heights are distances from the obstacle, positive outside of it.
"""

import copy
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from expressions import Expression, TimeSeries
from files import NotInRun

SPACING = 1e-4  # of differences, as a part of the body's size


@dataclass(frozen=True)
class Course:
    """Numbers that may change with time."""

    at: Callable[[float], np.ndarray]
    moves: bool

    def drawn(self, enlarged: float, shift: np.ndarray | float) -> "Course":
        """Elsewhere by `shift` at the start, and with changes so many times as large."""
        start = self.at(0.0)
        return replace(self, at=lambda time: start + shift + enlarged * (self.at(time) - start))


def course(given: object) -> Course:
    """Of a number, an expression of t or a time series, or a list of them."""
    entries = [of_time(part) for part in (given if isinstance(given, list) else [given])]

    def at(time: float) -> np.ndarray:
        values = np.array([value(time) for value, _ in entries])
        return values if isinstance(given, list) else values[0]

    return Course(at, any(moves for _, moves in entries))


def of_time(given: object) -> tuple[Callable[[float], float], bool]:
    """A function of the time, and whether it changes."""
    if isinstance(given, str):
        expression, origin = Expression(given), np.zeros((1, 3))
        return lambda time: float(expression(origin, time)[0]), expression.moves
    if isinstance(given, dict):
        series, shift = TimeSeries(Path(given["file"]), given["column"]), given.get("shift", 0.0)
        return lambda time: series(time) + shift, True
    return lambda time: float(given), False


@dataclass(frozen=True)
class HalfSpace:
    """(x - point)·normal ≤ 0; the normal has length 1 and points out of the obstacle."""

    point: Course
    normal: np.ndarray
    rigid = True

    @property
    def moves(self) -> bool:
        return self.point.moves

    def height(self, x: np.ndarray, time: float) -> np.ndarray:
        return (x - self.point.at(time)) @ self.normal

    def travel(self, time: float) -> np.ndarray:
        """How far it has come since the start; along the plane it stays where it is."""
        return self.normal * (self.normal @ (self.point.at(time) - self.point.at(0.0)))

    def extent(self, time: float) -> None:
        """It has no ends."""

    def drawn(self, enlarged: float, shift: np.ndarray) -> "HalfSpace":
        return replace(self, point=self.point.drawn(enlarged, shift))


@dataclass(frozen=True)
class Round:
    """A ball, or with an axis of length 1 a cylinder; `sign` is -1 where the body is inside."""

    center: Course
    radius: Course
    sign: int
    axis: np.ndarray | None = None

    @property
    def moves(self) -> bool:
        return self.center.moves or self.radius.moves

    @property
    def rigid(self) -> bool:
        return not self.radius.moves

    def height(self, x: np.ndarray, time: float) -> np.ndarray:
        apart = x - self.center.at(time)
        if self.axis is not None:
            apart = apart - np.outer(apart @ self.axis, self.axis)
        return self.sign * (np.linalg.norm(apart, axis=1) - self.radius.at(time))

    def travel(self, time: float) -> np.ndarray:
        """How far it has come since the start."""
        return self.center.at(time) - self.center.at(0.0)

    def extent(self, time: float) -> np.ndarray:
        """Two corners of the box around it, infinite where a cylinder has no ends."""
        reach = self.radius.at(time) if self.axis is None else np.where(self.axis == 0, self.radius.at(time), np.inf)
        return self.center.at(time) + np.array([[-1], [1]]) * reach

    def drawn(self, enlarged: float, shift: np.ndarray) -> "Round":
        return replace(self, center=self.center.drawn(enlarged, shift), radius=self.radius.drawn(enlarged, 0.0))


@dataclass(frozen=True)
class LevelSet:
    """Where an expression is negative; its heights are those of its tangent planes, which are true near the surface."""

    value: Expression
    spacing: float  # of central differences
    enlarged: float = 1.0
    shift: np.ndarray | float = 0.0
    rigid = False

    @property
    def moves(self) -> bool:
        return self.value.moves

    def height(self, x: np.ndarray, time: float) -> np.ndarray:
        x = x - self.shift
        if self.enlarged == 1 or not self.moves:
            return self._height(x, time)
        start = self._height(x, 0.0)
        return start + self.enlarged * (self._height(x, time) - start)

    def extent(self, time: float) -> None:
        """Unknown."""

    def drawn(self, enlarged: float, shift: np.ndarray) -> "LevelSet":
        return replace(self, enlarged=enlarged, shift=shift)

    def _height(self, x: np.ndarray, time: float) -> np.ndarray:
        value = self.value(x, time)
        slope = np.linalg.norm(gradient(lambda beside: self.value(beside, time), x, self.spacing), axis=1)
        return np.divide(value, slope, out=value, where=slope > 0)


Shape = HalfSpace | Round | LevelSet


@dataclass(frozen=True)
class Obstacle:
    """What candidates may touch, by the name that the scene gives it or its number."""

    name: str
    shape: Shape


def gradient(height: Callable[[np.ndarray], np.ndarray], x: np.ndarray, spacing: float) -> np.ndarray:
    """By central differences, n × dim."""
    steps = spacing * np.eye(x.shape[1])
    return np.stack([height(x + step) - height(x - step) for step in steps], axis=1) / (2 * spacing)


def normals(shape: Shape, x: np.ndarray, time: float, spacing: float) -> np.ndarray:
    """Directions of length 1 out of the obstacle at points near its surface."""
    slope = gradient(lambda beside: shape.height(beside, time), x, spacing)
    size = np.linalg.norm(slope, axis=1, keepdims=True)
    return np.divide(slope, size, out=np.zeros_like(slope), where=size > 0)


def read_obstacles(scene: dict, size: float) -> list[Obstacle]:
    """Those of a scene, in its order; size of the body. Raises NotInRun for a shape that is not drawn."""
    return [Obstacle(name, shape_of(table["obstacle"], size)) for name, table in zip(names(scene), contact_tables(scene))]


def with_fitted_obstacles(scene: dict, values: list[float]) -> dict:
    """A scene whose obstacles are where its unknowns have these values."""
    scene = copy.deepcopy(scene)
    # Positions are along the normals that the scene has, before any of them turns.
    for one, value in sorted(zip(scene["unknown"], values), key=lambda pair: pair[0]["of"] == "angle"):
        if one["of"] not in ("position", "angle", "center", "radius"):
            continue
        tables = contact_tables(scene)
        given = next(table["obstacle"] for table in tables if len(tables) == 1 or table["obstacle"].get("name") == one.get("obstacle"))
        if one["of"] == "position":
            given["point"] = [moved(part, value * n) for part, n in zip(given["point"], unit(given["normal"]))]
        elif one["of"] == "angle":
            given["normal"] = turned(unit(given["normal"]), one.get("component", "z"), value)
        elif one["of"] == "radius":
            given["radius"] = value
        else:
            middle = "center" if given["shape"] == "ball" else "point"
            given[middle] = [value if axis == one["component"] else part for axis, part in zip("xyz", given[middle])]
    return scene


def moved(given: object, shift: float) -> object:
    """A coordinate elsewhere: a number, an expression or a time series."""
    if isinstance(given, dict):
        return given | {"shift": shift}
    return f"({given}) + ({float(shift)!r})" if isinstance(given, str) else given + shift


def turned(normal: np.ndarray, axis: str, angle: float) -> list[float]:
    """A unit vector turned about an axis (rad); in the plane about z."""
    x, about = np.zeros(3), np.eye(3)["xyz".index(axis)]
    x[: len(normal)] = normal
    x = np.cos(angle) * x + np.sin(angle) * np.cross(about, x) + (1 - np.cos(angle)) * (about @ x) * about
    return [float(part) for part in x[: len(normal)]]


def contact_tables(scene: dict) -> list[dict]:
    """One for each obstacle."""
    given = scene.get("contact", [])
    return given if isinstance(given, list) else [given]


def names(scene: dict) -> list[str]:
    """Of the obstacles: those that the scene gives, or numbers."""
    return [table["obstacle"].get("name", f"obstacle {i}") for i, table in enumerate(contact_tables(scene), 1)]


def shape_of(given: dict, size: float) -> Shape:
    """One table of a scene."""
    sign = -1 if given.get("side") == "inside" else 1
    match given["shape"]:
        case "half-space":
            return HalfSpace(course(given["point"]), unit(given["normal"]))
        case "ball":
            return Round(course(given["center"]), course(given["radius"]), sign)
        case "cylinder":
            return Round(course(given["point"]), course(given["radius"]), sign, unit(given["axis"]) if "axis" in given else None)
        case "signed-distance":
            return LevelSet(Expression(given["distance"]), SPACING * size)
    raise NotInRun(f"an obstacle of the shape \"{given['shape']}\" is not drawn")


def unit(direction: list[float]) -> np.ndarray:
    vector = np.array(direction, dtype=float)
    return vector / np.linalg.norm(vector)
