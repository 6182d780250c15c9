# SPDX-License-Identifier: GPL-3.0-or-later
"""How accurate the rungs of a study are: orders where the solution is known, what it recommends, estimates and suggests."""

import json
import re
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SOURCE, table  # noqa: E402
from studies import IMPACT, pressure, study  # noqa: E402

import numpy as np  # noqa: E402

WAVE = SOURCE / "scenes" / "standing-wave.toml"
BOUNCE = SOURCE / "scenes" / "bouncing-bar.toml"
PRESS = SOURCE / "scenes" / "hertz-press.toml"
SCHEMES = (("contact-implicit", "consistent"), ("contact-stabilized", "consistent"), ("contact-implicit", "massless"))
IMPACT_SIZES, IMPACT_STEPS = (0.5, 0.25, 0.125, 0.0625), (120, 240, 480, 960)
IMPACT_LADDER = ("--sizes", ",".join(map(str, IMPACT_SIZES)), "--steps", ",".join(f"{2 / n:.10g}" for n in IMPACT_STEPS))
TRUTH = {"impulse": 200.0, "contact_start": 0.5, "contact_time": 2 / 3}  # of the bar's impact


def order(folder: Path, quantity: str, kind: str, degree: int = 1, scheme: str = "contact-implicit", mass: str = "consistent") -> float:
    found = [one for one in json.loads((folder / "study.json").read_text())["orders"]
             if (one["quantity"], one["degree"], one["scheme"], one["mass"]) == (quantity, degree, scheme, mass)]  # fmt: skip
    assert len(found) == 1, found
    print(f"{folder.name}: {quantity}, degree {degree}, {scheme}, {mass}: order {found[0][kind]:.2f} in {kind}, "
          f"{found[0]['scatter'][kind][0]:.2f} to {found[0]['scatter'][kind][1]:.2f}, "
          f"{'' if found[0]['asymptotic'][kind] else 'not '}in the asymptotic range")
    return found[0][kind]


def orders(folder: Path) -> None:
    """Of functions of degree r: r + 1 in space, where waves do not spoil it with their dispersion 2, and 2 in time; fronts of
    an impact 2/3 of that (tests/verification/bar.py), of the contact-implicit scheme whose energy falls less."""
    study(WAVE, folder / "wave", "--degrees", "1,2", "--sizes", "2,1,0.5,0.25", "--steps", "0.0666667,0.0333333,0.01666667,0.00833333")
    for degree in (1, 2):
        assert abs(order(folder / "wave", "displacement", "time", degree) - 2) < 0.2
        assert abs(order(folder / "wave", "displacement", "both", degree) - 2) < 0.2
    assert abs(order(folder / "wave", "displacement", "space", 1) - 2) < 0.3
    assert order(folder / "wave", "displacement", "space", 2) > 2.5
    study(IMPACT, folder / "impact", "--schemes", "contact-implicit,contact-stabilized,massless", *IMPACT_LADDER, "--quantity",
          "displacement,impulse,contact_start,contact_time")  # fmt: skip
    for scheme, mass in SCHEMES:
        assert 0.4 < order(folder / "impact", "displacement", "both", 1, scheme, mass) < 1.1
    errors = table(folder / "impact" / "study.csv")["displacement_error"]
    assert np.min(errors) < 0.02 < np.max(errors)
    study(BOUNCE, folder / "bounce", "--schemes", "contact-implicit,contact-stabilized,massless", "--sizes", "0.5,0.25,0.125",
          "--set", "time.end=5.333333333333333", "--set", "time.step=0.005333333333333333", "--set", "exact.impulse=533.3333333333333",
          "--set", "exact.contact_time=1.3333333333333333", "--steps", "0.0166667,0.00833333,0.00416667", "--quantity", "displacement")  # fmt: skip
    for scheme, mass in SCHEMES:
        assert 0.4 < order(folder / "bounce", "displacement", "both", 1, scheme, mass) < 1.3
    # Hertz's solution is that of a half-plane: on this disc it holds to about (a/R)^2 = 0.7 %, and beyond nothing converges to it.
    # Pressures of either degree come within it; those of nodes that functions of degree 2 give no share of their face would not.
    study(PRESS, folder / "press", "--sizes", "16,4,1", "--steps", "0.1", "--degrees", "1,2", "--quantity", "pressure")
    rows = table(folder / "press" / "study.csv")
    for degree in (1, 2):
        there = rows["degree"] == degree
        errors = rows["pressure_error"][there]
        print(f"Hertz, degree {degree}: pressure off by", *(f"{100 * error:.2f} %" for error in errors))
        assert list(rows["size"][there]) == [16, 4, 1] and np.max(errors) > 0.04 and errors[-1] < 0.02


