# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of contact between parts of the body: candidates, gaps and sides on two squares that do not match, 5 and 7 elements wide and 0.05 m apart."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from harness import table
from regression.keys.runs import DATA, ROUNDING, Run, Runner, near, optimize_in, same

SQUARES = DATA / "two-squares.toml"
PAIR = "above/below"
GAP = 0.05
# The squares fall on each other without rotation, and part.
FALL = {"initial__velocity": ["0", "y > 1.02 ? -0.3 : 0.2"], "contact__friction": 0.0, "output__every": 1}


def bodies(done: Run) -> dict[str, np.ndarray]:
    found = table(done.folder / "bodies.csv")
    return {name: column.reshape(-1, 2) for name, column in found.items()}


@pytest.mark.key("contact.against")
def test_against(simulate: Runner) -> None:
    """Candidates are the nodes of the finer side, their gap is that of the squares; the forces on the squares are equal and opposite."""
    done = simulate(SQUARES, **FALL)
    assert done.manifest["effects"]["contact of parts"] and done.manifest["candidates"] == 8
    near(done.start["gap"], np.full(8, GAP), 1e-9)
    near(done.start["y"], np.full(8, 1 + GAP), 1e-9)
    assert set(done.start["obstacle"]) == {PAIR}
    near(done.start["area"].sum(), 1.0, 1e-9)
    each = bodies(done)
    assert list(each["body"][0]) == ["upper", "lower"]
    force = table(done.folder / "obstacles.csv")["force_y"]
    assert force.max() > 0.1, "no contact"
    change = np.diff(each["momentum_y"], axis=0)
    near(change[:, 0], 0.01 * force[1:], 1e-12 * force.max())
    near(change.sum(axis=1), np.zeros(len(change)), 1e-14)
    assert abs(done.steps["contact_force_y"]).max() < 1e-12 * force.max(), "forces between parts have no resultant"
    near(each["kinetic_energy"].sum(axis=1), done.steps["kinetic_energy"], 1e-14)
    near(each["elastic_energy"].sum(axis=1), done.steps["elastic_energy"], 1e-14)
    # Contact-implicit steps change the momentum by that of the displacement: y_k − y_{k−1} = τ (v_{k−1} + v_k)/2 in the mean.
    near(np.diff(each["displacement_y"], axis=0), 0.01 * (each["momentum_y"][1:] + each["momentum_y"][:-1]) / 2, 1e-11)


@pytest.mark.key("contact.against")
def test_restitution(simulate: Runner) -> None:
    """It is the ratio of the relative velocities of the two centres of mass."""
    done = simulate(SQUARES, time__end=1.5, **FALL)
    p = bodies(done)["momentum_y"]  # of masses of 1
    relative = p[:, 0] - p[:, 1]
    impact = done.manifest["impact"]
    assert impact["restitution"] == pytest.approx(-relative[-1] / relative[0], rel=1e-9) and 0.3 < impact["restitution"] < 1
    assert [one["name"] for one in impact["bodies"]] == ["upper", "lower"]
    near([one["velocity_at_end"][1] for one in impact["bodies"]], p[-1])
    near([one["mass"] for one in impact["bodies"]], [1, 1])
    assert impact["body"] == "upper"
    assert "relative to lower" in done.stdout


@pytest.mark.key("contact.against", "output.fields")
def test_pressure_on_both_faces(simulate: Runner) -> None:
    """Its integral over either face is the force, but for negative values at the end of contact, which the master's nodes would have."""
    done = simulate(SQUARES, **FALL, output__fields=["displacement", "pressure"])
    with h5py.File(done.folder / "state.h5") as file:
        stored = file["Function/pressure"]
        pressure = np.array([stored[t][:, 0] for t in sorted(stored, key=lambda t: float(t.replace("_", ".")))])
    force = table(done.folder / "obstacles.csv")["force_y"]
    assert len(pressure) == len(force) and force.max() > 0.1
    for height, rounding in ((1.0, 1e-3), (1.05, 1e-9)):
        face = np.flatnonzero(abs(done.points[:, 1] - height) < 1e-9)
        face = face[np.argsort(done.points[face, 0])]
        x = done.points[face, 0]
        hats = np.gradient(x) * np.where((x > 1e-9) & (x < 1 - 1e-9), 1.0, 0.5)
        near(pressure[:, face] @ hats, force, rounding)
        near(np.delete(pressure, np.flatnonzero(abs(done.points[:, 1] - 1.025) < 0.03), axis=1), np.zeros((len(force), len(done.points) - 14)))


