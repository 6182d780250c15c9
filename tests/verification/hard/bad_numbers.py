# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers that no run can do anything with: each ends in one sentence, with status 2 (the scene) or 3 (a solver), and leaves the
folder of an earlier run as it was. The meshes, the scene and what a sentence is are those of regression.bad-input, whose cases
are not repeated."""

import shutil
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[2] / "regression" / "bad_input")]
from bad_input import INSIDES, NOISE, content, differences  # noqa: E402
from case import SCENE, cube2, moved, moved_corner, square2, square_elements, write  # noqa: E402
from table import Table  # noqa: E402

from harness import attempt, signorini, table  # noqa: E402

LATER = "(t > 1e-4 ? {} : 0)"  # two thirds of the run are over by then
SQUARE = square2()
CLAMP = '[[clamp]]\non = "top"\n'
FREE = {CLAMP: ""}


def obstacle(**keys: object) -> dict:
    return {"contact__obstacle": keys}


def objective(**keys: object) -> dict:
    return {"objective__desired": keys}


# Name, verb, overrides (or a text of the scene and what takes its place), mesh, and a fragment of the sentence.
CASES: list[tuple[str, str, dict, str, str]] = [
    ("load overflows late", "optimize", {"load__body": ["0", LATER.format("exp(800)")]}, SQUARE, "load.body"),
    ("traction is no number late", "simulate", {"load__traction": [{"on": "side", "value": ["0", LATER.format("log(-1)")]}]}, SQUARE,
     "load.traction[0].value"),
    ("first guess is infinite", "optimize", {"control__initial": ["1/x", "0"]}, SQUARE, "control.initial"),
    ("first guess is no number, forward run", "simulate", {"control__initial": ["0", "sqrt(t - 1)"]}, SQUARE, "control.initial"),
    ("control of the check is no number", "check", {"check__control": ["log(-1)", "0"]}, SQUARE, "check.control"),
    ("initial velocity is no number", "simulate", {"initial__velocity": ["0", "y < 1 ? 0/0 : 0"]}, SQUARE, "initial.velocity"),
    ("initial displacement is infinite", "simulate", {"initial__displacement": ["1/(y - 0.5)", "0"]}, SQUARE, "initial.displacement"),
    ("clamp jumps to infinity late", "simulate", {"clamp__0__value": ["0", LATER.format("1/0")]}, SQUARE, "clamp.value"),
    ("desired displacement is infinite late", "optimize", objective(displacement=["0", LATER.format("1/0")]), SQUARE,
     "objective.desired.displacement"),
    ("desired displacement whose square overflows", "optimize", objective(displacement=["0", "1e200"]), SQUARE, "objective"),
    ("plane moves to infinity", "simulate", obstacle(shape="half-space", point=["0", "-0.1 - " + LATER.format("1/0")], normal=[0, 1]), SQUARE,
     "contact.obstacle.point"),
    ("level set is no number", "simulate", obstacle(shape="signed-distance", distance="sqrt(x - 9)"), SQUARE, "contact.obstacle.distance"),
    ("level set is flat: normal of no length", "simulate", obstacle(shape="signed-distance", distance="1 + 0*y"), SQUARE,
     "contact.obstacle.distance"),
    ("level set with a pole at a node", "simulate", obstacle(shape="signed-distance", distance="1/(y + x^2)"), SQUARE,
     "contact.obstacle.distance"),
    ("node at the centre of a ball: no normal", "simulate", obstacle(shape="ball", center=[0, 0], radius=3, side="inside"), SQUARE, "contact"),
    ("candidates held in the normal's direction", "simulate", {CLAMP: CLAMP.replace("top", "bottom") + 'components = ["y"]\n'}, SQUARE, "contact.on"),
    ("node pushed through the opposite edge", "simulate", {}, square2(points=moved(2, (0.0, 0.9, 0.0))), "overlap"),
    ("corner pushed through the opposite face", "simulate", {"mesh__file": "cube.msh"}, cube2(points=moved_corner(6, (-2.0, 2.0, 0.2))),
     "overlap"),
    ("all triangles inside out in one point", "simulate", {}, square2(points=[(0.0, 0.0, 0.0)] * 9), "no area"),
    ("load whose motion overflows", "simulate", {"load__body": ["0", "-1e308"]}, SQUARE, "Penetration"),
    ("control whose motion overflows", "optimize", {"control__scale": 1e308}, SQUARE, "Penetration"),
    ("stiffness at the end of the numbers", "simulate", {"material__young": 1e308}, SQUARE, "step 1 (t = 5e-05 s): the solution is not finite"),
    ("static limit, nothing clamped: step huge", "simulate", FREE | {"time__step": 1e20, "time__end": 2e20}, SQUARE, "not positive definite"),
    ("static limit, nothing clamped: density tiny", "simulate", FREE | {"material__density": 1e-40}, SQUARE, "not positive definite"),
    ("the same by conjugate gradients", "simulate", FREE | {"material__density": 1e-40, "solver__linear": "iterative"}, SQUARE, "DIVERGED_INDEFINITE_MAT"),
    ("the same by the full VI", "simulate", FREE | {"material__density": 1e-40, "solver__vi": "full"}, SQUARE, "not positive definite"),
]  # fmt: skip


def complaints(verb: str, overrides: dict, mesh: str, fragment: str, folder: Path, good: Path) -> tuple[str, list[str]]:
    """What the program said, and what is wrong with that or with what it left."""
    out = folder / "results"
    folder.mkdir()
    shutil.copytree(good, out)
    write(folder / overrides.get("mesh__file", "square.msh"), mesh)
    edits = {old: new for old, new in overrides.items() if old in SCENE}
    scene = SCENE
    for old, new in edits.items():
        scene = scene.replace(old, new)
    write(folder / "scene.toml", scene)
    before = content(folder)
    done = attempt(verb, folder / "scene.toml", out, **{key: value for key, value in overrides.items() if key not in edits})
    lines = done.stderr.splitlines()
    found = differences(before, content(folder))
    if done.returncode not in (2, 3):
        found.append(f"exit status {done.returncode}")
    if len(lines) != 1 or not lines[0].startswith("signorini: "):
        found.append(f"{len(lines)} lines on stderr")
    if fragment not in done.stderr:
        found.append(f"no {fragment!r}")
    if NOISE.search(done.stderr + done.stdout) or INSIDES.search(done.stderr):
        found.append("a library speaks")
    said = done.stderr.strip().replace(f"{folder}/", "").removeprefix("signorini: ")
    return f"{done.returncode}: {said}", found


def orientation(good: Path, folder: Path) -> float:
    """Change of the motion by triangles that are numbered clockwise, every second one: relative to the largest energy."""
    folder.mkdir()
    elements = [(kind, group, entity, nodes[::-1] if i % 2 else nodes) for i, (kind, group, entity, nodes) in enumerate(square_elements())]
    write(folder / "square.msh", square2(elements=elements))
    write(folder / "scene.toml", SCENE)
    signorini("simulate", folder / "scene.toml", folder / "out")
    ours, theirs = table(folder / "out" / "steps.csv")["kinetic_energy"], table(good / "steps.csv")["kinetic_energy"]
    return abs(ours - theirs).max() / theirs.max()


def main() -> int:
    rows = Table("bad numbers")
    with tempfile.TemporaryDirectory() as name:
        root = Path(name)
        write(root / "square.msh", SQUARE)
        write(root / "scene.toml", SCENE)
        good = root / "good"
        signorini("simulate", root / "scene.toml", good)
        with ThreadPoolExecutor(2) as workers:
            ends = workers.map(lambda case: complaints(*case[1][1:], root / str(case[0]), good), enumerate(CASES))
            for (case, *_), (said, found) in zip(CASES, ends, strict=True):
                rows.row(case, said if len(said) <= 400 else said[:397] + "...", not found)
                for complaint in found:
                    print(f"      {complaint}")
        # Rounding of eight triangles' sums.
        change = orientation(good, root / "clockwise")
        rows.row("clockwise triangles are none of them", f"motion changes by {change:.1e}", change < 1e-12)
    return 1 if rows.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
