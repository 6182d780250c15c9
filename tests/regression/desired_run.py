# SPDX-License-Identifier: GPL-3.0-or-later
"""objective.desired.run: the desired states of an earlier run's folder, on any number of ranks and between stored times."""

import functools
import json
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_DISC, SOURCE, signorini, table

BLOCK = SOURCE / "tests" / "data" / "block.toml"
SIZE = {"mesh__size": 2}
# The block flies with y = (0, -t), without a control.
FREE = {"load__body": ["0", "0"], "contact__obstacle__point": [0, -10]}
START = {"control__initial": ["0.3", "-0.5"]}
ROUNDING = 1e-9  # of two sums, which the line search passes on
History = dict[str, np.ndarray]


def scene(folder: Path, source: Path, name: str, desired: str) -> Path:
    """A copy of a scene in `folder` with another desired state, its mesh where it was."""
    text = source.read_text()
    mesh = tomllib.loads(text)["mesh"]["file"]
    text = text.replace(f'"{mesh}"', f'"{(source.parent / mesh).resolve()}"')
    lines = [f"desired = {desired}" if line.startswith("desired") else line for line in text.splitlines()]
    copy = folder / f"{name}.toml"
    copy.write_text("\n".join(lines))
    return copy


def history(verb_scene: Path, out: Path, ranks: int = 1, **overrides: object) -> History:
    signorini("optimize", verb_scene, out, ranks, optimizer__max_iterations=2, output__fields=[], **overrides)
    return table(out / "history.csv")


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def same(found: History, expected: History, rounding: float) -> None:
    for name in ("objective", "tracking", "terminal", "gradient_norm"):
        assert (expected[name] > 0).all()
        assert found[name] == pytest.approx(expected[name], rel=rounding, abs=0), name


@pytest.fixture(scope="module")
def by_control(tmp_path_factory: pytest.TempPathFactory) -> History:
    """A search for the motion of the reference control, which it computes itself."""
    folder = tmp_path_factory.mktemp("by-control")
    found = history(scene(folder, HALF_DISC, "by-control", '{ control = ["0", "-1"] }'), folder / "c", **SIZE)
    assert (table(folder / "c" / "steps.csv")["active"] > 0).any()
    return found


@pytest.fixture(scope="module")
def by_run(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], Path]:
    """The scene of a search for that motion, simulated before on a number of ranks."""

    @functools.cache
    def simulated(ranks: int) -> Path:
        folder = tmp_path_factory.mktemp("by-run")
        copy = scene(folder, HALF_DISC, "by-run", '{ run = "earlier" }')  # relative to the scene
        signorini("simulate", copy, folder / "earlier", ranks, control__initial=["0", "-1"],
                  output__tables=[], output__fields=["displacement"], **SIZE)  # fmt: skip
        return copy

    return simulated


@pytest.mark.parametrize("earlier, ranks", ((1, 1), (1, 3), (3, 1), (2, 2)))
def test_run_is_its_control(earlier: int, ranks: int, by_run: Callable[[int], Path], by_control: History, tmp_path: Path) -> None:
    found = history(by_run(earlier), tmp_path / "r", ranks, **SIZE)
    # Another partition rounds otherwise, and the line search passes that on.
    same(found, by_control, 1e-13 if earlier == ranks == 1 else 1e-9)
    assert np.isnan(found["relative_distance_to_reference"]).all(), "there is no reference control"


def test_repeated_from_the_echo(by_run: Callable[[int], Path], tmp_path: Path) -> None:
    found = history(by_run(2), tmp_path / "r", 2, **SIZE)
    echo = tomllib.loads((tmp_path / "r" / "scene.toml").read_text())
    assert echo["objective"]["desired"] == {"run": str((by_run(2).parent / "earlier").resolve())}
    same(history(tmp_path / "r" / "scene.toml", tmp_path / "again", 2), found, 1e-9)


def test_derivatives(by_run: Callable[[int], Path]) -> None:
    signorini("check", by_run(2), check__control=["0.1", "-0.8"], **SIZE)


