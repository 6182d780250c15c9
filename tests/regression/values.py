# SPDX-License-Identifier: GPL-3.0-or-later
"""Every number of a run's tables, of run.json and of the summary on the console is recomputed: by linear elements in numpy from the
stored displacements and velocities, by sums over tables, by formulas of docs/reference/files.md.

    values.py SIGNORINI SOURCE
"""

import json
import re
import sys
import tempfile
from math import comb
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
import drawn  # noqa: E402
from harness import SIGNORINI, SOURCE, captured, signorini, stored, table  # noqa: E402
from recomputed import ROUNDING, TABLE, Run, failures, near, same, von_mises  # noqa: E402

import numpy as np  # noqa: E402

BLOCK_SCENE = SOURCE / "tests" / "data" / "block.toml"
BLOCK = f"""
[mesh]
file = "{SOURCE}/tests/data/square.geo"
size = 0.25
[time]
end = 1.2
step = 0.01
[material]
density = 2.0
young = 50.0
poisson = 0.3
viscosity = {{ bulk = 0.05, shear = 0.02 }}
[initial]
velocity = ["0.2", "-1 + 0.3*x"]
[[output.probe]]
name = "body"
body = true
[[output.probe]]
name = "tip"
point = [0, 1]
[[output.probe]]
name = "side"
on = "left"
[output]
every = 1
fields = ["displacement", "velocity", "strain", "stress", "von_mises", "pressure"]
"""
# Thrown between a tilted plane and a ball; the load changes in time.
THROWN = BLOCK + """
[load]
body = ["0.5", "-3 + t"]
[[output.probe]]
name = "below"
obstacle = "floor"
[[contact]]
on = "bottom"
obstacle = { name = "floor", shape = "half-space", point = [0, -0.05], normal = [0.3, 1] }
[[contact]]
on = "rest"
obstacle = { name = "wall", shape = "ball", center = [2.1, 0.5], radius = 0.9 }
"""
CENTRE, RADIUS = np.array([2.1, 0.5]), 0.9
# Bounces on one plane.
BOUNCING = BLOCK + """
[load]
gravity = ["0", "-2"]
[[contact]]
on = "bottom"
obstacle = { shape = "half-space", point = [0, -0.02], normal = [0, 1] }
"""
IN_SPACE = BLOCK.split("[[output.probe]]")[0].replace("square.geo", "cube.geo").replace('"0.2", "-1 + 0.3*x"', '"-0.4", "0", "-1 + 0.3*x"') + """
[load]
gravity = ["0", "0.3", "-2"]
[output]
every = 1
fields = ["displacement", "velocity", "strain", "stress", "von_mises", "pressure"]
[[contact]]
on = "bottom"
obstacle = { name = "bulge", shape = "ball", center = [0.4, 0.4, -1], radius = 0.95 }
[[contact]]
on = "left"
obstacle = { name = "wall", shape = "half-space", point = [-0.02, 0, 0], normal = [1, 0, 0] }
[[contact]]
on = "top"
obstacle = { name = "lid", shape = "half-space", point = [0, 0, 3], normal = [0, 0, -1] }
"""

def run_of(folder: Path, name: str, text: str, verb: str = "simulate", **overrides: object) -> tuple[Run, str]:
    scene = folder / f"{name}.toml"
    scene.write_text(text)
    done = signorini(verb, scene, folder / name, **overrides)
    return Run(folder / name), done.stdout


def energies(run: Run, load: np.ndarray) -> None:
    """steps.csv and probes.csv by the matrices; `load` is the nodal force of each step."""
    steps, body, y, v = run.steps, run.body, *(field.reshape(len(field), -1) for field in (run.y, run.v))
    near("kinetic energy", steps["kinetic_energy"], np.einsum("ki,ij,kj->k", v, body.M, v) / 2)
    near("elastic energy", steps["elastic_energy"], np.einsum("ki,ij,kj->k", y, body.A, y) / 2)
    moved, tau = np.diff(y, axis=0), np.diff(steps["time"])
    near("dissipation", steps["viscous_dissipation"], [0, *(np.einsum("ki,ij,kj->k", moved, body.B, moved) / tau)], TABLE)
    work = [0, *np.einsum("ki,ki->k", load.reshape(len(tau), -1), moved)]
    near("work of the load", steps["load_work"], work)
    near("external work", steps["external_work"], work)
    near("residual of the energy law", steps["energy_residual"], 0 * steps["time"], 1e-12, steps["kinetic_energy"].max())


