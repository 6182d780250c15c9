# SPDX-License-Identifier: GPL-3.0-or-later
"""The statements of docs/reference/definitions.md that a number can show: each test is named for its statement."""

import functools
import itertools
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini, stored, table
from studies import study

SQUARE = f"""
[mesh]
file = "{SOURCE}/meshes/block.geo"
size = 0.1
[time]
end = 0.5
step = 0.1
[material]
density = 1.0
young = 1e3
poisson = 0.3
[[output.probe]]
name = "body"
body = true
"""
CONTACT = """
[contact]
on = "bottom"
obstacle = { shape = "half-space", point = [0, -0.1], normal = [0, 1] }
[initial]
velocity = ["0", "-1"]
"""
CONTROL = '[control]\nscale = 1.0\ninitial = ["0", "t^2"]\n'
TRACKED = '[objective]\ndesired = { displacement = ["0", "t"] }\n[optimizer]\nmax_iterations = 0\n'
TAU, TIMES = 0.1, 0.1 * np.arange(6)
exactly = functools.partial(pytest.approx, rel=1e-9, abs=1e-12)
Runner = Callable[..., Path]  # to the folder of a run


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Runner:
    """Runs the square with more tables; returns the folder."""
    folder, numbers = tmp_path_factory.mktemp("runs"), itertools.count()

    def made(text: str, verb: str = "simulate", **overrides: object) -> Path:
        out = folder / str(next(numbers))
        scene = out.with_suffix(".toml")
        scene.write_text(SQUARE + text)
        signorini(verb, scene, out, **overrides)
        return out

    return made


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def momentum(out: Path) -> np.ndarray:
    return table(out / "probes.csv")["body.momentum_y"]


# --- Time -------------------------------------------------------------------------------------------------------------


FORCES = {"load": '[load]\nbody = ["0", "t^2"]', "gravity": '[load]\ngravity = ["0", "t^2"]', "control": CONTROL}


@pytest.mark.parametrize("text", FORCES.values(), ids=FORCES)
def test_exact_impulse_in_a_step(run: Runner, text: str) -> None:
    assert momentum(run(text)) == exactly(TIMES**3 / 3)


def test_control_with_intervals_of_its_own(run: Runner) -> None:
    """It is the mean over each interval, a step's the mean of what it overlaps."""
    means = np.diff([0, 0.25**3, 0.5**3]) / 3 / 0.25  # of two intervals, which meet in the middle of the third step
    assert momentum(run(CONTROL + "step = 0.25\n")) == exactly(TAU * np.cumsum([0, means[0], means[0], means.mean(), means[1], means[1]]))


def test_desired_displacement_at_the_end_of_a_step(run: Runner) -> None:
    assert table(run("[control]\nscale = 1.0\n" + TRACKED, "optimize") / "steps.csv")["tracking_error"] == exactly(TIMES)


def test_time_series_is_linear_between_its_times(run: Runner, tmp_path: Path) -> None:
    """And gives its exact impulse."""
    (tmp_path / "series.csv").write_text("time,push\n0,0\n0.15,3\n0.5,-1\n")
    series = run(f'[load]\nbody = ["0", {{ file = "{tmp_path}/series.csv", column = "push" }}]\n')
    fine = np.linspace(0, 0.5, 1001)  # so that trapezoids are exact: 0.15 is among them
    push = np.interp(fine, [0, 0.15, 0.5], [0, 3, -1])
    assert momentum(series) == exactly(np.concatenate([[0], np.cumsum((push[1:] + push[:-1]) / 2 * np.diff(fine))])[::200])


def test_clamp_has_its_value_and_derivative_at_the_end_of_a_step(run: Runner) -> None:
    probes = table(run('[[clamp]]\non = "left"\nvalue = ["0.01*t^2", "0"]\n[[output.probe]]\nname = "left"\non = "left"\n') / "probes.csv")
    assert probes["left.displacement_x"] == exactly(0.01 * TIMES**2)
    assert probes["left.velocity_x"] == exactly(0.02 * TIMES)


