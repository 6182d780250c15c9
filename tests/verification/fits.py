# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits: derivatives by every kind of unknown from every kind of measurement, and parameters that come back from made data.

usage: fits.py SIGNORINI SOURCE derivatives|together|recovery|exact|noise
"""

import re
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SIGNORINI, SOURCE, attempt, captured, signorini, table, toml  # noqa: E402

HALF_DISC, HALF_BALL = SOURCE / "meshes" / "half-disc.geo", SOURCE / "meshes" / "half-ball.geo"
MADE = ("drop-test", "find-the-wall", "two-materials")  # scenes whose data a simulation made
TRUE = {"young": 2e6, "shear viscosity": 100.0, "height": 0.0, "angle": 0.0, "core": 2e7, "matrix": 2e6}
SIZE = {"height": 1e-3, "angle": 0.035}  # of unknowns whose true value is zero


def unknowns(tables: list[dict]) -> str:
    return "".join("[[unknown]]\n" + "".join(f"{key} = {toml(value)}\n" for key, value in one.items()) for one in tables)


def scene(dim: int, obstacle: str, wanted: list[dict], folder: Path) -> str:
    """A viscoelastic body that is thrown onto an obstacle and pushed there, measured in every way."""
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


EVERY = [
    {"of": "young", "start": 1.05e8}, {"of": "poisson", "start": 0.29}, {"of": "bulk", "start": 1.1e4}, {"of": "shear", "start": 1.9e4},
    {"of": "density", "start": 1.02}, {"of": "initial.displacement", "start": 1.1},
    {"of": "load.body", "start": 1.05}, {"of": "load.gravity", "start": 0.95}, {"of": "load.traction", "start": 1.1},
]  # fmt: skip
PLANE = [{"of": "initial.velocity", "component": "y", "start": -490.0}, {"of": "position", "start": 0.05}, {"of": "angle", "start": 0.01}]
IN_SPACE = [{"of": "initial.velocity", "start": 0.98}, {"of": "position", "start": 0.05},
            {"of": "angle", "component": "x", "start": 0.01}, {"of": "angle", "component": "y", "start": -0.01}]  # fmt: skip
ROUND = [{"of": "center", "component": "x", "start": 0.1}, {"of": "center", "component": "y", "start": -40.05}, {"of": "radius", "start": 24.9}]


def half_space(dim: int) -> str:
    return f'{{ shape = "half-space", point = {[0.0] * (dim - 1) + [-15.2]}, normal = {[0.0] * (dim - 1) + [1.0]} }}'


CASES = {
    "plane": (2, half_space(2), EVERY + PLANE),
    "ball": (2, '{ shape = "ball", center = [0, -40.2], radius = 25.0 }', [EVERY[0], EVERY[4], *ROUND]),
    "space": (3, half_space(3), [EVERY[0], EVERY[3], EVERY[4], *IN_SPACE]),
}
TOGETHER = """
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
"""  # a control sought with the unknowns
SCHEMES = {"contact-implicit": {}, "contact-stabilized": {"time__scheme": "contact-stabilized"}, "massless": {"contact__mass": "massless"}}
MORE = [({"mesh__degree": 2}, 1), ({"solver__linear": "iterative"}, 1), ({}, 2), ({}, 3), ({"trajectory__storage": "checkpoints"}, 1)]


def derivatives(folder: Path) -> None:
    """check holds in every case: Taylor orders by each unknown, adjoint sweep against linearised motions, contact not vacuous."""
    for name, (dim, obstacle, wanted) in CASES.items():
        file = folder / f"{name}.toml"
        file.write_text(scene(dim, obstacle, wanted, folder))
        for scheme, overrides in SCHEMES.items():
            captured_run(file, folder, overrides)
            for more, ranks in [({}, 1), *(MORE if name == "plane" or scheme == "contact-stabilized" else [])]:
                done = attempt("check", file, None, ranks, **overrides, **more)
                rows = re.findall(r"^(ok|FAIL)\s+(\S.*?)\s{2,}(\S.*?)\s{2,}", done.stdout, re.MULTILINE)
                orders = [row for row in rows if row[1].startswith("Taylor order")]
                print(f"{name}, {scheme}, {more}, {ranks} ranks: {len(orders)} Taylor orders of {len(wanted)}", flush=True)
                assert done.returncode == 0, done.stdout + done.stderr
                assert "contact included" in done.stdout and len(rows) > 2 * len(wanted)
                assert len(orders) > len(wanted) / 2, "too few sizes keep the active sets"


def together(folder: Path) -> None:
    """The gradient of J by control and unknowns at once; a search by both lowers J, and goes on where it was stopped."""
    text = scene(2, half_space(2), [EVERY[0], EVERY[4], PLANE[1]], folder)
    # Unclamped bodies are thrown; this one hangs and is pushed.
    text = re.sub(r'displacement = .*\n|velocity = \[.*\n', "", text).replace("[initial]\n", TOGETHER)
    file = folder / "together.toml"
    file.write_text(text)
    for scheme, overrides in SCHEMES.items():
        captured_run(file, folder, overrides)
        for ranks in (1, 2):
            done = attempt("check", file, None, ranks, **overrides)
            assert done.returncode == 0 and "Taylor order by control and unknowns" in done.stdout, done.stdout + done.stderr
        print(f"together, {scheme}: checked on 1 and 2 ranks", flush=True)
    whole, cut = folder / "whole", folder / "cut"
    signorini("optimize", file, whole, optimizer__max_iterations=12, output__fields=["control", "adjoint"], **overrides)
    signorini("optimize", file, cut, optimizer__max_iterations=5, **overrides)
    resumed(file, cut, overrides | {"optimizer__max_iterations": 12}, 5)
    values = [table(out / "history.csv")["objective"] for out in (whole, cut)]
    print(f"J {values[0][0]:.4g} -> {values[0][-1]:.4g}, cut and resumed {values[1][-1]:.4g}")
    assert len(values[0]) == len(values[1]) == 13 and np.allclose(*values, rtol=1e-6, atol=0) and values[0][-1] < 0.3 * values[0][0]
    for name in ("control.xdmf", "adjoint.xdmf", "parameters.csv", "measurements.csv"):
        assert (whole / name).is_file(), name


def captured_run(file: Path, folder: Path, overrides: dict) -> None:
    """Makes the data of a scene, without noise."""
    done = captured([str(SIGNORINI), "simulate", str(file), "--out", str(folder / "made"), "--measure", "--seed", "0", "--replace", "--quiet",
                     *settings(overrides)])  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def settings(overrides: dict) -> list[str]:
    return [word for key, value in overrides.items() for word in ("--set", f"{key.replace('__', '.')}={toml(value)}")]


def resumed(file: Path, out: Path, overrides: dict, after: int = 2) -> None:
    done = captured([str(SIGNORINI), "optimize", str(file), "--out", str(out), "--resume", *settings(overrides)])
    assert done.returncode == 0 and f"resumed after iteration {after}" in done.stdout, done.stdout + done.stderr


def fitted(out: Path) -> dict[str, tuple[float, float]]:
    rows = table(out / "parameters.csv")
    return {str(name): (value, deviation) for name, value, deviation in zip(rows["name"], rows["value"], rows["standard_deviation"])}


def data_in(folder: Path, name: str) -> dict:
    """Overrides by which a scene's data are in a folder."""
    count = (SOURCE / "scenes" / f"{name}.toml").read_text().count("[[measurement]]")
    return {f"measurement__{i}__file": str(folder / f"{name}.csv") for i in range(count)}


