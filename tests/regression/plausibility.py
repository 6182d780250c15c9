# SPDX-License-Identifier: GPL-3.0-or-later
"""What makes results mean less than they seem to is said once, in run.json and on the page; scenes that are what the model is for
have nothing of it. A mesh with nodes at one place is a mesh like others. Short steps and a stiff body's weight are contact.
"""

import functools
import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import SIGNORINI, SOURCE, attempt, signorini, table
from soft_scenes import soft

DATA = SOURCE / "tests" / "data"
BLOCK = DATA / "block.toml"
GENTLE = {"contact__mass": "massless", "initial__velocity": ["0", "-0.01"], "load__body": ["0", "-0.1"],
          "contact__obstacle": {"shape": "half-space", "point": [0, -1e-3], "normal": [0, 1]}}  # fmt: skip
APART = {**GENTLE, "mesh__file": str(DATA / "apart.geo")}
# Coarse and short. Their warnings are true: the bar meets a wall at a third of its waves' speed, the disc that is caught is
# soft. All are one body, clamped and touched where they should be.
SHIPPED = {"bar-impact": {"time__end": 1.5}, "standing-wave": {}, "catch": {}, "hertz-press": {"time__step": 0.5},
           "half-disc": {"mesh__size": 2}}  # fmt: skip
OF_THE_MOTION = {"large strain", "large rotation", "linearised gap"}


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def warnings(out: Path) -> dict[str, dict]:
    found = manifest(out)["warnings"]
    names = {warning["name"]: warning for warning in found}
    assert len(names) == len(found), "one is said twice"
    for warning in found:
        assert warning["value"] > warning["limit"] and warning["message"]
    return names


@pytest.mark.parametrize("ranks", (1, 2))
def test_none(ranks: int, tmp_path: Path) -> None:
    done = signorini("simulate", BLOCK, tmp_path, ranks, **GENTLE)
    assert not warnings(tmp_path) and "warning" not in done.stdout


@pytest.mark.parametrize("ranks, degree", ((1, 1), (2, 1), (1, 2)))
def test_slide_of_parts(ranks: int, degree: int, tmp_path: Path) -> None:
    """The upper square is pressed on the lower one and moves along it: by more than its facets of 1/7, and by less at a fifth of the speed."""
    for speed, warned in ((1.5, True), (0.3, False)):
        out = tmp_path / str(speed)
        done = signorini("simulate", DATA / "two-squares.toml", out, ranks, initial__velocity=[f"y > 1.02 ? {speed} : 0", "y > 1.02 ? -0.1 : 0"],
                         contact__friction=0.0, contact__height=0.049, time__end=0.4, mesh__degree=degree)  # fmt: skip
        assert table(out / "steps.csv")["active"].max() > 2
        found = warnings(out)
        assert ("motion beyond a facet" in found) is warned
        if warned:
            reached = re.search(r"t = (\S+) s", found["motion beyond a facet"]["message"]).group(1)
            assert found["motion beyond a facet"]["value"] == pytest.approx(7 * speed * float(reached), rel=0.05)
            assert "slid" in done.stdout


@pytest.mark.parametrize("ranks", (1, 2))
def test_parts_of_the_mesh(ranks: int, tmp_path: Path) -> None:
    done = signorini("simulate", BLOCK, tmp_path, ranks, **APART)
    found = warnings(tmp_path)
    assert set(found) == {"parts of the mesh"} and found["parts of the mesh"]["value"] == 2
    message = found["parts of the mesh"]["message"]
    assert done.stdout.count(f"warning: {message}") == 1
    subprocess.run([sys.executable, str(SOURCE / "postprocess" / "report.py"), str(tmp_path)], check=True, capture_output=True)
    assert message in (tmp_path / "report.html").read_text()


def test_parts_of_the_mesh_of_a_search(tmp_path: Path) -> None:
    signorini("optimize", BLOCK, tmp_path, **APART, optimizer__max_iterations=1, output__tables=[], output__fields=[])
    assert "parts of the mesh" in warnings(tmp_path)


def test_first_exceeded(tmp_path: Path) -> None:
    """A body that spins freely turns by ω t in the linear model, and by 5 degrees at 0.218 s: the next sample is at 0.25 s."""
    scene, out = tmp_path / "spinning.toml", tmp_path / "spinning"
    scene.write_text(soft("square.geo", 0.5, 1.0, 0.0625) + '[initial]\nvelocity = ["-0.4*y", "0.4*x"]\n')
    signorini("simulate", scene, out)
    found = warnings(out)["large rotation"]
    assert found["value"] == pytest.approx(np.degrees(0.4), rel=0, abs=1e-9)
    assert "(the limit is first exceeded at or before t = 0.25 s)" in found["message"]


