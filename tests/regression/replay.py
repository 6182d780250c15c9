# SPDX-License-Identifier: GPL-3.0-or-later
"""J of a simulation, and a control that an earlier run left: applied again, or gone on from, on other ranks and with other steps."""

import json
import re
import shutil
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SOURCE, attempt, signorini, table  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402

BLOCK, CUBE = SOURCE / "tests" / "data" / "block.toml", SOURCE / "tests" / "data" / "cube.toml"
ROUNDING, RANKS = 1e-12, 1e-8  # on other ranks sums are in another order, and contact multiplies that
IN_SPACE = {"control": {"scale": 1}, "objective": {"desired": {"displacement": ["0", "0.1*t", "-0.1"]}, "alpha": 1e-2}}


def objective(out: Path) -> dict[str, float]:
    return json.loads((out / "run.json").read_text())["objective"]


def same(a: dict[str, float], b: dict[str, float], tolerance: float) -> None:
    assert a.keys() == b.keys() and b["value"] > 0
    assert all(abs(a[part] - b[part]) <= tolerance * b["value"] for part in a), (a, b)


def of_every_kind(folder: Path) -> None:
    """J of simulate is that of optimize at its first guess, whatever is desired and wherever the control acts."""
    motion = folder / "motion"
    signorini("simulate", BLOCK, motion, control__initial=["0.5", "-0.5"])
    for number, settings in enumerate((
        {"objective__desired": {"control": ["0.3*t", "x"]}, "control__initial": ["t", "-1"]},
        {"objective__desired": {"control": ["0.3", "-1"]}},
        {"objective__desired": {"displacement": ["0.1*t", "y"]}, "control__initial": ["0", "-9"], "control__lower": -2},
        {"objective__desired": {"displacement": ["0", "-0.1"]}, "control__on": "top", "objective__on": "bottom", "control__initial": ["1", "x"]},
        {"objective__desired": {"run": str(motion)}, "control__constant_in_time": True, "control__initial": ["x", "0"]},
        {"objective__desired": {"control": ["0.3", "-1"]}, "control__space": "cellwise", "control__initial": ["x", "0"], "mesh__degree": 2,
         "time__scheme": "contact-stabilized"},
        {"objective__desired": {"control": ["0.3", "-1"]}, "contact__mass": "massless", "solver__vi": "full"},
    )):  # fmt: skip
        found, expected = folder / f"j-{number}", folder / f"expected-{number}"
        signorini("optimize", BLOCK, expected, optimizer__max_iterations=0, **settings)
        for ranks in (1, 2) if number in (0, 3) else (1,):
            done = signorini("simulate", BLOCK, found, ranks, **settings)
            same(objective(found), objective(expected), ROUNDING if ranks == 1 else RANKS)
            line = next(line for line in done.stdout.splitlines() if line.startswith("J = "))
            assert abs(float(line.split()[2]) / objective(found)["value"] - 1) < 1e-6, line
        assert (table(found / "steps.csv")["active"] > 0).any(), f"case {number}: no contact"
    done = signorini("simulate", BLOCK, folder / "unknown", objective__desired={"run": "nowhere"})
    assert "J is not known: objective.desired.run: " in done.stdout and "objective" not in json.loads(
        (folder / "unknown" / "run.json").read_text())
    print("simulate: J is that of optimize at the same control; without the desired run it is not known")


