# SPDX-License-Identifier: GPL-3.0-or-later
"""Forces by obstacle, probes, the summary of contact, and what is stored: in tables, in run.json and in words, on one rank and two."""

import functools
import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_BALL, HALF_DISC, SIGNORINI, SOURCE, captured, signorini, stored, table
from soft_scenes import ONTO_A_SLOPE, soft

DATA = SOURCE / "tests" / "data"
BLOCK, CUBE = DATA / "block.toml", DATA / "cube.toml"
SCHEMES = {"contact-implicit": {}, "contact-stabilized": {"time__scheme": "contact-stabilized"}, "massless": {"contact__mass": "massless"}}


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def near(found: object, expected: object, **tolerance: float) -> None:
    assert found == pytest.approx(expected, **{"rel": 0, "abs": 0} | tolerance)


# --- Two obstacles: floor and ceiling close upon the block by 0.02 m --------------------------------------------------

PRESSED = 50 / (1 - 0.3**2) * 0.02  # N/m, equal and opposite
CLOSED = 100  # steps of 0.02 s


def jaws(**more: object) -> list[dict]:
    """The floor, which has a name, and the ceiling."""
    lower = {"name": "lower jaw", "shape": "half-space", "point": [0, "min(0.2*t - 0.05, 0.01)"], "normal": [0, 1]}
    upper = {"shape": "half-space", "point": [0, "max(1.05 - 0.2*t, 0.99)"], "normal": [0, -1]}
    return [{"on": "bottom", "obstacle": lower} | more, {"on": "top", "obstacle": upper} | more]


GRIPS = {
    "1 rank": (1, {}, {}),
    "2 ranks": (2, {}, {}),
    "contact-stabilized, 2 ranks": (2, {}, SCHEMES["contact-stabilized"]),
    "massless": (1, {"mass": "massless"}, {}),
}
Grip = tuple[Path, str, dict[str, np.ndarray]]


@pytest.fixture(scope="module")
def grip(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Grip]:
    """Runs a case; returns its folder, what is printed and obstacles.csv, steps × obstacles."""

    @functools.cache
    def made(case: str) -> Grip:
        (ranks, mass, scheme), out = GRIPS[case], tmp_path_factory.mktemp("gripper") / "out"
        done = signorini("simulate", BLOCK, out, ranks, contact=jaws(**mass), load__body=["0", "0"], initial__velocity=["0", "0"],
                         time__end=2, material__viscosity={"bulk": 5, "shear": 5}, output__fields=[], **scheme)  # fmt: skip
        rows = table(out / "obstacles.csv")
        assert list(rows["obstacle"]) == ["lower jaw", "obstacle 2"] * (CLOSED + 1)
        return out, done.stdout, {name: column.reshape(-1, 2) for name, column in rows.items() if name != "obstacle"}

    return made


@pytest.mark.parametrize("case", GRIPS)
def test_gripper(grip: Callable[[str], Grip], case: str) -> None:
    out, printed, each = grip(case)
    assert (out / "obstacles.csv").read_text().startswith("step,time,obstacle,force_x,force_y,normal_force,active,min_gap\n")
    steps, impact = table(out / "steps.csv"), manifest(out)["impact"]
    assert (each["step"] == np.arange(CLOSED + 1)[:, None]).all()
    for axis in "xy":
        near(each[f"force_{axis}"].sum(axis=1), steps[f"contact_force_{axis}"], abs=1e-13 * PRESSED)
    near(each["normal_force"].sum(axis=1), steps["normal_force"], rel=1e-14)
    assert (each["active"].sum(axis=1) == steps["active"]).all() and (each["min_gap"].min(axis=1) == steps["min_gap"]).all()
    last = each["force_y"][-2:].mean(axis=0)  # of contact-implicit steps single ones alternate
    assert abs(last / PRESSED - [1, -1]).max() < 0.01 and abs(last.sum()) < 1e-4 * PRESSED
    assert abs(steps["contact_force_y"][-2:].mean()) < 1e-4 * PRESSED < steps["normal_force"][-2:].mean()
    lower, upper = impact["obstacles"]
    near(lower["normal_impulse"], 0.02 * each["normal_force"][:, 0].sum(), rel=1e-12)
    near(impact["all"]["normal_impulse"], lower["normal_impulse"] + upper["normal_impulse"], rel=1e-12)
    assert abs(impact["all"]["impulse"][1]) < 1e-2 * impact["all"]["normal_impulse"] and impact["restitution"] is None
    assert 0.24 <= lower["start"] <= 0.26 and not impact["ended"]
    near(lower["end"], 2, rel=1e-12)
    assert all(f"\n  {name}: from " in printed for name in ("lower jaw", "obstacle 2", "all together")) and "if magnitudes at nodes are added" in printed


