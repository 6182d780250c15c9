# SPDX-License-Identifier: GPL-3.0-or-later
"""How accurate the rungs of a study are: orders where the solution is known, what it recommends, estimates and suggests."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_DISC, SOURCE, table
from studies import IMPACT, study

WAVE = SOURCE / "scenes" / "standing-wave.toml"
BOUNCE = SOURCE / "scenes" / "bouncing-bar.toml"
PRESS = SOURCE / "scenes" / "hertz-press.toml"
SCHEMES = (("contact-implicit", "consistent"), ("contact-stabilized", "consistent"), ("contact-implicit", "massless"))
ALL_SCHEMES = ("--schemes", "contact-implicit,contact-stabilized,massless")
IMPACT_SIZES, IMPACT_STEPS = (0.5, 0.25, 0.125, 0.0625), (120, 240, 480, 960)
IMPACT_RUNGS = ("--sizes", ",".join(map(str, IMPACT_SIZES)), "--steps", ",".join(f"{2 / n:.10g}" for n in IMPACT_STEPS))
TRUTH = {"impulse": 200.0, "contact_start": 0.5, "contact_time": 2 / 3}  # of the bar's impact
NUMBER = r"([\d.e+-]+)"
# Of a search for a size and a step: next trials are priced by the seconds of earlier ones, ten times as many on a busy machine.
PATIENT = ("--budget", "100h")


def order(folder: Path, quantity: str, kind: str, degree: int = 1, scheme: str = "contact-implicit", mass: str = "consistent") -> float:
    (found,) = (one for one in json.loads((folder / "study.json").read_text())["orders"]
                if (one["quantity"], one["degree"], one["scheme"], one["mass"]) == (quantity, degree, scheme, mass))  # fmt: skip
    print(f"{folder.name}: {quantity}, degree {degree}, {scheme}, {mass}: order {found[kind]:.2f} in {kind}, "
          f"{found['scatter'][kind][0]:.2f} to {found['scatter'][kind][1]:.2f}, "
          f"{'' if found['asymptotic'][kind] else 'not '}in the asymptotic range")  # fmt: skip
    return found[kind]


@pytest.fixture(scope="module")
def wave(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("study") / "wave"
    study(WAVE, out, "--degrees", "1,2", "--sizes", "2,1,0.5,0.25", "--steps", "0.0666667,0.0333333,0.01666667,0.00833333")
    return out


@pytest.fixture(scope="module")
def impact(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("study") / "impact"
    study(IMPACT, out, *ALL_SCHEMES, *IMPACT_RUNGS, "--quantity", "displacement,impulse,contact_start,contact_time")
    return out


@pytest.fixture(scope="module")
def bounce(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("study") / "bounce"
    study(BOUNCE, out, *ALL_SCHEMES, "--sizes", "0.5,0.25,0.125", "--steps", "0.0166667,0.00833333,0.00416667",
          "--quantity", "displacement", "--set", "time.end=5.333333333333333", "--set", "time.step=0.005333333333333333",
          "--set", "exact.impulse=533.3333333333333", "--set", "exact.contact_time=1.3333333333333333")  # fmt: skip
    return out


@pytest.fixture(scope="module")
def press(tmp_path_factory: pytest.TempPathFactory) -> dict[str, np.ndarray]:
    out = tmp_path_factory.mktemp("study") / "press"
    study(PRESS, out, "--sizes", "16,4,1", "--steps", "0.1", "--degrees", "1,2", "--quantity", "pressure")
    return table(out / "study.csv")


@pytest.mark.parametrize("degree", (1, 2))
def test_order_of_a_wave(wave: Path, degree: int) -> None:
    """Of functions of degree r: r + 1 in space, where waves do not spoil it with their dispersion 2, and 2 in time."""
    assert order(wave, "displacement", "time", degree) == pytest.approx(2, abs=0.2)
    assert order(wave, "displacement", "both", degree) == pytest.approx(2, abs=0.2)
    if degree == 1:
        assert order(wave, "displacement", "space", 1) == pytest.approx(2, abs=0.3)
    else:
        assert order(wave, "displacement", "space", 2) > 2.5


@pytest.mark.parametrize("scheme, mass", SCHEMES)
def test_order_of_an_impact(impact: Path, scheme: str, mass: str) -> None:
    """Of its fronts 2/3 (tests/verification/bar.py), of the contact-implicit scheme whose energy falls less."""
    assert 0.4 < order(impact, "displacement", "both", 1, scheme, mass) < 1.1


def test_errors_of_an_impact(impact: Path) -> None:
    errors = table(impact / "study.csv")["displacement_error"]
    assert errors.min() < 0.02 < errors.max()


@pytest.mark.parametrize("scheme, mass", SCHEMES)
def test_order_of_a_bounce(bounce: Path, scheme: str, mass: str) -> None:
    assert 0.4 < order(bounce, "displacement", "both", 1, scheme, mass) < 1.3


@pytest.mark.parametrize("degree", (1, 2))
def test_pressure_of_hertz(press: dict[str, np.ndarray], degree: int) -> None:
    """Hertz's solution is that of a half-plane: on this disc it holds to about (a/R)^2 = 0.7 %, and beyond nothing converges to it.
    Pressures of either degree come within it; those of nodes that functions of degree 2 give no share of their face would not."""
    there = press["degree"] == degree
    errors = press["pressure_error"][there]
    print("pressure off by", *(f"{100 * error:.2f} %" for error in errors))
    assert list(press["size"][there]) == [16, 4, 1] and errors.max() > 0.04 and errors[-1] < 0.02


def recommended(folder: Path, title: str) -> list[tuple[float, float, float]]:
    """Tolerance, size and step of what a study's sentences recommend for a quantity."""
    said = [re.match(rf"for an error of (\S+) % in {title}: size (\S+), step ([^,]+),", text)
            for text in json.loads((folder / "study.json").read_text())["sentences"]]  # fmt: skip
    return [(float(found[1]) / 100, float(found[2]), float(found[3])) for found in said if found]


