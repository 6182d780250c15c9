"""signorini study: what it prices, runs, keeps and refuses; orders where the solution is known. With a further argument, `ranks`,
what it does on two."""

import json
import re
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SIGNORINI, SOURCE, captured, signorini, table  # noqa: E402

import numpy as np  # noqa: E402

DATA = SOURCE / "tests" / "data"
WAVE = SOURCE / "scenes" / "standing-wave.toml"
IMPACT = SOURCE / "scenes" / "bar-impact.toml"
BOUNCE = SOURCE / "scenes" / "bouncing-bar.toml"
PRESS = SOURCE / "scenes" / "hertz-press.toml"
SCHEMES = (("contact-implicit", "consistent"), ("contact-stabilized", "consistent"), ("contact-implicit", "massless"))


def study(scene: Path, out: Path | None, *options: object, ranks: int = 1, status: int = 0) -> subprocess.CompletedProcess:
    command = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    command += [str(SIGNORINI), "study", str(scene), *(["--out", str(out)] if out else []), *map(str, options)]
    done = captured(command, timeout=300)  # where none takes minutes
    assert done.returncode == status, done.stdout + done.stderr
    return done


def order(folder: Path, quantity: str, kind: str, degree: int = 1, scheme: str = "contact-implicit", mass: str = "consistent") -> float:
    found = [one for one in json.loads((folder / "study.json").read_text())["orders"]
             if (one["quantity"], one["degree"], one["scheme"], one["mass"]) == (quantity, degree, scheme, mass)]  # fmt: skip
    assert len(found) == 1, found
    print(f"{folder.name}: {quantity}, degree {degree}, {scheme}, {mass}: order {found[0][kind]:.2f} in {kind}, "
          f"{found[0]['scatter'][kind][0]:.2f} to {found[0]['scatter'][kind][1]:.2f}")
    return found[0][kind]


def orders(folder: Path) -> None:
    """Of functions of degree r: r + 1 in space, where waves do not spoil it with their dispersion 2, and 2 in time; fronts of
    an impact 2/3 of that (tests/verification/bar.py), of the contact-implicit scheme whose energy falls less."""
    study(WAVE, folder / "wave", "--degrees", "1,2", "--sizes", "2,1,0.5,0.25", "--steps", "0.0666667,0.0333333,0.01666667,0.00833333")
    for degree in (1, 2):
        assert abs(order(folder / "wave", "displacement", "time", degree) - 2) < 0.2
        assert abs(order(folder / "wave", "displacement", "both", degree) - 2) < 0.2
    assert abs(order(folder / "wave", "displacement", "space", 1) - 2) < 0.3
    assert order(folder / "wave", "displacement", "space", 2) > 2.5
    study(IMPACT, folder / "impact", "--schemes", "contact-implicit,contact-stabilized,massless", "--sizes", "0.5,0.25,0.125,0.0625",
          "--steps", "0.0166667,0.00833333,0.00416667,0.002083333", "--quantity", "displacement,impulse")  # fmt: skip
    for scheme, mass in SCHEMES:
        assert 0.4 < order(folder / "impact", "displacement", "both", 1, scheme, mass) < 1.1
    errors = table(folder / "impact" / "study.csv")["displacement_error"]
    assert min(errors) < 0.02 < max(errors)
    study(BOUNCE, folder / "bounce", "--schemes", "contact-implicit,contact-stabilized,massless", "--sizes", "0.5,0.25,0.125",
          "--set", "time.end=5.333333333333333", "--set", "time.step=0.005333333333333333", "--set", "exact.impulse=533.3333333333333",
          "--set", "exact.contact_time=1.3333333333333333", "--steps", "0.0166667,0.00833333,0.00416667", "--quantity", "displacement")  # fmt: skip
    for scheme, mass in SCHEMES:
        assert 0.4 < order(folder / "bounce", "displacement", "both", 1, scheme, mass) < 1.3
    # Hertz's solution is that of a half-plane: on this disc it holds to about (a/R)^2 = 0.7 %, and beyond nothing converges to it.
    # Pressures of either degree come within it; those of nodes that functions of degree 2 give no share of their face would not.
    study(PRESS, folder / "press", "--sizes", "16,4,1", "--steps", "0.1", "--degrees", "1,2", "--quantity", "pressure")
    rows = table(folder / "press" / "study.csv")
    for degree in (1, 2):
        there = rows["degree"] == degree
        errors = rows["pressure_error"][there]
        print(f"Hertz, degree {degree}: pressure off by", *(f"{100 * error:.2f} %" for error in errors))
        assert list(rows["size"][there]) == [16, 4, 1] and max(errors) > 0.04 and errors[-1] < 0.02


