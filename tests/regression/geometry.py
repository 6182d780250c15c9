# SPDX-License-Identifier: GPL-3.0-or-later
"""What pages and figures draw of obstacles and bodies, by closed forms.

    geometry.py SIGNORINI SOURCE
"""

import itertools
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SOURCE  # noqa: E402

sys.path.insert(0, str(SOURCE / "postprocess"))
import h5py  # noqa: E402
import numpy as np  # noqa: E402
import report_compare  # noqa: E402
import report_motion  # noqa: E402
import scenery  # noqa: E402
import style  # noqa: E402
import surfaces  # noqa: E402
from mesh import Mesh, Series  # noqa: E402
from obstacles import normals, read_obstacles  # noqa: E402
from report_fields import nodal  # noqa: E402

ROUNDING = 1e-12
RNG = np.random.default_rng(1)


def near(what: str, found: object, expected: object, relative: float = ROUNDING) -> None:
    found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    assert found.shape == expected.shape, (what, found.shape, expected.shape)
    off = np.max(np.abs(found - expected)) if found.size else 0.0
    assert off <= relative * np.max([1.0, np.max(np.abs(expected), initial=0)]), (what, off, found, expected)


def shape(size: float = 2.0, **obstacle: object) -> object:
    return read_obstacles({"contact": {"obstacle": obstacle}}, size)[0].shape


