# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of fits share: scenes and their data, fits that are stopped and resumed, and what a fit prints."""

import json
from pathlib import Path

import numpy as np
from harness import SIGNORINI, SOURCE, captured, table, toml

HALF_DISC, HALF_BALL = SOURCE / "meshes" / "half-disc.geo", SOURCE / "meshes" / "half-ball.geo"
SCHEMES = {"contact-implicit": {}, "contact-stabilized": {"time__scheme": "contact-stabilized"}, "massless": {"contact__mass": "massless"}}
EVERY = [
    {"of": "young", "start": 1.05e8}, {"of": "poisson", "start": 0.29}, {"of": "bulk", "start": 1.1e4}, {"of": "shear", "start": 1.9e4},
    {"of": "density", "start": 1.02}, {"of": "initial.displacement", "start": 1.1},
    {"of": "load.body", "start": 1.05}, {"of": "load.gravity", "start": 0.95}, {"of": "load.traction", "start": 1.1},
]  # fmt: skip
PLANE = [{"of": "initial.velocity", "component": "y", "start": -490.0}, {"of": "position", "start": 0.05}, {"of": "angle", "start": 0.01}]


def half_space(dim: int) -> str:
    return f'{{ shape = "half-space", point = {[0.0] * (dim - 1) + [-15.2]}, normal = {[0.0] * (dim - 1) + [1.0]} }}'


def unknowns(tables: list[dict]) -> str:
    return "".join("[[unknown]]\n" + "".join(f"{key} = {toml(value)}\n" for key, value in one.items()) for one in tables)


def thrown(dim: int, obstacle: str, wanted: list[dict], folder: Path) -> str:
    """The scene of a viscoelastic body that is thrown onto an obstacle and pushed there, with every kind of measurement."""
    still, up = ['"0"'] * (dim - 1), "xyz"[dim - 1]
    centre = [0.0] * (dim - 1)
    point = [12.0, *centre[1:], -6.0]
    measured = [
        {"of": "force", "component": up, "noise": 0.02},
        {"of": "impulse", "component": "x", "deviation": 1e3},
        {"of": "displacement", "component": up, "point": point, "deviation": 0.02},
        {"of": "velocity", "component": "x", "on": "side", "deviation": 5.0},
    ]
    text = f"""
[mesh]
file = "{HALF_DISC if dim == 2 else HALF_BALL}"
size = {3.0 if dim == 2 else 4.5}
[time]
step = 2e-4
end = 6e-3
[material]
density = 1.0
young = 1e8
poisson = 0.3
viscosity = {{ bulk = 1e4, shear = 2e4 }}
[contact]
on = "contact"
obstacle = {obstacle}
[initial]
velocity = [{", ".join(still)}, "-500"]
displacement = [{", ".join(still)}, "0.01*({up} + 15)"]
[load]
body = [{", ".join(still)}, "-1e5*(1 + t/0.01)"]
gravity = {[*centre, -1e5]}
traction = [{{ on = "side", value = [{", ".join(['"1e6"', *still])}] }}]
[output]
fields = []
"""
    for i, one in enumerate(measured):
        text += "[[measurement]]\n" + "".join(f"{key} = {toml(value)}\n" for key, value in one.items())
        text += f'file = "{folder}/{i}.csv"\n'
    return text + unknowns(wanted)


def settings(overrides: dict) -> list[str]:
    return [word for key, value in overrides.items() for word in ("--set", f"{key.replace('__', '.')}={toml(value)}")]


def measure(file: Path, out: Path, overrides: dict, seed: int = 0) -> None:
    """Makes the data of a scene by a simulation; without noise at a seed of 0."""
    done = captured([str(SIGNORINI), "simulate", str(file), "--out", str(out), "--measure", "--seed", str(seed), "--replace", "--quiet",
                     *settings(overrides)])  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def resume(file: Path, out: Path, overrides: dict, after: int) -> None:
    done = captured([str(SIGNORINI), "optimize", str(file), "--out", str(out), "--resume", *settings(overrides)])
    assert done.returncode == 0 and f"resumed after iteration {after}" in done.stdout, done.stdout + done.stderr