def columns(folder: Path) -> dict[str, np.ndarray]:
    """What a study found, but for what it took: rung by rung, cheapest first."""
    rows = table(folder / "study.csv")
    timed = {"rung", "seconds", "memory_bytes", *(name for name in rows if name.endswith("_pareto"))}
    order = np.lexsort((rows["steps"], rows["size"]))
    return {name: values[order] for name, values in rows.items() if name not in timed}


def same(a: Path, b: Path) -> bool:
    """To the last bit."""
    first, second = columns(a), columns(b)
    return first.keys() == second.keys() and all(np.array_equal(first[name], second[name], equal_nan=first[name].dtype.kind == "f")
                                                 for name in first)  # fmt: skip


def ladder(folder: Path) -> None:
    """Prices of all rungs; a budget stops, what is there is kept whatever the budget, and a damaged rung runs again."""
    sizes = ("--sizes", "4,2,1,0.7")
    choice = (*sizes, "--steps", "2.5e-4,1.25e-4,1e-4,7.5e-5,5e-5,3.75e-5", "--quantity", "J")
    priced = study(HALF_DISC, None, *choice, "--dry-run").stdout
    assert "all 24: about" in priced and priced.count("size") == 24
    out = folder / "ladder"
    none = study(HALF_DISC, out, *choice, "--budget", "1e-9s").stdout
    assert "no rung has run: nothing is written" in none and not (out / "study.csv").exists()
    study(HALF_DISC, out, *sizes, "--steps", "2.5e-4", "--quantity", "J")
    stopped = study(HALF_DISC, out, *choice, "--budget", "1e-9s").stdout
    assert "4 of 24 rungs were there already" in stopped and "the budget ends before rung" in stopped
    some = table(out / "study.csv")
    assert set(some["size"]) == {4, 2, 1, 0.7} and list(some["steps"]) == [30] * 4
    (out / "rungs" / "size-4-steps-30-degree-1-contact-implicit.cbor").write_bytes(b"damaged")
    resumed = study(HALF_DISC, out, *choice, "--budget", "100h").stdout
    assert "3 of 24 rungs were there already" in resumed
    assert re.search(r"^rung \d+ of 24 runs again: its file is damaged", resumed, re.MULTILINE) and resumed.count("runs again") == 1
    rows = table(out / "study.csv")
    assert len(rows["rung"]) == 24 and np.isfinite(rows["J"]).all() and sum(np.isnan(rows["J_error"])) == 1
    before = (out / "study.csv").read_bytes()
    again = study(HALF_DISC, out, *choice).stdout
    assert "24 of 24 rungs were there already" in again and "rung 1 of 24: size" not in again
    assert (out / "study.csv").read_bytes() == before
    for s, e, front in zip(rows["seconds"], rows["J_error"], rows["J_pareto"]):
        beaten = np.isnan(e) or bool(((rows["seconds"] < s) & (rows["J_error"] <= e)).any())
        assert front == (not beaten)
    effectivity = rows["J_effectivity"][np.isfinite(rows["J_effectivity"])]
    print(f"effectivity of {len(effectivity)} estimates of J's error: {min(effectivity):.2f} to {max(effectivity):.2f}")
    assert len(effectivity) > 10 and 0.5 < np.median(effectivity) < 2


BLOCK = (DATA / "block.toml").read_text().replace("end = 0.6", "end = 0.2")
BLOCK_LADDER = ("--sizes", "0.5,0.3", "--steps", "0.02", "--quantity", "J,displacement,impulse")


