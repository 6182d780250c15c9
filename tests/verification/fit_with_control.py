# SPDX-License-Identifier: GPL-3.0-or-later
"""A control and unknowns sought at once: the gradient of J by both, a search that lowers J, and one that is resumed."""

import functools
import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from fit_runs import EVERY, PLANE, SCHEMES, check_printed, half_space, measure, not_resumed, resume, thrown
from harness import attempt, signorini, table

MASSLESS = SCHEMES["massless"]
CONTROL = """
[[clamp]]
on = "top"
[control]
scale = 1e6
initial = ["0", "-0.3"]
lower = -2.0
[objective]
desired = { control = ["0.1", "-1"] }
alpha = 1e-2
gamma = 7.5e-4
"""


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The scene, with data that a scheme made."""

    @functools.cache
    def file(scheme: str) -> Path:
        folder = tmp_path_factory.mktemp("together")
        text = thrown(2, half_space(2), [EVERY[0], EVERY[4], PLANE[1]], folder)
        # Unclamped bodies are thrown; this one hangs and is pushed.
        text = re.sub(r"displacement = .*\n|velocity = \[.*\n", "", text).replace("[initial]\n", CONTROL)
        (folder / "scene.toml").write_text(text)
        measure(folder / "scene.toml", folder / "made", SCHEMES[scheme])
        return folder / "scene.toml"

    return file


@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("scheme", SCHEMES)
def test_check(measured: Callable, scheme: str, ranks: int) -> None:
    done = attempt("check", measured(scheme), None, ranks, **SCHEMES[scheme])
    assert done.returncode == 0 and "Taylor order by control and unknowns" in done.stdout, done.stdout + done.stderr


@pytest.fixture(scope="module")
def first(measured: Callable, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A search without an iteration."""
    out = tmp_path_factory.mktemp("first")
    signorini("optimize", measured("massless"), out, optimizer__max_iterations=0, **MASSLESS)
    return out


@pytest.mark.parametrize("number, start", ((0, 1.05e8), (1, 1.02)))
def test_gradient_by_an_unknown_is_that_of_all_of_J(measured: Callable, first: Path, number: int, start: float, tmp_path: Path) -> None:
    h, J = 1e-4 * start, []
    for side in (1, -1):
        signorini("optimize", measured("massless"), tmp_path, optimizer__max_iterations=0, **MASSLESS,
                  **{f"unknown__{number}__start": start + side * h})  # fmt: skip
        J.append(table(tmp_path / "history.csv")["objective"][0])
    assert (J[0] - J[1]) / (2 * h) == pytest.approx(table(first / "parameters.csv")["gradient"][number], rel=1e-3, abs=0)


def test_no_decrement(first: Path) -> None:
    assert json.loads((first / "run.json").read_text())["fit"]["decrement"] is None


@pytest.fixture(scope="module")
def whole(measured: Callable, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A search of twelve iterations, and what it prints."""
    out = tmp_path_factory.mktemp("whole")
    done = signorini("optimize", measured("massless"), out, optimizer__max_iterations=12, output__fields=["control", "adjoint"], **MASSLESS)
    return out, done.stdout


def test_printed(whole: tuple[Path, str]) -> None:
    check_printed(*whole)


def test_lowers_J(whole: tuple[Path, str]) -> None:
    J = table(whole[0] / "history.csv")["objective"]
    assert len(J) == 13 and J[-1] < 0.3 * J[0]


@pytest.mark.parametrize("name", ("control.xdmf", "adjoint.xdmf", "parameters.csv", "measurements.csv"))
def test_files(whole: tuple[Path, str], name: str) -> None:
    assert (whole[0] / name).is_file()


def test_resumed(measured: Callable, whole: tuple[Path, str], tmp_path: Path) -> None:
    """A search that was stopped continues as one that was not; another problem is refused."""
    file, out = measured("massless"), tmp_path / "cut"
    signorini("optimize", file, out, optimizer__max_iterations=5, **MASSLESS)
    not_resumed(file, out, MASSLESS | {"objective__gamma": 1e-3}, "objective.gamma")
    not_resumed(file, out, MASSLESS | {"unknown__0__upper": 1e12}, "unknown[0].upper")
    resume(file, out, MASSLESS | {"optimizer__max_iterations": 12, "output__fields": ["displacement"]}, 5)
    expected = table(whole[0] / "history.csv")["objective"]
    assert table(out / "history.csv")["objective"] == pytest.approx(expected, rel=1e-6, abs=0)
