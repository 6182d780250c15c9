# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes that show what a user of a contact program asks, beside statics, free fall and momentum."""

import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SOURCE, Figures, signorini, stored, table  # noqa: E402

import numpy as np  # noqa: E402

SCENES = SOURCE / "scenes"


def told(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def gripper(out: Path, figures: Figures) -> None:
    """Uniform strain between smooth jaws, held since 0.1 s: the slowest shear wave of the block has died by then."""
    signorini("simulate", SCENES / "gripper.toml", out)
    rows = table(out / "obstacles.csv")
    statics = 1e7 / (1 - 0.3**2) * 2e-3
    for name in ("left jaw", "right jaw"):
        force = rows["normal_force"][rows["obstacle"] == name]
        assert force[0] == 0 < force[-1]
        figures.show(f"gripper: {name} at rest, of statics", force[-1] / statics, 1, 0.01)


def incline(out: Path, figures: Figures) -> None:
    signorini("simulate", SCENES / "incline.toml", out, output__every=1)
    steps, body = table(out / "steps.csv"), table(out / "probes.csv")
    assert (steps["active"][200:] == 11).all(), "the block does not lie on the plane"
    slid = body["block.center_x"] - body["block.center_x"][0]
    figures.show("incline: slid, of g sin(20) t^2/2", slid[-1] / (3.355218 * 0.5**2 / 2), 1, 1e-9)
    force = steps["contact_force_y"][200:].mean()
    figures.show("incline: mean force, of m g cos(20)", force / (1000 * 9.218385), 1, 0.01)


def ring(out: Path, figures: Figures) -> None:
    signorini("simulate", SCENES / "ring.toml", out)
    found, body, steps = told(out)["impact"], table(out / "probes.csv"), table(out / "steps.csv")
    assert found["all"]["impulse"][1] > 0 and found["ended"], "the ring does not bounce"
    pushed = np.flatnonzero(steps["contact_force_y"])
    mass, v = found["mass"], (found["velocity_before"][1], found["velocity_after"][1])
    weight = mass * 9.81 * 1e-4 * (pushed[-1] - pushed[0] + 1)
    figures.show("ring: restitution by impulse and by velocities", (found["all"]["impulse"][1] - weight) / (mass * -v[0]) - 1, -v[1] / v[0], 1e-6)
    figures.least("ring: restitution", -v[1] / v[0], 0.1)
    assert {one["name"] for one in told(out)["warnings"]} <= {"few nodes in contact", "stress of the mesh"}, told(out)["warnings"]
    assert np.isclose(body["ring.momentum_y"][0], -0.2 * mass, rtol=1e-12, atol=0)


def beam(out: Path, figures: Figures) -> None:
    """The ball goes down by 0.6 mm from 0.1 mm above the beam, where the mesh is fine enough for it."""
    signorini("simulate", SCENES / "beam.toml", out, output__every=50, mesh__scale=2)
    rows, probes = table(out / "obstacles.csv"), table(out / "probes.csv")
    down = -probes["middle.displacement_z"].min()
    assert rows["normal_force"].max() > 0 == rows["normal_force"][0]
    assert {one["name"] for one in told(out)["warnings"]} <= {"stress of the mesh"}, told(out)["warnings"]
    figures.least("beam: its middle goes down, of the ball's way", down / 0.5e-3, 0.9)
    von_mises = stored(out, "state", "von_mises")[2]
    figures.least("beam: largest von Mises stress, MPa", von_mises.max() / 1e6, 10)


def block(out: Path, figures: Figures) -> None:
    signorini("optimize", SCENES / "block.toml", out, optimizer__tolerance=1e-6)
    history, run = table(out / "history.csv"), told(out)
    assert run["stop_reason"] == "gradient norm below tolerance" and {one["name"] for one in run["warnings"]} <= {"energy lost in contact"}, run
    assert (table(out / "steps.csv")["active"] > 0).sum() > 10
    figures.show("block: gradient norm, of the first", history["gradient_norm"][-1] / history["gradient_norm"][0], 0, 1e-6)


def main() -> int:
    figures = Figures()
    with tempfile.TemporaryDirectory() as folder:
        for part in (gripper, incline, ring, beam, block):
            part(Path(folder) / part.__name__, figures)
    return 1 if figures.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