def kept(folder: Path) -> None:
    """A rung is kept as long as nothing that its numbers depend on has changed; else the study is one that starts anew."""
    square = (DATA / "square.geo").read_text()
    files = {"block.toml": BLOCK, "square.geo": square}
    including = {"square.geo": 'Include "corner.inc";\n' + square.replace("{1, 1, 0}", "{1, 1 + c, 0}"), "corner.inc": "c = 0;"}
    # What there is, what changes, and what is said.
    changes = {
        "the scene's own size, from which points to compare at come": ({}, {"block.toml": BLOCK.replace("size = 0.25", "size = 0.15")}, "points"),
        "the material": ({}, {"block.toml": BLOCK.replace("young = 50.0", "young = 40.0")}, "material.young = 40"),
        "where J is looked at": ({}, {"block.toml": BLOCK + '[check]\ncontrol = ["0", "-1.5"]\n'}, "check.control"),
        "the .geo": ({}, {"square.geo": square.replace("{1, 1, 0}", "{1, 1.2, 0}")}, "mesh file"),
        "a file that the .geo includes": (including, {"corner.inc": "c = 0.1;"}, "mesh file"),
    }  # fmt: skip
    place = folder / "kept"
    place.mkdir()
    scene = place / "block.toml"

    def write(some: dict[str, str]) -> None:
        for name, text in some.items():
            (place / name).write_text(text)

    for i, (what, (before, change, words)) in enumerate(changes.items()):
        out = place / f"out-{i}"
        write(files | before)
        study(scene, out, *BLOCK_LADDER)
        assert (table(out / "study.csv")["impulse"] > 0).all(), "no contact: the case says nothing"
        first = columns(out)
        unchanged = study(scene, out, *BLOCK_LADDER, "--set", "output.every=3", "--set", "optimizer.tolerance=1e-3").stdout
        assert "2 of 2 rungs were there already" in unchanged and "runs again" not in unchanged
        write(change)
        said = study(scene, out, *BLOCK_LADDER).stdout
        assert said.count("runs again: ") == 2 and said.count(words) >= 2, f"{what}: {said}"
        study(scene, place / f"fresh-{i}", *BLOCK_LADDER)
        assert same(out, place / f"fresh-{i}"), what
        now = columns(out)
        assert not all(np.array_equal(first[name], now[name], equal_nan=True) for name in ("J_error", "displacement_error")), what
    # A desired motion that another run has left, in the same folder.
    write(files)
    scene.write_text(BLOCK.replace('desired = { control = ["0.3", "-1"] }', 'desired = { run = "run" }'))
    one_size = ("--sizes", "0.25", "--steps", "0.02,0.01", "--quantity", "J")
    for i, young in enumerate((50.0, 40.0)):
        (place / "free.toml").write_text(BLOCK)
        signorini("simulate", place / "free.toml", place / "run", material__young=young)
        said = study(scene, place / "desired", *one_size).stdout
        assert said.count("objective.desired.run names is another") == 2 * i, said
        study(scene, place / f"desired-{i}", *one_size)
        assert same(place / "desired", place / f"desired-{i}")
    print(f"kept: {len(changes) + 1} changes, each of which ran every rung again")


def interrupted(folder: Path) -> None:
    """A study that was stopped goes on to what one that was not finds; what is finer and there already is what errors are against."""
    choice = ("--sizes", "2,1,0.25", "--steps", "1e-4,2.5e-6", "--quantity", "J")
    out = folder / "interrupted"
    process = subprocess.Popen([str(SIGNORINI), "study", str(HALF_DISC), "--out", str(out), *choice], stdout=subprocess.PIPE, text=True)
    for line in process.stdout:
        if line.startswith("rung 2 of 6: "):
            break
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=300)
    assert process.returncode == 130
    some = len(table(out / "study.csv")["rung"])
    assert 2 <= some < 6
    choice = ("--sizes", "2,1", "--steps", "1e-4,5e-5", "--quantity", "J")  # what is left would take longer than a test should
    study(HALF_DISC, out, *choice)
    study(HALF_DISC, folder / "whole", *choice)
    assert same(out, folder / "whole")
    coarse = sorted((out / "rungs").glob("size-2-steps-75-*"))
    assert len(coarse) == 1
    coarse[0].unlink()
    study(HALF_DISC, out, *choice, "--budget", "1e-9s")  # does not run it again
    left, whole = columns(out), columns(folder / "whole")
    assert len(left["J"]) == 3 and set(left["J_error"][np.isfinite(left["J_error"])]) <= set(whole["J_error"])
    print(f"interrupted after {some} of 6 rungs")


