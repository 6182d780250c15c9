# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/reference/files.md has the columns of every table, the members of every JSON file, and the datasets of every field
file that runs write, all of them and no others; every scene has a picture; the README is short; CONTRIBUTING.md names what there is.

That docs/reference/keys.md has every key is asserted by the tests of keys.
"""

import csv
import functools
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import pytest
from harness import SIGNORINI, SOURCE, captured

SCENES = SOURCE / "scenes"
# Written by runs that would take long here, such as a certified kink.
SELDOM = {"kink.shortest_combination", "kink.radius", "kink.gradients", "kink.weak_contact[].<member>",
          "<obstacle>/displacement", "<obstacle>/first_point", "<obstacle>/first_facet"}  # of obstacles that move
# What a name in brackets stands for where it is a column's whole name, in the runs below.
ALONE = {"<unknown>": "young|speed", "<quantity>": "J|impulse", "<key>": "contact.obstacle.point"}
PAGE = (SOURCE / "docs" / "reference" / "files.md").read_text()
CONTRIBUTING = (SOURCE / "CONTRIBUTING.md").read_text()


def documented() -> dict[str, list[str]]:
    """The tables of the page, as their rows, by the file that the section is about."""
    found: dict[str, list[str]] = {}
    for title, section in re.findall(r"(?ms)^## (.*?)\n(.*?)(?=^## |\Z)", PAGE):
        name = re.search(r"`([\w.]+)`", title)
        if name:
            found[name[1]] = re.findall(r"(?m)^\| (?:column|member|dataset) \| unit \| definition \|\n\|---\|---\|---\|\n((?:\|.*\n)+)", section)
    return found


# The names in the first columns of these tables.
KNOWN = {name: [re.findall(r"(?m)^\| `(.+?)` \|", rows) for rows in tables] for name, tables in documented().items()}


def pattern(name: str) -> re.Pattern:
    """The names that a documented one stands for."""
    if name in ALONE:
        return re.compile(ALONE[name])
    parts = re.split(r"<\w+>", name)
    return re.compile(".+".join(map(re.escape, parts)))


def sets(**keys: object) -> list[str]:
    return [word for key, value in keys.items() for word in ("--set", f"{key.replace('__', '.')}={value}")]


def probes(group: str, point: str, obstacle: str = "obstacle 1") -> list[str]:
    every = [f'{{name="point", point={point}}}', f'{{name="group", on="{group}"}}', f'{{name="obstacle", obstacle="{obstacle}"}}',
             '{name="body", body=true}']  # fmt: skip
    return sets(output__probe=f"[{', '.join(every)}]")


EVERY = '"displacement","velocity","strain","stress","von_mises","pressure"'
FIELDS = sets(output__fields=f"[{EVERY}]", output__every=50)
BLOCK, DISC, BALL = (SCENES / f"{name}.toml" for name in ("block", "half-disc", "half-ball"))
SHORT = sets(mesh__size=4, time__step=2.5e-4)
RUNS = {
    "measured": ("simulate", "joint.toml", "--measure"),
    "block": ("simulate", BLOCK, *FIELDS),
    "supported": ("simulate", BLOCK, *sets(material__rayleigh="{alpha=1.0}", material__prony="[{g=0.3, k=0.1, time=0.05}]",
                                           foundation='[{on="top", damping={normal=1.0}}]')),  # fmt: skip
    "disc": ("simulate", DISC, *SHORT, *FIELDS, *probes("top", "[0, -5]")),
    "ball": ("simulate", BALL, *SHORT, *FIELDS, *probes("top", "[0, 0, -5]")),
    "rough": ("simulate", BALL, *SHORT, *sets(contact__friction=0.3, output__fields=f'[{EVERY},"friction"]', output__every=50)),
    "plate": ("simulate", BLOCK, *sets(contact__obstacle__mass=1.0, contact__obstacle__inertia=1.0,
                                       output__probe='[{name="plate", obstacle="obstacle 1", acceleration=true, filter={cfc=4}}]')),  # fmt: skip
    "plate-in-space": ("simulate", BALL, *SHORT, *sets(contact__obstacle__mass=1e3, contact__obstacle__inertia="[1e5, 1e5, 1e5]",
                                                       output__probe='[{name="plate", obstacle="obstacle 1"}]')),  # fmt: skip
    "parts": ("simulate", SOURCE / "tests" / "data" / "two-cubes.toml", *FIELDS),
    "chosen": ("simulate", DISC, *sets(mesh__size=4, time__step="auto", time__tolerance=1e-1)),
    "optimum": ("optimize", DISC, *SHORT, *sets(optimizer__max_iterations=4)),
    "space": ("optimize", BALL, *SHORT, *sets(optimizer__max_iterations=2)),
    "any": ("optimize", SCENES / "catch-any.toml", *sets(optimizer__max_iterations=2)),
    "fit": ("optimize", SCENES / "bar-speed.toml"),
    "joint": ("optimize", "joint.toml"),
    "ordered": ("optimize", DISC, "--accuracy", "0.2", *sets(mesh__size=1)),
    "ordered-ball": ("optimize", BALL, "--accuracy", "0.5", *sets(time__step=5e-4)),
    "cases": ("batch", DISC, "--cases", SOURCE / "tests" / "data" / "heights.csv", "--quantity", "J,impulse", *SHORT,
              *sets(output__probe='[{name="tip", point=[0, -5], acceleration=true}]')),  # fmt: skip
    "study": ("study", DISC, "--sizes", "8,4", "--steps", "5e-4", "--quantity", "J,impulse", "--search-tolerances", "0.5"),
}
Ran = Callable[[str], Path]


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    """Gives the folder of one of the RUNS."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "joint.toml").write_text(
        re.sub('file = "', f'file = "{SCENES}/', BLOCK.read_text()) + '[optimizer]\nmax_iterations = 2\n[[unknown]]\nof = "young"\nstart = 900.0\n'
        '[[measurement]]\nof = "displacement"\ncomponent = "y"\npoint = [0.5, 1]\nfile = "top.csv"\nnoise = 0.1\n')  # fmt: skip

    @functools.cache
    def run(name: str) -> Path:
        if name == "joint":
            run("measured")
        verb, scene, *options = RUNS[name]
        done = captured([str(SIGNORINI), verb, str(folder / scene), "--out", str(folder / name), "--quiet", *options])
        assert done.returncode == 0, f"{done.args} ended with {done.returncode}:\n{done.stdout}{done.stderr}"
        return folder / name

    return run


