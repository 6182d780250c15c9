# SPDX-License-Identifier: GPL-3.0-or-later
"""One bad input: a scene that runs, meshes for it, and how a case spoils them."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

Expected = str | re.Pattern[str]  # a fragment of the message, or a pattern that it must contain
Point = tuple[float, float, float]
Element = tuple[int, int, int, tuple[int, ...]]  # gmsh's type, physical group, entity, nodes

SCENE = """\
[mesh]
file = "square.msh"

[time]
end = 1.5e-4
step = 5e-5

[material]
density = 1.0
young = 1e8
poisson = 0.3
viscosity = { bulk = 1e4, shear = 1e4 }

[[clamp]]
on = "top"

[contact]
on = "bottom"
obstacle = { shape = "half-space", point = [0, -0.1], normal = [0, 1] }

[load]
body = ["0", "-9.81"]

[initial]
displacement = ["0", "0"]
velocity = ["0", "0"]

[control]
scale = 1e6
lower = -2.0
upper = 2.0

[objective]
desired = { control = ["0", "-1"] }
alpha = 1e-2
gamma = 7.5e-4

[optimizer]
max_iterations = 1
tolerance = 1e-6

[solver]
vi = "condensed"
linear = "auto"

[output]
every = 1
"""

# --- Meshes, written by hand --------------------------------------------------------------------------------------------

BODY, TOP, BOTTOM, SIDE = 1, 2, 3, 4
GROUPS = ((2, BODY, "body"), (1, TOP, "top"), (1, BOTTOM, "bottom"), (1, SIDE, "side"))
LINE, TRIANGLE, QUADRILATERAL, TETRAHEDRON, PRISM, LINE_3, TRIANGLE_6 = 1, 2, 3, 4, 6, 8, 9


def square_points() -> list[Point]:
    """Nine nodes of the square -0.5 <= x <= 0.5, 0 <= y <= 1, row by row from below."""
    return [(x, y, 0.0) for y in (0.0, 0.5, 1.0) for x in (-0.5, 0.0, 0.5)]


def square_elements() -> list[Element]:
    """Eight triangles and the edges of the square."""
    triangles = []
    for corner in (1, 2, 4, 5):
        right, above, across = corner + 1, corner + 3, corner + 4
        triangles += [(corner, right, across), (corner, across, above)]
    edges = {BOTTOM: ((1, 2), (2, 3)), TOP: ((7, 8), (8, 9)), SIDE: ((1, 4), (4, 7), (3, 6), (6, 9))}
    return [(TRIANGLE, BODY, 1, nodes) for nodes in triangles] + [
        (LINE, group, group, nodes) for group, lines in edges.items() for nodes in lines
    ]


SPACE_GROUPS = ((3, BODY, "body"), (2, TOP, "top"), (2, BOTTOM, "bottom"))


def cube_points() -> list[Point]:
    """The corners of the cube -0.5 <= x, y <= 0.5, 0 <= z <= 1, the lower four first."""
    return [(x, y, z) for z in (0.0, 1.0) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]


def cube_elements() -> list[Element]:
    """Six tetrahedra around the diagonal from node 1 to node 8, and the triangles of the lower and the upper side."""
    tetrahedra = [(1, second, third, 8) for second, third in ((2, 4), (4, 3), (3, 7), (7, 5), (5, 6), (6, 2))]
    sides = {BOTTOM: ((1, 2, 4), (1, 4, 3)), TOP: ((5, 6, 8), (5, 8, 7))}
    return [(TETRAHEDRON, BODY, 1, nodes) for nodes in tetrahedra] + [
        (TRIANGLE, group, group, nodes) for group, triangles in sides.items() for nodes in triangles
    ]


def msh2(points: Sequence[Point], elements: Sequence[Element], groups: Iterable[tuple[int, int, str]] = GROUPS) -> str:
    """A mesh as gmsh's format 2.2."""
    names = [f'{dim} {tag} "{name}"' for dim, tag, name in groups]
    nodes = [f"{tag} {x} {y} {z}" for tag, (x, y, z) in enumerate(points, 1)]
    rows = [
        f"{tag} {kind} 2 {group} {entity} " + " ".join(map(str, corners))
        for tag, (kind, group, entity, corners) in enumerate(elements, 1)
    ]
    sections = [section("MeshFormat", ["2.2 0 8"])]
    if names:
        sections.append(section("PhysicalNames", [str(len(names)), *names]))
    sections.append(section("Nodes", [str(len(nodes)), *nodes]))
    sections.append(section("Elements", [str(len(rows)), *rows]))
    return "".join(sections)


