# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts a mesh that meshio reads into the text of a .msh (MSH 2.2), with sets as physical groups.

The program signorini starts it for a mesh.file of such a format: the path is on standard input, and the answer goes to descriptor 3:
"m" and the text, or "e" and the reason why the file cannot be read, in one sentence.
"""

import contextlib
import io
import os
import re
import sys
import tempfile
import warnings
from pathlib import Path

ANSWER = 3
MOST_VALUES = 100  # of an array of numbers of regions; more are numbers of cells
CORNERS = {"vertex": 1, "line": 2, "triangle": 3, "quad": 4, "tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
DIMENSION = {"vertex": 0, "line": 1, "triangle": 2, "quad": 2, "tetra": 3, "pyramid": 3, "wedge": 3, "hexahedron": 3}
# Sides of cells by their corners, in the order in which Abaqus and Exodus number them.
PLANE_SIDES = {"triangle": [(0, 1), (1, 2), (2, 0)], "quad": [(0, 1), (1, 2), (2, 3), (3, 0)]}
ABAQUS_SIDES = PLANE_SIDES | {
    "tetra": [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)],
    "wedge": [(0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)],
    "pyramid": [(0, 1, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)],
    "hexahedron": [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)],
}
EXODUS_SIDES = PLANE_SIDES | {
    "tetra": [(0, 1, 3), (1, 2, 3), (0, 3, 2), (0, 2, 1)],
    "wedge": [(0, 1, 4, 3), (1, 2, 5, 4), (0, 3, 5, 2), (0, 2, 1), (3, 4, 5)],
    "pyramid": [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (0, 3, 2, 1)],
    "hexahedron": [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3), (0, 3, 2, 1), (4, 5, 6, 7)],
}
POLYGONS = {2: "line", 3: "triangle", 4: "quad"}


class Unreadable(Exception):
    """Raised with a sentence about the file."""


class Groups:
    """Elements of an unnamed dimension by the name of their group: cells by their rows, others by their nodes."""

    def __init__(self) -> None:
        self.cells: dict[str, set[int]] = {}
        self.facets: dict[str, dict[tuple[int, ...], tuple[int, ...]]] = {}  # by the sorted nodes, which are listed in order
        self.points: dict[str, list[int]] = {}

    def add_facet(self, name: str, nodes: tuple[int, ...]) -> None:
        self.facets.setdefault(name, {}).setdefault(tuple(sorted(nodes)), nodes)


class Body:
    """Cells of the highest dimension of a mesh, and its groups."""

    def __init__(self, mesh: "meshio.Mesh") -> None:
        self.mesh = mesh
        self.bases = [re.sub(r"\d+$", "", block.type) for block in mesh.cells]
        for block, base in zip(mesh.cells, self.bases):
            if base not in CORNERS:
                raise Unreadable(f'elements of type "{block.type}" cannot be used; use triangles or tetrahedra')
        self.dim = max((DIMENSION[base] for base in self.bases), default=0)
        self.first: list[int] = []  # row of each block's first cell
        self.types: list[tuple[int, int]] = []  # block and row within it, by row
        for number, (block, base) in enumerate(zip(mesh.cells, self.bases)):
            self.first.append(len(self.types))
            if DIMENSION[base] == self.dim:
                self.types += [(number, i) for i in range(len(block.data))]
        self.groups = Groups()

    def add(self, name: str, block: int, rows: "np.ndarray") -> None:
        """Puts elements of a block into a group."""
        base = self.bases[block]
        if DIMENSION[base] == self.dim:
            self.groups.cells.setdefault(name, set()).update((self.first[block] + rows).tolist())
        elif DIMENSION[base] == self.dim - 1:
            for nodes in self.mesh.cells[block].data[rows][:, : CORNERS[base]].tolist():
                self.groups.add_facet(name, tuple(nodes))

    def add_side(self, name: str, row: int, side: int, sides: dict) -> None:
        """Puts a side of a cell, both numbered from 0, into a group."""
        block, i = self.types[row]
        corners = self.mesh.cells[block].data[i]
        self.groups.add_facet(name, tuple(int(corners[k]) for k in sides[self.bases[block]][side]))

    def add_nodes(self, name: str, nodes: "np.ndarray") -> None:
        """Puts the facets of the boundary between these nodes into a group or, if there are none, the nodes."""
        chosen = np.zeros(len(self.mesh.points), bool)
        chosen[nodes] = True
        found = [facet for facet in self.boundary() if chosen[list(facet)].all()]
        for facet in found:
            self.groups.add_facet(name, facet)
        if not found:
            self.groups.points[name] = [int(node) for node in nodes]

    def boundary(self) -> list[tuple[int, ...]]:
        """Facets that belong to one cell only, by their corners."""
        if not hasattr(self, "_boundary"):
            seen: dict[tuple[int, ...], tuple[int, ...] | None] = {}
            for block, base in zip(self.mesh.cells, self.bases):
                if DIMENSION[base] != self.dim:
                    continue
                for side in ABAQUS_SIDES[base]:
                    for nodes in block.data[:, list(side)].tolist():
                        key = tuple(sorted(nodes))
                        seen[key] = None if key in seen else tuple(nodes)
            self._boundary = [nodes for nodes in seen.values() if nodes is not None]
        return self._boundary


def convert(file: Path) -> str:
    mesh = read(file)
    if not mesh.cells or not len(mesh.points):
        raise Unreadable("the mesh has no elements (is the file incomplete?)")
    body = Body(mesh)
    if body.dim < 2:
        raise Unreadable("the file has no triangles or tetrahedra, and no elements that can be divided into them")
    collect_sets(body)
    collect_arrays(body)
    if file.suffix.lower() == ".inp":
        collect_abaqus_surfaces(body, file.read_text(encoding="utf-8", errors="replace"))
    elif file.suffix.lower() in (".e", ".exo"):
        collect_exodus(body, file)
    return text_of(body)


def read(file: Path) -> "meshio.Mesh":
    kind = {".e": "exodus", ".exo": "exodus", ".bdf": "nastran", ".nas": "nastran"}.get(file.suffix.lower())
    if file.suffix.lower() == ".inp":
        text = file.read_text(encoding="utf-8", errors="replace")
        require_plain_abaqus(text)
        require_members(text)
    printed = io.StringIO()  # meshio gives some reasons on the screen, and ends
    try:
        if kind == "nastran" and "BEGIN BULK" not in (text := file.read_text(encoding="utf-8", errors="replace")).upper():
            with tempfile.TemporaryDirectory() as scratch:  # the bulk data alone
                (whole := Path(scratch) / "whole.bdf").write_text(f"BEGIN BULK\n{text}\nENDDATA\n")
                return meshio.read(whole, kind)
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            return meshio.read(file, kind)
    except ImportError as missing:
        raise Unreadable(f"meshio needs the Python package {missing.name} ({sys.executable}) for this format; install it") from None
    except (Exception, SystemExit) as error:
        ended = isinstance(error, SystemExit)
        reason = " ".join((printed.getvalue() if ended else str(error)).removeprefix("Error:").split())
        reason = reason.rstrip(".") or ("it is damaged" if ended else type(error).__name__)
        raise Unreadable(f"meshio cannot read it ({reason}); check that the file is complete, or convert it to .msh") from None


def require_plain_abaqus(text: str) -> None:
    """Refuses what meshio leaves out without a word."""
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith("**")]
    instances = parts = 0
    for number, line in enumerate(lines):
        keyword, *options = (word.strip().lower() for word in line.split(","))
        if keyword == "*include":
            raise Unreadable("*INCLUDE is not followed; put the included lines into this file")
        if keyword == "*node" and any(option.startswith("nset") for option in options):
            raise Unreadable("*NODE with NSET makes a set that cannot be read; write the set by *NSET")
        parts += keyword == "*part"
        if keyword == "*instance":
            instances += 1
            if number + 1 < len(lines) and not lines[number + 1].startswith("*"):
                raise Unreadable("*INSTANCE with a translation or rotation cannot be read; export the mesh of the assembly, flat")
    if instances > 1 or parts > 1:
        raise Unreadable(f"several parts or instances cannot be read (found {parts} *PART, {instances} *INSTANCE); export the mesh of the assembly, flat")


def require_members(text: str) -> None:
    """Refuses sets of nodes or elements that the file does not have; meshio leaves out such members."""
    labels: dict[str, set[int]] = {"node": set(), "element": set()}
    members: list[tuple[str, str, int]] = []  # kind, set and label
    keyword, name, generate, continued = "", "", False, False
    for line in map(str.strip, text.splitlines()):
        if not line or line.startswith("**"):
            continue
        words = [word.strip() for word in line.split(",")]
        if line.startswith("*"):
            keyword, continued = words[0].lower(), False
            generate = any(word.lower() == "generate" for word in words)
            name = next((word.split("=", 1)[1].strip() for word in words if re.match(r"(n|el)set\s*=", word, re.IGNORECASE)), "")
        elif keyword in ("*node", "*element"):
            if not continued and words[0].isdigit():
                labels[keyword[1:]].add(int(words[0]))
            continued = line.endswith(",")
        elif keyword in ("*nset", "*elset"):
            numbers = [int(word) for word in words if word.isdigit()]  # others are names of sets
            if generate and len(numbers) > 1:
                numbers = range(numbers[0], numbers[1] + 1, *numbers[2:3])
            members += [("node" if keyword == "*nset" else "element", name, number) for number in numbers]
    for kind, name, number in members:
        if number not in labels[kind]:
            raise Unreadable(f'the set "{name}" names the {kind} {number}, which the file does not have; export the mesh with all its {kind}s')


def collect_sets(body: Body) -> None:
    for name, blocks in body.mesh.cell_sets.items():
        if is_of_gmsh(name):
            continue
        for number, rows in enumerate(blocks):
            if rows is not None and len(rows):
                body.add(name, number, np.asarray(rows, dtype=np.int64))
    for name, nodes in body.mesh.point_sets.items():
        body.add_nodes(name, np.asarray(nodes, dtype=np.int64))


def collect_arrays(body: Body) -> None:
    """Numbers of regions, as VTK and XDMF files have them, and families of MED."""
    mesh = body.mesh
    families = getattr(mesh, "cell_tags", {})
    for array, blocks in mesh.cell_data.items():
        values = [np.asarray(one) for one in blocks]
        if any(one.ndim > 1 and one.shape[-1] != 1 or not np.issubdtype(one.dtype, np.integer) for one in values):
            continue
        distinct = np.unique(np.concatenate([one.ravel() for one in values]))
        if len(distinct) > MOST_VALUES or is_of_gmsh(array):
            continue
        for value in distinct.tolist():
            for name in names_of(mesh, array, value, families):
                for number, one in enumerate(values):
                    body.add(name, number, np.flatnonzero(one.ravel() == value))
    for value, names in getattr(mesh, "point_tags", {}).items():
        nodes = np.flatnonzero(np.asarray(mesh.point_data["point_tags"]).ravel() == value)
        for name in names if len(nodes) else []:
            body.add_nodes(name, nodes)


def is_of_gmsh(name: str) -> bool:
    """Whether an array or set is one of gmsh's entities, not a group."""
    return name.endswith(("gmsh:geometrical", "gmsh:bounding_entities"))