def test_gripper_on_two_ranks(grip: Callable[[str], Grip]) -> None:
    one, two = (grip(case)[2] for case in ("1 rank", "2 ranks"))
    for name, values in one.items():
        assert np.abs(two[name] - values).max() <= 1e-8 * np.maximum(1, np.abs(values).max()), name


# --- One obstacle -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("scene, axis, ranks", ((BLOCK, 1, 1), (BLOCK, 1, 2), (CUBE, 2, 2)), ids=("block", "block, ranks", "cube, ranks"))
def test_impact(scene: Path, axis: int, ranks: int, scheme: str, tmp_path: Path) -> None:
    """Impulse, momentum and restitution of a body that flies onto an obstacle and off belong together."""
    done = signorini("simulate", scene, tmp_path, ranks, **SCHEMES[scheme], contact__obstacle__normal=[0, 0, 1][2 - axis :], time__end=0.8,
                     output__probe=[{"name": "body", "body": True}], output__fields=[])  # fmt: skip
    found, steps, body, name = manifest(tmp_path)["impact"], table(tmp_path / "steps.csv"), table(tmp_path / "probes.csv"), "xyz"[axis]
    whole, force, momentum = found["all"], steps[f"contact_force_{name}"], body[f"body.momentum_{name}"]
    assert found["ended"] and whole["impulse"] == found["obstacles"][0]["impulse"]
    impulse = 0.02 * force.sum()
    assert impulse > 1
    near(whole["impulse"][axis], impulse, rel=1e-12)
    assert abs(momentum[-1] - momentum[0] + 0.8 - impulse) < 1e-6 * impulse  # a weight of 1 N for 0.8 s
    touching = np.flatnonzero(force)
    before, after = momentum[touching[0] - 1], momentum[touching[-1]]
    near([found["velocity_before"][axis], found["velocity_after"][axis]], [before, after], rel=1e-12)
    assert 0 < found["restitution"] < 1.1
    near(found["restitution"], -after / before, rel=1e-9)
    weight = 0.02 * (touching[-1] - touching[0] + 1)
    near(found["restitution"], (impulse - weight + before) / -before, rel=1e-6)
    near(whole["start"], 0.02 * (touching[0] - 1), rel=1e-12)
    near(whole["end"], 0.02 * touching[-1], rel=1e-12)
    near(whole["contact_time"], 0.02 * len(touching), rel=1e-12)
    near(whole["peak"], (force[1:] + force[:-1]).max() / 2, rel=1e-12)
    near(whole["largest_step"], force.max(), rel=1e-14)
    energy = manifest(tmp_path)["energy"]
    near(energy["load_work"], steps["load_work"].sum(), rel=1e-12)
    assert energy["control_and_clamp_work"] == 0
    if scheme != "massless":  # else the mass that moves is not where the load acts
        near(energy["load_work"], -(body[f"body.center_{name}"][-1] - 0.5), abs=1e-12)  # potential energy
    assert f"restitution {found['restitution']:.4g}" in done.stdout and "touch times and peaks of two-step means need not" in done.stdout


def test_no_impact(tmp_path: Path) -> None:
    signorini("simulate", BLOCK, tmp_path, contact__obstacle__point=[0, -100], time__end=0.1)
    none = manifest(tmp_path)["impact"]
    assert none["all"]["start"] is None is none["velocity_before"] and none["all"]["contact_time"] == 0


def test_no_summary_without_invariants(tmp_path: Path) -> None:
    signorini("simulate", BLOCK, tmp_path, run__invariants="off", output__tables=["contact"])
    assert not {"impact", "energy"} & set(manifest(tmp_path))


def test_no_restitution_of_a_body_that_lands(tmp_path: Path) -> None:
    """It has left the plane for some steps and still comes nearer."""
    normal = [0.2, 1]
    signorini("simulate", BLOCK, tmp_path, contact__obstacle__normal=normal, output__fields=[], output__tables=["steps"], time__end=2)
    found = manifest(tmp_path)["impact"]
    assert np.dot(found["velocity_before"], normal) < 0 and np.dot(found["velocity_after"], normal) < 0 and found["ended"]
    assert found["all"]["end"] < 2 and found["restitution"] is None


# --- Probes -----------------------------------------------------------------------------------------------------------

PROBES = [{"name": "corner", "point": [0, 1]}, {"on": "left"}, {"name": "floor", "obstacle": "obstacle 1"}, {"name": "body", "body": True}]


def probed(out: Path, degree: int, ranks: int) -> dict[str, np.ndarray]:
    clamp = [{"on": "left", "components": ["x"]}]
    signorini("simulate", BLOCK, out, ranks, mesh__degree=degree, output__probe=PROBES, clamp=clamp)
    return table(out / "probes.csv")