def error(name: str, value: float) -> float:
    return abs(value - TRUE[name]) / (SIZE.get(name) or TRUE[name])


def recovery(folder: Path) -> None:
    """Without noise the parameters come back to 1e-6, on one rank and on two; from the data at hand, within their deviations."""
    drawn_where_found(folder)
    for name in MADE:
        file = SOURCE / "scenes" / f"{name}.toml"
        captured_run(file, folder, data_in(folder, name))
        for ranks in (1, 2):
            out = folder / f"{name}-{ranks}"
            done = signorini("optimize", file, out, ranks, **data_in(folder, name))
            found = fitted(out)
            worst = np.max([error(key, value) for key, (value, _) in found.items()])
            iterations = len(table(out / "history.csv")["iteration"]) - 1
            print(f"{name}, {ranks} ranks: {iterations} iterations, worst error {worst:.1e}")
            assert worst <= 1e-6 and iterations <= 15, done.stdout
        # Cut off after two iterations, a fit goes on where it was: the same iterates to the same end.
        cut = folder / f"{name}-cut"
        signorini("optimize", file, cut, optimizer__max_iterations=2, **data_in(folder, name))
        resumed(file, cut, data_in(folder, name))
        whole, parts = (table(folder / one / "history.csv") for one in (f"{name}-1", f"{name}-cut"))
        assert len(whole["iteration"]) == len(parts["iteration"])
        assert np.allclose(whole["objective"][:4], parts["objective"][:4], rtol=1e-6, atol=0)
        signorini("optimize", file, folder / "noisy")
        for key, (value, deviation) in fitted(folder / "noisy").items():
            print(f"  {key}: {value:.6g} +- {deviation:.2g}, off by {(value - TRUE[key]) / deviation:+.2f} deviations")
            assert abs(value - TRUE[key]) <= 3 * deviation


