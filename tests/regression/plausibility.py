# SPDX-License-Identifier: GPL-3.0-or-later
"""What makes results mean less than they seem to is said once, in run.json and on the page; scenes that are what the model is for
have nothing of it. A mesh with nodes at one place is a mesh like others. Short steps and a stiff body's weight are contact.
"""

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SIGNORINI, SOURCE, attempt, signorini, table  # noqa: E402
from soft_scenes import soft  # noqa: E402

import numpy as np  # noqa: E402

DATA = SOURCE / "tests" / "data"
BLOCK = DATA / "block.toml"
GENTLE = {"contact__mass": "massless", "initial__velocity": ["0", "-0.01"], "load__body": ["0", "-0.1"],
          "contact__obstacle": {"shape": "half-space", "point": [0, -1e-3], "normal": [0, 1]}}  # fmt: skip
# Coarse and short. What is told of them is true: the bar meets a wall at a third of its waves' speed, the disc that is caught is
# soft. All are one body, held and touched where they should be.
SHIPPED = {"bar-impact": {"time__end": 1.5}, "standing-wave": {}, "catch": {}, "hertz-press": {"time__step": 0.5}, "half-disc": {"mesh__size": 2}}
OF_THE_MOTION = {"large strain", "large rotation", "linearised gap"}


def warnings(out: Path) -> dict[str, dict]:
    found = json.loads((out / "run.json").read_text())["warnings"]
    names = {warning["name"]: warning for warning in found}
    assert len(names) == len(found), "one is said twice"
    for warning in found:
        assert warning["value"] > warning["limit"] and warning["message"], warning
    return names


def are_told(folder: Path) -> None:
    for ranks in (1, 2):
        done = signorini("simulate", BLOCK, folder / "gentle", ranks, **GENTLE)
        assert not warnings(folder / "gentle") and "warning" not in done.stdout
        out = folder / "apart"
        done = signorini("simulate", BLOCK, out, ranks, **GENTLE, mesh__file=str(DATA / "apart.geo"))
        found = warnings(out)
        assert set(found) == {"parts of the mesh"} and found["parts of the mesh"]["value"] == 2, found
        message = found["parts of the mesh"]["message"]
        assert done.stdout.count(f"warning: {message}") == 1, done.stdout
    subprocess.run([sys.executable, str(SOURCE / "postprocess" / "report.py"), str(out)], check=True, capture_output=True)
    assert message in (out / "report.html").read_text()
    signorini("optimize", BLOCK, out, **GENTLE, mesh__file=str(DATA / "apart.geo"), optimizer__max_iterations=1,
              output__tables=[], output__fields=[])  # fmt: skip
    assert "parts of the mesh" in warnings(out)


def first_exceeded(folder: Path) -> None:
    """A body that spins freely turns by ω t in the linear model, and by 5 degrees at 0.218 s: the look after that is at 0.25 s."""
    scene = folder / "spinning.toml"
    scene.write_text(soft("square.geo", 0.5, 1.0, 0.0625) + '[initial]\nvelocity = ["-0.4*y", "0.4*x"]\n')
    signorini("simulate", scene, folder / "spinning")
    found = warnings(folder / "spinning")
    assert abs(found["large rotation"]["value"] - np.degrees(0.4)) < 1e-9, found
    assert "(first exceeded by t = 0.25 s)" in found["large rotation"]["message"], found


CANTILEVER = """
Point(1) = {0, 0, 0, 0.01}; Point(2) = {0.28, 0, 0, 0.01}; Point(3) = {0.3, 0, 0, 0.01};
Point(4) = {0.3, 0.02, 0, 0.01}; Point(5) = {0, 0.02, 0, 0.01};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 1};
Curve Loop(1) = {1:5}; Plane Surface(1) = {1};
Physical Curve("tip") = {2}; Physical Curve("root") = {5}; Physical Surface("body") = {1};
"""


