# SPDX-License-Identifier: GPL-3.0-or-later
"""Page of a batch: ranges, failed cases, scatter plot, sensitivities, parallel coordinates and the table of all cases."""

import html
import math
from itertools import combinations

import numpy as np

from . import style
from .batch_folder import Axis, BatchFolder, Case, varies
from .files import Unreadable
from .report_parts import Chart, Page, Section, Shaded, Table, figure, packed, quantity, whole
from .sensitivity import LEAST, Sensitivity, by_chance, correlation, sensitivity

MOST_ROWS = 1000  # of the table of all cases
MOST_FAILED = 20  # rows of the table of failed cases
MOST_NAMES = 5
MOST_BARS = 15
LINEAR = 0.5  # R² below which a linear fit does not explain a quantity
TOGETHER = 0.9  # modulus of the correlation of two keys whose coefficients are hardly separable

Rated = tuple[Axis, Sensitivity]


def page(batch: BatchFolder) -> Page:
    """Makes the page. Raises Unreadable if batch.json or cases.csv is not as a batch writes it."""
    try:
        given, count = batch.manifest, len(batch.cases)
        part = f", shard {'/'.join(map(str, given['shard']))}" if given["shard"] else ""
        identity = f"batch of {given['scene']} with {whole(count)} {plural('case', count)}{part}"
        axes = [*(axis for axes in batch.keys.values() for axis in axes), *(axis for axis in batch.quantities if axis.varies)]
        sections = [Section("summary", "Summary", tables=[*reasons(batch), ranges(batch)]),
                    *([Section("scatter", "Scatter plot", panel="scatter", tables=failures(batch))] if len(axes) > 1 else []),
                    sensitivities(batch),
                    *([Section("parallel", "Parallel coordinates", panel="parallel")] if len(axes) > 1 and count > 1 else []),
                    Section("cases", "All cases", panel="cases")]  # fmt: skip
        return Page(str(given["scene"]), "batch", identity, facts(batch), sections, [], batch=data(batch, axes))
    except KeyError as error:
        raise Unreadable(f"{batch.path / 'batch.json'}: there is no entry {error.args[0]}") from None
    except (TypeError, AttributeError, ValueError) as error:
        raise Unreadable(f"{batch.path / 'batch.json'}: does not have the form that a batch writes ({error})") from None


def facts(batch: BatchFolder) -> list[tuple[str, str]]:
    given, count = batch.manifest, len(batch.cases)
    found = [("Cases", f"{whole(count)}: {whole(given['done'])} done, {whole(given['failed'])} failed")]
    if given["cases"] > count:
        found.append(("Not here", f"{whole(given['cases'] - count)} of the {whole(given['cases'])} cases of the table"))
    found.append(("Keys", ", ".join(map(str, given["keys"])) or "none"))
    if given["seconds"] is not None:
        found.append(("Seconds in all", quantity(given["seconds"], "s")))
    found += [("Warning", f"{one['message']} ({whole(one['cases'])} of {whole(count)} cases, first {one['case']})") for one in given["warnings"]]
    return [*found, ("Versions", ", ".join(f"{name} {version}" for name, version in given["versions"].items()))]


def plural(noun: str, count: int) -> str:
    return noun if count == 1 else f"{noun}s"


def some(names: list[str]) -> str:
    """Lists the first names."""
    return ", ".join(names[:MOST_NAMES]) + (f" and {whole(len(names) - MOST_NAMES)} more" if len(names) > MOST_NAMES else "")


def shown(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.6g}"


def reasons(batch: BatchFolder) -> list[Table]:
    """Makes a table of the failed cases by their reason, most frequent first."""
    found: dict[str, list[str]] = {}
    for case in batch.cases:
        if not case.done:
            found.setdefault(case.reason or "no reason given", []).append(case.name)
    rows = [[reason, whole(len(names)), some(names)] for reason, names in sorted(found.items(), key=lambda item: -len(item[1]))]
    return [Table("Cases that failed, by their reason", ["Reason", "Cases", "Which"], rows)] if rows else []


def ranges(batch: BatchFolder) -> Table:
    """Makes a table of the ranges of keys over all cases, and of quantities over those that are done."""
    rows = []
    for key, axes in batch.keys.items():
        rows += [texts_of(axis) if axis.words else [axis.label, *extent(axis.values)] for axis in axes] or [same(batch, key)]
    rows += [[axis.label, *extent(np.where(batch.done, axis.values, np.nan))] for axis in batch.quantities]
    return Table("Ranges: of keys over all cases, of quantities over the cases that are done",
                 ["Key or quantity", "Least", "Median", "Largest", "Cases"], rows)  # fmt: skip


def extent(values: np.ndarray) -> list[str]:
    found = values[np.isfinite(values)]
    return [*map(shown, (found.min(), np.median(found), found.max()) if len(found) else (math.nan,) * 3), whole(len(found))]