def names_of(mesh: "meshio.Mesh", array: str, value: int, families: dict) -> list[str]:
    """Names of the groups of cells with this value of an array."""
    if array == "cell_tags" and families:
        return list(families.get(value, []))
    if array == "nastran:ref":
        return [f"property {value}"]
    if array == "gmsh:physical":
        named = [name for name, (tag, _) in mesh.field_data.items() if tag == value]
        if named:
            return named
    return [f"{array} {value}"]


def collect_abaqus_surfaces(body: Body, text: str) -> None:
    """Surfaces of sides of elements in sets, which meshio leaves out."""
    name = None
    sets = {key.lower(): key for key in body.mesh.cell_sets}
    for line in map(str.strip, text.splitlines()):
        if line.startswith("**") or not line:
            continue
        if line.startswith("*"):
            keyword, *options = (word.strip() for word in line.split(","))
            given = dict(word.split("=", 1) if "=" in word else (word, "") for word in options)
            given = {key.strip().lower(): value.strip() for key, value in given.items()}
            of_elements = given.get("type", "ELEMENT").upper() == "ELEMENT"
            name = given.get("name") if keyword.lower() == "*surface" and of_elements else None
            continue
        if name is None:
            continue
        members, _, side = (word.strip() for word in line.partition(","))
        if members.lower() not in sets:
            raise Unreadable(f'the surface "{name}" names the element set "{members}", which the file does not have; expected a set and a side')
        if not re.fullmatch(r"S[1-6]", side.upper()):
            raise Unreadable(f'the surface "{name}" names the side "{side}"; expected S1 to S6')
        for number, rows in enumerate(body.mesh.cell_sets[sets[members.lower()]]):
            if rows is None or DIMENSION[body.bases[number]] != body.dim:
                continue
            for row in rows:
                body.add_side(name, body.first[number] + int(row), int(side[1]) - 1, ABAQUS_SIDES)
    # Such sets serve their surface alone.
    for key in [key for key in body.groups.cells if re.fullmatch(r"_.+_S\d", key)]:
        del body.groups.cells[key]