def contact_forces(run: Run, load: np.ndarray) -> None:
    """contact.csv, obstacles.csv and the rest of steps.csv, by the equation of a step and the obstacles' geometry."""
    steps, body, dim = run.steps, run.body, run.dim
    force = run.forces(load)
    rows, count = run.table("contact"), run.manifest["candidates"]
    names = run.manifest["impact"]["obstacles"]
    assert len(rows["step"]) == count * len(run.y) and steps["active"].max() > 1
    each = {name: values.reshape(len(run.y), count) for name, values in rows.items()}
    near("times of contact.csv", each["time"], np.repeat(steps["time"][:, None], count, axis=1))
    points = np.stack([each[axis][0] for axis in "xyz"[:dim]], axis=1)
    normals = np.stack([each[f"normal_{axis}"][0] for axis in "xyz"[:dim]], axis=1)
    nodes = np.array([np.linalg.norm(body.points - point, axis=1).argmin() for point in points])
    near("places of candidates", points, body.points[nodes])
    moved = np.einsum("kid,id->ki", run.y[:, nodes], normals)
    # The step's forces at the nodes are those of the table along its normals, and there are none elsewhere.
    pushed = np.zeros_like(force)
    for i, node in enumerate(nodes):
        pushed[:, node] += each["force"][1:, i, None] * normals[i]
    near("contact forces at all nodes", pushed, force, TABLE)
    assert np.max(np.abs(force)) > 1 and not each["force"][0].any()
    near("work of contact", steps["contact_work"], [0, *np.einsum("kid,kid->k", force, np.diff(run.y, axis=0))], TABLE)
    for c, axis in enumerate("xyz"[:dim]):
        near(f"resultant {axis}", steps[f"contact_force_{axis}"], [0, *force[:, :, c].sum(axis=1)], TABLE, steps["normal_force"].max())
    near("sum of the moduli", steps["normal_force"], each["force"].sum(axis=1))
    near("the least gap", steps["min_gap"], each["gap"].min(axis=1))
    closed = each["gap"] <= 1e-10 * np.sqrt(dim)
    near("candidates in contact", steps["active"], [0, *closed.sum(axis=1)[1:]])
    near("weak ones", steps["weak"], [0, *(closed & ~(each["force"] > 0)).sum(axis=1)[1:]])
    areas, pressures = {}, np.zeros((len(run.y), len(body.points)))
    for one in names:
        own = each["obstacle"][0] == one["name"]
        areas[one["name"]] = body.areas(np.isin(np.arange(len(body.points)), nodes[own]))
        near("area of hat functions", each["area"][0, own], areas[one["name"]][nodes[own]], TABLE)
        near("pressure", each["pressure"][:, own], each["force"][:, own] / areas[one["name"]][nodes[own]], TABLE)
        np.maximum.at(pressures, (slice(None), nodes[own]), each["pressure"][:, own])
        rows_of = run.table("obstacles")
        of = {name: values[rows_of["obstacle"] == one["name"]] for name, values in rows_of.items()}
        near("rows of an obstacle", of["step"], np.arange(len(run.y)))
        near("their times", of["time"], steps["time"])
        for c, axis in enumerate("xyz"[:dim]):
            near(f"an obstacle's force {axis}", of[f"force_{axis}"], (each["force"][:, own] * normals[own, c]).sum(axis=1), TABLE)
        near("sum of moduli", of["normal_force"], each["force"][:, own].sum(axis=1))
        near("in contact", of["active"], [0, *closed[1:, own].sum(axis=1)])
        near("least gap", of["min_gap"], each["gap"][:, own].min(axis=1))
    near("field of the pressure", stored(run.path, "state", "pressure")[2][..., 0], pressures)
    near("gaps follow the nodes", each["gap"] - moved, np.repeat(each["gap"][:1], len(run.y), axis=0), ROUNDING, 1)


def stresses(run: Run) -> None:
    """The fields of the stored times, and the largest of all."""
    body = run.body
    found = {name: stored(run.path, "state", name)[2] for name in ("strain", "stress", "von_mises")}
    strain = np.array([body.strains(y) for y in run.y])
    stress = np.array([body.stresses(y, v) for y, v in zip(run.y, run.v)])
    equivalent = von_mises(stress)
    near("strains", found["strain"].reshape(strain.shape), strain)
    near("stresses", found["stress"].reshape(stress.shape), stress)
    near("von Mises stresses", found["von_mises"][..., 0], equivalent)
    time, cell = np.unravel_index(equivalent.argmax(), equivalent.shape)
    told = run.manifest["largest_von_mises"]
    near("the largest von Mises stress", told["value"], equivalent.max())
    near("its place", told["point"], body.points[body.cells[cell]].mean(axis=0))
    near("its time", told["time"], run.steps["time"][time])
    impact, crossing = run.manifest.get("impact"), run.manifest["body"]["crossing_time"]
    begins = [one["start"] for one in impact["bounces"]] if impact else []
    same("whether it is a front's", told["at_onset"], any(begin <= told["time"] <= begin + crossing for begin in begins))


