# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene does not ask for is neither made nor done: the counters of run.json."""

import json
from pathlib import Path

import pytest
from harness import HALF_DISC, SOURCE, signorini

BLOCK = SOURCE / "tests" / "data" / "block.toml"
UNCONSTRAINED = SOURCE / "tests" / "data" / "manufactured.toml"  # without contact
ADJOINT = ("reduced problems", "adjoint sweeps", "adjoint steps", "linearised steps")
CONTROL = ("control spaces", "objectives", *ADJOINT)
CONTACT = ("constraints", "VI solvers", "VIs solved")
AT_REST = {"objective__desired": {"displacement": ["0", "0"]}}  # no second motion
FAR = AT_REST | {"contact__obstacle__point": [0, -5]}


def counters(verb: str, scene: Path, folder: Path, ranks: int = 1, **overrides: object) -> dict[str, int]:
    signorini(verb, scene, folder / "out", ranks, **overrides)
    run = json.loads((folder / "out" / "run.json").read_text())
    return run["counters"] | {"asked": run["steps"]["asked"], "candidates": run["candidates"]}


def none_of(found: dict[str, int], names: tuple[str, ...]) -> None:
    assert {name: found[name] for name in names} == dict.fromkeys(names, 0)


def test_simulate_makes_no_adjoint(tmp_path: Path) -> None:
    """simulate makes of a control and an objective what J needs: the desired motion, step by step beside its own."""
    found = counters("simulate", HALF_DISC, tmp_path, mesh__size=2)
    none_of(found, ADJOINT)
    assert found["control spaces"] == found["objectives"] == found["assembled L2"] == 1
    assert found["steps"] == 2 * found["asked"] == 300 and found["load evaluations"] == 0


def test_desired_displacement_takes_no_steps(tmp_path: Path) -> None:
    found = counters("simulate", HALF_DISC, tmp_path, mesh__size=2, **AT_REST)
    assert found["steps"] == found["asked"] and found["objectives"] == 1


def test_without_an_objective_nothing_of_it(tmp_path: Path) -> None:
    scene = tmp_path / "no-objective.toml"
    text = HALF_DISC.read_text().replace("../meshes", str(SOURCE / "meshes"))
    scene.write_text(text[: text.index("[objective]")])
    found = counters("simulate", scene, tmp_path, mesh__size=2)
    none_of(found, CONTROL)
    assert found["steps"] == found["asked"] == 150 and found["load evaluations"] == 0
    assert {name: count for name, count in found.items() if name.startswith("assembled")} == {
        "assembled a": 1, "assembled b": 1, "assembled d": 1, "assembled m": 1, "assembled L2_surface": 1}  # fmt: skip


def test_no_areas_without_a_table_or_a_field_of_pressures(tmp_path: Path) -> None:
    assert "assembled L2_surface" not in counters("simulate", HALF_DISC, tmp_path, mesh__size=2, output__tables=["steps"])


def test_optimize_makes_each_once(tmp_path: Path) -> None:
    found = counters("optimize", HALF_DISC, tmp_path, mesh__size=2, optimizer__max_iterations=1, output__every=50)
    assert found["control spaces"] == found["objectives"] == found["reduced problems"] == 1
    assert found["assembled L2"] == 1
    assert found["adjoint steps"] == found["asked"] * found["adjoint sweeps"] > 0, "the counters count nothing"


def test_elastic_scene_assembles_no_b(tmp_path: Path) -> None:
    edited = tmp_path / "elastic.toml"
    text = BLOCK.read_text().replace('"square.geo"', f'"{BLOCK.parent}/square.geo"')
    edited.write_text("\n".join(line for line in text.splitlines() if not line.startswith("viscosity")))
    found = counters("simulate", edited, tmp_path)
    assert "assembled b" not in found and "assembled d" not in found and found["assembled d_elastic"] == 1


def test_no_contact_no_vi(tmp_path: Path) -> None:
    found = counters("simulate", UNCONSTRAINED, tmp_path)
    none_of(found, (*CONTACT, "candidates"))
    assert found["solves with D"] == found["steps"] == found["asked"]
    assert found["load evaluations"] == found["asked"], "a load of time is evaluated once a step"


