# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that relax (docs/method.md section 1): closed forms, limits, laws of energy and momentum, ranks, stores, restart."""

import json
from pathlib import Path

import numpy as np
import pytest
from fit_runs import SCHEMES
from harness import SIGNORINI, SOURCE, captured, signorini, stored, table, toml
from standard_solid import Solid, at_ends, expression, over_steps, risen

YOUNG, POISSON = 1e3, 0.3
BULK, SHEAR = YOUNG / (3 * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))
RISE = 0.5  # s
ONE = [{"g": 0.5, "k": 0.2, "time": 1.0}]
TWO = [{"g": 0.3, "k": 0.0, "time": 0.2}, {"g": 0.2, "k": 0.4, "time": 2.0}]

# A block that cannot move sideways. Waves cross it within 3e-4 s: its inertia is 1e-7 of what changes within a second.
BLOCK = f"""
[mesh]
file = "{SOURCE / "meshes" / "block.geo"}"
size = 0.5
[time]
end = 4.0
step = 0.1
[material]
density = 1e-4
young = {YOUNG}
poisson = {POISSON}
[[clamp]]
on = "left"
components = ["x"]
[[clamp]]
on = "right"
components = ["x"]
[[clamp]]
on = "bottom"
components = ["y"]
[[output.probe]]
name = "top"
on = "top"
[output]
every = 1
fields = ["displacement", "stress", "von_mises"]
"""
HELD = f"""
[[clamp]]
on = "top"
components = ["y"]
value = ["0.01*{expression(RISE)}"]
"""
LOADED = f"""
[[load.traction]]
on = "top"
value = ["0", "10*{expression(RISE)}"]
"""

# A block that is thrown flatly onto a plane, with waves that the branches damp.
THROWN = """
[mesh]
file = "{mesh}"
size = {size}
[time]
end = 0.6
step = 0.01
[material]
density = 1.0
young = 50.0
poisson = 0.3
[contact]
on = "bottom"
obstacle = {{ shape = "half-space", point = {point}, normal = {normal} }}
[initial]
velocity = {velocity}
[output]
every = 1
"""
PLANE = THROWN.format(mesh=SOURCE / "tests" / "data" / "square.geo", size=0.25, point=[0, -0.1], normal=[0, 1], velocity=["0.1", "-1"])
SPACE = THROWN.format(mesh=SOURCE / "tests" / "data" / "cube.geo", size=0.5, point=[0, 0, -0.1], normal=[0, 0, 1],
                      velocity=["0", "0.1", "-1"])  # fmt: skip
BRANCHES = [{"g": 0.3, "k": 0.1, "time": 0.05}, {"g": 0.2, "k": 0.2, "time": 0.5}]


def run(folder: Path, scene: str, verb: str = "simulate", ranks: int = 1, **overrides: object) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "scene.toml").write_text(scene)
    signorini(verb, folder / "scene.toml", folder / "run", ranks, **overrides)
    return folder / "run"


def invariants(out: Path) -> dict[str, float]:
    return {law: found["worst"] for law, found in json.loads((out / "run.json").read_text())["invariants"].items()}


def response(out: Path, name: str, solid: Solid) -> tuple[np.ndarray, np.ndarray]:
    """Stress of the stretched block or displacement of the loaded one, of each step, and the exact ones."""
    probe = table(out / "probes.csv")
    t = probe["time"]
    if name == "creep":
        moved = probe["top.displacement_y"]
        return (moved[1:] + moved[:-1]) / 2, 10 * over_steps(lambda s: solid.creep(s, RISE), t)
    return probe["top.reaction_y"][1:], 0.01 * at_ends(lambda s: solid.relaxation(s, RISE), t)


