# SPDX-License-Identifier: GPL-3.0-or-later
"""Accuracy on demand: what is asked is met, within the budget, and what is on disk is whole whatever ends the run."""

import json
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SIGNORINI, SOURCE, captured, signorini, stored  # noqa: E402

import numpy as np  # noqa: E402

BLOCK = SOURCE / "tests" / "data" / "block.toml"
DROP = SOURCE / "scenes" / "disc-drop.toml"
FILES = {"scene.toml", "run.json", "steps.csv", "contact.csv", "obstacles.csv", "history.csv", "surfaces.h5", "state.xdmf", "state.h5",
         "control.xdmf", "control.h5", "adjoint.xdmf", "adjoint.h5", "checkpoint.h5", "indicators.csv"}  # fmt: skip


def command(verb: str, scene: Path, out: Path, *options: str, ranks: int = 1) -> list[str]:
    mpirun = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    return [*mpirun, str(SIGNORINI), verb, str(scene), "--out", str(out), *options]


def order(verb: str, scene: Path, out: Path, *options: str, status: int = 0, ranks: int = 1) -> tuple[dict, str]:
    """run.json and what was said last."""
    done = captured(command(verb, scene, out, *options, ranks=ranks))
    assert done.returncode == status, (done.args, done.returncode, done.stdout, done.stderr)
    return json.loads((out / "run.json").read_text()), done.stdout


def touched(out: Path) -> bool:
    table = np.genfromtxt(out / "steps.csv", delimiter=",", names=True)
    return bool((table["active"] > 0).any())


def optimum_is_met(folder: Path) -> None:
    """J's error, to a run that is ordered to a tenth of it, is below what is asked and as estimated."""
    best, _ = order("optimize", HALF_DISC, folder / "auto", "--accuracy", "1e-3", "--set", "mesh.size=auto")
    for ranks in (1, 2):
        run, said = order("optimize", HALF_DISC, folder / f"asked-{ranks}", "--accuracy", "1e-2", ranks=ranks)
        error = abs(run["objective"]["value"] / best["objective"]["value"] - 1)
        found = run["accuracy"]
        assert found["asked"] == 1e-2 and abs(found["estimated"] - sum(found[k] for k in ("space", "time", "search"))) < 1e-12
        assert error < found["asked"] and error / 3 < found["estimated"] < 3 * error, (error, found)
        assert touched(folder / f"asked-{ranks}")
        assert re.search(r"^0.01 of J asked, .* estimated .*: met; .* half the error would take about", said, re.MULTILINE), said
        print(f"optimum, {ranks} ranks: asked 1e-2, estimated {found['estimated']:.1e}, found {error:.1e}")
    assert best["accuracy"]["estimated"] <= 1e-3 and len(best["optimizer"]["coarse_levels"]) >= 2
    # On elements of one size more rounds follow, and the scene that is written is that of the last: it has its mesh and steps.
    finer, _ = order("optimize", HALF_DISC, folder / "finer", "--accuracy", "2e-3", "--set", "time.step=1e-4")
    assert len(finer["optimizer"]["coarse_levels"]) >= 1 and finer["unknowns"] > 3 * run["unknowns"]
    assert {p.name for p in (folder / "finer").iterdir()} == FILES
    steps = [level["steps"] for level in finer["optimizer"]["coarse_levels"]] + [finer["steps"]["done"]]
    assert steps == sorted(steps) and steps[-1] > 1.5 * steps[0], steps
    again = json.loads((signorini("simulate", folder / "finer" / "scene.toml", folder / "again"), (folder / "again" / "run.json").read_text())[1])
    assert (again["unknowns"], again["steps"]["done"]) == (finer["unknowns"], finer["steps"]["done"])