def area(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    if points.shape[1] == 2:
        return np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def half_spaces() -> None:
    for dim in (2, 3):
        x, normal, start = RNG.normal(size=(5, dim)), np.array([0.3, -2, 1.0][:dim]), np.array([0.1, 0.2, -0.4][:dim])
        unit, way = normal / np.linalg.norm(normal), np.array([2.0, 1, 0.5][:dim])
        flat = shape(shape="half-space", point=[f"{a} + {b}*t" for a, b in zip(start, way)], normal=list(normal))
        near("heights above a plane", flat.height(x, 0.5), (x - start - way / 2) @ unit)
        near("how far it has come", flat.travel(0.5), unit * (way @ unit) / 2)
        shift = np.full(dim, 0.25)
        near("drawn elsewhere, and three times as far", flat.drawn(3.0, shift).height(x, 0.5), (x - start - shift - 1.5 * way) @ unit)
        assert flat.moves and flat.rigid and flat.extent(0.5) is None
        assert not shape(shape="half-space", point=[0] * dim, normal=list(normal)).moves
        # As far as the box reaches: a strip below the line, in space a rectangle.
        box = np.array([[-1.0, -2, -3], [2, 1, 4]])[:, :dim]
        points, triangles = surfaces.seen_of(flat, 0.5, box, 0.7, True)
        corners = np.array(list(itertools.product(*box.T)))
        along = [np.array([unit[1], -unit[0]])] if dim == 2 else surfaces.plane_axes(unit)
        near("axes along a plane", np.array(along) @ np.array([*along, unit]).T, np.eye(dim)[: dim - 1])
        for axis in along:
            near("as far as the box", [np.min(points @ axis), np.max(points @ axis)], [np.min(corners @ axis), np.max(corners @ axis)])
        heights = flat.height(points, 0.5)
        near("on the surface", [np.min(heights), np.max(heights)], [-0.7, 0] if dim == 2 else [0, 0])
        sides = [np.ptp(points @ axis) for axis in along]
        near("its area", np.sum(area(points, triangles)), sides[0] * (0.7 if dim == 2 else sides[1]))


def balls_and_cylinders() -> None:
    x = RNG.normal(size=(6, 3))
    axis = np.array([1.0, 2, -2]) / 3
    for side, sign in (("outside", 1), ("inside", -1)):
        for dim in (2, 3):
            centre = np.array([0.2, 0.3, -0.1][:dim])
            ball = shape(shape="ball", center=[0.2, "0.1 + 0.4*t", -0.1][:dim], radius="0.4 + 0.2*t", side=side)
            near("heights of a ball", ball.height(x[:, :dim], 0.5), sign * (np.linalg.norm(x[:, :dim] - centre, axis=1) - 0.5))
            near("how far it has come", ball.travel(0.5), [0, 0.2, 0][:dim])
            near("the box around it", ball.extent(0.5), [centre - 0.5, centre + 0.5])
            drawn = ball.drawn(2.0, np.full(dim, 0.1))  # changes twice as large
            near("drawn elsewhere", drawn.height(x[:, :dim], 0.5),
                 sign * (np.linalg.norm(x[:, :dim] - [0.3, 0.6, 0.0][:dim], axis=1) - 0.6))  # fmt: skip
            assert ball.moves and not ball.rigid
        rod = shape(shape="cylinder", point=["t", 0.1, 0], axis=[1, 2, -2], radius=0.5, side=side)
        apart = x - [0.25, 0.1, 0]
        near("heights of a cylinder", rod.height(x, 0.25), sign * (np.linalg.norm(apart - np.outer(apart @ axis, axis), axis=1) - 0.5))
        assert rod.moves and rod.rigid and np.all(np.isinf(rod.extent(0.25)))
        straight = shape(shape="cylinder", point=[1, 2, 3], axis=[0, 0, 2], radius=0.5, side=side)
        near("the box around a straight one", straight.extent(0.0)[:, :2], [[0.5, 1.5], [1.5, 2.5]])
        assert not straight.moves and list(straight.extent(0.0)[:, 2]) == [-np.inf, np.inf]


def level_sets() -> None:
    x = RNG.normal(size=(6, 2)) + 3
    curve = shape(shape="signed-distance", distance="3*(x^2 + y^2 - (1 + t)^2)")
    at = lambda time: ((x**2).sum(axis=1) - (1 + time) ** 2) / (2 * np.linalg.norm(x, axis=1))  # noqa: E731 (of the tangent plane)
    near("heights of a level set", curve.height(x, 0.5), at(0.5), 1e-8)
    near("drawn with twice the change", curve.drawn(2.0, 0.0).height(x, 0.5), 2 * at(0.5) - at(0.0), 1e-8)
    near("normals", normals(curve, x, 0.5, 1e-4), x / np.linalg.norm(x, axis=1, keepdims=True), 1e-6)  # differences of differences
    assert curve.moves and curve.extent(0.0) is None and not curve.rigid


def level_surfaces() -> None:
    """Zeros of linear functions are planes; those of the distance to a point a sphere, which is seen from outside."""
    axes, points = surfaces.grid(np.array([0.0, 0, 0]), np.array([1.0, 0.5, 0.25]), 8)
    assert [len(axis) for axis in axes] == [9, 5, 3] and len(points) == 135
    cells = surfaces.tetrahedra((9, 5, 3))
    a, b, c, d = np.moveaxis(points[cells], 1, 0)
    near("the box is filled", np.sum(np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a))) / 6, 1 / 8)
    for direction, expected in (([0.0, 0, 1], 0.5), ([1.0, 1, 0], 0.25 * np.sqrt(0.5)), ([0.0, 1, 2], np.sqrt(5) / 4)):  # sections of the box
        middle = (points - [0.5, 0.25, 0.125]) @ direction + 1e-3 * (direction[2] == 1)
        pairs, weight, faces = surfaces.zeros(cells, middle)
        cut = surfaces.between(pairs, weight, points)
        near("on the plane", surfaces.between(pairs, weight, middle), np.zeros(len(pairs)))
        near("values go with it", surfaces.between(pairs, weight, points @ [1.0, 2, 3]), cut @ [1.0, 2, 3])
        near("area of a section", np.sum(area(cut, faces)), expected, 1e-9)
        for way in (1, -1):
            p, q, r = np.moveaxis(cut[surfaces.facing(faces, cut, way * np.array(direction))], 1, 0)
            assert np.min(way * np.cross(q - p, r - p) @ direction) >= 0
    middle[np.argmax(points @ [1, 1, 1])] = np.nan
    assert len(surfaces.zeros(cells, middle)[2]) <= len(faces), "a value that is unknown makes no surface"
    centre, box = np.array([0.1, 0.2, -0.3]), np.array([[-2.0, -2, -2], [2, 2, 2]])
    for side, sign in (("outside", 1), ("inside", -1)):
        ball = shape(shape="ball", center=list(centre), radius=0.5, side=side)
        for changes, cells_across in ((False, 40), (True, 16)):
            surface, faces = surfaces.seen_of(ball, 0.0, box, 0.0, changes)
            width = 1.1 / cells_across  # of the box around the ball alone
            assert np.max(np.abs(np.linalg.norm(surface - centre, axis=1) - 0.5)) < 3 / 4 * width**2  # along a cell's diagonal
            near("area of a sphere", np.sum(area(surface, faces)), np.pi, 4 * width**2)
            p, q, r = np.moveaxis(surface[faces] - centre, 1, 0)
            assert np.min(sign * np.einsum("ij,ij->i", np.cross(q - p, r - p), p + q + r)) > -1e-12, "seen from within"
        half = surfaces.seen_of(ball, 0.0, np.array([centre, centre + 2]), 0.0, False)
        near("an eighth of it", np.sum(area(*half)), np.pi / 8, 0.01)
    assert len(surfaces.seen_of(ball, 0.0, box + 5, 0.0, False)[1]) == 0, "out of sight"


