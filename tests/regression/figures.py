# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of a run are drawn from its folder: all of them, legible image files, and one sentence where it is no run."""

import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_BALL, HALF_DISC, SOURCE, signorini  # noqa: E402
from soft_scenes import ON_A_BALL, soft  # noqa: E402

import numpy as np  # noqa: E402
from PIL import Image  # noqa: E402

sys.path.insert(0, str(SOURCE / "postprocess"))
import as_package  # noqa: E402, F401
from signorini.post import control_magnitude  # noqa: E402
from signorini.post.run_folder import RunFolder  # noqa: E402
from signorini.post.view import view_of  # noqa: E402

SCRIPT = SOURCE / "postprocess" / "figures.py"
SIMULATE = {"contact_force.png", "contact_force_history.png", "contact_pressure.png", "energy.png", "animation.gif"}
OPTIMIZE = SIMULATE | {"control_magnitude.png", "control_history.png", "objective.png", "distance_to_reference.png", "tracking_error.png"}
# Jaws, one of which moves, a disc inside of which the body is and a wavy floor.
OBSTACLES = soft("square.geo", 0.2, 0.3, 0.01) + """
[[contact]]
on = "left"
obstacle = { shape = "half-space", point = ["-0.3 + 1.2*t", 0], normal = [1, 0] }

[[contact]]
on = "rest"
obstacle = { shape = "cylinder", point = [-0.3, 0.5], radius = 1.45, side = "inside" }

[[contact]]
on = "bottom"
obstacle = { shape = "signed-distance", distance = "y + 0.2 - 0.09*cos(3*(x - 0.5))" }
"""


def draw(out: Path) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, str(SCRIPT), str(out)], capture_output=True, text=True)


def drawn(out: Path) -> set[str]:
    done = draw(out)
    assert done.returncode == 0, done.stderr
    return {p.name for p in (out / "figures").iterdir() if p.suffix in (".png", ".gif")}


def cellwise(folder: Path) -> None:
    """A control of one value for each cell, in the plane and in space, on the body and on a surface: each triangle that is
    drawn has the value of a cell that it belongs to, and the label has the unit."""
    catch, ball = SOURCE / "scenes" / "catch.toml", {"mesh__size": 4, "time__step": 5e-4, "control__initial": ["0", "0", "-0.9"]}
    for scene, unit, more in ((HALF_DISC, "$10^{6}$ N/m³", {"mesh__size": 3}), (catch, "N/m²", {"mesh__size": 0.3, "time__step": 0.02}),
                              (HALF_BALL, "$10^{6}$ N/m³", ball), (HALF_BALL, "$10^{6}$ N/m²", ball | {"control__on": "side"})):  # fmt: skip
        out = folder / "cells"
        signorini("optimize", scene, out, optimizer__max_iterations=1, control__space="cellwise", **more)
        run = RunFolder(out)
        assert control_magnitude.draw(run)[0].stat().st_size > 5000, f"{scene.name}, {more}"
        series = run.field("control.xdmf", "control")
        mesh, cells = view_of(run).seen(series.mesh)
        assert series.cellwise and len(series.at(0)) == len(series.mesh.cells)
        assert all(set(shown) <= set(series.mesh.cells[cell]) for shown, cell in zip(mesh.cells, cells, strict=True))
        assert control_magnitude.control_unit(run) == unit, control_magnitude.control_unit(run)


def pressed(out: Path, figures: set[str]) -> set[str]:
    """Those figures, but for the one that wants pressures where contact.csv has none."""
    return figures if "pressure" in (out / "contact.csv").read_text().split("\n", 1)[0] else figures - {"contact_pressure.png"}


