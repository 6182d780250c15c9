# SPDX-License-Identifier: GPL-3.0-or-later
"""J of a simulation, and a control that an earlier run left: applied again, or a first guess, on other ranks and with other steps."""

import functools
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import h5py
import pytest
from harness import SOURCE, attempt, signorini, table

BLOCK, CUBE = SOURCE / "tests" / "data" / "block.toml", SOURCE / "tests" / "data" / "cube.toml"
ROUNDING, RANKS = 1e-12, 1e-8  # on other ranks sums are in another order, and contact multiplies that
IN_SPACE = {"control": {"scale": 1}, "objective": {"desired": {"displacement": ["0", "0.1*t", "-0.1"]}, "alpha": 1e-2}}
ENERGIES = ("kinetic_energy", "elastic_energy", "external_work")
Optimum = Callable[[str], Path]


def objective(out: Path) -> dict[str, float]:
    return json.loads((out / "run.json").read_text())["objective"]


def same(a: dict[str, float], b: dict[str, float], tolerance: float) -> None:
    assert b["value"] > 0 and a == pytest.approx(b, rel=0, abs=tolerance * b["value"])


def refused(*texts: str, ranks: int = 1, out: Path, **overrides: object) -> None:
    """A simulation of the block is refused, with these texts in the message."""
    done = attempt("simulate", BLOCK, out, ranks, **overrides)
    assert done.returncode == 2 and all(text in done.stderr for text in texts), done.stderr


KINDS = {
    "desired control": {"objective__desired": {"control": ["0.3*t", "x"]}, "control__initial": ["t", "-1"]},
    "no control": {"objective__desired": {"control": ["0.3", "-1"]}},
    "desired displacement, bound": {"objective__desired": {"displacement": ["0.1*t", "y"]}, "control__initial": ["0", "-9"],
                                    "control__lower": -2},
    "groups": {"objective__desired": {"displacement": ["0", "-0.1"]}, "control__on": "top", "objective__on": "bottom",
               "control__initial": ["1", "x"]},
    "desired run": {"objective__desired": {"run": "motion"}, "control__constant_in_time": True, "control__initial": ["x", "0"]},
    "cellwise": {"objective__desired": {"control": ["0.3", "-1"]}, "control__space": "cellwise", "control__initial": ["x", "0"],
                 "mesh__degree": 2, "time__scheme": "contact-stabilized"},
    "massless": {"objective__desired": {"control": ["0.3", "-1"]}, "contact__mass": "massless", "solver__vi": "full"},
}  # fmt: skip


@pytest.mark.parametrize("name", KINDS)
def test_J(name: str, tmp_path: Path) -> None:
    """J of simulate is that of optimize at its first guess, whatever is desired and wherever the control acts."""
    found, expected, settings = tmp_path / "found", tmp_path / "expected", KINDS[name]
    if name == "desired run":
        signorini("simulate", BLOCK, tmp_path / "motion", control__initial=["0.5", "-0.5"])
        settings = settings | {"objective__desired": {"run": str(tmp_path / "motion")}}
    signorini("optimize", BLOCK, expected, optimizer__max_iterations=0, **settings)
    for ranks in (1, 2) if name in ("desired control", "groups") else (1,):
        done = signorini("simulate", BLOCK, found, ranks, **settings)
        same(objective(found), objective(expected), ROUNDING if ranks == 1 else RANKS)
        line = next(line for line in done.stdout.splitlines() if line.startswith("J = "))
        assert float(line.split()[2]) == pytest.approx(objective(found)["value"], rel=1e-6)
    assert (table(found / "steps.csv")["active"] > 0).any(), "no contact"


def test_J_without_the_desired_run(tmp_path: Path) -> None:
    done = signorini("simulate", BLOCK, tmp_path, objective__desired={"run": "nowhere"})
    assert "J could not be evaluated: objective.desired.run: " in done.stdout
    assert "objective" not in json.loads((tmp_path / "run.json").read_text())


