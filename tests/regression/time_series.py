# SPDX-License-Identifier: GPL-3.0-or-later
"""Time series from CSV files: they act as the expressions that they are, on any number of ranks, and the files of a run are such
tables; a run from an echo, a resumed one and a study depend on their content."""

from pathlib import Path

import numpy as np
import pytest
from harness import SIGNORINI, SOURCE, captured, signorini, table, toml

BLOCK = SOURCE / "tests" / "data" / "block.toml"
ROUNDING = 1e-12  # which contact multiplies
RANKS = 1e-9  # on several ranks sums are in another order, and contact multiplies that
STEP = 0.02
COLUMNS = ("kinetic_energy", "elastic_energy", "external_work", "contact_force_y", "active")
# Of the load, the plane and a desired motion: kinks lie on steps and between them.
BENT = "t < 0.25 ? -1 : -1 - 4*(t - 0.25)"
RISE = "-0.1 + 0.2*t"


def series(column: str, file: str = "given.csv") -> dict[str, str]:
    return {"file": file, "column": column}


def given(folder: Path) -> Path:
    """A scene beside a table of what acts on it."""
    file = folder / "block.toml"
    file.write_text(BLOCK.read_text().replace('"square.geo"', f'"{SOURCE / "tests" / "data" / "square.geo"}"'))
    rows = ["push,time,rise"] + [f"{-1 if t < 0.25 else -1 - 4 * (t - 0.25):.17g},{t!r},{-0.1 + 0.2 * t:.17g}" for t in (0.0, 0.25, 1.0)]
    (folder / "given.csv").write_text("\n".join(rows) + "\n")
    return file


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return given(tmp_path)


def pushed(push: object, rise: object) -> dict[str, object]:
    return {"load": {"body": ["0", push], "traction": [{"on": "top", "value": ["0", push]}]}, "contact__obstacle__point": ["0", rise]}


@pytest.fixture(scope="module")
def by_expression(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """steps.csv of the motion by expressions, with contact."""
    folder = tmp_path_factory.mktemp("expression")
    signorini("simulate", given(folder), folder / "out", **pushed(BENT, RISE))
    steps = table(folder / "out" / "steps.csv")
    assert steps["active"].max() > 0 and np.ptp(np.diff(steps["external_work"])) > 0
    return folder / "out" / "steps.csv"


def run(verb: str, scene: Path, out: Path, settings: dict[str, object], *options: str) -> str:
    """What a run says."""
    words = [f"{key}={toml(value)}" for key, value in settings.items()]
    done = captured([str(SIGNORINI), verb, str(scene), "--out", str(out), *options, *(w for word in words for w in ("--set", word))])
    return done.stdout + done.stderr


def near(a: dict[str, np.ndarray], b: dict[str, np.ndarray], tolerance: float) -> None:
    for name in COLUMNS:
        assert np.allclose(a[name], b[name], rtol=0, atol=tolerance * abs(b[name]).max()), name


@pytest.mark.parametrize("ranks, tolerance", ((1, ROUNDING), (2, RANKS)))
def test_as_the_expression(ranks: int, tolerance: float, by_expression: Path, scene: Path, tmp_path: Path) -> None:
    """The motion by series is that by expressions; from the echo too."""
    expected = table(by_expression)
    signorini("simulate", scene, tmp_path / "series", ranks, **pushed(series("push"), series("rise")))
    near(table(tmp_path / "series" / "steps.csv"), expected, tolerance)
    signorini("simulate", tmp_path / "series" / "scene.toml", tmp_path / "again")
    near(table(tmp_path / "again" / "steps.csv"), expected, RANKS)


def test_force_of_an_earlier_run(by_expression: Path, scene: Path, tmp_path: Path) -> None:
    """The force that a run records is a load of the next: its times are found by their column's name."""
    signorini("simulate", scene, tmp_path / "next", contact__obstacle__point=[0, -100], initial__velocity=[0, 0],
              load={"body": [0, series("contact_force_y", str(by_expression))]})  # fmt: skip
    force, work = table(by_expression)["contact_force_y"], table(tmp_path / "next" / "steps.csv")
    middle = (force[1:] + force[:-1]) / 2
    momentum = STEP * middle.cumsum()  # of the unit mass, which nothing deforms
    assert middle.max() > 0
    assert np.allclose(work["kinetic_energy"][1:], momentum**2 / 2, rtol=1e-9, atol=1e-9 * (momentum**2).max())


def test_resumed(scene: Path, tmp_path: Path) -> None:
    """A search with a desired motion by a series is resumed to the last bit; other content is another problem."""
    def optimize(out: Path, iterations: int, rise: str = "rise", *options: str) -> str:
        return run("optimize", scene, out, {"objective.desired": {"displacement": [0, series(rise)]}, "optimizer.tolerance": 0,
                                            "optimizer.max_iterations": iterations}, *options)  # fmt: skip

    whole, part = tmp_path / "whole", tmp_path / "part"
    optimize(whole, 4)
    optimize(part, 2)
    assert "resumed after iteration 2" in optimize(part, 4, "rise", "--resume")
    history = table(whole / "history.csv")["objective"]
    assert len(history) == 5 and (np.diff(history) < 0).all()
    assert np.array_equal(table(part / "history.csv")["objective"], history)
    assert "objective.desired" in optimize(part, 5, "push", "--resume"), "another series is another problem"


def test_study_of_other_content(scene: Path, tmp_path: Path) -> None:
    """A study runs its rungs again where the content of a series changed, and says so."""
    def said() -> str:
        return run("study", scene, tmp_path / "study", {"load.body": [0, series("push")]}, "--sizes", "0.5", "--steps", "0.1",
                   "--quantity", "J")  # fmt: skip

    said()
    assert "time series" not in said()
    table_given = tmp_path / "given.csv"
    table_given.write_text(table_given.read_text().replace("-4", "-5"))
    assert "the content of a time series has changed" in said()
