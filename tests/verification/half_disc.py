# SPDX-License-Identifier: GPL-3.0-or-later
"""C0, the half disc: the figures of an independent implementation, on three meshes."""

from pathlib import Path

import pytest
from harness import HALF_DISC, signorini, table

# size: J(0), |g(0)|, J(u_ref), J(u_ref/2), contact impulse, energy at T, lowest y_n at T
REFERENCE = {
    1.0: (0.38274, 0.82601, 0.013244, 0.086056, 93008, 7.7604e7, -0.80455),
    0.5: (0.38484, 0.83043, 0.013251, 0.086592, 93515, 7.7902e7, -0.80761),
    0.25: (0.38559, 0.83195, 0.013253, 0.086796, 93580, 7.8054e7, -0.80830),
}
TOLERANCE = 0.005
STEP = 5e-5


def evaluate(size: float, push: float, out: Path) -> tuple[dict, dict]:
    """First row of the history and the steps at the constant control (0, push)."""
    signorini("optimize", HALF_DISC, out, mesh__size=size, control__initial=["0", str(push)], optimizer__max_iterations=0)
    return {key: column[0] for key, column in table(out / "history.csv").items()}, table(out / "steps.csv")


def lowest_displacement(out: Path) -> float:
    import h5py

    with h5py.File(out / "state.h5") as file:
        states = file["Function/displacement"]
        last = max(states, key=lambda name: float(name.replace("_", ".")))
        return float(states[last][:, 1].min())


@pytest.mark.parametrize("size", REFERENCE)
def test_reference(size: float, tmp_path: Path) -> None:
    out = tmp_path / "out"
    rest, still = evaluate(size, 0, out)
    assert not still["active"].any(), "nothing pushes, and yet there is contact"
    half, _ = evaluate(size, -0.5, out)
    pushed, steps = evaluate(size, -1, out)
    touching = steps["step"][steps["active"] > 0]
    assert len(touching) > 50, "hardly any contact: the case says nothing"
    assert touching[0] == 26, "the first contact"
    assert 35 in touching, "contact is open at step 35"
    assert not steps["weak"].any(), "weak contact at the reference control"
    assert not steps["active"][70:110].any() and 112 in touching, "the body does not leave and come back"
    energy = steps["kinetic_energy"] + steps["elastic_energy"]
    assert abs(steps["energy_residual"]).max() <= 1e-10 * energy.max()
    found = (rest["objective"], rest["gradient_norm"], pushed["objective"], half["objective"],
             steps["contact_force_y"].sum() * STEP, energy[-1], lowest_displacement(out))  # fmt: skip
    assert found == pytest.approx(REFERENCE[size], rel=TOLERANCE)