def header(file: Path) -> list[str]:
    with open(file) as lines:
        return next(csv.reader(lines))


def columns(file: Path) -> dict[str, list[str]]:
    """The documented columns that each of a table's may be: itself where it is one."""
    known = [column for table in KNOWN[file.name] for column in table]
    return {column: [column] if column in known else [one for one in known if pattern(one).fullmatch(column)] for column in header(file)}


def paths(value: object, path: str = "") -> set[str]:
    """The members of a file, with dots between those inside of one another and [] behind lists."""
    if isinstance(value, dict):
        return set().union(*(paths(one, f"{path}.{key}" if path else key) for key, one in value.items()), set())
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return set().union(*(paths(one, path + "[]") for one in value))
    return {path}


def datasets(file: Path) -> set[str]:
    found: set[str] = set()
    with h5py.File(file) as data:
        # VTK documents the group VTKHDF.
        data.visititems(lambda name, one: found.add(name) if isinstance(one, h5py.Dataset) and not name.startswith("VTKHDF/") else None)
    return found


def members(out: Path) -> Iterator[tuple[Path, str, set[str]]]:
    """Files of a run with members or datasets, the sections that they are in, and their names."""
    for file in sorted([*out.glob("*.json"), *out.glob("*.h5")]):
        if file.name in ("run.json", "study.json", "batch.json"):
            found = json.loads(file.read_text())
            yield file, file.name, paths(found) if file.name == "run.json" else set(found)
        elif file.suffix == ".h5" and file.name != "checkpoint.h5":
            yield file, "surfaces.h5" if file.name == "surfaces.h5" else "state", datasets(file)


def fitting(section: str, member: str) -> list[str]:
    """The documented names that a member may be."""
    return [one for one in KNOWN[section][0] if pattern(one).fullmatch(member) or f"{one}[]" == member.split(".")[0]
            or re.fullmatch(re.escape(one.split("[]")[0]), member)]  # an empty list  # fmt: skip


