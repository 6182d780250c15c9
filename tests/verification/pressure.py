# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact pressure in contact.csv and as a field: of uniform patches to rounding, and Hertz's.

All bodies are at rest after one step (at_rest.py).
"""

import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pytest
from at_rest import LAMBDA, MODULUS, MU, PRESS, RADIUS, RUNS, SCENE, SCHEMES, box, hat_means
from harness import boundary, signorini, stored, table

QUOTE = '"'


def quoted(expressions: list[str]) -> str:
    return "[" + ", ".join(f"{QUOTE}{one}{QUOTE}" for one in expressions) + "]"


# --- A patch --------------------------------------------------------------------------------------------------------------

SQUEEZE = (0.01, 0.02, 0.015)  # strains along the axes
def patch_tables(dim: int, mass: str) -> str:
    """Half of the sides are moved inwards, the others rest on obstacles: uniform strain, from the start on."""
    axes = "xyz"[:dim]
    text = ""
    for axis, name in enumerate(axes):
        text += f'[[clamp]]\non = "{name}1"\ncomponents = ["{name}"]\nvalue = ["-{SQUEEZE[axis]}"]\n'
        normal = [int(c == axis) for c in range(dim)]
        text += (f'[[contact]]\non = "{name}0"\nmass = "{mass}"\n'
                 f'obstacle = {{ shape = "half-space", point = {[0] * dim}, normal = {normal} }}\n')  # fmt: skip
    return text + f"[initial]\ndisplacement = {quoted([f'-{SQUEEZE[c]}*{name}' for c, name in enumerate(axes)])}\n"


def attributes(file: Path) -> dict[str, tuple[str, str]]:
    """Type and centre of each field, as a reader of XDMF sees them."""
    return {one.get("Name"): (one.get("AttributeType"), one.get("Center")) for one in xml.parse(file).iter("Attribute")}


@pytest.mark.parametrize("scheme, ranks", RUNS)
@pytest.mark.parametrize("degree", (1, 2))
@pytest.mark.parametrize("dim", (2, 3))
def test_patch(dim: int, degree: int, scheme: str, ranks: int, tmp_path: Path) -> None:
    time_scheme, mass = SCHEMES[scheme]
    scene, out = tmp_path / "patch.toml", tmp_path / "patch"
    scene.write_text(SCENE.format(mesh=box(dim, tmp_path), size="size = 0.3", degree=degree, scheme=time_scheme,
                                  tables=patch_tables(dim, mass)))  # fmt: skip
    signorini("simulate", scene, out, ranks)
    strain = np.diag([-s for s in SQUEEZE[:dim]] + [0] * (3 - dim))
    stress = LAMBDA * np.trace(strain) * np.eye(3) + 2 * MU * strain
    deviator = stress - np.trace(stress) / 3 * np.eye(3)
    contact, steps = table(out / "contact.csv"), table(out / "steps.csv")
    now = contact["step"] == 3
    assert steps["active"][-1] > 0 and (contact["force"][now] > 0).any(), "no contact: the case says nothing"
    axes = "xyz"[:dim]
    for axis, name in enumerate(axes):
        own = now & (contact["obstacle"] == f"obstacle {axis + 1}")
        expected = -stress[axis, axis]
        assert contact["area"][own].sum() == pytest.approx(1, abs=1e-12), "areas do not add up to the side's"
        assert contact["pressure"][own] / expected == pytest.approx(1, abs=1e-10)
        assert contact["force"][own].sum() / expected == pytest.approx(1, abs=1e-10)
        assert steps[f"contact_force_{name}"][-1] / expected == pytest.approx(1, abs=1e-10)
        for other, direction in enumerate(axes):
            assert (contact[f"normal_{direction}"][own] == (other == axis)).all()
    nodes, _, fields = stored(out, "state", "pressure")
    at_nodes = np.max([np.where(abs(nodes[:, axis]) < 1e-12, -stress[axis, axis], 0) for axis in range(dim)], axis=0)
    assert fields[-1].reshape(-1) / at_nodes.max() == pytest.approx(at_nodes / at_nodes.max(), abs=1e-10)
    assert abs(fields[0]).max() == 0, "a pressure before the first step"
    for name, exact in (("strain", strain), ("stress", stress), ("von_mises", np.sqrt(1.5 * (deviator**2).sum()))):
        found = stored(out, "state", name)[2][-1]
        assert found.shape[1:] == (np.shape(exact) or (1,)), "a tensor is 3 × 3"
        assert abs(found.reshape(len(found), *np.shape(exact)) - exact).max() / abs(exact).max() <= 1e-10, name
    assert attributes(out / "state.xdmf") == {"strain": ("Tensor", "Cell"), "stress": ("Tensor", "Cell"), "von_mises": ("Scalar", "Cell"),
                                              "pressure": ("Scalar", "Node")}  # fmt: skip


# --- Hertz ----------------------------------------------------------------------------------------------------------------

BALL = """
// An octant of a ball, its lowest point at the origin: the boundary within 15 degrees of that is the group contact.
radius = 8; fine = {fine}; reach = {reach}; angle = Pi / 12;
Point(1) = {{0, 0, radius}};
Point(2) = {{0, 0, 0}};
Point(3) = {{radius, 0, radius}};
Point(4) = {{0, radius, radius}};
Point(5) = {{radius * Sin(angle), 0, radius * (1 - Cos(angle))}};
Point(6) = {{0, radius * Sin(angle), radius * (1 - Cos(angle))}};
Point(7) = {{0, 0, radius * (1 - Cos(angle))}};
Line(1) = {{1, 3}}; Line(2) = {{1, 4}}; Line(3) = {{1, 2}};
Circle(4) = {{2, 1, 5}}; Circle(5) = {{5, 1, 3}}; Circle(6) = {{2, 1, 6}}; Circle(7) = {{6, 1, 4}}; Circle(8) = {{3, 1, 4}};
Circle(9) = {{5, 7, 6}};
Curve Loop(1) = {{1, -5, -4, -3}}; Plane Surface(1) = {{1}};
Curve Loop(2) = {{3, 6, 7, -2}}; Plane Surface(2) = {{2}};
Curve Loop(3) = {{2, -8, -1}}; Plane Surface(3) = {{3}};
Curve Loop(4) = {{4, 9, -6}}; Surface(4) = {{4}} In Sphere {{1}};
Curve Loop(5) = {{5, 8, -7, -9}}; Surface(5) = {{5}} In Sphere {{1}};
Surface Loop(1) = {{1, 2, 3, 4, 5}}; Volume(1) = {{1}};
Field[1] = MathEval;
Field[1].F = Sprintf("%g + 0.3 * Max(0, Sqrt(x^2 + y^2 + z^2) - %g)", fine, reach);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Physical Volume("body") = {{1}};
Physical Surface("y0") = {{1}}; Physical Surface("x0") = {{2}}; Physical Surface("top") = {{3}}; Physical Surface("contact") = {{4}};
"""


def hertz_scene(dim: int, degree: int, fine: float, folder: Path) -> Path:
    """A half disc or an octant of a ball, its flat side moved down onto a plane."""
    mesh, scene = folder / "hertz.geo", folder / "hertz.toml"
    floor = f'[contact]\non = "contact"\nobstacle = {{ shape = "half-space", point = {[0] * dim}, normal = {[0] * (dim - 1) + [1]} }}\n'
    if dim == 2:
        text = PRESS.read_text().replace("fine = 0.068;", f"fine = {fine};")
        clamps = '[[clamp]]\non = "top"\nvalue = ["0", "-0.1"]\n'
    else:
        text = BALL.format(fine=fine, reach=0.5)
        clamps = "".join(f'[[clamp]]\non = "{axis}0"\ncomponents = ["{axis}"]\n' for axis in "xy")
        clamps += '[[clamp]]\non = "top"\ncomponents = ["z"]\nvalue = ["-0.03"]\n'
    assert f"fine = {fine};" in text
    mesh.write_text(text)
    scene.write_text(SCENE.format(mesh=mesh, size="", degree=degree, scheme="contact-implicit", tables=clamps + floor))
    return scene


def hertz(dim: int, load: float) -> tuple[float, float]:
    """Half-width or radius of the contact, and peak pressure."""
    if dim == 2:
        width = 2 * np.sqrt(load * RADIUS / (np.pi * MODULUS))
        return width, 2 * load / (np.pi * width)
    radius = np.cbrt(3 * load * RADIUS / (4 * MODULUS))
    return radius, 3 * load / (2 * np.pi * radius**2)


@pytest.mark.parametrize("dim, degree, fine, scatter", ((2, 1, 0.068, 0.01), (2, 2, 0.068, 0.01), (3, 1, 0.04, 0.04), (3, 2, 0.06, 0.01)))
def test_hertz(dim: int, degree: int, fine: float, scatter: float, tmp_path: Path) -> None:
    """The pressure is Hertz's for the same resultant; `scatter`: the tolerance of single nodes, RMS."""
    out = tmp_path / "hertz"
    signorini("simulate", hertz_scene(dim, degree, fine, tmp_path), out)
    contact = table(out / "contact.csv")
    now = contact["step"] == contact["step"][-1]
    x = np.column_stack([contact[axis][now] for axis in "xyz"[:dim]])
    force, area, p = (contact[name][now] for name in ("force", "area", "pressure"))
    assert (p[area > 0] > 0).sum() > 20 and (force >= 0).all(), "hardly any contact: the case says nothing"
    resultant = force.sum() * (4 if dim == 3 else 1)
    radius, peak = hertz(dim, resultant)
    nodes, cells, fields = stored(out, "state", "pressure")
    r = np.linalg.norm(nodes[:, : dim - 1], axis=1)
    pressed = fields[-1].reshape(-1) > 1e-12 * fields[-1].max()  # rounding is left of forces that were none
    assert r[pressed].max() < 1.2 * radius

    def exact(places: np.ndarray) -> np.ndarray:
        return peak * np.sqrt(np.maximum(0, 1 - (np.linalg.norm(places[:, : dim - 1], axis=1) / radius) ** 2))

    near = boundary(cells)
    near = near[(r[near] < 1.5 * radius).all(axis=1) & (nodes[near][:, :, dim - 1] < 0.1 * RADIUS).all(axis=1)]
    if dim == 3:  # without the planes of symmetry
        near = near[(abs(np.linalg.norm(nodes[near] - [0, 0, RADIUS], axis=2) - RADIUS) < 1e-6).all(axis=1)]
    means = hat_means(nodes[:, :dim] if dim == 3 else nodes, near, exact)
    vertices = np.flatnonzero(area > 0)
    node = np.array([np.argmin(np.linalg.norm(nodes[:, :dim] - x[i], axis=1)) for i in vertices])
    inside = r[node] < 1.2 * radius
    vertices, node = vertices[inside], node[inside]
    found, expected, weight = p[vertices], means[node], area[vertices]
    off = abs(found - fields[-1].reshape(-1)[node]).max()
    assert off <= 1e-14 * found.max(), "the field and the table differ"
    moment = {2: 4, 3: 5 / 2}[dim]  # a² over the mean of r² under Hertz's pressure
    width = np.sqrt((area * p * np.linalg.norm(x[:, : dim - 1], axis=1) ** 2).sum() / (area * p).sum() * moment)
    print(f"{(found > 0).sum()} vertices in contact, a/R = {radius / RADIUS:.3f}, h/a = {fine / radius:.2f}")
    assert (area * p).sum() / force.sum() == pytest.approx(1, abs=1e-12), "sum of pressure times area over the forces'"
    fitted = (weight * found * expected).sum() / (weight * expected**2).sum()
    assert fitted == pytest.approx(1, abs=0.01), "peak, by least squares, over Hertz's"
    assert width / radius == pytest.approx(1, abs=0.01), "radius, by the second moment, over Hertz's"
    core = r[node] < 0.8 * radius
    off = np.sqrt((weight * (found - expected) ** 2)[core].sum() / (weight * expected**2)[core].sum())
    assert off <= scatter, "single vertices within 0.8 a, RMS"