def texts_of(axis: Axis) -> list[str]:
    """Returns the row of a key of texts."""
    return [f"{axis.name}: {some(list(axis.words))}", "", "", "", whole(int(np.isfinite(axis.values).sum()))]


def same(batch: BatchFolder, key: str) -> list[str]:
    """Returns the row of a key with one value."""
    place = batch.manifest["keys"].index(key)
    cells = [case.keys[place] for case in batch.cases if case.keys[place]]
    return [f"{key}: {cells[0]} in all" if cells else f"{key}: no value", "", "", "", whole(len(cells))]


def failures(batch: BatchFolder) -> list[Table]:
    """Makes a table of the failed cases, with the keys that vary."""
    failed = [case for case in batch.cases if not case.done]
    places = [place for place, axes in enumerate(batch.keys.values()) if axes]
    rows = [[case.name, *(case.keys[place] for place in places), case.reason] for case in failed[:MOST_FAILED]]
    more = f", the first {MOST_FAILED} of {whole(len(failed))}; to see the others, sort the table of all cases by outcome"
    title = f"Cases that failed{more if len(failed) > MOST_FAILED else ''}"
    return [Table(title, ["Case", *(list(batch.keys)[place] for place in places), "Reason"], rows)] if rows else []


# --- Sensitivities ----------------------------------------------------------------------------------------------------


def sensitivities(batch: BatchFolder) -> Section:
    """Makes the part about sensitivities: a chart and two tables, or a sentence that says why there are none."""
    done = np.flatnonzero(batch.done)
    keys = [axis for axes in batch.keys.values() for axis in axes if not axis.words and varies(axis.values[done])]
    values = np.array([key.values[done] for key in keys]).reshape(len(keys), len(done)).T
    found = [(axis, sensitivity(values, axis.values[done])) for axis in batch.quantities]
    rated = [(axis, one) for axis, one in found if np.isfinite(one.ranks).any()]
    sentences = left_out(batch, keys)
    if not rated:
        why = (f"Sensitivities need {LEAST} cases or more that are done and differ in a numeric key and in a quantity; "
               f"{whole(len(done))} of {whole(len(batch.cases))} cases {'is' if len(done) == 1 else 'are'} done.")  # fmt: skip
        return Section("sensitivities", "Sensitivities", texts=[why, *sentences], always=True)
    if unrated := [axis.title for axis, one in found if not np.isfinite(one.ranks).any()]:
        sentences.append(f"Quantities left out, since they have fewer than {LEAST} values or do not vary: {', '.join(unrated)}.")
    return Section("sensitivities", "Sensitivities", texts=[*explanations(keys, rated, values), *sentences],
                   charts=[influences(keys, rated)], tables=[correlations(keys, rated), *coefficients(keys, rated)])  # fmt: skip


def left_out(batch: BatchFolder, used: list[Axis]) -> list[str]:
    """Returns sentences on the keys that have no sensitivities."""
    texts = [axis.name for axes in batch.keys.values() for axis in axes if axis.words]
    constant = [name for key, axes in batch.keys.items() for name in ([axis.name for axis in axes] or [key])
                if name not in [*texts, *(axis.name for axis in used)]]  # fmt: skip
    reasons = (("are not numeric", texts), ("do not vary in the cases that are done", constant))
    return [f"Keys left out, since they {why}: {', '.join(names)}." for why, names in reasons if names]


def explanations(keys: list[Axis], rated: list[Rated], values: np.ndarray) -> list[str]:
    """Returns sentences on how far the numbers can be trusted."""
    least, most = (extreme(one.cases for _, one in rated) for extreme in (min, max))
    limit = by_chance(least)
    chance = f"95 % of rank correlations of {whole(least)} independent pairs lie within ±{limit:.2f}"
    chance = chance if limit < 1 else "too few to exclude chance"
    sentences = [f"The numbers are from {whole(least)}{f' to {whole(most)}' if most > least else ''} cases that are done; {chance}."]
    weak = [axis.title for axis, one in rated if one.explained < LINEAR]
    if weak:
        sentences.append(f"A linear fit explains less than half of the variance of {', '.join(weak)}: use the scatter plot.")
    if any(math.isnan(one.explained) for _, one in rated):
        sentences.append("No coefficients where cases are fewer than keys plus two, or where keys depend linearly on each other.")
    return [*sentences, *joint(keys, values)]


def joint(keys: list[Axis], values: np.ndarray) -> list[str]:
    """Returns sentences on pairs of keys that vary together, strongest first. `values`: cases × keys."""
    values = values[np.isfinite(values).all(axis=1)]
    varied = [i for i in range(len(keys)) if varies(values[:, i])]
    pairs = [(correlation(values[:, i], values[:, j]), keys[i].name, keys[j].name) for i, j in combinations(varied, 2)]
    pairs = sorted((pair for pair in pairs if abs(pair[0]) > TOGETHER), key=lambda pair: -abs(pair[0]))
    return [f"{first} and {second} vary together (correlation {r:+.3f}): the cases hardly separate their effects."
            for r, first, second in pairs[:MOST_NAMES]]  # fmt: skip