def section(name: str, lines: Iterable[str]) -> str:
    """One section of a .msh."""
    return "\n".join([f"${name}", *lines, f"$End{name}", ""])


def square2(**changes: object) -> str:
    """The square as format 2.2, with other points, elements or groups."""
    parts = {"points": square_points(), "elements": square_elements(), **changes}
    return msh2(**parts)  # type: ignore[arg-type]


def cube2(**changes: object) -> str:
    """The cube as format 2.2, with other points, elements or groups."""
    parts = {"points": cube_points(), "elements": cube_elements(), "groups": SPACE_GROUPS, **changes}
    return msh2(**parts)  # type: ignore[arg-type]


def square4(empty_curve: bool = False) -> str:
    """The square as gmsh's format 4.1; with a curve in a group "nothing" that has no elements, if asked for."""
    groups = [*GROUPS, (1, 5, "nothing")] if empty_curve else list(GROUPS)
    curves = [tag for dim, tag, _ in groups if dim == 1]
    box = "-0.5 0 0 0.5 1 0"
    entities = [f"0 {len(curves)} 1 0"]
    entities += [f"{tag} {box} 1 {tag} 0" for tag in curves]
    entities += [f"1 {box} 1 {BODY} {len(curves)} " + " ".join(map(str, curves))]
    points, elements = square_points(), square_elements()
    nodes = [f"1 {len(points)} 1 {len(points)}", f"2 1 0 {len(points)}"]
    nodes += [str(tag) for tag in range(1, len(points) + 1)]
    nodes += [f"{x} {y} {z}" for x, y, z in points]
    blocks: dict[tuple[int, int], list[str]] = {}
    for tag, (kind, _, entity, corners) in enumerate(elements, 1):
        blocks.setdefault((kind, entity), []).append(f"{tag} " + " ".join(map(str, corners)))
    rows = [f"{len(blocks)} {len(elements)} 1 {len(elements)}"]
    for (kind, entity), own in blocks.items():
        rows += [f"{2 if kind == TRIANGLE else 1} {entity} {kind} {len(own)}", *own]
    names = [str(len(groups))] + [f'{dim} {tag} "{name}"' for dim, tag, name in groups]
    return (
        section("MeshFormat", ["4.1 0 8"])
        + section("PhysicalNames", names)
        + section("Entities", entities)
        + section("Nodes", nodes)
        + section("Elements", rows)
    )


def square_of_halves() -> str:
    """The square as format 2.2, its triangles in a group "left" (x < 0) and a group "right" in place of "body"."""
    left, right = BODY, 5
    groups = ((2, left, "left"), (2, right, "right"), *GROUPS[1:])
    points = square_points()
    elements = [
        (kind, right, 2, nodes) if kind == TRIANGLE and sum(points[n - 1][0] for n in nodes) > 0 else (kind, group, entity, nodes)
        for kind, group, entity, nodes in square_elements()
    ]
    return square2(elements=elements, groups=groups)


def moved(node: int, point: Point) -> list[Point]:
    """The square's points with one of them elsewhere."""
    points = square_points()
    points[node - 1] = point
    return points


def moved_corner(node: int, point: Point) -> list[Point]:
    """The cube's points with one of them elsewhere."""
    points = cube_points()
    points[node - 1] = point
    return points


def with_element(*elements: Element) -> list[Element]:
    """The square's elements and some more."""
    return square_elements() + list(elements)


def with_space_element(*elements: Element) -> list[Element]:
    """The cube's elements and some more."""
    return cube_elements() + list(elements)


def before(text: str, mark: str, lines: int = 0) -> str:
    """The start of a text up to some lines behind a mark: a file whose writing was cut short."""
    start = text.index(mark)
    return text[:start] + "".join(text[start:].splitlines(keepends=True)[:lines])


GEO = """\
Point(1) = {-0.5, 0, 0};
Point(2) = {0.5, 0, 0};
Point(3) = {0.5, 1, 0};
Point(4) = {-0.5, 1, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Surface("body") = {1};
Physical Curve("top") = {3};
Physical Curve("bottom") = {1};
"""


SPACE_GEO = GEO.replace('Physical Surface("body") = {1};\nPhysical Curve("top") = {3};\nPhysical Curve("bottom") = {1};\n', """\
Extrude {0, 0, 1} { Surface{1}; }
Physical Surface("bottom") = {1};
""")

# What makes a scene of the cube out of that of the square.
TO_SPACE = (
    ('file = "square.msh"', 'file = "cube.msh"'),
    ("point = [0, -0.1], normal = [0, 1]", "point = [0, 0, -0.1], normal = [0, 0, 1]"),
    ('body = ["0", "-9.81"]', 'body = ["0", "0", "-9.81"]'),
    ('displacement = ["0", "0"]', 'displacement = ["0", "0", "0"]'),
    ('velocity = ["0", "0"]', 'velocity = ["0", "0", "0"]'),
    ('control = ["0", "-1"]', 'control = ["0", "0", "-1"]'),
)


