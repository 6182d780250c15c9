# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of a run and of a study: whole in one file, drawn without network, and driven by mouse, keyboard and finger's width.

A headless browser opens it and does what a reader does.
"""

import json
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import as_package  # noqa: F401
import numpy as np
import pytest
from browser import BODY, Reader, browser, make, opened, page_of
from harness import HALF_BALL, HALF_DISC, SIGNORINI, signorini, table
from selenium.webdriver import Chrome, Keys
from selenium.webdriver.support.select import Select
from signorini.post.run_folder import RunFolder, Unreadable
from signorini.post.study_folder import StudyFolder

LARGEST = 8_000_000  # bytes, for the half disc as shipped: a page that can be mailed
MAP = "document.querySelector('#contact-surface-plot .hm image').href.baseVal"


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chrome]:
    with browser(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of runs alone."""
    folder = tmp_path_factory.mktemp("runs")
    signorini("optimize", HALF_DISC, folder / "disc", optimizer__max_iterations=3)
    signorini("optimize", HALF_BALL, folder / "ball", mesh__size=3, time__step=2.5e-4, optimizer__max_iterations=2,
              control__initial=["0", "0", "-0.9"])  # fmt: skip
    signorini("optimize", HALF_DISC, folder / "bare", mesh__size=3, optimizer__max_iterations=1, output__tables=[], output__fields=[])
    signorini("optimize", HALF_DISC, folder / "cells", mesh__size=2, mesh__degree=2, control__space="cellwise", optimizer__max_iterations=1)
    return folder


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three rungs in size and two in time of each scheme."""
    folder = tmp_path_factory.mktemp("studies") / "study"
    subprocess.run([SIGNORINI, "study", HALF_DISC, "--out", folder, "--quiet", "--sizes", "3,2,1.5", "--steps", "2.5e-4,1.25e-4", "--schemes",
                    "contact-implicit,contact-stabilized,massless", "--quantity", "J,impulse", "--search-tolerances", "0.5,0.1"], check=True)  # fmt: skip
    return folder


@pytest.fixture(scope="module")
def pages(runs: Path, study: Path) -> dict[str, Path]:
    return {folder.name: page_of(folder) for folder in (*runs.iterdir(), study)}


@pytest.fixture(scope="module", params=("disc", "ball"))
def reader(request: pytest.FixtureRequest, pages: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Reader]:
    """The reader of a run's page, for tests that use different parts of it; its time_at_first is what it shows when it opens."""
    with browser(tmp_path_factory.mktemp("profile")) as driver, opened(driver, pages[request.param]) as reader:
        reader.time_at_first = reader.ask("document.getElementById('now').textContent")
        yield reader


def test_opens_at_the_peak(reader: Reader) -> None:
    """The first picture is that of the step of the largest contact force."""
    steps = table(reader.page.parent / "steps.csv")
    force = steps["normal_force"]
    assert force.max() > 0, "the body never touches"
    peak = next(step for step, modulus in enumerate(force) if modulus > (1 - 1e-9) * force.max())
    assert peak in table(reader.page.parent / "contact.csv")["step"], "it is not stored"
    number, unit = reader.time_at_first.removeprefix("t = ").split(" ")
    shown = float(number) * {"s": 1, "ms": 1e-3}[unit]
    assert abs(shown - steps["time"][peak]) <= 5e-4 * shown  # 4 digits are shown


def test_slider(reader: Reader) -> None:
    """Keys and clicks move the body; playing goes to the end."""
    vertices = f"Array.from({BODY}[0].{'y' if 'half-disc' in reader.page.read_text() else 'z'}).slice(0, 500)"
    slider = reader.find("#frame")
    for key in (Keys.ARROW_RIGHT, Keys.HOME, Keys.END, Keys.PAGE_DOWN * 3 + Keys.ARROW_LEFT):
        reader.changed(vertices, lambda key=key: slider.send_keys(key))
    reader.changed(vertices, slider.click)  # in its middle
    assert 0 < int(slider.get_attribute("value")) < int(slider.get_attribute("max"))
    assert reader.ask("document.getElementById('now').textContent") == f"t = {slider.get_attribute('aria-valuetext')}"
    assert reader.ask(f"{BODY}.find((trace) => trace.name === 'in contact')") is not None
    reader.changed(vertices, lambda: slider.send_keys(Keys.END + Keys.PAGE_DOWN))
    reader.changed("document.getElementById('frame').value", lambda: reader.find("#play").send_keys(Keys.SPACE))
    reader.wait("document.getElementById('play').textContent === 'Play'")
    assert slider.get_attribute("value") == slider.get_attribute("max"), "playing did not go to the end"