@pytest.mark.parametrize("degree", (1, 2))
def test_probes(degree: int, tmp_path: Path) -> None:
    """They are as in the stored fields and in steps.csv, and on two ranks the same."""
    found = {ranks: probed(tmp_path / str(ranks), degree, ranks) for ranks in (1, 2)}
    for ranks, probes in found.items():
        points, _, displacement = stored(tmp_path / str(ranks), "state", "displacement")
        steps = table(tmp_path / str(ranks) / "steps.csv")
        corner = np.flatnonzero(abs(points[:, :2] - [0, 1]).max(axis=1) < 1e-12)[0]
        for c, axis in enumerate("xy"):
            near(probes[f"corner.displacement_{axis}"], displacement[:, corner, c], abs=1e-13)
            near(probes[f"floor.impulse_{axis}"], 0.02 * steps[f"contact_force_{axis}"].cumsum(), abs=1e-12)
        assert abs(probes["probe 2.reaction_x"]).max() > 0.1 and not probes["probe 2.reaction_y"].any() and steps["active"].any()
        rate = np.diff(probes["body.momentum_x"]) / 0.02
        near(rate, (probes["probe 2.reaction_x"] + steps["contact_force_x"])[1:], abs=1e-10)
    for name, values in found[1].items():
        near(found[2][name], values, abs=1e-8)


def test_probes_of_a_resumed_search(tmp_path: Path) -> None:
    whole, parted, small = tmp_path / "whole", tmp_path / "parted", {"output__fields": [], "output__probe": PROBES}
    signorini("optimize", BLOCK, whole, optimizer__max_iterations=2, **small)
    signorini("optimize", BLOCK, parted, optimizer__max_iterations=1, **small)
    command = [str(SIGNORINI), "optimize", str(parted / "scene.toml"), "--resume", "--out", str(parted)]
    done = captured([*command, "--set", "optimizer.max_iterations=2"])
    assert done.returncode == 0, done.stderr
    for name in ("probes.csv", "obstacles.csv", "steps.csv"):
        assert (whole / name).read_text() == (parted / name).read_text(), name
    steps, body = table(whole / "steps.csv"), table(whole / "probes.csv")
    near(steps["load_work"][1:], -np.diff(body["body.center_y"]), abs=1e-13)
    assert abs(steps["external_work"] - steps["load_work"]).max() > 1e-3, "no control"


# --- Few nodes in contact: the mesh size that is suggested lets five touch, without a warning ---------------------------


def few_nodes(out: Path) -> list[dict]:
    return [warning for warning in manifest(out)["warnings"] if warning["name"] == "few nodes in contact"]


def most_active(out: Path) -> int:
    return int(table(out / "steps.csv")["active"].max())


ROUND = {
    "ball": (HALF_BALL, 4, {"time__step": 2.5e-4, "control__initial": ["0", "0", "-1"]}),
    "disc": (HALF_DISC, 5, {"control__initial": ["0", "-1"]}),
}


@pytest.mark.parametrize("shape", ROUND)
def test_few_nodes_of_a_round_body(shape: str, tmp_path: Path) -> None:
    """It touches with one node."""
    scene, size, keys = ROUND[shape]

    def run(size: float, ranks: int = 1) -> tuple[int, list[dict]]:
        signorini("simulate", scene, tmp_path, ranks, mesh__size=size, output__fields=[], output__tables=["steps"], **keys)
        return most_active(tmp_path), few_nodes(tmp_path)

    nodes, (warning,) = run(size)
    assert nodes == 1 and 'one node touches "obstacle 1"' in warning["message"] and warning["value"] > warning["limit"] > 0
    suggested = float(re.search(r"\(mesh.size = (\S+)\)", warning["message"])[1])
    if shape == "ball":
        assert run(size, ranks=2)[1][0]["message"] == warning["message"]
    nodes, warnings = run(suggested)
    assert 5 <= nodes < 20 and not warnings, suggested


def test_few_nodes_of_a_corner(tmp_path: Path) -> None:
    signorini("simulate", CUBE, tmp_path, contact__on="boundary", time__end=0.16, contact__obstacle__normal=[0.5, 0.4, 1],
              contact__obstacle__point=[0, 0, -0.02], output__fields=[])  # fmt: skip
    assert most_active(tmp_path) in (1, 2) and len(few_nodes(tmp_path)) == 1