def sizes_where_they_matter(folder: Path) -> None:
    """With mesh.size = "auto" elements differ by more than their factor in a uniform mesh, and the mesh is kept."""
    out = folder / "auto"
    run = json.loads((out / "run.json").read_text())
    assert {p.name for p in out.iterdir()} == FILES | {"mesh.msh"}

    def spread(folder: Path) -> tuple[int, float]:
        nodes, cells, _ = stored(folder, "state", "displacement")
        a, b, c = (nodes[cells[:, i], :2] for i in range(3))
        area = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
        return len(cells), float(area.max() / area.min())

    indicators = np.genfromtxt(out / "indicators.csv", delimiter=",", names=True)["indicator"]
    assert len(indicators) == run["cells"] and run["accuracy"]["space"] < indicators.sum() < 100 * run["accuracy"]["space"]
    signorini("simulate", out / "scene.toml", folder / "on-it")  # which names the mesh that was kept
    (cells, largest), (uniform_cells, uniform) = spread(folder / "on-it"), spread(folder / "again")
    assert cells == run["cells"] and largest > 3 * uniform, (cells, largest, uniform_cells, uniform)
    start = json.loads((signorini("optimize", HALF_DISC, folder / "from-it", control__initial={"run": str(out)}, mesh__size=1, optimizer__max_iterations=0),
                        (folder / "from-it" / "run.json").read_text())[1])["objective"]["value"]  # fmt: skip
    assert abs(start / run["objective"]["value"] - 1) < 0.01, start
    # A mesh of which nothing else is known is refined where it matters: its own error is above what is asked.
    coarse, _ = order("optimize", HALF_DISC, folder / "coarse", "--accuracy", "8e-3", "--set", "mesh.size=auto")
    asked = 0.8 * coarse["accuracy"]["space"]
    for ranks in (1, 2):
        refined = folder / f"refined-{ranks}"
        finer, _ = order("optimize", HALF_DISC, refined, "--accuracy", repr(asked), "--set", f'mesh={{file="{folder / "coarse" / "mesh.msh"}"}}', ranks=ranks)
        assert finer["accuracy"]["estimated"] <= asked and len(finer["optimizer"]["coarse_levels"]) >= 1 and finer["cells"] > 1.2 * coarse["cells"]
        assert abs(finer["objective"]["value"] / run["objective"]["value"] - 1) < 2e-3 + asked
        assert {p.name for p in refined.iterdir()} == FILES | {"mesh.msh"}
    print(f"sizes: {cells} cells whose areas differ {largest:.0f} times, in a uniform mesh of {uniform_cells} {uniform:.1f} times")


def budget_is_kept(folder: Path) -> None:
    # The budget is some first answers long, however busy the machine is.
    coarse = ("--quantity", "contact_time", "--set", "mesh.size=4", "--set", "time.step=0.04")
    for verb, scene, more in (("optimize", HALF_DISC, ()), ("simulate", DROP, coarse)):
        out = folder / f"budget-{verb}"
        start = time.perf_counter()
        order(verb, scene, out, "--accuracy", "0.5", *more)
        seconds = 5 * (time.perf_counter() - start)
        run, said = order(verb, scene, out, "--accuracy", "1e-7", "--budget", f"{seconds:.2f}s", *more, status=1)
        assert "budget" in said and not run["accuracy"]["met"]
        assert run["steps"]["done"] == run["steps"]["asked"], "what the budget cut off stands in place of a whole answer"
        # What was asked is far beyond it; that the run ends is what keeping it means.
        assert "budget is spent" in said or "beyond the budget" in said, said
        assert run["accuracy"]["estimated"] > 10 * 1e-7, "the budget would have been enough"
        assert not list(out.glob(".unfinished*")) and (out / "state.h5").is_file()
        if verb == "optimize":  # whose error is known from the first round on
            further = re.search(r"what is asked would take about (\S+) s", said)
            assert float(further[1]) > seconds, said
        print(f"budget of {verb}: {seconds:.1f} s, estimated {run['accuracy']['estimated']:.1e}")


def interrupted_keeps_the_best(folder: Path) -> None:
    for ranks, which in ((1, signal.SIGINT), (2, signal.SIGUSR1)):
        out = folder / f"interrupted-{ranks}"
        process = subprocess.Popen(command("optimize", BLOCK, out, "--accuracy", "1e-7", "--set", "mesh.size=0.5", ranks=ranks), text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT)  # fmt: skip
        for line in process.stdout:
            if line.startswith("round 2"):
                break
        content = {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}
        process.send_signal(which)
        said, _ = process.communicate(timeout=60)
        assert process.returncode == 130 and "not met, interrupted" in said, (process.returncode, said)
        assert FILES == {path.name for path in out.iterdir()}
        assert all((out / name).read_bytes() == content[name] for name in ("run.json", "control.h5", "steps.csv"))
        run = json.loads((out / "run.json").read_text())
        assert len(run["optimizer"]["coarse_levels"]) == 1
        print(f"interrupted on {ranks} ranks: the second round's answer stays, {len(FILES)} files")