def energy_lost(folder: Path) -> None:
    """A steel cantilever swings against a stop under its tip, in steps of 20 µs, in which a wave goes through twenty elements: contact takes
    a fifth of the energy. It falls with the step, as is told, to the 1 µs that a wave takes through an element."""
    scene, out = folder / "stop.toml", folder / "stop"
    (folder / "stop.geo").write_text(CANTILEVER)
    scene.write_text("""
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
""")

    def lost(**overrides: object) -> tuple[float, str]:
        signorini("simulate", scene, out, **overrides)
        steps = table(out / "steps.csv")
        assert (steps["contact_force_y"] > 0).sum() > 3, "hardly any contact: the case says nothing"
        part = -steps["contact_work"].sum() / (steps["kinetic_energy"] + steps["elastic_energy"]).max()
        told = warnings(out).get("energy lost in contact")
        assert (told is not None) == (part > 0.03) and (not told or abs(told["value"] / part - 1) < 1e-9), (part, told)
        return part, told["message"] if told else ""

    for scheme in ("contact-implicit", "contact-stabilized"):
        part, told = lost(time__scheme=scheme)
        step = float(re.search(r"falls with the step \(time.step\) down to (\S+) s", told)[1])
        least, _ = lost(time__scheme=scheme, time__step=1e-3 / round(1e-3 / step))
        print(f"{scheme}: contact takes {part:.3f} of the energy with steps of 20 µs, {least:.3f} with {step:g} s")
        assert part > 0.1 and abs(step / 1e-6 - 1) < 0.1 and least < part / 3
    part, told = lost(time__step=5e-7, contact__mass="massless")
    print(f"massless, 0.5 µs: {part:.3f}")
    assert part < 0.03 and not told
    lost_to_a_moving_stop = {"shape": "half-space", "point": [0, "-1e-4 + 0*t"], "normal": [0, 1]}
    signorini("simulate", scene, out, contact__obstacle=lost_to_a_moving_stop)
    assert "energy lost in contact" not in warnings(out)


ANGLE = """
h = 0.1;
Point(1) = {0, 0, 0, h}; Point(2) = {1, 0, 0, h}; Point(3) = {1, 0.4, 0, h}; Point(4) = {0.4, 0.4, 0, h};
Point(5) = {0.4, 1, 0, h}; Point(6) = {0, 1, 0, h};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 6}; Line(6) = {6, 1};
Curve Loop(1) = {1:6}; Plane Surface(1) = {1};
Physical Curve("foot") = {1}; Physical Curve("tip") = {2}; Physical Curve("head") = {5}; Physical Surface("body") = {1};
"""


def stress_at_a_corner(folder: Path) -> None:
    """An angle, held at its head and pulled at its tip: the stress at the corner that points into it, of 270 degrees, grows as the elements
    become smaller, r^(λ−1) with λ = 0.5445 (Williams 1952), and the warning names it. In a block under uniform pressure there is none."""
    (folder / "angle.geo").write_text(ANGLE)
    thick = ANGLE.replace('Physical Curve("foot") = {1}; Physical Curve("tip") = {2}; Physical Curve("head") = {5}; Physical Surface("body") = {1};',
                          'e[] = Extrude {0, 0, 0.3} { Surface{1}; };\nPhysical Volume("body") = {e[1]}; Physical Surface("tip") = {e[3]}; '
                          'Physical Surface("head") = {e[6]};')  # fmt: skip
    (folder / "thick.geo").write_text(thick)
    for dim, sizes in ((2, (0.1, 0.05, 0.025)), (3, (0.15,))):
        scene, out = folder / "angle.toml", folder / "angle"
        across = ["0", "-1"] + ["0"] * (dim - 2)
        scene.write_text(soft("square.geo", 0.1, 1.0, 0.1).replace(str(DATA / "square.geo"), str(folder / ("angle.geo" if dim == 2 else "thick.geo")))
                         + f'[[clamp]]\non = "head"\n[[load.traction]]\non = "tip"\nvalue = {json.dumps(across)}\n'
                         + '[output]\nfields = ["stress", "von_mises"]\nevery = 1\n')  # fmt: skip
        largest = []
        for size in sizes:
            for degree, ranks in ((1, 1), (1, 2), (2, 1)) if size == sizes[0] else ((1, 1),):
                signorini("simulate", scene, out, ranks, mesh__size=size, mesh__degree=degree)
                found = json.loads((out / "run.json").read_text())["largest_von_mises"]
                told = warnings(out)["stress of the mesh"]
                assert abs(told["value"] / (found["value"] / found["recovered"]) - 1) < 1e-12 and told["limit"] == 1.3
                assert "at the corner (0.4, 0.4" in told["message"] and "around which 0.75 of the full angle" in told["message"], told
                if (degree, ranks) == (1, 1):
                    largest.append(found["value"])
                elif degree == 1:
                    assert abs(found["value"] / largest[-1] - 1) < 1e-9, "on two ranks it is another"
        print(f"{dim} dimensions: largest von Mises stress {', '.join(f'{value:.3g}' for value in largest)} Pa with elements of {sizes} m")
        assert all(1.25 < fine / coarse < 1.5 for coarse, fine in zip(largest, largest[1:], strict=False)), largest
    signorini("simulate", BLOCK, folder / "even", **GENTLE, output__fields=["von_mises"])
    found = json.loads((folder / "even" / "run.json").read_text())["largest_von_mises"]
    assert found["value"] > 0 and "stress of the mesh" not in warnings(folder / "even")