@pytest.mark.parametrize("degree", (1, 2))
@pytest.mark.parametrize("name, scene, prony", (
    ("relaxation", HELD, ONE), ("relaxation by two branches", HELD, TWO), ("creep", LOADED, ONE),
), ids=("relaxation", "two branches", "creep"))  # fmt: skip
def test_closed_form(name: str, scene: str, prony: list[dict], degree: int, tmp_path: Path) -> None:
    """Second order in the step."""
    solid, errors = Solid.of(YOUNG, POISSON, prony), []
    for step in (0.1, 0.05):
        out = run(tmp_path, BLOCK + scene, material__prony=prony, time__step=step, mesh__degree=degree)
        found, exact = response(out, name, solid)
        assert exact[-1] > 1.2 * exact[int(RISE / step)] if name == "creep" else exact.max() > 1.2 * exact[-1], "hardly any relaxation"
        errors.append(np.abs(found - exact).max() / exact.max())
    order = np.log2(errors[0] / errors[1])
    print(f"{name}: errors {errors[0]:.2e}, {errors[1]:.2e}, order {order:.2f}")
    assert order > 1.8 and errors[1] < 1e-3


def test_stress_and_energy(tmp_path: Path) -> None:
    """The stress at t_k has the branches' part, along and across the strain; so have the columns of energy and dissipation."""
    out = run(tmp_path, BLOCK + HELD, material__prony=TWO, time__step=0.02)
    steps, solid = table(out / "steps.csv"), Solid.of(YOUNG, POISSON, TWO)
    t, strain = steps["time"], 0.01 * risen(steps["time"], RISE)
    stress = stored(out, "state", "stress")[2].reshape(len(t), -1, 9).mean(axis=1)
    along = 0.01 * solid.relaxation(t, RISE)
    assert np.abs(stress[:, 4] - along).max() < 1e-3 * along.max()
    # Half of the deviator's modulus: σ_yy − σ_xx = 2 G ε.
    shear = Solid(SHEAR * (1 - sum(one["g"] for one in TWO)), tuple((one["g"] * SHEAR, one["time"]) for one in TWO))
    across = 0.01 * shear.relaxation(t, RISE)
    assert np.abs(stress[:, 4] - stress[:, 0] - 2 * across).max() < 1e-3 * along.max()
    von_mises = stored(out, "state", "von_mises")[2].reshape(len(t), -1).mean(axis=1)
    assert np.abs(von_mises - 2 * across).max() < 1e-3 * along.max()
    each = [(modulus, time, Solid(0, ((1, time),)).relaxation(t, RISE) * 0.01) for modulus, time in solid.branches]
    energy = sum(modulus * q**2 / 2 for modulus, _, q in each)
    assert np.abs(steps["relaxation_energy"] - energy).max() < 1e-3 * energy.max()
    power = sum(modulus * q**2 / time for modulus, time, q in each)
    lost = (np.diff(t) * (power[1:] + power[:-1]) / 2).sum()
    assert abs(steps["relaxation_dissipation"].sum() / lost - 1) < 1e-3
    assert np.abs(steps["elastic_energy"] - solid.long_term * strain**2 / 2).max() < 1e-3 * energy.max()


def constants(bulk: float, shear: float) -> dict[str, float]:
    """Young's modulus and Poisson's ratio, as overrides."""
    poisson = (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear))
    return {"material__young": 2 * shear * (1 + poisson), "material__poisson": poisson}


def thrown(folder: Path, **overrides: object) -> tuple[np.ndarray, np.ndarray]:
    """Displacements at all times and forces of all steps of the block that is thrown onto the plane."""
    out = run(folder, PLANE, time__scheme="contact-stabilized", **overrides)
    force = table(out / "steps.csv")["normal_force"]
    assert (force > 0).sum() > 10, "hardly any contact: the case says nothing"
    return stored(out, "state", "displacement")[2], force


@pytest.mark.parametrize("time, left", ((1e-9, 1.0), (1e9, 0.0)), ids=("at once", "never"))
def test_limits(time: float, left: float, tmp_path: Path) -> None:
    """A branch that relaxes at once leaves the long-term moduli, one that never does is stiffness."""
    g, k, bulk, shear = 0.3, 0.1, 50 / (3 * 0.4), 50 / 2.6
    found, force = thrown(tmp_path / "prony", material__prony=[{"g": g, "k": k, "time": time}])
    expected, exact = thrown(tmp_path / "elastic", **constants(bulk * (1 - left * k), shear * (1 - left * g)))
    off = np.abs(found - expected).max() / np.abs(expected).max(), np.abs(force - exact).max() / exact.max()
    print(f"displacement {off[0]:.1e}, force {off[1]:.1e}")
    assert off[0] < 1e-6 and off[1] < 1e-6


