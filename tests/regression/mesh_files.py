# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes and geometries of other programs: each file is that of a brick or a plate that moves as the same body does from a .msh, with
the names of its groups kept; or it is refused with the cure."""

import json
import re
import subprocess
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import meshio
import numpy as np
import pytest
from harness import SIGNORINI, attempt, captured, table

# A body of 1 m × 1 m (× 1 m) on its lower side, pressed by its weight onto a floor for a few steps.
SCENE = """[mesh]
file = "{file}"
{mesh}
[time]
end = 0.1
step = 0.01
[material]
density = 1.0
young = 100.0
poisson = 0.3
[contact]
on = "{floor}"
obstacle = {{ shape = "half-space", point = {point}, normal = {normal} }}
[load]
body = {load}
"""
SIDE = 1.0


def scene(folder: Path, file: str, dim: int = 3, floor: str = "floor", mesh: str = "") -> Path:
    path = folder / "scene.toml"
    up = [0] * (dim - 1) + [1]
    path.write_text(SCENE.format(file=file, mesh=mesh, floor=floor, point=[0] * dim, normal=up, load=["0"] * (dim - 1) + ["-10"]))
    return path


def grid(dim: int, n: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Points of a brick or plate of n^dim cells, and the cells, as quadrilaterals or hexahedra."""
    points = np.stack(np.meshgrid(*[np.linspace(0, SIDE, n + 1)] * dim, indexing="ij"), -1).reshape(-1, dim)
    corner = np.stack(np.meshgrid(*[np.arange(n)] * dim, indexing="ij"), -1).reshape(-1, dim)
    strides = (n + 1) ** np.arange(dim)[::-1]
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    offsets = square if dim == 2 else np.array([[*s, z] for z in (0, 1) for s in square])
    return np.pad(points, ((0, 0), (0, 3 - dim))), (corner[:, None] + offsets) @ strides


