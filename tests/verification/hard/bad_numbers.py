# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers that no run can do anything with: each ends in one sentence, with status 2 (the scene) or 3 (a solver), and leaves the
folder of an earlier run as it was. The meshes, the scene and what a sentence is are those of regression.bad-input, whose cases
are not repeated."""

import shutil
from pathlib import Path

import pytest
from case import SCENE, cube2, moved, moved_corner, square2, square_elements, write
from case_run import INSIDES, NOISE, content, differences
from harness import attempt, signorini, table

LATER = "(t > 1e-4 ? {} : 0)"  # two thirds of the run are over by then
SQUARE = square2()
CLAMP = '[[clamp]]\non = "top"\n'
LIGHT = {"edits": {CLAMP: ""}, "material__density": 1e-40}  # not clamped


def obstacle(**keys: object) -> dict:
    return {"contact__obstacle": keys}


def level_set(distance: str) -> dict:
    return obstacle(shape="signed-distance", distance=distance)


def desired(displacement: str) -> dict:
    return {"objective__desired": {"displacement": ["0", displacement]}}


# By name: the verb, overrides, among them "edits" of the scene's text and "mesh", and a fragment of the sentence.
CASES: dict[str, tuple[str, dict, str]] = {
    "load overflows late": ("optimize", {"load__body": ["0", LATER.format("exp(800)")]}, "load.body"),
    "traction is no number late":
        ("simulate", {"load__traction": [{"on": "side", "value": ["0", LATER.format("log(-1)")]}]}, "load.traction[0].value"),
    "first guess is infinite": ("optimize", {"control__initial": ["1/x", "0"]}, "control.initial"),
    "first guess is no number, forward run": ("simulate", {"control__initial": ["0", "sqrt(t - 1)"]}, "control.initial"),
    "control of the check is no number": ("check", {"check__control": ["log(-1)", "0"]}, "check.control"),
    "initial velocity is no number": ("simulate", {"initial__velocity": ["0", "y < 1 ? 0/0 : 0"]}, "initial.velocity"),
    "initial displacement is infinite": ("simulate", {"initial__displacement": ["1/(y - 0.5)", "0"]}, "initial.displacement"),
    "clamp jumps to infinity late": ("simulate", {"clamp__0__value": ["0", LATER.format("1/0")]}, "clamp.value"),
    "desired displacement is infinite late": ("optimize", desired(LATER.format("1/0")), "objective.desired.displacement"),
    "desired displacement whose square overflows": ("optimize", desired("1e200"), "objective"),
    "plane moves to infinity":
        ("simulate", obstacle(shape="half-space", point=["0", "-0.1 - " + LATER.format("1/0")], normal=[0, 1]), "contact.obstacle.point"),
    "level set is no number": ("simulate", level_set("sqrt(x - 9)"), "contact.obstacle.distance"),
    "level set is flat: normal of no length": ("simulate", level_set("1 + 0*y"), "contact.obstacle.distance"),
    "level set with a pole at a node": ("simulate", level_set("1/(y + x^2)"), "contact.obstacle.distance"),
    "node at the centre of a ball: no normal": ("simulate", obstacle(shape="ball", center=[0, 0], radius=3, side="inside"), "contact"),
    "candidates clamped in the normal's direction":
        ("simulate", {"edits": {CLAMP: CLAMP.replace("top", "bottom") + 'components = ["y"]\n'}}, "contact.on"),
    "node pushed through the opposite edge": ("simulate", {"mesh": square2(points=moved(2, (0.0, 0.9, 0.0)))}, "overlap"),
    "corner pushed through the opposite face":
        ("simulate", {"mesh__file": "cube.msh", "mesh": cube2(points=moved_corner(6, (-2.0, 2.0, 0.2)))}, "overlap"),
    "all triangles inside out in one point": ("simulate", {"mesh": square2(points=[(0.0, 0.0, 0.0)] * 9)}, "zero area"),
    "load whose motion overflows": ("simulate", {"load__body": ["0", "-1e308"]}, "largest penetration"),
    "control whose motion overflows": ("optimize", {"control__scale": 1e308}, "largest penetration"),
    "stiffness at the end of the numbers": ("simulate", {"material__young": 1e308}, "step 1 (t = 5e-05 s): the solution is not finite"),
    "static limit, nothing clamped: step huge":
        ("simulate", {"edits": {CLAMP: ""}, "time__step": 1e20, "time__end": 2e20}, "not positive definite"),
    "static limit, nothing clamped: density tiny": ("simulate", LIGHT, "not positive definite"),
    "the same by conjugate gradients": ("simulate", LIGHT | {"solver__linear": "iterative"}, "DIVERGED_INDEFINITE_MAT"),
    "the same by the full VI": ("simulate", LIGHT | {"solver__vi": "full"}, "not positive definite"),
}  # fmt: skip


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The results of the scene as it is."""
    folder = tmp_path_factory.mktemp("good")
    write(folder / "square.msh", SQUARE)
    write(folder / "scene.toml", SCENE)
    signorini("simulate", folder / "scene.toml", folder / "results")
    return folder / "results"


@pytest.mark.parametrize("verb, overrides, fragment", CASES.values(), ids=CASES)
def test_one_sentence(verb: str, overrides: dict, fragment: str, good: Path, tmp_path: Path) -> None:
    scene, out = tmp_path / "scene.toml", tmp_path / "results"
    shutil.copytree(good, out)
    given = dict(overrides)
    write(tmp_path / given.get("mesh__file", "square.msh"), given.pop("mesh", SQUARE))
    text = SCENE
    for old, new in given.pop("edits", {}).items():
        assert old in text
        text = text.replace(old, new)
    write(scene, text)
    before = content(tmp_path)
    done = attempt(verb, scene, out, **given)
    print(f"{done.returncode}: {done.stderr.strip().replace(f'{tmp_path}/', '').removeprefix('signorini: ')[:400]}")
    assert done.returncode in (2, 3)
    assert done.stderr.startswith("signorini: ") and len(done.stderr.splitlines()) == 1
    assert fragment in done.stderr
    assert not NOISE.search(done.stderr + done.stdout) and not INSIDES.search(done.stderr), "a library speaks"
    assert not differences(before, content(tmp_path))


def test_clockwise_triangles_change_nothing(good: Path, tmp_path: Path) -> None:
    """Every second triangle is numbered clockwise: the motion changes by the rounding of eight triangles' sums."""
    elements = [(kind, group, entity, nodes[::-1] if i % 2 else nodes) for i, (kind, group, entity, nodes) in enumerate(square_elements())]
    write(tmp_path / "square.msh", square2(elements=elements))
    write(tmp_path / "scene.toml", SCENE)
    signorini("simulate", tmp_path / "scene.toml", tmp_path / "out")
    ours, theirs = table(tmp_path / "out" / "steps.csv")["kinetic_energy"], table(good / "steps.csv")["kinetic_energy"]
    change = abs(ours - theirs).max() / theirs.max()
    print(f"motion changes by {change:.1e} < 1e-12")
    assert change < 1e-12
