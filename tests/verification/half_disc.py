# SPDX-License-Identifier: GPL-3.0-or-later
"""C0, the half disc: the figures of an independent implementation, on three meshes."""

import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, relative, signorini, table  # noqa: E402

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


def figures(size: float, out: Path) -> tuple[float, ...]:
    rest, still = evaluate(size, 0, out)
    assert not still["active"].any(), "nothing pushes, and yet there is contact"
    half, _ = evaluate(size, -0.5, out)
    pushed, steps = evaluate(size, -1, out)
    touching = steps["step"][steps["active"] > 0]
    assert len(touching) > 50, "hardly any contact: the case says nothing"
    assert touching[0] == 26, f"first contact at step {touching[0]}"
    assert 35 in touching, "contact is open at step 35"
    assert not steps["weak"].any(), "weak contact at the reference control"
    assert not steps["active"][70:110].any() and 112 in touching, "the body does not leave and come back"
    energy = steps["kinetic_energy"] + steps["elastic_energy"]
    assert abs(steps["energy_residual"]).max() <= 1e-10 * energy.max()
    return (rest["objective"], rest["gradient_norm"], pushed["objective"], half["objective"],
            steps["contact_force_y"].sum() * STEP, energy[-1], lowest_displacement(out))  # fmt: skip


def main() -> int:
    failed = False
    print("size   J(0)     |g(0)|   J(u_ref)  J(u_ref/2)  impulse  energy      lowest y   worst deviation")
    with tempfile.TemporaryDirectory() as folder:
        for size, expected in REFERENCE.items():
            found = figures(size, Path(folder) / "out")
            worst = np.max([relative(f, e) for f, e in zip(found, expected, strict=True)])
            failed |= worst > TOLERANCE
            print("{:4.2f}  {:.5f}  {:.5f}  {:.6f}  {:.6f}    {:.0f}    {:.4e}  {:.5f}   {:.2e}".format(size, *found, worst))
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
