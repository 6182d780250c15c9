# SPDX-License-Identifier: GPL-3.0-or-later
"""Files from elsewhere: what other programs write into a .geo, a mesh, a folder or a name changes no result, or is refused."""

import json
import os
import struct
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from harness import SIGNORINI, captured
from soft_scenes import soft

SQUARE = """Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Point(3) = {1, 1, 0}; Point(4) = {0, 1, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1}; Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
"""
GROUPS = 'Physical Surface("body") = {1}; Physical Curve("bottom") = {1};\n'
SIZES = (0.3, 0.1)


def run(folder: Path, *words: str, status: int = 0) -> str:
    """Runs in a folder, which the returned text does not name."""
    done = captured([str(SIGNORINI), *words], cwd=folder)
    assert done.returncode == status, f"{words} ended with {done.returncode}: {done.stdout}{done.stderr}"
    return (done.stdout if status == 0 else done.stderr).replace(f"{folder}/", "")


def cells(folder: Path, geo: str, size: float | None) -> int:
    """Number of cells of the mesh that is made of a .geo."""
    (folder / "body.geo").write_text(geo + "\n")
    text = soft("square.geo", size or 0.1, 0.1, 0.02)
    lines = [line for line in text.splitlines() if size or not line.startswith("size")]
    file = next(line for line in lines if line.startswith("file"))
    (folder / "scene.toml").write_text("\n".join(lines).replace(file, 'file = "body.geo"'))
    run(folder, "simulate", "scene.toml", "--out", "out", "--replace", "--quiet", "--set", "output.fields=[]")
    return json.loads((folder / "out" / "run.json").read_text())["cells"]


@pytest.fixture(scope="module")
def expected_cells(tmp_path_factory: pytest.TempPathFactory) -> list[int]:
    """Numbers of cells of the square for each of SIZES."""
    folder = tmp_path_factory.mktemp("square")
    expected = [cells(folder, SQUARE + GROUPS, size) for size in SIZES]
    assert expected[1] > 5 * expected[0]
    return expected


SAVES_ITS_MESH = "Mesh.MeshSizeMax = 0.5; Mesh 2;" + GROUPS + 'Save "own.msh";'
MERGES_IT = 'Merge "own.msh";\n' + GROUPS


@pytest.mark.parametrize("commands",
                         (GROUPS + "Mesh 1;", GROUPS + "Mesh 2;", SAVES_ITS_MESH, GROUPS + "Mesh.MeshSizeMin = 0.01; Mesh 2; RefineMesh;"),
                         ids=("curves", "surface", "saved", "refined"))  # fmt: skip
def test_geo_that_meshes_itself_has_elements_of_mesh_size(commands: str, expected_cells: list[int], tmp_path: Path) -> None:
    assert [cells(tmp_path, SQUARE + commands, size) for size in SIZES] == expected_cells


def test_merged_mesh_has_its_own_size_alone(tmp_path: Path) -> None:
    cells(tmp_path, SQUARE + SAVES_ITS_MESH, SIZES[0])
    (tmp_path / "body.geo").write_text(MERGES_IT)
    said = run(tmp_path, "info", "scene.toml", status=2)
    assert "mesh.size: has no effect" in said and "merges a mesh" in said
    assert cells(tmp_path, MERGES_IT, None) > 4


def test_options_of_petsc_in_a_file_are_not_read(tmp_path: Path) -> None:
    """Such a file in the folder of a run could load code and overwrite files."""
    cells(tmp_path, SQUARE + GROUPS, 0.3)
    (tmp_path / ".petscrc").write_text("-log_view :log.txt\n")
    run(tmp_path, "simulate", "scene.toml", "--out", "out", "--replace", "--quiet")
    assert not (tmp_path / "log.txt").exists(), ".petscrc was read"
    (tmp_path / ".petscrc").unlink()
    run(tmp_path, "simulate", "scene.toml", "--out", "out", "--replace", "--quiet", "--", "-log_view", ":log.txt")
    assert (tmp_path / "log.txt").exists(), "options after -- are still PETSc's, or nothing is shown by this"