def influences(keys: list[Axis], rated: list[Rated]) -> Chart:
    """Makes the bar chart of both measures, a view for each quantity, strongest keys first."""
    views = {}
    for axis, one in rated:
        order = np.argsort(-np.nan_to_num(np.abs(one.ranks)), kind="stable")[:MOST_BARS]
        order = [i for i in order if np.isfinite(one.ranks[i])]
        names = [html.escape(keys[i].name, quote=False) for i in order]
        bars = [bar("rank correlation (Spearman)", names, one.ranks[order], style.BLUE)]
        fit = ""
        if math.isfinite(one.explained):
            bars.append(bar("standardised regression coefficient", names, one.coefficients[order], style.ORANGE))
            fit = f", linear fit R² = {one.explained:.2f}"
        largest = np.nanmax(np.abs([one.ranks[order], one.coefficients[order]]))
        title, end = f"{whole(one.cases)} cases{fit}", 1.05 * max(1, largest)
        across = {"range": [-end, end], "zeroline": True, "zerolinecolor": "#98a2ab"}
        view = figure(bars, title, "", xaxis=across, yaxis={"type": "category", "autorange": "reversed", "ticks": ""})
        views[axis.name if axis.title in views else axis.title] = view
    return Chart("influence", "Influence of the keys" + (f" on {rated[0][0].title}" if len(rated) == 1 else ""), views,
                 "±1: the quantity depends on this key alone, rising (+) or falling (−) throughout. Rank correlations need no linear "
                 "dependence; coefficients separate keys that vary together.")  # fmt: skip


def bar(name: str, names: list[str], values: np.ndarray, colour: str) -> dict:
    """Makes a trace of horizontal bars."""
    return {"type": "bar", "orientation": "h", "name": name, "x": packed(values), "y": names, "marker": {"color": colour},
            "hovertemplate": "%{y}: %{x:.3f}<extra></extra>"}  # fmt: skip


def correlations(keys: list[Axis], rated: list[Rated]) -> Table:
    rows = [[axis.title, *map(shaded, one.ranks), whole(one.cases)] for axis, one in rated]
    return Table("Rank correlations (Spearman) of quantities with keys", ["", *(key.name for key in keys), "Cases"], rows)


def coefficients(keys: list[Axis], rated: list[Rated]) -> list[Table]:
    rows = [[axis.title, *map(shaded, one.coefficients), share(one.explained), share(one.predicted)] for axis, one in rated
            if math.isfinite(one.explained)]  # fmt: skip
    title = ("Standardised coefficients of a linear fit by all keys: change of a quantity in its standard deviations as the key changes by "
             "its own. R²: share of the variance that the fit explains; predicted: the same for cases that are left out of the fit")
    return [Table(title, ["", *(key.name for key in keys), "R²", "R² predicted"], rows)] if rows else []


def shaded(value: float) -> Shaded | str:
    return "–" if math.isnan(value) else Shaded(f"{round(value, 2) + 0.0:+.2f}", value)  # not -0.00


def share(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.3f}"


# --- Data of the page's script ----------------------------------------------------------------------------------------


def data(batch: BatchFolder, axes: list[Axis]) -> dict:
    """Returns the axes that vary, names and outcomes of the cases, and the texts of the table of all cases."""
    keys = sum(len(axes) for axes in batch.keys.values())
    return {
        "axes": [{"label": axis.label, "key": i < keys, "values": plain(axis.values), "words": axis.words, "log": axis.logarithmic}
                 for i, axis in enumerate(axes)],
        "keys": keys,
        "names": [case.name for case in batch.cases],
        "done": [case.done for case in batch.cases],
        "most": MOST_ROWS,
        "head": head(batch),
        "rows": [row(batch, i, case) for i, case in enumerate(batch.cases)],
        "total": whole(len(batch.cases)),
    }  # fmt: skip


def plain(values: np.ndarray) -> list[float | None]:
    """Returns numbers as JSON has them, with None for NaN; nine digits are more than a screen resolves."""
    return [None if math.isnan(value) else float(f"{value:.9g}") for value in values]


def head(batch: BatchFolder) -> list[str]:
    return ["Case", *map(str, batch.keys), "Outcome", "Reason", "Warnings", "Steps", *(axis.label for axis in batch.quantities)]


def row(batch: BatchFolder, number: int, case: Case) -> list[str]:
    steps = "" if math.isnan(case.steps) else f"{case.steps:.0f}"
    return [case.name, *case.keys, "done" if case.done else "failed", case.reason, case.warnings, steps,
            *(shown(axis.values[number]) for axis in batch.quantities)]  # fmt: skip