def test_recommendations(impact: Path, tmp_path: Path) -> None:
    """Of three sizes and three steps of the bar's impact, for which it is not known that its solution is: what is recommended is as
    accurate as promised, as are all finer rungs, and the solution lies within the error bars. With the differences to the finest rung
    alone it would not."""
    text = re.sub(r"\[exact\].*?(?=\[output\])", "", IMPACT.read_text(), flags=re.DOTALL).replace("../meshes", str(SOURCE / "meshes"))
    scene, out = tmp_path / "bar-impact.toml", shutil.copytree(impact, tmp_path / "impact")
    scene.write_text(text)
    whole = table(impact / "study.csv")
    named = {name: json.loads((impact / "study.json").read_text())["quantities"][name]["title"] for name in TRUTH}
    given, broken, broken_later, naive, naive_broken, bars, right = 0, 0, 0, 0, 0, 0, 0
    for scheme, mass in SCHEMES:
        own = (whole["scheme"] == scheme) & (whole["mass"] == mass)
        for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
            sizes, steps = ",".join(map(str, IMPACT_SIZES[i : i + 3])), ",".join(f"{2 / n:.10g}" for n in IMPACT_STEPS[j : j + 3])
            said = study(scene, out, "--schemes", "massless" if mass == "massless" else scheme, "--sizes", sizes, "--steps", steps,
                         "--quantity", ",".join(TRUTH))  # fmt: skip
            assert "9 of 9 rungs were already stored in the folder" in said.stdout
            rows = table(out / "study.csv")
            bar = {name: one["bar"] for name, one in json.loads((out / "study.json").read_text())["quantities"].items()}
            finest = (rows["size"] == rows["size"].min()) & (rows["steps"] == rows["steps"].max())
            for name, truth in TRUTH.items():
                off = np.abs(whole[name] / truth - 1)
                bars += 1
                right += abs(rows[name][finest][0] / truth - 1) <= bar[name]["value"] * (1 + 1e-6) + 1e-9
                for tolerance, size, step in recommended(out, named[name]):
                    there = own & np.isclose(whole["size"], size, rtol=1e-12, atol=0) & np.isclose(whole["step"], step, rtol=1e-2, atol=0)
                    finer = own & (whole["size"] <= size * 1.001) & (whole["step"] <= step * 1.01)
                    assert sum(there) == 1
                    given += 1
                    broken += off[there][0] > tolerance
                    broken_later += np.max(off[finer]) > tolerance
                for tolerance in (0.1, 0.05, 0.01, 0.001):
                    near = np.nonzero(rows[f"{name}_error"] <= tolerance)[0]
                    if len(near):
                        naive += 1
                        naive_broken += abs(rows[name][near[np.argmin(rows["seconds"][near])]] / truth - 1) > tolerance
    print(f"{given} recommendations, {broken} off by more at the rung and {broken_later} there or later; by the differences to the "
          f"finest rung {naive_broken} of {naive} would be; {right} of {bars} error bars are right")  # fmt: skip
    assert given > 30 and broken == 0 and broken_later <= 0.05 * given and naive_broken > 0.1 * naive and right >= 0.95 * bars


