# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers of a study are those of runs of the same size and step: rungs, errors, envelopes and fronts, in study.csv, on the console,
on its page and in its pictures; and the estimates of the error of J."""

import json
from dataclasses import dataclass
from pathlib import Path

import drawn
import numpy as np
import pytest
from harness import signorini, table
from recomputed import TABLE, near
from regression.values.runs import BLOCK_SCENE, BOUNCING
from studies import study

NAMES = ["impulse", "impulse_duration", "sustained_peak", "peak_force", "energy_loss"]
RUNGS = 4


@dataclass(frozen=True)
class Study:
    """A study's scene and folder, study.csv, study.json and the lines on the console."""

    scene: Path
    out: Path
    rows: dict[str, np.ndarray]
    manifest: dict
    lines: list[str]
    ballast: int  # bytes of this process during the study

    def lines_after(self, start: str, skipped: int, count: int | None = None) -> list[str]:
        """Lines of the console after the one that begins so."""
        first = next(i for i, line in enumerate(self.lines) if line.startswith(start)) + skipped
        return self.lines[first : first + count if count else None]

    def rung(self, n: int) -> list[str]:
        """The first words of a rung's line."""
        return [str(n + 1), f"{self.rows['size'][n]:.4g}", f"{self.rows['step'][n]:.3g}"]

    def errors(self, name: str) -> np.ndarray:
        """Relative to the finest rung, which has none; of an elastic body no energy is lost where elements and steps are small."""
        value = self.rows[name]
        if name == "energy_loss":
            return np.abs(value)
        size, step = self.rows["size"], self.rows["step"]
        finest = int(np.flatnonzero((size == size.min()) & (step == step.min()))[0])
        error = np.abs(value / value[finest] - 1)
        error[finest] = np.nan
        return error

    def envelope(self, name: str) -> np.ndarray:
        """The largest error there and at finer rungs."""
        error, size, step = self.errors(name), self.rows["size"], self.rows["step"]
        finer = (size <= size[:, None]) & (step <= step[:, None])
        return np.array([np.nanmax(error[one]) if np.isfinite(error[one]).any() else np.nan for one in finer])

    def front(self, name: str) -> list[bool]:
        """Whether no cheaper rung is as good, to the last digit of the envelopes."""
        envelope, seconds = self.rows[f"{name}_envelope"], self.rows["seconds"]
        return [bool(np.isfinite(e) and not ((seconds < s) & (envelope <= e)).any()) for s, e in zip(seconds, envelope)]


@pytest.fixture(scope="module")
def ladder(tmp_path_factory: pytest.TempPathFactory) -> Study:
    folder = tmp_path_factory.mktemp("study")
    scene, out = folder / "ladder.toml", folder / "ladder"
    scene.write_text(BOUNCING)
    ballast = np.ones(3 * 10**7)
    done = study(scene, out, "--sizes", "0.3,0.5", "--steps", "0.01,0.02", "--quantity", ",".join(NAMES), "--set", "output.fields=[]")
    rows, manifest = table(out / "study.csv"), json.loads((out / "study.json").read_text())
    return Study(scene, out, rows, manifest, done.stdout.splitlines(), ballast.nbytes)


def test_rungs(ladder: Study) -> None:
    assert (list(ladder.rows["size"]), list(ladder.rows["step"])) == ([0.5, 0.5, 0.3, 0.3], [0.02, 0.01, 0.02, 0.01]), "the cheapest first"
    assert 0 < np.max(ladder.rows["memory_bytes"]) < ladder.ballast / 8, "the memory is that of another program"


@pytest.mark.parametrize("n", range(RUNGS))
def test_rung_is_a_run(ladder: Study, n: int, tmp_path: Path) -> None:
    rows, out = ladder.rows, tmp_path / "rung"
    signorini("simulate", ladder.scene, out, mesh__size=float(rows["size"][n]), time__step=float(rows["step"][n]), output__fields=[])
    manifest, steps = json.loads((out / "run.json").read_text()), table(out / "steps.csv")
    touch = manifest["impact"]["all"]
    expected = {"impulse": np.linalg.norm(touch["impulse"]), "impulse_duration": touch["impulse_duration"],
                "sustained_peak": touch["sustained_peak"], "peak_force": touch["peak"],
                "energy_loss": -steps["contact_work"].sum() / (steps["kinetic_energy"] + steps["elastic_energy"]).max()}  # fmt: skip
    for name in NAMES:
        near(name, rows[name][n], expected[name], TABLE)
    assert (rows["unknowns"][n], rows["steps"][n]) == (manifest["unknowns"], manifest["steps"]["done"])


