# SPDX-License-Identifier: GPL-3.0-or-later
"""`signorini keys` names every key, and with --json is a JSON schema that takes all scenes here and none with a wrong type, a
key too many or too few."""

import copy
import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import SIGNORINI, SOURCE, captured
from jsonschema import Draft202012Validator

FILES = sorted(file for folder in ("scenes", "tests/data", "docs/verification") for file in (SOURCE / folder).glob("*.toml"))
assert len(FILES) > 12


def valid(value: object, schema: dict) -> bool:
    """True if a value is what a schema asks for."""
    return Draft202012Validator(schema).is_valid(value)


def places(node: object, path: tuple = ()) -> Iterator[tuple]:
    """The paths of all tables and values, the scene's own and changed keys of scenarios apart."""
    for key, value in node.items() if isinstance(node, dict) else enumerate(node):
        yield (*path, key)
        if key != "set" and isinstance(value, dict) or (isinstance(value, list) and value and isinstance(value[0], dict)):
            yield from places(value, (*path, key))


def changed(scene: dict, path: tuple, value: object) -> dict:
    scene = copy.deepcopy(scene)
    node = scene
    for key in path[:-1]:
        node = node[key]
    node[path[-1]] = value
    return scene


def defaults(schema: object) -> Iterator[dict]:
    for value in schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ():
        yield from defaults(value)
    if isinstance(schema, dict) and "default" in schema:
        yield schema


def printed(*words: str) -> str:
    done = captured([str(SIGNORINI), *words])
    assert done.returncode == 0 and not done.stderr, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def schema() -> dict:
    return json.loads(printed("keys", "--json"))


def test_help_names_the_command() -> None:
    assert re.search(r"(?m)^  keys ", printed("--help"))


@pytest.mark.parametrize("words", ("--help", "keys"))
def test_parts_of_expressions(words: str) -> None:
    said = printed(words)
    assert all(part in said for part in ("a ? b : c", "+ - * / ^", "atan2", "sqrt", "pi", "x, y, z (m)"))


def test_same_keys_as_text_and_markdown() -> None:
    named = re.findall(r"(?m)^\| `([a-z_.]+)` ", printed("keys", "--markdown"))
    assert len(named) > 60 and re.findall(r"(?m)^[a-z_.]+$", printed("keys")) == named


def test_dialect(schema: dict) -> None:
    assert schema["$schema"] == Draft202012Validator.META_SCHEMA["$id"]
    Draft202012Validator.check_schema(schema)


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parent.name}/{file.name}")
def test_scene(file: Path, schema: dict) -> None:
    """It is valid, and with any one thing wrong it is not."""
    scene = tomllib.loads(file.read_text())
    assert valid(scene, schema)
    wrong = {"a key too many": scene | {"gravity": 9.81}, "no time": {k: v for k, v in scene.items() if k != "time"}}
    for path in places(scene):
        value = {"nonsense": 1} if not isinstance(path[-1], int) and path[-1] != "set" else "nonsense"
        wrong[f"{path} of a wrong type"] = changed(scene, path, value)
    wrong |= {"a text for a number": changed(scene, ("time", "end"), "1"), "a step of zero": changed(scene, ("time", "step"), 0),
              "an unknown scheme": changed(scene, ("time", "scheme"), "explicit")}  # fmt: skip
    assert [what for what, other in wrong.items() if valid(other, schema)] == [], "valid, and yet wrong"


def test_scenes_name_their_schema(schema: dict) -> None:
    """Editors find it by the first line."""
    folder = SOURCE / "scenes"
    assert json.loads((folder / "scene.schema.json").read_text()) == schema, "write it anew: signorini keys --schema-file scenes/scene.schema.json"
    scenes = list(folder.glob("*.toml"))
    assert len(scenes) > 30
    assert [scene.name for scene in scenes if not scene.read_text().startswith("#:schema scene.schema.json\n")] == []


def test_schema_file(schema: dict, tmp_path: Path) -> None:
    said = printed("keys", "--schema-file", str(tmp_path / "own.json"))
    assert json.loads((tmp_path / "own.json").read_text()) == schema and said.endswith("\n#:schema own.json\n")
    assert [file.name for file in tmp_path.iterdir()] == ["own.json"]


def test_schema_file_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    for name, reason in ("none/own.json", "No such file or directory"), ("folder", "Is a directory"):
        done = captured([str(SIGNORINI), "keys", "--schema-file", str(tmp_path / name)])
        assert done.returncode == 2 and not done.stdout
        assert done.stderr == f"signorini: --schema-file: {tmp_path / name}: cannot be written ({reason})\n"
    assert [file.name for file in tmp_path.iterdir()] == ["folder"]


def test_defaults(schema: dict) -> None:
    own = list(defaults(schema))
    assert len(own) > 15
    assert [one["default"] for one in own if not valid(one["default"], one)] == [], "refused by its own key"