def bands() -> None:
    """In the plane a strip below the curve: all of a disc that the picture holds."""
    box = np.array([[-1.0, -1], [1, 1]])
    for changes, cells in ((False, 160), (True, 80)):
        fine = 2 * (2 / cells) ** 2
        small = shape(shape="ball", center=[0.1, 0.2], radius=0.5)
        near("a disc", np.sum(area(*surfaces.seen_of(small, 0.0, box, 0.1, changes))), np.pi / 4, 20 * fine)
        large = shape(shape="ball", center=[0.0, -5], radius=4.5)
        points, triangles = surfaces.seen_of(large, 0.0, box, 0.1, changes)
        heights = large.height(points, 0.0)
        near("below the curve", [np.min(heights), np.max(heights)], [-0.1, 0], 2 * fine)
        angle = 2 * np.arcsin(1 / 4.5)
        near("a strip", np.sum(area(points, triangles)), angle * (4.5**2 - 4.4**2) / 2, 0.01)
        hole = shape(shape="ball", center=[0.1, 0.2], radius=0.5, side="inside")
        near("around a hole", np.sum(area(*surfaces.seen_of(hole, 0.0, box, 0.1, changes))), np.pi * (0.6**2 - 0.5**2), 20 * fine)
        wave = shape(shape="signed-distance", distance="y - 0.5*x")
        points, triangles = surfaces.seen_of(wave, 0.0, box, 0.2, changes)
        near("below a line", np.sum(area(points, triangles)), 0.2 * np.sqrt(5), 1e-6)
        assert np.min(wave.height(points, 0.0)) > -0.2 - 1e-9
    away = shape(shape="signed-distance", distance="y - 5")
    assert len(surfaces.seen_of(away, 0.0, box, 0.2, False)[1]) == 0