def test_scene_whose_name_is_not_utf8(tmp_path: Path) -> None:
    """It has results like any other."""
    cells(tmp_path, SQUARE + GROUPS, 0.3)
    name = os.fsdecode(b"caf\xe9.toml")
    (tmp_path / "scene.toml").rename(tmp_path / name)
    run(tmp_path, "simulate", name, "--out", "latin", "--quiet")
    run(tmp_path, "study", name, "--out", "latin-study", "--sizes", "0.5,0.3", "--steps", "0.02", "--quantity", "displacement", "--quiet")
    for file in ("latin/run.json", "latin-study/study.json"):
        assert json.loads((tmp_path / file).read_text())["scene"] == "caf\ufffd"


# --- Meshes of others ---------------------------------------------------------------------------------------------------

LINE, TRIANGLE, QUADRILATERAL, TETRAHEDRON, POINT = 1, 2, 3, 4, 15
NODES = {LINE: 2, TRIANGLE: 3, QUADRILATERAL: 4, TETRAHEDRON: 4, POINT: 1}
CORNERS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0), (0.5, 0.5, 0.0)]
QUARTERS = [(1, 2, 5), (2, 3, 5), (3, 4, 5), (4, 1, 5)]
SIDES = [(1, 2), (2, 3), (3, 4), (4, 1)]
NAMES = {(1, 2): "bottom", (1, 3): "top", (2, 1): "body"}
Rows = list[tuple[int, int, int, tuple[int, ...]]]  # gmsh's type, group, entity, nodes
# Four triangles, the lower side and the upper one, each an entity of its own.
WHOLE: Rows = [(TRIANGLE, 1, 1, nodes) for nodes in QUARTERS] + [(LINE, 2, 2, SIDES[0]), (LINE, 3, 3, SIDES[2])]
CUBE = [(x, y, z) for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)]
TETRAHEDRA: Rows = [(TETRAHEDRON, 1, 1, (1, a, b, 8)) for a, b in ((2, 4), (4, 3), (3, 7), (7, 5), (5, 6), (6, 2))]
FLOOR: Rows = [(TRIANGLE, 2, 2, nodes) for nodes in ((1, 2, 4), (1, 4, 3))]
IN_SPACE = {(2, 2): "bottom", (3, 1): "body"}


def msh2(rows: Rows = WHOLE, names: dict[tuple[int, int], str] = NAMES, points: list = CORNERS, version: str = "2.2", end: str = "\n",
         numbers: list | None = None) -> str:  # fmt: skip
    """MSH 2 as text."""
    lines = ["$MeshFormat", f"{version} 0 8", "$EndMeshFormat"]
    if names:
        lines += ["$PhysicalNames", str(len(names)), *(f'{dim} {tag} "{name}"' for (dim, tag), name in names.items()), "$EndPhysicalNames"]
    lines += ["$Nodes", str(len(points)), *(f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(points, 1)), "$EndNodes", "$Elements",
              str(len(rows))]
    for i, (kind, group, entity, nodes) in enumerate(rows):
        lines.append(" ".join(map(str, [numbers[i] if numbers else i + 1, kind, 2, group, entity, *nodes])))
    return end.join([*lines, "$EndElements", ""])


def binary2(rows: Rows = WHOLE, names: dict[tuple[int, int], str] = NAMES, points: list = CORNERS, glue: bytes = b"\n",
            order: str = "<") -> bytes:
    """The same in binary, which many writers end without a line's end behind the data."""
    text = msh2([], names, points)
    data = text[:text.index("$Nodes")].replace("2.2 0 8\n", "2.2 1 8\n\0").encode().replace(b"\0", struct.pack(order + "i", 1) + b"\n")
    data += b"$Nodes\n%d\n" % len(points) + b"".join(struct.pack(order + "i3d", i, *x) for i, x in enumerate(points, 1))
    data += glue + b"$EndNodes\n$Elements\n%d\n" % len(rows)
    for i, (kind, group, entity, nodes) in enumerate(rows, 1):
        data += struct.pack(order + "3i", kind, 1, 2) + struct.pack(f"{order}{3 + len(nodes)}i", i, group, entity, *nodes)
    return data + glue + b"$EndElements\n"


