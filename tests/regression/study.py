# SPDX-License-Identifier: GPL-3.0-or-later
"""signorini study: what it prices, runs, keeps and refuses; with a further argument, `ranks`, what it does on two. How accurate its
rungs are: study_accuracy.py."""

import json
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SIGNORINI, SOURCE, captured, signorini, table  # noqa: E402
from soft_scenes import ONTO_A_SLOPE, soft  # noqa: E402
from studies import DATA, IMPACT, pressure, study  # noqa: E402

import numpy as np  # noqa: E402

RING = SOURCE / "scenes" / "drop-ring.toml"


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
    # Of the coarsest and a finer size it counted them; from size to size they grow by a power.
    expected = re.findall(r"^ +\d+ +(\d+) .* size ([\d.]+), step ([\d.e-]+),", priced, re.MULTILINE)
    found = {(size, round(7.5e-3 / steps, 9)): unknowns for size, steps, unknowns in zip(rows["size"], rows["steps"], rows["unknowns"])}
    off = [float(count) / found[float(size), float(step)] - 1 for count, size, step in expected]
    assert len(off) == 24 and np.max(np.abs(off)) < 0.15 and sum(one == 0 for one in off) >= 12, expected
    before = (out / "study.csv").read_bytes()
    again = study(HALF_DISC, out, *choice).stdout
    assert "24 of 24 rungs were there already" in again and "rung 1 of 24: size" not in again
    assert (out / "study.csv").read_bytes() == before
    for size, steps, envelope in zip(rows["size"], rows["steps"], rows["J_envelope"]):
        finer = rows["J_error"][(rows["size"] <= size) & (rows["steps"] >= steps)]
        assert np.isnan(finer).all() if np.isnan(envelope) else envelope == np.nanmax(finer)
    for s, e, front in zip(rows["seconds"], rows["J_envelope"], rows["J_pareto"]):
        beaten = np.isnan(e) or bool(((rows["seconds"] < s) & (rows["J_envelope"] <= e)).any())
        assert front == (not beaten)
    effectivity = rows["J_effectivity"][np.isfinite(rows["J_effectivity"])]
    print(f"effectivity of {len(effectivity)} estimates of J's error: {np.min(effectivity):.2f} to {np.max(effectivity):.2f}")
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
    # A motion that is cut short has no figures.
    cut = folder / "cut"
    process = subprocess.Popen([str(SIGNORINI), "study", str(IMPACT), "--out", str(cut), "--sizes", "0.5,0.05", "--steps", "0.01,5e-6", "--quantity", "impulse"],
                               stdout=subprocess.PIPE, text=True)  # fmt: skip
    for line in process.stdout:
        if line.startswith("rung 3 of 4: "):
            break
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=300)
    assert process.returncode == 130 and list(table(cut / "study.csv")["rung"]) == [1, 2, 3] and len(list((cut / "rungs").iterdir())) == 3
    print(f"interrupted after {some} of 6 rungs, and within one")


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
    choice = ("--sizes", "2,1", "--steps", "1e-4,5e-5", "--quantity", "J,displacement,gradient,impulse,contact_start,contact_time")
    for n in (1, 2):
        study(HALF_DISC, folder / f"ranks-{n}", *choice, ranks=n)
    one, two = (table(folder / f"ranks-{n}" / "study.csv") for n in (1, 2))
    key = lambda rows: np.lexsort((rows["steps"], rows["size"]))  # noqa: E731 (prices, and with them the order, are timed)
    assert (one["contact_time"] > 0).all(), "no contact: the case says nothing"
    for name in ("J", "J_error", "J_estimate", "J_envelope", "displacement_error", "gradient_error", "impulse", "contact_start", "contact_time"):
        a, b = one[name][key(one)], two[name][key(two)]
        # Differences of numbers that agree to 1e-12 or so.
        assert np.allclose(a, b, rtol=1e-6, atol=1e-9, equal_nan=True), (name, a, b)
    for n in (1, 2):
        study(HALF_DISC, folder / f"searches-{n}", *SEARCHES, "--search-tolerances", "1e-2", ranks=n)
    one, two = (table(folder / f"searches-{n}" / "search.csv") for n in (1, 2))
    assert one["forward_sweeps"] == two["forward_sweeps"] and np.allclose(one["J"], two["J"], rtol=1e-6, atol=0), (one["J"], two["J"])
    again = study(HALF_DISC, folder / "ranks-1", *choice, ranks=2).stdout
    assert again.count('the number of ranks was "1" and is "2"') == 4, again


