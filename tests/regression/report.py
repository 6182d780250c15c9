# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of a run and of a study: whole in one file, drawn without network, and driven by mouse, keyboard and finger's width.

A headless browser opens it and does what a reader does.
"""

import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from browser import BODY, Reader, browser, make, page_of  # noqa: E402
from harness import HALF_BALL, HALF_DISC, SIGNORINI, SOURCE, signorini, table  # noqa: E402

sys.path.insert(0, str(SOURCE / "postprocess"))
import as_package  # noqa: E402, F401
from signorini.post.run_folder import RunFolder, Unreadable  # noqa: E402
from signorini.post.study_folder import StudyFolder  # noqa: E402

from selenium.webdriver import Chrome, Keys  # noqa: E402
from selenium.webdriver.support.select import Select  # noqa: E402

LARGEST = 8_000_000  # bytes, for the half disc as shipped: a page that can be mailed
MAP = "document.querySelector('#contact-surface-plot .hm image').href.baseVal"


def read_run(driver: Chrome, page: Path) -> None:
    """What there is to do on a run's page."""
    reader = Reader(driver, page, 1280, 900)
    opens_at_the_peak(reader)
    slider = reader.find("#frame")
    vertices = f"Array.from({BODY}[0].{'y' if 'half-disc' in page.read_text() else 'z'}).slice(0, 500)"
    for key in (Keys.ARROW_RIGHT, Keys.HOME, Keys.END, Keys.PAGE_DOWN * 3 + Keys.ARROW_LEFT):
        reader.changed(vertices, lambda key=key: slider.send_keys(key))
    reader.changed(vertices, slider.click)  # in its middle
    frame = int(slider.get_attribute("value"))
    assert 0 < frame < int(slider.get_attribute("max")), frame
    assert reader.ask("document.getElementById('now').textContent") == f"t = {slider.get_attribute('aria-valuetext')}"
    assert reader.ask(f"{BODY}.find((trace) => trace.name === 'in contact')") is not None
    for index in range(1, len(Select(reader.find("#field")).options)):
        reader.changed(f"[Array.from({BODY}[0].intensity).slice(0, 500), {BODY}[0].colorbar.title.text]",
                       lambda index=index: reader.select("#field", index))  # fmt: skip
    reader.changed(vertices, lambda: slider.send_keys(Keys.END + Keys.PAGE_DOWN))
    reader.changed("document.getElementById('frame').value", lambda: reader.find("#play").send_keys(Keys.SPACE))
    reader.wait("document.getElementById('play').textContent === 'Play'")
    assert slider.get_attribute("value") == slider.get_attribute("max"), "playing did not go to the end"
    reader.changed("document.getElementById('body-plot').layout.scene.aspectratio", reader.find("#nearer").click)
    legend_of(reader, "energies")
    for view in (1, 2):
        reader.changed(MAP, lambda view=view: reader.select("#contact-surface-view", view))
    reader.close()
    narrow(driver, page)


def opens_at_the_peak(reader: Reader) -> None:
    """The first picture is that of the step of the largest contact force."""
    steps = table(reader.page.parent / "steps.csv")
    force = steps["normal_force"]
    assert force.max() > 0, "the body never touches"
    peak = next(step for step, modulus in enumerate(force) if modulus > (1 - 1e-9) * force.max())
    assert peak in table(reader.page.parent / "contact.csv")["step"], "it is not stored"
    time, unit = reader.ask("document.getElementById('now').textContent").removeprefix("t = ").split(" ")
    shown = float(time) * {"s": 1, "ms": 1e-3}[unit]
    # 4 digits are shown.
    assert abs(shown - steps["time"][peak]) <= 5e-4 * shown, (shown, steps["time"][peak])


