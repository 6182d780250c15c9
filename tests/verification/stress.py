# SPDX-License-Identifier: GPL-3.0-or-later
"""Stress of a viscoelastic bar that is clamped at one end and kept from widening, released and ringing down: closed form.

The strain is u'(x, t) e_x e_x alone, so that along the bar the moduli are λ + 2μ and κ + 4η/3, across it λ and κ - 2η/3,
out of the plane too. Fields are means over cells, taken at midpoints: of order h with degree 1, h² with degree 2.
"""

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from harness import SOURCE, signorini, stored

LENGTH, SIZE = 2.0, 0.1  # m, of the bar and of the motion
E, NU, RHO, KAPPA, ETA = 3.0, 0.3, 1.0, 0.2, 0.3
LAMBDA, MU = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
ALONG, ACROSS = (LAMBDA + 2 * MU, KAPPA + 4 * ETA / 3), (LAMBDA, KAPPA - 2 * ETA / 3)  # elastic, viscous
END = 0.8  # s, a fifth of a period
MESHES = {2: ("parts.geo", {1: 0.05, 2: 0.4}), 3: ("parts-space.geo", {1: 0.15, 2: 0.36})}  # coarser size by degree

SCENE = """
[mesh]
file = "{mesh}"
size = {size}
degree = {degree}
[time]
end = {end}
step = {step}
[material]
density = {rho}
young = {young}
poisson = {poisson}
viscosity = {{ bulk = {kappa}, shear = {eta} }}
[[clamp]]
on = "start"
components = ["x"]
[[clamp]]
on = "boundary"
components = {across}
[initial]
displacement = {start}
[output]
every = 1000000
fields = ["strain", "stress", "von_mises"]
"""


def slope(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u' and its rate at END: of the damped oscillation of the first mode sin(kx)."""
    k = np.pi / (2 * LENGTH)
    delta, eigen = ALONG[1] * k**2 / (2 * RHO), np.sqrt(ALONG[0] / RHO) * k
    omega = np.sqrt(eigen**2 - delta**2)
    decay = SIZE * np.exp(-delta * END)
    value = decay * (np.cos(omega * END) + delta / omega * np.sin(omega * END))
    rate = -decay * eigen**2 / omega * np.sin(omega * END)
    return value * k * np.cos(k * x), rate * k * np.cos(k * x)


def errors(dim: int, degree: int, size: float, folder: Path) -> dict[str, float]:
    """Relative errors in L2 at the end."""
    mesh = SOURCE / "tests/data" / MESHES[dim][0]
    scene, out = folder / "ring.toml", folder / "out"
    zero = ['"0"'] * (dim - 1)
    scene.write_text(SCENE.format(
        mesh=mesh, size=size, degree=degree, end=END, step=END / round(8 * END / size), rho=RHO, young=E, poisson=NU, kappa=KAPPA,
        eta=ETA, across='["y"]' if dim == 2 else '["y", "z"]',
        start=f'[{", ".join([f"{chr(34)}{SIZE}*sin(pi*x/{2 * LENGTH}){chr(34)}", *zero])}]'))  # fmt: skip
    signorini("simulate", scene, out)
    nodes, cells, stress = stored(out, "state", "stress")
    corners = nodes[cells][:, :, :dim]
    volume = abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    strain, rate = slope(corners.mean(axis=1)[:, 0])
    along, across = (modulus[0] * strain + modulus[1] * rate for modulus in (ALONG, ACROSS))
    assert abs(ALONG[1] * rate).max() > 0.2 * abs(ALONG[0] * strain).max(), "hardly any viscous stress: the case says little"
    exact = np.zeros((len(cells), 3, 3))
    exact[:, 0, 0], exact[:, 1, 1], exact[:, 2, 2] = along, across, across
    exact_strain = np.zeros((len(cells), 3, 3))
    exact_strain[:, 0, 0] = strain
    exact_mises = abs(along - across)

    def error(name: str, expected: np.ndarray) -> float:
        found = stored(out, "state", name)[2][-1].reshape(expected.shape)
        weighted = [(volume * (x.reshape(len(cells), -1) ** 2).sum(axis=1)).sum() for x in (found - expected, expected)]
        return float(np.sqrt(weighted[0] / weighted[1]))

    assert stress.shape[1:] == (len(cells), 3, 3)
    largest = json.loads((out / "run.json").read_text())["largest_von_mises"]
    all_mises = stored(out, "state", "von_mises")[2][:, :, 0]
    assert abs(largest["value"] / all_mises.max() - 1) < 1e-14
    with h5py.File(out / "state.h5") as data:
        found = np.argmin(abs(data["times"][:] - largest["time"]))
    there = np.argmin(np.linalg.norm(corners.mean(axis=1) - largest["point"], axis=1))
    assert all_mises[found, there] >= (1 - 1e-6) * largest["value"], f"not there: {largest}"
    return {"strain": error("strain", exact_strain), "stress": error("stress", exact), "von_mises": error("von_mises", exact_mises)}


@pytest.mark.parametrize("degree", (1, 2))
@pytest.mark.parametrize("dim", MESHES)
def test_order_and_error(dim: int, degree: int, tmp_path: Path) -> None:
    size = MESHES[dim][1][degree]
    coarse, fine = (errors(dim, degree, h, tmp_path) for h in (size, size / 2))
    orders = {field: float(np.log2(coarse[field] / fine[field])) for field in coarse}
    print(", ".join(f"{field}: {coarse[field]:.1e} to {fine[field]:.1e}, order {order:.2f}" for field, order in orders.items()))
    for field, order in orders.items():
        assert order >= degree - 0.15, field
        assert fine[field] <= 0.05, field
