# SPDX-License-Identifier: GPL-3.0-or-later
"""The half disc's and the half ball's experiments, turned by 37 degrees with mesh, plane and controls: nothing may depend on
the directions of the axes."""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_BALL, HALF_DISC, boundary, signorini, stored, table  # noqa: E402

import numpy as np  # noqa: E402

ANGLE = np.deg2rad(37)
# The coordinates, turned, are rounded, and each of up to 150 steps leaves the accuracy of its solver, 1e-12 at most
# (verification.agreement).
TOLERANCE = 1e-10
ENERGIES = ("kinetic_energy", "elastic_energy", "viscous_dissipation", "external_work", "tracking_error")


def turn(dim: int) -> np.ndarray:
    """In space about an axis that is none of the coordinates'."""
    if dim == 2:
        return np.array([[np.cos(ANGLE), -np.sin(ANGLE)], [np.sin(ANGLE), np.cos(ANGLE)]])
    x, y, z = np.array([1, 2, 3]) / np.sqrt(14)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(ANGLE) * cross + (1 - np.cos(ANGLE)) * cross @ cross


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


def run(scene: Path, R: np.ndarray, folder: Path, **overrides: object) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """The experiment turned by R, pushed with nine tenths of its reference control: its figures seen from the turned axes, in
    an order that does not depend on R, and how many candidates are active at each step."""
    dim, out = len(R), folder / "out"
    down = -R[:, -1]

    def push(size: float) -> list[str]:
        return [f"{size * x:.17g}" for x in down]

    signorini("optimize", scene, out, optimizer__max_iterations=0, control__initial=push(0.9),
              objective__desired={"control": push(1)}, **overrides,
              contact__obstacle={"shape": "half-space", "point": list(15.75 * down), "normal": list(-down)})  # fmt: skip
    steps, contact, history = (table(out / f"{name}.csv") for name in ("steps", "contact", "history"))
    assert (contact["force"] > 0).sum() > 20, "hardly any contact: the case says nothing"
    figures = {name: steps[name] for name in ENERGIES} | {name: history[name] for name in ("objective", "gradient_norm")}
    for name in ("displacement", "velocity"):
        points, _, values = stored(out, "state", name)
        figures[name] = (values[:, :, :dim] @ R)[:, np.lexsort((points @ R).round(6).T)]
    candidates = np.column_stack([contact[axis] for axis in "xyz"[:dim]]) @ R
    order = np.lexsort([*candidates.round(6).T, contact["step"]])
    figures |= {"gaps": contact["gap"][order], "nodal forces": contact["force"][order]}
    figures["contact force"] = np.column_stack([steps[f"contact_force_{axis}"] for axis in "xyz"[:dim]]) @ R
    return figures, steps["active"]


def compare(name: str, scene: Path, folder: Path, variants: dict[str, dict], size: float, **overrides: object) -> bool:
    # One short run for its mesh.
    signorini("simulate", scene, folder / "out", mesh__size=size, time__step=1e-4, time__end=1e-4)
    points, cells, _ = stored(folder / "out", "state", "displacement")
    dim = points.shape[1]
    holds = True
    for title, variant in variants.items():
        found = []
        for angle, R in (("0", np.eye(dim)), ("37", turn(dim))):
            mesh = folder / f"{angle}.msh"
            write_mesh(mesh, points @ R.T, cells, groups(points, cells))
            found.append(run(scene, R, folder, mesh={"file": str(mesh), "degree": variant.get("degree", 1)},
                             **{key: value for key, value in variant.items() if key != "degree"}, **overrides))  # fmt: skip
        (straight, active), (turned, turned_active) = found
        same = np.array_equal(active, turned_active)
        worst = {key: abs(turned[key] - straight[key]).max() / abs(straight[key]).max() for key in straight}
        holds &= same and np.max(list(worst.values())) <= TOLERANCE
        print(f"{name}, {title}: {(active > 0).sum()} steps in contact, active candidates {'equal' if same else 'differ'} at all "
              "steps; relative differences " + ", ".join(f"{key} {value:.1e}" for key, value in worst.items()))  # fmt: skip
    return holds


def main() -> int:
    variants = {"condensed": {}, "full VI": {"solver__vi": "full"}, "conjugate gradients": {"solver__linear": "iterative"}}
    in_the_plane = variants | {"degree 2": {"degree": 2}, "degree 2, full VI": {"degree": 2, "solver__vi": "full"}}
    with tempfile.TemporaryDirectory() as folder:
        holds = [compare("half disc", HALF_DISC, Path(folder), in_the_plane, size=1.5),
                 compare("half ball", HALF_BALL, Path(folder), variants, size=2.4, time__step=2.5e-4)]  # fmt: skip
    return 0 if all(holds) else 1


if __name__ == "__main__":
    raise SystemExit(main())