def probes(run: Run) -> None:
    """Of the body, of a node, of a side, of an obstacle."""
    body, found = run.body, run.table("probes")
    mass = body.density * body.volume.sum()
    near("times of probes.csv", found["time"], run.steps["time"])
    ones = [np.tile(np.eye(run.dim)[c], len(body.points)) for c in range(run.dim)]
    y, v = (field.reshape(len(field), -1) for field in (run.y, run.v))
    at = body.points.ravel()
    centre = [one @ body.M @ at / mass for one in ones]
    tip = int(np.linalg.norm(body.points - [0, 1], axis=1).argmin())
    side = body.areas(np.abs(body.points[:, 0]) < 1e-9)
    for c, axis in enumerate("xy"):
        near("centre of mass", found[f"body.center_{axis}"], centre[c] + y @ body.M @ ones[c] / mass)
        near("momentum", found[f"body.momentum_{axis}"], v @ body.M @ ones[c])
        for name, field in (("displacement", run.y), ("velocity", run.v)):
            near(f"{name} of a node", found[f"tip.{name}_{axis}"], field[:, tip, c])
            near(f"{name} of a side", found[f"side.{name}_{axis}"], field[:, :, c] @ side / side.sum())
        if f"below.force_{axis}" in found:
            of = run.table("obstacles")
            force = of[f"force_{axis}"][of["obstacle"] == "floor"]
            near("force of an obstacle", found[f"below.force_{axis}"], force)
            near("its impulse", found[f"below.impulse_{axis}"], np.cumsum(force) * 0.01)
    turn = np.stack([centre[1] - body.points[:, 1], body.points[:, 0] - centre[0]], axis=1).ravel()
    near("rotation", found["body.rotation"], y @ body.M @ turn / (turn @ body.M @ turn))


def figures_of_the_body(run: Run) -> None:
    """run.json on body, mesh and steps."""
    told, body = run.manifest, run.body
    speeds, extent = body.wave_speeds(), np.ptp(body.points, axis=0)
    near("mass", told["body"]["mass"], body.density * body.volume.sum())
    near("extent", told["body"]["extent"], extent)
    near("pressure waves", told["body"]["pressure_waves"], [speeds[0]] * 2)
    near("shear waves", told["body"]["shear_waves"], [speeds[1]] * 2)
    near("time of a wave across", told["body"]["crossing_time"], extent.max() / speeds[0])
    near("time of a wave across the least element", told["steps"]["wave_time"], body.heights.min() / speeds[0])  # the load varies
    assert (told["unknowns"], told["free_unknowns"], told["cells"]) == (body.points.size, body.points.size, len(body.cells))
    assert told["steps"] | {"wave_time": 0} == {"asked": len(run.y) - 1, "done": len(run.y) - 1, "stored": len(run.y), "wave_time": 0}


