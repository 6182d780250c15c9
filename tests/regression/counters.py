# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene does not ask for is neither made nor done: the counters of run.json."""

import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SOURCE, signorini  # noqa: E402

BLOCK = SOURCE / "tests/data/block.toml"
FREE = SOURCE / "tests/data/manufactured.toml"  # without contact
CONTROL = ("control spaces", "objectives", "reduced problems", "adjoint sweeps", "adjoint steps", "linearised steps")
CONTACT = ("constraints", "VI solvers", "VIs solved")


def counters(verb: str, scene: Path, folder: Path, ranks: int = 1, **overrides: object) -> dict[str, int]:
    signorini(verb, scene, folder / verb, ranks, **overrides)
    run = json.loads((folder / verb / "run.json").read_text())
    return run["counters"] | {"asked": run["steps"]["asked"], "candidates": run["candidates"]}


def none_of(found: dict[str, int], names: tuple[str, ...]) -> None:
    assert all(found[name] == 0 for name in names), {name: found[name] for name in names}


def simulate_makes_no_adjoint(folder: Path) -> None:
    """Of a scene with a control and an objective it makes what J needs: the desired motion, step by step beside its own."""
    found = counters("simulate", HALF_DISC, folder, mesh__size=2)
    none_of(found, ("reduced problems", "adjoint sweeps", "adjoint steps", "linearised steps"))
    assert found["control spaces"] == found["objectives"] == found["assembled L2"] == 1
    assert found["steps"] == 2 * found["asked"] == 300 and found["load evaluations"] == 0
    found = counters("simulate", HALF_DISC, folder, mesh__size=2, objective__desired={"displacement": ["0", "0"]})
    assert found["steps"] == found["asked"] and found["objectives"] == 1
    no_objective = folder / "no-objective.toml"
    text = HALF_DISC.read_text().replace("../meshes", str(SOURCE / "meshes"))
    no_objective.write_text(text[: text.index("[objective]")])
    found = counters("simulate", no_objective, folder, mesh__size=2)
    none_of(found, CONTROL)
    assert found["steps"] == found["asked"] == 150 and found["load evaluations"] == 0
    assert {name: count for name, count in found.items() if name.startswith("assembled")} == {
        "assembled a": 1, "assembled b": 1, "assembled d": 1, "assembled m": 1, "assembled L2_surface": 1}  # fmt: skip
    found = counters("simulate", HALF_DISC, folder, mesh__size=2, output__tables=["steps"])
    assert "assembled L2_surface" not in found, "areas of candidates without a table or a field of pressures"
    found = counters("optimize", HALF_DISC, folder, mesh__size=2, optimizer__max_iterations=1, output__every=50)
    assert found["control spaces"] == found["objectives"] == found["reduced problems"] == 1
    assert found["assembled L2"] == 1
    assert found["adjoint steps"] == found["asked"] * found["adjoint sweeps"] > 0, "the counters count nothing"
    print("simulate: what J needs and no adjoint; without an objective nothing of it")


def elastic_scene_has_no_b(folder: Path) -> None:
    edited = folder / "elastic.toml"
    text = BLOCK.read_text().replace('"square.geo"', f'"{BLOCK.parent}/square.geo"')
    edited.write_text("\n".join(line for line in text.splitlines() if not line.startswith("viscosity")))
    found = counters("simulate", edited, folder)
    assert "assembled b" not in found and "assembled d" not in found and found["assembled d_elastic"] == 1
    print("an elastic scene assembles no b")