ROD = """Point(1) = {0, 0, 0}; Point(2) = {0.02, 0, 0}; Point(3) = {0.02, 0.4, 0}; Point(4) = {0, 0.4, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1:4}; Plane Surface(1) = {1};
Physical Surface("body") = {1}; Physical Curve("tip") = {1}; Physical Curve("boundary") = {1:4};
"""
RIM = """Point(1) = {0, 0, 0}; Point(2) = {0.1, 0, 0}; Point(3) = {0, 0.1, 0}; Point(4) = {-0.1, 0, 0}; Point(5) = {0, -0.1, 0};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Circle(3) = {4, 1, 5}; Circle(4) = {5, 1, 2};
Point(12) = {0.08, 0, 0}; Point(13) = {0, 0.08, 0}; Point(14) = {-0.08, 0, 0}; Point(15) = {0, -0.08, 0};
Circle(11) = {12, 1, 13}; Circle(12) = {13, 1, 14}; Circle(13) = {14, 1, 15}; Circle(14) = {15, 1, 12};
Curve Loop(1) = {1:4}; Curve Loop(2) = {11:14}; Plane Surface(1) = {1, 2};
Physical Surface("body") = {1}; Physical Curve("boundary") = {1:4};
"""


def stress_under_one_node(folder: Path) -> None:
    """Where one node takes all of the contact force, the warning names that node, and not another one of the cell."""
    (folder / "rim.geo").write_text(RIM)
    scene, out = folder / "rim.toml", folder / "rim"
    scene.write_text(f"""[mesh]
file = "{folder / "rim.geo"}"
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
obstacle = {{ shape = "ball", center = [0, -0.1501], radius = 0.05 }}
[initial]
velocity = ["0", "-1"]
[output]
fields = ["von_mises"]
every = 1
""")
    signorini("simulate", scene, out)
    found, steps = warnings(out), table(out / "contact.csv")
    pushed = steps["force"] > 0
    nodes = set(zip(steps["x"][pushed], steps["y"][pushed]))
    assert len(nodes) == 1 and "stress of the mesh" in found, (nodes, found)
    x, y = map(float, re.search(r"smaller elements at \((\S+), (\S+)\) m", found["stress of the mesh"]["message"]).groups())
    assert np.allclose([x, y], nodes.pop(), rtol=0, atol=1e-6), (x, y, steps["x"][pushed])


def sustained_over_two_steps(folder: Path) -> None:
    """A rod that lands on its flat end: the force is ρ c v A all the time. In long steps the sustained peak is that of two of them, and
    says so; in short ones the front of the wave overshoots on all meshes, and neither the run nor a study calls it convergent."""
    (folder / "rod.geo").write_text(ROD)
    scene, out = folder / "rod.toml", folder / "rod"
    scene.write_text(f"""[mesh]
file = "{folder / "rod.geo"}"
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
obstacle = {{ shape = "half-space", point = [0, -0.001], normal = [0, 1] }}
[initial]
velocity = ["0", "-1"]
""")
    exact = 1000 * np.sqrt(1e8 / 1000) * 0.02
    done = signorini("simulate", scene, out)
    touch = json.loads((out / "run.json").read_text())["impact"]["all"]
    normal = table(out / "obstacles.csv")["normal_force"]
    assert abs(touch["sustained_over"] - 2e-4) < 1e-15, touch
    assert abs(touch["sustained_peak"] - ((normal[1:] + normal[:-1]) / 2).max()) < 1e-9 * exact, touch
    assert "the largest mean over 0.0002 s" in done.stdout and "if the force is smooth, its sustained peak converge" in done.stdout, done.stdout
    for size, step in ((0.02, 1e-5), (0.01, 5e-6)):
        signorini("simulate", scene, out, mesh__size=size, time__step=step)
        touch = json.loads((out / "run.json").read_text())["impact"]["all"]
        assert touch["sustained_peak"] > 1.3 * exact, (touch, exact)
    said = signorini("study", scene, folder / "rods", mesh__size=0.02, time__step=1e-4, output__fields=["von_mises"]).stdout
    titles = [line for line in said.splitlines() if line.startswith("sustained peak force")]
    assert len(titles) == 1 and titles[0].endswith("it need not converge"), said
    rows = said[said.index("order of") :].splitlines()
    assert any(line.startswith("largest_von_mises ") for line in rows), said


def is_above_in_print(folder: Path) -> None:
    """A strain above the limit by a part in 1e7 is not told as the limit itself."""
    far = {"contact__obstacle": {"shape": "half-space", "point": [0, -9], "normal": [0, 1]}, "load__body": ["0", "0"]}
    signorini("simulate", BLOCK, folder / "strained", **far, initial__velocity=["0", "0"], initial__displacement=["0", "0.050000005*y"], time__end=0.02)
    message = warnings(folder / "strained")["large strain"]["message"]
    assert float(message.split()[4]) > 0.05, message


