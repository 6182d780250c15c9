# SPDX-License-Identifier: GPL-3.0-or-later
"""signorini study: what it prices, runs, reports and refuses.

What it keeps: study_kept.py and study_searches.py; on two ranks: study_ranks.py; how accurate its rungs are: study_accuracy.py.
"""

import json
import re
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from harness import HALF_DISC, SIGNORINI, SOURCE, captured, signorini, table
from soft_scenes import ONTO_A_SLOPE, soft
from studies import DATA, IMPACT, study

RING = SOURCE / "scenes" / "drop-ring.toml"
SIZES = ("--sizes", "4,2,1,0.7")
RUNGS = (*SIZES, "--steps", "2.5e-4,1.25e-4,1e-4,7.5e-5,5e-5,3.75e-5", "--quantity", "J")  # 24


@pytest.fixture(scope="module")
def continued(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """A study of four rungs that is continued to 24: first with a budget of nothing, then with one of the four damaged."""
    out = tmp_path_factory.mktemp("continued") / "out"
    study(HALF_DISC, out, *SIZES, "--steps", "2.5e-4", "--quantity", "J")
    stopped = study(HALF_DISC, out, *RUNGS, "--budget", "1e-9s").stdout
    some = table(out / "study.csv")
    (out / "rungs" / "size-4-steps-30-degree-1-contact-implicit.cbor").write_bytes(b"damaged")
    resumed = study(HALF_DISC, out, *RUNGS, "--budget", "100h").stdout
    return SimpleNamespace(out=out, stopped=stopped, some=some, resumed=resumed, rows=table(out / "study.csv"))


def test_nothing_is_written_without_a_rung(tmp_path: Path) -> None:
    none = study(HALF_DISC, tmp_path, *RUNGS, "--budget", "1e-9s").stdout
    assert "no rung has run: rung 1 would take about" in none and not (tmp_path / "study.csv").exists()


def test_budget_stops(continued: SimpleNamespace) -> None:
    """What is there is kept whatever the budget."""
    assert "4 of 24 rungs were already stored in the folder" in continued.stopped and "the budget ends before rung" in continued.stopped
    assert set(continued.some["size"]) == {4, 2, 1, 0.7} and list(continued.some["steps"]) == [30] * 4


def test_damaged_rung_runs_again(continued: SimpleNamespace) -> None:
    assert "3 of 24 rungs were already stored in the folder" in continued.resumed
    assert re.search(r"^rung \d+ of 24 runs again: its file is damaged", continued.resumed, re.MULTILINE)
    assert continued.resumed.count("runs again") == 1
    rows = continued.rows
    assert len(rows["rung"]) == 24 and np.isfinite(rows["J"]).all() and sum(np.isnan(rows["J_error"])) == 1


def test_priced_unknowns(continued: SimpleNamespace) -> None:
    """Those of the coarsest and a finer size are counted; from size to size they grow by a power."""
    priced = study(HALF_DISC, None, *RUNGS, "--dry-run").stdout
    assert "all 24: about" in priced and priced.count("size") == 24
    expected = re.findall(r"^ +\d+ +(\d+) .* size ([\d.]+), step ([\d.e-]+),", priced, re.MULTILINE)
    rows = continued.rows
    found = {(size, round(7.5e-3 / steps, 9)): unknowns for size, steps, unknowns in zip(rows["size"], rows["steps"], rows["unknowns"])}
    off = [float(count) / found[float(size), float(step)] - 1 for count, size, step in expected]
    assert len(off) == 24 and np.max(np.abs(off)) < 0.15 and sum(one == 0 for one in off) >= 12


def test_nothing_runs_twice(continued: SimpleNamespace) -> None:
    before = (continued.out / "study.csv").read_bytes()
    again = study(HALF_DISC, continued.out, *RUNGS).stdout
    assert "24 of 24 rungs were already stored in the folder" in again and "rung 1 of 24: size" not in again
    assert (continued.out / "study.csv").read_bytes() == before


def test_envelope(continued: SimpleNamespace) -> None:
    """The largest error of a rung and of those that are finer; on the Pareto front nothing quicker has a smaller one."""
    rows = continued.rows
    for size, steps, envelope in zip(rows["size"], rows["steps"], rows["J_envelope"]):
        finer = rows["J_error"][(rows["size"] <= size) & (rows["steps"] >= steps)]
        assert np.isnan(finer).all() if np.isnan(envelope) else envelope == np.nanmax(finer)
    for s, e, front in zip(rows["seconds"], rows["J_envelope"], rows["J_pareto"]):
        beaten = np.isnan(e) or bool(((rows["seconds"] < s) & (rows["J_envelope"] <= e)).any())
        assert front == (not beaten)


def test_effectivity(continued: SimpleNamespace) -> None:
    effectivity = continued.rows["J_effectivity"][np.isfinite(continued.rows["J_effectivity"])]
    print(f"effectivity of {len(effectivity)} estimates of J's error: {effectivity.min():.2f} to {effectivity.max():.2f}")
    assert len(effectivity) > 10 and 0.5 < np.median(effectivity) < 2


@pytest.mark.parametrize("verb", ("optimize", "check", "study"))
def test_memory(verb: str, tmp_path: Path) -> None:
    """More steps than any machine has memory for the states of, in one sentence and before it is allocated."""
    options = ("--sizes", "0.5", "--steps", "7.5e-11") if verb == "study" else ()
    command = [str(SIGNORINI), verb, str(HALF_DISC), "--out", str(tmp_path / "out"), "--set", "time.step=7.5e-11", *options]
    done = captured(command, timeout=300)
    lines = done.stderr.splitlines()
    assert done.returncode == 2 and len(lines) == 1 and "time.step: found 7.5e-11 s" in lines[0] and "GB" in lines[0]


SQUEEZED = """
[mesh]
file = "{mesh}"
size = 0.25
[time]
end = 0.4
step = 0.01
[material]
density = 1.0
young = 50.0
poisson = 0.3
viscosity = {{ bulk = 1.0, shear = 1.0 }}
[[contact]]
on = "bottom"
obstacle = {{ shape = "half-space", point = [{zeros} "0.1*t"], normal = [{zeros} 1] }}
[[contact]]
on = "top"
obstacle = {{ shape = "half-space", point = [{zeros} "1 - 0.1*t"], normal = [{zeros} -1] }}
"""


@pytest.mark.parametrize("mesh, zeros, unit", (("square.geo", "0,", "N s/m"), ("cube.geo", "0, 0,", "N s")), ids=("plane", "space"))
def test_obstacles(mesh: str, zeros: str, unit: str, tmp_path: Path) -> None:
    """Two jaws press a body from either side: what each does is reported, in the units of the plane and of space, and it does not vanish in
    their sum, which is the difference of the two. Tables fit 80 columns."""
    scene, out = tmp_path / "squeezed.toml", tmp_path / "squeezed"
    scene.write_text(SQUEEZED.format(mesh=DATA / mesh, zeros=zeros))
    said = study(scene, out, "--sizes", "0.5", "--steps", "0.02,0.01", "--degrees", "1").stdout
    rows = table(out / "study.csv")
    given = json.loads((out / "study.json").read_text())["quantities"]
    assert [given[f"impulse{end}"]["unit"] for end in ("", "_1", "_2")] == [unit] * 3
    assert given["peak_force_2"]["unit"] == unit.replace(" s", "")
    assert (rows["impulse_1"] > 10 * rows["impulse"]).all() and (rows["contact_time_1"] > 0.3).all()
    assert rows["impulse"] == pytest.approx(abs(rows["impulse_1"] - rows["impulse_2"]), rel=0, abs=1e-12 * rows["impulse_1"].max())
    assert f"impulse of contact, obstacle 2, {unit}: " in said
    wide = [line for line in said.splitlines() if len(line) > 80 and re.match(r"\s*(\d+ |rung )", line)]
    assert not [line for line in wide if " of " not in line]
    print(f"jaws push with {rows['impulse_1'][-1]:.4g} and {rows['impulse_2'][-1]:.4g} {unit}, in all {rows['impulse'][-1]:.1e}")


TOLERANCES = (8e-2, 2e-2, 5e-3)
CHOSEN = ("--sizes", "8e-3", "--tolerances", ",".join(map(str, TOLERANCES)), "--steps", "5.6e-4,2.8e-4",
          "--quantity", "contact_start,contact_time")  # fmt: skip
FALL = ("--set", f"exact.contact_start={np.sqrt(2 * 0.2 / 9.81)}")  # s


@pytest.fixture(scope="module")
def chosen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of steps that the motion chooses beside those of one length."""
    out = tmp_path_factory.mktemp("chosen") / "out"
    assert "steps chosen" in study(RING, out, *CHOSEN, *FALL).stdout
    return out


def test_chosen_steps_are_priced() -> None:
    priced = study(RING, None, *CHOSEN, "--dry-run").stdout
    assert priced.count("tolerance") == 3 and priced.count(", step ") == 2


def test_chosen_steps_are_accurate(chosen: Path) -> None:
    """A free fall ends when it must, to more than in more steps of one length."""
    rows = table(chosen / "study.csv")
    there = np.isfinite(rows["tolerance"])
    assert sorted(rows["tolerance"][there]) == sorted(TOLERANCES) and rows["contact_time"].max() > 0.03, "no contact occurred"
    for tolerance, error, steps in zip(rows["tolerance"][there], rows["contact_start_error"][there], rows["steps"][there]):
        print(f"tolerance {tolerance:g}: {steps:.0f} steps, start of contact off by {error:.1e}")
        assert error <= np.minimum(tolerance, rows["contact_start_error"][~there].min())
    assert rows["steps"][there].min() < rows["steps"][~there].min()


def test_chosen_steps_are_kept(chosen: Path) -> None:
    assert "5 of 5 rungs were already stored in the folder" in study(RING, chosen, *CHOSEN, *FALL).stdout


def test_chosen_steps_on_the_page(chosen: Path) -> None:
    reported = captured([sys.executable, SOURCE / "postprocess" / "report.py", chosen])
    assert reported.returncode == 0 and "steps chosen" in (chosen / "report.html").read_text(), reported.stderr


def test_tolerances_of_the_scene() -> None:
    """Its own, and four and sixteen times it."""
    said = study(DATA / "block.toml", None, "--sizes", "0.5", "--set", 'time={end=0.6, step="auto", tolerance=1e-2}', "--dry-run").stdout
    assert all(f"tolerance {t}" in said for t in ("0.01", "0.04", "0.16"))


def test_chosen_steps_with_an_objective(tmp_path: Path) -> None:
    auto = 'time={end=0.6, step="auto", tolerance=1e-3}'
    study(DATA / "block.toml", tmp_path, "--sizes", "0.5", "--set", auto, "--quantity", "J,impulse")
    values = table(tmp_path / "study.csv")
    assert len(values["J"]) == 3 and values["impulse"].max() > 0 and abs(values["J"] / values["J"][-1] - 1).max() < 0.05


def test_chosen_steps_to_an_accuracy(tmp_path: Path) -> None:
    done = captured([SIGNORINI, "simulate", RING, "--out", tmp_path / "out", "--accuracy", "1e-2", "--quantity", "contact_start",
                     "--set", "mesh.size=8e-3"])  # fmt: skip
    assert done.returncode == 0 and "met; size" in done.stdout and ", tolerance " in done.stdout, done.stdout + done.stderr


@pytest.fixture(scope="module")
def stressed(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """A study of the largest stress, with its warnings."""
    folder = tmp_path_factory.mktemp("stressed")
    scene, out = folder / "thrown.toml", folder / "out"
    scene.write_text(soft("square.geo", 0.25, 0.4, 0.02) + ONTO_A_SLOPE)
    said = study(scene, out, "--sizes", "0.5,0.25", "--steps", "0.02", "--quantity", "largest_von_mises,impulse").stdout
    warnings = json.loads((out / "study.json").read_text())["warnings"]
    return SimpleNamespace(scene=scene, said=said, rows=table(out / "study.csv"), warnings=warnings)


def test_equal_warnings_are_printed_once(stressed: SimpleNamespace) -> None:
    """Those of the finest rung."""
    names = {warning["name"] for warning in stressed.warnings}
    for name in names:
        alike = [warning for warning in stressed.warnings if warning["name"] == name]
        others = [str(warning["rung"]) for warning in alike[:-1]]
        also = f" (also rung{'s' * (len(others) > 1)} {', '.join(others)}; see study.json)" if others else ""
        assert f"warning: rung {alike[-1]['rung']}: {alike[-1]['message']}{also}\n" in stressed.said
    assert stressed.said.count("warning: rung") == len(names) < len(stressed.warnings)


def test_largest_stress(stressed: SimpleNamespace, tmp_path: Path) -> None:
    """It is that of a run that stores all steps, with a warning where the mesh determines it."""
    warned = {warning["rung"] for warning in stressed.warnings if warning["name"] == "stress of the mesh"}
    assert warned
    rows = stressed.rows
    for rung, size, value, impulse in zip(rows["rung"], rows["size"], rows["largest_von_mises"], rows["impulse"]):
        signorini("simulate", stressed.scene, tmp_path, mesh__size=float(size), output__fields=["von_mises"], output__every=1)
        run = json.loads((tmp_path / "run.json").read_text())
        assert impulse > 0 and value == run["largest_von_mises"]["value"]
        assert (rung in warned) == any(warning["name"] == "stress of the mesh" for warning in run["warnings"])


def test_stress_is_not_computed_for_other_quantities(stressed: SimpleNamespace, tmp_path: Path) -> None:
    assert "von Mises" not in study(stressed.scene, tmp_path, "--sizes", "0.5,0.25", "--steps", "0.02").stdout


REFUSED = {
    ("--quantity", "impuls"): ("--quantity", "impuls", 'did you mean "impulse"?'),
    ("--quantity", "gradient"): ("--quantity", "gradient", "quantities of this scene: "),
    ("--sizes", "0"): ("--sizes", "found 0"),
    ("--steps", "-1"): ("--steps", "found -1"),
    ("--steps", "1e-20"): ("--steps: found 1e-20 s", "gives 1 to 100000000 steps"),
    ("--tolerances", "0.7"): ("--tolerances: found 0.7", "from 1e-12 to 0.5"),
    ("--degrees", "3"): ("--degrees", "found 3", "expected 1 or 2"),
    ("--schemes", "implicit"): ("--schemes", "found", "contact-implicit"),
    ("--budget", "soon"): ("--budget", "found soon", "10min"),
    ("--suggest", "1e-2"): ("--suggest", "objective", "impulse"),
    ("--search-tolerances", "1e-3"): ("--search-tolerances", "has no [objective]", "needs a control and an objective"),
    ("--suggest", "1e-2", "--quantity", "impuls"): ("--quantity", "impuls", 'did you mean "impulse"?'),
    ("--suggest", "1e-2", "--quantity", "impulse,peak_force"): ("--suggest", "impulse,peak_force", "choose one of"),
    ("--suggest", "1e-2", "--quantity", "energy_loss"): ("--suggest", "energy_loss", "choose one of"),
}


@pytest.mark.parametrize("options", REFUSED, ids=" ".join)
def test_refused(options: tuple[str, ...], tmp_path: Path) -> None:
    out = None if "--suggest" in options else tmp_path / "out"
    lines = study(IMPACT, out, *options, status=2).stderr.splitlines()
    assert len(lines) == 1 and all(fragment in lines[0] for fragment in REFUSED[options])
    assert not (tmp_path / "out").exists()