def drawn_where_found(folder: Path) -> None:
    """Pages and films show obstacles where the fit found them."""
    sys.path.insert(0, str(SOURCE / "postprocess"))
    from obstacles import with_fitted_obstacles  # noqa: PLC0415

    planes = [{"of": "angle"}, {"of": "position"}]
    given = {"contact": {"obstacle": {"shape": "half-space", "point": [1.0, "2*t"], "normal": [0.0, 2.0]}}, "unknown": planes}
    found = with_fitted_obstacles(given, [np.pi / 6, 0.5])["contact"]["obstacle"]
    assert found["point"] == [1.0, "(2*t) + (0.5)"] and np.allclose(found["normal"], [-0.5, np.sqrt(0.75)], rtol=1e-12, atol=0)
    balls = [{"of": "radius", "obstacle": "b"}, {"of": "center", "component": "y", "obstacle": "b"}]
    ball = {"shape": "ball", "name": "b", "center": [0, 0], "radius": 1}
    given = {"contact": [{"obstacle": ball | {"name": "a"}}, {"obstacle": ball}], "unknown": balls}
    found = with_fitted_obstacles(given, [2.0, 3.0])["contact"]
    assert found[0]["obstacle"]["radius"] == 1 and found[1]["obstacle"] == ball | {"center": [0, 3.0], "radius": 2.0}


def exact(folder: Path) -> None:
    """From the exact solution of a bar's impact E and the speed come back with the error of the discretisation, which falls with it."""
    file, errors = SOURCE / "scenes" / "bar-speed.toml", []
    for size, step in ((0.5, 1 / 120), (0.25, 1 / 240), (0.125, 1 / 480)):
        out = folder / f"bar-{size}"
        signorini("optimize", file, out, mesh__size=size, time__step=step)
        found = fitted(out)
        errors.append([abs(found["young"][0] / 900 - 1), abs(found["speed"][0] / -10 - 1)])
        print(f"size {size} m: E off by {errors[-1][0]:.2e}, speed by {errors[-1][1]:.2e}; "
              f"{len(table(out / 'history.csv')['iteration']) - 1} iterations")  # fmt: skip
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    print(f"orders: {orders.round(2).tolist()}")
    assert np.all(np.array(errors[-1]) < 0.02) and np.all(np.array(errors[-1]) < np.array(errors[0]) / 2)


def noise(folder: Path) -> None:
    """With noise, over 40 seeds, the true value lies within two reported standard deviations in 33 to 40 of them."""
    seeds = 40
    for name in MADE:
        file = SOURCE / "scenes" / f"{name}.toml"
        within: dict[str, int] = {}
        for seed in range(1, seeds + 1):
            for verb, more in (("simulate", ["--measure", "--seed", str(seed), "--replace"]), ("optimize", [])):
                done = captured([str(SIGNORINI), verb, str(file), "--out", str(folder / verb), "--quiet", "--set", "output.fields=[]",
                                 *settings(data_in(folder, name)),
                                 *more])  # fmt: skip
                assert done.returncode == 0, done.stdout + done.stderr
            for key, (value, deviation) in fitted(folder / "optimize").items():
                within[key] = within.get(key, 0) + (abs(value - TRUE[key]) <= 2 * deviation)
        print(f"{name}: within two deviations of {seeds} seeds: {within}", flush=True)
        assert all(33 <= count <= seeds for count in within.values())


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        {"derivatives": derivatives, "together": together, "recovery": recovery, "exact": exact, "noise": noise}[sys.argv[3]](Path(name))