def simplices(cells: np.ndarray) -> np.ndarray:
    """Triangles or tetrahedra of quadrilaterals or hexahedra, around one diagonal of each."""
    if cells.shape[1] == 4:
        return cells[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    return cells[:, [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]].reshape(-1, 4)


def floor_nodes(points: np.ndarray, dim: int) -> np.ndarray:
    return np.flatnonzero(points[:, dim - 1] == 0)


def facets(cells: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Facets of simplices whose nodes are all chosen."""
    width = cells.shape[1]
    all_facets = np.concatenate([np.delete(cells, i, axis=1) for i in range(width)])
    return all_facets[np.isin(all_facets, chosen).all(axis=1)]


def of_order_two(points: np.ndarray, cells: np.ndarray, bend: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Simplices with nodes in the middles of their edges, those of the upper side moved by `bend`."""
    pairs = [(0, 1), (1, 2), (2, 0)] if cells.shape[1] == 3 else [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    dim = cells.shape[1] - 1
    edges = np.sort(cells[:, pairs].reshape(-1, 2), axis=1)
    unique, where = np.unique(edges, axis=0, return_inverse=True)
    middles = points[unique].mean(axis=1)
    upper = np.abs(middles[:, dim - 1] - SIDE) < 1e-12
    middles[upper, dim - 1] += bend * middles[upper, 0] * (SIDE - middles[upper, 0])
    return np.concatenate([points, middles]), np.concatenate([cells, len(points) + where.reshape(-1, len(pairs))], axis=1)


@dataclass
class File:
    """A file, as `write` makes it. `floor`: its group of the lower side; `body`: groups of cells that it has."""

    name: str
    write: Callable[[Path], None]
    dim: int = 3
    floor: str = "floor"
    body: set[str] = field(default_factory=lambda: {"body"})
    mesh: str = ""  # more keys of [mesh]
    note: str = ""
    tolerance: float = 1e-9  # of energies relative to those of the .msh; None: of a mesh of its own
    reference: str = ""


def with_sets(dim: int, kind: str = "simplex", named: bool = True) -> meshio.Mesh:
    """A mesh with sets of cells and nodes, as Abaqus has them."""
    points, cells = grid(dim)
    if kind != "blocks":
        cells = simplices(cells)
    names = {"simplex": {2: "triangle", 3: "tetra"}, "blocks": {2: "quad", 3: "hexahedron"}}
    mesh = meshio.Mesh(points, [(names[kind][dim], cells)])
    if named:
        mesh.cell_sets = {"body": [np.arange(len(cells))]}
        mesh.point_sets = {"floor": floor_nodes(points, dim)}
    return mesh


def with_numbers(dim: int, array: str = "region") -> meshio.Mesh:
    """A mesh with facets and a number for each cell and facet, as VTK and XDMF files have them."""
    points, cells = grid(dim)
    cells = simplices(cells)
    below = facets(cells, floor_nodes(points, dim))
    kinds = ("line", "triangle") if dim == 2 else ("triangle", "tetra")
    return meshio.Mesh(points, [(kinds[1], cells), (kinds[0], below)], cell_data={array: [np.full(len(cells), 7), np.full(len(below), 3)]})


def med(path: Path) -> None:
    mesh = with_numbers(3, "cell_tags")
    mesh.cell_data["cell_tags"] = [np.full(len(block.data), -1 - i) for i, block in enumerate(mesh.cells)]
    mesh.cell_tags = {-1: ["body", "steel"], -2: ["floor"]}
    mesh.write(path)


def abaqus_by_hand(path: Path) -> None:
    """With sets of elements on whose sides a surface is, as Abaqus/CAE writes it."""
    points, cells = grid(3)
    cells = simplices(cells)
    sides = [(0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)]  # S1 to S4 of C3D4
    below = set(floor_nodes(points, 3).tolist())
    lines = ["*Heading", "*Node", *(f"{i}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(points.tolist(), 1)), "*Element, type=C3D4"]
    lines += [f"{i}, " + ", ".join(str(node + 1) for node in cell) for i, cell in enumerate(cells.tolist(), 1)]
    lines += ["*Elset, elset=body, generate", f"1, {len(cells)}, 1"]
    surface = []
    for number, side in enumerate(sides, 1):
        own = [i for i, cell in enumerate(cells.tolist(), 1) if {cell[k] for k in side} <= below]
        if own:
            lines += [f"*Elset, elset=_floor_S{number}", *(", ".join(map(str, own[i : i + 8])) for i in range(0, len(own), 8))]
            surface.append(f"_floor_S{number}, S{number}")
    lines += ["*Surface, type=ELEMENT, name=floor", *surface, "*Material, name=steel"]
    path.write_text("\n".join(lines) + "\n")


def nastran_by_hand(path: Path) -> None:
    """In free fields; groups are the numbers of properties."""
    points, cells = grid(3)
    cells = simplices(cells)
    lines = ["BEGIN BULK", *(f"GRID,{i},,{x:.6f},{y:.6f},{z:.6f}" for i, (x, y, z) in enumerate(points.tolist(), 1))]
    lines += [f"CTETRA,{i},10," + ",".join(str(node + 1) for node in cell) for i, cell in enumerate(cells.tolist(), 1)]
    below = facets(cells, floor_nodes(points, 3)).tolist()
    lines += [f"CTRIA3,{len(cells) + i},20," + ",".join(str(node + 1) for node in facet) for i, facet in enumerate(below, 1)]
    path.write_text("\n".join([*lines, "ENDDATA"]) + "\n")


def exodus_by_hand(path: Path) -> None:
    """With named blocks and side sets, as Cubit and MOOSE write them."""
    import netCDF4

    points, cells = grid(3)
    below = set(floor_nodes(points, 3).tolist())
    sides = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3), (0, 3, 2, 1), (4, 5, 6, 7)]
    found = [(i, k) for i, cell in enumerate(cells.tolist(), 1) for k, side in enumerate(sides, 1) if {cell[one] for one in side} <= below]
    with netCDF4.Dataset(path, "w", format="NETCDF3_64BIT_OFFSET") as data:
        data.title, data.version, data.api_version, data.floating_point_word_size = "brick", np.float32(5.1), np.float32(5.1), np.int32(8)
        for name, size in {"len_string": 33, "len_name": 33, "num_dim": 3, "num_nodes": len(points), "num_elem": len(cells), "num_el_blk": 1,
                           "num_side_sets": 1, "num_el_in_blk1": len(cells), "num_nod_per_el1": 8, "num_side_ss1": len(found), "time_step": None}.items():  # fmt: skip
            data.createDimension(name, size)
        for axis, values in zip("xyz", points.T):
            data.createVariable(f"coord{axis}", "f8", ("num_nodes",))[:] = values
        for kind, name in (("eb", "body"), ("ss", "floor")):
            count = "num_el_blk" if kind == "eb" else "num_side_sets"
            text = data.createVariable(f"{kind}_names", "S1", (count, "len_name"))
            text[0] = np.frombuffer(name.encode().ljust(33, b"\0"), "S1")
            data.createVariable(f"{kind}_prop1", "i4", (count,))[:] = 1
        connect = data.createVariable("connect1", "i4", ("num_el_in_blk1", "num_nod_per_el1"))
        connect.elem_type = "HEX8"
        connect[:] = cells + 1
        for name, values in zip(("elem_ss1", "side_ss1"), zip(*found)):
            data.createVariable(name, "i4", ("num_side_ss1",))[:] = values


def by_gmsh(path: Path) -> None:
    """What gmsh itself writes of the brick's .msh, in the format of the path's extension."""
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        points, cells = grid(3)
        cells = simplices(cells)
        below = facets(cells, floor_nodes(points, 3))
        gmsh.model.add("brick")
        volume, surface = gmsh.model.addDiscreteEntity(3, 10), gmsh.model.addDiscreteEntity(2, 20)
        gmsh.model.mesh.addNodes(3, volume, range(1, len(points) + 1), points.ravel())
        gmsh.model.mesh.addElementsByType(volume, 4, [], (cells + 1).ravel())
        gmsh.model.mesh.addElementsByType(surface, 2, [], (below + 1).ravel())
        gmsh.model.addPhysicalGroup(3, [volume], 10, "body")
        gmsh.model.addPhysicalGroup(2, [surface], 20, "floor")
        gmsh.option.setNumber("Mesh.SaveGroupsOfElements", 1)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def by_meshio(mesh: Callable[[], meshio.Mesh], **options: object) -> Callable[[Path], None]:
    return lambda path: mesh().write(path, **options)


def shape(path: Path) -> None:
    """The brick as CAD by gmsh's OpenCASCADE, in mm where the format has a unit; the product of a .step has a name."""
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.addBox(0, 0, 0, SIDE * 1000, SIDE * 1000, SIDE * 1000)
        gmsh.model.occ.synchronize()
        lower = path.with_suffix(path.suffix.lower().replace(".stp", ".step"))
        gmsh.write(str(lower))
        lower.rename(path)
    finally:
        gmsh.finalize()
    if path.suffix in (".step", ".STP"):
        path.write_text(re.sub(r"PRODUCT\('[^']*',\s*'[^']*'", "PRODUCT('brick','brick'", path.read_text()))


def plate_of_order_two(bend: float) -> meshio.Mesh:
    points, cells = grid(2)
    points, cells = of_order_two(points, simplices(cells), bend)
    return meshio.Mesh(points, [("triangle6", cells)], point_sets={"floor": floor_nodes(points, 2)})


def brick_of_order_two() -> meshio.Mesh:
    points, cells = grid(3)
    points, cells = of_order_two(points, simplices(cells))
    return meshio.Mesh(points, [("tetra10", cells)], point_sets={"floor": floor_nodes(points, 3)})


FILES = [
    File("brick.inp", by_meshio(lambda: with_sets(3))),
    File("plate.inp", by_meshio(lambda: with_sets(2)), dim=2),
    File("hand.inp", abaqus_by_hand),
    File("blocks.inp", by_meshio(lambda: with_sets(3, "blocks")), mesh="split = true", note="27 elements are divided into tetrahedra", reference="blocks"),
    File("quads.inp", by_meshio(lambda: with_sets(2, "blocks")), dim=2, mesh="split = true", note="9 elements are divided", reference="blocks"),
    File("second.inp", by_meshio(brick_of_order_two), note="of higher order are taken at their vertices", body={"body"}),
    File("second-plate.inp", by_meshio(lambda: plate_of_order_two(0)), dim=2, mesh="degree = 2", note="taken at their vertices", reference="degree 2"),
    File("curved.inp", by_meshio(lambda: plate_of_order_two(0.2)), dim=2, note="some are curved, by up to"),
    File("brick.med", med, body={"body", "steel"}),
    File("brick.vtu", by_meshio(lambda: with_numbers(3)), floor="region 3", body={"region 7"}),
    File("plate.vtu", by_meshio(lambda: with_numbers(2)), dim=2, floor="region 3", body={"region 7"}),
    File("bare.vtu", by_meshio(lambda: with_sets(3, named=False)), floor="boundary"),
    File("brick.vtk", by_meshio(lambda: with_numbers(3)), floor="region 3", body={"region 7"}),
    File("brick.xdmf", by_meshio(lambda: with_numbers(3)), floor="region 3", body={"region 7"}),
    File("brick.e", by_meshio(lambda: with_sets(3)), body={"block 1"}),
    File("hand.e", exodus_by_hand, mesh="split = true", reference="blocks"),
    File("brick.unv", by_gmsh),
    File("brick.bdf", by_gmsh, floor="property 20", body={"property 10"}),
    File("hand.bdf", nastran_by_hand, floor="property 20", body={"property 10"}),
    File("brick.msh", by_gmsh),
    File("brick.step", shape, floor="surface 5", mesh="size = 0.4", body={"brick", "body"}, reference="shape"),
    File("brick.STP", shape, floor="surface 5", mesh="size = 0.4", body={"brick", "body"}, reference="shape"),
    File("brick.brep", shape, floor="surface 5", mesh='size = 0.4\nunit = "mm"', body={"volume 1", "body"}, reference="shape"),
    File("brick.iges", shape, floor="surface 5", mesh="size = 0.4", body={"volume 1", "body"}, reference="shape"),
]


def groups(info: str, kind: str) -> set[str]:
    """Names of the groups of one kind that info lists."""
    return {name.strip() for name in re.findall(rf"(?m)^  {kind} group (.*?)  \d", info)}


def energies(out: Path) -> tuple[np.ndarray, float]:
    steps = table(out / "steps.csv")
    return steps["elastic_energy"], float(steps["active"].max())


@pytest.fixture(scope="module")
def references(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[int, str], np.ndarray]:
    """Motions of the same bodies from a .msh with the same cells."""
    found = {}
    folder = tmp_path_factory.mktemp("references")
    for dim in (2, 3):
        for kind in ("", "blocks", "degree 2"):
            if (dim, kind) == (3, "degree 2"):
                continue
            points, cells = grid(dim)
            cells = simplices(cells) if kind != "blocks" else pulled(cells)
            below = facets(cells, floor_nodes(points, dim))
            kinds = ("line", "triangle") if dim == 2 else ("triangle", "tetra")
            tags = [np.full(len(cells), 1), np.full(len(below), 2)]
            mesh = meshio.Mesh(points, [(kinds[1], cells), (kinds[0], below)], cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
                               field_data={"body": np.array([1, dim]), "floor": np.array([2, dim - 1])})  # fmt: skip
            file = folder / f"{dim}{kind.replace(' ', '')}.msh"
            mesh.write(file, file_format="gmsh22", binary=False)
            out = folder / f"{dim}{kind}"
            signorini_ok("simulate", scene(folder, file.name, dim, mesh="degree = 2" if kind == "degree 2" else ""), out)
            found[dim, kind] = energies(out)[0]
    return found


def pulled(cells: np.ndarray) -> np.ndarray:
    """Simplices of quadrilaterals or hexahedra from the vertex with the least number: each face has the diagonal from its own."""
    found = []
    for cell in cells.tolist():
        least = sorted(cell)[0]
        if len(cell) == 4:
            i = cell.index(least)
            ring = cell[i:] + cell[:i]
            found += [[ring[0], ring[1], ring[2]], [ring[0], ring[2], ring[3]]]
            continue
        for side in [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]:
            face = [cell[k] for k in side]
            if least not in face:
                i = face.index(sorted(face)[0])
                ring = face[i:] + face[:i]
                found += [[least, ring[0], ring[1], ring[2]], [least, ring[0], ring[2], ring[3]]]
    return np.array(found)


def signorini_ok(verb: str, *words: object) -> str:
    command = [str(SIGNORINI), verb, str(words[0])]
    command += ["--out", str(words[1])] if len(words) > 1 else []
    done = captured(command)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_file(file: File, references: dict, tmp_path: Path) -> None:
    """`info` lists its groups, a run names them, and the motion is that of the same cells from a .msh."""
    path = tmp_path / file.name
    file.write(path)
    keys = [f"mesh.{line.replace(' ', '')}" for line in file.mesh.splitlines()]
    info = captured([str(SIGNORINI), "info", str(path), *(word for key in keys for word in ("--set", key))])
    assert info.returncode == 0, info.stderr
    body, boundary = ("volume", "surface") if file.dim == 3 else ("surface", "curve")
    assert groups(info.stdout, body) == file.body and file.floor in groups(info.stdout, boundary), info.stdout
    assert "in the box from (0, 0" in info.stdout and "connected parts: 1" in info.stdout
    assert file.note in info.stdout
    measure = {match[0]: float(match[1]) for match in re.findall(rf"(?m)^  {body} group (.*?)  \d.*?, (?:area|volume) ([0-9.e-]+) m", info.stdout)}
    assert all(abs(value - 1) < 1e-5 for name, value in measure.items()), measure
    signorini_ok("simulate", scene(tmp_path, file.name, file.dim, file.floor, file.mesh), tmp_path / "out")
    found, active = energies(tmp_path / "out")
    assert active > 0 and found[-1] > 0
    if file.reference != "shape":
        expected = references[file.dim, file.reference]
        assert np.abs(found - expected).max() < 1e-5 * expected.max()  # .bdf and .unv have some six digits


def test_shapes_are_alike(tmp_path: Path) -> None:
    """The brick of 1 m in .step (mm), .brep and .iges is the same body."""
    boxes = set()
    for name, keys in (("a.step", []), ("a.iges", []), ("a.brep", ["--set", 'mesh.unit="mm"'])):
        shape(tmp_path / name)
        said = captured([str(SIGNORINI), "info", str(tmp_path / name), *keys]).stdout
        boxes.add(re.search(r"in the box .*", said).group())
    assert boxes == {"in the box from (0, 0, 0) to (1, 1, 1) m"}


def refused(folder: Path, file: str, *texts: str, ranks: int = 1, dim: int = 3, floor: str = "floor", mesh: str = "") -> None:
    done = attempt("simulate", scene(folder, file, dim, floor, mesh), folder / "out", ranks)
    assert done.returncode == 2 and not (folder / "out" / "run.json").exists(), done.stdout + done.stderr
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("signorini: ")]
    assert all(text in line for text in texts), line


def test_refusals(tmp_path: Path) -> None:
    """One sentence with the cure."""
    with_sets(3, "blocks").write(tmp_path / "blocks.inp")
    refused(tmp_path, "blocks.inp", "blocks.inp: found elements of type", "set mesh.split = true")
    refused(tmp_path, "blocks.inp", "set mesh.split = true", ranks=2)
    with_sets(3).write(tmp_path / "brick.inp")
    refused(tmp_path, "brick.inp", "mesh.split has no effect", "remove it", mesh="split = true")
    refused(tmp_path, "brick.inp", 'no surface group "flor"', 'did you mean "floor"', floor="flor")
    plate_of_order_two(0.2).write(tmp_path / "curved.inp")
    refused(tmp_path, "curved.inp", "has curved elements", "set mesh.degree = 1", dim=2, mesh="degree = 2")
    refused(tmp_path, "brick.stl", 'found "brick.stl"; expected a file that ends in .geo, .msh, .step')
    (tmp_path / "cut.vtu").write_text("<?xml version='1.0'?><VTKFile type='UnstructuredGrid'><Unst")
    refused(tmp_path, "cut.vtu", "cut.vtu: meshio cannot read it", "check that the file is complete")
    (tmp_path / "empty.inp").write_text("")
    refused(tmp_path, "empty.inp", "empty.inp: ")
    refused(tmp_path, "none.inp", "none.inp")
    (tmp_path / "broken.step").write_text("ISO-10303-21;\nHEADER;\n")
    refused(tmp_path, "broken.step", "broken.step: ", mesh="size = 0.5")
    shape(tmp_path / "brick.step")
    refused(tmp_path, "brick.step", "mesh.size: missing: a CAD file has no element sizes")
    refused(tmp_path, "brick.step", "mesh.unit: has no effect on this CAD file", mesh='size = 0.5\nunit = "mm"')
    refused(tmp_path, "brick.step", "mesh.split: has no effect on a CAD file", mesh="size = 0.5\nsplit = true")
    refused(tmp_path, "brick.step", 'no surface group "flor"', "surface 5", mesh="size = 0.5", floor="flor")
    meshio.Mesh(np.zeros((2, 3)), [("line", [[0, 1]])]).write(tmp_path / "line.vtu")
    refused(tmp_path, "line.vtu", "no triangles or tetrahedra")
    text = (tmp_path / "brick.inp").read_text() + "*SURFACE, TYPE=ELEMENT, NAME=side\nnowhere, S1\n"
    (tmp_path / "surface.inp").write_text(text)
    refused(tmp_path, "surface.inp", 'the surface "side" names the element set "nowhere"')


@pytest.mark.parametrize("lines, texts", (
    ("*INCLUDE, INPUT=more.inp", ("*INCLUDE is not followed",)),
    ("*INSTANCE, NAME=a, PART=b\n0., 0., 0.01\n*END INSTANCE", ("translation or rotation cannot be read",)),
    ("*PART, NAME=a\n*END PART\n*PART, NAME=b\n*END PART", ("several parts", "found 2 *PART")),
    ("*NODE, NSET=all\n999, 5., 5., 5.", ("*NODE with NSET", "write the set by *NSET")),
    ("*NSET, NSET=lost\n1, 2,\n90001", ('the set "lost" names the node 90001',)),
    ("*ELSET, ELSET=lost, GENERATE\n1, 90001, 45000", ('the set "lost" names the element 45001',)),
    ("*ELEMENT, TYPE=C3D4\n90001, 1, two", ("meshio cannot read it (", "check that the file is complete")),
), ids=("include", "instance", "parts", "nodes", "lost node", "lost element", "damaged"))  # fmt: skip
def test_what_meshio_leaves_out_of_abaqus_files_is_refused(lines: str, texts: tuple[str, ...], tmp_path: Path) -> None:
    with_sets(3).write(tmp_path / "brick.inp")
    (tmp_path / "brick.inp").write_text((tmp_path / "brick.inp").read_text() + lines + "\n")
    refused(tmp_path, "brick.inp", "brick.inp: ", *texts)


def test_sizes_of_cad_are_not_graded(tmp_path: Path) -> None:
    shape(tmp_path / "brick.step")
    path = scene(tmp_path, "brick.step", floor="surface 5", mesh="size = 0.5")
    words = ["--graded", "--sizes", "0.5,0.4", "--steps", "0.01", "--quantity", "displacement", "--out", str(tmp_path / "out")]
    done = captured([str(SIGNORINI), "study", str(path), *words])
    assert done.returncode == 2 and "brick.step is a CAD file, whose sizes cannot be graded" in done.stderr


def test_facets_inside_are_counted(tmp_path: Path) -> None:
    """A surface of sides between cells is no part of the boundary, which info says."""
    points, cells = grid(3)
    cells = simplices(cells)
    inner = np.delete(cells, 0, axis=1)
    with_numbers(3).write(tmp_path / "a.vtu")
    assert "inside the body" not in signorini_ok("info", tmp_path / "a.vtu")
    mesh = meshio.Mesh(points, [("tetra", cells), ("triangle", inner)], cell_data={"region": [np.full(len(cells), 7), np.full(len(inner), 3)]})
    mesh.write(tmp_path / "b.vtu")
    assert re.search(r"surface group region 3 .*\(\d+ inside the body\)", signorini_ok("info", tmp_path / "b.vtu"))


def test_elements_in_two_groups_count_once(tmp_path: Path) -> None:
    mesh = with_sets(3, "blocks")
    mesh.cell_sets["again"] = mesh.cell_sets["body"]
    mesh.write(tmp_path / "blocks.inp")
    said = captured([str(SIGNORINI), "info", str(tmp_path / "blocks.inp"), "--set", "mesh.split=true"]).stdout
    assert "27 elements are divided" in said and groups(said, "volume") == {"body", "again"}


def test_without_meshio(tmp_path: Path) -> None:
    """Where Python lacks it, the message says what is missing."""
    with_sets(3).write(tmp_path / "brick.inp")
    (tmp_path / "path" / "meshio").mkdir(parents=True)
    (tmp_path / "path" / "meshio" / "__init__.py").write_text("raise ModuleNotFoundError(\"No module named 'meshio'\", name='meshio')\n")
    import os

    done = subprocess.run([SIGNORINI, "simulate", scene(tmp_path, "brick.inp"), "--out", tmp_path / "out"], capture_output=True, text=True,
                          env=os.environ | {"PYTHONPATH": f"{tmp_path / 'path'}"})  # fmt: skip
    assert done.returncode == 2 and "brick.inp: meshio is missing among the packages of" in done.stderr


def test_ungrouped_cells_have_a_group(tmp_path: Path) -> None:
    mesh = with_sets(3)
    mesh.cell_sets = {"half": [np.arange(len(mesh.cells[0].data) // 2)]}
    mesh.write(tmp_path / "brick.inp")
    said = signorini_ok("info", tmp_path / "brick.inp")
    assert groups(said, "volume") == {"half", "ungrouped"}


def test_ranks_and_echo(tmp_path: Path) -> None:
    """The same on two ranks, and from the scene that the run wrote."""
    with_sets(3, "blocks").write(tmp_path / "blocks.inp")
    path = scene(tmp_path, "blocks.inp", mesh="split = true")
    found = []
    for name, source, ranks in (("one", path, 1), ("two", path, 2), ("again", tmp_path / "one" / "scene.toml", 1)):
        done = attempt("simulate", source, tmp_path / name, ranks)
        assert done.returncode == 0, done.stderr
        found.append(energies(tmp_path / name)[0])
    assert np.array_equal(found[0], found[2]) and np.abs(found[1] - found[0]).max() < 1e-9 * found[0].max()
    assert json.loads((tmp_path / "one" / "run.json").read_text())["body"]["notes"] == ["27 elements are divided into tetrahedra"]