def not_resumed(file: Path, out: Path, overrides: dict, key: str) -> None:
    """Asserts that --resume refuses another problem by the key in which it differs, and leaves the checkpoint."""
    before = (out / "checkpoint.h5").read_bytes()
    done = captured([str(SIGNORINI), "optimize", str(file), "--out", str(out), "--resume", *settings(overrides)])
    assert done.returncode == 2 and len(done.stderr.strip().splitlines()) == 1, done.stdout + done.stderr
    assert "checkpoint.h5" in done.stderr and key in done.stderr
    assert (out / "checkpoint.h5").read_bytes() == before


def fitted(out: Path) -> dict[str, tuple[float, float]]:
    """Value and standard deviation of each unknown."""
    rows = table(out / "parameters.csv")
    return {str(name): (value, deviation) for name, value, deviation in zip(rows["name"], rows["value"], rows["standard_deviation"])}


def check_printed(out: Path, printed: str) -> None:
    """Asserts that the lines that a fit prints, and the sums in run.json, agree with its tables."""
    run, history, found = json.loads((out / "run.json").read_text()), table(out / "history.csv"), table(out / "parameters.csv")
    fit, search, control, last = run["fit"], run["optimizer"], run.get("objective"), {name: column[-1] for name, column in history.items()}
    assert search["iterations"] == last["iteration"]
    assert search["forward_sweeps"] == last["forward_sweeps"] and search["adjoint_sweeps"] == last.get("adjoint_sweeps", 0)
    names = [str(name) for name in np.atleast_1d(found["name"])]
    theta = [", ".join(f"{history[name][i]:.6g}" for name in names) for i in range(len(history["iteration"]))]
    counts = [(len(names), "unknown"), (fit["values"], "value"), (len(fit["measurements"]), "measurement")]
    unknowns, values, measurements = (f"{count} {word}{'' if count == 1 else 's'}" for count, word in counts)
    J = f"{last['objective']:.6e}"
    if control:
        expected = [f"{k:4.0f}  J = {value:.6e}, misfit {misfit:.3e}, |g| = {g:.2e}; {x}" for k, value, misfit, g, x in
                    zip(history["iteration"], history["objective"], history["misfit"], history["gradient_norm"], theta)]  # fmt: skip
        parts = ", ".join(f"{word} {last[name]:.3e}" for word, name in
                          (("tracking",) * 2, ("terminal",) * 2, ("control", "control_cost"), ("misfit",) * 2))  # fmt: skip
        end = (f"J {J} ({parts}): {search['iterations']} iterations, {search['forward_sweeps']} forward and "
               f"{search['adjoint_sweeps']} adjoint sweeps in ")  # fmt: skip
    else:
        expected = [f"fit of {unknowns} to {values} of {measurements}",
                    *(f"{k:4.0f}  J = {value:.6e}, decrement {decrement:.2e}; {x}" for k, value, decrement, x in
                      zip(history["iteration"], history["objective"], history["decrement"], theta))]  # fmt: skip
        end = f"J {J}: {search['iterations']} iterations, {search['forward_sweeps']} forward sweeps in "
    width = np.max([len(name) for name in [*names, "unknown"]])
    columns = (np.atleast_1d(found[name]) for name in ("value", "standard_deviation", "start", "unit"))
    for name, value, deviation, start, unit in zip(names, *columns):
        assert value == last[name], name
        expected.append(f"{name:<{width}}  {value:14.8g}  {deviation:12.3g}  {start:12.6g}  {unit if unit == unit else ''}")
    expected += [f"misfit of {values}: {fit['misfit']:.3g} standard deviations (root mean square)", end]
    lines, at = printed.splitlines(), 0
    for line in expected:
        at = next((i + 1 for i in range(at, len(lines)) if lines[i].startswith(line)), 0)
        assert at, f"not printed, or before what is above it: {line}\n{printed}"
