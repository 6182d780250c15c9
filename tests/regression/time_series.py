# SPDX-License-Identifier: GPL-3.0-or-later
"""Time series from CSV files: they act as the expressions that they are, on any number of ranks, and the files of a run are such
tables; what is read again, resumed or kept by a study knows them."""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SIGNORINI, SOURCE, captured, signorini, table, toml  # noqa: E402

import numpy as np  # noqa: E402

BLOCK = SOURCE / "tests" / "data" / "block.toml"
ROUNDING = 1e-12  # which contact multiplies
RANKS = 1e-9  # on several ranks sums are in another order, and contact multiplies that
T, STEP = 0.6, 0.02
COLUMNS = ("kinetic_energy", "elastic_energy", "external_work", "contact_force_y", "active")
# Of the load, the plane and a desired motion: kinks lie on steps and between them.
BENT = "t < 0.25 ? -1 : -1 - 4*(t - 0.25)"
RISE = "-0.1 + 0.2*t"


def series(column: str, file: str = "given.csv") -> dict[str, str]:
    return {"file": file, "column": column}


def given(folder: Path) -> Path:
    """A scene beside a table of what acts on it."""
    scene = folder / "block.toml"
    scene.write_text(BLOCK.read_text().replace('"square.geo"', f'"{SOURCE / "tests" / "data" / "square.geo"}"'))
    rows = ["push,time,rise"] + [f"{-1 if t < 0.25 else -1 - 4 * (t - 0.25):.17g},{t!r},{-0.1 + 0.2 * t:.17g}" for t in (0.0, 0.25, 1.0)]
    (folder / "given.csv").write_text("\n".join(rows) + "\n")
    return scene


def run(verb: str, scene: Path, out: Path, settings: dict[str, object], *options: str) -> str:
    """What a run says."""
    words = [f"{key}={toml(value)}" for key, value in settings.items()]
    done = captured([str(SIGNORINI), verb, str(scene), "--out", str(out), *options, *(w for word in words for w in ("--set", word))])
    return done.stdout + done.stderr


def near(a: dict[str, np.ndarray], b: dict[str, np.ndarray], tolerance: float) -> None:
    for name in COLUMNS:
        assert np.allclose(a[name], b[name], rtol=0, atol=tolerance * abs(b[name]).max()), name


def as_the_expression(folder: Path, scene: Path) -> None:
    """The same motion by expressions and by series, with contact; from the echo too."""
    def settings(push: object, rise: object) -> dict[str, object]:
        return {"load": {"body": ["0", push], "traction": [{"on": "top", "value": ["0", push]}]}, "contact__obstacle__point": ["0", rise]}

    by_expression, by_series, again = folder / "expression", folder / "series", folder / "again"
    signorini("simulate", scene, by_expression, **settings(BENT, RISE))
    expected = table(by_expression / "steps.csv")
    assert expected["active"].max() > 0 and np.ptp(np.diff(expected["external_work"])) > 0
    for ranks, tolerance in ((1, ROUNDING), (2, RANKS)):
        signorini("simulate", scene, by_series, ranks, **settings(series("push"), series("rise")))
        near(table(by_series / "steps.csv"), expected, tolerance)
    signorini("simulate", by_series / "scene.toml", again)
    near(table(again / "steps.csv"), expected, RANKS)
    print("series act as the expressions that they are, on one and two ranks, and from the echoed scene")


def by_an_earlier_run(folder: Path, scene: Path) -> None:
    """The force that a run records is a load of the next: its times are found by their column's name."""
    recorded, next_run = folder / "expression", folder / "next"
    signorini("simulate", scene, next_run, contact__obstacle__point=[0, -100], initial__velocity=[0, 0],
              load={"body": [0, series("contact_force_y", str(recorded / "steps.csv"))]})  # fmt: skip
    force = table(recorded / "steps.csv")["contact_force_y"]
    work = table(next_run / "steps.csv")
    middle = (force[1:] + force[:-1]) / 2
    momentum = STEP * middle.cumsum()  # of the unit mass, which nothing deforms
    assert middle.max() > 0
    assert np.allclose(work["kinetic_energy"][1:], momentum**2 / 2, rtol=1e-9, atol=1e-9 * (momentum**2).max())
    print("a column of an earlier run's table is a load")


def gone_on_with(folder: Path, scene: Path) -> None:
    """A search with a desired motion by a series is resumed to the same result; other content is another problem."""
    def optimize(out: Path, iterations: int, rise: str = "rise", *options: str) -> str:
        return run("optimize", scene, out, {"objective.desired": {"displacement": [0, series(rise)]}, "optimizer.tolerance": 0,
                                            "optimizer.max_iterations": iterations}, *options)  # fmt: skip

    whole, part = folder / "whole", folder / "part"
    optimize(whole, 4)
    optimize(part, 2)
    assert "resumed after iteration 2" in optimize(part, 4, "rise", "--resume")
    history = table(whole / "history.csv")["objective"]
    assert len(history) == 5 and (np.diff(history) < 0).all()
    assert np.array_equal(table(part / "history.csv")["objective"], history)
    assert "objective.desired" in optimize(part, 5, "push", "--resume"), "another series is another problem"
    print("a search with a desired motion by a series is resumed to the last bit")


def studied(folder: Path, scene: Path) -> None:
    """A study runs its rungs again where the content of a series changed, and says so."""
    text = (folder / "given.csv").read_text()

    def said() -> str:
        return run("study", scene, folder / "study", {"load.body": [0, series("push")]}, "--sizes", "0.5", "--steps", "0.1",
                   "--quantity", "J")  # fmt: skip

    said()
    assert "time series" not in said()
    (folder / "given.csv").write_text(text.replace("-4", "-5"))
    assert "the content of a time series is another" in said()
    print("a study knows the content of a series")


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        scene = given(folder)
        for part in (as_the_expression, by_an_earlier_run, gone_on_with, studied):
            part(folder, scene)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
