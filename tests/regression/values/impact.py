# SPDX-License-Identifier: GPL-3.0-or-later
"""Every number of run.json on impact, energy and residuals is recomputed from the tables, and the summary on the console repeats them."""

import re

import numpy as np
import pytest
from recomputed import ROUNDING, TABLE, near
from regression.values.runs import IMPACTS, SceneRun

TOUCHED = {"thrown": ["floor", "wall", None], "bouncing": ["obstacle 1", None], "space": ["bulge", "wall", None]}  # None: all together
CASES = [(run, obstacle) for run, names in TOUCHED.items() for obstacle in names]
OF_EACH = pytest.mark.parametrize("run, obstacle", CASES, indirect=["run"], ids=lambda name: name or "all")


def entry(run: SceneRun, obstacle: str | None) -> dict:
    """What run.json has on an obstacle."""
    impact = run.manifest["impact"]
    return next(one for one in impact["obstacles"] if one["name"] == obstacle) if obstacle else impact["all"]


def forces(run: SceneRun, obstacle: str | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Normal force and resultant of each step, by an obstacle's rows or by steps.csv."""
    if obstacle is None:
        return run.steps["normal_force"], np.stack([run.steps[f"contact_force_{axis}"] for axis in run.axes], axis=1)
    rows = run.table("obstacles")
    own = rows["obstacle"] == obstacle
    return rows["normal_force"][own], np.stack([rows[f"force_{axis}"][own] for axis in run.axes], axis=1)


# --- run.json ---------------------------------------------------------------------------------------------------------


@IMPACTS
def test_names_of_obstacles(run: SceneRun) -> None:
    names = [one["name"] for one in run.manifest["impact"]["obstacles"]]
    assert names == TOUCHED[run.name][:-1] + ["lid"] * (run.name == "space")


@pytest.mark.parametrize("run, obstacle", [*CASES, ("space", "lid")], indirect=["run"], ids=lambda name: name or "all")
def test_least_gap(run: SceneRun, obstacle: str | None) -> None:
    rows, one = run.table("obstacles"), entry(run, obstacle)
    gap = run.steps["min_gap"] if obstacle is None else rows["min_gap"][rows["obstacle"] == obstacle]
    near("least gap", one["least_gap"], gap.min(), TABLE, 1)
    near("its time", one["least_gap_time"], run.steps["time"][gap.argmin()], TABLE, 1)


@pytest.mark.parametrize("run", ("space",), indirect=True)
def test_obstacle_that_is_not_touched(run: SceneRun) -> None:
    one = entry(run, "lid")
    assert not forces(run, "lid")[0].any()
    never = {"start": None, "end": None, "peak_time": None, "sustained_over": entry(run, None)["sustained_over"], "peak_at_onset": False}
    known = {key: one[key] for key in ("least_gap", "least_gap_time")}
    assert one == dict.fromkeys(one, 0) | known | never | {"name": "lid", "impulse": [0, 0, 0]}


@OF_EACH
def test_contact_with_an_obstacle(run: SceneRun, obstacle: str | None) -> None:
    (normal, force), one, time, tau = forces(run, obstacle), entry(run, obstacle), run.steps["time"], run.scene["time"]["step"]
    touching = np.flatnonzero(normal > 0)
    assert len(touching) > 5
    means, pair = (normal[1:] + normal[:-1]) / 2, np.linalg.norm(force[1:] + force[:-1], axis=1) / 2
    window = np.max([4 * run.manifest["steps"]["wave_time"], 2 * tau])
    impulse, first, last = np.append(0, tau * np.cumsum(normal[1:])), touching[0], touching[-1]
    part = [np.interp(share * impulse[-1], impulse[first - 1 :], time[first - 1 :]) for share in (0.01, 0.99)]
    sustained = np.interp(time, time, impulse) - np.interp(time - window, time, impulse)
    expected = {"start": time[first - 1], "end": time[last], "duration": time[last] - time[first - 1],
                "contact_time": tau * len(touching), "impulse": tau * force.sum(axis=0), "normal_impulse": impulse[-1], "peak": pair.max(),
                "peak_time": time[means.argmax()], "normal_peak": means.max(), "largest_step": normal.max(),
                "impulse_duration": part[1] - part[0], "sustained_over": window, "sustained_peak": np.max(sustained / window)}  # fmt: skip
    assert set(expected) == set(one) - {"name", "peak_at_onset", "least_gap", "least_gap_time"}
    for key, value in expected.items():
        near(key, one[key], value, TABLE)


@OF_EACH
def test_peak_as_contact_begins(run: SceneRun, obstacle: str | None) -> None:
    normal, time = forces(run, obstacle)[0], run.steps["time"]
    starts = [k for k in np.flatnonzero(normal > 0) if not normal[np.max([k - 2, 0]) : k].any()]
    peak = ((normal[1:] + normal[:-1]) / 2).argmax()
    last = np.max([k for k in starts if k <= peak + 1])
    assert entry(run, obstacle)["peak_at_onset"] == (time[peak] <= time[last - 1] + run.manifest["body"]["crossing_time"])


def velocities(run: SceneRun) -> np.ndarray:
    """The centre's, of each step."""
    momenta = run.v.reshape(len(run.v), -1) @ run.body.M
    return np.stack([momenta[:, c :: run.dim].sum(axis=1) for c in range(run.dim)], axis=1) / run.manifest["body"]["mass"]


@IMPACTS
def test_body_before_and_after(run: SceneRun) -> None:
    found, velocity, touching = run.manifest["impact"], velocities(run), np.flatnonzero(run.steps["normal_force"] > 0)
    near("mass of the impact", found["mass"], run.manifest["body"]["mass"])
    near("velocity before", found["velocity_before"], velocity[touching[0] - 1])
    near("velocity after", found["velocity_after"], velocity[touching[-1]])


@IMPACTS
def test_bounces(run: SceneRun) -> None:
    """Touches are grouped."""
    (normal, force), time, velocity, bounces = forces(run), run.steps["time"], velocities(run), run.manifest["impact"]["bounces"]
    touching = np.flatnonzero(normal > 0)
    starts = [int(np.abs(time - one["start"]).argmin()) + 1 for one in bounces]
    assert starts[0] == touching[0] and all(normal[k] > 0 and not normal[k - 2 : k].any() for k in starts)
    assert len(bounces) > 1 or run.name != "bouncing"
    for one, start, after in zip(bounces, starts, [*starts[1:], len(normal)]):
        own = touching[(touching >= start) & (touching < after)]
        near("start of a bounce", one["start"], time[start - 1])
        near("end of a bounce", one["end"], time[own[-1]])
        near("impulse of a bounce", one["impulse"], run.scene["time"]["step"] * force[own].sum(axis=0), TABLE)
        near("peak of a bounce", one["peak"], ((normal + np.roll(normal, 1)) / 2)[own].max(), TABLE)
        near("velocity before a bounce", one["velocity_before"], velocity[start - 1])
        near("velocity after a bounce", one["velocity_after"], velocity[own[-1]])
        if one["restitution"] is not None:
            near("restitution of a bounce", one["restitution"], -one["velocity_after"][1] / one["velocity_before"][1], TABLE)


@pytest.mark.parametrize("run", ("thrown",), indirect=True)
def test_no_restitution_of_two_obstacles(run: SceneRun) -> None:
    found = run.manifest["impact"]
    assert found["restitution"] is None and all(one["contact_time"] for one in found["obstacles"])


@IMPACTS
def test_energy_account(run: SceneRun) -> None:
    found, steps, kinetic, elastic = run.manifest["energy"], run.steps, run.steps["kinetic_energy"], run.steps["elastic_energy"]
    sums = {"kinetic_at_start": kinetic[0], "elastic_at_start": elastic[0], "load_work": steps["load_work"].sum(),
            "control_and_clamp_work": (steps["external_work"] - steps["load_work"]).sum(), "contact_work": steps["contact_work"].sum(),
            "viscous_dissipation": steps["viscous_dissipation"].sum(),
            "kinetic_at_end": kinetic[-1], "elastic_at_end": elastic[-1]}  # fmt: skip
    assert set(sums) == set(found) - {"residual"}
    for key, value in sums.items():
        near(key, found[key], value, ROUNDING, kinetic.max())
    near("residual", found["residual"], steps["energy_residual"].sum(), 1e-3, np.abs(steps["energy_residual"]).sum())


@IMPACTS
def test_worst_residuals(run: SceneRun) -> None:
    residual, found = run.steps["momentum_residual"], run.manifest["invariants"]["momentum law, residual / largest forces"]
    near("worst momentum residual", found["worst"], residual.max(), 1e-3)
    assert residual.max() < 1e-12 and run.steps["complementarity"].max() < 1e-12


# --- The summary on the console ---------------------------------------------------------------------------------------


def printed(run: SceneRun, pattern: str, *expected: object, digits: tuple[int, ...] = ()) -> None:
    """Asserts that one line is the pattern, with these numbers for {}, of four digits or so many."""
    text = re.sub(r"[()+]", r"\\\g<0>", pattern).replace("{}", r"([-+]?[\d.]+(?:e[-+]?\d+)?)")
    lines = [match for line in run.printed.splitlines() if (match := re.fullmatch(text, line))]
    assert len(lines) == 1, f"{len(lines)} lines are {text}:\n{run.printed}"
    values = np.concatenate([np.ravel(one) for one in expected])
    found = [float(one) for one in lines[0].groups()]
    for one, value, count in zip(found, values, digits or [4] * len(found), strict=True):
        near(pattern, one, value, 0.51 * 10 ** (1 - count), np.max([abs(value), 1e-9 * np.max(np.abs(values))]))


def vector(run: SceneRun) -> str:
    return f"({', '.join(['{}'] * run.dim)})"


def per_depth(run: SceneRun) -> str:
    return "/m" if run.dim == 2 else ""


def touched(run: SceneRun) -> list[dict]:
    """Obstacles with contact, and all of them together."""
    impact = run.manifest["impact"]
    return [one for one in [*impact["obstacles"], impact["all"] | {"name": "all together"}] if one["contact_time"]]


@IMPACTS
def test_lines_of_obstacles(run: SceneRun) -> None:
    each, per = touched(run), per_depth(run)
    for one in each if len(each) > 2 else each[:1]:
        text, values = f"  {one['name']}: from {{}} to {{}} s", [one["start"], one["end"]]
        if one["contact_time"] < 0.999 * one["duration"]:
            text += ", with a force during {} s"
            values.append(one["contact_time"])
        text += f", impulse {vector(run)}"
        values.extend(one["impulse"])
        if one["normal_impulse"] - np.linalg.norm(one["impulse"]) > 1e-3 * one["normal_impulse"]:
            text += " ({} if magnitudes at nodes are added)"
            values.append(one["normal_impulse"])
        text += f" N s{per}, peak of two-step means {{}}"
        values.append(one["peak"])
        if one["normal_peak"] - one["peak"] > 1e-3 * one["normal_peak"]:
            text += " ({} if magnitudes at nodes are added)"
            values.append(one["normal_peak"])
        printed(run, f"{text} N{per} at {{}} s" + ", as contact begins" * one["peak_at_onset"], values, one["peak_time"])


@IMPACTS
def test_lines_of_obstacles_that_are_not_touched(run: SceneRun) -> None:
    for one in run.manifest["impact"]["obstacles"]:
        lines = [line for line in run.printed.splitlines() if line.startswith(f"  {one['name']}: not touched")]
        assert len(lines) == (not one["contact_time"])
        if lines:
            gap, time = re.findall(r"[-+.e\d]*\d", lines[0].split("not touched")[1])[:2]
            near(lines[0], [float(gap), float(time)], [one["least_gap"], one["least_gap_time"]], 1e-3)


@IMPACTS
def test_lines_of_sustained_peaks(run: SceneRun) -> None:
    for duration, peak, window in {(one["impulse_duration"], one["sustained_peak"], one["sustained_over"]) for one in touched(run)}:
        within = f"{duration:.4g}".replace(".", r"\.")
        text = f"    1 to 99 % of the impulse within {within} s, sustained peak of normal forces {{}} N{per_depth(run)} (largest mean over {{}} s)"
        printed(run, text, peak, window, digits=(4, 3))


@IMPACTS
def test_line_of_energies(run: SceneRun) -> None:
    energy, text = run.manifest["energy"], f"energy, kinetic and elastic: {{}} J{per_depth(run)} at the start"
    values = [energy["kinetic_at_start"] + energy["elastic_at_start"]]
    for by, sign, key in (("loads", 1, "load_work"), ("control and clamps", 1, "control_and_clamp_work"), ("contact", 1, "contact_work"),
                          ("viscosity", -1, "viscous_dissipation")):  # fmt: skip
        if abs(energy[key]) > 1e-12:
            text += f", {{}} by {by}"
            values.append(sign * energy[key])
    assert len(values) > 3
    end, elastic = energy["kinetic_at_end"] + energy["elastic_at_end"], energy["elastic_at_end"]
    printed(run, text + ": {} at the end, {} of it elastic", *values, end, elastic)


@IMPACTS
def test_line_of_stress(run: SceneRun) -> None:
    stress = run.manifest["largest_von_mises"]
    at = f"{vector(run)} m, {{}} s" + ", as contact begins" * stress["at_onset"]
    text = f"largest stored von Mises stress: {{}} Pa in the cell at {at}; {{}} Pa recovered from the cells around it"
    printed(run, text, stress["value"], stress["point"], stress["time"], stress["recovered"])


@IMPACTS
def test_lines_of_bounces(run: SceneRun) -> None:
    per, bounces = per_depth(run), run.manifest["impact"]["bounces"]
    for number, one in enumerate(bounces if len(bounces) > 1 else [], 1):
        touches = f" in {one['touches']} touches" if one["touches"] > 1 else ""
        ended = "after" if number < len(bounces) or run.manifest["impact"]["ended"] else "at the end, still in contact"
        text = (f"  bounce {number} of {len(bounces)}: from {{}} to {{}} s{touches}, impulse {vector(run)} N s{per}, peak of normal forces {{}} N{per}; "
                f"{vector(run)} m/s before, {vector(run)} m/s {ended}")  # fmt: skip
        values = [one["start"], one["end"], *one["impulse"], one["peak"], *one["velocity_before"], *one["velocity_after"]]
        if one["restitution"] is not None:
            text += "; restitution {}"
            values.append(one["restitution"])
        printed(run, text, values)
