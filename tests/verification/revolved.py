# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies of revolution by their half section, and plates: uniform pressure to rounding, Hertz's ball, and a ball in space.

Patches and Hertz's press are at rest after one step, as at_rest.py says.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from at_rest import LAMBDA, MODULUS, MU, NU, PRESS, RADIUS, RUNS, SCENE, SCHEMES, E, box, hat_means
from harness import SOURCE, boundary, signorini, stored, table

SQUEEZE = {"x": 0.01, "y": 0.02}  # strains along radius and height


def section(text: str) -> str:
    """The scene with its mesh as a half section."""
    return text.replace("[mesh]\n", '[mesh]\nmodel = "axisymmetric"\n', 1)


# The unit square is the half section of a cylinder, whose base rests on a plane, and whose side in a tube or on a clamp.
TUBE = '[[contact]]\non = "x1"\nmass = "{mass}"\nobstacle = {{ shape = "cylinder", point = [0, 0], radius = 1.0, side = "inside" }}\n'
CLAMP = '[[clamp]]\non = "x1"\ncomponents = ["x"]\nvalue = ["-0.01"]\n[[output.probe]]\nname = "side"\non = "x1"\n'
SIDES = {"in a tube": TUBE, "squeezed": CLAMP}


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("scheme, ranks", RUNS)
@pytest.mark.parametrize("degree", (1, 2))
def test_cylinder(degree: int, scheme: str, ranks: int, side: str, tmp_path: Path) -> None:
    """Uniform strain: pressures, areas and resultants of the whole body."""
    time_scheme, mass = SCHEMES[scheme]
    radial = 0.0 if side == "in a tube" else -SQUEEZE["x"]
    strain = np.diag([radial, -SQUEEZE["y"], radial])
    stress = LAMBDA * np.trace(strain) * np.eye(3) + 2 * MU * strain
    assert stress[0, 0] < 0 and stress[1, 1] < 0, "no contact: the case says nothing"
    base = f'[[contact]]\non = "y0"\nmass = "{mass}"\nobstacle = {{ shape = "half-space", point = [0, 0], normal = [0, 1] }}\n'
    tables = (f'[[clamp]]\non = "y1"\ncomponents = ["y"]\nvalue = ["-{SQUEEZE["y"]}"]\n{base}{SIDES[side].format(mass=mass)}'
              f'[initial]\ndisplacement = ["{radial}*x", "-{SQUEEZE["y"]}*y"]\n')  # fmt: skip
    scene, out = tmp_path / "patch.toml", tmp_path / "patch"
    text = SCENE.format(mesh=box(2, tmp_path), size="size = 0.3", degree=degree, scheme=time_scheme, tables=tables)
    scene.write_text(section(text))
    signorini("simulate", scene, out, ranks)
    contact, steps = table(out / "contact.csv"), table(out / "steps.csv")
    now = contact["step"] == 3
    surfaces = [("obstacle 1", -stress[1, 1], np.pi)] + ([("obstacle 2", -stress[0, 0], 2 * np.pi)] if side == "in a tube" else [])
    for obstacle, pressure, area in surfaces:
        own = now & (contact["obstacle"] == obstacle)
        assert contact["area"][own].sum() == pytest.approx(area, abs=1e-12 * area)
        assert contact["pressure"][own] / pressure == pytest.approx(1, abs=1e-10)
        assert contact["force"][own].sum() / (pressure * area) == pytest.approx(1, abs=1e-10)
        if degree == 2 and obstacle == "obstacle 1":
            assert contact["x"][own].min() > 0, "the vertex on the axis is a candidate"
    assert steps["contact_force_y"][-1] / (-stress[1, 1] * np.pi) == pytest.approx(1, abs=1e-10)
    assert (steps["contact_force_x"] == 0).all(), "a radial resultant"
    if side == "squeezed":
        force = table(out / "probes.csv")["side.reaction_x"][-1]
        assert force / (2 * np.pi * stress[0, 0]) == pytest.approx(1, abs=1e-10), "sum of the radial forces of the clamp"
    for name, exact in (("strain", strain), ("stress", stress)):
        found = stored(out, "state", name)[2][-1].reshape(-1, 3, 3)
        assert abs(found - exact).max() / abs(exact).max() <= 1e-10, name


