# SPDX-License-Identifier: GPL-3.0-or-later
"""One control for several scenarios: it is good where the control of one scene fails, on several ranks, resumed, and in space."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from browser import page_of
from harness import SIGNORINI, SOURCE, captured, signorini, table, toml

SCENES = SOURCE / "scenes"
CATCH, ANY, BALL = (SCENES / f"{name}.toml" for name in ("catch", "catch-any", "half-ball"))


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def run(*options: str, **overrides: object) -> None:
    """Runs a verb with options."""
    sets = [word for key, value in overrides.items() for word in ("--set", f"{key.replace('__', '.')}={toml(value)}")]
    done = captured([str(SIGNORINI), *options, *sets])
    assert done.returncode == 0, done.stdout + done.stderr


def over_speeds(found: Path) -> np.ndarray:
    """J of the catch at 41 speeds within 20 % of 1 m/s, under the control of a run."""
    cases = found.parent / "speeds.csv"
    cases.write_text("name,initial.velocity\n" + "".join(f'{v:.2f},"[{v:.2f}, 0.0]"\n' for v in np.linspace(0.8, 1.2, 41)))
    out = found.parent / f"{found.name}-speeds"
    run("batch", str(CATCH), "--out", str(out), "--cases", str(cases), "--quantity", "J", control__initial={"run": str(found)})
    with open(out / "cases.csv") as cases_file:
        J = np.array([float(case["J"]) for case in csv.DictReader(cases_file)])
    assert len(J) == 41 and np.isfinite(J).all()
    return J


def test_robust_catch(tmp_path: Path) -> None:
    signorini("optimize", CATCH, tmp_path / "one")
    signorini("optimize", ANY, tmp_path / "expected")
    signorini("optimize", ANY, tmp_path / "worst", objective__exponent=20.0)
    one, expected, worst = (over_speeds(tmp_path / name) for name in ("one", "expected", "worst"))
    assert manifest(tmp_path / "worst")["impact"]["all"]["impulse"], "the disc hits the wall"
    assert one.max() > 10 * expected.max() and expected.max() > worst.max()
    assert one[20] < expected[20] < 1.3 * one[20], "at the nominal speed it costs little"
    assert expected.mean() < worst.mean() < one.mean()
    # Between the five speeds of the scenarios it is as good as at them.
    scenarios = table(tmp_path / "worst" / "scenarios.csv")
    assert worst.max() < 1.05 * scenarios["objective"].max()
    assert scenarios["share"] @ scenarios["objective"] == pytest.approx(manifest(tmp_path / "worst")["objective"]["value"], rel=1e-12)


def test_page(tmp_path: Path) -> None:
    signorini("optimize", ANY, tmp_path / "run", optimizer__max_iterations=1)
    page = page_of(tmp_path / "run").read_text()
    assert "Objective of each scenario" in page and all(f"{v} m/s" in page for v in ("0.8", "0.9", "1.0", "1.1", "1.2"))


def test_resumed_search(tmp_path: Path) -> None:
    short = {"objective__exponent": 4.0, "optimizer__checkpoint": 2}
    signorini("optimize", ANY, tmp_path / "whole", optimizer__max_iterations=8, **short)
    signorini("optimize", ANY, tmp_path / "parts", optimizer__max_iterations=5, **short)
    run("optimize", str(ANY), "--out", str(tmp_path / "parts"), "--resume", optimizer__max_iterations=8, **short)
    whole, parts = (table(tmp_path / name / "history.csv") for name in ("whole", "parts"))
    for column in ("objective", "gradient_norm", "forward_sweeps", "adjoint_sweeps"):
        assert (whole[column] == parts[column]).all(), column
    assert (tmp_path / "whole" / "scenarios.csv").read_bytes() == (tmp_path / "parts" / "scenarios.csv").read_bytes()


def test_two_ranks(tmp_path: Path) -> None:
    """Ranks make the motions one after another."""
    common = {"optimizer__max_iterations": 3, "time__scheme": "contact-stabilized"}
    signorini("optimize", ANY, tmp_path / "one", **common)
    signorini("optimize", ANY, tmp_path / "two", ranks=2, **common)
    one, two = (table(tmp_path / name / "scenarios.csv")["objective"] for name in ("one", "two"))
    assert two == pytest.approx(one, rel=1e-6)


@pytest.mark.parametrize("solver", ("direct", "iterative"))
def test_scenarios_in_space(solver: str, tmp_path: Path) -> None:
    """J falls in all scenarios, of which one has a D of its own, whether or not solves are made together."""
    done = signorini("optimize", BALL, tmp_path, mesh__size=4, time__step=5e-4, solver__linear=solver, optimizer__max_iterations=4, optimizer__start="guess",
                     scenario=[{}, {"set": {"contact.obstacle.point": [0, 0, -15.2]}}, {"set": {"load.body": ["0", "0", "-1e6"]}},
                               {"set": {"material.young": 2e8}}])  # fmt: skip
    history, found = table(tmp_path / "history.csv"), table(tmp_path / "scenarios.csv")
    assert history["objective"][-1] < history["objective"][0] and len(np.unique(found["objective"])) == 4, done.stdout
