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
import as_package  # noqa: E402, F401
import h5py  # noqa: E402
import numpy as np  # noqa: E402
from signorini.post import report_compare  # noqa: E402
from signorini.post import report_motion  # noqa: E402
from signorini.post import scenery  # noqa: E402
from signorini.post import style  # noqa: E402
from signorini.post import surfaces  # noqa: E402
from signorini.post.boundary import arc_of  # noqa: E402
from signorini.post.mesh import Mesh, Series  # noqa: E402
from signorini.post.obstacles import Obstacle  # noqa: E402
from signorini.post.report_fields import nodal  # noqa: E402

ROUNDING = 1e-12
RNG = np.random.default_rng(1)


def near(what: str, found: object, expected: object, relative: float = ROUNDING) -> None:
    found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    assert found.shape == expected.shape, (what, found.shape, expected.shape)
    off = np.max(np.abs(found - expected)) if found.size else 0.0
    assert off <= relative * np.max([1.0, np.max(np.abs(expected), initial=0)]), (what, off, found, expected)


def obstacle(points: np.ndarray, facets: np.ndarray, **more: object) -> Obstacle:
    """One that is still, with a candidate on the surface."""
    dim = points.shape[1]
    given = {"name": "obstacle", "flat": False, "whole": False, "gap": np.zeros(1), "normal": np.eye(dim)[-1:], "times": np.linspace(0, 1, 5)}
    return Obstacle(**given | more, points=np.asarray(points, float), facets=np.asarray(facets))