def test_fields(reader: Reader) -> None:
    for index in range(1, len(Select(reader.find("#field")).options)):
        reader.changed(f"[Array.from({BODY}[0].intensity).slice(0, 500), {BODY}[0].colorbar.title.text]",
                       lambda index=index: reader.select("#field", index))  # fmt: skip


def test_camera_comes_nearer(reader: Reader) -> None:
    reader.changed("document.getElementById('body-plot').layout.scene.aspectratio", reader.find("#nearer").click)


def test_legend(reader: Reader) -> None:
    hide_and_show(reader, "energies")


def test_map_of_contact(reader: Reader) -> None:
    for view in (1, 2):
        reader.changed(MAP, lambda view=view: reader.select("#contact-surface-view", view))


def hide_and_show(reader: Reader, chart: str) -> None:
    """A click on the legend hides a curve, a key shows it again."""
    button = reader.find(f"#{chart} .legend button")
    visible = f"document.getElementById('{chart}-plot').data[0].visible !== false"
    reader.changed(visible, button.click)
    assert button.get_attribute("aria-pressed") == "false" and not reader.ask(visible)
    reader.changed(visible, lambda: button.send_keys(Keys.ENTER))
    assert button.get_attribute("aria-pressed") == "true" and reader.ask(visible)


@pytest.mark.parametrize("name", ("disc", "ball", "bare", "cells", "study"))
def test_fits_a_phone(driver: Chrome, pages: dict[str, Path], name: str) -> None:
    """Also after the phone was turned."""
    with opened(driver, pages[name], 390, 844) as reader:
        reader.fits()
        reader.size(844, 390)
        reader.wait("document.documentElement.clientWidth > 700")
        reader.fits()


def test_size(runs: Path) -> None:
    start = time.perf_counter()
    size = page_of(runs / "disc").stat().st_size
    print(f"the half disc's page has {size / 1e6:.1f} MB and was made in {time.perf_counter() - start:.1f} s")
    assert size <= LARGEST


def test_run_without_fields(pages: dict[str, Path]) -> None:
    bare = pages["bare"].read_text(encoding="utf-8")
    assert "there is no state.xdmf" in bare and 'id="body"' not in bare


def test_study(driver: Chrome, pages: dict[str, Path]) -> None:
    manifest = json.loads((pages["study"].parent / "study.json").read_text())
    first, plot = manifest["orders"][0], "document.getElementById('work-precision-plot')"
    order = f"{first['space']:.2f} (" if first["asymptotic"]["space"] else "not in the asymptotic range ("
    marks = "Array.from(document.querySelectorAll('#work-precision-plot .points path'), (mark) => mark.getAttribute('transform'))"
    with opened(driver, pages["study"]) as reader:
        names = reader.ask(f"{plot}.data.map((trace) => trace.name)")
        assert names[0] == "Pareto front" and set(names[1:]) == {"Error bar of the finest rung", "degree 1, contact-implicit",
            "degree 1, contact-stabilized", "degree 1, contact-implicit, massless"}  # fmt: skip
        assert reader.ask(f"{plot}.layout.xaxis.type + {plot}.layout.yaxis.type") == "loglog"
        reader.changed(marks, lambda: reader.select("#work-precision-view", 1))
        hide_and_show(reader, "work-precision")
        text = reader.ask("document.body.innerText")
        for expected in (*manifest["sentences"], manifest["quantities"]["J"]["bar"]["words"], "N s/m", "finest rung", order, "★"):
            assert expected in text
        # Of J and impulse.
        for rows, count in (("#rungs tbody tr", 18), ("#values table", 2), ("#values tbody tr", 2 * 18), ("#searches tbody tr", 2)):
            assert reader.ask(f"document.querySelectorAll('{rows}').length") == count, rows