def collect_exodus(body: Body, file: Path) -> None:
    """Names of blocks, and side sets."""
    import netCDF4

    def names(data: "netCDF4.Dataset", variable: str, kind: str, count: int) -> list[str]:
        found = []
        if variable in data.variables:
            found = [b"".join(row.compressed() if hasattr(row, "compressed") else row).decode().strip("\0 ") for row in data[variable][:]]
        return [found[i] if i < len(found) and found[i] else f"{kind} {i + 1}" for i in range(count)]

    with netCDF4.Dataset(file) as data:
        blocks = [number for number, base in enumerate(body.bases) if base != "vertex"]
        for name, number in zip(names(data, "eb_names", "block", len(blocks)), blocks):
            body.add(name, number, np.arange(len(body.mesh.cells[number].data)))
        count = len([key for key in data.variables if re.fullmatch(r"elem_ss\d+", key)])
        row_of = np.full(sum(len(block.data) for block in body.mesh.cells), -1)
        start = 0
        for number, block in enumerate(body.mesh.cells):
            if DIMENSION[body.bases[number]] == body.dim:
                row_of[start : start + len(block.data)] = body.first[number] + np.arange(len(block.data))
            start += len(block.data)
        for i, name in enumerate(names(data, "ss_names", "side set", count), 1):
            for element, side in zip(data[f"elem_ss{i}"][:], data[f"side_ss{i}"][:]):
                if (row := row_of[int(element) - 1]) >= 0:
                    body.add_side(name, int(row), int(side) - 1, EXODUS_SIDES)