def circle(middle: list[float], radius: float, count: int = 400, inside: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Its points and segments, with the obstacle to the right; `inside`: the body."""
    angle = np.linspace(0, -2 * np.pi, count, endpoint=False) * (-1 if inside else 1)
    points = np.array(middle) + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    return points, np.column_stack([np.arange(count), np.roll(np.arange(count), -1)])


def grid(sides: list[float], counts: list[int]) -> np.ndarray:
    """Points of a box from the origin on, the last coordinate changing first."""
    axes = [np.linspace(0, side, count) for side, count in zip(sides, counts)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(sides))


def box_of(sides: list[float], counts: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Points of a box in space and tetrahedra that fill it."""
    number, (ni, nj, nk) = np.arange(np.prod(counts)).reshape(counts), [count - 1 for count in counts]
    corners = [number[i : i + ni, j : j + nj, k : k + nk].ravel() for i, j, k in itertools.product((0, 1), repeat=3)]
    cells = [np.stack([corners[0], corners[one], corners[one | two], corners[7]], axis=1) for one, two in itertools.permutations((1, 2, 4), 2)]
    return grid(sides, counts), np.concatenate(cells)


def area(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    if points.shape[1] == 2:
        return np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def level_surfaces() -> None:
    """Zeros of linear functions are planes; those of the distance to a point a sphere, which is seen from outside."""
    points, cells = box_of([1.0, 0.5, 0.25], [9, 5, 3])
    assert len(points) == 135
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


def bands() -> None:
    """In the plane a strip below the curve; all of a disc."""
    line = np.array([[-1.0, -0.5], [1, 0.5]])
    points, triangles = surfaces.seen_of(obstacle(line, [[0, 1]]), 0.0, 0.2)
    near("below a line", np.sum(area(points, triangles)), 0.2 * np.sqrt(5))
    near("as deep as that", np.min((points - line[0]) @ [-0.5, 1]) / np.hypot(0.5, 1), -0.2)
    disc = obstacle(*circle([0.1, 0.2], 0.5), whole=True)
    polygon = 200 * np.sin(2 * np.pi / 400)  # of radius 1
    near("a disc", np.sum(area(*surfaces.seen_of(disc, 0.0, 0.1))), polygon * 0.25)
    rim = obstacle(*circle([0.1, 0.2], 0.5))
    near("of a part of a disc a strip", np.sum(area(*surfaces.seen_of(rim, 0.0, 0.1))), polygon * (0.5**2 - 0.4**2), 1e-3)
    hole = obstacle(*circle([0.1, 0.2], 0.5, inside=True), whole=True)
    near("around a hole", np.sum(area(*surfaces.seen_of(hole, 0.0, 0.1))), polygon * (0.6**2 - 0.5**2), 1e-3)
    assert len(surfaces.seen_of(obstacle(np.empty((0, 2)), np.empty((0, 2), int)), 0.0, 0.2)[1]) == 0


def places_along_boundaries() -> None:
    """Arc length along a square's boundary, whose parts end where a node lies between that is no candidate; middles of edges count."""
    points, number = grid([1.0, 1], [5, 5]), np.arange(25).reshape(5, 5)
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    cells = np.stack([part.ravel() for part in corners], axis=1)[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    mesh = Mesh(points, cells)
    (loop,) = mesh.loops()
    assert loop[0] == loop[-1] and len(set(loop)) == 16 and set(loop) == set(mesh.boundary_nodes())
    bottom = np.array([[0.5, 0], [0, 0], [1, 0], [0.25, 0], [0.75, 0], [0.375, 0]])
    arc = arc_of(mesh, bottom, 0)
    near("in order", bottom[arc.order, 0], [0, 0.25, 0.375, 0.5, 0.75, 1])
    near("from the one that is pushed", arc.position, [-0.5, -0.25, -0.125, 0, 0.25, 0.5])
    assert not arc.part.any() and list(arc.rows()[arc.order]) == [0, 1, 2, 3, 4, 5] and len(arc.edges()) == 7
    both = np.concatenate([bottom, bottom + [0, 1]])
    arc = arc_of(mesh, both, 2)
    assert sorted(set(arc.part)) == [0, 1] and len(set(arc.rows())) == 12 and set(range(13)) - set(arc.rows()) == {6}
    near("each part is as long as its side", [np.ptp(arc.position[arc.part == part]) for part in (0, 1)], [1, 1])
    near("and far from the other", np.min(np.abs(arc.position[arc.part == 0][:, None] - arc.position[arc.part == 1])), 0.3 * 2)
    corner = np.array([[0, 0], [0.25, 0], [0, 0.25], [0.75, 0]])
    arc = arc_of(mesh, corner, 0)
    assert sorted(np.bincount(arc.part)) == [1, 3], "the corner is one part, and the node between is none of them"
    everyone = points[mesh.boundary_nodes()]
    arc = arc_of(mesh, everyone, 3)
    assert not arc.part.any() and list(arc.order).index(3) in (7, 8), "a closed boundary is opened opposite the contact"
    near("all around", np.diff(arc.position), np.full(15, 0.25))
    ring = np.concatenate([circle([0, 0], 1, 20)[0], circle([0, 0], 0.5, 20)[0]])
    after = np.roll(np.arange(20), -1)
    cells = np.concatenate([np.stack([np.arange(20), after, np.arange(20) + 20], axis=1), np.stack([after, after + 20, np.arange(20) + 20], axis=1)])
    assert sorted(map(len, Mesh(ring, cells).loops())) == [21, 21]
    arc = arc_of(Mesh(ring, cells), ring, 5)
    assert np.bincount(arc.part).tolist() == [20, 20], "a hole has a boundary of its own"


def bodies(folder: Path) -> None:
    """Boundary and size of a rectangle and a box, and values of cells at nodes."""
    points = grid([3.0, 2], [4, 3])
    number = np.arange(12).reshape(4, 3)
    low = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    cells = np.stack([part.ravel() for part in low], axis=1)[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    flat = Mesh(points, cells)
    edges, of = flat.facets()
    near("length of the boundary", np.sum(np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)), 10)
    assert np.array_equal(edges, flat.outline()) and all(set(edge) <= set(cells[cell]) for edge, cell in zip(edges.tolist(), of))
    assert list(flat.boundary_nodes()) == [n for n in range(12) if n not in (4, 7)] and flat.size == 3
    inside, cells = box_of([2.0, 2, 4], [3, 3, 5])
    solid = Mesh(inside, cells)
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

    def seen(one: Obstacle) -> tuple[object, np.ndarray]:
        found, box = scenery.scenery([one], times, position, size)
        assert len(found) == 1
        return found[0], box

    slot = np.array([[0.0, 0], [2, 1]]) + scenery.MARGIN * size * np.array([[-1], [1]])
    line = np.array([[-5.0, -0.5], [9, -0.5]]), [[0, 1]]
    still, box = seen(obstacle(*line, flat=True))
    near("the body and a margin", box, slot)
    assert len(still.shapes) == 1 and list(still.shape) == [0] * 5 and not still.offset.any()
    assert report_motion.packed_scenery(still, 5)["offset"] is None
    way = np.stack([np.zeros(5), times - 0.5], axis=1)
    rising, _ = seen(obstacle(*line, flat=True, displacement=np.tile(way[:, None], (1, 2, 1))))
    where = [points + rising.offset[i] for i, (points, _) in ((i, rising.shapes[rising.shape[i]]) for i in range(5))]
    near("where it is in each frame", [points[:, 1].max() for points in where], times - 1)
    assert report_motion.packed_scenery(rising, 5)["offset"] is not None, "it moves along one axis alone"
    points, segments = circle([1, -0.6], 0.5)
    growth = 0.5 * times[:, None, None] * (points - [1, -0.6])
    growing, box = seen(obstacle(points, segments, whole=True, displacement=growth))
    assert len(growing.shapes) == 5 and list(growing.shape) == [0, 1, 2, 3, 4] and not growing.offset.any()
    near("its size in each frame", [np.ptp(points[:, 0]) for points, _ in growing.shapes], 1 + times / 2, 0.01)
    near("all of it is in the picture", box[0, 1], -1.35 - scenery.BAND * size)
    assert scenery.scenery([obstacle(*circle([1, 9], 1), whole=True)], times, position, size)[0] == []
    # One with another surface at each time: its points are drawn where their motion, enlarged, takes them.
    first = {"first_point": np.array([0, 2, 5, 7, 9, 11]), "first_facet": np.array([0, 1, 3, 4, 5, 6])}
    line = np.column_stack([np.arange(11.0), np.zeros(11)])
    facets = [[0, 1], [0, 1], [1, 2], [0, 1], [0, 1], [0, 1]]
    changing = obstacle(line, facets, displacement=np.column_stack([np.zeros(11), np.repeat(times, np.diff(first["first_point"]))]), **first)
    points, segments = changing.drawn(3.0, np.array([0, 10.0])).at(0.25)
    near("of its time alone", points, [[2, 10.75], [3, 10.75], [4, 10.75]])
    assert segments.tolist() == [[0, 1], [1, 2]] and changing.moves and not changing.rigid
    # Of the candidates those that ever touch tell how near it is.
    force = np.array([[0.0, 1, 0], [0, 0, 0], [0, 1, 2]])
    three = obstacle(*circle([0, 0], 1), gap=np.array([0.1, 0.3, 0.2]), normal=np.array([[0.0, 1], [1, 0], [0.6, 0.8]]))
    for pushes, nearest in ((force, 2), (0 * force, 0), (None, 0)):
        contact = SimpleNamespace(of=lambda number, pushes=pushes: SimpleNamespace(force=pushes))
        run = SimpleNamespace(has_contact_table=pushes is not None, contact=contact, obstacles=[three])
        (drawn,) = scenery.drawn_obstacles(run, 5.0)
        near("its gap is enlarged", drawn.shift, -4 * three.gap[nearest] * three.normal[nearest])


def main() -> int:
    beside_the_body()
    side_by_side()
    pictures()
    level_surfaces()
    places_along_boundaries()
    bands()
    with tempfile.TemporaryDirectory() as name:
        bodies(Path(name))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