REST = {"mesh__degree": 2, "control__on": "rest", "control__components": ["y"], "objective__desired": {"control": ["0", "-1"]}}
# Scene, ranks of the search, settings.
OPTIMA = {
    "some steps": (BLOCK, 1, {"output__every": 7}),  # so that control.h5 has only some of it
    "rest": (BLOCK, 2, REST),
    "cellwise": (BLOCK, 1, {"control__space": "cellwise", "control__upper": 0.1, "time__scheme": "contact-stabilized"}),
    "massless": (BLOCK, 2, {"control__constant_in_time": True, "contact__mass": "massless"}),
    "space": (CUBE, 1, IN_SPACE | {"contact__obstacle": {"shape": "half-space", "point": [0, 0, -0.05], "normal": [0, 0, 1]}}),
}


@pytest.fixture(scope="module")
def optimum(tmp_path_factory: pytest.TempPathFactory) -> Optimum:
    """By its name in OPTIMA, a search of two iterations."""

    @functools.cache
    def of(name: str) -> Path:
        (scene, ranks, settings), out = OPTIMA[name], tmp_path_factory.mktemp("optimum") / "out"
        signorini("optimize", scene, out, ranks, **settings, optimizer={"max_iterations": 2})
        assert (table(out / "steps.csv")["active"] > 0).any() and objective(out)["control_cost"] > 0
        return out

    return of


def replay(earlier: Path, name: str, out: Path, ranks: int) -> None:
    scene, _, settings = OPTIMA[name]
    initial = {"run": str(earlier)}
    more = {"control": {"scale": 1, "initial": initial}} if "control" in settings else {"control__initial": initial}
    signorini("simulate", scene, out, ranks, **settings | more)


@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("name", OPTIMA)
def test_replayed(optimum: Optimum, name: str, ranks: int, tmp_path: Path) -> None:
    """The motion and J of an optimum again, from its folder alone."""
    earlier = optimum(name)
    replay(earlier, name, tmp_path, ranks)
    tolerance = ROUNDING if ranks == OPTIMA[name][1] == 1 else RANKS
    same(objective(tmp_path), objective(earlier), tolerance)
    a, b = table(tmp_path / "steps.csv"), table(earlier / "steps.csv")
    for energy in ENERGIES:
        assert a[energy] == pytest.approx(b[energy], rel=0, abs=tolerance * abs(b[energy]).max()), energy


def test_scene_of_a_replay(optimum: Optimum, tmp_path: Path) -> None:
    again, echo = tmp_path / "again", tmp_path / "echo"
    replay(optimum("space"), "space", again, 2)
    signorini("simulate", again / "scene.toml", echo)
    same(objective(echo), objective(again), RANKS)


@pytest.fixture
def from_rest(optimum: Optimum) -> dict[str, object]:
    """Settings with the control of an earlier search as the first guess."""
    return REST | {"control__initial": {"run": str(optimum("rest"))}}


def test_first_guess(optimum: Optimum, from_rest: dict[str, object], tmp_path: Path) -> None:
    """A search starts where an earlier one ended."""
    signorini("optimize", BLOCK, tmp_path, **from_rest, optimizer__max_iterations=2)
    history = table(tmp_path / "history.csv")["objective"]
    assert abs(history[0] / objective(optimum("rest"))["value"] - 1) < RANKS and history[-1] < history[0]


def test_other_steps(from_rest: dict[str, object], tmp_path: Path) -> None:
    """Each has the value in its middle, so that half as long ones repeat it and J changes with the motion alone."""
    J = {}
    for step in (0.02, 0.01, 0.005):
        signorini("simulate", BLOCK, tmp_path, time__step=step, **from_rest)
        J[step] = objective(tmp_path)
        assert abs(J[step]["control_cost"] / J[0.02]["control_cost"] - 1) < ROUNDING
    assert abs(J[0.005]["value"] - J[0.01]["value"]) < abs(J[0.01]["value"] - J[0.02]["value"]) < 0.2 * J[0.02]["value"]