def legend_of(reader: Reader, chart: str) -> None:
    """A click hides a curve, a key shows it again."""
    button = reader.find(f"#{chart} .legend button")
    visible = f"document.getElementById('{chart}-plot').data[0].visible !== false"
    reader.changed(visible, button.click)
    assert button.get_attribute("aria-pressed") == "false" and not reader.ask(visible)
    reader.changed(visible, lambda: button.send_keys(Keys.ENTER))
    assert button.get_attribute("aria-pressed") == "true" and reader.ask(visible)


def narrow(driver: Chrome, page: Path) -> None:
    """On a phone's screen, also after it was turned."""
    reader = Reader(driver, page, 390, 844)
    reader.fits()
    reader.size(844, 390)
    reader.wait("document.documentElement.clientWidth > 700")
    reader.fits()
    reader.close()


def read_study(driver: Chrome, page: Path) -> None:
    reader = Reader(driver, page, 1280, 900)
    plot = "document.getElementById('work-precision-plot')"
    names = reader.ask(f"{plot}.data.map((trace) => trace.name)")
    assert names[0] == "Pareto front" and set(names[1:]) == {"Error bar of the finest rung", "degree 1, contact-implicit",
        "degree 1, contact-stabilized", "degree 1, contact-implicit, massless"}, names  # fmt: skip
    assert reader.ask(f"{plot}.layout.xaxis.type + {plot}.layout.yaxis.type") == "loglog"
    marks = "Array.from(document.querySelectorAll('#work-precision-plot .points path'), (mark) => mark.getAttribute('transform'))"
    reader.changed(marks, lambda: reader.select("#work-precision-view", 1))
    legend_of(reader, "work-precision")
    text = reader.ask("document.body.innerText")
    manifest = json.loads((page.parent / "study.json").read_text())
    first = manifest["orders"][0]
    order = f"{first['space']:.2f} (" if first["asymptotic"]["space"] else "not in the asymptotic range ("
    for expected in (*manifest["sentences"], manifest["quantities"]["J"]["bar"]["words"], "N s/m", "finest rung", order, "★"):
        assert expected in text, f"{expected} is not on the page"
    assert reader.ask("document.querySelectorAll('#rungs tbody tr').length") == 18
    assert reader.ask("document.querySelectorAll('#values table').length") == 2  # J and impulse
    assert reader.ask("document.querySelectorAll('#values tbody tr').length") == 2 * 18
    assert reader.ask("document.querySelectorAll('#searches tbody tr').length") == 2
    reader.close()
    narrow(driver, page)


def write_study(folder: Path) -> Path:
    """Three rungs in size and two in time of each scheme."""
    subprocess.run([SIGNORINI, "study", HALF_DISC, "--out", folder, "--quiet", "--sizes", "3,2,1.5", "--steps", "2.5e-4,1.25e-4", "--schemes",
                    "contact-implicit,contact-stabilized,massless", "--quantity", "J,impulse", "--search-tolerances", "0.5,0.1"], check=True)  # fmt: skip
    return folder


def refused(folder: Path, *expected: str) -> None:
    """One sentence, and no page."""
    (folder / "report.html").unlink(missing_ok=True)
    done = make(folder)
    assert done.returncode == 2 and done.stderr.startswith("report.py: ") and done.stderr.count("\n") == 1, done.stderr
    assert not done.stdout and all(part in done.stderr for part in expected), done.stderr
    assert not folder.is_dir() or not list(folder.glob("*report*")), list(folder.iterdir())


