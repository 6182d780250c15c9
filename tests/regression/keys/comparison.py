# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of what a motion is compared with, exact values in a study and measurements in a fit, and of what is fitted: the effect of
each on a small scene is that of docs/reference/keys.md."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import signorini, table
from regression.keys.runs import COARSE, CORE, STIFF, Run, Runner, edited, near, optimize_in, simulate_in

Columns = dict[str, np.ndarray]


@pytest.fixture
def study(tmp_path: Path) -> Callable[..., Columns]:
    """Columns of study.csv of the block without an objective, thrown onto its plane; its default steps and sizes."""
    scene = edited(tmp_path / "study.toml", (r"(?s)\[control\].*", ""))

    def study(name: str, **overrides: object) -> Columns:
        signorini("study", scene, tmp_path / name, **overrides)
        return table(tmp_path / name / "study.csv")

    return study


@pytest.mark.key("exact.displacement")
@pytest.mark.parametrize("exact, error", ((["0", "-t"], 0), (["0", "-2*t"], 0.5)), ids=str)
def test_exact_displacement(exact: list[str], error: float, study: Callable[..., Columns]) -> None:
    found = study("free", contact__obstacle__point=[0, -100], load__body=["0", "0"], exact__displacement=exact)
    assert abs(found["displacement_error"] - error).max() < 1e-9


@pytest.mark.key("exact.impulse", "exact.peak_force", "exact.contact_start", "exact.contact_time")
@pytest.mark.parametrize("name", ("impulse", "peak_force", "contact_start", "contact_time"))
def test_exact_number(name: str, study: Callable[..., Columns]) -> None:
    known = study("known", **{f"exact__{name}": 0.125})
    assert np.min(known[name]) > 0
    near(known[f"{name}_error"], abs(known[name] / 0.125 - 1), 1e-9)


@pytest.mark.key("exact.pressure")
def test_exact_pressure(study: Callable[..., Columns]) -> None:
    small, large = (study(value, exact__pressure=value)["pressure_error"] for value in ("0.1", "1e9"))
    assert abs(large - 1).max() < 1e-6 and np.min(small) > 0 and abs(small - 1).max() > 1e-3


PROBES = [{"name": "top", "point": [0, 0.1]}, {"name": "sides", "on": "surface"}, {"name": "floor", "obstacle": "floor"}]
TOP = {"point": [0, 0.1]}
Measured = Callable[..., dict]


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the core's scene gives, as data: columns by probe and quantity."""
    return simulate_in(tmp_path_factory.mktemp("data"), CORE, **COARSE, output__probe=PROBES).folder / "probes.csv"


@pytest.fixture
def measured(data: Path) -> Measured:
    """One measurement from these data."""

    def measured(of: str = "displacement", column: str = "top.displacement_y", **more: object) -> dict:
        return {"of": of, "component": "y", "file": str(data), "column": column} | ({} if "noise" in more else {"deviation": 1.0}) | more

    return measured


@pytest.fixture
def fit(tmp_path: Path, measured: Measured) -> Runner:
    def fit(unknown: list[dict] | None = None, measurement: list[dict] | None = None, iterations: int = 0, **overrides: object) -> Run:
        given = {"unknown": unknown or [STIFF], "measurement": measurement or [measured(**TOP)]}
        return optimize_in(tmp_path, CORE, iterations, **COARSE, **given, **overrides)

    return fit


def parameters(done: Run) -> Columns:
    return table(done.folder / "parameters.csv")


def measurements(done: Run) -> Columns:
    return table(done.folder / "measurements.csv")


TRUE = [STIFF | {"start": 2e7}]


@pytest.mark.key("measurement.of", "measurement.point", "measurement.on", "measurement.component", "measurement.file", "measurement.column")
@pytest.mark.parametrize("of, column, where", (
    ("displacement", "top.displacement_y", TOP),
    ("velocity", "top.velocity_x", TOP | {"component": "x"}),
    ("displacement", "sides.displacement_y", {"on": "surface"}),
    ("velocity", "sides.velocity_y", {"on": "surface"}),
    ("impulse", "floor.impulse_y", {}),
), ids=str)  # fmt: skip
def test_measured_as_probes(of: str, column: str, where: dict[str, object], data: Path, measured: Measured, fit: Runner) -> None:
    """At the true values data that are a probe's leave nothing."""
    scale = abs(table(data)[column]).max()
    assert abs(measurements(fit(TRUE, [measured(of, column, **where)]))["residual"]).max() < 1e-9 * scale


@pytest.mark.key("measurement.component", "measurement.column")
def test_measured_as_another_component(measured: Measured, fit: Runner) -> None:
    assert abs(measurements(fit(TRUE, [measured(column="top.displacement_x", **TOP)]))["residual"]).max() > 1e-4


@pytest.mark.key("measurement.obstacle")
def test_measured_obstacle(measured: Measured, fit: Runner) -> None:
    """The force of each of two obstacles is its own: one is never touched."""
    wall = {"on": "surface", "obstacle": {"name": "wall", "shape": "half-space", "point": [9, 0], "normal": [-1, 0]}}
    floor = {"on": "bottom", "obstacle": {"name": "floor", "shape": "half-space", "point": [0, -0.001], "normal": [0, 1]}}
    runs = [fit(measurement=[measured("force", "floor.force_y", obstacle=name)], contact=[floor, wall]) for name in ("floor", "wall")]
    on_floor, on_wall = (measurements(done)["simulated"] for done in runs)
    assert abs(on_floor).max() > 100 and not on_wall.any()