@pytest.mark.parametrize("scheme, ranks", RUNS)
@pytest.mark.parametrize("degree", (1, 2))
def test_plate(degree: int, scheme: str, ranks: int, tmp_path: Path) -> None:
    """A square plate between a clamp and a plane, free at its sides: uniaxial stress, E alone, and nothing across it."""
    time_scheme, mass = SCHEMES[scheme]
    tables = (f'[[clamp]]\non = "y1"\ncomponents = ["y"]\nvalue = ["-0.02"]\n[[contact]]\non = "y0"\nmass = "{mass}"\n'
              f'obstacle = {{ shape = "half-space", point = [0, 0], normal = [0, 1] }}\n'
              f'[initial]\ndisplacement = ["{0.02 * NU}*x", "-0.02*y"]\n')  # fmt: skip
    scene, out = tmp_path / "plate.toml", tmp_path / "plate"
    text = SCENE.format(mesh=box(2, tmp_path), size="size = 0.3", degree=degree, scheme=time_scheme, tables=tables)
    scene.write_text(text.replace("[mesh]\n", '[mesh]\nmodel = "plane-stress"\n', 1))
    signorini("simulate", scene, out, ranks)
    contact = table(out / "contact.csv")
    now = contact["step"] == 3
    assert contact["pressure"][now] / (0.02 * E) == pytest.approx(1, abs=1e-10)
    stress = stored(out, "state", "stress")[2][-1].reshape(-1, 3, 3)
    assert abs(stress - np.diag([0, -0.02 * E, 0])).max() <= 1e-10 * 0.02 * E


@pytest.mark.parametrize("degree", (1, 2))
def test_hertz(degree: int, tmp_path: Path) -> None:
    """Half a ball pressed onto a plane: radius, peak and profile are Hertz's for the same force."""
    fine = 0.04
    text = PRESS.read_text().replace("fine = 0.068;", f"fine = {fine};")
    # The right half of the half disc in place of both.
    start, end = text.index("Point(5)"), text.index("// As fine as")
    half = "Circle(1) = {2, 1, 3};\nCircle(2) = {3, 1, 4};\nLine(3) = {4, 1};\nLine(4) = {1, 2};\n"
    text = text[:start] + half + "Curve Loop(1) = {1, 2, 3, 4};\nPlane Surface(1) = {1};\n" + text[end:]
    text = text.replace("{5, 1}", "{1}").replace("{2, 4}", "{2}")
    mesh, scene, out = tmp_path / "press.geo", tmp_path / "press.toml", tmp_path / "press"
    mesh.write_text(text)
    tables = ('[[clamp]]\non = "top"\ncomponents = ["y"]\nvalue = ["-0.03"]\n'
              '[contact]\non = "contact"\nobstacle = { shape = "half-space", point = [0, 0], normal = [0, 1] }\n')  # fmt: skip
    scene.write_text(section(SCENE.format(mesh=mesh, size="", degree=degree, scheme="contact-implicit", tables=tables)))
    signorini("simulate", scene, out)
    contact = table(out / "contact.csv")
    now = contact["step"] == contact["step"][-1]
    r, force, area, p = (contact[name][now] for name in ("x", "force", "area", "pressure"))
    assert (p > 0).sum() > 10, "hardly any contact: the case says nothing"
    radius = np.cbrt(3 * force.sum() * RADIUS / (4 * MODULUS))
    peak = 3 * force.sum() / (2 * np.pi * radius**2)
    nodes, cells, fields = stored(out, "state", "pressure")
    assert nodes[fields[-1].reshape(-1) > 1e-12 * fields[-1].max(), 0].max() < 1.2 * radius
    near = boundary(cells)
    near = near[(nodes[near][:, :, 0] < 1.5 * radius).all(axis=1) & (nodes[near][:, :, 1] < 0.1 * RADIUS).all(axis=1)]
    near = near[(abs(np.linalg.norm(nodes[near][:, :, :2] - [0, RADIUS], axis=2) - RADIUS) < 1e-6).all(axis=1)]
    profile = lambda places: peak * np.sqrt(np.maximum(0, 1 - (places[:, 0] / radius) ** 2))  # noqa: E731
    means = hat_means(nodes, near, profile, weight=lambda places: places[:, 0])
    vertices = np.flatnonzero((area > 0) & (r < 1.2 * radius))
    expected = means[[np.argmin(abs(nodes[:, 0] - r[i]) + abs(nodes[:, 1]) * (nodes[:, 1] > 0.1)) for i in vertices]]
    assert (area * p).sum() / force.sum() == pytest.approx(1, abs=1e-12), "sum of pressure times area over the forces'"
    fitted = (area[vertices] * p[vertices] * expected).sum() / (area[vertices] * expected**2).sum()
    assert fitted == pytest.approx(1, abs=0.01), "peak, by least squares, over Hertz's"
    second = np.sqrt((force * r**2).sum() / force.sum() * 5 / 2)  # a² over the mean of r² under Hertz's pressure
    assert second / radius == pytest.approx(1, abs=0.01), "radius, by the second moment, over Hertz's"