def test_lines_of_rungs(ladder: Study) -> None:
    head, *lines = ladder.lines_after("rung    size, m", 0, 1 + RUNGS)
    assert head.replace(", ", ",").split() == "rung size,m step,s degree scheme unknowns seconds MB".split()
    for n, line in enumerate(lines):
        unknowns, seconds, memory = (ladder.rows[name][n] for name in ("unknowns", "seconds", "memory_bytes"))
        *exact, shown_seconds, shown_memory = line.split()
        assert [*exact, shown_memory] == [*ladder.rung(n), "1", "contact-implicit", f"{unknowns:.0f}", f"{memory / 1e6:.0f}"]
        assert abs(float(shown_seconds) / seconds - 1) < 6e-3  # three digits, of a time that the table rounds too


def test_lines_of_orders(ladder: Study) -> None:
    for one, line in zip(ladder.manifest["orders"], ladder.lines_after("degree 1, contact-implicit:", 2)):
        shown = [one["quantity"]]
        for kind in ("space", "time", "both"):
            order, asymptotic = one[kind], one["asymptotic"][kind]
            if order is None:
                shown.append("-")
            else:
                scatter = "({:.{d}f} to {:.{d}f})".format(*one["scatter"][kind], d=2 if asymptotic else 1)
                shown += [f"{order:.2f}" if asymptotic else "none", *scatter.split()]
        assert line.split() == shown


@pytest.mark.parametrize("name", NAMES)
def test_errors(ladder: Study, name: str) -> None:
    near("errors", ladder.rows[f"{name}_error"], ladder.errors(name), TABLE)
    near("the largest there and at finer rungs", ladder.rows[f"{name}_envelope"], ladder.envelope(name), TABLE)
    assert list(map(bool, ladder.rows[f"{name}_pareto"])) == ladder.front(name), "rungs that no cheaper one beats"


@pytest.mark.parametrize("name", NAMES)
def test_lines_of_a_quantity(ladder: Study, name: str) -> None:
    value, error, most, front = ladder.rows[name], ladder.errors(name), ladder.envelope(name), ladder.front(name)
    for n, line in enumerate(ladder.lines_after(ladder.manifest["quantities"][name]["title"], 2, RUNGS)):
        assert line.replace(" %", "%").split()[:6] == [
            *ladder.rung(n), f"{value[n]:.6g}", "reference" if np.isnan(error[n]) else f"{100 * error[n]:.3g}%",
            "-" if np.isnan(most[n]) else f"{100 * most[n]:.3g}%"]  # fmt: skip
        assert line.endswith("*") == front[n]


def test_page_and_pictures(ladder: Study) -> None:
    drawn.study(ladder.out, ladder.rows, NAMES)


def test_estimates_of_the_error(tmp_path: Path) -> None:
    """How much of the error of J they are, and the lines of the console."""
    out = tmp_path / "estimates"
    lines = study(BLOCK_SCENE, out, "--sizes", "0.5,0.3", "--steps", "0.04,0.01", "--quantity", "J").stdout.splitlines()
    rows, start = table(out / "study.csv"), next(i for i, line in enumerate(lines) if line.startswith("J: "))
    parts = [rows[f"J_estimate_{part}"] for part in ("space", "time", "initial", "desired")]
    known = np.isfinite(rows["J_effectivity"])
    assert known.any(), "no error is known well enough: the case says nothing"
    for n, line in enumerate(lines[start + 2 : start + 2 + RUNGS]):
        estimate, effectivity = rows["J_estimate"][n], rows["J_effectivity"][n]
        near("the parts of an estimate", estimate, np.sum([part[n] for part in parts]), TABLE)
        if known[n]:
            near("est/err", effectivity, estimate / rows["J_error"][n], TABLE)
        shown = [f"{100 * estimate:.3g}%", f"{effectivity:.2f}" if known[n] else "-"]
        assert line.replace(" %", "%").replace("*", "").split()[-2:] == shown