def test_few_nodes_of_a_tilted_face(tmp_path: Path) -> None:
    """The last nodes of a face whose nodes are 0.25 m apart."""
    (tmp_path / "tilted.toml").write_text(soft("square.geo", 0.25, 0.14, 0.01) + ONTO_A_SLOPE)
    signorini("simulate", tmp_path / "tilted.toml", tmp_path / "out", output__fields=[])
    (warning,) = few_nodes(tmp_path / "out")
    near(warning["value"], 0.25, abs=1e-6)
    assert warning["limit"] == 0 and "an end of the contact group" in warning["message"]


def test_two_nodes_of_a_flat_face_are_all(tmp_path: Path) -> None:
    flat = {"contact__obstacle__normal": [0, 1], "output__fields": [], "output__tables": ["steps"]}
    signorini("simulate", BLOCK, tmp_path, mesh__size=2, **flat)
    assert most_active(tmp_path) == 2 and not few_nodes(tmp_path)


# --- The console ------------------------------------------------------------------------------------------------------


def test_stored_steps(tmp_path: Path) -> None:
    done = signorini("simulate", BLOCK, tmp_path, time__step=1e-3)
    assert len(stored(tmp_path, "state", "displacement")[2]) == 301
    assert len(table(tmp_path / "steps.csv")["step"]) == len(table(tmp_path / "obstacles.csv")["step"]) == 601
    line = re.search(r"600 steps in \S+ s, their balances in \S+ s, output in \S+ s: (\S+) MB, fields and contact of one step in 2"
                     r"(?: and of the step with the largest force)? \(output.every = 2\)", done.stdout)  # fmt: skip
    near(float(line[1]), sum(path.stat().st_size for path in tmp_path.iterdir()) / 1e6, rel=0.01)


def test_every_step_is_stored(tmp_path: Path) -> None:
    done = signorini("simulate", BLOCK, tmp_path, time__step=1e-3, output__every=1)
    assert len(stored(tmp_path, "state", "displacement")[2]) == 601 and "contact of every step (output.every = 1)" in done.stdout


def test_no_step_is_stored(tmp_path: Path) -> None:
    done = signorini("simulate", BLOCK, tmp_path, time__step=1e-3, output__fields=[], output__tables=["steps"])
    assert "output.every" not in done.stdout and "600 steps" in done.stdout


CHATTERS = {"contact__obstacle__normal": [0, 1], "time__step": 0.005, "optimizer__method": "projected-gradient"}
ADVICE = 'try time.scheme = "contact-stabilized"'


def test_advice_of_check_among_chattering_contact() -> None:
    """There is none with the other scheme."""
    schemes, shorter = ("contact-implicit", "contact-stabilized"), {**CHATTERS, "time__step": 0.0025, "check__control": ["0.5", "0.5"]}
    chatters, calm = (signorini("check", BLOCK, **shorter, time__scheme=scheme).stdout for scheme in schemes)
    assert re.search(rf"mean slope that differs by \d+ % of the largest slope among them; {ADVICE}\.\n", chatters)
    assert re.search(rf"All checks hold, contact included\.\nBut .*: {ADVICE}\.\n$", chatters)
    assert "try " not in calm and calm.endswith("All checks hold, contact included.\n")


def test_no_advice_where_a_slope_almost_vanishes() -> None:
    """Along d the slope is a thousandth of its growth over larger changes, so that a change of contact by a few per cent of it has any
    ratio to the slope itself. A search works there."""
    said = signorini("check", SOURCE / "scenes" / "block.toml", material__young=8000).stdout
    slope, secant = map(float, re.search(r"derivative along d is (\S+); over .* mean slope (\S+)\.\n", said).groups())
    assert abs(secant - slope) > abs(slope), "the slope does not vanish: the case says nothing"
    assert "holds for larger changes of the control too" in said and "try " not in said


def test_rounding_of_gradients_is_measured() -> None:
    """Differences of gradients show four times as much as their size foretells, and the check of Hessian products holds."""
    said = signorini("check", SOURCE / "scenes" / "block.toml", material__young=8000, check__control=["0", "-1.5"]).stdout
    assert re.search(r"^ok +Hessian product against differences of gradients", said, re.MULTILINE) and said.endswith("All checks hold, contact included.\n")


@pytest.mark.parametrize("scheme", ("contact-implicit", "contact-stabilized"))
def test_advice_of_optimize_among_chattering_contact(scheme: str, tmp_path: Path) -> None:
    done = signorini("optimize", BLOCK, tmp_path, **CHATTERS, time__scheme=scheme, optimizer__max_iterations=300, output__fields=[])
    found = [warning["message"] for warning in manifest(tmp_path)["warnings"] if warning["name"] == "search among chattering contact"]
    if scheme == "contact-implicit":
        assert "no further decrease" in done.stdout and len(found) == 1 and found[0].endswith(ADVICE)
        assert f"warning: {found[0]}" in done.stdout
    else:
        assert not found