def recommended(folder: Path, title: str) -> list[tuple[float, float, float]]:
    """Tolerance, size and step of what a study's sentences recommend for a quantity."""
    said = [re.match(rf"for (\S+) % in {title}: size (\S+), step ([^,]+),", text)
            for text in json.loads((folder / "study.json").read_text())["sentences"]]  # fmt: skip
    return [(float(found[1]) / 100, float(found[2]), float(found[3])) for found in said if found]


def promises(folder: Path) -> None:
    """Ladders of three sizes and three steps of the bar's impact, for which it is not known that its solution is: what they recommend is as
    accurate as they say, as are the rungs of the whole ladder that are finer, and the solution lies within the error bars. With the
    differences to the finest rung alone it would not. Run after orders(), whose rungs it takes."""
    text = re.sub(r"\[exact\].*?(?=\[output\])", "", IMPACT.read_text(), flags=re.DOTALL).replace("../meshes", str(SOURCE / "meshes"))
    scene = folder / "bar-impact.toml"
    scene.write_text(text)
    whole = table(folder / "impact" / "study.csv")
    named = {name: json.loads((folder / "impact" / "study.json").read_text())["quantities"][name]["title"] for name in TRUTH}
    given, broken, broken_later, naive, naive_broken, bars, held = 0, 0, 0, 0, 0, 0, 0
    for scheme, mass in SCHEMES:
        own = (whole["scheme"] == scheme) & (whole["mass"] == mass)
        for i in (0, 1):
            for j in (0, 1):
                steps = ",".join(f"{2 / n:.10g}" for n in IMPACT_STEPS[j : j + 3])
                said = study(scene, folder / "impact", "--schemes", "massless" if mass == "massless" else scheme, "--sizes",
                             ",".join(map(str, IMPACT_SIZES[i : i + 3])), "--steps", steps, "--quantity", ",".join(TRUTH))  # fmt: skip
                assert "9 of 9 rungs were there already" in said.stdout
                rows = table(folder / "impact" / "study.csv")
                bar = {name: one["bar"] for name, one in json.loads((folder / "impact" / "study.json").read_text())["quantities"].items()}
                finest = (rows["size"] == np.min(rows["size"])) & (rows["steps"] == np.max(rows["steps"]))
                for name, truth in TRUTH.items():
                    off = np.abs(whole[name] / truth - 1)
                    bars += 1
                    held += abs(rows[name][finest][0] / truth - 1) <= bar[name]["value"] * (1 + 1e-6) + 1e-9
                    for tolerance, size, step in recommended(folder / "impact", named[name]):
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
    print(f"bar impact: {given} recommendations, {broken} off by more at the rung and {broken_later} there or later; by the differences to the "
          f"finest rung {naive_broken} of {naive} would be; {held} of {bars} error bars hold")  # fmt: skip
    assert given > 30 and broken == 0 and broken_later <= 0.05 * given and naive_broken > 0.1 * naive and held >= 0.95 * bars


def contact_times(folder: Path) -> None:
    """A bar in free flight touches at 1/2 s, wherever that is within a step, and is told so to rounding; it leaves at 7/6 s, where waves
    have made its end less sharp. By whole steps start and time would be off by up to half a step and a step."""
    ends = [2 / steps for steps in (97, 233, 391)]
    study(IMPACT, folder / "times", "--schemes", "contact-implicit,contact-stabilized,massless", "--degrees", "1,2", "--sizes", "0.5,0.25",
          "--steps", ",".join(f"{step:.12g}" for step in ends), "--quantity", "contact_start,contact_time")  # fmt: skip
    rows = table(folder / "times" / "study.csv")
    assert len(rows["rung"]) == 36 and set(rows["steps"]) == {97, 233, 391}
    whole_steps = np.abs((np.floor(0.5 / rows["step"]) + 0.5) * rows["step"] - 0.5)
    assert np.max(whole_steps / rows["step"]) > 0.2, "1/2 s is in the middle of all steps: the case says nothing"
    late = np.abs(rows["contact_time"] - 2 / 3) / rows["step"]
    print(f"start of contact off by at most {np.max(rows['contact_start_error']):.0e} of it, time by {np.median(late):.2f} steps, "
          f"at most {np.max(late):.2f}")
    assert np.max(rows["contact_start_error"]) < 1e-10