PATCH = """
[mesh]
file = "{mesh}"
size = {size}
[time]
end = 10.0
step = 0.02
[material]
density = 1.0
young = 50.0
poisson = 0.0
viscosity = {{ bulk = 1.6666666666666667, shear = 2.5 }}   # the elastic moduli times 0.1 s
[[clamp]]
on = "top"
value = {value}
[contact]
on = "bottom"
obstacle = {{ shape = "half-space", point = {point}, normal = {normal} }}
[exact]
pressure = "2.5"   # 50 N/m2 times 0.1 m - 0.05 m over a height of 1 m
"""


def pressure(folder: Path, ranks: int = 1) -> None:
    """Uniform strain is in the space of every mesh, and so a uniform pressure must come out on each, of both degrees. The slowest
    motion, a quarter wave of shear, dies as exp(-3.1/s t) and leaves 1e-12 of it; see tests/verification/hard/discs.py."""
    moved = '"t < 1 ? -0.1 * sin(pi*t/2)^2 : -0.1"'
    for name, mesh, zeros in (("plane", "square.geo", 1), ("space", "cube.geo", 2)):
        scene = folder / f"patch-{name}.toml"
        zero = ", ".join(['"0"'] * zeros)
        scene.write_text(PATCH.format(mesh=DATA / mesh, size=0.5, value=f"[{zero}, {moved}]", point=[0] * zeros + [-0.05],
                                      normal=[0] * zeros + [1]))  # fmt: skip
        out = folder / f"patch-{name}-{ranks}"
        study(scene, out, "--sizes", "0.5", "--steps", "0.02", "--degrees", "1,2", "--quantity", "pressure", ranks=ranks)
        rows = table(out / "study.csv")
        print(f"uniform pressure, {name}, {ranks} ranks: off by", *(f"{error:.0e}" for error in rows["pressure_error"]))
        assert sorted(rows["degree"]) == [1, 2] and max(rows["pressure_error"]) < 1e-10  # 500 steps, each to about 1e-14 of the stiffest


def memory(folder: Path) -> None:
    """More steps than any machine has memory for the states of, in one sentence and before it is asked for."""
    of_study = ("--sizes", "0.5", "--steps", "7.5e-11")
    for verb, options in (("optimize", ()), ("check", ()), ("study", of_study)):
        done = captured([str(SIGNORINI), verb, str(HALF_DISC), "--out", str(folder / "many"), "--set", "time.step=7.5e-11", *options],
                        timeout=300)  # fmt: skip
        lines = done.stderr.splitlines()
        assert done.returncode == 2 and len(lines) == 1 and "time.step: found 7.5e-11 s" in lines[0] and "GB" in lines[0], done.stderr


def ranks(folder: Path) -> None:
    """The same figures on two; where there are rungs of another number of ranks, they run again."""
    choice = ("--sizes", "2,1", "--steps", "1e-4,5e-5", "--quantity", "J,displacement,gradient,impulse")
    for n in (1, 2):
        study(HALF_DISC, folder / f"ranks-{n}", *choice, ranks=n)
    one, two = (table(folder / f"ranks-{n}" / "study.csv") for n in (1, 2))
    key = lambda rows: np.lexsort((rows["steps"], rows["size"]))  # noqa: E731 (prices, and with them the order, are timed)
    for name in ("J", "J_error", "J_estimate", "displacement_error", "gradient_error", "impulse"):
        a, b = one[name][key(one)], two[name][key(two)]
        # Differences of numbers that agree to 1e-12 or so.
        assert np.allclose(a, b, rtol=1e-6, atol=1e-9, equal_nan=True), (name, a, b)
    again = study(HALF_DISC, folder / "ranks-1", *choice, ranks=2).stdout
    assert again.count('the number of ranks was "1" and is "2"') == 4, again