def impact(run: Run) -> None:
    """What run.json sums up of contact and of the energy, from the tables."""
    told, steps, tau = run.manifest["impact"], run.steps, run.scene["time"]["step"]
    rows, names = run.table("obstacles"), [one["name"] for one in told["obstacles"]]
    axes = "xyz"[: run.dim]

    def of(name: str | None) -> tuple[np.ndarray, np.ndarray]:
        if name is None:
            return steps["normal_force"], np.stack([steps[f"contact_force_{axis}"] for axis in axes], axis=1)
        own = rows["obstacle"] == name
        return rows["normal_force"][own], np.stack([rows[f"force_{axis}"][own] for axis in axes], axis=1)

    for one, name in zip([*told["obstacles"], told["all"]], [*names, None]):
        normal, force = of(name)
        pushed = np.flatnonzero(normal > 0)
        gap = steps["min_gap"] if name is None else rows["min_gap"][rows["obstacle"] == name]
        least = {"least_gap": gap.min(), "least_gap_time": steps["time"][gap.argmin()]}
        for key, value in least.items():
            near(f"{key} of {name or 'all'}", one[key], value, TABLE, 1)
        if name == "lid":
            never = {key: one[key] for key in least} | {"start": None, "end": None, "peak_time": None, "sustained_over": told["all"]["sustained_over"], "peak_at_onset": False}
            assert not len(pushed) and one == dict.fromkeys(one, 0) | never | {"name": name, "impulse": [0, 0, 0]}, one
            continue
        means, pair = (normal[1:] + normal[:-1]) / 2, np.linalg.norm(force[1:] + force[:-1], axis=1) / 2
        window = np.max([4 * run.manifest["steps"]["wave_time"], 2 * tau])
        impulse, fine = np.append(0, tau * np.cumsum(normal[1:])), steps["time"]
        until = lambda time: np.interp(time, fine, impulse)  # noqa: E731, B023
        part = [np.interp(share * impulse[-1], impulse[pushed[0] - 1:], fine[pushed[0] - 1:]) for share in (0.01, 0.99)]
        expected = {"start": fine[pushed[0] - 1], "end": fine[pushed[-1]], "duration": fine[pushed[-1]] - fine[pushed[0] - 1],
                    "contact_time": tau * len(pushed), "impulse": tau * force.sum(axis=0), "normal_impulse": impulse[-1], "peak": pair.max(),
                    "peak_time": fine[means.argmax()], "normal_peak": means.max(), "largest_step": normal.max(),
                    "impulse_duration": part[1] - part[0], "sustained_over": window,
                    "sustained_peak": np.max((until(fine) - until(fine - window)) / window)}  # fmt: skip
        assert len(pushed) > 5 and set(expected) == set(one) - {"name", "peak_at_onset", *least}, one
        for key, value in expected.items():
            near(f"{key} of {name or 'all'}", one[key], value, TABLE)
        begun = [k for k in pushed if not normal[np.max([k - 2, 0]):k].any()]
        at = means.argmax()
        last = np.max([k for k in begun if k <= at + 1])
        assert one["peak_at_onset"] == (fine[at] <= fine[last - 1] + run.manifest["body"]["crossing_time"]), name
    velocities = run.v.reshape(len(run.v), -1) @ run.body.M
    momentum = np.stack([velocities[:, c:: run.dim].sum(axis=1) for c in range(run.dim)], axis=1) / run.manifest["body"]["mass"]
    normal, force = of(None)
    pushed = np.flatnonzero(normal > 0)
    near("mass of the impact", told["mass"], run.manifest["body"]["mass"])
    near("velocity before", told["velocity_before"], momentum[pushed[0] - 1])
    near("velocity after", told["velocity_after"], momentum[pushed[-1]])
    begins = [int(np.abs(steps["time"] - one["start"]).argmin()) + 1 for one in told["bounces"]]  # touches are grouped
    assert begins[0] == pushed[0] and all(normal[k] > 0 and not normal[k - 2 : k].any() for k in begins)
    for one, begin, after in zip(told["bounces"], begins, [*begins[1:], len(normal)]):
        own = pushed[(pushed >= begin) & (pushed < after)]
        near("start of a bounce", one["start"], steps["time"][begin - 1])
        near("end of a bounce", one["end"], steps["time"][own[-1]])
        near("impulse of a bounce", one["impulse"], tau * force[own].sum(axis=0), TABLE)
        near("peak of a bounce", one["peak"], ((normal + np.roll(normal, 1)) / 2)[own].max(), TABLE)
        near("velocity before a bounce", one["velocity_before"], momentum[begin - 1])
        near("velocity after a bounce", one["velocity_after"], momentum[own[-1]])
        if one["restitution"] is not None:
            near("restitution of a bounce", one["restitution"], -one["velocity_after"][1] / one["velocity_before"][1], TABLE)
    sums = {"kinetic_at_start": steps["kinetic_energy"][0], "elastic_at_start": steps["elastic_energy"][0],
            "load_work": steps["load_work"].sum(), "control_and_clamp_work": (steps["external_work"] - steps["load_work"]).sum(),
            "contact_work": steps["contact_work"].sum(), "viscous_dissipation": steps["viscous_dissipation"].sum(),
            "kinetic_at_end": steps["kinetic_energy"][-1], "elastic_at_end": steps["elastic_energy"][-1]}  # fmt: skip
    assert set(sums) == set(run.manifest["energy"]) - {"residual"}
    for key, value in sums.items():
        near(f"energy: {key}", run.manifest["energy"][key], value, ROUNDING, steps["kinetic_energy"].max())
    near("energy: residual", run.manifest["energy"]["residual"], steps["energy_residual"].sum(), 1e-3, np.abs(steps["energy_residual"]).sum())
    worst = run.manifest["invariants"]
    near("worst momentum residual", worst["momentum law, residual / largest forces"]["worst"], steps["momentum_residual"].max(), 1e-3)
    assert steps["momentum_residual"].max() < 1e-12 and steps["complementarity"].max() < 1e-12