CANTILEVER = """
Point(1) = {0, 0, 0, 0.01}; Point(2) = {0.28, 0, 0, 0.01}; Point(3) = {0.3, 0, 0, 0.01};
Point(4) = {0.3, 0.02, 0, 0.01}; Point(5) = {0, 0.02, 0, 0.01};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 1};
Curve Loop(1) = {1:5}; Plane Surface(1) = {1};
Physical Curve("tip") = {2}; Physical Curve("root") = {5}; Physical Surface("body") = {1};
"""
STOP = """
mesh = { file = "stop.geo", size = 0.01 }
time = { end = 1e-3, step = 2e-5 }
material = { density = 7800.0, young = 2.1e11, poisson = 0.3 }
initial = { velocity = ["0", "-11*x*x"] }
output = { fields = [] }
[[clamp]]
on = "root"
[contact]
on = "tip"
obstacle = { shape = "half-space", point = [0, -1e-4], normal = [0, 1] }
"""


@pytest.fixture
def stop(tmp_path: Path) -> Path:
    """A steel cantilever that swings against a stop under its tip, in steps of 20 µs, in which a wave goes through twenty elements."""
    (tmp_path / "stop.geo").write_text(CANTILEVER)
    (tmp_path / "stop.toml").write_text(STOP)
    return tmp_path / "stop.toml"


def lost(scene: Path, **overrides: object) -> tuple[float, str]:
    """The part of the energy that contact takes, and the message about it."""
    out = scene.parent / "stop"
    signorini("simulate", scene, out, **overrides)
    steps = table(out / "steps.csv")
    assert (steps["contact_force_y"] > 0).sum() > 3, "hardly any contact: the case says nothing"
    part = -steps["contact_work"].sum() / (steps["kinetic_energy"] + steps["elastic_energy"]).max()
    warning = warnings(out).get("energy lost in contact")
    assert (warning is not None) == (part > 0.03) and (not warning or abs(warning["value"] / part - 1) < 1e-9)
    return part, warning["message"] if warning else ""


@pytest.mark.parametrize("scheme", ("contact-implicit", "contact-stabilized"))
def test_energy_lost(stop: Path, scheme: str) -> None:
    """Contact takes a fifth of it; that falls with the step, as is reported, to the 1 µs that a wave takes through an element."""
    part, message = lost(stop, time__scheme=scheme)
    step = float(re.search(r"Shorter steps \(time.step\) reduce this error until a step takes (\S+) s", message)[1])
    least, _ = lost(stop, time__scheme=scheme, time__step=1e-3 / round(1e-3 / step))
    print(f"contact takes {part:.3f} of the energy with steps of 20 µs, {least:.3f} with {step:g} s")
    assert part > 0.1 and step == pytest.approx(1e-6, rel=0.1) and least < part / 3


def test_energy_lost_by_massless_contact(stop: Path) -> None:
    part, message = lost(stop, time__step=5e-7, contact__mass="massless")
    assert part < 0.03 and not message


def test_energy_lost_to_a_moving_stop(stop: Path) -> None:
    out = stop.parent / "stop"
    signorini("simulate", stop, out, contact__obstacle={"shape": "half-space", "point": [0, "-1e-4 + 0*t"], "normal": [0, 1]})
    assert "energy lost in contact" not in warnings(out)


ANGLE = """
h = 0.1;
Point(1) = {0, 0, 0, h}; Point(2) = {1, 0, 0, h}; Point(3) = {1, 0.4, 0, h}; Point(4) = {0.4, 0.4, 0, h};
Point(5) = {0.4, 1, 0, h}; Point(6) = {0, 1, 0, h};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 6}; Line(6) = {6, 1};
Curve Loop(1) = {1:6}; Plane Surface(1) = {1};
Physical Curve("foot") = {1}; Physical Curve("tip") = {2}; Physical Curve("head") = {5}; Physical Surface("body") = {1};
"""
THICK = ANGLE[: ANGLE.index("Physical")] + """e[] = Extrude {0, 0, 0.3} { Surface{1}; };
Physical Volume("body") = {e[1]}; Physical Surface("tip") = {e[3]}; Physical Surface("head") = {e[6]};
"""
Corner = Callable[..., float]