def every_obstacle(folder: Path) -> None:
    """Several obstacles of all shapes are drawn, and the jaw comes nearer; in space a ball is."""
    for name, text in (("several", OBSTACLES), ("ball", ON_A_BALL)):
        scene, out = folder / f"{name}.toml", folder / name
        scene.write_text(text)
        signorini("simulate", scene, out)
        found = drawn(out)
        assert found == pressed(out, SIMULATE), f"{name}: missing {SIMULATE - found}, unexpected {found - SIMULATE}"
        with Image.open(out / "figures" / "animation.gif") as film:
            grey = []
            for frame in (0, film.n_frames - 1):
                film.seek(frame)
                picture = np.asarray(film.convert("RGB")).astype(int)
                plot = picture[50:-75, 90:-130]  # without axes and colours
                grey.append(np.mean((np.ptp(plot, axis=2) < 8) & (abs(plot.mean(axis=2) - 216) < 12)))
        assert grey[0] > 0.02, f"{name}: no obstacle is seen"
        assert name == "ball" or grey[1] > grey[0] + 0.03, f"the jaw does not move: {grey}"


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        signorini("optimize", HALF_DISC, folder / "o", mesh__size=2, optimizer__max_iterations=5)
        signorini("simulate", HALF_DISC, folder / "s", mesh__size=2, control__initial=["0", "-1"])
        signorini("optimize", HALF_BALL, folder / "b", mesh__size=3, time__step=2.5e-4, optimizer__max_iterations=3,
                  contact__obstacle__normal=[0.1, -0.12, 1], control__initial=["0", "0", "-0.9"])  # fmt: skip
        found = drawn(folder / "o")
        optimize, simulate = pressed(folder / "o", OPTIMIZE), pressed(folder / "s", SIMULATE)
        assert found == optimize, f"missing {optimize - found}, unexpected {found - optimize}"
        found = drawn(folder / "s")
        assert found == simulate, f"missing {SIMULATE - found}, unexpected {found - SIMULATE}"
        found = drawn(folder / "b")
        assert found == optimize, f"in space: missing {OPTIMIZE - found}, unexpected {found - OPTIMIZE}"
        for file in sorted([*(folder / "o" / "figures").glob("*.png"), *(folder / "b" / "figures").glob("*.png")]):
            assert b"signorini report" in file.read_bytes()[:1000], "the next run would take it for the user's"
            with Image.open(file) as image:
                assert np.min(image.size) >= 400, f"{file.name} is {image.size}"
                colours = image.convert("RGB").getcolors(maxcolors=10**7)
                assert len(colours) > 50, f"{file.name} is blank"
        assert b"signorini report" in (folder / "o" / "figures" / "animation.gif").read_bytes()[:1000]
        with Image.open(folder / "o" / "figures" / "animation.gif") as image:
            assert image.n_frames >= 30
        for tables, fields, expected in ((["contact"], ["displacement", "control"],
                                          {"control_magnitude.png", "control_history.png", "contact_force.png", "contact_pressure.png",
                                           "animation.gif"}),
                                         (["history"], ["control"],
                                          {"control_magnitude.png", "control_history.png", "objective.png", "distance_to_reference.png"}),
                                         ([], [], set())):  # fmt: skip
            out = folder / "part"
            signorini("optimize", HALF_DISC, out, mesh__size=3, optimizer__max_iterations=1, output__tables=tables,
                      output__fields=fields, control__initial=["0", "-0.9"])  # fmt: skip
            expected = pressed(out, expected) if "contact" in tables else expected
            done = draw(out)
            found = {Path(line).name for line in done.stdout.splitlines() if line.endswith((".png", ".gif"))}
            said = [line for line in done.stdout.splitlines() if line.startswith("no ")]
            assert done.returncode == 0 and found == expected, f"{tables}, {fields}: {found}\n{done.stdout}{done.stderr}"
            assert len(said) == len(OPTIMIZE - expected) + 1, done.stdout  # measurements too, which only a fit has
        signorini("optimize", SOURCE / "scenes" / "drop-test.toml", folder / "fit", optimizer__max_iterations=2)
        found = drawn(folder / "fit")
        assert found == pressed(folder / "fit", SIMULATE | {"objective.png", "measurements-1.png"}), found
        every_obstacle(folder)
        cellwise(folder)
        assert "control_magnitude.png" in drawn(folder / "cells")
        wrong = draw(folder)
        assert wrong.returncode == 2 and wrong.stderr.count("\n") == 1, wrong.stderr
        print(f"{len(OPTIMIZE)}, in space as many, and {len(SIMULATE)} figures drawn; not a run: {wrong.stderr.strip()}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
