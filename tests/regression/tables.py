# SPDX-License-Identifier: GPL-3.0-or-later
"""Forces by obstacle, probes, the summary of contact, and what is stored: in tables, in run.json and in words, on one rank and two."""

import json
import re
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_BALL, SIGNORINI, SOURCE, attempt, captured, signorini, stored, table  # noqa: E402
from soft_scenes import ONTO_A_SLOPE, soft  # noqa: E402

import numpy as np  # noqa: E402

DATA = SOURCE / "tests" / "data"
BLOCK, CUBE = DATA / "block.toml", DATA / "cube.toml"
SCHEMES = ({}, {"time__scheme": "contact-stabilized"}, {"contact__mass": "massless"})


def told(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def jaw(group: str, point: list, normal: list, name: str | None = None) -> dict:
    obstacle = {"shape": "half-space", "point": point, "normal": normal} | ({"name": name} if name else {})
    return {"on": group, "obstacle": obstacle}


def gripper(folder: Path) -> None:
    """Floor and ceiling close upon the block by 0.02 m: equal and opposite forces, E/(1 - nu^2) 0.02 N/m each."""
    jaws = [jaw("bottom", [0, "min(0.2*t - 0.05, 0.01)"], [0, 1], "lower jaw"), jaw("top", [0, "max(1.05 - 0.2*t, 0.99)"], [0, -1])]
    steps, pressed = 100, 50 / (1 - 0.3**2) * 0.02
    runs = []
    for scheme, ranks in ((SCHEMES[0], 1), (SCHEMES[0], 2), (SCHEMES[1], 2), ({"mass": "massless"}, 1)):
        out = folder / "gripper"
        contact = [one | ({"mass": "massless"} if "mass" in scheme else {}) for one in jaws]
        done = signorini("simulate", BLOCK, out, ranks, contact=contact, load__body=["0", "0"], initial__velocity=["0", "0"], time__end=2,
                         material__viscosity={"bulk": 5, "shear": 5}, output__fields=[], **scheme if "mass" not in scheme else {})  # fmt: skip
        assert (out / "obstacles.csv").read_text().startswith("step,time,obstacle,force_x,force_y,normal_force,active,min_gap\n")
        rows, all_steps, impact = table(out / "obstacles.csv"), table(out / "steps.csv"), told(out)["impact"]
        assert list(rows["obstacle"]) == ["lower jaw", "obstacle 2"] * (steps + 1) and (rows["step"] == np.repeat(np.arange(steps + 1), 2)).all()
        each = {name: column.reshape(-1, 2) for name, column in rows.items() if name != "obstacle"}
        for axis in "xy":
            assert np.allclose(each[f"force_{axis}"].sum(axis=1), all_steps[f"contact_force_{axis}"], rtol=0, atol=1e-13 * pressed)
        assert np.allclose(each["normal_force"].sum(axis=1), all_steps["normal_force"], rtol=1e-14, atol=0)
        assert (each["active"].sum(axis=1) == all_steps["active"]).all() and (each["min_gap"].min(axis=1) == all_steps["min_gap"]).all()
        last = each["force_y"][-2:].mean(axis=0)  # of contact-implicit steps single ones alternate
        assert abs(last / pressed - [1, -1]).max() < 0.01 and abs(last.sum()) < 1e-4 * pressed, last
        assert abs(all_steps["contact_force_y"][-2:].mean()) < 1e-4 * pressed < all_steps["normal_force"][-2:].mean()
        lower, upper = impact["obstacles"]
        assert np.isclose(lower["normal_impulse"], 0.02 * each["normal_force"][:, 0].sum(), rtol=1e-12, atol=0)
        assert np.isclose(impact["all"]["normal_impulse"], lower["normal_impulse"] + upper["normal_impulse"], rtol=1e-12, atol=0)
        assert abs(impact["all"]["impulse"][1]) < 1e-2 * impact["all"]["normal_impulse"] and impact["restitution"] is None
        assert 0.24 <= lower["start"] <= 0.26 and np.isclose(lower["end"], 2, rtol=1e-12, atol=0) and not impact["ended"]
        assert all(f"\n  {name}: from " in done.stdout for name in ("lower jaw", "obstacle 2", "all together")) and "by modulus" in done.stdout
        runs.append(each)
    for name in runs[0]:
        assert np.allclose(runs[0][name], runs[1][name], rtol=0, atol=1e-8 * np.maximum(1, abs(runs[0][name]).max())), f"two ranks: {name}"
    print(f"gripper: {last[0]:.4f} and {last[1]:.4f} N/m of {pressed:.4f}, {lower['normal_impulse'] + upper['normal_impulse']:.4f} N s/m by modulus")


def impact(folder: Path) -> None:
    """A body that flies onto an obstacle and off: impulse, momentum and restitution belong together, with every scheme."""
    for scene, axis, ranks in ((BLOCK, 1, 1), (BLOCK, 1, 2), (CUBE, 2, 2)):
        up = [0, 0, 1][2 - axis :]
        for scheme in SCHEMES:
            out = folder / "impact"
            done = signorini("simulate", scene, out, ranks, **scheme, contact__obstacle__normal=up, output__probe=[{"name": "body", "body": True}],
                             output__fields=[], time__end=0.8)  # fmt: skip
            found, steps, body = told(out)["impact"], table(out / "steps.csv"), table(out / "probes.csv")
            assert found["ended"] and found["all"]["impulse"] == found["obstacles"][0]["impulse"]
            name = "xyz"[axis]
            force, momentum = steps[f"contact_force_{name}"], body[f"body.momentum_{name}"]
            impulse = 0.02 * force.sum()
            assert impulse > 1 and np.isclose(found["all"]["impulse"][axis], impulse, rtol=1e-12, atol=0)
            # A weight of 1 N for 0.8 s.
            assert abs(momentum[-1] - momentum[0] + 0.8 - impulse) < 1e-6 * impulse
            pushed = np.flatnonzero(force)
            before, after = momentum[pushed[0] - 1], momentum[pushed[-1]]
            assert np.allclose([found["velocity_before"][axis], found["velocity_after"][axis]], [before, after], rtol=1e-12, atol=0)
            assert np.isclose(found["restitution"], -after / before, rtol=1e-9, atol=0) and 0 < found["restitution"] < 1.1
            weight = 0.02 * (pushed[-1] - pushed[0] + 1)
            assert np.isclose(found["restitution"], (impulse - weight + before) / -before, rtol=1e-6, atol=0)
            assert np.isclose(found["all"]["start"], 0.02 * (pushed[0] - 1), rtol=1e-12, atol=0)
            assert np.isclose(found["all"]["end"], 0.02 * pushed[-1], rtol=1e-12, atol=0)
            assert np.isclose(found["all"]["contact_time"], 0.02 * len(pushed), rtol=1e-12, atol=0)
            assert np.isclose(found["all"]["peak"], (force[1:] + force[:-1]).max() / 2, rtol=1e-12, atol=0)
            assert np.isclose(found["all"]["largest_step"], force.max(), rtol=1e-14, atol=0)
            energy = told(out)["energy"]
            assert np.isclose(energy["load_work"], steps["load_work"].sum(), rtol=1e-12, atol=0) and energy["control_and_clamp_work"] == 0
            if "contact__mass" not in scheme:  # else the mass that moves is not where the load acts
                assert np.isclose(energy["load_work"], -(body[f"body.center_{name}"][-1] - 0.5), rtol=0, atol=1e-12)  # potential energy
            assert f"restitution {found['restitution']:.4g}" in done.stdout and "touch times and two-step peaks need not" in done.stdout
            print(f"{scene.stem}, {ranks} ranks, {scheme or 'contact-implicit'}: restitution {found['restitution']:.4f}")
    signorini("simulate", BLOCK, folder / "none", contact__obstacle__point=[0, -100], time__end=0.1)
    none = told(folder / "none")["impact"]
    assert none["all"]["start"] is None is none["velocity_before"] and none["all"]["contact_time"] == 0
    signorini("simulate", BLOCK, folder / "off", run__invariants="off", output__tables=["contact"])
    assert "impact" not in told(folder / "off") and "energy" not in told(folder / "off")


def probes(folder: Path) -> None:
    """On two ranks, of both degrees, from optimize and where it goes on."""
    asked = [{"name": "corner", "point": [0, 1]}, {"on": "left"}, {"name": "floor", "obstacle": "obstacle 1"}, {"name": "body", "body": True}]
    clamp = {"clamp": [{"on": "left", "components": ["x"]}]}
    for degree in (1, 2):
        for ranks in (1, 2):
            out = folder / f"probes-{degree}-{ranks}"
            signorini("simulate", BLOCK, out, ranks, mesh__degree=degree, output__probe=asked, **clamp)
            points, _, displacement = stored(out, "state", "displacement")
            found, steps = table(out / "probes.csv"), table(out / "steps.csv")
            corner = np.flatnonzero(abs(points[:, :2] - [0, 1]).max(axis=1) < 1e-12)[0]
            for c, axis in enumerate("xy"):
                assert np.allclose(found[f"corner.displacement_{axis}"], displacement[:, corner, c], rtol=0, atol=1e-13)
                assert np.allclose(found[f"floor.impulse_{axis}"], 0.02 * steps[f"contact_force_{axis}"].cumsum(), rtol=0, atol=1e-12)
            assert abs(found["probe 2.reaction_x"]).max() > 0.1 and not found["probe 2.reaction_y"].any() and steps["active"].any()
            rate = np.diff(found["body.momentum_x"]) / 0.02
            assert np.allclose(rate, (found["probe 2.reaction_x"] + steps["contact_force_x"])[1:], rtol=0, atol=1e-10)
        one, two = (table(folder / f"probes-{degree}-{ranks}" / "probes.csv") for ranks in (1, 2))
        assert all(np.allclose(one[name], two[name], rtol=0, atol=1e-8) for name in one)
    whole, parted = folder / "whole", folder / "parted"
    small = {"output__fields": [], "output__probe": asked}
    signorini("optimize", BLOCK, whole, optimizer__max_iterations=2, **small)
    signorini("optimize", BLOCK, parted, optimizer__max_iterations=1, **small)
    done = captured([str(SIGNORINI), "optimize", str(parted / "scene.toml"), "--resume", "--out", str(parted), "--set", "optimizer.max_iterations=2"])
    assert done.returncode == 0, done.stderr
    for name in ("probes.csv", "obstacles.csv", "steps.csv"):
        assert (whole / name).read_text() == (parted / name).read_text(), name
    steps, body = table(whole / "steps.csv"), table(whole / "probes.csv")
    assert np.allclose(steps["load_work"][1:], -np.diff(body["body.center_y"]), rtol=0, atol=1e-13)
    assert abs(steps["external_work"] - steps["load_work"]).max() > 1e-3, "no control"
    print("probes: as in the stored fields, on two ranks, of both degrees, and where a search goes on")


def half_landed(folder: Path) -> None:
    """A body that has let go of the plane for some steps and still comes nearer has no restitution yet."""
    out = folder / "landing"
    signorini("simulate", BLOCK, out, contact__obstacle__normal=[0.2, 1], output__fields=[], output__tables=["steps"], time__end=2)
    found = told(out)["impact"]
    n = np.array([0.2, 1])
    assert np.dot(found["velocity_before"], n) < 0 and np.dot(found["velocity_after"], n) < 0 and found["ended"], found
    assert found["all"]["end"] < 2 and found["restitution"] is None, found
    print("no restitution of a body that lands")


def few_nodes(folder: Path) -> None:
    """A ball in space that touches with one node: the size that is told lets five touch, and then nothing is told."""
    out = folder / "few"
    scene = {"time__step": 2.5e-4, "control__initial": ["0", "0", "-1"], "output__fields": [], "output__tables": ["steps"]}

    def most(ranks: int = 1, **more: object) -> tuple[int, dict | None]:
        signorini("simulate", HALF_BALL, out, ranks, **scene, **more)
        said = [warning for warning in told(out)["warnings"] if warning["name"] == "few nodes in contact"]
        assert len(said) < 2
        return int(table(out / "steps.csv")["active"].max()), said[0] if said else None

    nodes, said = most(mesh__size=4)
    size = float(re.search(r"\(mesh.size = (\S+)\)", said["message"])[1])
    assert nodes == 1 and "one node touches \"obstacle 1\"" in said["message"] and said["value"] > said["limit"] > 0
    assert said["message"] == most(2, mesh__size=4)[1]["message"]
    fine, nothing = most(mesh__size=size)
    assert 5 <= fine < 20 and nothing is None, (fine, size, nothing)
    signorini("simulate", CUBE, out, contact__on="boundary", time__end=0.16, contact__obstacle__normal=[0.5, 0.4, 1],
              contact__obstacle__point=[0, 0, -0.02], output__fields=[])  # fmt: skip
    corner = [warning["message"] for warning in told(out)["warnings"] if warning["name"] == "few nodes in contact"]
    assert table(out / "steps.csv")["active"].max() in (1, 2) and len(corner) == 1, corner
    print(f"size 4: {said['message']}; size {size}: {fine} touch")


def few_nodes_in_the_plane(folder: Path) -> None:
    """The half disc likewise; the block, whose face is flat, touches with all of its nodes, be they two."""
    out = folder / "few"

    def run(size: float) -> tuple[int, list[str]]:
        signorini("simulate", SOURCE / "scenes" / "half-disc.toml", out, mesh__size=size, control__initial=["0", "-1"], output__fields=[],
                  output__tables=["steps"])  # fmt: skip
        return int(table(out / "steps.csv")["active"].max()), [one["message"] for one in told(out)["warnings"] if one["name"] == "few nodes in contact"]

    nodes, said = run(5)
    assert nodes == 1 and len(said) == 1 and "one node touches \"obstacle 1\"" in said[0], (nodes, said)
    size = float(re.search(r"\(mesh.size = (\S+)\)", said[0])[1])
    nodes, nothing = run(size)
    assert 5 <= nodes < 20 and not nothing, (size, nodes, nothing)
    tilted = folder / "tilted.toml"
    tilted.write_text(soft("square.geo", 0.25, 0.14, 0.01) + ONTO_A_SLOPE)
    signorini("simulate", tilted, out, output__fields=[])
    found = [one["value"] for one in told(out)["warnings"] if one["name"] == "few nodes in contact"]
    assert len(found) == 1 and abs(found[0] - 0.25) < 1e-6, f"the last nodes of a face whose nodes are 0.25 m apart: {found}"
    flat = {"contact__obstacle__normal": [0, 1], "output__fields": [], "output__tables": ["steps"]}
    signorini("simulate", BLOCK, out, mesh__size=2, **flat)
    found = [one["name"] for one in told(out)["warnings"]]
    assert table(out / "steps.csv")["active"].max() == 2 and "few nodes in contact" not in found, found
    print(f"in the plane: size 5: {said[0]}; size {size}: {nodes} touch")


def stored_steps(folder: Path) -> None:
    out = folder / "stored"
    done = signorini("simulate", BLOCK, out, time__step=1e-3)
    times = stored(out, "state", "displacement")[2]
    assert len(times) == 301 and len(table(out / "steps.csv")["step"]) == len(table(out / "obstacles.csv")["step"]) == 601
    line = re.search(r"600 steps in \S+ s, their balances in \S+ s, output in \S+ s: (\S+) MB, fields and contact of one step in 2(?: and of that with the largest force)? \(output.every = 2\)", done.stdout)
    files = sum(path.stat().st_size for path in out.iterdir())
    assert line and abs(float(line[1]) - files / 1e6) < 0.01 * files / 1e6, (done.stdout, files)
    done = signorini("simulate", BLOCK, out, time__step=1e-3, output__every=1)
    assert len(stored(out, "state", "displacement")[2]) == 601 and "contact of every step (output.every = 1)" in done.stdout
    done = signorini("simulate", BLOCK, out, time__step=1e-3, output__fields=[], output__tables=["steps"])
    assert "output.every" not in done.stdout and "600 steps" in done.stdout
    print(f"600 steps: 301 stored, {line[1]} MB as told")


def advice(folder: Path) -> None:
    """Where contact chatters, `check` and `optimize` say what to change, and with that there is nothing to say."""
    flat = {"contact__obstacle__normal": [0, 1], "time__step": 0.005, "optimizer__method": "projected-gradient"}
    other = "try time.scheme = \"contact-stabilized\""
    chatters, calm = (signorini("check", BLOCK, **flat, time__scheme=scheme).stdout for scheme in ("contact-implicit", "contact-stabilized"))
    assert re.search(rf"slope that differs by \d\d %; {other}\.\n", chatters), chatters
    assert re.search(rf"All checks hold, contact included\.\nBut .*: {other}\.\n$", chatters), chatters
    assert "try " not in calm and calm.endswith("All checks hold, contact included.\n"), calm
    ends = {}
    for scheme in ("contact-implicit", "contact-stabilized"):
        out = folder / "advice"
        done = signorini("optimize", BLOCK, out, **flat, time__scheme=scheme, optimizer__max_iterations=300, output__fields=[])
        ends[scheme] = table(out / "history.csv")["gradient_norm"][-1]
        said = [warning["message"] for warning in told(out)["warnings"] if warning["name"] == "search among chattering contact"]
        if scheme == "contact-implicit":
            assert "no further decrease" in done.stdout and len(said) == 1 and said[0].endswith(other), done.stdout
            assert f"warning: {said[0]}" in done.stdout
        else:
            assert not said, said
    print(f"check and optimize among chattering contact: {other}; |g| {ends['contact-implicit']:.1e} and then {ends['contact-stabilized']:.1e}")


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        for part in (gripper, impact, probes, half_landed, few_nodes, few_nodes_in_the_plane, stored_steps, advice):
            part(Path(name))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