def refused(folder: Path, *expected: str) -> None:
    """One sentence, and no page."""
    (folder / "report.html").unlink(missing_ok=True)
    done = make(folder)
    assert done.returncode == 2 and done.stderr.startswith("report.py: ") and done.stderr.count("\n") == 1, done.stderr
    assert not done.stdout and all(part in done.stderr for part in expected), done.stderr
    assert not folder.is_dir() or not list(folder.glob("*report*"))


def test_empty_folder(tmp_path: Path) -> None:
    refused(tmp_path, "not the folder of a run, a study or a batch")


def test_no_such_folder(tmp_path: Path) -> None:
    refused(tmp_path / "nowhere", "there is no such folder")


def test_folder_of_runs(runs: Path) -> None:
    refused(runs, f"runs inside: {runs / 'ball'}, {runs / 'bare'}, ")


@pytest.mark.parametrize("file, change, expected", (
    ("run.json", lambda _: b"[]", ""),
    ("run.json", lambda text: text.replace(b'"unknowns"', b'"known"'), "unknowns"),
    ("study.json", lambda text: text.replace(b'"orders"', b'"order"'), "orders"),
    ("study.csv", lambda text: text.replace(b"impulse_error", b"impulse_eror"), "impulse_error"),
))  # fmt: skip
def test_damaged_file(file: str, change: Callable[[bytes], bytes], expected: str, runs: Path, study: Path, tmp_path: Path) -> None:
    damaged = shutil.copytree(runs / "disc" if file == "run.json" else study, tmp_path / "damaged")
    (damaged / file).write_bytes(change((damaged / file).read_bytes()))
    refused(damaged, file, expected)


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("short")
    signorini("optimize", HALF_DISC, out, mesh__size=4, time__end=2.5e-4, optimizer__max_iterations=2)
    page_of(out)
    return out


READERS = {
    "steps.csv": lambda out: RunFolder(out).steps,
    "contact.csv": lambda out: RunFolder(out).contact,
    "history.csv": lambda out: RunFolder(out).history,
    "scene.toml": lambda out: RunFolder(out).scene,
    "run.json": lambda out: RunFolder(out).manifest,
    "state.xdmf": lambda out: RunFolder(out).field("state", "velocity"),
    "state.h5": lambda out: RunFolder(out).field("state", "velocity").at(5),
    "study.csv": lambda out: StudyFolder(out).rungs,
    "study.json": lambda out: StudyFolder(out).rungs,
    "search.csv": lambda out: StudyFolder(out).searches,
}


def problem_of(read: Callable[[Path], object], out: Path) -> str:
    try:
        read(out)
    except Unreadable as problem:
        return str(problem)
    return ""


@pytest.mark.parametrize("file", READERS)
def test_cut_file(file: str, short: Path, study: Path, tmp_path: Path) -> None:
    """Of a run's and a study's files not one byte may be missing at the end: the readers notice a cut at any byte of a table's last
    two lines, and at two hundred places before; the program says so."""
    out = shutil.copytree(study if file in ("study.csv", "study.json", "search.csv") else short, tmp_path / "cut")
    path, read = out / file, READERS[file]
    whole = path.read_bytes()
    read(out)
    lines = whole.rindex(b"\n", 0, whole.rindex(b"\n", 0, -1)) if file.endswith(".csv") else len(whole)  # before the last two
    for length in [*range(0, lines, np.maximum(1, lines // 200)), *range(lines, len(whole)), len(whole) - 1]:
        path.write_bytes(whole[:length])
        problem = problem_of(read, out)
        assert file in problem and "\n" not in problem, f"{length} of {len(whole)} bytes"
    path.write_bytes(whole[: whole.rindex(b"\n", 0, -1) + 1])  # all but the last line, the one that looks best
    refused(out, file)