SQUEEZED = """
[mesh]
file = "{mesh}"
size = 0.25
[time]
end = 0.4
step = 0.01
[material]
density = 1.0
young = 50.0
poisson = 0.3
viscosity = {{ bulk = 1.0, shear = 1.0 }}
[[contact]]
on = "bottom"
obstacle = {{ shape = "half-space", point = [{zeros} "0.1*t"], normal = [{zeros} 1] }}
[[contact]]
on = "top"
obstacle = {{ shape = "half-space", point = [{zeros} "1 - 0.1*t"], normal = [{zeros} -1] }}
"""


def obstacles(folder: Path) -> None:
    """Two jaws press a body from either side: what each does is told, in the units of the plane and of space, and it does not vanish in
    their sum, which is the difference of the two. Tables fit 80 columns."""
    for name, mesh, zeros, unit in (("plane", "square.geo", "0,", "N s/m"), ("space", "cube.geo", "0, 0,", "N s")):
        scene = folder / f"squeezed-{name}.toml"
        scene.write_text(SQUEEZED.format(mesh=DATA / mesh, zeros=zeros))
        out = folder / f"squeezed-{name}"
        said = study(scene, out, "--sizes", "0.5", "--steps", "0.02,0.01", "--degrees", "1").stdout
        rows = table(out / "study.csv")
        given = json.loads((out / "study.json").read_text())["quantities"]
        assert [given[f"impulse{end}"]["unit"] for end in ("", "_1", "_2")] == [unit] * 3 and given["peak_force_2"]["unit"] == unit.replace(" s", "")
        assert (rows["impulse_1"] > 10 * rows["impulse"]).all() and (rows["contact_time_1"] > 0.3).all()
        assert np.allclose(rows["impulse"], np.abs(rows["impulse_1"] - rows["impulse_2"]), rtol=0, atol=1e-12 * np.max(rows["impulse_1"]))
        assert f"impulse of contact, obstacle 2, {unit}: " in said
        wide = [line for line in said.splitlines() if len(line) > 80 and re.match(r"\s*(\d+ |rung )", line)]
        assert not [line for line in wide if " of " not in line], wide
        print(f"{name}: jaws push with {rows['impulse_1'][-1]:.4g} and {rows['impulse_2'][-1]:.4g} {unit}, in all {rows['impulse'][-1]:.1e}")


def chosen_steps(folder: Path) -> None:
    """Steps that the motion chooses beside those of one length: a free fall ends when it must, to more than in more steps."""
    out, touch = folder / "chosen", np.sqrt(2 * 0.2 / 9.81)  # s
    tolerances = (8e-2, 2e-2, 5e-3)
    choice = ("--sizes", "8e-3", "--tolerances", ",".join(map(str, tolerances)), "--steps", "5.6e-4,2.8e-4", "--quantity", "contact_start,contact_time")
    priced = study(RING, None, *choice, "--dry-run").stdout
    assert priced.count("tolerance") == 3 and priced.count(", step ") == 2, priced
    said = study(RING, out, *choice, "--set", f"exact.contact_start={touch}").stdout
    assert "steps chosen" in said, said
    rows = table(out / "study.csv")
    chosen = np.isfinite(rows["tolerance"])
    assert sorted(rows["tolerance"][chosen]) == sorted(tolerances) and np.max(rows["contact_time"]) > 0.03, "no contact occurred"
    for tolerance, error, steps in zip(rows["tolerance"][chosen], rows["contact_start_error"][chosen], rows["steps"][chosen]):
        print(f"tolerance {tolerance:g}: {steps:.0f} steps, start of contact off by {error:.1e}")
        assert error <= np.minimum(tolerance, np.min(rows["contact_start_error"][~chosen]))
    assert np.min(rows["steps"][chosen]) < np.min(rows["steps"][~chosen])
    again = study(RING, out, *choice, "--set", f"exact.contact_start={touch}").stdout
    assert "5 of 5 rungs were there already" in again, again
    reported = captured([sys.executable, SOURCE / "postprocess" / "report.py", out])
    assert reported.returncode == 0 and "steps chosen" in (out / "report.html").read_text(), reported.stderr
    # The scene's own tolerance, and four and sixteen times it; those of an objective too.
    block = study(DATA / "block.toml", None, "--sizes", "0.5", "--set", 'time={end=0.6, step="auto", tolerance=1e-2}', "--dry-run").stdout
    assert all(f"tolerance {t}" in block for t in ("0.01", "0.04", "0.16")), block
    with_J = study(DATA / "block.toml", folder / "chosen-J", "--sizes", "0.5", "--set", 'time={end=0.6, step="auto", tolerance=1e-3}',
                   "--quantity", "J,impulse").stdout  # fmt: skip
    values = table(folder / "chosen-J/study.csv")
    assert len(values["J"]) == 3 and np.max(values["impulse"]) > 0 and np.max(abs(values["J"] / values["J"][-1] - 1)) < 0.05, with_J
    done = captured([SIGNORINI, "simulate", RING, "--out", folder / "ordered", "--accuracy", "1e-2", "--quantity", "contact_start",
                     "--set", "mesh.size=8e-3"])  # fmt: skip
    assert done.returncode == 0 and "met; size" in done.stdout and ", tolerance " in done.stdout, done.stdout + done.stderr


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
            assert "Transfinite" in said[0] and "; use " in said[0] and not (folder / "refused").exists()
    done = signorini("simulate", fixed, folder / "fixed", ranks)
    assert json.loads((folder / "fixed/run.json").read_text())["cells"] == cells, done.stdout
    study(fixed, folder / "one-size", "--sizes", "0.25", "--steps", "0.02,0.01", "--quantity", "J", ranks=ranks)
    rows = table(folder / "one-size/study.csv")
    assert list(rows["steps"]) == [2, 4] and rows["unknowns"][0] == rows["unknowns"][1] == 2 * 71**2
    print("a .geo that sets its own density: run, studied in time, refused where sizes matter")