def msh4(groups: bool = True) -> str:
    """The square in MSH 4.1, as converters write it: without entities there are no groups."""
    text = msh2()
    entities = ["$Entities", "0 2 1 0", "2 0 0 0 1 0 0 1 2 0", "3 0 1 0 1 1 0 1 3 0", "1 0 0 0 1 1 0 1 1 0",
                "$EndEntities"] if groups else []
    nodes = ["$Nodes", "1 5 1 5", "2 1 0 5", *"12345", *(f"{x} {y} {z}" for x, y, z in CORNERS), "$EndNodes"]
    elements = ["$Elements", "3 6 1 6", "2 1 2 4", *(f"{i} {a} {b} {c}" for i, (a, b, c) in enumerate(QUARTERS, 1)), "1 2 1 1", "5 1 2",
                "1 3 1 1", "6 3 4",
                "$EndElements", ""]  # fmt: skip
    return "\n".join([text[:text.index("$Nodes")].replace("2.2", "4.1").rstrip(), *entities, *nodes, *elements])


def with_rows(*rows: tuple[int, int, int, tuple[int, ...]]) -> Rows:
    return [*WHOLE, *rows]


@dataclass
class Foreign:
    """A mesh, and what is right for it: its cells, the nodes of the contact group and the mass of density 1; or what its refusal says."""

    name: str
    mesh: str | bytes
    right: tuple | str
    on: str = "bottom"
    suffix: str = "msh"
    dim: int = 2
    size: float | None = None
    material: str = "[material]"
    said: str = ""  # in a note
    maker: str = ""  # a .geo that saves the mesh
    sets: tuple[str, ...] = ()
    ended: bool = True  # whether the last line of a .geo is

    def scene(self, file: str) -> str:
        down = [0] * (self.dim - 1)
        return f"""[mesh]
file = "{file}"
{f"size = {self.size}" if self.size else ""}
[time]
end = 0.002
step = 1e-3
{self.material}
density = 1.0
young = 1e4
poisson = 0.3
[load]
gravity = {[*down, -9.81]}
[contact]
on = "{self.on}"
obstacle = {{ shape = "half-space", point = {[*down, -0.01]}, normal = {[*down, 1]} }}
"""


TWO_SQUARES = SQUARE + """Point(5) = {2, 0, 0}; Point(6) = {2, 1, 0}; Line(5) = {2, 5}; Line(6) = {5, 6}; Line(7) = {6, 3};
Curve Loop(2) = {5, 6, 7, -2}; Plane Surface(2) = {2};
"""
BOX = 'SetFactory("OpenCASCADE"); Box(1) = {0, 0, 0, 1, 1, 1}; Physical Volume("body") = {1}; Physical Surface("bottom") = {5};\n'
CELL = 'no triangle of the mesh is in a physical group; all are the group "body"'
EDGE = 'no edge of the body is in a physical group; its whole boundary is the group "boundary"'
AS_DRAWN = "as the same drawing without what is foreign"