# --- Space ------------------------------------------------------------------------------------------------------------


def test_expressions_are_interpolated_at_the_nodes(run: Runner) -> None:
    zero = run('[load]\ntraction = [ { on = "bottom", value = ["0", "sin(10*pi*x)^2"] } ]')  # 0 at the nodes, every 0.1 m
    assert momentum(zero) == exactly(np.zeros(6))


@pytest.mark.parametrize("degree, candidates", ((1, 11), (2, 21)))
def test_candidates_include_the_middles_of_edges(run: Runner, degree: int, candidates: int) -> None:
    assert manifest(run(CONTACT, mesh__degree=degree))["candidates"] == candidates


def test_clamped_node_is_no_candidate(run: Runner) -> None:
    text = CONTACT.replace("[initial]", '[[clamp]]\non = "left"\n[initial]').replace('"-1"', '"-x"')
    assert manifest(run(text))["candidates"] == 10


def test_node_clamped_in_other_directions_alone_is_a_candidate(run: Runner) -> None:
    text = CONTACT.replace("[initial]", '[[clamp]]\non = "left"\ncomponents = ["x"]\n[initial]')
    assert manifest(run(text))["candidates"] == 11


@pytest.mark.parametrize("space", ("nodal", "cellwise"))
def test_control_has_values_at_the_nodes_or_in_the_cells(run: Runner, space: str) -> None:
    out = run(CONTROL + TRACKED, "optimize", control__space=space, mesh__degree=2)
    points, _, control = stored(out, "control", "control")
    assert control.shape[1] == (len(points) if space == "nodal" else manifest(out)["cells"])


# --- Contact and energy -----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def hit(run: Runner) -> Path:
    out = run(CONTACT, time__step=5e-3)
    assert table(out / "steps.csv")["contact_force_y"].max() > 1, "the body did not hit"
    return out


def test_force_is_that_on_the_body(hit: Path) -> None:
    assert (table(hit / "steps.csv")["contact_force_y"] >= 0).all() and (table(hit / "contact.csv")["normal_y"] == 1).all()


def test_sum_of_step_times_force_is_the_impulse(hit: Path) -> None:
    assert 5e-3 * table(hit / "obstacles.csv")["force_y"].sum() == exactly(momentum(hit)[-1] - momentum(hit)[0])


def test_forces_in_axial_symmetry_are_those_of_the_whole_body(run: Runner) -> None:
    """A cylinder of 1 m and the radius 1 m swells until a tube stops it."""
    tube = '{ shape = "cylinder", point = [0, 0], radius = 1.01, side = "inside" }'
    out = run(f'[contact]\non = "right"\nobstacle = {tube}\n[initial]\nvelocity = ["x", "0"]\n', time__step=5e-3, mesh__model="axisymmetric")
    steps, obstacles, contact, probes = (table(out / f"{name}.csv") for name in ("steps", "obstacles", "contact", "probes"))
    assert steps["normal_force"].max() > 1, "the tube was not hit"
    assert not steps["contact_force_x"].any() and not obstacles["force_x"].any() and manifest(out)["impact"]["all"]["impulse"][0] == 0
    for k in set(contact["step"]):
        now = contact["step"] == k
        assert contact["force"][now].sum() == exactly(steps["normal_force"][steps["step"] == k][0])
        assert contact["area"][now].sum() == exactly(2 * np.pi)
    assert [name for name in probes if name.startswith("body.")] == ["body.center_y", "body.momentum_y"]


def test_energy_law_of_a_step(hit: Path) -> None:
    steps = table(hit / "steps.csv")
    energy = steps["kinetic_energy"] + steps["elastic_energy"]
    works = steps["external_work"] + steps["contact_work"] - steps["viscous_dissipation"]
    assert np.diff(energy) - works[1:] == exactly(np.zeros(100))


