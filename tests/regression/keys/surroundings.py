# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of Rayleigh damping, foundations and forces at points: the effect of each on the unit square is that of docs/reference/keys.md."""

import numpy as np
import pytest
from regression.keys.runs import FREE, Runner, T, near

SHORT = {"time__step": 1e-8, "time__end": 1e-8}  # so short that the velocity is still the initial one, but for 1e-6 of it
ELASTIC = {"material__viscosity": {"bulk": 0, "shear": 0}}
YOUNG, POISSON, STEP = 50.0, 0.3, 0.02  # of the block
MU = YOUNG / (2 * (1 + POISSON))
LAMBDA = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))


@pytest.mark.key("material.rayleigh.alpha")
def test_mass_damping_slows_a_flight(simulate: Runner) -> None:
    """The midpoint rule's solution of v' = -alpha v, and the energy that the account loses."""
    alpha = 0.8
    done = simulate(material__rayleigh={"alpha": alpha}, **ELASTIC, **FREE | {"initial__velocity": ["0.6", "0.8"]})
    factor = (1 - alpha * STEP / 2) / (1 + alpha * STEP / 2)
    near(done.steps["kinetic_energy"], 0.5 * factor ** (2 * done.steps["step"]))
    near(done.steps["drag_dissipation"].sum(), 0.5 - done.steps["kinetic_energy"][-1])
    assert np.max(abs(done.steps["viscous_dissipation"])) < 1e-13
    assert done.manifest["effects"]["mass damping"] and "mass damping" in done.stdout


@pytest.mark.key("material.rayleigh.beta")
@pytest.mark.parametrize("velocity, stiffness", (
    pytest.param(["x", "y"], 4 * LAMBDA + 4 * MU, id="swells"),
    pytest.param(["y", "0"], MU, id="shears"),
))  # fmt: skip
def test_stiffness_damping(velocity: list[str], stiffness: float, simulate: Runner) -> None:
    done = simulate(material__rayleigh={"beta": 1e-3}, **ELASTIC, **SHORT, **FREE | {"initial__velocity": velocity})
    near(done.steps["viscous_dissipation"][1] / 1e-8, 1e-3 * stiffness, 1e-5)


@pytest.mark.key("foundation.on", "foundation.stiffness.normal", "foundation.stiffness.tangential")
@pytest.mark.parametrize("on, energy", (("top", (7 * 0.2**2 + 3 * 0.1**2) / 2), ("left", (7 * 0.1**2 + 3 * 0.2**2) / 2)))
def test_springs(on: str, energy: float, simulate: Runner) -> None:
    """Their energy where the block is moved by (0.1, 0.2) without strain."""
    done = simulate(foundation=[{"on": on, "stiffness": {"normal": 7, "tangential": 3}}],
                    **FREE | {"initial__displacement": ["0.1", "0.2"]})  # fmt: skip
    near(done.steps["foundation_energy"][0], energy)
    assert abs(done.steps["elastic_energy"][0]) < 1e-13
    assert done.manifest["energy"]["foundation_at_start"] == done.steps["foundation_energy"][0]


@pytest.mark.key("foundation.damping.normal", "foundation.damping.tangential")
@pytest.mark.parametrize("on, power", (("top", 7 * 0.2**2 + 3 * 0.1**2), ("left", 7 * 0.1**2 + 3 * 0.2**2)))
def test_dashpots(on: str, power: float, simulate: Runner) -> None:
    done = simulate(foundation=[{"on": on, "damping": {"normal": 7, "tangential": 3}}], **SHORT,
                    **FREE | {"initial__velocity": ["0.1", "0.2"]})  # fmt: skip
    near(done.steps["foundation_dissipation"][1] / 1e-8, power, 1e-5)


@pytest.mark.key("foundation.absorbing")
def test_absorbing(simulate: Runner) -> None:
    """Its dashpots are the impedances of pressure and shear waves; the density is 1."""
    done = simulate(foundation=[{"on": "top", "absorbing": True}], **SHORT, **FREE | {"initial__velocity": ["0.1", "0.2"]})
    near(done.steps["foundation_dissipation"][1] / 1e-8, np.sqrt(LAMBDA + 2 * MU) * 0.2**2 + np.sqrt(MU) * 0.1**2, 1e-5)


@pytest.mark.key("load.point.at", "load.point.value")
@pytest.mark.parametrize("at", ([1, 1], [0, 0.5]))
def test_force_at_a_point(at: list[float], simulate: Runner) -> None:
    done = simulate(load__point=[{"at": at, "value": ["0.3", "2*t"]}], **FREE)
    near(done.momentum(), [0.3 * T, T**2])
    moved = np.linalg.norm(done.field("displacement")[1], axis=1)
    near(done.points[np.argmax(moved)][:2], at, 1e-9)  # as gmsh rounds; the loaded node moves most at first
    assert any(warning["name"] == "force at a point" for warning in done.manifest["warnings"])