def test_shorter_run(from_rest: dict[str, object], tmp_path: Path) -> None:
    signorini("simulate", BLOCK, tmp_path, time__end=0.3, **from_rest)


def test_same_folder_is_refused(optimum: Optimum, from_rest: dict[str, object]) -> None:
    refused("control.initial.run", out=optimum("rest"), **from_rest)


@pytest.fixture(scope="module")
def from_fields(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A search without a checkpoint, in a folder in which an earlier search left one."""
    out = tmp_path_factory.mktemp("fields") / "out"
    signorini("optimize", BLOCK, out, optimizer__max_iterations=1)
    old = objective(out)
    signorini("optimize", BLOCK, out, optimizer__max_iterations=4, optimizer__checkpoint=0)
    assert (out / "checkpoint.h5").exists() and objective(out)["value"] < 0.999 * old["value"]
    return out


@pytest.mark.parametrize("ranks", (1, 2))
def test_control_from_fields(from_fields: Path, ranks: int, tmp_path: Path) -> None:
    """Nodal controls are read from control.h5, and the checkpoint of another search is not taken for this one's."""
    signorini("simulate", BLOCK, tmp_path, ranks, control__initial={"run": str(from_fields)})
    same(objective(tmp_path), objective(from_fields), ROUNDING if ranks == 1 else RANKS)
    with h5py.File(from_fields / "control.h5") as file:
        assert len(file["Function/control"]) == 30


OTHERS = ({"mesh__degree": 2}, {"control__space": "cellwise"}, {"mesh__size": 0.5}, {"time__end": 1.2})


@pytest.mark.parametrize("setting", OTHERS, ids=str)
def test_control_from_fields_is_refused(from_fields: Path, setting: dict[str, object], tmp_path: Path) -> None:
    refused("control.initial.run: ", out=tmp_path, control__initial={"run": str(from_fields)}, **setting)


SOME = {"optimizer__max_iterations": 2, "output__every": 7, "optimizer__checkpoint": 0}
BETWEEN = "found no step stored between"
UNKNOWN = {
    "steps": ({}, f"{BETWEEN} 0 and 0.02 s, and checkpoint.h5 belongs to another run"),
    "constant": ({"control__constant_in_time": True}, "found a control that changes in time; use one that is constant"),
    "long steps": ({"control__step": 0.3}, BETWEEN),
}


@pytest.fixture(scope="module")
def some_fields(from_fields: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A search that stored some steps, in a folder with the checkpoint of another."""
    out = shutil.copytree(from_fields, tmp_path_factory.mktemp("some") / "out")
    signorini("optimize", BLOCK, out, **SOME)
    return out


@pytest.mark.parametrize("name", UNKNOWN)
def test_control_between_stored_steps(some_fields: Path, name: str, tmp_path: Path) -> None:
    """It is not known, unless the control is the same there."""
    setting, text = UNKNOWN[name]
    refused("control.h5: ", text, out=tmp_path, control__initial={"run": str(some_fields)}, **setting)


def test_control_between_stored_steps_without_a_checkpoint(some_fields: Path, tmp_path: Path) -> None:
    out = shutil.copytree(some_fields, tmp_path / "out")
    (out / "checkpoint.h5").unlink()
    refused("and there is no checkpoint.h5; use", ranks=2, out=tmp_path / "again", control__initial={"run": str(out)})


@pytest.mark.parametrize("setting", ({"control__constant_in_time": True}, {"control__step": 0.2}), ids=str)
def test_step_stored_in_each_interval(setting: dict[str, object], tmp_path: Path) -> None:
    out, again = tmp_path / "out", tmp_path / "again"
    signorini("optimize", BLOCK, out, **SOME, **setting)
    for ranks in (1, 2):
        signorini("simulate", BLOCK, again, ranks, control__initial={"run": str(out)}, **setting)
        assert objective(again)["control_cost"] > 0
        same(objective(again), objective(out), ROUNDING if ranks == 1 else RANKS)


@pytest.fixture
def killed(optimum: Optimum, tmp_path: Path) -> Path:
    """A folder with the checkpoint alone: a search that was killed has left no run.json."""
    out = tmp_path / "killed"
    out.mkdir()
    shutil.copy(optimum("some steps") / "checkpoint.h5", out)
    return out


def test_control_of_a_killed_search(optimum: Optimum, killed: Path, tmp_path: Path) -> None:
    signorini("simulate", BLOCK, tmp_path / "again", control__initial={"run": str(killed)})
    same(objective(tmp_path / "again"), objective(optimum("some steps")), ROUNDING)


@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("value", ("3", '{"value": "1"}', "[]"))
def test_manifest_of_no_run(killed: Path, value: str, ranks: int, tmp_path: Path) -> None:
    """The checkpoint is not this one's, on whichever rank that is found."""
    (killed / "run.json").write_text(f'{{"objective": {value}}}')
    refused("no control.h5 that its run wrote, and checkpoint.h5 belongs to another run", ranks=ranks, out=tmp_path / "again",
            control__initial={"run": str(killed)})  # fmt: skip


def test_checkpoint_of_a_fit(killed: Path, tmp_path: Path) -> None:
    """It has no control."""
    (killed / "run.json").write_text('{"objective": []}')
    with h5py.File(killed / "checkpoint.h5", "a") as file:
        del file["u"]
    refused("checkpoint.h5 belongs to a search without a control; use", ranks=2, out=tmp_path / "again", control__initial={"run": str(killed)})


FREE = {"contact__obstacle__point": [0, -100], "load__body": ["0", "0"], "optimizer__start": "guess"}  # all momentum is the control's
X = {"control__components": ["x"], "objective__desired": {"control": ["0.3", "0"]}}
Y = {"control__components": ["y"], "objective__desired": {"control": ["0", "-1"]}}
FAR, WIDE = {"mesh__file": "far.geo"}, {"mesh__file": "wide.geo"}


def with_mesh(settings: dict[str, object], folder: Path) -> dict[str, object]:
    """The settings, with the path of a mesh that is 100 m away or 3 m wide."""
    square = (SOURCE / "tests" / "data" / "square.geo").read_text()
    (folder / "far.geo").write_text(re.sub(r"= \{(\d, \d, 0)\}", r"= {10\1}", square))
    (folder / "wide.geo").write_text(re.sub(r"= \{1, (\d, 0)\}", r"= {3, \1}", square))
    return settings | {key: str(folder / settings[key]) for key in ("mesh__file",) if key in settings}


@pytest.fixture(scope="module")
def free(tmp_path_factory: pytest.TempPathFactory) -> Optimum:
    """Searches in free flight, by the components, the group or the mesh of their control."""
    kinds = {"x": (X, 2), "xy": ({}, 2), "top": ({"control__on": "top"}, 2), "wide": (WIDE, 1)}

    @functools.cache
    def of(name: str) -> Path:
        (settings, iterations), folder = kinds[name], tmp_path_factory.mktemp(name)
        signorini("optimize", BLOCK, folder / "out", **FREE, **with_mesh(settings, folder), optimizer__max_iterations=iterations)
        return folder / "out"

    return of


OTHER_KINDS = {
    "other component": ("x", Y, "checkpoint.h5: found a control in x, but this scene's control acts in y;"),
    "fewer components": ("xy", Y, "found a control in x, y, but this scene's control acts in y;"),
    "fewer components, other mesh": ("xy", Y | {"mesh__size": 0.3}, "found a control in x, y, but this scene's control acts in y;"),
    "other group": ("top", {"control__on": "left"}, 'found a control on "top", but this scene\'s control acts on "left"'),
    "on the body": ("top", {}, 'found a control on "top", but this scene\'s control acts on the body'),
    "other scale": ("xy", {"control__scale": 1e3}, "found a control with control.scale = 1, but this scene has 1000"),
    "far": ("xy", FAR, "found a control up to 100 m away from this scene"),
    "far, on a group": ("top", FAR | {"control__on": "top"}, "found a control up to 100 m away from this scene"),
    "from a wide mesh": ("wide", {}, "found a control up to 2 m away from this scene"),
    "on a wide mesh": ("xy", WIDE, "found a control up to 2 m away from this scene"),
}


@pytest.mark.parametrize("name, ranks", [*((name, 1) for name in OTHER_KINDS), ("other component", 2), ("far", 2)])
def test_control_of_another_kind_is_refused(free: Optimum, name: str, ranks: int, tmp_path: Path) -> None:
    """A control is that of the same components, group, scale and place, or it is refused."""
    earlier, settings, text = OTHER_KINDS[name]
    refused("control.initial.run: ", text, ranks=ranks, out=tmp_path / "refused", control__initial={"run": str(free(earlier))}, **FREE,
            **with_mesh(settings, tmp_path))  # fmt: skip
    assert not (tmp_path / "refused" / "run.json").exists()


@pytest.mark.parametrize("ranks", (1, 2))
def test_components_that_it_lacks_are_zero(free: Optimum, ranks: int, tmp_path: Path) -> None:
    for out, settings in (("as-x", X), ("as-xy", {})):
        signorini("simulate", BLOCK, tmp_path / out, ranks, control__initial={"run": str(free("x"))}, **FREE, **settings)
    a, b = table(tmp_path / "as-xy" / "steps.csv"), table(tmp_path / "as-x" / "steps.csv")
    work = abs(b["external_work"]).max()  # of the control alone
    assert work > 1e-5
    for energy in ENERGIES:
        assert a[energy] == pytest.approx(b[energy], rel=0, abs=RANKS * work), energy


DESIRED = {"objective__desired": {"displacement": ["0.1*t", "-0.1"]}}


@pytest.fixture
def joint(tmp_path: Path) -> dict[str, object]:
    """A search for a control and a modulus."""
    data = tmp_path / "data.csv"
    data.write_text("time,value\n" + "".join(f"{0.02 * k:.17g},{-0.03 * k:.17g}\n" for k in range(31)))
    measurement = {"of": "displacement", "component": "y", "point": [0.5, 1], "file": str(data), "deviation": 0.01}
    return DESIRED | {"unknown": [{"of": "young", "start": 50.0}], "measurement": [measurement]}


def replay_joint(optimum: Path, out: Path, ranks: int, settings: dict[str, object]) -> None:
    """With the fitted modulus the motion and J of the optimum again."""
    young = float(table(optimum / "parameters.csv")["value"][0])
    signorini("simulate", BLOCK, out, ranks, material__young=young, control__initial={"run": str(optimum)}, **DESIRED, **settings)
    same(objective(out), objective(optimum), RANKS)


@pytest.mark.parametrize("settings", ({}, {"control__constant_in_time": True}, {"control__step": 0.1}), ids=str)
def test_control_of_a_joint_search(joint: dict[str, object], settings: dict[str, object], tmp_path: Path) -> None:
    optimum, again = tmp_path / "joint", tmp_path / "again"
    signorini("optimize", BLOCK, optimum, **joint, **settings, optimizer__max_iterations=3)
    young = table(optimum / "parameters.csv")["value"][0]
    assert abs(young / 50 - 1) > 1e-3 and (table(optimum / "steps.csv")["active"] > 0).any()
    for ranks in (1, 2):
        replay_joint(optimum, again, ranks, settings)
        assert objective(again)["control_cost"] > 0


def test_control_of_a_joint_search_from_fields(joint: dict[str, object], tmp_path: Path) -> None:
    """A checkpoint that an earlier search left there is not this one's."""
    optimum = tmp_path / "joint"
    signorini("optimize", BLOCK, optimum, **joint, control__step=0.1, optimizer__max_iterations=3)
    old = objective(optimum)
    signorini("optimize", BLOCK, optimum, **joint, optimizer__max_iterations=6, optimizer__checkpoint=0)
    assert (optimum / "checkpoint.h5").exists() and abs(objective(optimum)["control_cost"] / old["control_cost"] - 1) > 1e-3
    replay_joint(optimum, tmp_path / "again", 1, {})