def text_of(body: Body) -> str:
    """The mesh as MSH 2.2, which lists a cell once for each of its groups."""
    groups = body.groups
    if groups.cells and len(set().union(*groups.cells.values())) < len(body.types):
        name = "ungrouped"
        while name in groups.cells:
            name += "'"
        groups.cells[name] = set(range(len(body.types))).difference(*groups.cells.values())
    cells, tags, names = [], [], {}

    def add(dim: int, name: str | None, kind: str, nodes: list) -> None:
        if name is not None:
            clean = name.replace('"', "'").replace("\n", " ")
            tag = int(names.setdefault((dim, clean), np.array([len(names) + 1, dim]))[0])
        cells.append((kind, np.array(nodes)))
        tags.append(np.full(len(nodes), 0 if name is None else tag))

    for name, rows in (groups.cells or {None: range(len(body.types))}).items():
        of_block: dict[int, list[int]] = {}
        for row in sorted(rows):
            block, i = body.types[row]
            of_block.setdefault(block, []).append(i)
        for block, own in of_block.items():
            add(body.dim, name, body.mesh.cells[block].type, body.mesh.cells[block].data[own])
    for name, facets in groups.facets.items():
        for corners in (2, 3, 4):
            if own := [nodes for nodes in facets.values() if len(nodes) == corners]:
                add(body.dim - 1, name, POLYGONS[corners], own)
    for name, nodes in groups.points.items():
        add(0, name, "vertex", [[node] for node in nodes])
    points = np.zeros((len(body.mesh.points), 3))
    points[:, : body.mesh.points.shape[1]] = body.mesh.points
    # Names are by tag, since groups of two dimensions may have the same one.
    found = meshio.Mesh(points, cells, cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags})
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "mesh.msh"
        meshio.write(file, found, file_format="gmsh22", binary=False)
        format_, end, rest = file.read_text().partition("$EndMeshFormat\n")
    listed = "".join(f'{dim} {tag[0]} "{name}"\n' for (dim, name), tag in names.items())
    return f"{format_}{end}$PhysicalNames\n{len(names)}\n{listed}$EndPhysicalNames\n{rest}"


def main() -> int:
    file = Path(os.fsdecode(sys.stdin.buffer.read()))
    try:
        global meshio, np
        import meshio
        import numpy as np

        with warnings.catch_warnings(action="ignore"):
            answer = "m" + convert(file)
    except ModuleNotFoundError as missing:
        answer = f"e{missing.name} is missing among the packages of {sys.executable}, by which files of this format are read; install it"
    except Unreadable as error:
        answer = f"e{error}"
    with os.fdopen(ANSWER, "wb") as out:
        out.write(answer.encode())
    return 0


if __name__ == "__main__":
    sys.exit(main())