def replayed(folder: Path) -> None:
    """The motion and J of an optimum again, from its folder."""
    for number, (scene, settings) in enumerate((
        (BLOCK, {"output__every": 7}),  # so that control.h5 has only some of it
        (BLOCK, {"mesh__degree": 2, "control__on": "rest", "control__components": ["y"], "objective__desired": {"control": ["0", "-1"]}}),
        (BLOCK, {"control__space": "cellwise", "control__upper": 0.1, "time__scheme": "contact-stabilized"}),
        (BLOCK, {"control__constant_in_time": True, "contact__mass": "massless"}),
        (CUBE, {**IN_SPACE, "contact__obstacle": {"shape": "half-space", "point": [0, 0, -0.05], "normal": [0, 0, 1]}}),
    )):  # fmt: skip
        optimum = folder / f"optimum-{number}"
        first = 1 + number % 2
        signorini("optimize", scene, optimum, first, **settings, optimizer={"max_iterations": 2})
        assert (table(optimum / "steps.csv")["active"] > 0).any() and objective(optimum)["control_cost"] > 0
        settings["control__initial"] = {"run": str(optimum)}
        if "control" in settings:
            settings["control"] = {"scale": 1, "initial": settings.pop("control__initial")}
        for ranks in (1, 2):
            again = folder / f"again-{number}"
            signorini("simulate", scene, again, ranks, **settings)
            tolerance = ROUNDING if ranks == first == 1 else RANKS
            same(objective(again), objective(optimum), tolerance)
            a, b = table(again / "steps.csv"), table(optimum / "steps.csv")
            for name in ("kinetic_energy", "elastic_energy", "external_work"):
                assert np.allclose(a[name], b[name], rtol=0, atol=tolerance * abs(b[name]).max()), (number, name)
    echo = folder / "echo"
    signorini("simulate", again / "scene.toml", echo)
    same(objective(echo), objective(again), RANKS)
    print("the control of an optimum is applied again, from its folder alone")


def gone_on_from(folder: Path) -> None:
    """A search with other weights or steps starts where an earlier one ended."""
    optimum = folder / "optimum-1"
    settings = {"mesh__degree": 2, "control__on": "rest", "control__components": ["y"], "control__initial": {"run": str(optimum)},
                "objective__desired": {"control": ["0", "-1"]}}  # fmt: skip
    signorini("optimize", BLOCK, folder / "on", **settings, optimizer__max_iterations=2)
    history = table(folder / "on" / "history.csv")["objective"]
    assert abs(history[0] / objective(optimum)["value"] - 1) < RANKS and history[-1] < history[0]
    # Other steps: each has the value in its middle, so that half as long ones repeat it and J moves with the motion alone.
    J = {step: None for step in (0.02, 0.01, 0.005)}
    for step in J:
        signorini("simulate", BLOCK, folder / "steps", time__step=step, **settings)
        J[step] = objective(folder / "steps")
        assert abs(J[step]["control_cost"] / J[0.02]["control_cost"] - 1) < ROUNDING
    assert abs(J[0.005]["value"] - J[0.01]["value"]) < abs(J[0.01]["value"] - J[0.02]["value"]) < 0.2 * J[0.02]["value"]
    shorter = folder / "shorter"
    signorini("simulate", BLOCK, shorter, time__end=0.3, **settings)
    same_folder = attempt("simulate", BLOCK, optimum, **settings)
    assert same_folder.returncode == 2 and "control.initial.run" in same_folder.stderr, same_folder.stderr
    print("an earlier control is gone on from, with other steps too")