@pytest.fixture(scope="module")
def corner(tmp_path_factory: pytest.TempPathFactory) -> Corner:
    """The largest stress in an angle, clamped at its head and pulled at its tip. Each runs once."""
    folder = tmp_path_factory.mktemp("angle")
    scene, geo, out = folder / "angle.toml", folder / "angle.geo", folder / "out"

    @functools.cache
    def of(dim: int, size: float, degree: int = 1, ranks: int = 1) -> float:
        geo.write_text(ANGLE if dim == 2 else THICK)
        across = ["0", "-1"] + ["0"] * (dim - 2)
        scene.write_text(soft("square.geo", 0.1, 1.0, 0.1).replace(str(DATA / "square.geo"), str(geo))
                         + f'[[clamp]]\non = "head"\n[[load.traction]]\non = "tip"\nvalue = {json.dumps(across)}\n'
                         + '[output]\nfields = ["stress", "von_mises"]\nevery = 1\n')  # fmt: skip
        signorini("simulate", scene, out, ranks, mesh__size=size, mesh__degree=degree)
        found, warning = manifest(out)["largest_von_mises"], warnings(out)["stress of the mesh"]
        assert abs(warning["value"] / (found["value"] / found["recovered"]) - 1) < 1e-12 and warning["limit"] == 1.3
        assert "at the corner (0.4, 0.4" in warning["message"] and "where the body fills 0.75 of the full angle" in warning["message"]
        return found["value"]

    return of


@pytest.mark.parametrize("degree, ranks", ((1, 1), (1, 2), (2, 1)))
@pytest.mark.parametrize("dim, size", ((2, 0.1), (3, 0.15)))
def test_stress_at_a_corner(corner: Corner, dim: int, size: float, degree: int, ranks: int) -> None:
    """The warning names the corner that points into the angle, of 270 degrees."""
    found = corner(dim, size, degree, ranks)
    if ranks == 2:
        assert found == pytest.approx(corner(dim, size), rel=1e-9), "on two ranks it is another"


def test_stress_at_a_corner_grows(corner: Corner) -> None:
    """As the elements become smaller, by r^(λ−1) with λ = 0.5445 (Williams 1952)."""
    largest = [corner(2, size) for size in (0.1, 0.05, 0.025)]
    print(f"largest von Mises stress {', '.join(f'{value:.3g}' for value in largest)} Pa")
    assert all(1.25 < fine / coarse < 1.5 for coarse, fine in zip(largest, largest[1:]))


def test_stress_of_a_block(tmp_path: Path) -> None:
    """Under uniform pressure there is no such warning."""
    signorini("simulate", BLOCK, tmp_path, **GENTLE, output__fields=["von_mises"])
    assert manifest(tmp_path)["largest_von_mises"]["value"] > 0 and "stress of the mesh" not in warnings(tmp_path)


RIM_MESH = """Point(1) = {0, 0, 0}; Point(2) = {0.1, 0, 0}; Point(3) = {0, 0.1, 0}; Point(4) = {-0.1, 0, 0}; Point(5) = {0, -0.1, 0};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Circle(3) = {4, 1, 5}; Circle(4) = {5, 1, 2};
Point(12) = {0.08, 0, 0}; Point(13) = {0, 0.08, 0}; Point(14) = {-0.08, 0, 0}; Point(15) = {0, -0.08, 0};
Circle(11) = {12, 1, 13}; Circle(12) = {13, 1, 14}; Circle(13) = {14, 1, 15}; Circle(14) = {15, 1, 12};
Curve Loop(1) = {1:4}; Curve Loop(2) = {11:14}; Plane Surface(1) = {1, 2};
Physical Surface("body") = {1}; Physical Curve("boundary") = {1:4};
"""
RIM = """[mesh]
file = "rim.geo"
size = 0.006
degree = 2
[time]
end = 6e-4
step = 1e-5
[material]
density = 2700.0
young = 7e10
poisson = 0.33
[contact]
on = "boundary"
obstacle = { shape = "ball", center = [0, -0.1501], radius = 0.05 }
[initial]
velocity = ["0", "-1"]
[output]
fields = ["von_mises"]
every = 1
"""


def test_stress_under_one_node(tmp_path: Path) -> None:
    """Where one node takes all of the contact force, the warning names that node, and not another one of the cell."""
    scene, out = tmp_path / "rim.toml", tmp_path / "rim"
    (tmp_path / "rim.geo").write_text(RIM_MESH)
    scene.write_text(RIM)
    signorini("simulate", scene, out)
    found, steps = warnings(out), table(out / "contact.csv")
    pushed = steps["force"] > 0
    (node,) = set(zip(steps["x"][pushed], steps["y"][pushed]))
    place = re.search(r"smaller elements at \((\S+), (\S+)\) m", found["stress of the mesh"]["message"]).groups()
    assert list(map(float, place)) == pytest.approx(node, rel=0, abs=1e-6)