def foreign() -> list[Foreign]:
    whole, cube = (4, 2, 1), (6, 4, 1)
    body_twice = [(TRIANGLE, group, 1, nodes) for group in (1, 4) for nodes in QUARTERS] + WHOLE[4:]
    in_part = [*WHOLE, *((TRIANGLE, 4, 1, nodes) for nodes in QUARTERS[1:3])]
    steel = {**NAMES, (2, 4): "steel"}
    of_steel = '[[material]]\non = "steel"\ndensity = 3.0\nyoung = 1e4\npoisson = 0.3\n[[material]]\non = "rest"'
    rest = {**steel, (2, 5): "rest"}
    halves = in_part + [(TRIANGLE, 5, 1, nodes) for nodes in (QUARTERS[0], QUARTERS[3])]
    twice_in_space = [*TETRAHEDRA, *((TETRAHEDRON, 4, 1, row[3]) for row in TETRAHEDRA), *FLOOR]
    drawn = 'Point(10) = {-2, -0.01, 0}; Point(11) = {3, -0.01, 0}; Line(10) = {10, 11}; Physical Curve("ground") = {10};\n'
    untagged = [(kind, 0, entity, nodes) for kind, _, entity, nodes in WHOLE]
    second = [(0.5, 0.0, 0.0), (0.75, 0.25, 0.0), (0.25, 0.25, 0.0)]
    cell = CELL
    edge = EDGE
    geo = {"suffix": "geo", "size": 0.3}
    plate = msh2(thin(), {(1, 1): "skin", (2, 2): "body"}, PLATE)
    massless = 'contact.mass="massless"'
    jaw = '{{on="skin", mass="massless", obstacle={{shape="half-space", point=[0, {}], normal=[0, {}]}}}}'
    jaws = f"contact=[{jaw.format(-0.01, 1)}, {jaw.format(0.11, -1)}]"
    return [
        Foreign("2.2, each cell in two groups", msh2(body_twice, steel), whole),
        Foreign("2.2, tetrahedra in two groups", msh2(twice_in_space, {**IN_SPACE, (3, 4): "all"}, CUBE), cube, dim=3),
        Foreign("2.2, groups that overlap in part", msh2(halves, rest), (4, 2, 2), material=of_steel),
        Foreign("2.2, groups that overlap in part, binary", binary2(halves, rest), (4, 2, 2), material=of_steel),
        Foreign("2.2, tetrahedra in two groups, binary", binary2(twice_in_space, {**IN_SPACE, (3, 4): "all"}, CUBE), cube, dim=3),
        Foreign("2.2, every element of entity 1", msh2([(kind, group, 1, nodes) for kind, group, _, nodes in WHOLE]), whole),
        Foreign("2.2, every element of entity 0", msh2([(kind, group, 0, nodes) for kind, group, _, nodes in WHOLE]), whole),
        Foreign("2.2, a cell twice in its group", msh2(with_rows(WHOLE[0])), ("the triangle at (0, 0) is in the mesh twice",)),
        Foreign("2.1", msh2(version="2.1"), whole),
        Foreign("2, lines of another system", msh2(end="\r\n"), whole),
        Foreign("2.2, a node that nothing uses", msh2(points=[*CORNERS, (7.0, 7.0, 7.0)]), whole),
        Foreign("2.2, numbers of elements with gaps", msh2(numbers=[7, 3, 100, 50, 2, 9]), whole),
        Foreign("2.2, numbers of elements begin anew", msh2(numbers=[1, 2, 3, 4, 1, 2]),
                ("announces 6 elements, but has only 4 different element numbers", "renumber them")),
        Foreign("2.2, two nodes of one number", msh2(points=[*CORNERS, (7.0, 7.0, 0.0)]).replace("\n6 7.0", "\n5 7.0"),
                ("node number 5 occurs twice", "renumber the nodes")),
        Foreign("2.2, two groups of one name", msh2(names={(1, 2): "side", (1, 3): "side", (2, 1): "body"}), (4, 4, 1), on="side"),
        Foreign("2.2, groups of negative numbers", msh2([(kind, -group, entity, nodes) for kind, group, entity, nodes in WHOLE]), whole),
        Foreign("2.2 binary, data glued to the end", binary2(glue=b""), whole),
        Foreign("2.2 binary, of the other byte order", binary2(order=">"), whole),
        Foreign("2.2 binary, cut short", binary2(glue=b"")[:-20], ("incomplete .msh file", "write the file again")),
        Foreign("text behind the last section", msh2() + "written by some program, for $5\n", whole),
        Foreign("a section of its own behind the elements", msh2() + "$Origin\nsome program\n$EndOrigin\n", whole),
        Foreign("format 1", "$NOD\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$ENDNOD\n$ELM\n1\n1 2 1 1 3 1 2 3\n$ENDELM\n",
                ("not a .msh file of gmsh", "$MeshFormat", "convert")),
        Foreign("a .msh of another program", '(0 "made elsewhere")\n(2 2)\n(10 (0 1 4 0 2))\n', ("not a .msh file of gmsh", "meshio")),
        Foreign("4.1", msh4(), whole),
        Foreign("4.1, two groups of one name", msh4().replace("top", "bottom"), (4, 4, 1)),
        Foreign("4.1 without entities", msh4(groups=False), ("Unknown entity", "write the file again", "MSH 2.2")),
        Foreign("without any group", msh2(untagged, {}), (4, 4, 1), on="boundary", said=edge),
        Foreign("without a group of cells", msh2(untagged[:4] + WHOLE[4:]), whole, said=cell),
        Foreign("without a group of the boundary", msh2(WHOLE[:4], {}), (4, 4, 1), on="boundary", said=edge),
        Foreign("one cell of four in a group", msh2([WHOLE[0], *((TRIANGLE, 0, 7, nodes) for nodes in QUARTERS[1:]), *WHOLE[4:]]),
                ("surface 7 has 3 triangles in no physical group", 'Physical Surface("body") = {7}')),
        Foreign("a measuring line across the body", msh2(with_rows((LINE, 9, 9, (1, 3))), {**NAMES, (1, 9): "line"}), whole),
        Foreign("contact on a line across the body", msh2(with_rows((LINE, 9, 9, (1, 3))), {**NAMES, (1, 9): "line"}),
                ('contact.on: the group "line"', "the edge at (0, 0), which belongs to no triangle"), on="line"),
        Foreign("a floor of quadrilaterals below a cube", msh2([*TETRAHEDRA, *FLOOR, (QUADRILATERAL, 9, 9, (9, 10, 12, 11))], IN_SPACE,
                                                               [*CUBE, (-1, -1, -0.01), (2, -1, -0.01), (-1, 2, -0.01), (2, 2, -0.01)]),
                cube, dim=3),
        Foreign("a floor of triangles below a cube", msh2([*TETRAHEDRA, *FLOOR, (TRIANGLE, 9, 9, (9, 10, 12))], IN_SPACE,
                                                          [*CUBE, (-1, -1, -0.01), (2, -1, -0.01), (-1, 2, -0.01), (2, 2, -0.01)]), cube,
                dim=3),
        Foreign("cells of second order", msh2([(9, 1, 1, (1, 2, 5, 6, 7, 8))], points=[*CORNERS, *second]),
                (1, 3, 0.25), on="boundary", said="1 elements of higher order are taken at their vertices"),
        Foreign("quadrilaterals", msh2([(QUADRILATERAL, 1, 1, (1, 2, 3, 4))]), ("Quadrilateral", "set mesh.split = true")),
        Foreign("a plane mesh at z = 1", msh2(points=[(x, y, 1.0) for x, y, _ in CORNERS]), ("plane z = 0", "1 m")),
        Foreign("a group named as the number of another", msh2(names={(2, 1): "body", (1, 2): "3"}),
                ('contact.on: the group "3"', "give the unnamed group a name"), on="3"),
        Foreign("groups by number", msh2(names={}), whole, on="2"),
        *(Foreign(f"{version}{', binary' if binary else ''}, ghost cells", "", AS_DRAWN,
                  maker=SQUARE + GROUPS + f"""Mesh.MeshSizeMax = 0.3; Mesh.MeshSizeMin = 0.3;
Mesh 2; Mesh.PartitionCreateGhostCells = 1; PartitionMesh 3; Mesh.MshFileVersion = {version}; Mesh.Binary = {binary}; Save "foreign.msh";
""") for version, binary in ((4.1, 0), (4.1, 1), (2.2, 0))),
        Foreign(".geo of second order", SQUARE + GROUPS + "Mesh.ElementOrder = 2;", AS_DRAWN, **geo,
                said="Mesh.ElementOrder = 2 of the .geo has no effect"),
        Foreign(".geo of quadrilaterals", SQUARE + GROUPS + "Mesh.RecombineAll = 1;", AS_DRAWN, **geo,
                said="Mesh.RecombineAll = 1 of the .geo has no effect"),
        Foreign(".geo that recombines its surface", SQUARE + GROUPS + "Recombine Surface{1};", ("Quadrilateral", "set mesh.split = true"),
                **geo),
        Foreign(".geo with a floor that is drawn", SQUARE + GROUPS + drawn, AS_DRAWN, **geo),
        Foreign(".geo, contact on a floor that is drawn", SQUARE + GROUPS + drawn,
                ('contact.on: the group "ground"', "which belongs to no triangle"),
                on="ground", **geo),
        Foreign(".geo without groups", SQUARE, AS_DRAWN, on="boundary", **geo, said=cell),
        Foreign(".geo whose group 5 and group \"5\" are two",
                SQUARE + 'Physical Surface("body", 7) = {1}; Physical Curve("5", 3) = {3}; Physical Curve(5) = {1};',
                ('contact.on: the group "5"', "give the unnamed group a name"), on="5", **geo),
        Foreign(".geo with a surface in no group", TWO_SQUARES + GROUPS, ("surface 2 has", 'Physical Surface("body") = {2}', "delete it"),
                **geo),
        Foreign(".geo that divides its mesh among processes",
                SQUARE + GROUPS + "Mesh 2; Mesh.PartitionCreateGhostCells = 1; PartitionMesh 3;", AS_DRAWN, **geo),
        Foreign(".geo whose group lists a curve that is not drawn", SQUARE + GROUPS.replace("= {1};\n", "= {1, 99};\n"),
                ('contact.on: the group "bottom"', "lists curve 99, which does not exist", "correct the list"), **geo),
        Foreign(".geo whose unused group lists a curve that is not drawn", SQUARE + GROUPS + 'Physical Curve("old") = {3, 99};', AS_DRAWN,
                **geo),
        Foreign(".geo whose last line has no end", SQUARE + GROUPS.strip(), ("several statements but no newline", "add a newline"),
                **geo, ended=False),
        Foreign(".geo whose last statement has no end", SQUARE + GROUPS + "MeshSize{1} = 0.3; // a comment", AS_DRAWN, **geo, ended=False),
        Foreign(".geo that ends gmsh", SQUARE + GROUPS + "Exit;", ("gmsh stopped before the end of this file", "Exit"), **geo),
        Foreign(".geo that ends gmsh before it draws", 'If (1) Printf("usage"); Exit 2; EndIf\n' + SQUARE, ("gmsh stopped", "Exit"), **geo),
        Foreign(".geo of a box", BOX + "Mesh.ElementOrder = 2; Mesh 3;", (None, None, 1), dim=3, suffix="geo", size=0.6,
                said="Mesh.ElementOrder = 2"),
        Foreign("a face in the floor by rounding", SQUARE + GROUPS,
                ("1e-09 m inside", "as do all 5 candidates", 'contact.initial = "project"'), **geo,
                sets=("contact.obstacle.point=[0, 1e-9]",)),
        Foreign("a face in the floor by rounding, projected", SQUARE + GROUPS, AS_DRAWN, **geo,
                sets=("contact.obstacle.point=[0, 1e-9]", 'contact.initial="project"')),
        Foreign("a face in a floor that is turned over", SQUARE + GROUPS, ("0.01 m inside", "reverse the obstacle's normal"), **geo,
                sets=("contact.obstacle.normal=[0, -1]",)),
        Foreign("a massless skin, one cell thick", plate, (20, 22, 0.1), on="skin", sets=(massless,)),
        Foreign("a massless skin between two jaws, one cell thick", plate,
                ("contact.mass: ", "are contact nodes, so none can take its mass", "mesh.degree = 2", "smaller group"), on="skin", sets=(jaws,)),
        Foreign("a massless skin between two jaws, of degree 2", plate, (20, 88, 0.1), on="skin", sets=(jaws, "mesh.degree=2")),
    ]  # fmt: skip


