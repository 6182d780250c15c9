# SPDX-License-Identifier: GPL-3.0-or-later
"""What a study keeps: a rung, as long as nothing that its numbers depend on has changed; the rungs before an interruption."""

import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from harness import HALF_DISC, signorini, table
from studies import DATA, IMPACT, interrupt, study

BLOCK = (DATA / "block.toml").read_text().replace("end = 0.6", "end = 0.2")
SQUARE = (DATA / "square.geo").read_text()
FILES = {"block.toml": BLOCK, "square.geo": SQUARE}
INCLUDING = {"square.geo": 'Include "corner.inc";\n' + SQUARE.replace("{1, 1, 0}", "{1, 1 + c, 0}"), "corner.inc": "c = 0;"}
RUNGS = ("--sizes", "0.5,0.3", "--steps", "0.02", "--quantity", "J,displacement,impulse")
# What there is, what changes, and what is said.
CHANGES = {
    "the scene's own size, and with it the sample points": ({}, {"block.toml": BLOCK.replace("size = 0.25", "size = 0.15")}, "points"),
    "the material": ({}, {"block.toml": BLOCK.replace("young = 50.0", "young = 40.0")}, "material.young = 40"),
    "the control at which J is taken": ({}, {"block.toml": BLOCK + '[check]\ncontrol = ["0", "-1.5"]\n'}, "check.control"),
    "the .geo": ({}, {"square.geo": SQUARE.replace("{1, 1, 0}", "{1, 1.2, 0}")}, "mesh file"),
    "a file that the .geo includes": (INCLUDING, {"corner.inc": "c = 0.1;"}, "mesh file"),
}  # fmt: skip


def columns(folder: Path) -> dict[str, np.ndarray]:
    """What a study found, except its costs: rung by rung, cheapest first."""
    rows = table(folder / "study.csv")
    timed = {"rung", "seconds", "memory_bytes", *(name for name in rows if name.endswith("_pareto"))}
    order = np.lexsort((rows["steps"], rows["size"]))
    return {name: values[order] for name, values in rows.items() if name not in timed}


def write(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        (folder / name).write_text(text)


@pytest.mark.parametrize("before, change, words", CHANGES.values(), ids=CHANGES)
def test_changed(before: dict[str, str], change: dict[str, str], words: str, tmp_path: Path) -> None:
    """Then the study is to the last bit one that starts anew."""
    scene, out, fresh = (tmp_path / name for name in ("block.toml", "out", "fresh"))
    write(tmp_path, FILES | before)
    study(scene, out, *RUNGS)
    assert (table(out / "study.csv")["impulse"] > 0).all(), "no contact: the case says nothing"
    first = columns(out)
    unchanged = study(scene, out, *RUNGS, "--set", "output.every=3", "--set", "optimizer.tolerance=1e-3").stdout
    assert "2 of 2 rungs were already stored in the folder" in unchanged and "runs again" not in unchanged
    write(tmp_path, change)
    said = study(scene, out, *RUNGS).stdout
    assert said.count("runs again: ") == 2 and said.count(words) >= 2
    study(scene, fresh, *RUNGS)
    now = columns(out)
    np.testing.assert_equal(now, columns(fresh))
    assert not all(np.array_equal(first[name], now[name], equal_nan=True) for name in ("J_error", "displacement_error"))


def test_changed_run_that_is_desired(tmp_path: Path) -> None:
    """A desired motion that another run has left, in the same folder."""
    scene, free, out = tmp_path / "block.toml", tmp_path / "free.toml", tmp_path / "out"
    write(tmp_path, FILES)
    free.write_text(BLOCK)
    scene.write_text(BLOCK.replace('desired = { control = ["0.3", "-1"] }', 'desired = { run = "run" }'))
    one_size = ("--sizes", "0.25", "--steps", "0.02,0.01", "--quantity", "J")
    for i, young in enumerate((50.0, 40.0)):
        signorini("simulate", free, tmp_path / "run", material__young=young)
        said = study(scene, out, *one_size).stdout
        assert said.count("objective.desired.run names has changed") == 2 * i
        study(scene, tmp_path / f"fresh-{i}", *one_size)
        np.testing.assert_equal(columns(out), columns(tmp_path / f"fresh-{i}"))


CHOICE = ("--sizes", "2,1", "--steps", "1e-4,5e-5", "--quantity", "J")  # the rest would take longer than a test should


@pytest.fixture(scope="module")
def studies(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """One that was interrupted and continued, and one that was not."""
    folder = tmp_path_factory.mktemp("studies")
    found = SimpleNamespace(continued=folder / "continued", whole=folder / "whole")
    interrupt(HALF_DISC, found.continued, "--sizes", "2,1,0.25", "--steps", "1e-4,2.5e-6", "--quantity", "J", after="rung 2 of 6: ")
    found.some = len(table(found.continued / "study.csv")["rung"])
    study(HALF_DISC, found.continued, *CHOICE)
    study(HALF_DISC, found.whole, *CHOICE)
    return found


def test_interrupted_between_rungs(studies: SimpleNamespace) -> None:
    assert 2 <= studies.some < 6
    np.testing.assert_equal(columns(studies.continued), columns(studies.whole))


def test_errors_of_what_is_there(studies: SimpleNamespace, tmp_path: Path) -> None:
    """Without its coarsest rung, which the budget does not let run again: errors are against the finer ones that are there."""
    out = shutil.copytree(studies.continued, tmp_path / "out")
    (coarse,) = (out / "rungs").glob("size-2-steps-75-*")
    coarse.unlink()
    study(HALF_DISC, out, *CHOICE, "--budget", "1e-9s")
    left, whole = columns(out), columns(studies.whole)
    assert len(left["J"]) == 3 and set(left["J_error"][np.isfinite(left["J_error"])]) <= set(whole["J_error"])


def test_interrupted_within_a_rung(tmp_path: Path) -> None:
    """A motion that is cut short has no figures."""
    interrupt(IMPACT, tmp_path, "--sizes", "0.5,0.05", "--steps", "0.01,5e-6", "--quantity", "impulse", after="rung 3 of 4: ", pause=0.3)
    assert list(table(tmp_path / "study.csv")["rung"]) == [1, 2, 3] and len(list((tmp_path / "rungs").iterdir())) == 3
