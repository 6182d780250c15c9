# SPDX-License-Identifier: GPL-3.0-or-later
"""Writers of meshes of one brick or plate in the formats of other programs, by meshio, gmsh and hand."""

import re
from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np

SIDE = 1.0  # of the body, m


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
