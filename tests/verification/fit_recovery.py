# SPDX-License-Identifier: GPL-3.0-or-later
"""Parameters that come back: without noise exactly, from noisy data within their deviations, from an exact solution with the mesh."""

import functools
import subprocess
import time
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pytest
from fit_runs import check_printed, fitted, measure, not_resumed, resume, settings
from harness import SIGNORINI, SOURCE, captured, signorini, table

MADE = ("drop-test", "find-the-wall", "sliding-block", "two-materials")  # scenes whose data a simulation made
TRUE = {"young": 2e6, "shear viscosity": 100.0, "height": 0.0, "angle": 0.0, "core": 2e7, "matrix": 2e6, "friction": 0.3, "speed": 1.0}
SIZE = {"height": 1e-3, "angle": 0.035}  # of unknowns whose true value is zero


@dataclass
class Fit:
    file: Path  # the scene
    data: dict[str, object]  # overrides by which its data are without noise
    out: Path
    printed: str


def shipped(name: str) -> Path:
    return SOURCE / "scenes" / f"{name}.toml"


def data_in(folder: Path, name: str) -> dict[str, object]:
    """Overrides by which a scene's data are in a folder."""
    return {f"measurement__{i}__file": str(folder / f"{name}.csv") for i in range(shipped(name).read_text().count("[[measurement]]"))}


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, int], Fit]:
    """Fits to data without noise, by scene and number of ranks; each is computed once."""

    @functools.cache
    def data(name: str) -> dict[str, object]:
        folder = tmp_path_factory.mktemp("data")
        measure(shipped(name), folder / "made", data_in(folder, name))
        return data_in(folder, name)

    @functools.cache
    def fit(name: str, ranks: int) -> Fit:
        out = tmp_path_factory.mktemp("fit")
        return Fit(shipped(name), data(name), out, signorini("optimize", shipped(name), out, ranks, **data(name)).stdout)

    return fit


@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("name", MADE)
def test_comes_back(fits: Callable, name: str, ranks: int) -> None:
    fit = fits(name, ranks)
    iterations = len(table(fit.out / "history.csv")["iteration"]) - 1
    worst = np.max([abs(value - TRUE[key]) / (SIZE.get(key) or TRUE[key]) for key, (value, _) in fitted(fit.out).items()])
    print(f"{iterations} iterations, worst error {worst:.1e}")
    assert worst <= 1e-6 and iterations <= 15, fit.printed
    check_printed(fit.out, fit.printed)


@pytest.mark.parametrize("ranks", (1, 2))
def test_plane_is_drawn_where_it_was_found(fits: Callable, ranks: int) -> None:
    """The surface that pages and films show is shifted along its normal, then turned."""
    out = fits("find-the-wall", ranks).out
    found, run = fitted(out), tomllib.loads((out / "scene.toml").read_text())
    given = run["contact"]["obstacle"]
    normal = np.array(given["normal"]) / np.linalg.norm(given["normal"])
    c, s = np.cos(found["angle"][0]), np.sin(found["angle"][0])
    with h5py.File(out / "surfaces.h5") as file:
        points = file["1/points"][()]
        assert np.abs(file["1/normal"][()] - [c * normal[0] - s * normal[1], s * normal[0] + c * normal[1]]).max() < 1e-12
    off = (points - np.array(given["point"]) - found["height"][0] * normal) @ [c * normal[0] - s * normal[1], s * normal[0] + c * normal[1]]
    assert len(points) == 2 and np.abs(off).max() < 1e-12


def test_iterates_are_shown_meanwhile(fits: Callable, tmp_path: Path) -> None:
    """history.csv has the iterates so far while the fit runs."""
    fit = fits(MADE[0], 1)
    process = subprocess.Popen([str(SIGNORINI), "optimize", str(fit.file), "--out", str(tmp_path), "--quiet", *settings(fit.data)])
    seen = 0
    while process.poll() is None and seen < 2:
        time.sleep(0.01)
        if (tmp_path / "history.csv").is_file():
            seen = len((tmp_path / "history.csv").read_text().splitlines()) - 1
    unfinished = not (tmp_path / "run.json").exists()
    assert process.wait(300) == 0 and seen >= 2 and unfinished