def test_long_term_moduli(tmp_path: Path) -> None:
    """The same material by its instantaneous and by its long-term moduli."""
    bulk, shear = 50 / (3 * 0.4), 50 / 2.6
    g, k = (sum(one[name] for one in BRANCHES) for name in "gk")
    found, _ = thrown(tmp_path / "instantaneous", material__prony=BRANCHES)
    same, _ = thrown(tmp_path / "long-term", material__prony=BRANCHES, material__moduli="long-term",
                     **constants(bulk * (1 - k), shear * (1 - g)))  # fmt: skip
    assert np.abs(found - same).max() < 1e-11 * np.abs(found).max()


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("dim, degree", ((2, 1), (2, 2), (3, 1), (3, 2)), ids=("plane", "plane of degree 2", "space", "space of degree 2"))
def test_laws(dim: int, degree: int, scheme: str, tmp_path: Path) -> None:
    """Energy, momentum and contact condition of every step."""
    out = run(tmp_path, PLANE if dim == 2 else SPACE, material__prony=BRANCHES, mesh__degree=degree, **SCHEMES[scheme])
    steps, worst = table(out / "steps.csv"), invariants(out)
    start = steps["kinetic_energy"][0]
    assert (steps["active"] > 0).sum() > 5, "hardly any contact: the case says nothing"
    assert steps["relaxation_energy"].max() > 1e-3 * start and steps["relaxation_dissipation"].sum() > 1e-2 * start
    assert steps["relaxation_dissipation"].min() > -1e-15 * start, "branches give energy"
    print(", ".join(f"{law}: {value:.1e}" for law, value in worst.items()))
    assert len(worst) == 5 and np.max(list(worst.values())) <= 1e-12
    assert np.abs(steps["energy_residual"]).max() <= 1e-12 * start and steps["momentum_residual"].max() <= 1e-12
    total = steps["kinetic_energy"] + steps["elastic_energy"] + steps["relaxation_energy"]
    assert np.diff(total).max() <= 1e-12 * start, "energy rises"


@pytest.mark.parametrize("solver", ("direct", "iterative"))
def test_ranks(solver: str, tmp_path: Path) -> None:
    """Two ranks make the motion of one, to the accuracy of the solvers."""
    one, two = (table(run(tmp_path / str(ranks), PLANE, ranks=ranks, material__prony=BRANCHES, time__scheme="contact-stabilized",
                          solver__linear=solver) / "steps.csv") for ranks in (1, 2))  # fmt: skip
    assert (one["active"] > 0).sum() > 5 and np.array_equal(one["active"], two["active"])
    for name in ("kinetic_energy", "elastic_energy", "relaxation_energy", "relaxation_dissipation", "normal_force"):
        assert np.abs(one[name] - two[name]).max() < 1e-9 * np.abs(one[name]).max(), name


def lengths(out: Path) -> np.ndarray:
    """Step lengths of a run that chooses them."""
    found = np.diff(table(out / "steps.csv")["time"])
    print(f"{len(found)} steps of {found.min():.1e} to {found.max():.1e} s")
    assert found.max() > 10 * found.min(), "hardly any lengths"
    return found


def test_steps_of_varying_length(tmp_path: Path) -> None:
    """q_j is a state that steps of any length carry on: the closed form to the tolerance."""
    auto = {"end": 4.0, "step": "auto", "tolerance": 1e-2}
    out = run(tmp_path, BLOCK + HELD, material__prony=TWO, material__density=1e-2, time=auto)
    assert len(lengths(out)) < 4.0 / lengths(out).min() / 2
    found, exact = response(out, "relaxation", Solid.of(YOUNG, POISSON, TWO))
    print(f"largest difference {np.abs(found - exact).max() / exact.max():.1e}")
    assert np.abs(found - exact).max() < 1e-2 * exact.max()


