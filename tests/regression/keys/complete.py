# SPDX-License-Identifier: GPL-3.0-or-later
"""The program itself names the keys that it accepts; each of them has a test in this folder, a case of bad input, and a row in
docs/reference/keys.md, whose table is the program's."""

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from cases import all_cases
from harness import SIGNORINI, SOURCE, attempt, captured
from regression.keys.runs import BLOCK, COARSE, CORE, DATA, STIFF, Run, edited, get, optimize_in, simulate_in

EXACT = {"displacement": ["0", "0"], "pressure": "1", "impulse": 1, "peak_force": 1, "contact_start": 1, "contact_time": 1}
# Scenes in which every table and every optional key occurs.
WITH_MASS = {"mass": 1.0, "velocity": [0, 1], "components": ["y"], "inertia": 1.0, "mass_center": [0, 0], "force": ["0", "t"],
             "stiffness": 1.0, "damping": [1.0, 2.0]}  # fmt: skip
FULL = (
    (BLOCK, {
        "mesh__model": "plane-strain", "clamp": [{"on": "left", "components": ["x"], "value": ["0"]}],
        "load__traction": [{"on": "top", "value": ["0", "0"]}], "load__gravity": [0, 0],
        "load__point": [{"at": [1, 1], "value": [0, 0]}], "material__rayleigh": {"alpha": 0.1, "beta": 1e-3},
        "material__prony": [{"g": 0.3, "k": 0.1, "time": 0.1}],
        "foundation": [{"on": "top", "stiffness": {"normal": 1.0}, "damping": {"tangential": 1.0}}, {"on": "left", "absorbing": True}],
        "contact": [
            {"on": "bottom", "obstacle": {"shape": "half-space", "point": [0, -1], "normal": [0, 1]}},
            {"on": "bottom", "obstacle": {"shape": "ball", "center": [0, -2], "radius": 1}},
            {"on": "bottom", "obstacle": {"shape": "cylinder", "point": [0, -2], "radius": 1}},
            {"on": "bottom", "obstacle": {"shape": "signed-distance", "distance": "y + 1"}},
        ],
        "control__on": "body", "control__lower": -9, "control__upper": 9, "objective__on": "body", "check__control": ["0", "0"],
        "output__probe": [{"point": [0.5, 0.5]}, {"on": "top"}, {"obstacle": "obstacle 3"}, {"body": True}], "output__format": ["vtkhdf"],
    }),
    (BLOCK, {"initial": {"drop": {"height": 0.1}}, "load": {"gravity": [0, -1]},
             "output__probe": [{"body": True, "acceleration": True}, {"obstacle": "obstacle 1", "filter": {"cfc": 4.0}}]}),
    (BLOCK, {"contact__friction": "0.1 + x^2", "contact__obstacle__surface_velocity": ["1", "0"]}),
    (BLOCK, {"contact__friction": {"bound": "0.1 + x^2"}}),
    (BLOCK, {"objective__exponent": 4.0, "scenario": [{"weight": 0.5}, {"name": "fast", "set": {"initial.velocity": ["0", "-2"]}}]}),
    (DATA / "two-squares.toml", {"contact__slave": "on", "contact__height": 0.01}),
    *((BLOCK, {"contact__obstacle": shape | WITH_MASS, "objective__obstacle": "obstacle 1"}) for shape in (
        {"shape": "half-space", "point": [0, -1], "normal": [0, 1]}, {"shape": "ball", "center": [0, -2], "radius": 1},
        {"shape": "cylinder", "point": [0, -2], "radius": 1}, {"shape": "signed-distance", "distance": "y + 1"})),
    (BLOCK, {"time": {"end": 0.6, "step": "auto", "longest": 0.06, "shortest": 1e-3}, "control__step": 0.06}),
    (DATA / "two-materials.toml", {"objective__desired": {"displacement": ["0", "0"]}, "trajectory__storage": "checkpoints"}),
    (SOURCE / "scenes" / "hertz-press.toml", {"time__end": 0.05, "mesh__scale": 8, "exact": EXACT}),
    (CORE, COARSE | {
        "unknown": [STIFF | {"lower": 1e6, "upper": 1e9, "prior": {"mean": 2e7, "deviation": 1.0}},
                    {"of": "initial.velocity", "component": "y"}, {"of": "position", "obstacle": "floor"},
                    {"of": "prony.time", "on": "inclusion", "branch": 0}],
        "material__1__prony": [{"g": 0.3, "time": 1e-3}],
        "measurement": [{"of": "force", "component": "y", "obstacle": "floor", "file": "a.csv", "noise": 0.1},
                        {"of": "displacement", "point": [0, 0.1], "component": "y", "file": "b.csv", "deviation": 1.0},
                        {"of": "velocity", "on": "surface", "component": "x", "file": "b.csv", "deviation": 1.0},
                        {"of": "contact-time", "value": 0.01}],
    }),
    (DATA / "cube.toml", {"contact__obstacle": {"shape": "cylinder", "point": [0, 0, -2], "axis": [1, 0, 0], "radius": 1}}),
)  # fmt: skip