def shipped_scenes(folder: Path) -> None:
    for name, overrides in SHIPPED.items():
        signorini("simulate", SOURCE / "scenes" / f"{name}.toml", folder / name, output__fields=[], **overrides)
        found = warnings(folder / name)
        print(f"{name}: {'; '.join(warning['message'] for warning in found.values()) or 'nothing to tell'}")
        assert set(found) <= OF_THE_MOTION, found


def nodes_at_one_place(folder: Path) -> None:
    """A crack: its nodes are found again by a run that desires an earlier one's motion, and by one that goes on."""
    mesh = {"mesh__file": str(DATA / "cracked.geo"), "mesh__size": 0.2}
    for before, after in ((1, 1), (2, 1), (1, 3)):
        signorini("simulate", BLOCK, folder / "earlier", before, **mesh, output__fields=["displacement"], control__initial=["0.3*x", "-1"])
        desired = {"objective__desired": {"run": str(folder / "earlier")}}
        out = folder / f"desired-{before}-{after}"
        options = {**mesh, **desired, "control__initial": ["0.3*x", "-1"], "output__fields": ["control"]}
        signorini("optimize", BLOCK, out, after, optimizer__max_iterations=0, **options)
        assert table(out / "history.csv")["tracking"][0] < 1e-20, "the motion is not its own"
        # On one rank a run that is taken up again is the one that was not interrupted.
        whole, parted = folder / f"whole-{after}", folder / f"parted-{before}-{after}"
        options = {**mesh, "output__fields": []}
        signorini("optimize", BLOCK, whole, after, optimizer__max_iterations=4, **options)
        signorini("optimize", BLOCK, parted, before, optimizer__max_iterations=2, **options)
        command = ["mpirun", "--oversubscribe", "-n", str(after), str(SIGNORINI), "optimize", str(BLOCK), "--resume", "--out", str(parted)]
        for key, value in {**options, "optimizer__max_iterations": 4}.items():
            command += ["--set", f"{key.replace('__', '.')}={json.dumps(value)}"]
        subprocess.run(command, check=True, capture_output=True)
        a, b = table(whole / "history.csv")["objective"], table(parted / "history.csv")["objective"]
        assert len(a) == len(b) == 5 and abs(a[-1] / b[-1] - 1) < 1e-8, (a, b)


def weight_of_a_stiff_body_in_short_steps(folder: Path) -> None:
    """A block of steel that is put down: contact from the first step on, and never weak."""
    steel = {"material__density": 7800, "material__young": 2e11, "material__viscosity": {"bulk": 1e4, "shear": 1e4},
             "load__body": ["0", "-78000"], "initial__velocity": ["0", "0"],
             "contact__obstacle": {"shape": "half-space", "point": [0, 0], "normal": [0, 1]}}  # fmt: skip
    for step in (1e-5, 2e-7, 1e-8):
        signorini("simulate", BLOCK, folder / "steel", **steel, time__step=step, time__end=20 * step, output__fields=[])
        steps = table(folder / "steel" / "steps.csv")
        assert (steps["active"][1:] == 5).all() and not steps["weak"].any(), steps
    done = attempt("check", BLOCK, None, **steel, time__step=2e-7, time__end=4e-6)
    assert "ok    contact occurred" in done.stdout and "20 steps, at most 5 nodes, 0 weak" in done.stdout, done.stdout


def rest_is_checked() -> None:
    """A body that stands on the floor enters nothing without forces: contact is checked, and no projection is missed. In flight one is."""
    steps = {"time__scheme": "contact-stabilized", "contact__obstacle__normal": [0, 1]}
    resting = {**steps, "contact__obstacle__point": [0, 0], "initial__velocity": ["0", "0"]}
    done = attempt("check", BLOCK, None, **resting)
    assert done.returncode == 0 and "FAIL" not in done.stdout and "predictor was projected" not in done.stdout, done.stdout
    assert "Verdict: exact" in done.stdout and "ok    contact occurred                                          30 steps" in done.stdout, done.stdout
    done = attempt("check", BLOCK, None, **steps)
    assert "ok    the predictor was projected" in done.stdout, done.stdout


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        weight_of_a_stiff_body_in_short_steps(Path(folder))
        rest_is_checked()
        are_told(Path(folder))
        first_exceeded(Path(folder))
        energy_lost(Path(folder))
        stress_at_a_corner(Path(folder))
        stress_under_one_node(Path(folder))
        sustained_over_two_steps(Path(folder))
        is_above_in_print(Path(folder))
        nodes_at_one_place(Path(folder))
        shipped_scenes(Path(folder))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