def stress(folder: Path) -> None:
    """The largest stress is that of a run that stores all steps, and in doubt where the mesh makes it; no other quantity is for that."""
    scene = folder / "thrown.toml"
    scene.write_text(soft("square.geo", 0.25, 0.4, 0.02) + ONTO_A_SLOPE)
    said = study(scene, folder / "stress", "--sizes", "0.5,0.25", "--steps", "0.02", "--quantity", "largest_von_mises,impulse").stdout
    rows = table(folder / "stress" / "study.csv")
    warnings = json.loads((folder / "stress" / "study.json").read_text())["warnings"]
    told = {warning["rung"] for warning in warnings if warning["name"] == "stress of the mesh"}
    assert told
    # What is alike is said once, of the finest rung.
    for name in {warning["name"] for warning in warnings}:
        alike = [warning for warning in warnings if warning["name"] == name]
        others = [str(warning["rung"]) for warning in alike[:-1]]
        likewise = f" (also rung{'s' * (len(others) > 1)} {', '.join(others)}: study.json)" if others else ""
        assert f"warning: rung {alike[-1]['rung']}: {alike[-1]['message']}{likewise}\n" in said, (alike, said)
    assert said.count("warning: rung") == len({warning["name"] for warning in warnings}) < len(warnings), said
    for rung, size, value, impulse in zip(rows["rung"], rows["size"], rows["largest_von_mises"], rows["impulse"]):
        signorini("simulate", scene, folder / "one", mesh__size=float(size), output__fields=["von_mises"], output__every=1)
        run = json.loads((folder / "one" / "run.json").read_text())
        assert impulse > 0 and value == run["largest_von_mises"]["value"], (value, run["largest_von_mises"])
        assert (rung in told) == any(warning["name"] == "stress of the mesh" for warning in run["warnings"]), told
    said = study(scene, folder / "unasked", "--sizes", "0.5,0.25", "--steps", "0.02").stdout
    assert "von Mises" not in said, "it was computed though nothing stores it"


def refusals(folder: Path) -> None:
    for options, fragments in (
        (("--quantity", "impuls"), ("--quantity", "impuls", 'did you mean "impulse"?')),
        (("--quantity", "gradient"), ("--quantity", "gradient", "this scene has")),
        (("--sizes", "0"), ("--sizes", "found 0")),
        (("--steps", "-1"), ("--steps", "found -1")),
        (("--steps", "1e-20"), ("--steps: found 1e-20 s", "choose 1 to 100000000 steps")),
        (("--tolerances", "0.7"), ("--tolerances: found 0.7", "from 1e-12 to 0.5")),
        (("--degrees", "3"), ("--degrees", "found 3", "expected 1 or 2")),
        (("--schemes", "implicit"), ("--schemes", "found", "contact-implicit")),
        (("--budget", "soon"), ("--budget", "found soon", "10min")),
        (("--suggest", "1e-2"), ("--suggest", "objective", "impulse")),
        (("--search-tolerances", "1e-3"), ("--search-tolerances", "has no [objective]", "needs a control and an objective")),
        (("--suggest", "1e-2", "--quantity", "impuls"), ("--quantity", "impuls", 'did you mean "impulse"?')),
        (("--suggest", "1e-2", "--quantity", "impulse,peak_force"), ("--suggest", "impulse,peak_force", "choose one of")),
        (("--suggest", "1e-2", "--quantity", "energy_loss"), ("--suggest", "energy_loss", "choose one of")),
    ):
        refused = study(IMPACT, folder / "refused", *options, status=2)
        lines = refused.stderr.splitlines()
        assert len(lines) == 1 and all(fragment in lines[0] for fragment in fragments), refused.stderr
        assert not (folder / "refused").exists()


