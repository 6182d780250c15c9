# SPDX-License-Identifier: GPL-3.0-or-later
"""J of a simulation, and a control that an earlier run left: applied again, or gone on from, on other ranks and with other steps."""

import json
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
        assert (table(found / "steps.csv")["active"] > 0).any() or number > 2
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
    killed = folder / "killed"  # such a search has left no run.json
    killed.mkdir()
    shutil.copy(folder / "optimum-0" / "checkpoint.h5", killed)
    signorini("simulate", BLOCK, again, control__initial={"run": str(killed)})
    same(objective(again), objective(folder / "optimum-0"), ROUNDING)
    print("without a checkpoint of its own a run's control is read from its fields")


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        for part in (of_every_kind, replayed, gone_on_from, without_a_checkpoint):
            part(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