def test_contact_times(tmp_path: Path) -> None:
    """A bar in free flight touches at 1/2 s, wherever that is within a step, and is found to do so to rounding; it leaves at 7/6 s, where
    waves have made its end less sharp. By whole steps start and time would be off by up to half a step and a step."""
    ends = [2 / steps for steps in (97, 233, 391)]
    study(IMPACT, tmp_path, *ALL_SCHEMES, "--degrees", "1,2", "--sizes", "0.5,0.25", "--steps", ",".join(f"{step:.12g}" for step in ends),
          "--quantity", "contact_start,contact_time")  # fmt: skip
    rows = table(tmp_path / "study.csv")
    assert len(rows["rung"]) == 36 and set(rows["steps"]) == {97, 233, 391}
    whole_steps = np.abs((np.floor(0.5 / rows["step"]) + 0.5) * rows["step"] - 0.5)
    assert np.max(whole_steps / rows["step"]) > 0.2, "1/2 s is in the middle of all steps: the case says nothing"
    late = np.abs(rows["contact_time"] - 2 / 3) / rows["step"]
    print(f"start of contact off by at most {rows['contact_start_error'].max():.0e} of it, time by {np.median(late):.2f} steps, "
          f"at most {late.max():.2f}")  # fmt: skip
    assert rows["contact_start_error"].max() < 1e-10


def estimates(said: str) -> list[list[float]]:
    """The parts of each trial's estimate. Its error is at least twice their sum, or that of their moduli if that is more; that in space is at
    least what a mesh twice as coarse shows."""
    parts = []
    for error, *found in re.findall(r"estimated relative error at most (\S+) \(space (\S+), time (\S+); (\S+) by a mesh twice as coarse\)", said):
        space, time, by_mesh = map(float, found)
        parts.append([space, time])
        total = np.maximum(2 * abs(space + time), abs(space) + abs(time))
        in_time = abs(time) / (abs(space) + abs(time)) * total
        assert abs(float(error) - np.maximum(total, in_time + by_mesh)) < 0.03 * float(error), said
    return parts


def test_suggested_for_J(tmp_path: Path) -> None:
    """The tolerance is met by what the estimate says at most and in truth, beside a run with a quarter of the size and of the step,
    whose error is a sixteenth of that."""
    tolerance = 1e-2
    said = study(HALF_DISC, None, "--suggest", tolerance, *PATIENT, "--set", "mesh.size=3", "--set", "time.step=2.5e-4").stdout
    assert len(estimates(said)) >= 2
    found = re.search(rf"0\.01 in J is met by: .* estimated relative error at most {NUMBER}", said)
    there = re.search(rf"^in the scene: mesh.size = {NUMBER}, mesh.degree = 1, time.step = {NUMBER}$", said, re.MULTILINE)
    assert found and there, said
    (size, step), estimate = map(float, there.groups()), float(found[1])
    assert estimate <= tolerance
    study(HALF_DISC, tmp_path, "--sizes", f"{size},{size / 4}", "--steps", f"{step},{step / 4}", "--quantity", "J")
    rows = table(tmp_path / "study.csv")
    here = (rows["size"] == size) & (rows["steps"] == rows["steps"].min())
    assert sum(here) == 1 and sum(np.isnan(rows["J_error"])) == 1
    error = rows["J_error"][here][0]
    print(f"suggested size {size:g}, step {step:g} s: error {error:.1e}, by its estimate at most {estimate:.1e}")
    assert error <= tolerance and error <= estimate