# --- A ball in space, and its half section ---------------------------------------------------------------------------------

PUSHED = """
[mesh]
file = "{mesh}"
size = {size}
[time]
end = 7.5e-3
step = 6.25e-5
scheme = "contact-stabilized"
[material]
density = 1.0
young = 1e8
poisson = 0.3
viscosity = {{ bulk = 1e4, shear = 1e4 }}
[[clamp]]
on = "top"
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [{zeros}-15.3], normal = [{zeros}1] }}
[load]
body = [{still}"-1e6*(1 - cos(800*t))"]
[output]
fields = []
"""


def pushed(dim: int, size: float, folder: Path) -> tuple[np.ndarray, dict]:
    """Vertical contact force of the half ball at the steps, means of two, and the run's manifest."""
    scene, out = folder / f"{dim}-{size}.toml", folder / f"{dim}-{size}"
    name = "half-ball-section.geo" if dim == 2 else "half-ball.geo"
    text = PUSHED.format(mesh=SOURCE / "meshes" / name, size=size, zeros="0, " * (dim - 1), still='"0", ' * (dim - 1))
    scene.write_text(section(text) if dim == 2 else text)
    signorini("simulate", scene, out)
    force = table(out / "steps.csv")["contact_force_" + "xyz"[dim - 1]]
    return (force[1:] + force[:-1]) / 2, json.loads((out / "run.json").read_text())


def test_ball(tmp_path: Path) -> None:
    """The force over time of a ball in space tends to that of its half section, which has a fraction of the unknowns."""
    exact, _ = pushed(2, 0.2, tmp_path)
    assert (exact > 0).sum() > 20, "hardly any contact: the case says nothing"

    def error(dim: int, size: float) -> tuple[float, int]:
        force, run = pushed(dim, size, tmp_path)
        off, seconds = np.linalg.norm(force - exact) / np.linalg.norm(exact), run["timings"]["forward"]["seconds"]
        body = "half section" if dim == 2 else "ball in space"
        print(f"{body}, size {size}: {100 * off:.2f} % with {run['unknowns']} unknowns in {seconds:.4f} s")
        return off, run["unknowns"]

    space, plane = [error(3, size) for size in (2.5, 1.25)], [error(2, size) for size in (2.5, 1.25, 0.625)]
    assert space[1][0] < 0.02 and space[0][0] / space[1][0] > 2, "the ball in space does not tend to the half section"
    assert plane[2][0] < 0.02 and plane[0][0] / plane[2][0] > 3, "the half section does not converge"
    assert space[1][1] > 5 * plane[2][1], "at about the same error the half section has no fraction of the unknowns"