ROD_MESH = """Point(1) = {0, 0, 0}; Point(2) = {0.02, 0, 0}; Point(3) = {0.02, 0.4, 0}; Point(4) = {0, 0.4, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1:4}; Plane Surface(1) = {1};
Physical Surface("body") = {1}; Physical Curve("tip") = {1}; Physical Curve("boundary") = {1:4};
"""
ROD = """[mesh]
file = "rod.geo"
size = 0.02
[time]
end = 4e-3
step = 1e-4
scheme = "contact-stabilized"
[material]
density = 1000.0
young = 1e8
poisson = 0.0
[contact]
on = "tip"
obstacle = { shape = "half-space", point = [0, -0.001], normal = [0, 1] }
[initial]
velocity = ["0", "-1"]
"""
EXACT = 1000 * np.sqrt(1e8 / 1000) * 0.02  # ρ c v A, N/m


@pytest.fixture
def rod(tmp_path: Path) -> Path:
    """A rod that lands on its flat end: the force is ρ c v A all the time."""
    (tmp_path / "rod.geo").write_text(ROD_MESH)
    (tmp_path / "rod.toml").write_text(ROD)
    return tmp_path / "rod.toml"


def test_sustained_over_two_steps(rod: Path) -> None:
    """In long steps the sustained peak is that of two of them, and says so."""
    done = signorini("simulate", rod, rod.parent / "out")
    touch = manifest(rod.parent / "out")["impact"]["all"]
    normal = table(rod.parent / "out" / "obstacles.csv")["normal_force"]
    assert touch["sustained_over"] == pytest.approx(2e-4, rel=0, abs=1e-15)
    assert touch["sustained_peak"] == pytest.approx(((normal[1:] + normal[:-1]) / 2).max(), rel=0, abs=1e-9 * EXACT)
    assert "(largest mean over 0.0002 s)" in done.stdout and "if the force is smooth, the sustained peak converge" in done.stdout


@pytest.mark.parametrize("size, step", ((0.02, 1e-5), (0.01, 5e-6)))
def test_front_of_a_wave(rod: Path, size: float, step: float) -> None:
    """In short steps it overshoots on all meshes."""
    signorini("simulate", rod, rod.parent / "out", mesh__size=size, time__step=step)
    assert manifest(rod.parent / "out")["impact"]["all"]["sustained_peak"] > 1.3 * EXACT


def test_sustained_peak_need_not_converge(rod: Path) -> None:
    """Neither the run nor a study calls it convergent."""
    said = signorini("study", rod, rod.parent / "study", output__fields=["von_mises"]).stdout
    (title,) = (line for line in said.splitlines() if line.startswith("sustained peak force"))
    assert title.endswith("this quantity need not converge")
    rows = said[said.index("order of") :].splitlines()
    assert any(line.startswith("largest_von_mises ") for line in rows)


def test_above_in_print(tmp_path: Path) -> None:
    """A strain above the limit by a part in 1e7 is not printed as the limit itself."""
    far = {"contact__obstacle": {"shape": "half-space", "point": [0, -9], "normal": [0, 1]}, "load__body": ["0", "0"], "time__end": 0.02}
    signorini("simulate", BLOCK, tmp_path, **far, initial__velocity=["0", "0"], initial__displacement=["0", "0.050000005*y"])
    assert float(warnings(tmp_path)["large strain"]["message"].split()[4]) > 0.05


def test_strain_of_facets(tmp_path: Path) -> None:
    """Of a disc that falls: its facets, pressed flat, have a strain that the cells around them and finer meshes do not have."""
    found = {}
    for size in (4, 1):
        signorini("simulate", SOURCE / "scenes" / "disc-drop.toml", tmp_path, mesh__size=size, time__end=12, material__young=2e4, output__fields=[])
        found[size] = warnings(tmp_path).get("large strain")
    assert found[1] is None and found[4]["value"] > 0.05
    mean = float(re.search(r"The mean over the cells around is (\S+)\.", found[4]["message"])[1])
    assert "facets of a coarse mesh" in found[4]["message"] and mean < 0.03


