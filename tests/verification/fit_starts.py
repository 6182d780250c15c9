# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits on logarithmic scales find their minimum from first guesses far away, or end at a bound, or are warned of."""

import itertools
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fit_runs import fitted, measure
from harness import SOURCE, signorini, table

SINKING = f"""
[mesh]
file = "{SOURCE / "tests" / "data" / "square.geo"}"
size = 0.5
[time]
end = 0.2
step = 0.01
scheme = "contact-stabilized"
[material]
density = 1.0
young = 1000.0
poisson = 0.3
viscosity = {{ bulk = 1.0, shear = 1.0 }}
[load]
body = ["0", "-1"]
[initial]
velocity = ["0", "-1"]
[contact]
on = "bottom"
obstacle = {{ shape = "half-space", point = [0, -0.05], normal = [0, 1] }}
[output]
fields = []
[[unknown]]
of = "young"
start = 1000.0
[[unknown]]
of = "bulk"
start = 1.0
[[measurement]]
of = "displacement"
component = "y"
point = [0.5, 1]
file = "top.csv"
deviation = 1e-3
"""


def sinking(folder: Path, overrides: dict, seed: int = 0) -> Path:
    """The scene, with its data measured in a run."""
    (folder / "sinking.toml").write_text(SINKING)
    measure(folder / "sinking.toml", folder / "made", overrides, seed)
    return folder / "sinking.toml"


def summary(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


@pytest.fixture(scope="module")
def noisy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return sinking(tmp_path_factory.mktemp("noisy"), {}, seed=1)


@pytest.fixture(scope="module")
def minimum(noisy: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The fit on linear scales from the true parameters."""
    out = tmp_path_factory.mktemp("plain")
    signorini("optimize", noisy, out, unknown__0__scale="linear", unknown__1__scale="linear")
    bulk, deviation = fitted(out)["bulk"]
    assert 0.1 < deviation < bulk < 10
    return out


@pytest.mark.parametrize("bulk", (0.1, 1.0, 10.0))
@pytest.mark.parametrize("young", 300 * 10 ** (0.2 * np.arange(6)), ids="{:.0f}".format)
def test_minimum_is_found(noisy: Path, minimum: Path, young: float, bulk: float, tmp_path: Path) -> None:
    """From 18 first guesses over a decade of the modulus and two of a viscosity."""
    done = signorini("optimize", noisy, tmp_path, unknown__0__start=young, unknown__1__start=bulk)
    assert "decrement below tolerance" in done.stdout and "nan" not in done.stdout
    assert summary(tmp_path)["fit"]["objective"] == pytest.approx(summary(minimum)["fit"]["objective"], rel=1e-9, abs=0)
    iterates = table(tmp_path / "history.csv")
    for name in ("young", "bulk"):
        (found, found_deviation), (value, deviation) = fitted(tmp_path)[name], fitted(minimum)[name]
        assert found == pytest.approx(value, rel=1e-5, abs=0), name
        assert found_deviation == pytest.approx(deviation, rel=1e-4, abs=0), name
        assert np.max(np.abs(np.diff(np.log(iterates[name])))) <= 1 + 1e-12, "a step beyond what its linearisation covers"


def test_end_of_the_scale_is_a_bound(tmp_path: Path) -> None:
    """Data of less viscosity than the scene's shear alone has: bulk falls to the end of its scale."""
    file = sinking(tmp_path, {"material__viscosity__bulk": 0.0, "material__viscosity__shear": 0.5})
    signorini("optimize", file, tmp_path / "plain", unknown__1__scale="linear", unknown__1__start=0.1)
    done = signorini("optimize", file, tmp_path / "log", unknown__1__start=0.1)
    none, small = (table(tmp_path / one / "parameters.csv") for one in ("plain", "log"))
    assert none["value"][1] == 0 and none["at_bound"][1] == small["at_bound"][1] == 1 and none["gradient"][1] > 0
    assert small["value"][1] == small["lower"][1] == pytest.approx(0.1 * 2**-26, rel=1e-12, abs=0)
    assert small["value"][0] == pytest.approx(none["value"][0], rel=1e-6, abs=0)
    assert small["standard_deviation"][1] == pytest.approx(none["standard_deviation"][1], rel=1e-5, abs=0)
    assert small["gradient"][1] == pytest.approx(none["gradient"][1], rel=1e-5, abs=0)
    assert "decrement below tolerance" in done.stdout and "bulk fell to the lower end of its logarithmic scale" in done.stdout


def test_another_minimum_is_warned_of(tmp_path: Path) -> None:
    """A first guess 300 times too stiff ends in one that does not explain the data."""
    done = signorini("optimize", sinking(tmp_path, {}), tmp_path / "far", unknown__0__start=1e5, unknown__1__start=100.0)
    fit, warnings = (summary(tmp_path / "far")[name] for name in ("fit", "warnings"))
    assert fit["misfit"] > 2 and "warning: the residuals are" in done.stdout
    assert warnings[-1]["name"] == "misfit of the data" and warnings[-1]["value"] == fit["misfit"]