def motion_is_met(folder: Path) -> None:
    run, said = order("simulate", DROP, folder / "impulse", "--accuracy", "1e-2", "--quantity", "impulse")
    assert run["accuracy"]["quantity"] == "impulse" and run["accuracy"]["estimated"] <= 1e-2 and "met;" in said
    assert touched(folder / "impulse")
    fine = json.loads((signorini("simulate", DROP, folder / "fine", mesh__size=1, time__step=2.5e-3), (folder / "fine" / "run.json").read_text())[1])
    graded, said = order("simulate", DROP, folder / "graded", "--accuracy", "1e-2", "--quantity", "impulse", "--set", "mesh.size=auto")
    assert graded["accuracy"]["estimated"] <= 1e-2 and "sizes by the error of the stress" in said and (folder / "graded" / "mesh.msh").is_file()
    least, largest, cells = re.findall(r"^sizes by the error of the stress: from (\S+) to (\S+) m, (\d+) elements$", said, re.MULTILINE)[-1]
    assert float(least) < float(largest) and int(cells) == graded["cells"], said
    took, half = map(float, re.search(r"of which the run took (\S+) s; half the error would take about (\S+) s", said).groups())
    assert half > 1.5 * took, said  # order 2 in space: twice the cells, and no fewer steps
    signorini("simulate", folder / "graded" / "scene.toml", folder / "on-graded")  # which names the mesh that was kept
    assert json.loads((folder / "on-graded" / "run.json").read_text())["cells"] == graded["cells"]
    impulse = [np.hypot(*one["impact"]["all"]["impulse"]) for one in (run, graded, fine)]
    assert abs(impulse[0] / impulse[2] - 1) < 1e-2 and abs(impulse[1] / impulse[2] - 1) < 1e-2, impulse
    print(f"impulse: asked 1e-2, estimated {run['accuracy']['estimated']:.1e}, found {abs(impulse[0] / impulse[2] - 1):.1e}, on sizes that vary {abs(impulse[1] / impulse[2] - 1):.1e}")


def pages(folder: Path) -> None:
    """They show where sizes and lengths are small, and every figure has what it needs."""
    signorini("optimize", BLOCK, folder / "lengths", time__step="auto", time__tolerance=1e-2)
    for name, shown in (("auto", ("The mesh, and each cell", "0.001 of J asked")), ("lengths", ("Length of the steps over time",))):
        for script in ("report.py", "figures.py"):
            done = subprocess.run([sys.executable, SOURCE / "postprocess" / script, folder / name], capture_output=True, text=True)
            assert done.returncode == 0 and not done.stderr, (script, name, done.stderr)
        page = (folder / name / "report.html").read_text()
        assert all(text in page for text in shown), name


def refusals(folder: Path) -> None:
    for verb, options, words in (
        ("simulate", ("--set", "mesh.size=auto"), ("mesh.size", '"auto"', "--accuracy")),
        ("study", ("--set", "mesh.size=auto"), ("mesh.size", '"auto"', "--accuracy")),
        ("optimize", ("--budget", "5s"), ("--budget", "--accuracy")),
        ("optimize", ("--accuracy", "1e-2", "--resume"), ("--accuracy", "--resume")),
        ("optimize", ("--accuracy", "0"), ("--accuracy",)),
        ("optimize", ("--accuracy", "1e-2", "--set", "mesh.degree=2"), ("--accuracy", "mesh.degree = 2", "set it to 1")),
        ("simulate", ("--accuracy", "1e-2"), ("--accuracy", "--quantity")),
        ("simulate", ("--accuracy", "1e-2", "--quantity", "impuls"), ("--quantity", '"impulse"')),
        ("simulate", ("--accuracy", "1e-2", "--quantity", "J"), ("--quantity", "impulse")),
    ):
        done = captured(command(verb, HALF_DISC, folder / "refused", *options))
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, (verb, options, done.returncode, done.stderr)
        assert all(word in done.stderr for word in words), (words, done.stderr)
        assert not (folder / "refused").exists()
    fixed = f'mesh={{file="{SOURCE / "tests" / "data" / "fixed-density.geo"}", size=0.25}}'  # which no size changes
    done = captured(command("optimize", BLOCK, folder / "refused", "--accuracy", "1e-2", "--set", fixed))
    assert done.returncode == 2 and "mesh.size: " in done.stderr and "Transfinite" in done.stderr, done.stderr


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        for test in (refusals, optimum_is_met, sizes_where_they_matter, pages, budget_is_kept, interrupted_keeps_the_best, motion_is_met):
            test(Path(folder))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