PLATE = [(i / 10, 0.1 * j, 0.0) for j in (0, 1) for i in range(11)]


def thin() -> Rows:
    """A plate of one cell through its thickness, its whole boundary in one group."""
    cells = [nodes for i in range(1, 11) for nodes in ((i, i + 1, i + 12), (i, i + 12, i + 11))]
    skin = [*((i, i + 1) for i in range(1, 11)), *((i, i + 1) for i in range(12, 22)), (1, 12), (11, 22)]
    return [(LINE, 1, 1, nodes) for nodes in skin] + [(TRIANGLE, 2, 2, nodes) for nodes in cells]


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> tuple[int, int, float]:
    """Cells, candidates and mass of the plain drawing."""
    folder = tmp_path_factory.mktemp("drawn")
    (folder / "drawn.geo").write_text(SQUARE + GROUPS + "\n")
    (folder / "scene.toml").write_text(Foreign("", "", (), suffix="geo", size=0.3).scene("drawn.geo"))
    run(folder, "simulate", "scene.toml", "--out", "out", "--quiet", "--set", "output.fields=[]")
    manifest = json.loads((folder / "out" / "run.json").read_text())
    assert manifest["cells"] > 30 and manifest["candidates"] > 3
    return manifest["cells"], manifest["candidates"], 1