def test_contact_never_does_work(hit: Path) -> None:
    assert (table(hit / "steps.csv")["contact_work"] <= 1e-12).all()


def test_external_work_includes_that_of_clamps_and_load_work_does_not(run: Runner) -> None:
    steps = table(run('[[clamp]]\non = "left"\nvalue = ["0.01*t^2", "0"]\n') / "steps.csv")
    energy = steps["kinetic_energy"] + steps["elastic_energy"]
    assert energy[-1] > 0
    assert steps["external_work"].sum() == exactly(energy[-1] - energy[0])
    assert steps["load_work"] == exactly(np.zeros(6))


@pytest.mark.parametrize("load, weak", (("0", 11), ("-1", 0)), ids=("without a force", "under its weight"))
def test_candidates_of_a_standing_body_are_active(run: Runner, load: str, weak: int) -> None:
    """Weak are those without a force."""
    text = CONTACT.split("[initial]")[0].replace("-0.1", "0") + f'[load]\nbody = ["0", "{load}"]\n'
    steps = table(run(text, time__scheme="contact-stabilized") / "steps.csv")
    assert steps["active"][1:].tolist() == [11] * 5 and steps["weak"][1:].tolist() == [weak] * 5


# --- Searches and studies ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def found(run: Runner) -> Path:
    """A search with contact and bounds."""
    return run(CONTACT + '[control]\nscale = 1.0\nlower = -2.0\nupper = 2.0\n[objective]\ndesired = { control = ["0", "-2"] }\n'
               'alpha = 1e-2\ngamma = 1e-2\n[optimizer]\nmax_iterations = 5\n', "optimize", time__step=5e-3)  # fmt: skip


def test_steps_of_a_search_belong_to_the_last_iterate(found: Path) -> None:
    """The end state counts without a half."""
    error, J = table(found / "steps.csv")["tracking_error"] ** 2, manifest(found)["objective"]
    assert 5e-3 / 4 * (error[1:] + error[:-1]).sum() == exactly(J["tracking"])
    assert 1e-2 * error[-1] == exactly(J["terminal"])
    assert table(found / "history.csv")["objective"][-1] == exactly(J["value"])


def test_sweeps_are_those_of_the_search(found: Path) -> None:
    history, search = table(found / "history.csv"), manifest(found)["optimizer"]
    assert history["forward_sweeps"][-1] > history["adjoint_sweeps"][-1] > 5
    for here, there in (("iterations", "iteration"), ("forward_sweeps", "forward_sweeps"), ("adjoint_sweeps", "adjoint_sweeps")):
        assert search[here] == history[there][-1]


@pytest.mark.parametrize("initial, bounds", (((0.1, -0.2), ""), ((0, 0), "lower = 0\nupper = 1e3\n")), ids=("no bounds", "bounds"))
def test_gradient_norm(run: Runner, initial: tuple[float, float], bounds: str) -> None:
    """The norm in L2(0,T; L2), by the stored adjoint state; with bounds, by the lumped mass matrix, of what does not point out of them."""
    alpha, scale = 0.3, 2.0
    text = f"[control]\nscale = {scale}\ninitial = {[str(part) for part in initial]}\n{bounds}[objective]\nalpha = {alpha}\n" \
           'desired = { displacement = ["(sin(3*y) - 0.5)*t", "-x*t"] }\n[optimizer]\nmax_iterations = 0\n'  # fmt: skip
    out = run(text, "optimize", time__end=0.4)
    points, cells, p = stored(out, "adjoint", "adjoint")
    g = alpha * np.array(initial) + TAU * scale / 2 * p[..., :2]
    sides = points[cells[:, 1:], :2] - points[cells[:, :1], :2]
    area = abs(np.linalg.det(sides)) / 2
    mass = np.zeros((len(points), len(points)))
    for i, j in itertools.product(range(3), repeat=2):
        np.add.at(mass, (cells[:, i], cells[:, j]), area / 12 * (1 + (i == j)))
    if bounds:  # the control is at the lower ones
        assert (g > 0).any() and (g < 0).any(), "all gradients have the same sign"
        lumped = mass.sum(axis=1)
        g, mass = np.minimum(np.einsum("ij,kjc->kic", mass / lumped[:, None], g), 0), np.diag(lumped)
    assert table(out / "history.csv")["gradient_norm"][0] == exactly(np.sqrt(TAU * np.einsum("kic,ij,kjc->", g, mass, g)))