def bodies(folder: Path) -> None:
    """Boundary and size of a rectangle and a box, and values of cells at nodes."""
    axes, points = surfaces.grid(np.array([0.0, 0]), np.array([3.0, 2]), 3)
    number = np.arange(12).reshape(4, 3)
    low = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    cells = np.stack([part.ravel() for part in low], axis=1)[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    flat = Mesh(points, cells)
    edges, of = flat.facets()
    near("length of the boundary", np.sum(np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)), 10)
    assert np.array_equal(edges, flat.outline()) and all(set(edge) <= set(cells[cell]) for edge, cell in zip(edges.tolist(), of))
    assert list(flat.boundary_nodes()) == [n for n in range(12) if n not in (4, 7)] and flat.size == 3
    axes, inside = surfaces.grid(np.array([0.0, 0, 0]), np.array([2.0, 2, 4]), 4)
    solid = Mesh(inside, surfaces.tetrahedra(tuple(len(axis) for axis in axes)))
    faces, of = solid.facets()
    near("surface", np.sum(area(inside, faces)), 40)
    p, q, r = np.moveaxis(inside[faces], 1, 0)
    near("volume, from outside", np.sum(np.einsum("ij,ij->i", np.cross(p, q), r)) / 6, 16)
    assert all(set(face) <= set(solid.cells[cell]) for face, cell in zip(faces.tolist(), of)) and solid.size == 4
    assert len(solid.boundary_nodes()) == len(inside) - 3
    for dim, mesh in ((2, flat), (3, solid)):
        for width in (1, 3, 9):
            values = RNG.normal(size=(len(mesh.cells), width))
            with h5py.File(folder / "values.h5", "w") as file:
                file["at"] = values
            series = Series(mesh, np.array([0.0]), [(folder / "values.h5", "at")], True)
            near("components", series.components(0), values)
            near("values", series.values(0), values.reshape(-1, 3, 3) if width == 9 else values[:, :dim] if width == 3 else values)
            if width == 3:
                near("a vector", series.at(0), values[:, :dim])
            found = nodal(series, series.values(0))
            for node in range(len(mesh.points)):
                near("mean of the cells at a node", found[node], series.values(0)[(mesh.cells == node).any(axis=1)].mean(axis=0))
        only = np.zeros((len(mesh.cells), dim))
        only[::3] = RNG.normal(size=only[::3].shape)
        found = nodal(series, only, only)
        for node in range(len(mesh.points)):
            there = only[(mesh.cells == node).any(axis=1)]
            acting = there[there.any(axis=1)]
            near("mean of those that act", found[node], acting.mean(axis=0) if len(acting) else np.zeros(dim))
    assert nodal(Series(flat, np.array([0.0]), [], False), points) is points


def pictures() -> None:
    """The box that is drawn fills the picture, and more of the world is seen where it is too slim for labels."""
    for low, high in (([1.0, 2.0], [3.0, 2.5]), ([-5.0, 1.0], [-4.0, 31.0]), ([2.0, 2.0], [4.0, 4.0])):
        low, high = np.array(low), np.array(high)
        axes = style.plan(low, high, ("x", "y"))
        seen = np.array([axes.get_xlim(), axes.get_ylim()]).T
        inches = axes.get_position().size * axes.figure.get_size_inches()
        near("in its middle", seen.mean(axis=0), (low + high) / 2)
        near("of equal scale", inches / (seen[1] - seen[0]), np.full(2, np.min(style.PLAN / (high - low))))
        near("as wide as the box or as labels", inches, np.maximum(np.min(style.PLAN / (high - low)) * (high - low), style.LEAST_PLAN))
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (m)", "y (m)")


def side_by_side() -> None:
    """Two motions have the fields that both have, in the unit of the larger values, and one box."""
    def body(end: float, box: list, *fields: tuple) -> tuple[dict, Series]:
        made = [{"name": name, "label": f"{name} ({unit})", "factor": factor, "scale": factor / 8, "least": factor * least, "largest": factor * largest}
                for name, unit, factor, least, largest in fields]  # fmt: skip
        return {"fields": made, "box": box, "eye": end, "start": end, "note": "."}, Series(None, np.array([0.0, end]), [], False)

    slow = body(1.0, [[0, 0], [1, 4]], ("speed", "mm/s", 1e3, 0.1, 0.5), ("stress", "Pa", 1.0, 0, 7), ("own", "m", 1.0, 0, 1))
    fast = body(2.0, [[-1, 1], [3, 2]], ("stress", "Pa", 1.0, 1, 9), ("speed", "m/s", 1.0, 0.2, 8))
    for pair in ((slow, fast), (fast, slow)):
        motions = report_compare.alike([dict(one, fields=[dict(field) for field in one["fields"]]) for one, _ in pair], np.array([0.0, 2]), [own for _, own in pair])
        for one, (own, _) in zip(motions, pair):
            found = {field["name"]: field for field in one["fields"]}
            assert set(found) == {"speed", "stress"} and [field["name"] for field in one["fields"]] == [
                field["name"] for field in motions[0]["fields"]], "not in one order"  # fmt: skip
            for name, label, least, largest in (("speed", "speed (m/s)", 0.1, 8), ("stress", "stress (Pa)", 0, 9)):
                assert found[name]["label"] == label and found[name]["factor"] == 1
                near("one range", [found[name][key] for key in ("least", "largest", "scale")], [least, largest, 1 / 8])
            near("one box", one["box"], [[-1, 0], [3, 4]])
            assert one["eye"] == one["start"] == pair[0][0]["eye"]
            assert one["note"] == (". It ends at 1 s and stays as it is then." if own is slow[0] else ".")


