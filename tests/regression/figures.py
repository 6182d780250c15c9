# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of a run are drawn from its folder: all of them, legible image files, and one sentence where it is no run."""

import functools
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import as_package  # noqa: F401
import numpy as np
import pytest
from harness import HALF_BALL, HALF_DISC, SOURCE, signorini
from PIL import Image
from signorini.post import control_magnitude
from signorini.post.run_folder import RunFolder
from signorini.post.view import view_of
from soft_scenes import ON_A_BALL, soft

SCRIPT = SOURCE / "postprocess" / "figures.py"
SIMULATE = {"contact_force.png", "contact_force_history.png", "contact_pressure.png", "energy.png", "animation.gif"}
OPTIMIZE = SIMULATE | {"control_magnitude.png", "control_history.png", "objective.png", "distance_to_reference.png", "tracking_error.png"}
# Jaws, one of which moves, a disc inside of which the body is and a wavy floor.
OBSTACLES = soft("square.geo", 0.2, 0.3, 0.01) + """
[[contact]]
on = "left"
obstacle = { shape = "half-space", point = ["-0.3 + 1.2*t", 0], normal = [1, 0] }

[[contact]]
on = "rest"
obstacle = { shape = "cylinder", point = [-0.3, 0.5], radius = 1.45, side = "inside" }

[[contact]]
on = "bottom"
obstacle = { shape = "signed-distance", distance = "y + 0.2 - 0.09*cos(3*(x - 0.5))" }
"""


def draw(out: Path) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, str(SCRIPT), str(out)], capture_output=True, text=True)


def names(out: Path) -> set[str]:
    return {file.name for file in (out / "figures").iterdir() if file.suffix in (".png", ".gif")}


def pressed(out: Path, figures: set[str]) -> set[str]:
    """Those figures, but for the one that wants pressures where contact.csv has none."""
    return figures if "pressure" in (out / "contact.csv").read_text().split("\n", 1)[0] else figures - {"contact_pressure.png"}


