# SPDX-License-Identifier: GPL-3.0-or-later
"""A search that starts on coarse meshes ends where one from the first guess does, with fewer sweeps; it can be interrupted, resumed and
does without a level that cannot be meshed. And a control that an earlier run left is gone on from on another mesh."""

import json
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SIGNORINI, SOURCE, attempt, captured, signorini, table  # noqa: E402

BLOCK, FIXED = SOURCE / "tests" / "data" / "block.toml", SOURCE / "tests" / "data" / "fixed-density.geo"
NEAR = 1e-6  # of J near its minimum, which is about 1e-2
ROUNDING, RANKS = 1e-12, 1e-8  # on other ranks sums are in another order, and contact multiplies that
# Of 800 cells: one level of 200 cells is coarse enough.
DISC = {"mesh__size": 1, "output__fields": [], "output__tables": ["history"], "optimizer__max_iterations": 38}


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def sweeps_to(out: Path, value: float) -> int:
    history = table(out / "history.csv")
    row = (history["objective"] <= value).argmax()
    assert history["objective"][row] <= value, f"{history['objective'].min()} is above {value}"
    return int(history["forward_sweeps"][row] + history["adjoint_sweeps"][row])


def same_optimum(folder: Path) -> None:
    for method, changes in (("lbfgs", {}), ("newton-cg", {"optimizer__max_iterations": 9}),
                            ("lbfgs", {"control__lower": -0.9, "control__upper": 0.5, "mesh__degree": 2, "mesh__size": 1.5})):  # fmt: skip
        outs = [folder / start for start in ("guess", "coarse")]
        for out in outs:
            done = signorini("optimize", HALF_DISC, out, **DISC | {"optimizer__start": out.name, "optimizer__method": method} | changes)
        J = [table(out / "history.csv")["objective"] for out in outs]
        least = np.minimum(J[0].min(), J[1].min())
        print(f"{method}, {changes}: J {J[0][-1]:.9f} from the first guess, {J[1][-1]:.9f} from coarse meshes")
        assert abs(J[0][-1] - J[1][-1]) < NEAR
        if not changes:
            direct, coarse = (sweeps_to(out, least + NEAR) for out in outs)
            print(f"    to J* + 1e-6 {direct} sweeps from the first guess, {coarse} from coarse meshes")
            assert coarse < 0.75 * direct
        *_, level = manifest(outs[1])["optimizer"]["coarse_levels"]
        assert manifest(outs[0])["optimizer"]["coarse_levels"] == []
        if "mesh__size" not in changes:
            assert level["size"] == 2 and level["steps"] == 75 and abs(level["step"] / 1e-4 - 1) < ROUNDING and level["iterations"] > 3
            assert level["forward_sweeps"] >= level["adjoint_sweeps"] > 3 and level["seconds"] > 0 and abs(level["objective"] - least) < 1e-3
            line, = (line for line in done.stdout.splitlines() if line.startswith("coarse mesh of size 2 m, "))
            assert "75 steps of 0.0001 s" in line and level["stop_reason"] in line, line
        assert J[1][0] < 0.05 * J[0][0] and table(outs[1] / "history.csv")["iteration"][0] == 0
    by_default = signorini("optimize", HALF_DISC, folder / "default", **DISC | {"optimizer__max_iterations": 1})
    assert "coarse mesh" in by_default.stdout and 'start = "coarse"' in (folder / "default" / "scene.toml").read_text()


def on_ranks(folder: Path) -> None:
    few = DISC | {"optimizer__max_iterations": 4}
    J = []
    for ranks in (1, 2):
        signorini("optimize", HALF_DISC, folder / "ranks", ranks, **few)
        J.append(table(folder / "ranks" / "history.csv")["objective"])
    print(f"on two ranks J differs by {abs(J[1] / J[0] - 1).max():.1e} at most")
    assert abs(J[1] / J[0] - 1).max() < 1e-6


def resumed(folder: Path) -> None:
    """From the checkpoint alone, without coarse meshes; without one with them again."""
    whole, parted = folder / "whole", folder / "parted"
    signorini("optimize", HALF_DISC, whole, **DISC | {"optimizer__max_iterations": 12})
    signorini("optimize", HALF_DISC, parted, **DISC | {"optimizer__max_iterations": 5})
    command = [str(SIGNORINI), "optimize", str(parted / "scene.toml"), "--out", str(parted), "--resume", "--set", "optimizer.max_iterations=12"]
    done = captured(command)
    assert done.returncode == 0 and "resumed after iteration 5" in done.stdout and "coarse mesh" not in done.stdout, done.stdout + done.stderr
    a, b = (table(out / "history.csv") for out in (whole, parted))
    assert all((a[key] == b[key]).all() for key in a if key != "seconds"), "the result differs from that of a run in one piece"
    (parted / "checkpoint.h5").unlink()
    done = captured(command)
    assert done.returncode == 0 and "no checkpoint in" in done.stdout and "coarse mesh of size" in done.stdout, done.stdout + done.stderr
    print("resumed: the same to the last bit")