def test_contact_in_steps_of_varying_length(tmp_path: Path) -> None:
    """The impulse of a bounce to the tolerance, beside short steps of equal length, and the laws of each step."""
    auto = {"end": 1.5, "step": "auto", "tolerance": 1e-2, "scheme": "contact-stabilized", "quantity": "contact-force"}
    impulses = []
    for name, times in (("equal", {"end": 1.5, "step": 1e-3, "scheme": "contact-stabilized"}), ("auto", auto)):
        out = run(tmp_path / name, PLANE, material__prony=[{"g": 0.4, "k": 0.4, "time": 0.1}], time=times)
        assert table(out / "steps.csv")["relaxation_dissipation"].sum() > 0.1, "J/m; hardly any relaxation"
        impulses.append(json.loads((out / "run.json").read_text())["impact"]["all"]["normal_impulse"])
    print(f"impulse {impulses[1]:.5f}, in short steps {impulses[0]:.5f} N s/m")
    assert len(lengths(out)) < 200 and abs(impulses[1] / impulses[0] - 1) < 1e-2
    assert np.max(list(invariants(out).values())) <= 1e-12


CONTROLLED = PLANE.replace("normal = [0, 1]", "normal = [0.3, 1]") + """
[control]
scale = 1.0
[objective]
desired = { control = ["0.3", "-1"] }
alpha = 1e-2
gamma = 1e-2
"""


def search(folder: Path, iterations: int, **overrides: object) -> Path:
    return run(folder, CONTROLLED, "optimize", material__prony=BRANCHES, time__scheme="contact-stabilized", optimizer__start="guess",
               optimizer__max_iterations=iterations, optimizer__tolerance=1e-9, **overrides)  # fmt: skip


def iterates(out: Path) -> list[np.ndarray]:
    history = table(out / "history.csv")
    return [history[name] for name in ("iteration", "objective", "gradient_norm")]


def test_derivatives_of_a_control(tmp_path: Path) -> None:
    """Taylor orders, Hessian products, laws and contact by `check`; J and gradients by states on disk or recomputed are the same."""
    (tmp_path / "scene.toml").write_text(CONTROLLED)
    for scheme in SCHEMES.values():
        done = signorini("check", tmp_path / "scene.toml", None, material__prony=BRANCHES, **scheme)
        assert "contact occurred" in done.stdout
    memory = iterates(search(tmp_path / "memory", 3))
    assert len(memory[0]) == 4 and memory[1][-1] < memory[1][0]
    for storage in ({"storage": "disk"}, {"storage": "checkpoints", "budget": 2e5}):
        for one, other in zip(memory, iterates(search(tmp_path / storage["storage"], 3, trajectory=storage))):
            assert np.abs(one - other).max() <= 1e-12 * np.abs(one).max()


def test_resumed(tmp_path: Path) -> None:
    """A search that was stopped continues to the same iterates; another material is another problem."""
    whole = iterates(search(tmp_path / "whole", 5))
    out = search(tmp_path / "stopped", 2)
    overrides = {"material.prony": BRANCHES, "time.scheme": "contact-stabilized", "optimizer.start": "guess", "optimizer.max_iterations": 5,
                 "optimizer.tolerance": 1e-9}  # fmt: skip

    def resume(**other: object) -> object:
        words = [word for key, value in (overrides | other).items() for word in ("--set", f"{key}={toml(value)}")]
        return captured([str(SIGNORINI), "optimize", str(tmp_path / "stopped" / "scene.toml"), "--out", str(out), "--resume", *words])

    refused = resume(**{"material.prony": [BRANCHES[0] | {"time": 0.06}, BRANCHES[1]]})
    assert refused.returncode == 2 and "material.prony" in refused.stderr, refused.stderr
    done = resume()
    assert done.returncode == 0 and "resumed after iteration 2" in done.stdout, done.stdout + done.stderr
    for one, other in zip(whole, iterates(out)):
        assert np.array_equal(one, other)
