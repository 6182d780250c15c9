# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of Prony series: the effect of each on the unit square is that of docs/reference/keys.md."""

import numpy as np
import pytest
from regression.keys.runs import FREE, Runner, near

YOUNG, POISSON = 50.0, 0.3  # of the block
BULK, SHEAR = YOUNG / (3 * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))
STEP = 1e-8  # s, so short that the velocity is still the initial one, but for 1e-6 of it
SHORT = {"time__step": STEP, "time__end": STEP, "material__viscosity": {"bulk": 0, "shear": 0}}
SERIES = [{"g": 0.3, "k": 0.1, "time": 0.01}, {"g": 0.2, "k": 0.15, "time": 0.2}]


@pytest.mark.key("material.moduli", "material.prony.g", "material.prony.k")
@pytest.mark.parametrize("moduli, bulk, shear", (
    pytest.param({}, 0.75 * BULK, 0.5 * SHEAR, id="instantaneous by default"),
    pytest.param({"material__moduli": "instantaneous"}, 0.75 * BULK, 0.5 * SHEAR, id="instantaneous"),
    pytest.param({"material__moduli": "long-term"}, BULK, SHEAR, id="long-term"),
))  # fmt: skip
def test_relaxed_elasticity(moduli: dict[str, str], bulk: float, shear: float, simulate: Runner) -> None:
    """The body is relaxed at first: its energy is that of the long-term moduli."""
    done = simulate(material__prony=SERIES, **moduli, **FREE | {"initial__displacement": ["0", "0.1*y"]})
    near(done.steps["elastic_energy"][0], (bulk + 4 / 3 * shear) / 2 * 0.1**2)
    assert done.steps["relaxation_energy"][0] == 0 < done.steps["relaxation_energy"][-1]
    assert done.manifest["effects"]["relaxation"] and "relaxation" in done.stdout


@pytest.mark.key("material.prony.g", "material.prony.k", "material.prony.time")
@pytest.mark.parametrize("series", (SERIES[:1], SERIES[1:], SERIES, [{"g": 0.4, "time": 0.05}], [{"k": 0.4, "time": 0.05}]), ids=str)
@pytest.mark.parametrize("velocity, bulk, shear", (
    pytest.param(["x", "y"], 4, 4 / 3, id="swells"),
    pytest.param(["y", "0"], 0, 1, id="shears"),
))  # fmt: skip
def test_branches(series: list[dict[str, float]], velocity: list[str], bulk: float, shear: float, simulate: Runner) -> None:
    """After one short step q = STEP v in each branch, from 0: its energy, and what its dashpot dissipates meanwhile."""
    done = simulate(material__prony=series, **SHORT, **FREE | {"initial__velocity": velocity})
    stiffness = np.array([bulk * BULK * one.get("k", 0) + shear * SHEAR * one.get("g", 0) for one in series])
    times = np.array([one["time"] for one in series])
    near(done.steps["relaxation_energy"][1] / STEP**2, stiffness.sum() / 2, 1e-5)
    near(done.steps["relaxation_dissipation"][1] / STEP**3, (stiffness / times).sum() / 4, 1e-5)


@pytest.mark.key("material.moduli", "material.prony.g", "material.prony.k")
def test_waves_at_the_instant_of_loading(simulate: Runner) -> None:
    """The density is 1."""
    for moduli, bulk, shear in (("instantaneous", BULK, SHEAR), ("long-term", BULK / 0.75, SHEAR / 0.5)):
        body = simulate(material__prony=SERIES, material__moduli=moduli, **SHORT, **FREE).manifest["body"]
        near(body["pressure_waves"], np.full(2, np.sqrt(bulk + 4 / 3 * shear)))
        near(body["shear_waves"], np.full(2, np.sqrt(shear)))