@dataclass(frozen=True)
class Case:
    """One bad input and what the message about it must contain."""

    name: str
    expect: tuple[Expected, ...]
    never: tuple[Expected, ...] = ()  # what the message must not contain
    edits: tuple[tuple[str, str], ...] = ()  # texts of the scene and what stands in their place
    at: str = ""  # the message must name the line of the scene on which this text begins
    scene: bytes | None = None  # the whole scene, in place of edits
    mesh: str | bytes | None = None  # in place of the square
    mesh_file: str = "square.msh"
    verb: str = "simulate"
    options: tuple[str, ...] = ()
    command: tuple[str, ...] | None = None  # the whole command line, in place of verb and options
    out: str = "results"
    earlier: bool = False  # the folder has an earlier run's results
    prepare: Callable[[Path], None] | None = None  # last change to the folder of the case
    largest_file: int | None = None  # bytes that a file can grow to, as on a full disk
    ranks: int = 1


def edited(name: str, old: str, new: str, *expect: Expected, **more: object) -> Case:
    """A scene in which `new` stands for `old`; the message must name the line where `new` begins."""
    more.setdefault("at", new.strip().splitlines()[0] if new.strip() else "")
    return Case(name, expect, edits=((old, new),), **more)  # type: ignore[arg-type]


def overridden(name: str, assignments: str | tuple[str, ...], *expect: Expected, **more: object) -> Case:
    """A scene with --set options; the message must name no line of the scene file, which says something else there."""
    given = (assignments,) if isinstance(assignments, str) else assignments
    options = tuple(word for assignment in given for word in ("--set", assignment))
    more.setdefault("never", (re.compile(r"\.toml:\d"),))
    return Case(name, expect, options=options, **more)  # type: ignore[arg-type]


def meshed(name: str, mesh: str | bytes, *expect: Expected, **more: object) -> Case:
    """A scene with another mesh; the message must name its file."""
    file = str(more.get("mesh_file", "square.msh"))
    return Case(name, (file, *expect), mesh=mesh, **more)  # type: ignore[arg-type]


def solid(name: str, mesh: str, *expect: Expected, edits: tuple[tuple[str, str], ...] = (), **more: object) -> Case:
    """A scene in space, with a mesh in place of the cube."""
    more = {"mesh_file": "cube.msh", **more}
    return Case(name, expect, mesh=mesh, edits=(*TO_SPACE, *edits), **more)  # type: ignore[arg-type]


def typed(name: str, words: str, *expect: Expected, **more: object) -> Case:
    """A whole command line."""
    return Case(name, expect, command=tuple(words.split()), **more)  # type: ignore[arg-type]


def write(path: Path, content: str | bytes) -> None:
    """Writes a whole file."""
    path.write_bytes(content.encode() if isinstance(content, str) else content)


def prepend(path: Path, text: str) -> None:
    """Puts text in front of a file's."""
    write(path, text + path.read_text())


def keep_tables(path: Path, names: Sequence[str]) -> None:
    """Drops all tables of a scene but some."""
    tables = re.split(r"(?m)^(?=\[)", path.read_text())
    write(path, "".join(table for table in tables if table[1:].startswith(tuple(name + "]" for name in names))))


def stored_run(folder: Path, points: Sequence[Point] | None = None, times: Sequence[float] = (0.0, 1.5e-4), dim: int = 2,
               field: str = "displacement", value: float = 0.0, cut: int | None = None,
               listed: Sequence[float] | None = None) -> None:
    """What a run on the square leaves in state.h5; `value` is one of its last time. `listed`: the array of times, if it is to be
    wrong."""
    folder.mkdir()
    nodes = np.array(square_points() if points is None else points)
    with h5py.File(folder / "state.h5", "w") as file:
        file["Mesh/mesh/geometry"] = nodes[:, :dim]
        displacement = np.zeros((len(nodes), 3))
        for name in [f"{number:08}" for number in range(len(times))]:
            file[f"Function/{field}/{name}"] = displacement
        file[f"Function/{field}/{name}"][4, 1] = value
        file["times"] = np.array(times if listed is None else listed)
    if cut:
        write(folder / "state.h5", (folder / "state.h5").read_bytes()[:cut])


def occupy(path: Path) -> None:
    """Puts a folder that is not empty in place of a file."""
    path.unlink(missing_ok=True)
    path.mkdir()
    write(path / "notes.txt", "keep me\n")