@pytest.mark.key("contact.against", "output.fields")
@pytest.mark.parametrize("side", ("on", "against"))
def test_pressure_on_a_wider_face(side: str, simulate: Runner, tmp_path: Path) -> None:
    """Where one square is narrower, pressures times areas still add up to the forces, on the facets that it covers in part too."""
    narrow = SQUARES.with_suffix(".geo").read_text()
    for right in ("Point(6) = {1,", "Point(7) = {1,"):
        assert right in narrow
        narrow = narrow.replace(right, right.replace("1", "0.63"))
    (tmp_path / "narrow.geo").write_text(narrow)
    done = simulate(SQUARES, **FALL, mesh__file=str(tmp_path / "narrow.geo"), contact__slave=side, output__fields=["displacement", "pressure"])
    pressure, force = done.field("pressure")[:, :, 0], table(done.folder / "obstacles.csv")["force_y"]
    assert force.max() > 0.1
    for height in (1.0, 1.05):
        face = np.flatnonzero(abs(done.points[:, 1] - height) < 1e-9)
        face = face[np.argsort(done.points[face, 0])]
        x = done.points[face, 0]
        hats = np.gradient(x) * np.where((x > x.min()) & (x < x.max()), 1.0, 0.5)
        found = pressure[:, face] @ hats
        assert abs(found - force).max() < 0.06 * force.max(), height  # negative values, which are left out
        assert pressure[:, face].max() < 4 * force.max()


@pytest.mark.key("contact.against", "contact.friction", "output.fields")
@pytest.mark.parametrize("degree", (1, 2))
def test_friction_on_both_faces(degree: int, simulate: Runner) -> None:
    """The tractions integrated over the faces are the friction forces on the parts, equal and opposite."""
    slipping = {"initial__velocity": ["y > 1.02 ? 0.3 : 0", "y > 1.02 ? -0.3 : 0.2"], "contact__friction": 0.3, "output__every": 1, "mesh__degree": degree}
    done = simulate(SQUARES, **slipping, output__fields=["displacement", "friction"])
    friction, force = done.field("friction"), table(done.folder / "obstacles.csv")["force_x"]
    assert abs(force).max() > 0.05
    for height, sign in ((1.05, 1), (1.0, -1)):
        face = np.flatnonzero(abs(done.points[:, 1] - height) < 1e-9)
        face = face[np.argsort(done.points[face, 0])]
        x = done.points[face, 0]
        hats = np.gradient(x) * np.where((x > 1e-9) & (x < 1 - 1e-9), 1.0, 0.5)
        near(friction[:, face, 0] @ hats, sign * force, 1e-2 if sign < 0 else 1e-6)


@pytest.mark.key("contact.against", "mesh.degree")
@pytest.mark.parametrize("linear", ("direct", "iterative"))
def test_degree_2(linear: str, simulate: Runner) -> None:
    """Candidates are vertices. A nearly uniform pressure between the squares is nearly that of degree 1, and moves their midpoints with their vertices."""
    done = simulate(SQUARES, **FALL, mesh__degree=2, solver__linear=linear, output__fields=["displacement", "pressure"])
    assert done.manifest["candidates"] == 8 and done.manifest["unknowns"] > 600
    near(done.start["gap"], np.full(8, GAP), 1e-9)
    force = table(done.folder / "obstacles.csv")["force_y"]
    linear_force = table(simulate(SQUARES, **FALL).folder / "obstacles.csv")["force_y"]
    assert force.max() > 0.1 and force.sum() == pytest.approx(linear_force.sum(), rel=0.02)
    change = np.diff(bodies(done)["momentum_y"], axis=0)
    near(change[:, 0], 0.01 * force[1:], 1e-9 * force.max())
    near(change.sum(axis=1), np.zeros(len(change)), 1e-11)
    pressure = done.field("pressure")[:, :, 0]
    for height in (1.0, 1.05):
        face = np.flatnonzero(abs(done.points[:, 1] - height) < 1e-9)
        face = face[np.argsort(done.points[face, 0])]
        x = done.points[face, 0]
        near(pressure[:, face] @ (np.gradient(x) * np.where((x > 1e-9) & (x < 1 - 1e-9), 1.0, 0.5)), force, 1e-3)