def summary(run: Run, printed: str) -> None:
    """The lines on the console have the numbers of run.json, in the order in which they are told."""
    told = run.manifest
    unit = "/m" if run.dim == 2 else ""

    def numbers(pattern: str, *expected: object, digits: tuple[int, ...] = ()) -> None:
        number = r"([-+]?[\d.]+(?:e[-+]?\d+)?)"
        text = pattern.replace("(", r"\(").replace(")", r"\)").replace("+", r"\+").replace("{}", number).replace("N/m", f"N{unit}").replace("J/m", f"J{unit}")
        lines = [match for line in printed.splitlines() if (match := re.fullmatch(text, line))]
        assert len(lines) == 1, f"{len(lines)} lines are {text}:\n{printed}"
        values = np.concatenate([np.ravel(one) for one in expected])
        found = [float(one) for one in lines[0].groups()]
        for one, value, count in zip(found, values, digits or [4] * len(found), strict=True):
            near(pattern, one, value, 0.51 * 10 ** (1 - count), np.max([abs(value), 1e-9 * np.max(np.abs(values))]))

    vector = f"({', '.join(['{}'] * run.dim)})"
    each = [one for one in [*told["impact"]["obstacles"], told["impact"]["all"] | {"name": "all together"}] if one["contact_time"]]
    for one in each if len(each) > 2 else each[:1]:
        modulus = np.linalg.norm(one["impulse"])
        parts = ["  " + one["name"] + ": from {} to {} s"], [one["start"], one["end"]]
        if one["contact_time"] < 0.999 * one["duration"]:
            parts[0].append(", {} s of it with a force"), parts[1].append(one["contact_time"])
        parts[0].append(f", impulse {vector}"), parts[1].extend(one["impulse"])
        if one["normal_impulse"] - modulus > 1e-3 * one["normal_impulse"]:
            parts[0].append(" ({} by modulus)"), parts[1].append(one["normal_impulse"])
        parts[0].append(" N s/m, peak of two steps {}".replace("s/m", f"s{unit}")), parts[1].append(one["peak"])
        if one["normal_peak"] - one["peak"] > 1e-3 * one["normal_peak"]:
            parts[0].append(" ({} by modulus)"), parts[1].append(one["normal_peak"])
        parts[0].append(" N/m at {} s" + ", as contact begins" * one["peak_at_onset"]), parts[1].append(one["peak_time"])
        numbers("".join(parts[0]), *parts[1])
    for one in told["impact"]["obstacles"]:
        said = [line for line in printed.splitlines() if line.startswith(f"  {one['name']}: not touched")]
        assert len(said) == (not one["contact_time"]), printed
        if said:
            gap, time = re.findall(r"[-+.e\d]*\d", said[0].split("not touched")[1])[:2]
            near(said[0], [float(gap), float(time)], [one["least_gap"], one["least_gap_time"]], 1e-3)
    for one in {(one["impulse_duration"], one["sustained_peak"], one["sustained_over"]): one for one in each}.values():
        short = f"{one['impulse_duration']:.4g}".replace(".", r"\.")
        numbers(f"    1 to 99 % of the impulse within {short} s, sustained peak {{}} N/m, the largest mean over {{}} s", one["sustained_peak"], one["sustained_over"], digits=(4, 3))  # fmt: skip
    energy = told["energy"]
    text, values = "energy, kinetic and elastic: {} J/m at the start", [energy["kinetic_at_start"] + energy["elastic_at_start"]]
    for by, sign, key in (("loads", 1, "load_work"), ("control and clamps", 1, "control_and_clamp_work"), ("contact", 1, "contact_work"),
                          ("viscosity", -1, "viscous_dissipation")):  # fmt: skip
        if abs(energy[key]) > 1e-12:
            text += f", {{}} by {by}"
            values.append(sign * energy[key])
    assert len(values) > 3
    numbers(text + ": {} at the end, {} of it elastic", *values, energy["kinetic_at_end"] + energy["elastic_at_end"], energy["elastic_at_end"])
    stress = told["largest_von_mises"]
    onset = ", as contact begins" if stress["at_onset"] else ""
    numbers(f"largest stored von Mises stress: {{}} Pa in the cell at {vector} m, {{}} s{onset}; {{}} Pa recovered from the cells around it",
            stress["value"], stress["point"], stress["time"], stress["recovered"])  # fmt: skip
    whole = told["impact"]
    for number, one in enumerate(whole["bounces"] if len(whole["bounces"]) > 1 else [], 1):
        ratio = "; restitution {}" if one["restitution"] is not None else ""
        touches = f" in {one['touches']} touches" if one["touches"] > 1 else ""
        ended = "after" if number < len(whole["bounces"]) or whole["ended"] else "at the end, still in contact"
        numbers(f"  bounce {number} of {len(whole['bounces'])}: from {{}} to {{}} s{touches}, impulse {vector} N s/m, peak {{}} N/m; {vector} m/s before, "
                f"{vector} m/s {ended}{ratio}", one["start"], one["end"], one["impulse"], one["peak"], one["velocity_before"], one["velocity_after"],
                *([one["restitution"]] if ratio else []))  # fmt: skip


def load_of(run: Run, force: list, by: str) -> np.ndarray:
    """Nodal forces of each step of a uniform load: of steps, exact means over each."""
    matrix = run.body.W if by == "body" else run.body.M
    return np.array([(matrix @ np.tile(one, len(run.body.points))).reshape(-1, run.dim) for one in force])


def thrown(folder: Path) -> Run:
    run, printed = run_of(folder, "thrown", THROWN)
    middle = (run.steps["time"][1:] + run.steps["time"][:-1]) / 2
    load = load_of(run, [[0.5, -3 + t] for t in middle], "body")
    energies(run, load)
    contact_forces(run, load)
    stresses(run)
    probes(run)
    figures_of_the_body(run)
    impact(run)
    summary(run, printed)
    rows = run.table("contact")
    first = rows["step"] == 0
    points = np.stack([rows["x"], rows["y"]], axis=1)[first]
    normals = np.stack([rows["normal_x"], rows["normal_y"]], axis=1)[first]
    floor = rows["obstacle"][first] == "floor"
    up = np.array([0.3, 1]) / np.hypot(0.3, 1)
    away = points - CENTRE
    near("normals of the plane", normals[floor], np.tile(up, (floor.sum(), 1)))
    near("gaps of the plane", rows["gap"][first][floor], (points[floor] - [0, -0.05]) @ up)
    near("normals of the ball", normals[~floor], (away / np.linalg.norm(away, axis=1)[:, None])[~floor])
    near("gaps of the ball", rows["gap"][first][~floor], np.linalg.norm(away, axis=1)[~floor] - RADIUS)
    assert run.manifest["impact"]["restitution"] is None and all(one["contact_time"] for one in run.manifest["impact"]["obstacles"])
    return run