def suggestion(folder: Path) -> None:
    """The tolerance is met by the moduli of the estimate's parts and in truth, beside a run with a quarter of the size and of the step,
    whose error is a sixteenth of that."""
    tolerance = 1e-2
    said = study(HALF_DISC, None, "--suggest", tolerance, "--set", "mesh.size=3", "--set", "time.step=2.5e-4").stdout
    # Parts of opposite sign make up for each other by chance.
    tried = re.findall(r"estimated error at most (\S+) \(space (\S+), time (\S+)\)", said)
    assert len(tried) >= 2 and any(float(space) * float(time) < 0 for _, space, time in tried), said
    for error, *parts in tried:
        assert abs(float(error) - sum(abs(float(part)) for part in parts)) < 0.02 * float(error), said
    number = r"([\d.e+-]+)"
    found = re.search(rf"0\.01 in J is met by: size {number}, step {number}, degree 1, by the moduli of their own estimate's parts {number}", said)
    assert found, said
    size, step, estimate = map(float, found.groups())
    assert estimate <= tolerance
    study(HALF_DISC, folder / "truth", "--sizes", f"{size},{size / 4}", "--steps", f"{step},{step / 4}", "--quantity", "J")
    rows = table(folder / "truth" / "study.csv")
    here = (rows["size"] == size) & (rows["steps"] == min(rows["steps"]))
    assert sum(here) == 1 and sum(np.isnan(rows["J_error"])) == 1
    error = rows["J_error"][here][0]
    print(f"suggested size {size:g}, step {step:g} s: error {error:.1e}, by its estimate at most {estimate:.1e}")
    assert error <= tolerance and error <= 2 * estimate
    beyond = study(HALF_DISC, None, "--suggest", "1e-9", "--budget", "1e-9s", "--set", "mesh.size=3", status=1).stdout
    assert "beyond the budget" in beyond and "not met" in beyond


def own_density(folder: Path, ranks: int = 1) -> None:
    """A .geo that sets its own density runs; where sizes matter it is refused, and nothing goes on for ever."""
    text = (DATA / "block.toml").read_text().replace("end = 0.6", "end = 0.04")
    text = text.replace('"square.geo"', json.dumps(str(DATA / "fixed-density.geo")))
    cells = 2 * 70**2  # more points to sample at than are wanted: coarser meshes are looked for
    fixed, scaled = folder / "fixed.toml", folder / "scaled.toml"
    fixed.write_text(text)
    scaled.write_text(text.replace("size = 0.25\n", ""))
    for scene, kind in ((fixed, "size"), (scaled, "scale")):
        for options in ((), ("--dry-run",), ("--sizes", "0.5,0.125"), ("--suggest", "1e-2")):
            refused = study(scene, folder / "refused", *options, ranks=ranks, status=2)
            said = [line for line in refused.stderr.splitlines() if line.startswith("signorini: ")]
            assert len(said) == 1 and f"mesh.{kind}: " in said[0] and f"has {cells} cells" in said[0], refused.stderr
            assert "Transfinite" in said[0] and "allowed are" in said[0] and not (folder / "refused").exists()
    done = signorini("simulate", fixed, folder / "fixed", ranks)
    assert json.loads((folder / "fixed/run.json").read_text())["cells"] == cells, done.stdout
    study(fixed, folder / "one-size", "--sizes", "0.25", "--steps", "0.02,0.01", "--quantity", "J", ranks=ranks)
    rows = table(folder / "one-size/study.csv")
    assert list(rows["steps"]) == [2, 4] and rows["unknowns"][0] == rows["unknowns"][1] == 2 * 71**2
    print("a .geo that sets its own density: run, studied in time, refused where sizes matter")


def refusals(folder: Path) -> None:
    for options, fragments in (
        (("--quantity", "impuls"), ("--quantity", "impuls", 'did you mean "impulse"?')),
        (("--quantity", "gradient"), ("--quantity", "gradient", "allowed with this scene")),
        (("--sizes", "0"), ("--sizes", "found 0")),
        (("--steps", "-1"), ("--steps", "found -1")),
        (("--steps", "1e-20"), ("--steps: found 1e-20 s", "allowed are 1 to 100000000")),
        (("--degrees", "3"), ("--degrees", "found 3", "1 and 2")),
        (("--schemes", "implicit"), ("--schemes", "found", "contact-implicit")),
        (("--budget", "soon"), ("--budget", "found soon", "10min")),
        (("--suggest", "1e-2"), ("--suggest", "objective")),
    ):
        refused = study(IMPACT, folder / "refused", *options, status=2)
        lines = refused.stderr.splitlines()
        assert len(lines) == 1 and all(fragment in lines[0] for fragment in fragments), refused.stderr
        assert not (folder / "refused").exists()


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if sys.argv[3:] == ["ranks"]:
            pressure(folder, 2)
            own_density(folder, 2)
            ranks(folder)
            return 0
        for part in (orders, pressure, ladder, kept, interrupted, suggestion, own_density, memory, refusals):
            part(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
