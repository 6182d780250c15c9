# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad input: whatever is wrong, the program says so in one sentence, exits with status 2 and leaves nothing behind.

Every case starts from a small scene that runs and spoils it in one way. Afterwards the folder of the case, results of an earlier
run included, has exactly the content that it had before.
"""

import re
from pathlib import Path

import pytest
from case import GEO, SPACE_GEO, TO_SPACE, Case, Expected, cube2, square2, square4
from case_run import INSIDES, NOISE, content, differences, fill, run, scene_of
from cases import all_cases
from harness import SOURCE

WRONG_INPUT = 2
HEADLINE = re.compile(r"(scene: \d+ free unknowns, .*\nbody: .*\n(warning: .*\n)*effects: .*\nsolver: .*\n)?")
GOOD = (
    Case("square in format 2.2", (), mesh=square2()),
    Case("square in format 4.1", (), mesh=square4(), verb="optimize"),
    Case("square of a geometry", (), edits=(('file = "square.msh"', 'file = "square.geo"\nsize = 4'),), mesh=GEO, mesh_file="square.geo"),
    Case("square on two ranks", (), ranks=2),
    Case("cube", (), edits=TO_SPACE, mesh=cube2(), mesh_file="cube.msh", verb="optimize"),
    Case("cube of a geometry, three ranks", (), edits=(*TO_SPACE, ('file = "cube.msh"', 'file = "cube.geo"\nsize = 4'),
                                                       ('on = "top"', 'on = "side"')), mesh_file="cube.geo", ranks=3,
         mesh=SPACE_GEO + 'Physical Volume("body") = {1}; Physical Surface("side") = {26};\n'),
    Case("half disc", (), command=("simulate", str(SOURCE / "scenes" / "half-disc.toml"), "--out", "results", "--set", "mesh.size=4",
                                   "--set", "time.end=1.5e-4")),
)  # fmt: skip


@pytest.mark.parametrize("case", GOOD, ids=lambda case: case.name)
def test_good_input_runs(case: Case, tmp_path: Path) -> None:
    """Without what the cases spoil."""
    fill(tmp_path, case)
    assert run(case, tmp_path).returncode == 0 and (tmp_path / "results" / "run.json").is_file()


@pytest.mark.parametrize("case", all_cases(), ids=lambda case: case.name)
def test_bad_input_is_refused(case: Case, tmp_path: Path) -> None:
    fill(tmp_path, case)
    before = content(tmp_path)
    done = run(case, tmp_path)
    print(done.stdout + done.stderr)
    assert done.returncode == WRONG_INPUT
    lines = done.stderr.splitlines()
    own = [line for line in lines if line.startswith("signorini: ")]
    assert len(own) == 1 and lines[0] == own[0], "stderr is one line of the program, to which mpirun may add its own"
    assert case.ranks > 1 or len(lines) == 1
    assert not NOISE.search(done.stderr) and not NOISE.search(done.stdout), "a library speaks"
    assert HEADLINE.fullmatch(done.stdout)
    message = own[0].removeprefix("signorini: ").replace(f"{tmp_path}/", "")  # a folder's name says nothing
    expected = [*case.expect, *([f"scene.toml:{line_of(case)}: "] if case.at else [])]
    assert not [fragment for fragment in expected if not contains(message, fragment)], "the message lacks this"
    assert not [fragment for fragment in (*case.never, INSIDES) if contains(message, fragment)], "this is in the message"
    assert not differences(before, content(tmp_path))


def line_of(case: Case) -> int:
    """Number of the line of the scene that the message must name."""
    text = scene_of(case)
    return text[: text.index(case.at)].count("\n") + 1


def contains(message: str, expected: Expected) -> bool:
    """Whether a message has a fragment or matches a pattern."""
    return expected in message if isinstance(expected, str) else bool(expected.search(message))