def bouncing(folder: Path) -> Run:
    run, printed = run_of(folder, "bouncing", BOUNCING, initial__velocity=["0", "-1"], time__scheme="contact-implicit", time__end=2.6)
    load = load_of(run, [[0, -2]] * (len(run.y) - 1), "gravity")
    energies(run, load)
    contact_forces(run, load)
    impact(run)
    summary(run, printed)
    below = [cell for cell, nodes in enumerate(run.body.cells) if (run.body.points[nodes][:, 1] < 1e-9).sum() == 2]
    near("time of a wave across the least element in contact", run.manifest["steps"]["wave_time"],
         run.body.heights[below].min() / run.body.wave_speeds()[0])  # fmt: skip
    told = run.manifest["impact"]
    assert len(told["bounces"]) > 1, told["bounces"]
    return run


def in_space(folder: Path) -> Run:
    run, printed = run_of(folder, "space", IN_SPACE, time__end=0.9, time__step=0.02, mesh__size=0.5)
    load = load_of(run, [[0, 0.3, -2]] * (len(run.y) - 1), "gravity")
    energies(run, load)
    contact_forces(run, load)
    stresses(run)
    impact(run)
    summary(run, printed)
    return run


def a_single_step(folder: Path) -> None:
    """Is enough for a page with energies."""
    held = np.ones(3 * 10**7)  # which the program that starts this run has, and not the run
    run, _ = run_of(folder, "single", BOUNCING, time__end=0.01)
    assert run.manifest["peak_memory_bytes"] < held.nbytes, run.manifest["peak_memory_bytes"]
    energies(run, load_of(run, [[0, -2]], "gravity"))
    views = drawn.views_of(drawn.report_run.page(drawn.RunFolder(run.path)))
    assert len(drawn.numbers(views["energies"][""]["data"][0]["x"])) == 2


def costs() -> None:
    """`info` says how much memory matrices take: 8 bytes an entry and 4 an index, one index for a block of entries."""
    printed = signorini("info", BLOCK_SCENE).stdout
    rows = {line[:22].strip(): line[46:56].strip() for line in printed.split("and in a step")[1].split("off:")[0].splitlines()}
    assert {"viscosity", "contact", "body load", "control", "objective", "tables"} <= set(rows)
    for name, memory in rows.items():
        assert bool(memory) == (name in ("viscosity", "contact", "body load", "control", "objective")), f"{name}: '{memory}'"
    scene = Path(BLOCK_SCENE)
    with tempfile.TemporaryDirectory() as name:
        signorini("simulate", scene, Path(name) / "out", time__end=0.02)
        nodes, cells, _ = stored(Path(name) / "out", "state", "displacement")
    blocks = len({(a, b) for cell in cells for a in cell for b in cell if a <= b})  # of a symmetric matrix
    for name, found in (("A", re.search(r" A (\S+) MB", printed)[1]), ("viscosity", rows["viscosity"].split()[0])):
        near(f"memory of {name}", float(found), (blocks * (4 * 8 + 4) + 4 * len(nodes)) / 1e6, 5e-3)
    counts = re.search(r"unknowns: (\d+) \((\d+) free\), cells: (\d+), candidates: (\d+), steps: (\d+) of (\S+) s", printed)
    # Griewank and Walther, Algorithm 799: revolve (2000): r l - C(s + r, r - 1) of l states from s checkpoints, the start among both.
    for budget in (10_000, 20_000):
        printed = signorini("info", BLOCK_SCENE, trajectory__storage="checkpoints", trajectory__budget=budget).stdout
        again, slots = re.search(r"and (\S+) steps recomputed of either motion \((\d+) checkpoints\)", printed).groups()
        states, kept, repeats = 31, int(slots) + 1, 0
        while comb(kept + repeats, repeats) < states:
            repeats += 1
        assert 1 < kept < states
        near("steps recomputed", float(again), (repeats * states - comb(kept + repeats, repeats - 1)) / 30 - 1, 0.0051, 1)
    near("counts", [float(one) for one in counts.groups()], [2 * len(nodes), 2 * len(nodes), len(cells), int((nodes[:, 1] < 1e-9).sum()), 30, 0.02])


def stiff(folder: Path) -> Run:
    """A clamped body that is pressed onto a floor, whose displacements are drawn enlarged."""
    text = BLOCK + """
[load]
body = ["0", "-30000"]
[[clamp]]
on = "top"
[[contact]]
on = "bottom"
obstacle = { shape = "half-space", point = [0, -0.0005], normal = [0, 1] }
"""
    run, _ = run_of(folder, "stiff", text, initial__velocity=["0", "0"], material__young=5e6, time__end=0.02, time__step=1e-4)
    assert 1e-4 < np.max(np.abs(run.y)) < 0.01
    return run


def pushed(folder: Path) -> Run:
    """A control of the top."""
    keys = {"control__scale": 3.0, "control__on": "top", "output__every": 1, "objective__desired": {"control": ["0.3", "-1"]}}
    signorini("optimize", BLOCK_SCENE, folder / "pushed", **keys, optimizer__max_iterations=2)
    return Run(folder / "pushed")


