# SPDX-License-Identifier: GPL-3.0-or-later
"""What the optimizer's accuracy costs: each search of a study is that of `optimize`, is kept as long as nothing that it depends on has
changed, and their table is that of the last command."""

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from harness import HALF_DISC, signorini, table
from studies import ONE_RUNG, interrupt, study

TOLERANCES = ("1e-1", "1e-3", "1e-4")
SEARCHES = (*ONE_RUNG, "--search-tolerances", ",".join(TOLERANCES))
COUNTS = ("iterations", "forward_sweeps", "adjoint_sweeps")


@pytest.fixture(scope="module")
def searched(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """A study with three searches."""
    out = tmp_path_factory.mktemp("searched") / "out"
    said = study(HALF_DISC, out, *SEARCHES).stdout
    return SimpleNamespace(out=out, said=said, rows=table(out / "search.csv"), manifest=json.loads((out / "study.json").read_text()))


@pytest.fixture
def out(searched: SimpleNamespace, tmp_path: Path) -> Path:
    """A copy of that study."""
    return shutil.copytree(searched.out, tmp_path / "out")


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_search_is_that_of_optimize(searched: SimpleNamespace, tolerance: str, tmp_path: Path) -> None:
    signorini("optimize", HALF_DISC, tmp_path, mesh__size=2, time__step=1e-4, optimizer__tolerance=float(tolerance))
    run = json.loads((tmp_path / "run.json").read_text())
    row = {name: values[TOLERANCES.index(tolerance)] for name, values in searched.rows.items()}
    assert row["tolerance"] == float(tolerance) and row["J"] == run["objective"]["value"]
    assert row["stop_reason"] == run["stop_reason"]
    assert [row[name] for name in COUNTS] == [run["optimizer"][name] for name in COUNTS]
    if tolerance == TOLERANCES[-1]:
        assert table(tmp_path / "steps.csv")["active"].max() > 0, "no contact: the case says nothing"


def test_costs(searched: SimpleNamespace) -> None:
    """A smaller tolerance takes more sweeps and leaves a smaller J."""
    rows, least = searched.rows, searched.rows["J"].min()
    print("; ".join(f"{sweeps:.0f} sweeps to {tolerance}" for sweeps, tolerance in zip(rows["forward_sweeps"], TOLERANCES)))
    assert searched.manifest["searches"] == 3 and "search.csv" in searched.manifest["files"]
    assert list(rows["forward_sweeps"]) == sorted(rows["forward_sweeps"]) and rows["forward_sweeps"][0] < rows["forward_sweeps"][2]
    assert np.array_equal(rows["J_above_least"], (rows["J"] - least) / least) and rows["J_above_least"][2] == 0 < rows["J_above_least"][0]


def test_recommended_tolerance(searched: SimpleNamespace) -> None:
    """The cheapest that leaves less than a tenth of the error by size and step."""
    rows, sentence = searched.rows, searched.manifest["sentences"][-1]
    error = table(searched.out / "study.csv")["J_estimate"][0]
    cheapest = next(i for i in np.argsort(rows["seconds"]) if rows["J_above_least"][i] <= error / 10)
    tolerance, percent = f"{rows['tolerance'][cheapest]:.3g}", f"{100 * error:.2g} %"
    assert f"size and step cause an error of {percent} in J. A search with optimizer.tolerance = {tolerance} adds less than a tenth" in sentence
    assert sentence in searched.said


def test_kept(out: Path) -> None:
    before = (out / "search.csv").read_bytes()
    said = study(HALF_DISC, out, *SEARCHES, "--set", "optimizer.checkpoint=3").stdout
    assert "search 1 of 3" not in said and (out / "search.csv").read_bytes() == before


def test_other_method(out: Path) -> None:
    said = study(HALF_DISC, out, *ONE_RUNG, "--search-tolerances", "1e-1", "--set", "optimizer.method=newton-cg").stdout
    assert "search 1 of 1 runs again: the method of the search has changed" in said and len(table(out / "search.csv")["J"]) == 1


def test_budget(out: Path) -> None:
    said = study(HALF_DISC, out, *ONE_RUNG, "--search-tolerances", "1e-3,1e-6", "--budget", "1e-3s").stdout
    assert "the budget ends before the last search" in said and list(table(out / "search.csv")["tolerance"]) == [1e-3]


def test_price() -> None:
    said = study(HALF_DISC, None, *SEARCHES, "--dry-run").stdout
    assert "in addition 3 searches, whose number of sweeps and time cannot be predicted" in said


def test_without_searches(out: Path) -> None:
    study(HALF_DISC, out, *ONE_RUNG)
    assert not (out / "search.csv").exists() and json.loads((out / "study.json").read_text())["searches"] == 0


def test_interrupted(out: Path) -> None:
    interrupt(HALF_DISC, out, *ONE_RUNG, "--search-tolerances", "1e-3,1e-9", "--set", "mesh.size=0.5", "--set", "time.step=5e-5",
              after="search 1 of 2: ", pause=0.3)  # fmt: skip
    assert list(table(out / "search.csv")["tolerance"]) == [1e-3]