def simulate(case: Foreign, folder: Path, status: int = 0) -> str:
    """Writes the mesh, or lets gmsh write it, and runs its scene."""
    file = f"foreign.{case.suffix}"
    if case.maker:
        (folder / "maker.geo").write_text(case.maker)
        (folder / "scene.toml").write_text(replace(case, size=0.3).scene("maker.geo"))
        run(folder, "info", "scene.toml")
    else:
        mesh = case.mesh.encode() if isinstance(case.mesh, str) else case.mesh
        (folder / file).write_bytes(mesh + b"\n" * (case.suffix == "geo" and case.ended))
    (folder / "scene.toml").write_text(case.scene(file))
    words = ("simulate", "scene.toml", "--out", "out", "--set", "output.fields=[]", *(f"--set={word}" for word in case.sets))
    return run(folder, *words, status=status)


CASES = foreign()
REFUSED = [case for case in CASES if isinstance(case.right, tuple) and isinstance(case.right[0], str)]
READ = [case for case in CASES if case not in REFUSED]


@pytest.mark.parametrize("case", REFUSED, ids=lambda case: case.name)
def test_refused_by_one_sentence(case: Foreign, tmp_path: Path) -> None:
    """It says what to do."""
    said = simulate(case, tmp_path, status=2)
    assert not [part for part in case.right if part not in said] and len(said.strip().splitlines()) == 1