def search(folder: Path) -> Run:
    """J, its parts, its gradient and the distances of the last iterate, by its control, its adjoint state and two motions."""
    tau, alpha, gamma, scale = 0.02, 0.01, 0.02, 2.0
    keys = {"control__scale": scale, "objective__alpha": alpha, "objective__gamma": gamma, "output__every": 1, "objective__tracking": 1.5}
    wanted = ["0.3", "-1 + x"]
    signorini("optimize", BLOCK_SCENE, folder / "search", **keys, objective__desired={"control": wanted}, optimizer__max_iterations=3)
    signorini("simulate", BLOCK_SCENE, folder / "wanted", **keys, control__initial=wanted)
    run, desired = Run(folder / "search"), Run(folder / "wanted")
    W, history, told = run.body.W, run.table("history"), run.manifest
    flat = lambda field: field.reshape(len(field), -1)  # noqa: E731
    u, p = (flat(stored(run.path, name, name)[2][..., :2]) for name in ("control", "adjoint"))
    u_wanted = np.stack([np.full(len(run.body.points), 0.3), run.body.points[:, 0] - 1], axis=1).ravel()
    off = flat(run.y - desired.y)
    error = np.sqrt(np.einsum("ki,ij,kj->k", off, W, off))
    near("tracking error", run.steps["tracking_error"], error, TABLE)
    parts = {"tracking": 1.5 * tau / 4 * (error[1:] ** 2 + error[:-1] ** 2).sum(), "terminal": gamma * error[-1] ** 2,
             "control_cost": alpha / 2 * tau * np.einsum("ki,ij,kj->", u, W, u)}  # fmt: skip
    for name, value in (parts | {"value": sum(parts.values())}).items():
        near(f"J: {name}", told["objective"][name], value, TABLE)
        near(f"the last row's {name}", history["objective" if name == "value" else name][-1], value, TABLE)
        assert value > 1e-6, name
    near("J is the sum of its parts", history["objective"], history["tracking"] + history["terminal"] + history["control_cost"])
    gradient = alpha * u + scale * tau / 2 * p
    near("norm of the gradient", history["gradient_norm"][-1], np.sqrt(tau * np.einsum("ki,ij,kj->", gradient, W, gradient)), TABLE)
    norm = lambda w: np.sqrt(tau * np.einsum("ki,ij,kj->", w, W, w))  # noqa: E731
    near("distance to the reference", history["relative_distance_to_reference"][-1],
         norm(u - u_wanted) / (np.sqrt(tau * len(u)) * np.sqrt(u_wanted @ W @ u_wanted)), TABLE)  # fmt: skip
    near("iterations", history["iteration"], np.arange(4))
    work = np.einsum("ki,ki->k", scale * u @ W, np.diff(flat(run.y), axis=0))
    near("work of the control", (run.steps["external_work"] - run.steps["load_work"])[1:], work, TABLE)
    assert told["optimizer"]["iterations"] == 3 and history["step_length"][0] == 0 and (history["step_length"][1:] > 0).all()
    for kind in ("forward", "adjoint"):
        assert told["optimizer"][f"{kind}_sweeps"] == history[f"{kind}_sweeps"][-1] and (np.diff(history[f"{kind}_sweeps"]) > 0).all()
    return run


