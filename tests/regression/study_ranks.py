# SPDX-License-Identifier: GPL-3.0-or-later
"""signorini study on one rank and on two: the same figures, and the same refusals."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_DISC, signorini, table
from patch_scene import PRESSURE, patch
from studies import DATA, ONE_RUNG, study

RUNGS = ("--sizes", "2,1", "--steps", "1e-4,5e-5", "--quantity", "J,displacement,gradient,impulse,contact_start,contact_time")


@pytest.fixture(scope="module")
def studies(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    """Of each number of ranks."""
    folder = tmp_path_factory.mktemp("ranks")
    for ranks in (1, 2):
        study(HALF_DISC, folder / str(ranks), *RUNGS, ranks=ranks)
    return {ranks: folder / str(ranks) for ranks in (1, 2)}


def test_same_figures(studies: dict[int, Path]) -> None:
    one, two = (table(folder / "study.csv") for folder in studies.values())
    order = [np.lexsort((rows["steps"], rows["size"])) for rows in (one, two)]  # prices, and with them the order, are timed
    assert (one["contact_time"] > 0).all(), "no contact: the case says nothing"
    for name in ("J", "J_error", "J_estimate", "J_envelope", "displacement_error", "gradient_error", "impulse", "contact_start",
                 "contact_time"):  # fmt: skip
        # Differences of numbers that agree to 1e-12 or so.
        np.testing.assert_allclose(one[name][order[0]], two[name][order[1]], rtol=1e-6, atol=1e-9, err_msg=name)


def test_rungs_of_another_number_of_ranks_run_again(studies: dict[int, Path], tmp_path: Path) -> None:
    out = shutil.copytree(studies[1], tmp_path / "out")
    again = study(HALF_DISC, out, *RUNGS, ranks=2).stdout
    assert again.count('the number of ranks was "1", and now is "2"') == 4


def test_same_search(tmp_path: Path) -> None:
    for ranks in (1, 2):
        study(HALF_DISC, tmp_path / str(ranks), *ONE_RUNG, "--search-tolerances", "1e-2", ranks=ranks)
    one, two = (table(tmp_path / str(ranks) / "search.csv") for ranks in (1, 2))
    assert one["forward_sweeps"] == two["forward_sweeps"] and one["J"] == pytest.approx(two["J"], rel=1e-6, abs=0)


@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("dim", (2, 3))
def test_uniform_pressure(dim: int, ranks: int, tmp_path: Path) -> None:
    """That of the patch test, of both degrees; see tests/verification/hard/discs.py."""
    scene, out = tmp_path / "patch.toml", tmp_path / "patch"
    scene.write_text(patch(dim, size=0.5, step=0.02) + f'[exact]\npressure = "{PRESSURE}"\n')
    study(scene, out, "--sizes", "0.5", "--steps", "0.02", "--degrees", "1,2", "--quantity", "pressure", ranks=ranks)
    rows = table(out / "study.csv")
    assert sorted(rows["degree"]) == [1, 2] and rows["pressure_error"].max() < 1e-10  # 500 steps, each to about 1e-14 of the stiffest


CELLS = 2 * 70**2  # more points to sample at than are wanted: coarser meshes are tried


def own_density(folder: Path, kind: str) -> Path:
    """A scene whose .geo sets its own density, with a mesh.size or the usual mesh.scale."""
    text = (DATA / "block.toml").read_text().replace("end = 0.6", "end = 0.04")
    text = text.replace('"square.geo"', json.dumps(str(DATA / "fixed-density.geo")))
    scene = folder / "scene.toml"
    scene.write_text(text if kind == "size" else text.replace("size = 0.25\n", ""))
    return scene


@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("options", ("", "--dry-run", "--sizes 0.5,0.125", "--suggest 1e-2"))
@pytest.mark.parametrize("kind", ("size", "scale"))
def test_own_density_is_refused_where_sizes_matter(kind: str, options: str, ranks: int, tmp_path: Path) -> None:
    """And no search for a coarser mesh continues for ever."""
    refused = study(own_density(tmp_path, kind), tmp_path / "refused", *options.split(), ranks=ranks, status=2)
    said = [line for line in refused.stderr.splitlines() if line.startswith("signorini: ")]
    assert len(said) == 1 and f"mesh.{kind}: " in said[0] and f"has {CELLS} cells" in said[0]
    assert "Transfinite" in said[0] and "; use " in said[0] and not (tmp_path / "refused").exists()


@pytest.mark.parametrize("ranks", (1, 2))
def test_own_density_runs(ranks: int, tmp_path: Path) -> None:
    scene = own_density(tmp_path, "size")
    signorini("simulate", scene, tmp_path / "run", ranks)
    assert json.loads((tmp_path / "run" / "run.json").read_text())["cells"] == CELLS
    study(scene, tmp_path / "one-size", "--sizes", "0.25", "--steps", "0.02,0.01", "--quantity", "J", ranks=ranks)
    rows = table(tmp_path / "one-size" / "study.csv")
    assert list(rows["steps"]) == [2, 4] and rows["unknowns"][0] == rows["unknowns"][1] == 2 * 71**2
