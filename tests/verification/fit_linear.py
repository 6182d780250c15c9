# SPDX-License-Identifier: GPL-3.0-or-later
"""A fit of data that are linear in the unknowns is linear least squares: every number of its outcome, and of its page."""

import base64
import functools
import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import as_package  # noqa: F401
import numpy as np
import pytest
from fit_runs import check_printed
from harness import SOURCE, signorini, table
from recomputed import near
from signorini.post import report_fit
from signorini.post.run_folder import RunFolder

FALLING = f"""
[mesh]
file = "{SOURCE / "meshes" / "block.geo"}"
size = 0.5
[time]
end = 1.0
step = 0.1
[material]
density = 2.0
young = 1e3
poisson = 0.3
[load]
traction = [
  {{ on = "top", value = ["0", "3"] }}, {{ on = "top", value = ["0", "5"] }},
  {{ on = "bottom", value = ["0", "-2"] }}, {{ on = "bottom", value = ["0", "1"] }},
]
body = ["-1", "0"]
[initial]
velocity = ["0.4", "0.7"]
[output]
fields = []
[[unknown]]
of = "initial.velocity"
name = "throw"
start = 1.3
[[unknown]]
of = "load.body"
name = "weight"
start = 0.6
prior = {{ mean = 0.9, deviation = 0.2 }}
[[unknown]]
of = "load.traction"
on = "top"
name = "pull"
start = 1.1
prior = {{ mean = 1.2, deviation = 0.05 }}
[[measurement]]
of = "displacement"
component = "x"
on = "body"
name = "drift"
column = "x"
file = "fall.csv"
[[measurement]]
of = "displacement"
component = "y"
on = "body"
name = "fall"
column = "y"
file = "fall.csv"
"""  # of the body's mean, which moves as a mass point: its data are linear in all unknowns
START = np.array([1.3, 0.6, 1.1])
TIMES = np.array([0.1, 0.35, 0.5, 0.8, 0.95, 1.0])


@dataclass
class Fit:
    """A run, and the linear least squares that it solves: rows·θ = right, in units of their deviations."""

    scale: str
    out: Path
    first: Path  # a run without an iteration
    printed: str
    rows: np.ndarray
    right: np.ndarray
    solution: np.ndarray
    covariance: np.ndarray
    residuals: np.ndarray  # of the data, in deviations

    def json(self) -> dict:
        return json.loads((self.out / "run.json").read_text())

    def deviations(self) -> np.ndarray:
        return np.sqrt(np.diag(self.covariance))

    def correlations(self) -> np.ndarray:
        return self.covariance / np.outer(self.deviations(), self.deviations())