def study(folder: Path) -> None:
    """Rungs have the numbers of runs of their size and step; errors, envelopes and fronts follow, in study.csv and on the console."""
    (folder / "ladder.toml").write_text(BOUNCING)
    names = ["impulse", "impulse_duration", "sustained_peak", "peak_force", "energy_loss"]
    held = np.ones(3 * 10**7)  # bytes that are not the program's, times eight
    done = captured([str(SIGNORINI), "study", str(folder / "ladder.toml"), "--sizes", "0.3,0.5", "--steps", "0.01,0.02", "--quantity", ",".join(names),
                     "--set", "output.fields=[]", "--out", str(folder / "ladder")])  # fmt: skip
    assert done.returncode == 0, done.stderr
    rows = table(folder / "ladder" / "study.csv")
    same("rungs, the cheapest first", (list(rows["size"]), list(rows["step"])), ([0.5, 0.5, 0.3, 0.3], [0.02, 0.01, 0.02, 0.01]))
    assert 0 < np.max(rows["memory_bytes"]) < held.nbytes / 8
    for n in range(4):
        signorini("simulate", folder / "ladder.toml", folder / "rung", mesh__size=float(rows["size"][n]), time__step=float(rows["step"][n]), output__fields=[])
        told, steps = json.loads((folder / "rung" / "run.json").read_text()), table(folder / "rung" / "steps.csv")
        touch = told["impact"]["all"]
        expected = {"impulse": np.linalg.norm(touch["impulse"]), "impulse_duration": touch["impulse_duration"], "sustained_peak": touch["sustained_peak"],
                    "peak_force": touch["peak"],
                    "energy_loss": -steps["contact_work"].sum() / (steps["kinetic_energy"] + steps["elastic_energy"]).max()}  # fmt: skip
        for name, value in expected.items():
            near(f"{name} of rung {n + 1}", rows[name][n], value, TABLE)
        same("size of a rung", (rows["unknowns"][n], rows["steps"][n]), (told["unknowns"], told["steps"]["done"]))
    finest = int(np.flatnonzero((rows["size"] == rows["size"].min()) & (rows["step"] == rows["step"].min()))[0])
    lines, about = done.stdout.splitlines(), json.loads((folder / "ladder" / "study.json").read_text())
    start = next(i for i, line in enumerate(lines) if line.startswith("rung    size, m"))
    same("heads of the rungs", lines[start].replace(", ", ",").split(), "rung size,m step,s degree scheme unknowns seconds MB".split())
    for n, line in enumerate(lines[start + 1 : start + 5]):
        same("a line of the rungs", line.split(),
             [str(n + 1), f"{rows['size'][n]:.4g}", f"{rows['step'][n]:.3g}", "1", "contact-implicit", f"{rows['unknowns'][n]:.0f}", f"{rows['seconds'][n]:.3g}",
              f"{rows['memory_bytes'][n] / 1e6:.0f}"])  # fmt: skip
    start = next(i for i, line in enumerate(lines) if line.startswith("degree 1, contact-implicit:"))
    for one, line in zip(about["orders"], lines[start + 2 :]):
        shown = [one["quantity"]]
        for kind in ("space", "time", "both"):
            order, asymptotic = one[kind], one["asymptotic"][kind]
            if order is None:
                shown.append("-")
            else:
                digits = 2 if asymptotic else 1
                shown += [f"{order:.2f}" if asymptotic else "none", *"({:.{d}f} to {:.{d}f})".format(*one["scatter"][kind], d=digits).split()]
        same("a line of orders", line.split(), shown)
    for name in names:
        value, exact = rows[name], name == "energy_loss"  # of an elastic body none is lost where elements and steps are small
        error = np.abs(value) if exact else np.abs(value / value[finest] - 1)
        error[finest] = error[finest] if exact else np.nan
        near(f"errors of {name}", rows[f"{name}_error"], error, TABLE)
        finer = (rows["size"] <= rows["size"][:, None]) & (rows["step"] <= rows["step"][:, None])
        most = [np.nanmax(error[one]) if np.isfinite(error[one]).any() else np.nan for one in finer]
        near(f"the largest there and at finer rungs, {name}", rows[f"{name}_envelope"], most, TABLE)
        envelope = rows[f"{name}_envelope"]  # to its last digit
        best = [bool(np.isfinite(e) and not ((rows["seconds"] < s) & (envelope <= e)).any()) for s, e in zip(rows["seconds"], envelope)]
        same(f"rungs that no cheaper one beats, {name}", list(map(bool, rows[f"{name}_pareto"])), best)
        title = about["quantities"][name]["title"]
        start = next(i for i, line in enumerate(lines) if line.startswith(title))
        for n, line in enumerate(lines[start + 2 : start + 6]):
            words = line.replace(" %", "%").split()
            same(f"a line of {name}", words[:5] + words[5:6],
                 [str(n + 1), f"{rows['size'][n]:.4g}", f"{rows['step'][n]:.3g}", f"{value[n]:.6g}",
                  "reference" if np.isnan(error[n]) else f"{100 * error[n]:.3g}%", "-" if np.isnan(most[n]) else f"{100 * most[n]:.3g}%"])  # fmt: skip
            same(f"its star, {name}", line.endswith("*"), best[n])
    drawn.study(folder / "ladder", rows, names)


def estimates(folder: Path) -> None:
    """Of J's error, in a study with an objective: what the console says of them, and how much of the error they are."""
    out = folder / "estimates"
    done = captured([str(SIGNORINI), "study", str(BLOCK_SCENE), "--sizes", "0.5,0.3", "--steps", "0.04,0.01", "--quantity", "J", "--out", str(out)])
    assert done.returncode == 0, done.stderr
    rows, lines = table(out / "study.csv"), done.stdout.splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("J: "))
    known = 0
    for n, line in enumerate(lines[start + 2 : start + 6]):
        estimate, effectivity = rows["J_estimate"][n], rows["J_effectivity"][n]
        near("the parts of an estimate", estimate, np.sum([rows[f"J_estimate_{part}"][n] for part in ("space", "time", "initial", "desired")]), TABLE)
        known += bool(np.isfinite(effectivity))
        if np.isfinite(effectivity):
            near("est/err", effectivity, estimate / rows["J_error"][n], TABLE)
        same("estimate and est/err", line.replace(" %", "%").replace("*", "").split()[-2:],
             [f"{100 * estimate:.3g}%", "-" if np.isnan(effectivity) else f"{effectivity:.2f}"])  # fmt: skip
    assert known, "no error is known well enough: the case says nothing"


def main() -> int:
    """Ends with the first run whose numbers are wrong."""
    with tempfile.TemporaryDirectory() as name:
        folder, runs = Path(name), []
        for part in (thrown, bouncing, in_space, search, pushed, stiff):
            runs.append(part(folder))
            drawn.check(runs[-1])
            print(f"{part.__name__}: {len(failures)} failures", flush=True)
            if failures:
                return 1
        for pair in (runs[:2], runs[3:5]):
            drawn.comparison(*pair)
        drawn.enlargements()
        a_single_step(folder)
        costs()
        study(folder)
        estimates(folder)
    print(f"comparisons and a study: {len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    raise SystemExit(main())