@pytest.mark.parametrize("name", RUNS)
def test_tables(name: str, ran: Ran) -> None:
    """A header is one of the documented tables, some columns left out, in their order."""
    for file in sorted(ran(name).glob("*.csv")):
        assert file.name in KNOWN, f"{file.name} is not documented"
        unknown = [column for column, found in columns(file).items() if not found]
        assert not unknown, f"columns of {file.name} are not documented"
        plain = {column for table in KNOWN[file.name] for column in table if "<" not in column}
        order = [column for column in header(file) if column in plain]
        assert any(order == [column for column in table if column in order] for table in KNOWN[file.name]), f"order of columns of {file.name}"


@pytest.mark.parametrize("name", RUNS)
def test_members_and_datasets(name: str, ran: Ran) -> None:
    for file, section, found in members(ran(name)):
        whole = {one.split(".")[0] for one in KNOWN[section][0]}
        unknown = [member for member in sorted(found) if not fitting(section, member) and member not in whole]
        assert not unknown, f"members of {file.name} are not documented"


@pytest.mark.parametrize("name", RUNS)
def test_files(name: str, ran: Ran) -> None:
    listed = PAGE.split("## `steps.csv`")[0]
    unknown = [file.name for file in ran(name).iterdir() if file.name not in ("joint", "rungs") and f"`{file.name}" not in listed]
    assert not unknown, "files are not documented"


@pytest.mark.parametrize("section", [section for section, tables in KNOWN.items() if tables])
def test_all_are_written(section: str, ran: Ran) -> None:
    """Every documented column, member and dataset is in a run."""
    seen: set[str] = set()
    for name in RUNS:
        if section.endswith(".csv") and (ran(name) / section).exists():
            seen.update(*columns(ran(name) / section).values())
        seen.update(one for _, of, found in members(ran(name)) if of == section for member in found for one in fitting(section, member))
    tables = KNOWN[section] if section != "state" else KNOWN[section][:1]
    print(f"{len(seen)} columns, members or datasets of {section} are in runs")
    assert sorted({one for table in tables for one in table} - SELDOM - seen) == []


def test_no_cell_is_empty() -> None:
    rows = [row for tables in documented().values() for row in re.findall(r"(?m)^\| `.*$", "".join(tables))]
    assert rows and not [row for row in rows if any(not cell.strip() for cell in row.strip("|").split(" | "))]


@pytest.mark.parametrize("scene", sorted(SCENES.glob("*.toml")), ids=lambda scene: scene.stem)
def test_picture(scene: Path) -> None:
    picture = SOURCE / "docs" / "pictures" / f"{scene.stem}.png"
    assert picture.is_file() and picture.stat().st_size <= 60_000
    assert f"pictures/{scene.stem}.png" in (SOURCE / "docs" / "scenes.md").read_text()


def test_first_pages_are_short() -> None:
    assert len((SOURCE / "README.md").read_text().splitlines()) <= 110
    assert CONTRIBUTING.count("\n") <= 90, "what is not for the first hour goes to docs/extend.md"


def test_contributing_names_what_there_is() -> None:
    """Every class with a member that CONTRIBUTING.md or docs/extend.md names is in the sources, and every file."""
    text = CONTRIBUTING + (SOURCE / "docs" / "extend.md").read_text()
    headers = [file.read_text() for file in (SOURCE / "cpp").rglob("*.h")]
    names = re.findall(r"`(\w+)::(\w+)\(", text)
    files = re.findall(r"\b((?:\w+/)+[\w-]+\.(?:cpp|h|py|txt))\b", text)
    assert len(names) >= 10 and len(files) >= 20, "hardly any was found"
    missing = [f"{of}::{member}()" for of, member in names
               if not any(re.search(rf"\b(class|struct|namespace) (signorini::)?{of}\b", header) and re.search(rf"\b{member}\(", header)
                          for header in headers)]  # fmt: skip
    assert not missing
    assert not [file for file in files if not any((SOURCE / folder / file).is_file() for folder in ("", "cpp"))]
