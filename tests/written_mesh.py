# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that a test writes itself, as files of gmsh."""

from pathlib import Path

import numpy as np
from harness import boundary


def groups(points: np.ndarray, cells: np.ndarray) -> dict[str, np.ndarray]:
    """The facets of the boundary, by the groups of half-disc.geo and half-ball.geo."""
    facets = boundary(cells)
    middle = points[facets].mean(axis=1)
    top = abs(middle[:, -1]) < 1e-9
    contact = -middle[:, -1] > np.cos(np.pi / 6) * np.linalg.norm(middle, axis=1)
    return {"top": facets[top], "contact": facets[contact], "side": facets[~top & ~contact]}


def write_mesh(file: Path, points: np.ndarray, cells: np.ndarray, facets: dict[str, np.ndarray]) -> None:
    """As .msh of version 2.2, whose numbers are read back without rounding."""
    dim = points.shape[1]
    parts = [("body", dim, cells)] + [(name, dim - 1, part) for name, part in facets.items()]
    kinds = {1: 1, 2: 2, 3: 4}  # gmsh's numbers of edges, triangles, tetrahedra
    names = [f'{d} {tag} "{name}"' for tag, (name, d, _) in enumerate(parts, 1)]
    nodes = [f"{i} " + " ".join(f"{x:.17g}" for x in np.append(p, np.zeros(3 - dim))) for i, p in enumerate(points, 1)]
    elements = [f"{kinds[d]} 2 {tag} {tag} " + " ".join(str(n + 1) for n in element)
                for tag, (_, d, part) in enumerate(parts, 1) for element in part]  # fmt: skip
    elements = [f"{i} {text}" for i, text in enumerate(elements, 1)]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    for section, rows in (("PhysicalNames", names), ("Nodes", nodes), ("Elements", elements)):
        lines += [f"${section}", str(len(rows)), *rows, f"$End{section}"]
    file.write_text("\n".join(lines) + "\n")