def without_a_checkpoint(folder: Path) -> None:
    """Nodal controls are read from control.h5 as well; a checkpoint that an earlier search left in the folder is not taken for this one's."""
    out, again = folder / "no-checkpoint", folder / "from-fields"
    start = {"control__initial": {"run": str(out)}}
    signorini("optimize", BLOCK, out, optimizer__max_iterations=1)
    old = objective(out)
    signorini("optimize", BLOCK, out, optimizer__max_iterations=4, optimizer__checkpoint=0)
    assert (out / "checkpoint.h5").exists() and objective(out)["value"] < 0.999 * old["value"]
    for ranks in (1, 2):
        signorini("simulate", BLOCK, again, ranks, **start)
        same(objective(again), objective(out), ROUNDING if ranks == 1 else RANKS)
    with h5py.File(out / "control.h5") as file:
        assert len(file["Function/control"]) == 30
    for setting in ({"mesh__degree": 2}, {"control__space": "cellwise"}, {"mesh__size": 0.5}, {"time__end": 1.2}):
        refused = attempt("simulate", BLOCK, again, **start, **setting)
        assert refused.returncode == 2 and "control.initial.run: " in refused.stderr, (setting, refused.stderr)
    # What lies between stored steps is not known, unless the control is the same there.
    some = {"optimizer__max_iterations": 2, "output__every": 7, "optimizer__checkpoint": 0}
    between = "found no step stored between"
    signorini("optimize", BLOCK, out, **some)
    for setting, text in (({}, f"{between} 0 and 0.02 s, and checkpoint.h5 is of another run"),
                          ({"control__constant_in_time": True}, "found a control that changes in time; use one that is constant"),
                          ({"control__step": 0.3}, between)):  # fmt: skip
        refused = attempt("simulate", BLOCK, again, **start, **setting)
        assert refused.returncode == 2 and "control.h5: " in refused.stderr and text in refused.stderr, (setting, refused.stderr)
    (out / "checkpoint.h5").unlink()
    refused = attempt("simulate", BLOCK, again, 2, **start)
    assert refused.returncode == 2 and "and there is no checkpoint.h5; use" in refused.stderr, refused.stderr
    for setting in ({"control__constant_in_time": True}, {"control__step": 0.2}):  # within each interval a step is stored
        signorini("optimize", BLOCK, out, **some, **setting)
        for ranks in (1, 2):
            signorini("simulate", BLOCK, again, ranks, **start, **setting)
            assert objective(again)["control_cost"] > 0
            same(objective(again), objective(out), ROUNDING if ranks == 1 else RANKS)
    killed = folder / "killed"  # such a search has left no run.json
    killed.mkdir()
    shutil.copy(folder / "optimum-0" / "checkpoint.h5", killed)
    signorini("simulate", BLOCK, again, control__initial={"run": str(killed)})
    same(objective(again), objective(folder / "optimum-0"), ROUNDING)
    for value in ("3", '{"value": "1"}', "[]"):  # of no run: the checkpoint is not this one's, on whichever rank that is found
        (killed / "run.json").write_text(f'{{"objective": {value}}}')
        for ranks in (1, 2):
            refused = attempt("simulate", BLOCK, again, ranks, control__initial={"run": str(killed)})
            assert refused.returncode == 2 and "no control.h5 of its run, and checkpoint.h5 is of another run" in refused.stderr, (value, refused)
    with h5py.File(killed / "checkpoint.h5", "a") as file:  # that of a fit has none
        del file["u"]
    refused = attempt("simulate", BLOCK, again, 2, control__initial={"run": str(killed)})
    assert refused.returncode == 2 and "checkpoint.h5 is of a search without a control; use" in refused.stderr, refused.stderr
    print("without a checkpoint of its own a run's control is read from its fields")


