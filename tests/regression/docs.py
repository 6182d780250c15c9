# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/reference/files.md has the columns of every table, the members of run.json and study.json, and the datasets of every field
file that runs write, all of them and no others; every scene has a picture; the README is short.

    docs.py SIGNORINI SOURCE

That docs/reference/keys.md has every key is held by keys.py.
"""

import csv
import json
import re
import tempfile
from pathlib import Path

import h5py

import sys

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from harness import SIGNORINI, SOURCE, captured  # noqa: E402

SCENES = SOURCE / "scenes"
# Written by runs that would take long here, such as a certified kink.
SELDOM = {"kink.shortest_combination", "kink.radius", "kink.gradients", "kink.weak_contact[].<member>",
          "<obstacle>/displacement", "<obstacle>/first_point", "<obstacle>/first_facet"}  # of obstacles that move
# What a name in brackets stands for where it is a column's whole name, in the runs below.
ALONE = {"<unknown>": "young|speed", "<quantity>": "J|impulse"}
failures = 0


def fail(message: str) -> None:
    global failures
    failures += 1
    print(f"FAIL  {message}", flush=True)


def documented() -> dict[str, list[list[str]]]:
    """The names in the first columns of the page's tables, by the file that the section is about."""
    text = (SOURCE / "docs" / "reference" / "files.md").read_text()
    found: dict[str, list[list[str]]] = {}
    for title, section in re.findall(r"(?ms)^## (.*?)\n(.*?)(?=^## |\Z)", text):
        name = re.search(r"`([\w.]+)`", title)
        if name:
            tables = re.findall(r"(?m)^\| (?:column|member|dataset) \| unit \| definition \|\n\|---\|---\|---\|\n((?:\|.*\n)+)", section)
            found[name[1]] = [re.findall(r"(?m)^\| `(.+?)` \|", rows) for rows in tables]
            for row in re.findall(r"(?m)^\| `.*$", "".join(tables)):
                if any(not cell.strip() for cell in row.strip("|").split(" | ")):
                    fail(f"{name[1]}: a cell is empty in {row}")
    return found


def pattern(name: str) -> re.Pattern:
    """The names that a documented one stands for."""
    if name in ALONE:
        return re.compile(ALONE[name])
    parts = re.split(r"<\w+>", name)
    return re.compile(".+".join(map(re.escape, parts)))