@pytest.mark.parametrize("case", READ, ids=lambda case: case.name)
def test_read_as_it_is_meant(case: Foreign, drawn: tuple[int, int, float], tmp_path: Path) -> None:
    said = simulate(case, tmp_path)
    assert f"note: {case.said}" in said if case.said else "note: " not in said
    manifest = json.loads((tmp_path / "out" / "run.json").read_text())
    cells, candidates, mass = drawn if case.right == AS_DRAWN else case.right
    if case.on == "boundary" and case.right == AS_DRAWN:
        candidates = 4 * (candidates - 1)
    assert cells in (manifest["cells"], None) and candidates in (manifest["candidates"], None)
    assert manifest["body"]["mass"] == pytest.approx(mass, rel=1e-12, abs=0)
    notes = manifest["body"]["notes"]
    assert bool(notes) == bool(case.said) and all(f"note: {note}" in said for note in notes)


def test_mesh_that_a_run_keeps_of_a_geo(tmp_path: Path) -> None:
    """It has all cells, which need no group, and is read as they were."""
    (tmp_path / "drawn.geo").write_text(SQUARE + 'Physical Curve("bottom") = {1};\n')
    text = Foreign("", "", ()).scene("drawn.geo").replace('file = "drawn.geo"', 'file = "drawn.geo"\nsize = "auto"')
    (tmp_path / "scene.toml").write_text(text)
    run(tmp_path, "simulate", "scene.toml", "--out", "first", "--accuracy", "0.5", "--quantity", "displacement", "--quiet")
    run(tmp_path, "simulate", "first/scene.toml", "--out", "second", "--quiet")
    first, second = (json.loads((tmp_path / out / "run.json").read_text()) for out in ("first", "second"))
    for key in ("cells", "candidates", "body"):
        assert first[key] == second[key]
    assert first["body"]["notes"] == [CELL]