RUNS = {
    "plane": ("optimize", HALF_DISC, {"mesh__size": 2, "optimizer__max_iterations": 5}, OPTIMIZE),
    "simulated": ("simulate", HALF_DISC, {"mesh__size": 2, "control__initial": ["0", "-1"]}, SIMULATE),
    "space": ("optimize", HALF_BALL, {"mesh__size": 3, "time__step": 2.5e-4, "optimizer__max_iterations": 3,
                                      "contact__obstacle__normal": [0.1, -0.12, 1], "control__initial": ["0", "0", "-0.9"]}, OPTIMIZE),
    "fit": ("optimize", SOURCE / "scenes" / "drop-test.toml", {"optimizer__max_iterations": 2}, SIMULATE | {"objective.png", "measurements-1.png"}),
}  # fmt: skip


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Gives the folder of one of the RUNS with its figures."""
    folder = tmp_path_factory.mktemp("runs")

    @functools.cache
    def run(name: str) -> Path:
        verb, scene, overrides, _ = RUNS[name]
        signorini(verb, scene, folder / name, **overrides)
        done = draw(folder / name)
        assert done.returncode == 0, done.stderr
        return folder / name

    return run


@pytest.mark.parametrize("name", RUNS)
def test_all_figures(name: str, drawn: Callable[[str], Path]) -> None:
    out = drawn(name)
    assert names(out) == pressed(out, RUNS[name][-1])


@pytest.mark.parametrize("name", ("plane", "space"))
def test_legible(name: str, drawn: Callable[[str], Path]) -> None:
    for file in sorted((drawn(name) / "figures").glob("*.png")):
        assert b"signorini report" in file.read_bytes()[:1000], f"the next run would take {file.name} for the user's"
        with Image.open(file) as image:
            assert np.min(image.size) >= 400, file.name
            assert len(image.convert("RGB").getcolors(maxcolors=10**7)) > 50, f"{file.name} is blank"


def test_film(drawn: Callable[[str], Path]) -> None:
    file = drawn("plane") / "figures" / "animation.gif"
    assert b"signorini report" in file.read_bytes()[:1000], "the next run would take it for the user's"
    with Image.open(file) as image:
        assert image.n_frames >= 30


@pytest.mark.parametrize("tables, fields, expected", (
    (["contact"], ["displacement", "control"],
     {"control_magnitude.png", "control_history.png", "contact_force.png", "contact_pressure.png", "animation.gif"}),
    (["history"], ["control"], {"control_magnitude.png", "control_history.png", "objective.png", "distance_to_reference.png"}),
    ([], [], set()),
), ids=("contact", "history", "nothing"))  # fmt: skip
def test_some_tables_and_fields(tables: list[str], fields: list[str], expected: set[str], tmp_path: Path) -> None:
    signorini("optimize", HALF_DISC, tmp_path, mesh__size=3, optimizer__max_iterations=1, output__tables=tables, output__fields=fields,
              control__initial=["0", "-0.9"])  # fmt: skip
    expected = pressed(tmp_path, expected) if "contact" in tables else expected
    done = draw(tmp_path)
    assert done.returncode == 0, done.stderr
    assert {Path(line).name for line in done.stdout.splitlines() if line.endswith((".png", ".gif"))} == expected
    missing = [line for line in done.stdout.splitlines() if line.startswith("no ")]
    assert len(missing) == len(OPTIMIZE - expected) + 1, done.stdout  # measurements too, which only a fit has


@pytest.mark.parametrize("name, text", (("several", OBSTACLES), ("ball", ON_A_BALL)), ids=("several", "ball"))
def test_obstacles(name: str, text: str, tmp_path: Path) -> None:
    """Several obstacles of all shapes are drawn, and the jaw comes nearer; in space a ball is."""
    scene, out = tmp_path / f"{name}.toml", tmp_path / name
    scene.write_text(text)
    signorini("simulate", scene, out)
    done = draw(out)
    assert done.returncode == 0, done.stderr
    assert names(out) == pressed(out, SIMULATE)
    with Image.open(out / "figures" / "animation.gif") as film:
        grey = []
        for frame in (0, film.n_frames - 1):
            film.seek(frame)
            plot = np.asarray(film.convert("RGB")).astype(int)[50:-75, 90:-130]  # without axes and colours
            grey.append(np.mean((np.ptp(plot, axis=2) < 8) & (abs(plot.mean(axis=2) - 216) < 12)))
    assert grey[0] > 0.02, "no obstacle is seen"
    assert name == "ball" or grey[1] > grey[0] + 0.03, "the jaw does not move"


BALL = {"mesh__size": 4, "time__step": 5e-4, "control__initial": ["0", "0", "-0.9"]}
CELLWISE = {
    "body in the plane": (HALF_DISC, "$10^{6}$ N/m³", {"mesh__size": 3}),
    "surface in the plane": (SOURCE / "scenes" / "catch.toml", "N/m²", {"mesh__size": 0.3, "time__step": 0.02}),
    "body in space": (HALF_BALL, "$10^{6}$ N/m³", BALL),
    "surface in space": (HALF_BALL, "$10^{6}$ N/m²", BALL | {"control__on": "side"}),
}


@pytest.mark.parametrize("case", CELLWISE)
def test_control_of_one_value_for_each_cell(case: str, tmp_path: Path) -> None:
    """Each triangle that is drawn has the value of a cell that it belongs to, and the label has the unit."""
    scene, unit, overrides = CELLWISE[case]
    signorini("optimize", scene, tmp_path, optimizer__max_iterations=1, control__space="cellwise", **overrides)
    run = RunFolder(tmp_path)
    assert control_magnitude.draw(run)[0].stat().st_size > 5000
    series = run.field("control", "control")
    mesh, cells = view_of(run).seen(series.mesh)
    assert series.cellwise and len(series.at(0)) == len(series.mesh.cells)
    assert all(set(shown) <= set(series.mesh.cells[cell]) for shown, cell in zip(mesh.cells, cells, strict=True))
    assert control_magnitude.control_unit(run) == unit
    if case == "surface in space":
        (tmp_path / "figures" / "control_magnitude.png").unlink()
        assert draw(tmp_path).returncode == 0 and "control_magnitude.png" in names(tmp_path)


def test_no_run(tmp_path: Path, drawn: Callable[[str], Path]) -> None:
    for folder in (tmp_path, drawn("plane").parent):
        done = draw(folder)
        assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
