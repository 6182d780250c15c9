# SPDX-License-Identifier: GPL-3.0-or-later
"""1000 iterations of Algorithm 1 on the half disc at h = 0.5, and the behaviour that the paper reports of them."""

import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, signorini, table  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402

STEP_OF_FIGURES = 35  # t = 0.00175 s
TRIALS = 1.5  # forward sweeps an iteration, for the line search; 1.38 found


def field(out: Path, name: str, step: int) -> np.ndarray:
    """Nodal values (nodes × 2) of a stored field after `step` steps."""
    with h5py.File(out / f"{name}.h5") as file:
        states = file[f"Function/{name}"]
        order = sorted(states, key=lambda key: float(key.replace("_", ".")))
        return states[order[step - 1]][:, :2]


def near(points: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """Which of `points` are among `targets`."""
    return (np.linalg.norm(points[:, None] - targets[None], axis=2) < 1e-9).any(axis=1)


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        signorini("optimize", HALF_DISC, out, optimizer__method="projected-gradient", optimizer__max_iterations=1000,
                  optimizer__tolerance=0)  # fmt: skip
        history, steps, contact = (table(out / f"{name}.csv") for name in ("history", "steps", "contact"))
        run = json.loads((out / "run.json").read_text())
        with h5py.File(out / "control.h5") as file:
            points = file["Mesh/mesh/geometry"][:]
        u, p = (field(out, name, STEP_OF_FIGURES) for name in ("control", "adjoint"))

    sweeps = run["timings"]["forward"], run["timings"]["adjoint"]
    print(f"{history['forward_sweeps'][-1]:.0f} forward and {history['adjoint_sweeps'][-1]:.0f} adjoint "
          f"sweeps, {1e3 * sweeps[0]['seconds'] / sweeps[0]['calls']:.0f} and "
          f"{1e3 * sweeps[1]['seconds'] / sweeps[1]['calls']:.0f} ms each")  # fmt: skip
    assert len(history["iteration"]) == 1001
    assert 1000 < history["forward_sweeps"][-1] < TRIALS * 1000 and 1000 < history["adjoint_sweeps"][-1] <= 1002
    J, distance = history["objective"], history["relative_distance_to_reference"]
    print(f"J: {J[0]:.5f}, {J[100]:.5f} (100), {J[600]:.6f} (600), {J[-1]:.6f}; distance to the reference control: "
          f"{distance[100]:.4f} (100), {distance[200]:.4f} (200), {distance[-1]:.4f}, least at {distance.argmin()}")  # fmt: skip
    assert (np.diff(J) < 0).all(), "J rose"
    assert J[100] < 0.0115 and J[600] < 0.01010

    # Seed, Fig. 5: no control on the clamp, none normal to the plane where contact is active. There p·ν = 0, so that an iteration only
    # shrinks u·ν by 1 - α/ω: slowly, to zero where J is stationary (optimizers.py).
    now = contact["step"] == STEP_OF_FIGURES
    active = now & (contact["force"] > 0)
    assert active.sum() > 3, "no contact at t = 0.00175"
    touching = near(points, np.column_stack([contact["x"], contact["y"]])[active])
    clamped = np.isclose(points[:, 1], points[:, 1].max(), rtol=0, atol=1e-9)
    size = np.linalg.norm(u, axis=1).max()
    print(f"control at t = 0.00175: largest {size:.3f}, on the clamp {abs(u[clamped]).max():.1e}, normal at the "
          f"{touching.sum()} active nodes {abs(u[touching, 1]).max():.1e}, of the adjoint state {abs(p[touching, 1]).max():.1e}")  # fmt: skip
    assert abs(u[clamped]).max() < 1e-12 * size, "u is a multiple of p plus the first guess, zero: it vanishes on the clamp"
    assert abs(p[touching, 1]).max() < 1e-12 * abs(p).max()

    # Seed, Fig. 9: the contact forces are symmetric.
    x, force = contact["x"][active], contact["force"][active]
    left, right = force[x < -1e-6].sum(), force[x > 1e-6].sum()
    print(f"contact force left and right of the axis: {left:.4e}, {right:.4e}")
    assert abs(left - right) < 0.02 * (left + right)
    assert steps["weak"].sum() == 0 or steps["weak"].max() <= 3
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