@pytest.mark.key("contact.initial", "contact.against")
@pytest.mark.parametrize("degree", (1, 2))
def test_project(degree: int, simulate: Runner) -> None:
    """Nodes of the slave side alone move out of the other part, whose surface stays."""
    done = simulate(SQUARES, initial__displacement=["0", "y > 1.02 ? -0.055 + 0.01*x : 0"], contact__initial="project", mesh__degree=degree,
                    contact__friction=0.0, output__every=1)  # fmt: skip
    before = GAP - 0.055 + 0.01 * done.start["x"]
    near(done.start["gap"], np.maximum(before, 0), 1e-12)
    assert 2 < (before < 0).sum() < 6, "some were inside"
    y = done.field("displacement")[0][:, 1]
    near(y[done.points[:, 1] < 1.02], np.zeros((done.points[:, 1] < 1.02).sum()), 1e-15)


@pytest.mark.key("contact.slave")
@pytest.mark.parametrize("side, y, candidates, sign", (("on", 1.05, 8, 1), ("against", 1.0, 6, 1), (None, 1.05, 8, 1)))
def test_slave(side: str | None, y: float, candidates: int, sign: int, simulate: Runner) -> None:
    """It has the candidates; the force reported is that on the group `on` either way."""
    done = simulate(SQUARES, **FALL, **({"contact__slave": side} if side else {}))
    assert done.manifest["candidates"] == candidates
    near(done.start["y"], np.full(candidates, y), 1e-9)
    force = table(done.folder / "obstacles.csv")["force_y"]
    assert force.max() > 0.1 and force.min() >= 0
    default = simulate(SQUARES, **FALL)
    near(done.steps["kinetic_energy"], default.steps["kinetic_energy"], 2e-3)  # both are exact for uniform pressure, which this nearly is
    if side == "on":
        same(done, default)


@pytest.mark.key("contact.height")
def test_height(simulate: Runner) -> None:
    """A higher surface is nearer: as if the other square were lower by as much, which moves with the velocity of the lower one."""
    higher = simulate(SQUARES, contact__height=0.03, **FALL)
    near(higher.start["gap"], np.full(8, GAP - 0.03), 1e-9)
    lower = simulate(SQUARES, initial__displacement=["0", "y < 1.02 ? 0.03 : 0"], **FALL)
    assert higher.steps["active"].max() > 0
    near(higher.steps["kinetic_energy"], lower.steps["kinetic_energy"], 1e-9)


@pytest.mark.key("unknown.of", "contact.height")
def test_fitted_height(simulate: Runner, tmp_path: Path) -> None:
    """From the motion of the upper square, with the height and friction that made it."""
    more = {"contact__friction": 0.3, "output": {"every": 1, "probe": [{"name": "p", "on": "upper"}]}}
    made = simulate(SQUARES, contact__height=0.02, **more)
    plain = SQUARES.read_text()
    scene = tmp_path / "fit.toml"
    scene.write_text(plain[: plain.index("[control]")].replace("two-squares.geo", str(DATA / "two-squares.geo")))
    measurement = [{"of": "displacement", "on": "upper", "component": c, "file": str(made.folder / "probes.csv"), "column": f"p.displacement_{c}",
                    "deviation": 1e-3} for c in "xy"]  # fmt: skip
    done = optimize_in(tmp_path, scene, 50, unknown=[{"of": "height", "start": 0.0}, {"of": "friction", "start": 0.2}],
                       measurement=measurement, optimizer__method="gauss-newton", **more)  # fmt: skip
    found = table(done.folder / "parameters.csv")
    assert list(found["unit"]) == ["m", ""]
    assert found["value"] == pytest.approx([0.02, 0.3], rel=1e-6)
    assert done.echo["contact"]["height"] == 0, "the scene as given"