def beside_the_body() -> None:
    """An obstacle over the frames of a picture: one shape that comes along, or one a frame where it grows; none where it is far."""
    times, size = np.linspace(0, 1, 5), 2.0
    position = np.tile(np.array([[0.0, 0], [2, 0], [2, 1]]), (5, 1, 1))

    def seen(**obstacle: object) -> tuple[object, np.ndarray]:
        found, box = scenery.scenery(read_obstacles({"contact": {"obstacle": obstacle}}, size), times, position, size)
        assert len(found) == 1
        return found[0], box

    slot = np.array([[0.0, 0], [2, 1]]) + scenery.MARGIN * size * np.array([[-1], [1]])
    still, box = seen(shape="half-space", point=[0, -0.5], normal=[0, 1])
    near("the body and a margin", box, slot)
    assert len(still.shapes) == 1 and list(still.shape) == [0] * 5 and not still.offset.any()
    assert report_motion.packed_scenery(still, 5)["offset"] is None
    rising, _ = seen(shape="half-space", point=["t", "t - 1"], normal=[0, 2])
    where = [points + rising.offset[i] for i, (points, _) in ((i, rising.shapes[rising.shape[i]]) for i in range(5))]
    near("where it is in each frame", [points[:, 1].max() for points in where], times - 1)
    assert report_motion.packed_scenery(rising, 5)["offset"] is not None, "it moves along one axis alone"
    growing, box = seen(shape="ball", center=[1, -0.6], radius="0.5 + 0.25*t")
    assert len(growing.shapes) == 5 and list(growing.shape) == [0, 1, 2, 3, 4] and not growing.offset.any()
    near("its size in each frame", [np.ptp(points[:, 0]) for points, _ in growing.shapes], 1 + times / 2, 0.01)
    near("all of it is in the picture", box[0, 1], -1.35 - scenery.BAND * size)
    assert scenery.scenery(read_obstacles({"contact": {"obstacle": {"shape": "ball", "center": [1, 9], "radius": 1}}}, size), times, position, size)[0] == []
    # Of the candidates those that ever touch tell how near it is.
    force, points = np.array([[0.0, 1, 0], [0, 0, 0], [0, 1, 2]]), np.array([[0.0, 0], [1, 0], [2, 0]])
    for pushes, expected in ((force, points[1:]), (0 * force, points)):
        contact = SimpleNamespace(of=lambda obstacle, pushes=pushes: SimpleNamespace(force=pushes, points=points))
        near("candidates that touch", scenery.candidates(SimpleNamespace(has_contact_table=True, contact=contact), 0, None), expected)
    near("no table", scenery.candidates(SimpleNamespace(has_contact_table=False), 0, Mesh(points, points)), points)


def main() -> int:
    beside_the_body()
    side_by_side()
    pictures()
    half_spaces()
    balls_and_cylinders()
    level_sets()
    level_surfaces()
    bands()
    with tempfile.TemporaryDirectory() as name:
        bodies(Path(name))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
