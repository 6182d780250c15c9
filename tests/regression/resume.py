# SPDX-License-Identifier: GPL-3.0-or-later
"""A search that was stopped continues to the last bit: after SIGINT, after kill -9 at random moments, with each method; on another
number of ranks to rounding (the tests with `ranks` in their names); and not from a damaged checkpoint or one of another problem."""

import functools
import random
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from harness import HALF_DISC, SIGNORINI, SOURCE, captured, table

# Iterations enough to be among the kinks for a while.
USUAL = {"mesh.size": "3", "time.end": "4e-3", "output.fields": "[]", "optimizer.checkpoint": "1", "optimizer.max_iterations": "80"}
KILLS = 6  # docs/long-runs.md reports 100
METHODS = {"lbfgs": 80, "newton-cg": 25, "projected-gradient": 20}  # and their iterations


def command(out: Path, *options: str, ranks: int = 1, scene: Path = HALF_DISC, **overrides: str) -> list[str]:
    mpirun = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    sets = USUAL | {key.replace("__", "."): value for key, value in overrides.items()}
    return [*mpirun, str(SIGNORINI), "optimize", str(scene), "--out", str(out), *options,
            *(word for key, value in sets.items() for word in ("--set", f"{key}={value}"))]  # fmt: skip


def run(out: Path, *options: str, **more: object) -> subprocess.CompletedProcess:
    return captured(command(out, *options, **more))


def complete(out: Path, *options: str, **more: object) -> str:
    done = run(out, *options, **more)
    assert done.returncode == 0, f"{done.args} ended with {done.returncode}:\n{done.stdout}{done.stderr}"
    return done.stdout


def results(out: Path) -> list[str]:
    """What must not depend on interruptions: history.csv except for the seconds, and the motion."""
    rows = [line.split(",") for line in (out / "history.csv").read_text().splitlines()]
    seconds = rows[0].index("seconds")
    return [",".join(row[:seconds] + row[seconds + 1 :]) for row in rows] + (out / "steps.csv").read_text().splitlines()


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], SimpleNamespace]:
    """By its method, an uninterrupted search: its folder, what it took and what it found."""

    @functools.cache
    def of(method: str) -> SimpleNamespace:
        out, start = tmp_path_factory.mktemp(method) / "out", time.monotonic()
        complete(out, optimizer__method=f'"{method}"', optimizer__max_iterations=str(METHODS[method]))
        return SimpleNamespace(out=out, seconds=time.monotonic() - start, results=results(out))

    return of