@pytest.mark.parametrize("start", (["0", "0"], ["0", "-1"]), ids=str)
def test_zero_is_no_scale(start: list[str], tmp_path: Path) -> None:
    """Distances relative to a reference control of zero are undefined: nan, neither infinite nor -nan, which 0/0 is."""
    found = history(BLOCK, tmp_path / "zero", objective__desired={"control": ["0", "0"]}, control__initial=start)
    assert np.isnan(found["relative_distance_to_reference"]).all()
    assert "-nan" not in (tmp_path / "zero" / "history.csv").read_text()
    assert start == ["0", "0"] or found["objective"][-1] < found["objective"][0], "the search moves"


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a flight, stored at every seventh step, and scenes of searches for it: by that run, and by its displacement."""
    folder = tmp_path_factory.mktemp("flight")
    signorini("simulate", scene(folder, BLOCK, "by-run", '{ run = "flown" }'), folder / "flown", output__every=7, **FREE)
    scene(folder, BLOCK, "by-displacement", '{ displacement = ["0", "-t"] }')
    return folder


@pytest.fixture(scope="module")
def searches(flight: Path) -> dict[str, History]:
    return {by: history(flight / f"{by}.toml", flight / f"search-{by}", **FREE, **START) for by in ("by-run", "by-displacement")}


def warned(out: Path) -> list[float]:
    return [one["value"] for one in manifest(out)["warnings"] if one["name"] == "desired motion between stored times"]


def test_linear_motion_is_met_between_stored_times(searches: dict[str, History]) -> None:
    same(searches["by-run"], searches["by-displacement"], ROUNDING)


def test_warning_of_stored_times(flight: Path, searches: dict[str, History]) -> None:
    assert warned(flight / "search-by-run") == pytest.approx([7], rel=1e-9, abs=0) and not warned(flight / "search-by-displacement")


@pytest.mark.parametrize("ranks", (1, 2))
def test_warning_is_printed_once(ranks: int, flight: Path, tmp_path: Path) -> None:
    done = signorini("simulate", flight / "by-run.toml", tmp_path / "once", ranks, **FREE, **START)
    assert len(warned(tmp_path / "once")) == 1 and done.stdout.count("are up to 0.14 s apart") == 1


def test_no_warning_of_a_whole_run(flight: Path, tmp_path: Path) -> None:
    signorini("simulate", flight / "by-run.toml", tmp_path / "whole", output__every=1, **FREE)
    signorini("simulate", flight / "by-run.toml", tmp_path / "once", **FREE, **START, objective__desired={"run": str(tmp_path / "whole")})
    assert not warned(tmp_path / "once")


@pytest.mark.parametrize("storage", ("disk", "checkpoints"))
@pytest.mark.parametrize("by", ("by-run", "by-displacement"))
def test_desired_states_one_by_one(by: str, storage: str, flight: Path, searches: dict[str, History], tmp_path: Path) -> None:
    """Forwards and backwards, to the last bit."""
    found = history(flight / f"{by}.toml", tmp_path / "f", trajectory__storage=storage, **FREE, **START)
    assert all(np.array_equal(found[name], searches[by][name]) for name in ("objective", "gradient_norm"))
    calls = manifest(tmp_path / "f")["timings"]["desired state"]["calls"]
    sweeps = found["forward_sweeps"][-1] + found["adjoint_sweeps"][-1] - 2  # the Hessian product at the start asks for none
    assert calls > 30 * sweeps > 0


def test_other_steps_and_an_earlier_end(flight: Path, tmp_path: Path) -> None:
    by_run, by_displacement = (history(flight / f"{by}.toml", tmp_path / by, time__end=0.3, time__step=0.01, **FREE, **START)
                               for by in ("by-run", "by-displacement"))  # fmt: skip
    same(by_run, by_displacement, ROUNDING)
    assert manifest(tmp_path / "by-run")["timings"]["desired state"]["calls"] == 1