@pytest.mark.parametrize("linear", ("direct", "iterative"))
def test_no_vi_in_free_flight(linear: str, tmp_path: Path) -> None:
    """None is solved, and every step takes one solve."""
    found = counters("simulate", BLOCK, tmp_path, solver__linear=linear, **FAR)
    assert found["constraints"] == found["VI solvers"] == 1 and found["VIs solved"] == 0
    assert found["solves with D"] == found["steps"] == found["asked"]
    assert found["load evaluations"] == 1, "a load that stays the same is evaluated once"


@pytest.mark.parametrize("linear", ("direct", "iterative"))
def test_vis_only_where_contact_may_be(linear: str, tmp_path: Path) -> None:
    found = counters("simulate", BLOCK, tmp_path, solver__linear=linear)
    assert 0 < found["VIs solved"] < found["steps"], "the body flies and lands"


def test_free_flight_by_the_stabilized_scheme(tmp_path: Path) -> None:
    found = counters("simulate", BLOCK, tmp_path, time__scheme="contact-stabilized", **FAR)
    assert found["VI solvers"] == 2 and found["VIs solved"] == 0, "the predictor has its own"
    assert found["solves with D"] == found["steps"] == found["asked"]


def test_free_flight_on_two_ranks(tmp_path: Path) -> None:
    found = counters("simulate", BLOCK, tmp_path, ranks=2, **FAR)
    assert found["VIs solved"] == 0 and found["solves with D"] == found["steps"] + found["candidates"] > found["steps"]


def test_memory_does_not_grow_with_the_steps(tmp_path: Path) -> None:
    """A forward run keeps two states, and two of a desired motion, however many steps it makes."""
    peak = {}
    for steps in (50, 3000):  # 3000 states of this mesh are 157 MB
        signorini("simulate", HALF_DISC, tmp_path / "long", mesh__size=0.5, time__end=steps * 5e-5, output__every=10**6)
        run = json.loads((tmp_path / "long" / "run.json").read_text())
        assert run["counters"]["trajectory vectors"] == 8 and run["steps"]["done"] == steps  # of the desired motion too
        peak[steps] = run["peak_memory_bytes"]
    assert peak[3000] < peak[50] + 20e6


def test_states_on_disk_or_in_checkpoints_take_no_memory(tmp_path: Path) -> None:
    """On disk or in checkpoints neither the states of a motion nor the adjoint states stay in memory."""
    few, many = 20, 300
    small = {"objective__desired": {"displacement": ["0", "-0.1*t"]}, "control__constant_in_time": True}

    def run(steps: int, **storage: object) -> dict:
        out = tmp_path / "kept"
        signorini("optimize", HALF_DISC, out, mesh__size=0.25, time__end=steps * 5e-5, optimizer__max_iterations=0,
                  output__fields=["adjoint"], trajectory=storage, **small)  # fmt: skip
        found = json.loads((out / "run.json").read_text())
        assert found["steps"]["done"] == steps and (out / "adjoint.h5").stat().st_size > 8 * steps * found["unknowns"]
        return found

    first = run(few, storage="disk")
    motion = 8 * first["unknowns"] * many
    runs = {"disk": run(many, storage="disk"), "memory": run(many, storage="memory"),
            "checkpoints": run(many, storage="checkpoints", budget=motion / 10)}  # fmt: skip
    # In memory there are the motions of the iterate and of the trial.
    assert runs["memory"]["counters"]["trajectory vectors"] >= 2 * many > 10 * runs["disk"]["counters"]["trajectory vectors"]
    peak = {storage: found["peak_memory_bytes"] for storage, found in runs.items()}
    assert peak["memory"] > peak["disk"] + 1.5 * motion
    for storage in ("disk", "checkpoints"):  # headers and XML, a budget
        assert peak[storage] < first["peak_memory_bytes"] + motion / 3, storage