@pytest.mark.parametrize("name", MADE)
def test_resumed(fits: Callable, name: str, tmp_path: Path) -> None:
    """A fit that was stopped after two iterations continues to the same end by the same iterates; another problem is refused."""
    fit = fits(name, 1)
    signorini("optimize", fit.file, tmp_path, optimizer__max_iterations=2, **fit.data)
    lower = {"find-the-wall": -1e3, "sliding-block": 1e-3}.get(name, 1.0)  # on which J at the last iterate does not depend
    bound = {"unknown__0__lower": lower}
    not_resumed(fit.file, tmp_path, fit.data | bound, "unknown[0].lower")
    resume(fit.file, tmp_path, fit.data | {"output__fields": []}, 2)  # what is written makes no other problem
    whole, parts = (table(out / "history.csv") for out in (fit.out, tmp_path))
    assert len(whole["iteration"]) == len(parts["iteration"])
    assert whole["objective"][:4] == pytest.approx(parts["objective"][:4], rel=1e-6, abs=0)


@pytest.mark.parametrize("name", MADE)
def test_shipped_data(name: str, tmp_path: Path) -> None:
    """Noisy data give the parameters within three of their deviations."""
    signorini("optimize", shipped(name), tmp_path)
    for key, (value, deviation) in fitted(tmp_path).items():
        print(f"{key}: {value:.6g} +- {deviation:.2g}, off by {(value - TRUE[key]) / deviation:+.2f} deviations")
        assert abs(value - TRUE[key]) <= 3 * deviation, key


@pytest.mark.long
@pytest.mark.parametrize("name", MADE)
def test_noise(name: str, tmp_path: Path) -> None:
    """Over 40 seeds, the squares of the errors in reported standard deviations sum up as χ² of 40 does.

    Deviations of half or twice the right size fail.
    """
    seeds, least, most = 40, 16.9, 76.1  # but for 1 in 2000 above and below
    squares: dict[str, float] = {}
    overrides = {"output__fields": []} | data_in(tmp_path, name)
    for seed in range(1, seeds + 1):
        measure(shipped(name), tmp_path / "simulate", overrides, seed)
        done = captured([str(SIGNORINI), "optimize", str(shipped(name)), "--out", str(tmp_path / "fit"), "--quiet", *settings(overrides)])
        assert done.returncode == 0, done.stdout + done.stderr
        for key, (value, deviation) in fitted(tmp_path / "fit").items():
            squares[key] = squares.get(key, 0) + ((value - TRUE[key]) / deviation) ** 2
    print(f"sums of {seeds} squares: {squares}")
    assert all(least <= total <= most for total in squares.values())


def test_exact_solution_of_a_bar(tmp_path: Path) -> None:
    """From the exact solution of its impact E and the speed come back with the error of the discretisation, which falls with it."""
    errors = []
    for size, step in ((0.5, 1 / 120), (0.25, 1 / 240), (0.125, 1 / 480)):
        out = tmp_path / f"{size}"
        signorini("optimize", shipped("bar-speed"), out, mesh__size=size, time__step=step)
        found = fitted(out)
        errors.append([abs(found["young"][0] / 900 - 1), abs(found["speed"][0] / -10 - 1)])
        print(f"size {size} m: E off by {errors[-1][0]:.2e}, speed by {errors[-1][1]:.2e}; "
              f"{len(table(out / 'history.csv')['iteration']) - 1} iterations")  # fmt: skip
    print(f"orders: {np.log2(np.array(errors[:-1]) / errors[1:]).round(2).tolist()}")
    assert np.all(np.array(errors[-1]) < 0.02) and np.all(np.array(errors[-1]) < np.array(errors[0]) / 2)
