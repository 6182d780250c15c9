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
from mesh_writers import (
    abaqus_by_hand,
    brick_of_order_two,
    by_gmsh,
    by_meshio,
    exodus_by_hand,
    facets,
    floor_nodes,
    grid,
    med,
    nastran_by_hand,
    plate_of_order_two,
    shape,
    simplices,
    with_numbers,
    with_sets,
)

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

def scene(folder: Path, file: str, dim: int = 3, floor: str = "floor", mesh: str = "") -> Path:
    path = folder / "scene.toml"
    up = [0] * (dim - 1) + [1]
    path.write_text(SCENE.format(file=file, mesh=mesh, floor=floor, point=[0] * dim, normal=up, load=["0"] * (dim - 1) + ["-10"]))
    return path


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
    reference: str = ""


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
    File("plate.xdmf", by_meshio(lambda: with_numbers(2)), dim=2, floor="region 3", body={"region 7"}),
    File("plate.e", by_meshio(lambda: with_sets(2)), dim=2, body={"block 1"}),
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