# The flat face of a block, which touches with all nodes at once, is pulled off the plane again: errors of first order in the size, of
# which the adjoint estimate, with frozen active sets, sees a tenth.
LIFTED = {"objective.desired": '{displacement=["0", "0.2*t"]}', "check.control": '["0", "1"]'}


def test_suggested_for_a_flat_face(tmp_path: Path) -> None:
    """The comparison with a coarser mesh sees what the estimate misses: J at the suggestion is as accurate as promised."""
    tolerance = 4e-2
    lifted = [word for key, value in LIFTED.items() for word in ("--set", f"{key}={value}")]
    said = study(SOURCE / "scenes" / "block.toml", None, "--suggest", tolerance, *PATIENT, *lifted).stdout
    assert len(estimates(said)) >= 2, "the scene's own mesh is enough: the case says nothing"
    there = re.search(rf"^in the scene: mesh.size = {NUMBER}, mesh.degree = 1, time.step = {NUMBER}$", said, re.MULTILINE)
    assert there and "0.04 in J is met by" in said, said
    size, step = map(float, there.groups())
    study(SOURCE / "scenes" / "block.toml", tmp_path, "--sizes", f"{size},{size / 2},{size / 4}", "--steps", str(step), "--quantity", "J", *lifted)
    rows = table(tmp_path / "study.csv")
    J, estimate = rows["J"][np.argsort(-rows["size"])], rows["J_estimate"][rows["size"] == size][0]
    limit = J[2] + (J[2] - J[1])  # of first order
    error = abs(J[0] / limit - 1)
    print(f"suggested size {size:g}: error {error:.1e}, adjoint estimate {estimate:.1e}")
    assert abs(J[2] - J[1]) < 0.7 * abs(J[1] - J[0]), "not yet of first order"
    assert tolerance / 20 < error <= tolerance and estimate < error / 3


def test_parts_of_opposite_sign() -> None:
    """They make up for each other by chance: the moduli count."""
    beyond = study(HALF_DISC, None, "--suggest", "1e-9", "--budget", "1e-9s", "--set", "mesh.size=6", "--set", "time.step=1.25e-4",
                   "--set", "time.end=4e-3", status=1).stdout  # fmt: skip
    assert "exceed the budget" in beyond and "not met" in beyond
    (parts,) = estimates(beyond)
    assert parts[0] * parts[1] < 0 and 2 * abs(sum(parts)) < sum(map(abs, parts))


@pytest.mark.parametrize("name", ("impulse", "contact_time"))
def test_suggested_for_a_quantity(name: str) -> None:
    """Without an objective: what is found for a tolerance is the exact value to that tolerance, for any quantity of contact. Error bars are
    some ten times the error there; one per cent takes 25 times as long as two."""
    coarse = ("--set", "mesh.size=0.5", "--set", "time.step=0.01")
    said = study(IMPACT, None, "--suggest", "2e-2", *PATIENT, "--quantity", name, *coarse).stdout
    found = re.search(rf"0\.02 in .* is met by: size {NUMBER}, step {NUMBER}, degree [12], .* {NUMBER} \S.*, error bar {NUMBER} %", said)
    assert found, said
    off, bar = abs(float(found[3]) / TRUTH[name] - 1), float(found[4]) / 100
    print(f"suggested size {found[1]}, step {found[2]} s: {off:.1e} off, its error bar {bar:.1e}")
    assert bar <= 2e-2 and off <= bar


def test_beyond_the_budget() -> None:
    beyond = study(IMPACT, None, "--suggest", "1e-9", "--quantity", "impulse", "--budget", "1e-9s", status=1).stdout
    assert "exceed the budget" in beyond and "not met" in beyond