def interrupted(folder: Path) -> None:
    """Between two levels: what was there stays, and nothing is left."""
    out, new = folder / "parted", folder / "new"
    for place in (out, new):
        before = {path.name: path.read_bytes() for path in place.iterdir()} if place.exists() else None
        process = subprocess.Popen([str(SIGNORINI), "optimize", str(HALF_DISC), "--out", str(place), "--set", "mesh.size=0.25"],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)  # fmt: skip
        for line in process.stdout:
            if line.startswith("coarse mesh of size 1 m"):
                break
        assert process.poll() is None, "ended before it could be interrupted"
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        assert process.returncode == 130
        assert ({path.name: path.read_bytes() for path in place.iterdir()} if place.exists() else None) == before
    print("interrupted on a coarse mesh: nothing was written, nothing was lost")


def left_out(folder: Path) -> None:
    """A .geo whose cells are as many at any size has no coarse meshes; nor has a small problem, nor one without iterations."""
    fixed = {"mesh__file": str(FIXED), "mesh__size": 0.01, "time__step": 0.012, "optimizer__max_iterations": 1, "output__fields": []}
    done = signorini("optimize", BLOCK, folder / "fixed", **fixed)
    assert done.stdout.count("m is left out: found a mesh of 9800 cells, where that of this scene has 9800") == 2, done.stdout
    assert manifest(folder / "fixed")["optimizer"]["coarse_levels"] == []
    for changes in ({"mesh__size": 0.25, "optimizer__start": "coarse"}, {"mesh__size": 0.05, "optimizer__max_iterations": 0}):
        done = signorini("optimize", BLOCK, folder / "small", **{"optimizer__max_iterations": 1} | changes)
        assert "coarse mesh" not in done.stdout, done.stdout
    print("left out: levels that are no coarser, or too coarse")


def of_another_mesh(folder: Path) -> None:
    """A linear control on a coarse mesh is itself on any other."""
    linear = {"control__initial": ["0.5 + x - y", "t*y - 1"]}
    optimum = folder / "linear"
    for earlier, ranks in (({}, 2), ({"mesh__degree": 2}, 1)):
        signorini("optimize", BLOCK, optimum, ranks, **linear, **earlier, optimizer__max_iterations=0)
        for number, here in enumerate(({"mesh__size": 0.13}, {"mesh__size": 0.4, "mesh__degree": 2}, {"mesh__size": 0.13, "control__space": "cellwise"})):
            outs = [folder / "stored", folder / "given"]
            for out, start in zip(outs, ({"control__initial": {"run": str(optimum)}}, linear), strict=True):
                signorini("simulate", BLOCK, out, 1 + number % 2, **start, **here)
            a, b = (manifest(out)["objective"] for out in outs)
            assert b["control_cost"] > 0 and all(abs(a[part] - b[part]) < RANKS * b["value"] for part in a), (a, b)
    # From an optimum: J is near its own, and with half the step the control is repeated.
    out, again = folder / "whole", folder / "again"
    here = {"mesh__size": 0.7, "time__step": 2.5e-5, "control__initial": {"run": str(out)}, "output__fields": []}
    for ranks in (1, 2):
        signorini("simulate", HALF_DISC, again, ranks, **here)
        assert abs(manifest(again)["objective"]["value"] / manifest(out)["objective"]["value"] - 1) < 0.02
    # A run that is gone on from starts there, not on coarse meshes.
    done = signorini("optimize", HALF_DISC, again, **here | {"optimizer__max_iterations": 1})
    assert "coarse mesh" not in done.stdout and table(again / "history.csv")["objective"][0] < 0.011
    # Its mesh is made again from its file, which must be what it was.
    geo, scene = folder / "square.geo", folder / "moved"
    shutil.copy(SOURCE / "tests" / "data" / "square.geo", geo)
    signorini("optimize", BLOCK, scene, **linear, mesh__file=str(geo), optimizer__max_iterations=0)
    from_there = {"control__initial": {"run": str(scene)}, "mesh__size": 0.13}
    geo.write_text(geo.read_text().replace("{1, 1, 0}", "{1, 1.1, 0}"))
    for text in ("whose file has changed since", "cannot be regenerated"):
        refused = attempt("simulate", BLOCK, again, **from_there)
        assert refused.returncode == 2 and "control.initial.run: " in refused.stderr and text in refused.stderr, refused.stderr
        geo.unlink(missing_ok=True)
    refused = attempt("simulate", BLOCK, again, **from_there | {"control__initial": {"run": str(optimum)}, "control__on": "top"})
    assert refused.returncode == 2 and 'found a control on the body, this scene\'s acts on "top"' in refused.stderr, refused.stderr
    print("an earlier control is gone on from on other meshes, degrees and ranks")


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        for part in (same_optimum, on_ranks, resumed, interrupted, left_out, of_another_mesh):
            part(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
