# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of a batch: sensitivities are those of scipy and of a fit by numpy, texts are literal, a damaged table gives one sentence.

What a reader does with it is tested in batch_page.py.
"""

import csv
import html
import json
import re
from collections.abc import Callable
from pathlib import Path

import as_package  # noqa: F401
import numpy as np
import pytest
from batch_folders import KEYS, ODD, REASON, samples, write_batch, write_linear
from browser import make, page_of
from drawn import numbers
from scipy.stats import rankdata, spearmanr
from signorini.post import report_batch
from signorini.post.batch_folder import BatchFolder, entries_of
from signorini.post.files import Unreadable
from signorini.post.report_parts import Page, Section, Table
from signorini.post.sensitivity import average_ranks, sensitivity

VARIED = ["material.young", "contact.friction", "contact.obstacle.point[1]"]


@pytest.fixture(scope="module")
def linear(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, np.ndarray, np.ndarray]:
    """A batch of known structure: its folder, the numeric keys and the quantities of the cases that are done."""
    return write_linear(tmp_path_factory.mktemp("batches") / "linear")


@pytest.fixture(scope="module")
def made(linear: tuple[Path, np.ndarray, np.ndarray]) -> Page:
    return report_batch.page(BatchFolder(linear[0]))


def page(folder: Path) -> Page:
    return report_batch.page(BatchFolder(folder))


def section(page: Page, name: str) -> Section:
    return next(one for one in page.sections if one.name == name)


def table(page: Page, name: str, start: str) -> Table:
    return next(one for one in section(page, name).tables if one.title.startswith(start))


def standardised(values: np.ndarray) -> np.ndarray:
    return (values - values.mean(axis=0)) / values.std(axis=0, ddof=1)


def cells(row: list) -> list[float]:
    return [float(str(cell)) for cell in row]


# --- Sensitivities ----------------------------------------------------------------------------------------------------


def test_rank_correlations(linear: tuple[Path, np.ndarray, np.ndarray], made: Page) -> None:
    _, keys, quantities = linear
    found = table(made, "sensitivities", "Rank correlations")
    assert found.head == ["", *VARIED, "Cases"]
    expected = spearmanr(np.hstack([keys, quantities])).statistic[3:, :3]
    for row, exact in zip(found.rows, expected, strict=True):
        assert cells(row[1:4]) == pytest.approx(exact, rel=0, abs=0.005001)
        assert row[4] == "59"
    assert abs(expected[0, 1]) > 0.7 and expected[1, 0] > 0.95, "the numbers show no structure"


def test_coefficients(linear: tuple[Path, np.ndarray, np.ndarray], made: Page) -> None:
    """They are those of a fit with an intercept, times the ratio of deviations; of y they are near 2 and -3."""
    _, keys, quantities = linear
    found = table(made, "sensitivities", "Standardised coefficients")
    assert found.head == ["", *VARIED, "R²", "R² predicted"]
    matrix = np.column_stack([np.ones(len(keys)), keys])
    for i, (row, y) in enumerate(zip(found.rows, quantities.T, strict=True)):
        fit = np.linalg.lstsq(matrix, y, rcond=None)[0]
        r2 = 1 - ((y - matrix @ fit) ** 2).sum() / ((y - y.mean()) ** 2).sum()
        assert cells(row[1:4]) == pytest.approx(fit[1:] * keys.std(axis=0) / y.std(), rel=0, abs=0.005001)
        assert cells(row[4:5]) == pytest.approx([r2], rel=0, abs=0.0005001)
        others = [np.arange(len(y)) != k for k in range(len(y))]
        missed = [y[k] - matrix[k] @ np.linalg.lstsq(matrix[rest], y[rest], rcond=None)[0] for k, rest in enumerate(others)]
        assert cells(row[5:]) == pytest.approx([1 - np.sum(np.square(missed)) / ((y - y.mean()) ** 2).sum()], rel=0, abs=0.0005001)
        if i == 0:
            assert fit[1:] == pytest.approx([2, -3, 0], rel=0, abs=0.05) and r2 > 0.99
            assert [cell.value for cell in row[1:4]] == pytest.approx(fit[1:] * keys.std(axis=0) / y.std(), rel=1e-9, abs=1e-12)


def test_chart(linear: tuple[Path, np.ndarray, np.ndarray], made: Page) -> None:
    """Bars of each quantity are those of the tables, the strongest key first."""
    _, keys, quantities = linear
    (chart,) = section(made, "sensitivities").charts
    assert list(chart.views) == ["impulse of contact", "peak force (two-step mean)"]
    ranks, coefficients = chart.views["impulse of contact"]["data"]
    assert ranks["y"] == coefficients["y"] == ["contact.friction", "material.young", "contact.obstacle.point[1]"]
    exact = spearmanr(np.column_stack([quantities[:, 0], keys])).statistic[0, 1:]
    assert numbers(ranks["x"]) == pytest.approx(exact[[1, 0, 2]], rel=1e-5, abs=1e-6)
    x, y = standardised(keys), standardised(quantities[:, 0])
    assert numbers(coefficients["x"]) == pytest.approx(np.linalg.solve(x.T @ x, x.T @ y)[[1, 0, 2]], rel=1e-5, abs=1e-6)
    assert chart.views["impulse of contact"]["layout"]["xaxis"]["title"]["text"] == "59 cases, linear fit R² = 1.00"
    assert chart.title == "Influence of the keys"


def test_sentences(made: Page) -> None:
    assert section(made, "sensitivities").texts == [
        "The numbers are from 59 cases that are done; 95 % of rank correlations of 59 independent pairs lie within ±0.26.",
        "Keys left out, since they are not numeric: time.scheme.",
        "Keys left out, since they do not vary in the cases that are done: mesh.size.",
    ]


def test_weak_fit(tmp_path: Path) -> None:
    """A parabola is not explained by a line."""
    a = np.linspace(-1, 1, 41)
    folder = write_batch(tmp_path, ["a"], [(str(i), [f"{x}"], [x**2, x]) for i, x in enumerate(a)])
    expected = "A linear fit explains less than half of the variance of impulse of contact: use the scatter plot."
    assert expected in section(page(folder), "sensitivities").texts
    first, second = table(page(folder), "sensitivities", "Standardised").rows
    assert cells(first[1:3]) == pytest.approx([0, 0], rel=0, abs=1e-9) and str(first[1]) == "+0.00"
    assert cells(second[1:]) == pytest.approx([1, 1, 1], rel=1e-12)


def test_dependent_keys(tmp_path: Path) -> None:
    """Ranks are there, coefficients are not unique."""
    a, b, _ = samples(20)
    cases = [(str(i), [f"{x}", f"{2 - x}", f"{y}"], [x + y, x]) for i, (x, y) in enumerate(zip(a, b))]
    made = section(page(write_batch(tmp_path, ["a", "b", "c"], cases)), "sensitivities")
    assert [one.title.split(" ")[0] for one in made.tables] == ["Rank"]
    assert made.tables[0].rows[1][1:3] == [report_batch.shaded(1.0), report_batch.shaded(-1.0)]
    assert "a and b vary together (correlation -1.000): the cases hardly separate their effects." in made.texts
    assert any(text.startswith("No coefficients where") for text in made.texts)
    assert "R²" not in made.charts[0].views["impulse of contact"]["layout"]["xaxis"]["title"]["text"]


@pytest.mark.parametrize("cases, fitted", ((4, False), (5, True)))
def test_few_cases(cases: int, fitted: bool) -> None:
    """A fit by three keys needs five cases."""
    keys = np.stack(samples(cases), axis=1)
    found = sensitivity(keys, keys @ [1, 2, 3] + np.sin(np.arange(cases)))
    assert found.cases == cases and np.isfinite(found.ranks).all()
    assert np.isfinite(found.coefficients).all() == fitted == np.isfinite(found.explained)


def test_left_out_cases() -> None:
    """Cases without a number count in nothing; a key that does not vary in the others has no sensitivity."""
    a, b, _ = samples(12)
    keys, y = np.stack([a, b, np.where(np.arange(12) == 3, 2.0, 1.0)], axis=1), a - b**2
    y[3], keys[5, 1] = np.nan, np.nan
    rest = np.isin(np.arange(12), [3, 5], invert=True)
    found = sensitivity(keys, y)
    assert found.cases == 10 and np.isnan([found.ranks[2], found.coefficients[2]]).all()
    assert found.ranks[:2] == pytest.approx([spearmanr(key, y[rest]).statistic for key in keys[rest, :2].T], rel=1e-12)


def test_equal_ranks() -> None:
    for values in ([3.0, 1.0, 3.0, 2.0, 3.0, 1.0], [1.0], [5.0, 5.0], [2.0, 1.0, 0.0]):
        assert list(average_ranks(np.array(values))) == list(rankdata(values))


# --- What the page has ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("cell, expected", (
    ("2", {"": 2}), ("-1e-3", {"": -0.001}), ("1_000", {"": 1000}), (" 7 ", {"": 7}), (".5", {"": 0.5}), ("", {}), ('"0.25"', {"": 0.25}),
    ("[0, -0.1]", {"[0]": 0, "[1]": -0.1}), ('["0", "-0.1*t"]', {"[0]": 0, "[1]": "-0.1*t"}),
    ("[[1, 2], [3]]", {"[0][0]": 1, "[0][1]": 2, "[1][0]": 3}),
    ("{ bulk = 0.1, shear = 2 }", {".bulk": 0.1, ".shear": 2}), ("true", {"": "true"}), ("-0.1*t", {"": "-0.1*t"}), ("nan", {"": "nan"}),
    ("1\ny = 2", {"": "1\ny = 2"}), ("[" * 5000, {"": "[" * 5000}), ("9" * 400, {"": "9" * 400}),
    ("contact-implicit", {"": "contact-implicit"}),
))  # fmt: skip
def test_cells(cell: str, expected: dict[str, object]) -> None:
    assert entries_of(cell) == expected


def test_mixed_forms(tmp_path: Path) -> None:
    """A key that is a number in one case and a vector in another is one of texts, as is a component with an expression."""
    texts = ["1", '["0", "1"]'], ["[1, 2]", '["0", "t"]'], ["", '["0", "2"]']
    folder = write_batch(tmp_path, ["a", "b"], [(str(i), one, [i, i]) for i, one in enumerate(texts)])
    (first,), (second,) = BatchFolder(folder).keys.values()
    assert (first.name, first.words, list(first.values[:2]), np.isnan(first.values[2])) == ("a", ("1", "[1, 2]"), [0, 1], True)
    assert (second.name, second.words, list(second.values)) == ("b[1]", ("1", "t", "2"), [0, 1, 2])
    assert "not numeric: a, b[1]." in section(page(folder), "sensitivities").texts[1]


def test_ranges(linear: tuple[Path, np.ndarray, np.ndarray], made: Page) -> None:
    """Of keys over all cases, of quantities over those that are done; units have prefixes."""
    _, _, quantities = linear
    rows = {row[0]: row[1:] for row in table(made, "summary", "Ranges").rows}
    a = samples(60)[0]
    assert rows["material.young"] == [*(f"{value:.6g}" for value in (a.min(), np.median(a), a.max())), "60"]
    forces = np.quantile(quantities[:, 1], [0, 0.5, 1]) / 1e3
    assert rows["peak force (two-step mean) (kN/m)"] == [*(f"{value:.6g}" for value in forces), "59"]
    for words in ("time.scheme: contact-implicit, contact-stabilized", "mesh.size: 0.1 in all"):
        assert rows[words] == ["", "", "", "60"]
    assert "impulse of contact (N s/m)" in rows and "contact.obstacle.point[1]" in rows and "contact.obstacle.point[0]" not in rows


def test_failed_cases(linear: tuple[Path, np.ndarray, np.ndarray], made: Page) -> None:
    assert table(made, "summary", "Cases that failed").rows == [[REASON, "1", "case 8"]]
    with open(linear[0] / "cases.csv", newline="") as file:
        failed = next(row for row in csv.DictReader(file) if row["outcome"] == "failed")
    found = table(made, "scatter", "Cases that failed")
    assert found.head == ["Case", *KEYS[:-1], "Reason"] and found.rows == [["case 8", *(failed[key] for key in KEYS[:-1]), REASON]]
    assert ("Cases", "60: 59 done, 1 failed") in made.facts


def test_data_of_the_script(linear: tuple[Path, np.ndarray, np.ndarray], made: Page) -> None:
    _, keys, quantities = linear
    axes = {axis["label"]: axis for axis in made.batch["axes"]}
    assert list(axes) == [*VARIED, "time.scheme", "impulse of contact (N s/m)", "peak force (two-step mean) (kN/m)"]
    assert [axis["key"] for axis in axes.values()] == [True] * 4 + [False] * 2 and made.batch["keys"] == 4
    assert [axis["log"] for axis in axes.values()] == [False] * 5 + [True]
    done = np.arange(60) != 7
    for name, exact in zip(list(axes)[:3], samples(60)):
        assert axes[name]["values"] == pytest.approx(exact, rel=1e-8)
    impulse = axes["impulse of contact (N s/m)"]["values"]
    assert impulse[7] is None and [value for value, on in zip(impulse, done) if on] == pytest.approx(quantities[:, 0], rel=1e-8)
    assert axes["time.scheme"]["values"] == [int(i % 3 > 0) for i in range(60)] and made.batch["names"][0] == ODD
    assert made.batch["rows"][7][-6:] == ["failed", REASON, "", "", "", ""]


def test_html(linear: tuple[Path, np.ndarray, np.ndarray]) -> None:
    """Texts of the table are literal, and none is the word for a number that there is not."""
    text = page_of(linear[0]).read_text(encoding="utf-8")
    visible = re.sub(r"(?s)<script.*?</script>|<style.*?</style>", "", text)
    assert f"<td>{html.escape(ODD).replace('&quot;', '&#34;')}</td>" in visible
    assert "<script>alert" not in text and "&lt;script&gt;alert(1)&lt;/script&gt;" in visible and "<b>&amp;" not in visible
    assert not re.search(r"\b(undefined|NaN|nan|None|Infinity)\b", re.sub(r"<[^>]*>", " ", visible))
    assert visible.count("<td>failed</td>") == 1 and visible.count("<td>done</td>") == 59
    assert "batch of block with 60 cases" in text and "signorini 1.0, dolfinx 0.9.0" in text


def test_names_of_keys_are_literal(tmp_path: Path) -> None:
    a, b, _ = samples(6)
    keys = ["x<i>", "y&"]
    folder = write_batch(tmp_path, keys, [(str(i), [f"{x}", f"{y}"], [x - y, x * y]) for i, (x, y) in enumerate(zip(a, b))])
    (chart,) = section(page(folder), "sensitivities").charts
    assert sorted(chart.views["impulse of contact"]["data"][0]["y"]) == ["x&lt;i&gt;", "y&amp;"]
    assert "<i>" not in re.sub(r"(?s)<script.*?</script>", "", page_of(folder).read_text(encoding="utf-8"))


def test_one_case(tmp_path: Path) -> None:
    folder = write_batch(tmp_path, ["a"], [("1", ["2"], [3.0, 4.0])])
    made = page(folder)
    assert [one.name for one in made.shown()] == ["summary", "sensitivities", "cases"]
    assert section(made, "sensitivities").texts[0] == (
        "Sensitivities need 3 cases or more that are done and differ in a numeric key and in a quantity; 1 of 1 cases is done.")  # fmt: skip
    assert "batch of block with 1 case" == made.identity and page_of(folder).is_file()


@pytest.mark.parametrize("cases", (
    [("1", ["2"], "memory"), ("2", ["3"], "memory"), ("3", ["4"], "")],
    [("1", ["2"], [1.0, 2.0]), ("2", ["3"], [2.0, np.nan])],
    [("1", ["p"], [1.0, 2.0]), ("2", ["q"], [2.0, 1.0]), ("3", ["r"], [2.0, 3.0])],
    [("1", ["1"], [1.0, 2.0]), ("2", ["2"], [1.0, 2.0]), ("3", ["3"], [1.0, 2.0])],
), ids=("all failed", "two", "texts", "constant quantities"))  # fmt: skip
def test_without_sensitivities(cases: list, tmp_path: Path) -> None:
    folder = write_batch(tmp_path, ["a"], cases)
    assert section(page(folder), "sensitivities").texts[0].startswith("Sensitivities need 3 cases") and page_of(folder).is_file()


def test_constant_quantity(tmp_path: Path) -> None:
    folder = write_batch(tmp_path, ["a"], [(str(i), [str(i)], [2.0 + 1e-16 * i, i]) for i in range(6)])
    assert section(page(folder), "sensitivities").texts[-1] == ("Quantities left out, since they have fewer than 3 values or do not vary: "
                                                                 "impulse of contact.")  # fmt: skip
    assert [axis["label"] for axis in page(folder).batch["axes"]] == ["a", "peak force (two-step mean) (N/m)"]
    assert section(page(folder), "sensitivities").charts[0].title == "Influence of the keys on peak force (two-step mean)"


def test_many_cases(tmp_path: Path) -> None:
    """The table shows a thousand."""
    folder = write_batch(tmp_path, ["a"], [(str(i), [str(i)], [i, -i] if i % 30 else "memory") for i in range(1003)])
    text = page_of(folder).read_text(encoding="utf-8")
    assert len(re.findall(r"<tr><td>\d+</td>", text.split('id="cases-table"')[1])) == 1000
    assert "1,000 of 1,003 cases are shown" in text and "the first 20 of 34; to see the others" in text


def test_shard_and_missing_cases(tmp_path: Path) -> None:
    made = page(write_batch(tmp_path, ["a"], [(str(i), [str(i)], [i, -i]) for i in range(4)], shard=[2, 3], cases=12))
    assert made.identity == "batch of block with 4 cases, shard 2/3" and ("Not here", "8 of the 12 cases of the table") in made.facts


# --- Damage -----------------------------------------------------------------------------------------------------------


def refused(folder: Path, *expected: str) -> None:
    """One sentence, and no page."""
    done = make(folder)
    assert done.returncode == 2 and done.stderr.startswith("report.py: ") and done.stderr.count("\n") == 1, done.stderr
    assert not done.stdout and all(part in done.stderr for part in expected), done.stderr
    assert not (folder / "report.html").exists()


def without(name: str) -> Callable[[str], str]:
    """Removes a member of batch.json."""
    return lambda text: json.dumps({key: entry for key, entry in json.loads(text).items() if key != name}) + "\n"


def changed(name: str, value: object) -> Callable[[str], str]:
    """Changes a member of batch.json."""
    return lambda text: json.dumps(json.loads(text) | {name: value}) + "\n"


DAMAGE = {
    "no outcome": ("cases.csv", lambda text: text.replace(",outcome,", ",outcom,"), "no column outcome at place 7"),
    "key": ("cases.csv", lambda text: text.replace("contact.friction", "contact.fiction", 1), "no column contact.friction at place 3"),
    "no quantity": ("cases.csv", lambda text: text.replace(",impulse,", ",impuls,", 1), "no column impulse"),
    "two quantities": ("cases.csv", lambda text: text.replace(",impulse,", ",peak_force,", 1), "no column impulse"),
    "more columns": ("cases.csv", lambda text: text.replace(",peak_force\n", ",peak_force,J\n", 1), "found the column J, which batch.json"),
    "word": ("cases.csv", lambda text: re.sub(r",200,[^,]*,", ",200,much,", text, count=1), "row 1 cannot be read (could not convert"),
    "outcome": ("cases.csv", lambda text: text.replace(",done,", ",doen,", 1), "row 1 cannot be read (the outcome is neither done nor"),
    "comma": ("cases.csv", lambda text: text.replace(",done,", ",,done,", 1), "row 1 cannot be read (13 cells below 12 column names)"),
    "quote": ("cases.csv", lambda text: text.replace('"soft, ""wet"" <b>&amp;"', '"soft, "wet" <b>&amp;', 1), "cases.csv: cannot be read"),
    "row": ("cases.csv", lambda text: text[: text.rindex("\n", 0, -1) + 1], "found 59 rows, but batch.json counts 60"),
    "outcomes": ("cases.csv", lambda text: text.replace(",failed,", ",done,", 1), "found 60 cases that are done, but batch.json counts 59"),
    "no rows": ("cases.csv", lambda text: text.split("\n")[0] + "\n", "found 0 rows"),
    "bytes": ("cases.csv", lambda text: text.replace("case 2", "case \udcff"), "cases.csv: cannot be read"),
    "list": ("batch.json", lambda text: "[]\n", "found no object"),
    "no scene": ("batch.json", without("scene"), "batch.json: there is no entry scene"),
    "no keys": ("batch.json", without("keys"), "batch.json: there is no entry keys"),
    "no unit": ("batch.json", lambda text: text.replace('"unit"', '"units"'), "batch.json: there is no entry unit"),
    "form": ("batch.json", changed("quantities", ["impulse", "peak_force"]), "does not have the form that a batch writes"),
    "seconds": ("batch.json", changed("seconds", "long"), "does not have the form that a batch writes"),
    "versions": ("batch.json", changed("versions", 3), "does not have the form that a batch writes"),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_damaged_file(name: str, linear: tuple[Path, np.ndarray, np.ndarray], tmp_path: Path) -> None:
    file, change, expected = DAMAGE[name]
    for one in ("cases.csv", "batch.json"):
        text = (linear[0] / one).read_text()
        (tmp_path / one).write_text(change(text) if one == file else text, errors="surrogateescape")
    assert (tmp_path / file).read_bytes() != (linear[0] / file).read_bytes(), "nothing was changed"
    with pytest.raises(Unreadable, match=re.escape(expected)) as problem:
        page(tmp_path)
    assert str(tmp_path / file) in str(problem.value) and "\n" not in str(problem.value)


def test_no_table(linear: tuple[Path, np.ndarray, np.ndarray], tmp_path: Path) -> None:
    (tmp_path / "batch.json").write_bytes((linear[0] / "batch.json").read_bytes())
    refused(tmp_path, "cases.csv: cannot be read")


@pytest.mark.parametrize("file", ("cases.csv", "batch.json"))
def test_cut_file(file: str, linear: tuple[Path, np.ndarray, np.ndarray], tmp_path: Path) -> None:
    """The readers notice a cut at any byte."""
    for one in ("cases.csv", "batch.json"):
        (tmp_path / one).write_bytes((linear[0] / one).read_bytes())
    whole = (tmp_path / file).read_bytes()
    for length in range(0, len(whole), 1 if len(whole) < 2000 else 7):
        (tmp_path / file).write_bytes(whole[:length])
        with pytest.raises(Unreadable, match=re.escape(file)) as problem:
            assert BatchFolder(tmp_path).cases and f"{length} of {len(whole)} bytes"
        assert "\n" not in str(problem.value)


def test_no_comparison(linear: tuple[Path, np.ndarray, np.ndarray]) -> None:
    done = make(linear[0], linear[0])
    assert done.returncode == 2 and "found a batch; give two runs" in done.stderr and done.stderr.count("\n") == 1


def test_folder_of_batches(linear: tuple[Path, np.ndarray, np.ndarray]) -> None:
    done = make(linear[0].parent)
    assert done.returncode == 2 and f"runs inside: {linear[0]}" in done.stderr and done.stderr.count("\n") == 1


def test_empty_cells_have_the_values_of_the_scene(tmp_path: Path) -> None:
    """They count in ranges and sensitivities."""
    a, b, _ = samples(12)
    cases = [(f"case {i}", ["" if i < 4 else f"{a[i]:.17g}", "[0, 1]" if i == 5 else ""], [a[i] if i >= 4 else 7.0, b[i]]) for i in range(12)]
    folder = write_batch(tmp_path / "batch", ["material.young", "initial.velocity"], cases)
    (folder / "scene.toml").write_text('[material]\nyoung = 7.0\n[initial]\nvelocity = ["0", "-1"]\n')
    batch = BatchFolder(folder)
    (young,) = batch.keys["material.young"]
    assert list(young.values) == [7.0] * 4 + list(a[4:])
    (velocity,) = batch.keys["initial.velocity"]
    assert velocity.name == "initial.velocity[1]" and sorted(set(velocity.values)) == [-1, 1]