def least_squares(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Writes noisy data into the folder; their rows and right hand sides, and two of the priors."""
    rng = np.random.default_rng(1)
    # Trapezoids are exact at the ends of steps; between them the data are of the chords.
    ends, deviation = np.arange(11) / 10, rng.uniform(0.01, 0.05, len(TIMES))
    thrown, pushed = np.interp(TIMES, ends, ends), np.interp(TIMES, ends, ends**2 / 4)  # by a speed of 1, and a force of 1 on a mass of 2
    zero = np.zeros(len(TIMES))
    A = np.vstack([np.column_stack([0.4 * thrown, -pushed, zero]), np.column_stack([0.7 * thrown, zero, 8 * pushed])])
    rest = np.append(zero, -pushed)  # of the tractions below, which are known
    data = rest + A @ [1.0, 0.8, 1.15] + np.tile(deviation, 2) * rng.standard_normal(len(A))
    lines = zip(TIMES.tolist(), *data.reshape(2, -1).tolist(), deviation.tolist())
    (folder / "fall.csv").write_text("time,x,y,deviation\n" + "".join(",".join(map(repr, row)) + "\n" for row in lines))
    deviation = np.tile(deviation, 2)
    rows = np.vstack([A / deviation[:, None], [0, 1 / 0.2, 0], [0, 0, 1 / 0.05]])
    return rows, np.append((data - rest) / deviation, [0.9 / 0.2, 1.2 / 0.05])


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Fit]:
    """The fit by its scale; each is computed once."""

    @functools.cache
    def fit(scale: str) -> Fit:
        folder = tmp_path_factory.mktemp(scale)
        file, out, first = (folder / name for name in ("falling.toml", "fit", "first"))
        rows, right = least_squares(folder)
        if scale == "log":  # whose priors are of logarithms: not linear, and left out
            rows, right = rows[:-2], right[:-2]
        file.write_text(FALLING if scale == "linear" else re.sub(r"prior = .*\n", "", FALLING))
        scales = {f"unknown__{j}__scale": scale for j in range(3)}
        done = signorini("optimize", file, out, optimizer__method="gauss-newton", optimizer__tolerance=1e-9, **scales)
        signorini("optimize", file, first, optimizer__max_iterations=0, **scales)
        solution = np.linalg.lstsq(rows, right, rcond=None)[0]
        residuals = (rows @ solution - right)[: 2 * len(TIMES)]
        return Fit(scale, out, first, done.stdout, rows, right, solution, np.linalg.inv(rows.T @ rows), residuals)

    return fit


@pytest.fixture(params=("linear", "log"))
def fit(fits: Callable, request: pytest.FixtureRequest) -> Fit:
    return fits(request.param)


def test_printed(fit: Fit) -> None:
    check_printed(fit.out, fit.printed)


def test_values(fit: Fit) -> None:
    near("values", table(fit.out / "parameters.csv")["value"], fit.solution, 1e-7)


def test_deviations(fit: Fit) -> None:
    near("deviations", table(fit.out / "parameters.csv")["standard_deviation"], fit.deviations(), 1e-7)


def test_gradient_at_the_start(fit: Fit) -> None:
    near("gradient", table(fit.first / "parameters.csv")["gradient"], fit.rows.T @ (fit.rows @ START - fit.right), 1e-9)


def test_ends_of_the_logarithmic_scale(fits: Callable) -> None:
    """They are where rounding alone is left of J's curvature."""
    found = table(fits("log").out / "parameters.csv")
    near("ends", [found["lower"] / found["start"], found["start"] / found["upper"]], np.full((2, 3), 2.0**-26), 1e-9)


def test_singular_values(fit: Fit) -> None:
    columns = fit.rows * (fit.solution if fit.scale == "log" else 1)
    near("singular values", fit.json()["fit"]["singular_values"], np.linalg.svd(columns / np.linalg.norm(columns, axis=0))[1], 1e-6)


def test_correlations(fit: Fit) -> None:
    near("correlations", fit.json()["fit"]["correlations"], fit.correlations(), 1e-6)
    one, other = np.unravel_index(np.abs(np.triu(fit.correlations(), 1)).argmax(), (3, 3))
    name = table(fit.out / "parameters.csv")["name"]
    assert (one, other) != (0, 1)
    assert f"largest correlation: {fit.correlations()[one, other]:+.2f}, of {name[one]} and {name[other]}" in fit.printed


def test_residuals(fit: Fit) -> None:
    near("residuals", table(fit.out / "measurements.csv")["residual"], fit.residuals, 1e-6)
    r = fit.rows @ fit.solution - fit.right
    near("J", fit.json()["fit"]["objective"], r @ r / 2, 1e-9)
    near("misfit", fit.json()["fit"]["misfit"], np.sqrt(np.mean(fit.residuals**2)), 1e-9)


def test_decrement_at_the_start(fits: Callable) -> None:
    fit = fits("linear")
    away = fit.rows @ (START - fit.solution)  # J is quadratic, so that the decrement is this length
    near("decrement", table(fit.out / "history.csv")["decrement"][0], np.linalg.norm(away), 1e-9)


def test_sweeps(fit: Fit) -> None:
    """A motion and three linearised ones an iterate: no trial of a linear problem fails."""
    search, sweeps = fit.json()["optimizer"], table(fit.out / "history.csv")["forward_sweeps"]
    assert search["forward_sweeps"] == sweeps[-1]
    if fit.scale == "linear":
        assert list(sweeps) == [4 * (k + 1) for k in range(len(sweeps))]
        assert search["adjoint_sweeps"] == 0


# --- The page ---------------------------------------------------------------------------------------------------------


def drawn(values: dict) -> np.ndarray:
    return np.frombuffer(base64.b64decode(values["bdata"]), "<f4").astype(float)


def test_ellipses(fit: Fit) -> None:
    views = report_fit.confidence(RunFolder(fit.out)).views
    assert len(views) == 3
    for (i, j), view in zip(((0, 1), (0, 2), (1, 2)), views.values()):
        inverse = np.linalg.inv(fit.covariance[np.ix_([i, j], [i, j])])
        # A part 1 − exp(−q/2) of a normal distribution in the plane is within the ellipse x·C⁻¹x = q.
        for curve, part in zip(view["data"], (1 - np.exp(-0.5), 0.95), strict=False):
            offset = np.column_stack([drawn(curve[axis]) - fit.solution[k] for axis, k in (("x", i), ("y", j))])
            q = np.einsum("ki,ij,kj->k", offset, inverse, offset)
            near(f"ellipse of {part:.2f}, {i} and {j}", q, np.full_like(q, -2 * np.log(1 - part)), 2e-3)  # of single precision, and 5.991
            assert np.ptp(offset[:, 0]) > 0 and np.ptp(offset[:, 1]) > 0
        near("its centre", np.concatenate([drawn(view["data"][2][axis]) for axis in "xy"]), fit.solution[[i, j]], 1e-6)


@pytest.mark.parametrize("number, name", enumerate(("drift", "fall")))
def test_residuals_drawn(fit: Fit, number: int, name: str) -> None:
    dots = report_fit.residuals(RunFolder(fit.out)).views[name]["data"][0]
    near("residuals", drawn(dots["y"]), fit.residuals.reshape(2, -1)[number], 1e-5)
    near("their times", drawn(dots["x"]), TIMES, 1e-6)


@pytest.mark.parametrize("name", ("drift", "fall"))
def test_data_drawn(fit: Fit, name: str) -> None:
    measured = table(fit.out / "measurements.csv")
    curves = {one["name"]: drawn(one["y"]) for one in report_fit.compared(RunFolder(fit.out)).views[name]["data"]}
    value, simulated, deviation = (measured[key][measured["measurement"] == name] for key in ("value", "simulated", "deviation"))
    near("measured", curves["measured"], value, 1e-6)
    near("simulated", curves["simulated"], simulated, 1e-6)
    near("band", curves["±2 deviations"], np.concatenate([simulated + 2 * deviation, (simulated - 2 * deviation)[::-1]]), 1e-6)


def test_table_of_unknowns(fit: Fit) -> None:
    cells, found = report_fit.unknowns(RunFolder(fit.out)).rows, table(fit.out / "parameters.csv")
    assert [float(row[1]) for row in cells] == [float(f"{value:.6g}") for value in found["value"]]
    assert [float(row[2]) for row in cells] == [float(f"{value:.3g}") for value in found["standard_deviation"]]