def test_strain_of_all_cells(tmp_path: Path) -> None:
    far = {"contact__obstacle": {"shape": "half-space", "point": [0, -9], "normal": [0, 1]}, "load__body": ["0", "0"], "time__end": 0.02}
    signorini("simulate", BLOCK, tmp_path, **far, initial__velocity=["0", "0"], initial__displacement=["0", "0.06*y"])
    assert "mean over the cells" not in warnings(tmp_path)["large strain"]["message"]


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scene(name: str, tmp_path: Path) -> None:
    signorini("simulate", SOURCE / "scenes" / f"{name}.toml", tmp_path, output__fields=[], **SHIPPED[name])
    found = warnings(tmp_path)
    print("; ".join(warning["message"] for warning in found.values()))
    assert set(found) <= OF_THE_MOTION


CRACKED = {"mesh__file": str(DATA / "cracked.geo"), "mesh__size": 0.2}
RANKS = pytest.mark.parametrize("before, after", ((1, 1), (2, 1), (1, 3)))


@RANKS
def test_crack_in_a_desired_run(before: int, after: int, tmp_path: Path) -> None:
    """Its nodes are found again by a run that desires an earlier one's motion."""
    control, earlier, out = {"control__initial": ["0.3*x", "-1"]}, tmp_path / "earlier", tmp_path / "out"
    signorini("simulate", BLOCK, earlier, before, **CRACKED, **control, output__fields=["displacement"])
    signorini("optimize", BLOCK, out, after, **CRACKED, **control, objective__desired={"run": str(earlier)}, optimizer__max_iterations=0,
              output__fields=["control"])  # fmt: skip
    assert table(out / "history.csv")["tracking"][0] < 1e-20, "the motion is not its own"


@RANKS
def test_crack_in_a_resumed_run(before: int, after: int, tmp_path: Path) -> None:
    """On one rank it is the one that was not interrupted."""
    whole, parted, options = tmp_path / "whole", tmp_path / "parted", {**CRACKED, "output__fields": []}
    signorini("optimize", BLOCK, whole, after, optimizer__max_iterations=4, **options)
    signorini("optimize", BLOCK, parted, before, optimizer__max_iterations=2, **options)
    command = ["mpirun", "--oversubscribe", "-n", str(after), str(SIGNORINI), "optimize", str(BLOCK), "--resume", "--out", str(parted)]
    for key, value in {**options, "optimizer__max_iterations": 4}.items():
        command += ["--set", f"{key.replace('__', '.')}={json.dumps(value)}"]
    subprocess.run(command, check=True, capture_output=True)
    a, b = table(whole / "history.csv")["objective"], table(parted / "history.csv")["objective"]
    assert len(a) == len(b) == 5 and abs(a[-1] / b[-1] - 1) < 1e-8


# A block of steel that is put down.
STEEL = {"material__density": 7800, "material__young": 2e11, "material__viscosity": {"bulk": 1e4, "shear": 1e4},
         "load__body": ["0", "-78000"], "initial__velocity": ["0", "0"],
         "contact__obstacle": {"shape": "half-space", "point": [0, 0], "normal": [0, 1]}}  # fmt: skip


@pytest.mark.parametrize("step", (1e-5, 2e-7, 1e-8))
def test_weight_of_a_stiff_body_in_short_steps(step: float, tmp_path: Path) -> None:
    """Contact from the first step on, and never weak."""
    signorini("simulate", BLOCK, tmp_path, **STEEL, time__step=step, time__end=20 * step, output__fields=[])
    steps = table(tmp_path / "steps.csv")
    assert (steps["active"][1:] == 5).all() and not steps["weak"].any()


def test_check_of_a_stiff_body_in_short_steps() -> None:
    done = attempt("check", BLOCK, None, **STEEL, time__step=2e-7, time__end=4e-6)
    assert "ok    contact occurred" in done.stdout and "20 steps, up to 5 candidates each, weak contact 0 times" in done.stdout


STABILIZED = {"time__scheme": "contact-stabilized", "contact__obstacle__normal": [0, 1]}


def test_check_at_rest() -> None:
    """A body that stands on the floor enters nothing without forces: contact is checked, and no projection is missed."""
    done = attempt("check", BLOCK, None, **STABILIZED, contact__obstacle__point=[0, 0], initial__velocity=["0", "0"])
    assert done.returncode == 0 and "FAIL" not in done.stdout and "predictor was projected" not in done.stdout
    assert "Verdict: the derivative is exact" in done.stdout and "ok    contact occurred                                          30 steps" in done.stdout


def test_check_in_flight() -> None:
    assert "ok    the predictor was projected" in attempt("check", BLOCK, None, **STABILIZED).stdout