def damaged(whole: Path, folder: Path, file: str, change: Callable[[bytes], bytes], *expected: str) -> None:
    """A copy of a folder with one file changed is refused."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(whole, folder)
    (folder / file).write_bytes(change((folder / file).read_bytes()))
    refused(folder, file, *expected)


def cut_anywhere(folder: Path, study: Path) -> None:
    """Of a run's and a study's files not one byte may be missing at the end: the readers notice a cut at any byte of a table's last
    two lines, and at two hundred places before; the program says so."""
    out, count = folder / "short", 0
    signorini("optimize", HALF_DISC, out, mesh__size=4, time__end=2.5e-4, optimizer__max_iterations=2)
    shutil.copytree(study, folder / "few")
    run = lambda read: lambda: read(RunFolder(out))  # noqa: E731
    rungs = lambda: StudyFolder(folder / "few").rungs  # noqa: E731
    searches = lambda: StudyFolder(folder / "few").searches  # noqa: E731
    readers = {"steps.csv": run(lambda run: run.steps), "contact.csv": run(lambda run: run.contact), "history.csv": run(lambda run: run.history),
               "scene.toml": run(lambda run: run.scene), "run.json": run(lambda run: run.manifest),
               "state.xdmf": run(lambda run: run.field("state.xdmf", "velocity")), "study.csv": rungs, "study.json": rungs, "search.csv": searches,
               "state.h5": run(lambda run: run.field("state.xdmf", "velocity").at(5))}  # fmt: skip
    for file, read in readers.items():
        path = (folder / "few" if read in (rungs, searches) else out) / file
        whole = path.read_bytes()
        read()
        lines = whole.rindex(b"\n", 0, whole.rindex(b"\n", 0, -1)) if file.endswith(".csv") else len(whole)  # before the last two
        for length in [*range(0, lines, np.maximum(1, lines // 200)), *range(lines, len(whole)), len(whole) - 1]:
            path.write_bytes(whole[:length])
            try:
                read()
            except Unreadable as problem:
                assert file in str(problem) and "\n" not in str(problem), problem
                count += 1
                continue
            raise AssertionError(f"{file} with {length} of {len(whole)} bytes passes for whole")
        path.write_bytes(whole[: whole.rindex(b"\n", 0, -1) + 1])  # all but the last line, the one that looks best
        refused(path.parent, file)
        path.write_bytes(whole)
    page_of(out)
    print(f"{count} cut files were found out")


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        signorini("optimize", HALF_DISC, folder / "disc", optimizer__max_iterations=3)
        signorini("optimize", HALF_BALL, folder / "ball", mesh__size=3, time__step=2.5e-4, optimizer__max_iterations=2,
                  control__initial=["0", "0", "-0.9"])  # fmt: skip
        signorini("optimize", HALF_DISC, folder / "bare", mesh__size=3, optimizer__max_iterations=1, output__tables=[],
                  output__fields=[])  # fmt: skip
        signorini("optimize", HALF_DISC, folder / "cells", mesh__size=2, mesh__degree=2, control__space="cellwise", optimizer__max_iterations=1)
        study = write_study(folder / "study")
        start = time.perf_counter()
        disc = page_of(folder / "disc")
        seconds, size = time.perf_counter() - start, disc.stat().st_size
        assert size <= LARGEST, f"{size} bytes"
        with browser(folder / "profile") as driver:
            read_run(driver, disc)
            read_run(driver, page_of(folder / "ball"))
            read_study(driver, page_of(study))
            for part in ("bare", "cells"):
                narrow(driver, page_of(folder / part))
        bare = (folder / "bare" / "report.html").read_text(encoding="utf-8")
        assert "there is no state.xdmf" in bare and 'id="body"' not in bare, "a run without fields"

        (folder / "empty").mkdir()
        refused(folder / "empty", "neither a run nor a study")
        around = make(folder)
        assert around.returncode == 2 and f"runs inside: {folder / 'ball'}, {folder / 'bare'}, " in around.stderr, around.stderr
        refused(folder / "nowhere", "there is no such folder")
        damaged(folder / "disc", folder / "damaged", "run.json", lambda _: b"[]")
        damaged(folder / "disc", folder / "damaged", "run.json", lambda text: text.replace(b'"unknowns"', b'"known"'), "unknowns")
        damaged(study, folder / "damaged", "study.json", lambda text: text.replace(b'"orders"', b'"order"'), "orders")
        damaged(study, folder / "damaged", "study.csv", lambda text: text.replace(b"impulse_error", b"impulse_eror"), "impulse_error")
        cut_anywhere(folder, study)
        print(f"the half disc's page has {size / 1e6:.1f} MB and was made in {seconds:.1f} s")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