def run(verb: str, scene: Path | str, out: Path, *options: str) -> Path:
    done = captured([str(SIGNORINI), verb, str(scene), "--out", str(out), "--quiet", *options])
    if done.returncode:
        raise SystemExit(f"{verb} {scene} {options} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return out


def sets(**keys: object) -> list[str]:
    return [word for key, value in keys.items() for word in ("--set", f"{key.replace('__', '.')}={value}")]


def probes(group: str, point: str, obstacle: str = "obstacle 1") -> list[str]:
    every = [f'{{name="point", point={point}}}', f'{{name="group", on="{group}"}}', f'{{name="obstacle", obstacle="{obstacle}"}}',
             '{name="body", body=true}']  # fmt: skip
    return sets(output__probe=f"[{', '.join(every)}]")


def runs(folder: Path) -> list[Path]:
    fields = sets(output__fields='["displacement","velocity","strain","stress","von_mises","pressure"]', output__every=50)
    block, disc, ball = (SCENES / f"{name}.toml" for name in ("block", "half-disc", "half-ball"))
    short = sets(mesh__size=4, time__step=2.5e-4)
    joint = folder / "joint.toml"
    joint.write_text(re.sub('file = "', f'file = "{SCENES}/', block.read_text()) + '[optimizer]\nmax_iterations = 2\n'
                     '[[unknown]]\nof = "young"\nstart = 900.0\n'
                     '[[measurement]]\nof = "displacement"\ncomponent = "y"\npoint = [0.5, 1]\nfile = "top.csv"\nnoise = 0.1\n')  # fmt: skip
    run("simulate", joint, folder / "measured", "--measure")
    return [
        folder / "measured",
        run("simulate", block, folder / "block", *fields),
        run("simulate", disc, folder / "disc", *short, *fields, *probes("top", "[0, -5]")),
        run("simulate", ball, folder / "ball", *short, *fields, *probes("top", "[0, 0, -5]")),
        run("simulate", disc, folder / "chosen", *sets(mesh__size=4, time__step="auto", time__tolerance=1e-1)),
        run("optimize", disc, folder / "optimum", *short, *sets(optimizer__max_iterations=4)),
        run("optimize", ball, folder / "space", *short, *sets(optimizer__max_iterations=2)),
        run("optimize", SCENES / "bar-speed.toml", folder / "fit"),
        run("optimize", joint, folder / "joint"),
        run("optimize", disc, folder / "ordered", "--accuracy", "0.2", *sets(mesh__size=1)),
        run("optimize", ball, folder / "ordered-ball", "--accuracy", "0.5", *sets(time__step=5e-4)),
        run("study", disc, folder / "study", "--sizes", "8,4", "--steps", "5e-4", "--quantity", "J,impulse", "--search-tolerances", "0.5"),
    ]


def check_table(name: str, tables: list[list[str]], header: list[str], where: Path, seen: set[str]) -> None:
    """A header is one of the documented tables, some columns left out, in their order."""
    names = [(column, pattern(column)) for table in tables for column in table]
    for column in header:
        found = [known for known, shape in names if known == column] or [known for known, shape in names if shape.fullmatch(column)]
        if not found:
            fail(f"{where.name}/{name} has the column {column}, which is not documented")
        seen.update(found)
    plain = [column for table in tables for column in table if "<" not in column]
    order = [column for column in header if column in plain]
    if not any(order == [column for column in table if column in order] for table in tables):
        fail(f"{where.name}/{name} has its columns in another order than the documentation: {', '.join(header)}")


def members(value: object, path: str = "") -> set[str]:
    if isinstance(value, dict):
        return set().union(*(members(one, f"{path}.{key}" if path else key) for key, one in value.items()), set())
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return set().union(*(members(one, path + "[]") for one in value))
    return {path}


def check_members(name: str, known: list[str], found: set[str], where: Path, seen: set[str]) -> None:
    for member in sorted(found):
        fitting = [one for one in known if pattern(one).fullmatch(member) or f"{one}[]" == member.split(".")[0]
                   or re.fullmatch(rf"{re.escape(one.split('[]')[0])}", member)]  # an empty list  # fmt: skip
        if not fitting and not any(member == one.split(".")[0] for one in known):
            fail(f"{where.name}/{name} has {member}, which is not documented")
        seen.update(fitting)


def datasets(file: Path) -> set[str]:
    found: set[str] = set()
    with h5py.File(file) as data:
        data.visititems(lambda name, one: found.add(name) if isinstance(one, h5py.Dataset) else None)
    return found


def check_contributing() -> None:
    """Every class with a member that CONTRIBUTING.md or docs/extend.md names is in the sources, and every file."""
    text = "".join((SOURCE / name).read_text() for name in ("CONTRIBUTING.md", "docs/extend.md"))
    if (lines := (SOURCE / "CONTRIBUTING.md").read_text().count("\n")) > 90:
        fail(f"CONTRIBUTING.md has {lines} lines: what is not for the first hour goes to docs/extend.md")
    headers = {file: file.read_text() for file in (SOURCE / "cpp").rglob("*.h")}
    names = re.findall(r"`(\w+)::(\w+)\(", text)
    for of, member in names:
        declared = rf"\b(class|struct|namespace) (signorini::)?{of}\b"
        if not any(re.search(declared, header) and re.search(rf"\b{member}\(", header) for header in headers.values()):
            fail(f"CONTRIBUTING.md: {of}::{member}() is not in the sources")
    files = re.findall(r"\b((?:\w+/)+[\w-]+\.(?:cpp|h|py|txt))\b", text)
    for file in files:
        if not any((SOURCE / folder / file).is_file() for folder in ("", "cpp")):
            fail(f"CONTRIBUTING.md: there is no file {file}")
    if len(names) < 10 or len(files) < 20:
        fail(f"CONTRIBUTING.md: found {len(names)} members and {len(files)} files only")


def main() -> int:
    check_contributing()
    known = documented()
    seen: dict[str, set[str]] = {name: set() for name in known}
    fields = known.pop("state")[0]
    with tempfile.TemporaryDirectory() as scratch:
        for out in runs(Path(scratch)):
            for file in sorted(out.glob("*.csv")):
                if file.name not in known:
                    fail(f"{out.name}/{file.name} is not documented")
                    continue
                with open(file) as lines:
                    check_table(file.name, known[file.name], next(csv.reader(lines)), out, seen[file.name])
            for name in ("run.json", "study.json"):
                if (out / name).is_file():
                    found = json.loads((out / name).read_text())
                    of = set(found) if name == "study.json" else members(found)
                    check_members(name, known[name][0], of, out, seen[name])
            for file in sorted(out.glob("*.h5")):
                if file.name == "surfaces.h5":
                    check_members(file.name, known[file.name][0], datasets(file), out, seen[file.name])
                elif file.name != "checkpoint.h5":
                    check_members(file.name, fields, datasets(file), out, seen["state"])
            listed = (SOURCE / "docs" / "reference" / "files.md").read_text().split("## `steps.csv`")[0]
            for file in out.iterdir():
                if file.name not in ("joint", "rungs") and f"`{file.name}" not in listed:
                    fail(f"the file {file.name} is not documented")
    for name, tables in [*known.items(), ("state", [fields])]:
        every = {column for table in tables for column in table} - SELDOM
        for column in sorted(every - seen[name]):
            fail(f"{name}: {column} is documented, but no run has it")
    scenes = (SOURCE / "docs" / "scenes.md").read_text()
    for scene in sorted(SCENES.glob("*.toml")):
        picture = SOURCE / "docs" / "pictures" / f"{scene.stem}.png"
        if not picture.is_file() or picture.stat().st_size > 60_000 or f"pictures/{scene.stem}.png" not in scenes:
            fail(f"docs/scenes.md has no picture of {scene.stem} of 60 kB at most")
    lines = len((SOURCE / "README.md").read_text().splitlines())
    if lines > 110:
        fail(f"README.md has {lines} lines, at most 110 are meant")
    print(f"{sum(len(names) for names in seen.values())} columns, members and datasets documented and seen; {failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    raise SystemExit(main())