@pytest.mark.key("measurement.name", "measurement.deviation")
def test_measured_deviation(measured: Measured, fit: Runner) -> None:
    known = measurements(fit(measurement=[measured(deviation=0.5, name="crown", **TOP)]))
    assert set(known["measurement"]) == {"crown"}
    near(known["residual"], 2 * measurements(fit())["residual"])


@pytest.mark.key("measurement.noise")
def test_measured_noise(data: Path, measured: Measured, fit: Runner) -> None:
    deviation = measurements(fit(measurement=[measured(noise=0.1, **TOP)]))["deviation"]
    near(deviation, np.full_like(deviation, 0.1 * abs(table(data)["top.displacement_y"]).max()))


@pytest.mark.key("measurement.value")
def test_measured_numbers(measured: Measured, fit: Runner) -> None:
    figures = [{"of": "contact-start", "value": 1e-3, "deviation": 1e-4}, {"of": "impulse-duration", "value": 1e-3},
               {"of": "sustained-peak", "value": 10.0}]  # fmt: skip
    done = fit(measurement=[measured(**TOP), *figures])
    found, duration, peak = done.manifest["fit"]["contact_times"]
    assert found["value"] == 1e-3 and abs(found["simulated"] - 1e-3) < 1e-4 and "measured 0.001 s" in done.stdout
    touch = done.manifest["impact"]["all"]
    assert duration["simulated"] == touch["impulse_duration"] > 0 and peak["simulated"] == touch["sustained_peak"] > 0
    assert (duration["unit"], peak["unit"]) == ("s", "N/m") and "measured 10 N/m, simulated" in done.stdout


@pytest.mark.key("unknown.of", "unknown.on", "unknown.name", "unknown.start")
def test_unknowns(fit: Runner) -> None:
    found = parameters(fit([STIFF, {"of": "young", "on": "matrix"}, {"of": "density", "on": "matrix", "name": "rubber's", "start": 1200}]))
    assert list(found["name"]) == ["young of inclusion", "young of matrix", "rubber's"]
    near(found["value"], found["start"])
    assert list(found["start"]) == [3e7, 2e6, 1200] and len(set(found["gradient"])) == 3


@pytest.mark.key("unknown.lower", "unknown.upper")
@pytest.mark.parametrize("bound, value", (("lower", 2.5e7), ("upper", 1.5e7)))
def test_bound_of_an_unknown(bound: str, value: float, fit: Runner) -> None:
    found = parameters(fit([STIFF | {"start": value, bound: value}], iterations=20))
    near(np.array([found["value"][0], found[bound][0]]), np.full(2, value))
    assert found["at_bound"][0] == 1


@pytest.mark.key("unknown.lower", "unknown.upper")
def test_unknown_without_bounds(fit: Runner) -> None:
    assert abs(parameters(fit(iterations=20))["value"][0] / 2e7 - 1) < 1e-4


@pytest.mark.key("unknown.scale", "unknown.prior.mean", "unknown.prior.deviation")
@pytest.mark.parametrize("more, prior", (
    pytest.param({"prior": {"mean": 1e7, "deviation": 0.1}}, (np.log(3) / 0.1) ** 2 / 2, id="logarithmic"),
    pytest.param({"scale": "linear", "prior": {"mean": 1e7, "deviation": 1e7}}, 2.0, id="linear"),
))  # fmt: skip
def test_prior(more: dict[str, object], prior: float, fit: Runner) -> None:
    """A prior adds half the square of its distance in deviations, on the unknown's scale."""
    near(fit([STIFF | more]).history["objective"][0] - fit().history["objective"][0], prior, 1e-9)


@pytest.mark.key("unknown.branch")
def test_unknown_of_a_branch(fit: Runner) -> None:
    series = [{"g": 0.3, "k": 0.1, "time": 1e-3}, {"g": 0.2, "k": 0.05, "time": 4e-3}]
    unknown = [{"of": of, "on": "inclusion", "branch": branch} for of, branch in (("prony.g", 1), ("prony.time", 0), ("prony.k", 0))]
    found = parameters(fit(unknown, material__1__prony=series))
    assert list(found["name"]) == ["prony.g 1 of inclusion", "prony.time 0 of inclusion", "prony.k 0 of inclusion"]
    near(found["value"], [0.2, 1e-3, 0.1])
    assert len(set(found["gradient"])) == 3
    only = parameters(fit([{"of": "prony.time", "on": "inclusion", "start": 2e-3}], material__1__prony=series[:1]))
    assert list(only["name"]) == ["prony.time of inclusion"]
    near(only["value"], [2e-3])


@pytest.mark.key("unknown.component", "unknown.obstacle")
def test_unknown_component_and_obstacle(fit: Runner) -> None:
    found = parameters(fit([{"of": "initial.velocity", "component": "y"}, {"of": "position", "obstacle": "floor"}]))
    assert list(found["name"]) == ["initial.velocity y", "position of floor"] and list(found["value"]) == [-1, 0]
    assert parameters(fit([{"of": "initial.velocity"}]))["value"][0] == 1