SEARCHES = ("--sizes", "2", "--steps", "1e-4", "--quantity", "J", "--set", "mesh.size=2", "--set", "time.step=1e-4")


def searches(folder: Path) -> None:
    """What the optimizer's accuracy costs: each search is that of `optimize`, is kept as long as nothing that it depends on has changed,
    and its table is that of the last command."""
    out, tolerances = folder / "searches", ("1e-1", "1e-3", "1e-4")
    asked = (*SEARCHES, "--search-tolerances", ",".join(tolerances))
    said = study(HALF_DISC, out, *asked).stdout
    rows, manifest = table(out / "search.csv"), json.loads((out / "study.json").read_text())
    assert manifest["searches"] == 3 and "search.csv" in manifest["files"]
    for i, tolerance in enumerate(tolerances):
        optimum = folder / f"optimum-{tolerance}"
        signorini("optimize", HALF_DISC, optimum, mesh__size=2, time__step=1e-4, optimizer__tolerance=float(tolerance))
        run = json.loads((optimum / "run.json").read_text())
        assert rows["tolerance"][i] == float(tolerance) and rows["J"][i] == run["objective"]["value"], (rows["J"][i], run["objective"])
        assert rows["stop_reason"][i] == run["stop_reason"]
        assert [rows[name][i] for name in ("iterations", "forward_sweeps", "adjoint_sweeps")] == [
            run["optimizer"][name] for name in ("iterations", "forward_sweeps", "adjoint_sweeps")], tolerance  # fmt: skip
    assert np.max(table(optimum / "steps.csv")["active"]) > 0, "no contact: the case says nothing"
    assert list(rows["forward_sweeps"]) == sorted(rows["forward_sweeps"]) and rows["forward_sweeps"][0] < rows["forward_sweeps"][2]
    least = np.min(rows["J"])
    assert np.array_equal(rows["J_above_least"], (rows["J"] - least) / least) and rows["J_above_least"][2] == 0 < rows["J_above_least"][0]
    error = table(out / "study.csv")["J_estimate"][0]
    cheapest = next(i for i in np.argsort(rows["seconds"]) if rows["J_above_least"][i] <= error / 10)
    assert f"optimizer.tolerance = {rows['tolerance'][cheapest]:.3g} leaves less than a tenth of J's error by size and step, {100 * error:.2g} %" in manifest["sentences"][-1]
    assert manifest["sentences"][-1] in said
    before = (out / "search.csv").read_bytes()
    kept = study(HALF_DISC, out, *asked, "--set", "optimizer.checkpoint=3").stdout
    assert "search 1 of 3" not in kept and (out / "search.csv").read_bytes() == before
    other = study(HALF_DISC, out, *SEARCHES, "--search-tolerances", "1e-1", "--set", "optimizer.method=newton-cg").stdout
    assert "search 1 of 1 runs again: the method of the search is another" in other and len(table(out / "search.csv")["J"]) == 1
    spent = study(HALF_DISC, out, *SEARCHES, "--search-tolerances", "1e-3,1e-6", "--budget", "1e-3s").stdout
    assert "the budget ends before the last search" in spent and list(table(out / "search.csv")["tolerance"]) == [1e-3], spent
    priced = study(HALF_DISC, None, *asked, "--dry-run").stdout
    assert "and 3 searches: the number of sweeps is not known in advance" in priced
    study(HALF_DISC, out, *SEARCHES)
    assert not (out / "search.csv").exists() and json.loads((out / "study.json").read_text())["searches"] == 0
    process = subprocess.Popen([str(SIGNORINI), "study", str(HALF_DISC), "--out", str(out), *SEARCHES, "--search-tolerances", "1e-3,1e-9",
                                "--set", "mesh.size=0.5", "--set", "time.step=5e-5"], stdout=subprocess.PIPE, text=True)  # fmt: skip
    for line in process.stdout:
        if line.startswith("search 1 of 2: "):
            break
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=300)
    assert process.returncode == 130 and list(table(out / "search.csv")["tolerance"]) == [1e-3]
    print("searches: " + ", ".join(f"{sweeps:.0f} sweeps to {tolerance}" for sweeps, tolerance in zip(rows["forward_sweeps"], tolerances)))


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if sys.argv[3:] == ["ranks"]:
            pressure(folder, 2)
            own_density(folder, 2)
            ranks(folder)
            return 0
        for part in (obstacles, ladder, kept, interrupted, chosen_steps, own_density, memory, stress, searches, refusals):
            part(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