def rows(folder: Path, text: str, *options: str) -> dict[str, np.ndarray]:
    """study.csv of the square with more tables."""
    (folder / "scene.toml").write_text(SQUARE + text)
    study(folder / "scene.toml", folder / "study", "--sizes", "0.25", *options)
    return table(folder / "study" / "study.csv")


def test_error_of_a_field_is_relative_to_its_norm(tmp_path: Path) -> None:
    """Against a displacement that is wrong by a known part."""
    flight = CONTACT.replace("-0.1", "-9") + '[exact]\ndisplacement = ["0", "-1.25*t"]\n'
    assert rows(tmp_path, flight, "--steps", "0.1", "--quantity", "displacement")["displacement_error"] == exactly(np.array([0.2]))


def test_error_of_a_field_in_axial_symmetry_is_over_the_whole_body(tmp_path: Path) -> None:
    """The error t x in -t (1 + x), with the weight x of the integrals: 1/4 over 17/12."""
    flight = CONTACT.replace("-0.1", "-9") + '[exact]\ndisplacement = ["0", "-t*(1 + x)"]\n'
    found = rows(tmp_path, flight, "--steps", "0.1", "--quantity", "displacement", "--set", "mesh.model=axisymmetric")
    assert found["displacement_error"] == exactly(np.array([np.sqrt(3 / 17)]))


def test_error_of_a_number_is_relative_to_its_value(tmp_path: Path) -> None:
    """The error of energy_loss, of which none is exact, is a plain difference."""
    text = CONTACT.replace("-0.1", "-0.12") + "[exact]\nimpulse = 2\n"
    found = rows(tmp_path, text, "--steps", "0.05,0.0125", "--quantity", "impulse,energy_loss")
    assert np.min(found["impulse"]) > 0 and np.ptp(found["energy_loss"]) > 1e-3
    assert found["impulse_error"] == exactly(abs(found["impulse"] / 2 - 1))
    assert found["energy_loss_error"] == exactly(found["energy_loss"])


# --- Fits -------------------------------------------------------------------------------------------------------------

LENGTH = 0.011  # of a step: the block, 0.1 m above and with 1 m/s, touches within one
MEASURED = """
[[unknown]]
of = "young"
start = 1.1e3
scale = "{scale}"
[[measurement]]
of = "force"
component = "y"
file = "{file}"
deviation = {deviation}
[[measurement]]
of = "contact-start"
value = 0.1
deviation = 1e-3
[[measurement]]
of = "contact-time"
value = 0.06
"""