def moduli(said: str) -> list[list[float]]:
    """The parts of each trial's estimate, which is twice their sum, or that of their moduli if that is more."""
    parts = []
    for error, *found in re.findall(r"estimated error at most (\S+) \(space (\S+), time (\S+)\)", said):
        parts.append([float(part) for part in found])
        assert abs(float(error) - np.maximum(2 * abs(sum(parts[-1])), sum(map(abs, parts[-1])))) < 0.02 * float(error), said
    return parts


def suggestion(folder: Path) -> None:
    """The tolerance is met by what the estimate says at most and in truth, beside a run with a quarter of the size and of the step,
    whose error is a sixteenth of that."""
    tolerance = 1e-2
    said = study(HALF_DISC, None, "--suggest", tolerance, "--set", "mesh.size=3", "--set", "time.step=2.5e-4").stdout
    assert len(moduli(said)) >= 2, said
    number = r"([\d.e+-]+)"
    found = re.search(rf"0\.01 in J is met by: size {number}, step {number}, degree 1, by their own estimate at most {number}", said)
    assert found, said
    size, step, estimate = map(float, found.groups())
    assert estimate <= tolerance
    study(HALF_DISC, folder / "truth", "--sizes", f"{size},{size / 4}", "--steps", f"{step},{step / 4}", "--quantity", "J")
    rows = table(folder / "truth" / "study.csv")
    here = (rows["size"] == size) & (rows["steps"] == np.min(rows["steps"]))
    assert sum(here) == 1 and sum(np.isnan(rows["J_error"])) == 1
    error = rows["J_error"][here][0]
    print(f"suggested size {size:g}, step {step:g} s: error {error:.1e}, by its estimate at most {estimate:.1e}")
    assert error <= tolerance and error <= estimate
    # Of parts of opposite sign, which make up for each other by chance, the moduli count.
    beyond = study(HALF_DISC, None, "--suggest", "1e-9", "--budget", "1e-9s", "--set", "mesh.size=6", "--set", "time.step=1.25e-4",
                   "--set", "time.end=4e-3", status=1).stdout  # fmt: skip
    assert "beyond the budget" in beyond and "not met" in beyond
    (parts,) = moduli(beyond)
    assert parts[0] * parts[1] < 0 and 2 * abs(sum(parts)) < sum(map(abs, parts)), beyond


def suggested_quantity(folder: Path) -> None:
    """Without an objective: what is found for a tolerance is the exact value to that tolerance, and for any quantity of contact. Error bars are
    some ten times the error there; one per cent takes 25 times as long as two."""
    number = r"([\d.e+-]+)"
    for name, truth in (("impulse", 200.0), ("contact_time", 2 / 3)):
        said = study(IMPACT, None, "--suggest", "2e-2", "--quantity", name, "--set", "mesh.size=0.5", "--set", "time.step=0.01").stdout
        found = re.search(rf"0\.02 in .* is met by: size {number}, step {number}, degree [12], .* {number} \S.*, error bar {number} %", said)
        assert found, said
        value, bar = float(found[3]), float(found[4]) / 100
        print(f"suggested for 2 % in {name}: size {found[1]}, step {found[2]} s: {abs(value / truth - 1):.1e} off, its error bar {bar:.1e}")
        assert bar <= 2e-2 and abs(value / truth - 1) <= bar
    beyond = study(IMPACT, None, "--suggest", "1e-9", "--quantity", "impulse", "--budget", "1e-9s", status=1).stdout
    assert "beyond the budget" in beyond and "not met" in beyond


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in (orders, promises, contact_times, pressure, suggestion, suggested_quantity):
            part(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