def contact_only_where_it_is(folder: Path) -> None:
    found = counters("simulate", FREE, folder)
    none_of(found, (*CONTACT, "candidates"))
    assert found["solves with D"] == found["steps"] == found["asked"]
    assert found["load evaluations"] == found["asked"], "a load of time is evaluated once a step"
    far = {"contact__obstacle__point": [0, -5], "objective__desired": {"displacement": ["0", "0"]}}  # no second motion
    for linear in ("direct", "iterative"):
        found = counters("simulate", BLOCK, folder, solver__linear=linear, **far)
        assert found["constraints"] == found["VI solvers"] == 1 and found["VIs solved"] == 0
        assert found["solves with D"] == found["steps"] == found["asked"]
        assert found["load evaluations"] == 1, "a load that stays the same is evaluated once"
        found = counters("simulate", BLOCK, folder, solver__linear=linear)
        assert 0 < found["VIs solved"] < found["steps"], "the body flies and lands"
    found = counters("simulate", BLOCK, folder, time__scheme="contact-stabilized", **far)
    assert found["VI solvers"] == 2 and found["VIs solved"] == 0, "the predictor has its own"
    assert found["solves with D"] == found["steps"] == found["asked"]
    found = counters("simulate", BLOCK, folder, ranks=2, **far)
    assert found["VIs solved"] == 0 and found["solves with D"] == found["steps"] + found["candidates"] > found["steps"]
    print("no contact, no VI; in free flight none is solved and every step takes one solve")


def memory_does_not_grow_with_the_steps(folder: Path) -> None:
    """A forward run keeps two states, and two of a desired motion, however many steps it makes."""
    peak = {}
    for steps in (50, 3000):  # 3000 states of this mesh are 157 MB
        signorini("simulate", HALF_DISC, folder / "long", mesh__size=0.5, time__end=steps * 5e-5, output__every=10**6)
        run = json.loads((folder / "long" / "run.json").read_text())
        assert run["counters"]["trajectory vectors"] == 8 and run["steps"]["done"] == steps  # of the desired motion too
        peak[steps] = run["peak_memory_bytes"]
    assert peak[3000] < peak[50] + 20e6, peak
    print(f"two states kept; {peak[3000] / 1e6:.0f} MB for 3000 steps, {peak[50] / 1e6:.0f} MB for 50")


def optimizations_keep_what_they_say(folder: Path) -> None:
    """On disk or in checkpoints neither the states of a motion nor the adjoint states stay in memory."""
    few, many = 20, 300
    small = {"objective__desired": {"displacement": ["0", "-0.1*t"]}, "control__constant_in_time": True}

    def run(steps: int, **storage: object) -> dict:
        signorini("optimize", HALF_DISC, folder / "kept", mesh__size=0.25, time__end=steps * 5e-5, optimizer__max_iterations=0,
                  output__fields=["adjoint"], trajectory=storage, **small)  # fmt: skip
        found = json.loads((folder / "kept" / "run.json").read_text())
        assert found["steps"]["done"] == steps and (folder / "kept" / "adjoint.h5").stat().st_size > 8 * steps * found["unknowns"]
        return found

    first = run(few, storage="disk")
    motion = 8 * first["unknowns"] * many
    peak = {"disk": run(many, storage="disk"), "memory": run(many, storage="memory"),
            "checkpoints": run(many, storage="checkpoints", budget=motion / 10)}  # fmt: skip
    # In memory there are the motions of the iterate and of the trial.
    assert peak["memory"]["counters"]["trajectory vectors"] >= 2 * many > 10 * peak["disk"]["counters"]["trajectory vectors"]
    peak = {storage: found["peak_memory_bytes"] for storage, found in peak.items()}
    assert peak["memory"] > peak["disk"] + 1.5 * motion, (peak, motion)
    for storage in ("disk", "checkpoints"):  # headers and XML, a budget
        assert peak[storage] < first["peak_memory_bytes"] + motion / 3, (peak, first["peak_memory_bytes"], motion)
    print(f"states of {motion / 1e6:.0f} MB a motion:", *(f"{storage} {bytes / 1e6:.0f} MB" for storage, bytes in peak.items()),
          f"at most; {first['peak_memory_bytes'] / 1e6:.0f} MB for {few} of {many} steps")  # fmt: skip


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        simulate_makes_no_adjoint(folder)
        elastic_scene_has_no_b(folder)
        contact_only_where_it_is(folder)
        memory_does_not_grow_with_the_steps(folder)
        optimizations_keep_what_they_say(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