def killed(out: Path, after: float) -> bool:
    """Kills a run after some seconds; whether it was still running then."""
    process = subprocess.Popen(command(out, "--resume"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(after)
    if process.poll() is not None:
        assert process.returncode == 0
        return False
    process.kill()
    process.wait(timeout=60)
    return True


def test_killed(whole: Callable[[str], SimpleNamespace], tmp_path: Path) -> None:
    """All runs that end have the results of an uninterrupted one, and leave no other file."""
    out, reference, moments = tmp_path / "killed", whole("lbfgs"), random.Random(1)
    done, completed, from_checkpoint = 0, 0, 0
    while done < KILLS:
        had = (out / "checkpoint.h5").exists()
        if killed(out, moments.uniform(0.05, 0.45 * reference.seconds)):
            done += 1
            from_checkpoint += had
            rows = (out / "history.csv").read_text() if (out / "history.csv").exists() else "\n"
            assert rows.endswith("\n"), "half a line"
            continue
        assert results(out) == reference.results
        completed += 1
        shutil.rmtree(out)
    had = (out / "checkpoint.h5").exists()  # of the last kill
    assert ("resumed after iteration" in complete(out, "--resume")) == had
    assert results(out) == reference.results
    assert not [path.name for path in out.iterdir() if path.name.startswith(".")]
    assert from_checkpoint >= np.maximum(1, KILLS // 4), "too few killed runs had a checkpoint to resume from"
    print(f"{from_checkpoint} of {KILLS} runs were killed after they had resumed; {completed + 1} runs ended")


STOPS = (("lbfgs", 15), ("lbfgs", "kink"), ("newton-cg", 2), ("newton-cg", 12), ("projected-gradient", 10))


@pytest.mark.parametrize("method, step", STOPS)
def test_methods(whole: Callable[[str], SimpleNamespace], method: str, step: int | str, tmp_path: Path) -> None:
    """Stopped in smooth parts of the search and among kinks, where an iteration gathers many gradients."""
    reference, choice = whole(method), {"optimizer__method": f'"{method}"'}
    if step == "kink":
        gathered = np.diff(table(reference.out / "history.csv")["adjoint_sweeps"])  # by iterations 1, 2, …
        step = int(np.argmax(gathered > 10)) + 1
        assert gathered[step - 1] > 10 and gathered[:15].max() < 3
    complete(tmp_path, **choice, optimizer__max_iterations=str(step))
    assert f"resumed after iteration {step}" in complete(tmp_path, "--resume", **choice, optimizer__max_iterations=str(METHODS[method]))
    assert results(tmp_path) == reference.results


def test_interrupted(whole: Callable[[str], SimpleNamespace], tmp_path: Path) -> None:
    """SIGINT in the middle of an iteration, with no periodic checkpoint."""
    process = subprocess.Popen(command(tmp_path, optimizer__checkpoint="1000"), stdout=subprocess.DEVNULL)
    history = tmp_path / "history.csv"
    while not history.exists() or history.read_text().count("\n") < 25:
        assert process.poll() is None, "ended too early"
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60) == 130
    assert 24 <= len(table(history)["iteration"]) < 45
    complete(tmp_path, "--resume", optimizer__checkpoint="1000")
    assert results(tmp_path) == whole("lbfgs").results


def test_chosen_steps(tmp_path: Path) -> None:
    """Steps that the motion chose stay: those of the checkpoint."""
    auto = {"time__step": '"auto"', "time__tolerance": "1e-2", "time__end": "7.5e-3", "mesh__size": "2"}
    reference, out = tmp_path / "whole", tmp_path / "resumed"
    complete(reference, **auto, optimizer__max_iterations="12")
    complete(out, **auto, optimizer__max_iterations="5")
    assert "resumed after iteration 5" in complete(out, "--resume", **auto, optimizer__max_iterations="12")
    assert results(out) == results(reference)
    lengths = np.diff(table(reference / "steps.csv")["time"])
    assert lengths.max() > 1.5 * lengths.min(), "all are of one length"


@pytest.mark.parametrize("friction", ("0.3", '{bound="1e5"}'))
def test_friction(friction: str, tmp_path: Path) -> None:
    """A coefficient and a bound, on a belt, without tangential mass."""
    rubbed = {"contact__friction": friction, "contact__obstacle__surface_velocity": '["100", "0"]',
              "contact__mass": "massless-tangential", "time__scheme": "contact-stabilized"}  # fmt: skip
    reference, out = tmp_path / "whole", tmp_path / "resumed"
    complete(reference, **rubbed, optimizer__max_iterations="8")
    complete(out, **rubbed, optimizer__max_iterations="3")
    assert "resumed after iteration 3" in complete(out, "--resume", **rubbed, optimizer__max_iterations="8")
    assert results(out) == results(reference)
    steps = table(reference / "steps.csv")
    assert steps["slip"].sum() > 20 and steps["friction_work"].sum() < 0, "hardly any friction: the case says nothing"


def test_obstacle_with_mass(tmp_path: Path) -> None:
    """A plate with mass that turns and slides, and that the control throws to a height."""
    plate = {"control__initial": '["0", "-1"]', "contact__obstacle__mass": "100.0", "contact__obstacle__inertia": "2e4", "contact__friction": "0.3",
             "objective__desired": '{displacement=["0", "-1.0"]}', "objective__obstacle": '"obstacle 1"'}  # fmt: skip
    reference, out = tmp_path / "whole", tmp_path / "resumed"
    complete(reference, **plate, optimizer__max_iterations="8")
    complete(out, **plate, optimizer__max_iterations="3")
    assert "resumed after iteration 3" in complete(out, "--resume", **plate, optimizer__max_iterations="8")
    assert results(out) == results(reference)
    assert table(reference / "steps.csv")["rigid_energy"].max() > 0


def test_parts(tmp_path: Path) -> None:
    """Two squares in contact, with friction, one of which a control moves."""
    squares = {"scene": SOURCE / "tests" / "data" / "two-squares.toml", "mesh__size": "0.2", "time__end": "0.6"}
    reference, out = tmp_path / "whole", tmp_path / "resumed"
    complete(reference, **squares, optimizer__max_iterations="8")
    complete(out, **squares, optimizer__max_iterations="3")
    assert "resumed after iteration 3" in complete(out, "--resume", **squares, optimizer__max_iterations="8")
    assert results(out) == results(reference)
    assert table(reference / "steps.csv")["slip"].sum() > 20, "hardly any friction: the case says nothing"


@pytest.fixture(scope="module")
def on_ranks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A search from one rank to two, to three and back."""
    out = tmp_path_factory.mktemp("ranks") / "out"
    complete(out, optimizer__max_iterations="8")
    for iterations, ranks in (("12", 2), ("16", 3), ("20", 1)):
        complete(out, "--resume", optimizer__max_iterations=iterations, ranks=ranks)
    return out


def test_ranks(on_ranks: Path, tmp_path: Path) -> None:
    """J is that of an uninterrupted run but for rounding, which kinks double with each iteration."""
    complete(tmp_path, optimizer__max_iterations="20")
    there, here = (table(out / "history.csv")["objective"] for out in (tmp_path, on_ranks))
    difference = np.abs(here / there[: len(here)] - 1)
    print("8 iterations on 1 rank, 4 on 2, 4 on 3, 4 on 1: J differs by", ", ".join(f"{one:.1e}" for one in difference[9:]))
    assert len(here) == 21 and difference[:9].max() == 0
    assert np.all(difference[9:] < 1e-11 * 2.0 ** np.arange(1, 13))


@pytest.fixture(scope="module")
def stopped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A search of five iterations."""
    out = tmp_path_factory.mktemp("stopped") / "out"
    complete(out, optimizer__max_iterations="5")
    return out


def refused(out: Path, *texts: str, ranks: int = 1, scene: Path = HALF_DISC, **overrides: str) -> None:
    done = run(out, "--resume", ranks=ranks, scene=scene, **overrides)
    lines = done.stderr.split("\n---")[0].strip().splitlines()  # of several ranks mpirun prints something too
    assert done.returncode == 2 and len(lines) == 1, f"{done.stdout}{done.stderr}"
    assert "checkpoint.h5" in lines[0] and all(text in lines[0] for text in texts)
    assert (out / "checkpoint.h5").exists()


OTHER_PROBLEMS = {
    "weight": ({"objective__alpha": "0.1"}, ("objective.alpha = 0.01", "objective.alpha = 0.1;")),
    "size": ({"mesh__size": "1.5"}, ("mesh.size",)),
    "method": ({"optimizer__method": '"newton-cg"'}, ("optimizer.method",)),
}
# The same keys name another mesh, or one whose groups have other elements, even where nothing touches.
OTHER_MESHES = {"nodes": ("radius = 15", "radius = 15.001"), "groups": ('"side") = {2, 4}', '"side") = {2}')}


def refuses_other_mesh(out: Path, folder: Path, change: tuple[str, str], ranks: int) -> None:
    scene, geo = folder / "scenes" / HALF_DISC.name, folder / "meshes" / "half-disc.geo"
    scene.parent.mkdir()
    shutil.copytree(SOURCE / "meshes", geo.parent)
    shutil.copy(HALF_DISC, scene)
    text = geo.read_text()
    assert change[0] in text
    geo.write_text(text.replace(*change))
    refused(out, "on another mesh", scene=scene, ranks=ranks)


@pytest.mark.parametrize("name", OTHER_PROBLEMS)
def test_other_problem_is_refused(stopped: Path, name: str) -> None:
    overrides, texts = OTHER_PROBLEMS[name]
    refused(stopped, *texts, **overrides)


@pytest.mark.parametrize("name", OTHER_PROBLEMS)
def test_other_problem_is_refused_on_ranks(on_ranks: Path, name: str) -> None:
    overrides, texts = OTHER_PROBLEMS[name]
    refused(on_ranks, *texts, **overrides, ranks=2)


@pytest.mark.parametrize("change", OTHER_MESHES.values(), ids=OTHER_MESHES)
def test_other_mesh_is_refused(stopped: Path, change: tuple[str, str], tmp_path: Path) -> None:
    refuses_other_mesh(stopped, tmp_path, change, 1)


@pytest.mark.parametrize("change", OTHER_MESHES.values(), ids=OTHER_MESHES)
def test_other_mesh_is_refused_on_ranks(on_ranks: Path, change: tuple[str, str], tmp_path: Path) -> None:
    refuses_other_mesh(on_ranks, tmp_path, change, 2)


def test_exact_solution_is_no_other_problem(stopped: Path, tmp_path: Path) -> None:
    """What is known of the solution."""
    out = shutil.copytree(stopped, tmp_path / "out")
    assert "resumed after" in complete(out, "--resume", optimizer__max_iterations="5", exact__impulse="1.0")


DAMAGES = {
    "half": lambda good: good[: len(good) // 2],
    "empty": lambda good: b"",
    "of another kind": lambda good: b"x" * 1000,
    "without its last byte": lambda good: good[:-1],
}


def refuses_damaged(out: Path, damage: str, ranks: int = 1) -> None:
    checkpoint = out / "checkpoint.h5"
    checkpoint.write_bytes(DAMAGES[damage](checkpoint.read_bytes()))
    refused(out, "damaged", ranks=ranks)


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_is_refused(stopped: Path, damage: str, tmp_path: Path) -> None:
    refuses_damaged(shutil.copytree(stopped, tmp_path / "out"), damage)


def test_damaged_is_refused_on_ranks(on_ranks: Path, tmp_path: Path) -> None:
    refuses_damaged(shutil.copytree(on_ranks, tmp_path / "out"), "without its last byte", ranks=2)


def test_one_byte_changed(stopped: Path, tmp_path: Path) -> None:
    """Anywhere: either it is refused, or it was one that is not read."""
    out, refusals = shutil.copytree(stopped, tmp_path / "out"), 0
    good = (out / "checkpoint.h5").read_bytes()
    complete(out, "--resume", optimizer__max_iterations="6")
    reference = results(out)
    for byte in random.Random(1).sample(range(len(good)), 20):
        (out / "checkpoint.h5").write_bytes(good[:byte] + bytes([good[byte] ^ 0x40]) + good[byte + 1 :])
        done = run(out, "--resume", optimizer__max_iterations="6")
        if done.returncode == 2:
            refusals += 1
        else:
            assert done.returncode == 0 and results(out) == reference, f"byte {byte}: {done.stderr}"
    assert refusals > 10