@pytest.fixture(scope="module", params=("contact-implicit", "contact-stabilized"))
def scheme(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(scope="module")
def fit(scheme: str, run: Runner, tmp_path_factory: pytest.TempPathFactory) -> Runner:
    """Fits by forces at the ends and in the middle of steps, and by contact times."""
    file, ends = tmp_path_factory.mktemp("data") / "force.csv", LENGTH * np.arange(1, 25)
    file.write_text("time,value\n" + "".join(f"{t!r},{10.0 * k}\n" for k, t in enumerate(np.sort([*ends, *(ends - LENGTH / 2)]).tolist())))

    @functools.cache
    def made(scale: str = "log", deviation: str = "2.0") -> Path:
        text = CONTACT + MEASURED.format(scale=scale, deviation=deviation, file=file)
        out = run(text, "optimize", optimizer__max_iterations=0, mesh__size=0.5, material__poisson=0.0,
                  time__scheme=scheme, time__step=LENGTH, time__end=25 * LENGTH)  # fmt: skip
        assert table(out / "obstacles.csv")["force_y"].max() > 10, "the body did not hit"
        return out

    return made


def test_measured_force_is_linear_between_steps(fit: Runner, scheme: str) -> None:
    """In the middle of step k it is F_k; of contact-implicit steps the mean of F_k and F_{k+1} at t_k."""
    data, force = table(fit() / "measurements.csv")["simulated"], table(fit() / "obstacles.csv")["force_y"]
    means = (force[1:-1] + force[2:]) / 2
    assert data[1::2] == exactly(means)
    if scheme == "contact-stabilized":
        assert data[::2] == exactly(force[1:-1])
    else:
        assert data[2::2] == exactly((means[1:] + means[:-1]) / 2)


def test_residual_is_in_standard_deviations(fit: Runner) -> None:
    data = table(fit() / "measurements.csv")
    assert data["residual"] == exactly((data["simulated"] - data["value"]) / 2)


def test_misfit_is_the_root_mean_square_of_residuals(fit: Runner) -> None:
    """Smaller where deviations are larger."""
    square = np.mean(table(fit() / "measurements.csv")["residual"] ** 2)
    misfits = [manifest(out)["fit"]["misfit"] for out in (fit(), fit(deviation="4.0"))]
    assert misfits == exactly([np.sqrt(square), np.sqrt(square) / 2])


@pytest.mark.parametrize("name", ("standard_deviation", "gradient"))
def test_unit_of_the_unknown_on_a_logarithmic_scale_too(fit: Runner, name: str) -> None:
    on_log, on_linear = (table(out / "parameters.csv")[name][0] for out in (fit(), fit("linear")))
    assert name == "gradient" or on_log > 0
    assert on_log / on_linear == exactly(1)


def intervals_of_contact(out: Path) -> list[list[float]]:
    """Begin and end of each interval of contact within the steps, by gaps continued linearly, from contact.csv."""
    contact = table(out / "contact.csv")
    times = np.unique(contact["time"])
    gaps, forces = (contact[name].reshape(len(times), -1) for name in ("gap", "force"))
    touching, found = (forces > 0).any(axis=1), []

    def crossing(near: np.ndarray, far: np.ndarray) -> float:
        """In steps, from the nearer gap; in the middle of the step where the two do not fall towards the contact."""
        falls = far > near
        return np.min(np.where(falls, np.clip(near / np.where(falls, far - near, 1), 0, 1), 0.5))

    for k in range(2, len(times)):
        if touching[k] and not touching[k - 1]:
            found.append([times[k - 1] + LENGTH * crossing(*(gaps[k - i][forces[k] > 0] for i in (1, 2))), times[k]])
        elif touching[k]:
            found[-1][1] = times[k]
        elif touching[k - 1] and k + 1 < len(times):
            found[-1][1] = times[k] - LENGTH * crossing(*(gaps[k + i][forces[k - 1] > 0] for i in (0, 1)))
    assert found and not touching[-2:].any()
    return found


def test_measured_contact_times_are_within_a_step(fit: Runner) -> None:
    """Gaps are continued linearly; a free fall touches when it does."""
    start, lasting = (one["simulated"] for one in {one["name"]: one for one in manifest(fit())["fit"]["contact_times"]}.values())
    intervals = intervals_of_contact(fit())
    assert [start, lasting] == exactly([intervals[0][0], sum(end - begin for begin, end in intervals)])
    assert start == exactly(0.1)


def test_impact_begins_and_ends_with_steps(fit: Runner) -> None:
    """At the begin of the first step with a force and at the end of the last one."""
    impact, steps = manifest(fit())["impact"]["all"], np.flatnonzero(table(fit() / "obstacles.csv")["force_y"] > 0)
    assert [impact["start"], impact["end"]] == exactly([(steps[0] - 1) * LENGTH, steps[-1] * LENGTH])