def leaves(node: object, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """The paths of a scene's values; the tables of a list by their numbers, changed keys of a scenario as one value."""
    for name, value in node.items() if isinstance(node, dict) else enumerate(node):
        here = (*path, str(name))
        if name != "set" and isinstance(value, dict) or (isinstance(value, list) and isinstance(value[0], dict)):
            yield from leaves(value, here)
        else:
            yield here


def without_numbers(path: tuple[str, ...]) -> str:
    return ".".join(name for name in path if not name.isdigit())


@pytest.fixture(scope="module")
def echoed(tmp_path_factory: pytest.TempPathFactory) -> list[Run]:
    folder = tmp_path_factory.mktemp("full")
    first = optimize_in(folder).folder
    by_runs = {"objective__desired": {"run": "somewhere"}, "control__initial": {"run": str(first)}}
    return [simulate_in(folder, scene, **overrides) for scene, overrides in (*FULL, (BLOCK, by_runs))]


@pytest.fixture(scope="module")
def accepted(echoed: list[Run]) -> set[str]:
    """The keys that scene.toml writes out."""
    return {without_numbers(path) for done in echoed for path in leaves(done.echo)}


def names_allowed(scene: Path, path: tuple[str, ...]) -> set[str]:
    """The keys that the program says it allows in a table of a scene."""
    refused = attempt("info", scene, **{"__".join((*path, "nonsense")): 1})
    assert refused.returncode == 2 and "nonsense: unknown key" in refused.stderr
    return {without_numbers((*path, name)) for name in refused.stderr.strip().rsplit("keys here: ")[1].split(", ")}


def test_echoed_keys_are_those_allowed(echoed: list[Run], accepted: set[str]) -> None:
    tables: dict[tuple[str, str], tuple[Path, tuple[str, ...]]] = {}  # each kind once, wherever it occurs
    for done in echoed:
        for path in leaves(done.echo):
            for n in range(len(path)):
                if not path[n].isdigit():
                    kind = without_numbers(path[:n]), get(done.echo, path[:n]).get("shape", "")
                    tables.setdefault(kind, (done.folder / "scene.toml", path[:n]))
    allowed = set().union(*(names_allowed(*place) for place in tables.values()))
    # A key that may be a table or a value is both.
    assert allowed - ({table for table, _ in tables} - accepted) == accepted


def test_each_key_has_a_test(accepted: set[str]) -> None:
    """Their names are those in the marks of this folder's tests."""
    tests = (node for file in Path(__file__).parent.glob("*.py") for node in ast.walk(ast.parse(file.read_text()))
             if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"))  # fmt: skip
    marks = (mark for test in tests for mark in test.decorator_list if ast.unparse(mark).startswith("pytest.mark.key("))
    assert {ast.literal_eval(name) for mark in marks for name in mark.args} == accepted


def test_each_key_has_a_bad_value(accepted: set[str]) -> None:
    """Messages of bad input name them, and not because a key is unknown or missing."""
    texts = (text for case in all_cases() for text in case.expect if isinstance(text, str))
    named = (re.match(r"([a-z_]+(?:(?:\[\d\])?\.[a-z_]+)+)(?:$|: (?!unknown|missing))", text) for text in texts)
    assert accepted - {re.sub(r"\[\d\]", "", match[1]) for match in named if match} == set()


@pytest.fixture(scope="module")
def markdown() -> str:
    return captured([str(SIGNORINI), "keys", "--markdown"]).stdout


@pytest.fixture(scope="module")
def rows(markdown: str) -> list[tuple[str, str, str]]:
    """Name, what can be chosen and default of each key in the table of the page."""
    return re.findall(r"(?m)^\| `([a-z_]+\.[a-z_.]+)` \| (.*?) \| (.*?) \| .* \|$", markdown)


@pytest.fixture(scope="module")
def default(tmp_path_factory: pytest.TempPathFactory) -> Run:
    folder = tmp_path_factory.mktemp("default")
    return simulate_in(folder, edited(folder / "default.toml", ("(max_iterations|alpha|gamma).*", "")), clamp=[{"on": "left"}],
                       foundation=[{"on": "top", "stiffness": {"tangential": 1.0}, "damping": {"tangential": 1.0}},
                                   {"on": "rest", "stiffness": {"normal": 1.0}, "damping": {"normal": 1.0}}], material__rayleigh={},
                       material__prony=[{"k": 0.1, "time": 1.0}, {"g": 0.1, "time": 1.0}], initial__velocity=["0", "0"],
                       contact__obstacle={"shape": "ball", "center": [0, -2], "radius": 1}, scenario=[{}],
                       measurement=[{"of": "force", "component": "y", "file": "none.csv"}], output__probe=[{"body": True}])  # fmt: skip


@pytest.fixture(scope="module")
def chosen(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A run of chosen steps, which has keys that others have not."""
    return simulate_in(tmp_path_factory.mktemp("chosen"), time={"end": 0.6, "step": "auto"})


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A run of two parts in contact, which has a key that others have not."""
    return simulate_in(tmp_path_factory.mktemp("parts"), DATA / "two-squares.toml", time__end=0.1)


def test_page_has_the_table_of_the_program(markdown: str) -> None:
    found = re.search(r"(?s)<!-- keys.*?-->\n(.*?)<!-- end of keys -->", (SOURCE / "docs" / "reference" / "keys.md").read_text())
    assert found and found[1] == markdown, "docs/extend.md says how to make it"


def test_page_has_each_key_once(rows: list[tuple[str, str, str]], accepted: set[str]) -> None:
    names = [name for name, _, _ in rows]
    assert set(names) == accepted and len(names) == len(accepted)


@pytest.mark.parametrize("steps", ("default", "chosen"))
def test_page_has_each_choice(steps: str, rows: list[tuple[str, str, str]], default: Run, chosen: Run) -> None:
    """The names that the program allows where it allows no others."""
    run = {"default": default, "chosen": chosen}[steps]
    values = {name: value for name, value, _ in rows}
    lists = 0
    for path in leaves(run.echo):
        if isinstance(get(run.echo, path), str):
            message = attempt("info", run.folder / "scene.toml", **{"__".join(path): "nonsense"}).stderr
            if match := re.search(r"choices: (.*)", message):
                lists, value = lists + 1, values.get(without_numbers(path), "")
                assert all(f'"{choice}"' in value for choice in match[1].split(", ")), without_numbers(path)
    assert lists > 5, "hardly any key has choices: the case says nothing"


def test_page_has_the_defaults(rows: list[tuple[str, str, str]], default: Run, chosen: Run, parts: Run) -> None:
    """The defaults are those that scene.toml confirms."""
    confirmed = 0
    for name, _, value in rows:
        if re.fullmatch("`[^`]*`", value):
            own = chosen if name in ("time.tolerance", "time.quantity") else parts if name == "contact.height" else default
            path = re.sub("^(clamp|measurement|scenario|foundation|material[.]prony|output[.]probe)", r"\1.0", name)
            # Each branch has a fraction: g has its default in the first branch, k in the second one. So have foundations.
            path = re.sub(r"foundation\.0(\.\w+\.tangential)", r"foundation.1\1", path.replace("prony.0.k", "prony.1.k"))
            echoed = get(own.echo, path.split("."))
            assert echoed == tomllib.loads(f"value = {value[1:-1]}")["value"], f"the table's default of {name} is {value}"
            confirmed += 1
    assert confirmed > 20