def of_another_kind(folder: Path) -> None:
    """A control is that of the same components, group, scale and place, or it is refused; components that it lacks are zero."""
    free = {"contact__obstacle__point": [0, -100], "load__body": ["0", "0"], "optimizer__start": "guess"}  # all momentum is the control's
    optimum = {}
    for name, settings in (("x", {"control__components": ["x"], "objective__desired": {"control": ["0.3", "0"]}}),
                           ("xy", {}), ("top", {"control__on": "top"})):  # fmt: skip
        optimum[name] = folder / name
        signorini("optimize", BLOCK, optimum[name], **free, **settings, optimizer__max_iterations=2)
    square = (SOURCE / "tests" / "data" / "square.geo").read_text()
    far, wide = folder / "far.geo", folder / "wide.geo"
    far.write_text(re.sub(r"= \{(\d, \d, 0)\}", r"= {10\1}", square))
    wide.write_text(re.sub(r"= \{1, (\d, 0)\}", r"= {3, \1}", square))
    optimum["wide"] = folder / "wide"
    signorini("optimize", BLOCK, optimum["wide"], **free, mesh__file=str(wide), optimizer__max_iterations=1)
    y = {"control__components": ["y"], "objective__desired": {"control": ["0", "-1"]}}
    for number, (name, settings, text) in enumerate((
        ("x", y, "checkpoint.h5: found a control of x, this scene's acts in y;"),
        ("xy", y, "found a control of x, y, this scene's acts in y;"),
        ("xy", y | {"mesh__size": 0.3}, "found a control of x, y, this scene's acts in y;"),
        ("top", {"control__on": "left"}, 'found a control on "top", this scene\'s acts on "left"'),
        ("top", {}, 'found a control on "top", this scene\'s acts on the body'),
        ("xy", {"control__scale": 1e3}, "found a control with control.scale = 1, this scene has 1000"),
        ("xy", {"mesh__file": str(far)}, "found a control up to 100 m from this scene"),
        ("top", {"mesh__file": str(far), "control__on": "top"}, "found a control up to 100 m from this scene"),
        ("wide", {}, "found a control up to 2 m from this scene"),
        ("xy", {"mesh__file": str(wide)}, "found a control up to 2 m from this scene"),
    )):  # fmt: skip
        for ranks in (1, 2) if number in (0, 6) else (1,):
            refused = attempt("simulate", BLOCK, folder / "refused", ranks, control__initial={"run": str(optimum[name])}, **free, **settings)
            assert refused.returncode == 2 and "control.initial.run: " in refused.stderr and text in refused.stderr, (text, refused.stderr)
            assert not (folder / "refused" / "run.json").exists()
    for ranks in (1, 2):
        for out, settings in (("as-x", {"control__components": ["x"], "objective__desired": {"control": ["0.3", "0"]}}), ("as-xy", {})):
            signorini("simulate", BLOCK, folder / out, ranks, control__initial={"run": str(optimum["x"])}, **free, **settings)
        a, b = table(folder / "as-xy" / "steps.csv"), table(folder / "as-x" / "steps.csv")
        work = abs(b["external_work"]).max()  # of the control alone
        assert work > 1e-5, work
        for name in ("external_work", "kinetic_energy", "elastic_energy"):
            assert np.allclose(a[name], b[name], rtol=0, atol=RANKS * work), name
    print("a control of other components, on another group, in another unit or place is refused")


def of_a_joint_search(folder: Path) -> None:
    """Beside unknowns: with the fitted modulus the motion and J of the optimum again."""
    data, optimum, again = folder / "data.csv", folder / "joint", folder / "again-joint"
    tables = {"objective__desired": {"displacement": ["0.1*t", "-0.1"]}, "unknown": [{"of": "young", "start": 50.0}],
              "measurement": [{"of": "displacement", "component": "y", "point": [0.5, 1], "file": str(data), "deviation": 0.01}]}  # fmt: skip
    data.write_text("time,value\n" + "".join(f"{0.02 * k:.17g},{-0.03 * k:.17g}\n" for k in range(31)))
    for settings in ({}, {"control__constant_in_time": True}, {"control__step": 0.1}):
        signorini("optimize", BLOCK, optimum, **tables, **settings, optimizer__max_iterations=3)
        young = table(optimum / "parameters.csv")["value"][0]
        assert abs(young / 50 - 1) > 1e-3 and (table(optimum / "steps.csv")["active"] > 0).any()
        for ranks in (1, 2):
            signorini("simulate", BLOCK, again, ranks, material__young=float(young), control__initial={"run": str(optimum)},
                      objective__desired=tables["objective__desired"], **settings)  # fmt: skip
            assert objective(again)["control_cost"] > 0
            same(objective(again), objective(optimum), RANKS)
    # A checkpoint that an earlier search left there is not this one's.
    old = objective(optimum)
    signorini("optimize", BLOCK, optimum, **tables, optimizer__max_iterations=6, optimizer__checkpoint=0)
    assert (optimum / "checkpoint.h5").exists() and abs(objective(optimum)["control_cost"] / old["control_cost"] - 1) > 1e-3
    young = table(optimum / "parameters.csv")["value"][0]
    signorini("simulate", BLOCK, again, material__young=float(young), control__initial={"run": str(optimum)},
              objective__desired=tables["objective__desired"])  # fmt: skip
    same(objective(again), objective(optimum), RANKS)
    print("the control of a search with unknowns is applied again")


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        for part in (of_every_kind, replayed, gone_on_from, without_a_checkpoint, of_another_kind, of_a_joint_search):
            part(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
