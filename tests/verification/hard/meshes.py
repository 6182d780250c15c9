# SPDX-License-Identifier: GPL-3.0-or-later
"""Badly shaped meshes: triangles a thousand times as long as high, and elements of sizes from 1 to 1000 in one mesh.

`check` compares the laws with fixed parts of the energy, as for a good mesh, where such elements are a layer of the body. A body
of nothing else is softer than its elements by their number: there the laws are satisfied to the rounding of the forces between
nodes. Contact keeps complementarity in either, since it is sought in the candidates alone.
"""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, attempt, table
from schemes import EPSILON, SCHEMES, energy, run

SMALLEST, ASPECT = 1e-4, 1000  # m
YOUNG = 50.0

SCENE = """
[mesh]
file = "mesh.geo"
[time]
end = 0.06
step = 1e-3
[material]
density = 1.0
young = {young}
poisson = 0.3
viscosity = {{ bulk = 0.05, shear = 0.05 }}
[contact]
on = "bottom"
obstacle = {{ shape = "half-space", point = [0, -0.01], normal = [0.01, 1] }}
[load]
body = ["0", "-1"]
[initial]
velocity = ["0", "-1"]
[control]
scale = 1.0
[objective]
desired = {{ control = ["0.3", "-1"] }}
alpha = 1e-2
gamma = 1e-2
"""

SQUARE = (SOURCE / "tests" / "data" / "square.geo").read_text()


def rectangle(width: float, height: float, columns: int, rows: int) -> str:
    """The square's file, of another size and in rows and columns of triangles."""
    corners = SQUARE.replace("{1, 0, 0}", f"{{{width}, 0, 0}}").replace("{1, 1, 0}", f"{{{width}, {height}, 0}}")
    return (corners.replace("{0, 1, 0}", f"{{0, {height}, 0}}") + f"Transfinite Curve{{1, 3}} = {columns + 1};\n"
            f"Transfinite Curve{{2, 4}} = {rows + 1};\nTransfinite Surface{{1}};\n")  # fmt: skip


LONG = SMALLEST * ASPECT
GROWTH = 1.4  # of a row beside the one before
ROWS = round(np.log(1 + (GROWTH - 1) / SMALLEST) / np.log(GROWTH))  # from the smallest to 1 m
LAYERS = {
    "slivers along the contact": SQUARE + "Transfinite Curve{1, 3} = 11;\n"
    f"Transfinite Curve{{2, -4}} = {ROWS + 1} Using Progression {GROWTH};\nTransfinite Surface{{1}};\n",
    "slivers across the contact": SQUARE + "Transfinite Curve{2, 4} = 11;\n"
    f"Transfinite Curve{{1, -3}} = {ROWS + 1} Using Progression {GROWTH};\nTransfinite Surface{{1}};\n",
    # Fine where it touches first.
    "sizes 1 to 1000": re.sub(r"\{([01]), ([01]), 0\}",
                              lambda p: f"{{{p[1]}, {p[2]}, 0, {SMALLEST if p[1] == p[2] == '0' else LONG}}}", SQUARE),
}  # fmt: skip
THROUGHOUT = {
    "slivers along the contact": rectangle(1, 100 * SMALLEST, round(1 / LONG), 100),
    "slivers across the contact": rectangle(100 * SMALLEST, 1, 100, round(1 / LONG)),
}
LAWS = {"energy law": "energy", "momentum law": "momentum", "force x gap": "complementarity", "transpose identity": "transpose",
        "contact occurred": "contact in"}  # fmt: skip


def body(folder: Path, mesh: str) -> Path:
    """The scene of a body of this mesh."""
    (folder / "mesh.geo").write_text(mesh)
    scene = folder / "scene.toml"
    scene.write_text(SCENE.format(young=YOUNG))
    return scene


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("case", LAYERS)
def test_layer(case: str, scheme: str, tmp_path: Path) -> None:
    done = attempt("check", body(tmp_path, LAYERS[case]), **SCHEMES[scheme])
    found = {name: re.search(rf"{law}.*?(\d\.\d+e[+-]\d+|\d+ steps)", done.stdout) for law, name in LAWS.items()}
    print(", ".join(f"{name} {law[1] if law else 'never'}" for name, law in found.items()))
    assert done.returncode == 0, "\n".join(re.findall(r"^FAIL .*", done.stdout, re.M)) + done.stderr


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("case", THROUGHOUT)
def test_throughout(case: str, scheme: str, tmp_path: Path) -> None:
    steps = run(body(tmp_path, THROUGHOUT[case]), tmp_path / "out", output__every=1, **SCHEMES[scheme])
    contact, unknowns = table(tmp_path / "out" / "contact.csv"), json.loads((tmp_path / "out" / "run.json").read_text())["unknowns"]
    largest = contact["force"].max()
    assert largest > 0, "no contact: the case says nothing"
    moved = 0.06 * (1 + 0.06 / 2)  # m, at most, under the load
    # Each unknown's force E l/h y, of which a rigid motion has none, cancels to its last digit, and its work with it.
    rounding = EPSILON * unknowns * YOUNG * ASPECT * moved**2 / energy(steps).max()
    off = abs(steps["energy_residual"]).max() / energy(steps).max()
    # A gap is closed within 1e-10 of the body, and a force none if it moves its node, alone, by no more: that of the six
    # triangles around it, of L/h/2 each, by A/2 + B/τ. It may pull by as much.
    closed = 1e-10
    negligible = closed * 6 * ASPECT / 2 * (YOUNG * 0.7 / (1.3 * 0.4) / 2 + (0.05 + 4 / 3 * 0.05) / 1e-3)
    open_under_force = abs(contact["force"] * contact["gap"]).max() / largest
    penetration, adhesion = np.maximum(0, -contact["gap"].min()), np.maximum(0, -contact["force"].min())
    print(f"{(steps['contact_force_y'] > 0).sum()} steps in contact, energy law {off:.1e} (<= {rounding:.0e}), penetration "
          f"{penetration:.0e} m, force x gap {open_under_force:.0e} m (each <= {closed:.0e}), adhesion {adhesion:.0e} N "
          f"(<= {negligible:.0e}) of {largest:.0e}")  # fmt: skip
    assert off <= rounding
    assert penetration <= closed
    assert open_under_force <= closed
    assert adhesion <= negligible
