# SPDX-License-Identifier: GPL-3.0-or-later
"""A headless browser opens the page of a batch and does what a reader does: chooses axes, brushes and sorts, by mouse and keyboard."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from batch_folders import ODD, REASON, samples, write_batch, write_linear
from browser import Reader, browser, opened, page_of
from selenium.webdriver import ActionChains, Chrome, Keys

PLOT = "document.getElementById('scatter-plot').data"
COUNT = "document.getElementById('parallel-count').textContent"
PICTURE = "document.querySelector('#parallel-plot canvas').toDataURL()"
LABELS = "Array.from(document.querySelectorAll('svg text'), (one) => one.textContent).join('\\n')"
NO_NUMBER = r"\b(undefined|NaN|null|Infinity)\b"
FIRST = "Array.from(document.querySelectorAll('#cases-table tbody tr'), (row) => row.cells[{}].textContent)"


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chrome]:
    with browser(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder, *_ = write_linear(tmp_path_factory.mktemp("batches") / "linear")
    return page_of(folder)


@pytest.fixture
def reader(driver: Chrome, page: Path) -> Iterator[Reader]:
    """The reader of a page; at its end there must have been no error, and no text of a number that there is not."""
    with opened(driver, page) as reader:
        yield reader
        text = reader.ask("document.body.innerText") + reader.ask(LABELS)
        assert "material.young" in text and not re.search(NO_NUMBER, text)


def marks(reader: Reader, trace: int = 0) -> list[list[float]]:
    return [reader.ask(f"Array.from({PLOT}[{trace}].{axis})") for axis in "xy"]


def drag(reader: Reader, axis: int, start: float, end: float) -> None:
    """Drags along an axis of the parallel coordinates, between parts of its length from below."""
    handle = reader.driver.find_elements("css selector", "#parallel-plot .handle")[axis]
    reader.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", handle)
    tall = handle.size["height"] - 12
    at = [round(tall * (0.5 - part)) for part in (start, end)]
    hand = ActionChains(reader.driver).move_to_element_with_offset(handle, 0, at[0])
    hand.click_and_hold().move_by_offset(0, at[1] - at[0]).release().perform()


def test_scatter(reader: Reader) -> None:
    """First it shows the first quantity over the first key; a failed case has a mark where both axes are keys."""
    a, b, _ = samples(60)
    done = np.arange(60) != 7
    assert marks(reader)[0] == pytest.approx(a[done], rel=1e-8) and len(marks(reader)[1]) == 59
    assert reader.ask(f"{PLOT}[0].text[0]").startswith("<b>soft, \"wet\" &lt;b&gt;&amp;amp;</b><br>material.young: 0.618034<br>impulse")
    reader.changed(f"{PLOT}.length", lambda: reader.select("#scatter-y", 1))
    assert marks(reader)[1] == pytest.approx(b[done], rel=1e-8)
    assert marks(reader, 1) == [[pytest.approx(a[7], rel=1e-8)], [pytest.approx(b[7], rel=1e-8)]]
    assert reader.ask(f"{PLOT}[1].name") == "failed"
    reader.changed(f"{PLOT}.map((trace) => trace.name)", lambda: reader.select("#scatter-colour", 4))
    assert reader.ask(f"{PLOT}.map((trace) => trace.name)") == ["contact-implicit", "contact-stabilized", "failed"]
    assert [len(marks(reader, trace)[0]) for trace in range(3)] == [20, 39, 1]
    button = reader.find("#scatter-card .legend button")
    reader.changed(f"{PLOT}[0].visible !== false", button.click)
    reader.changed("document.getElementById('scatter-plot').layout.xaxis.ticktext || []", lambda: reader.select("#scatter-x", 3))
    reader.changed(f"{PLOT}.length", lambda: reader.select("#scatter-colour", 0))
    assert reader.ask(f"{PLOT}[0].name") == "done"


def test_tooltip(reader: Reader) -> None:
    """The name of a case stands there as it is in the table."""
    reader.driver.execute_script("Plotly.Fx.hover('scatter-plot', [{curveNumber: 0, pointNumber: 0}])")
    reader.wait("document.querySelector('#scatter-plot .hovertext') !== null")
    assert reader.ask("document.querySelector('#scatter-plot .hovertext').textContent").startswith(ODD)


def test_logarithmic(reader: Reader) -> None:
    """A quantity over decades has a logarithmic axis, and colours by its logarithm."""
    kind = "document.getElementById('scatter-plot').layout.yaxis.type"
    reader.changed(kind, lambda: reader.select("#scatter-y", 5))
    assert reader.ask(kind) == "log"
    reader.select("#scatter-colour", 6)
    reader.wait(f"{PLOT}[{PLOT}.length - 1].marker.colorbar.title.text.startsWith('peak force')")
    values = np.array(marks(reader)[1])
    shades = reader.ask(f"{PLOT}[0].marker.color")
    assert shades[int(values.argmin())] == "rgb(68, 1, 84)" and shades[int(values.argmax())] == "rgb(253, 231, 37)"


def test_brush(reader: Reader) -> None:
    """A range on an axis selects the cases within, two ranges those within both; the scatter plot follows; a click releases an axis."""
    a, b, _ = samples(60)
    part = [(values - values.min()) / np.ptp(values) for values in (a, b)]
    picture = reader.ask(PICTURE)
    drag(reader, 0, 0.5, 1.1)
    reader.wait(f"{COUNT} !== ''")
    within = part[0] > 0.5
    assert abs(int(reader.ask(COUNT).split(" of ")[0]) - within.sum()) <= 2 and " of 60 cases: " in reader.ask(COUNT)
    assert reader.ask(PICTURE) != picture
    drag(reader, 1, 0.6, -0.1)
    both = within & (part[1] < 0.6)
    reader.wait(f"{PLOT}[0].selectedpoints.length < {within.sum() - 3}")
    assert abs(int(reader.ask(COUNT).split(" of ")[0]) - both.sum()) <= 2
    assert len(reader.ask(f"{PLOT}[0].selectedpoints")) == int(reader.ask(COUNT).split(" of ")[0]) - int(both[7])
    reader.changed(COUNT, lambda: drag(reader, 0, 0.3, 0.3))
    reader.changed(COUNT, reader.find("#parallel-clear").click)
    assert reader.ask(COUNT) == "" and not reader.find("#parallel-clear").is_enabled()
    assert reader.ask(f"{PLOT}[0].selectedpoints === undefined")


def test_brush_by_keys(reader: Reader) -> None:
    handle = reader.find("#parallel-plot .handle")
    said = "document.querySelector('#parallel-plot .handle').getAttribute('aria-valuetext')"
    assert reader.ask(said) == "all"
    for key in (Keys.ARROW_UP, Keys.ARROW_UP, Keys.ARROW_DOWN, "+", "-"):
        reader.changed(said, lambda key=key: handle.send_keys(key))
    low, high = map(float, reader.ask(said).split(" to "))
    a = samples(60)[0]
    assert [(low - a.min()) / np.ptp(a), (high - a.min()) / np.ptp(a)] == pytest.approx([0.45, 0.65], rel=0, abs=1e-5)
    assert int(reader.ask(COUNT).split(" of ")[0]) == ((a >= low) & (a <= high)).sum()
    handle.send_keys(Keys.ESCAPE)
    assert reader.ask(said) == "all" and reader.ask(COUNT) == ""


def test_colours_of_lines(reader: Reader) -> None:
    for index in (0, 4, 6):
        reader.changed(PICTURE, lambda index=index: reader.select("#parallel-colour", index))
    assert "peak force (two-step mean) (kN/m)" in reader.ask("document.getElementById('parallel-ramp').textContent")


def test_sort(reader: Reader) -> None:
    """Numbers sort by value, empty cells are last, and a second click sorts downwards."""
    heads = reader.driver.find_elements("css selector", "#cases-table .sort")
    heads[10].click()
    found = reader.ask(FIRST.format(10))
    values = [float(cell) for cell in found[:-1]]
    assert found[-1] == "" and len(set(values)) > 50 and values == sorted(values) and len(values) == 59
    heads[10].click()
    assert reader.ask(FIRST.format(10)) == [*found[-2::-1], ""]
    heads[0].click()
    assert reader.ask(FIRST.format(0))[:3] == ["case 2", "case 3", "case 4"] and reader.ask(FIRST.format(0))[-1] == ODD
    heads[7].send_keys(Keys.ENTER)
    assert reader.ask(FIRST.format(7))[:2] == [REASON, ""]
    assert reader.ask("Array.from(document.querySelectorAll('#cases-table th'), (one) => one.getAttribute('aria-sort'))")[7] == "ascending"


def test_influence(reader: Reader) -> None:
    bars = "document.getElementById('influence-plot').data"
    assert reader.ask(f"{bars}.map((trace) => trace.type)") == ["bar", "bar"]
    reader.changed(f"{bars}[0].y", lambda: reader.select("#influence-view", 1))
    button = reader.find("#influence .legend button")
    reader.changed(f"{bars}[0].visible !== false", button.click)


def test_fits_a_phone(driver: Chrome, page: Path) -> None:
    with opened(driver, page, 390, 844) as reader:
        reader.fits()
        assert reader.ask("document.getElementById('parallel-plot').clientWidth") > 390, "axes are too close for a finger"
        reader.size(844, 390)
        reader.wait("document.documentElement.clientWidth > 700")
        reader.fits()


@pytest.mark.parametrize("cases", (
    [("1", ["2"], [3.0, 4.0])],
    [("1", ["2"], "memory"), ("2", ["3"], "memory")],
    [("1", ["p"], [1.0, 2.0]), ("2", ["q"], [2.0, np.nan]), ("3", ["p"], "memory")],
    [("1", ["1"], [1.0, np.nan]), ("2", ["1"], [2.0, 3.0]), ("3", ["1"], [4.0, 5.0])],
), ids=("one", "all failed", "texts", "no key varies"))  # fmt: skip
def test_small_batches(cases: list, driver: Chrome, tmp_path: Path) -> None:
    """Parts without data are left out, and nothing fails."""
    with opened(driver, page_of(write_batch(tmp_path, ["a"], cases))) as reader:
        reader.fits()
        assert not re.search(NO_NUMBER, reader.ask("document.body.innerText") + reader.ask(LABELS))
        reader.find("#cases-table .sort").click()
