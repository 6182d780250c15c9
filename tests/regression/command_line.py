# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line beside its runs: --version, what bash completes, where an option is known, where a run of an echo goes."""

import importlib.util
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SIGNORINI, SOURCE, captured, signorini  # noqa: E402

BLOCK = SOURCE / "tests" / "data" / "block.toml"
QUICK = ("--set", "mesh.size=0.5", "--set", "time.end=0.04", "--set", "optimizer.max_iterations=1")


def ok(*words: str, cwd: Path | None = None) -> str:
    done = captured([str(SIGNORINI), *words], cwd=cwd)
    assert done.returncode == 0, done.stderr
    return done.stdout


def version() -> None:
    said = ok("--version")
    assert re.fullmatch(r"signorini \d+\.\d+\S*, dolfinx \S+, petsc \S+, gmsh \S+\n", said), said
    print(said.strip())


def temporary_folder(folder: Path) -> None:
    """One that is not there is made, as by Open MPI; one that cannot be is refused before MPI starts, which would crash, from
    Python too."""
    (folder / "file").write_text("")
    quick = [str(SIGNORINI), "info", str(BLOCK), "--quiet"]
    for name in ("TMPDIR", "TEMP", "TMP"):
        own = {key: value for key, value in os.environ.items() if key not in ("TMPDIR", "TEMP", "TMP")}
        for command, status in ((quick, 2), ([sys.executable, "-c", "import signorini; signorini.rank"], 1)):
            if status == 1 and (name != "TMPDIR" or not importlib.util.find_spec("signorini")):
                continue
            for wrong, why in ((folder / "file" / "below", "Not a directory"), ("/proc", "")):  # /proc: root may write there, and cannot
                done = subprocess.run(command, env=own | {name: str(wrong)}, capture_output=True, text=True, stdin=subprocess.DEVNULL)
                said = done.stderr.splitlines()
                assert done.returncode == status, (name, done.returncode, done.stderr)
                assert f"{name}: found the folder {wrong}, which cannot be written ({why}" in said[-1], done.stderr
                assert status == 1 or len(said) == 1, done.stderr
        for usable in (str(folder / f"made for {name}"), ""):
            done = subprocess.run(quick, env=own | {name: usable}, capture_output=True, text=True, stdin=subprocess.DEVNULL)
            assert done.returncode == 0 and not done.stderr, (name, usable, done.stderr)
    print("a folder for temporary files that cannot be made is refused")


def completion(folder: Path) -> None:
    """By the functions that bash itself would call, for the words as bash splits them."""
    script = folder / "completion.bash"
    script.write_text(ok("completion"))
    (folder / "own scene.toml").write_text("")
    (folder / "notes.txt").write_text("")

    def completed(*words: str) -> set[str]:
        given = " ".join(shlex.quote(word) for word in ("signorini", *words))
        command = f"source {shlex.quote(str(script))}; COMP_WORDS=({given}); COMP_CWORD={len(words)}; _signorini; printf '%s\\n' \"${{COMPREPLY[@]}}\""
        done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=True, cwd=folder)
        assert not done.stderr, done.stderr
        return set(done.stdout.splitlines()) - {""}

    verbs = set(re.findall(r"(?m)^  ([a-z]+) ", ok("--help")))
    assert ok("help") == ok("--help") and all(ok("help", verb) == ok(verb, "--help") for verb in ("study", "report"))
    assert {"simulate", "completion"} < verbs and completed("") == verbs | {"--help", "--version"}
    assert completed("op") == {"optimize"} and completed("nonsense") == set()
    for verb in verbs:
        listed = set(re.findall(r"(?m)--[a-z-]+", ok(verb, "--help")))
        assert completed(verb, "--") == listed, (verb, completed(verb, "--") ^ listed)
    assert "--resume" in completed("optimize", "--") and "--resume" not in completed("simulate", "--")
    assert completed("simulate", "--set", "mesh.s") == {"mesh.size=", "mesh.scale="}
    assert completed("simulate", "--set", "solver.vi", "=") == {"condensed", "full"}
    assert completed("simulate", "--set", "solver.linear", "=", "it") == {"iterative"}
    assert completed("simulate", "--set", "control.constant_in_time", "=") == {"true", "false"}
    assert completed("simulate", "--set", "mesh.size", "=") == set()
    assert completed("simulate", "own") == {"own scene.toml"} and completed("simulate", "no") == set()
    assert "own scene.toml" not in completed("simulate", "a.toml", "--out", "")
    print(f"bash completes {len(verbs)} verbs, their options, the keys of --set and their choices")


def options_where_they_work() -> None:
    for verb in ("simulate", "check", "info", "study"):
        assert "--resume" not in ok(verb, "--help")
        done = captured([str(SIGNORINI), verb, str(BLOCK), "--resume"])
        assert done.returncode == 2 and f"--resume: {verb} writes no checkpoints; use it with optimize" in done.stderr, done.stderr
    done = captured([str(SIGNORINI), "optimize", str(BLOCK), "--replac"])
    assert done.returncode == 2 and "--replace" not in done.stderr and "--resume" in done.stderr, done.stderr
    print("--resume is an option of optimize alone")


def how_to_go_on(folder: Path) -> None:
    for checkpoint, told in ((10, True), (0, False)):
        done = signorini("optimize", BLOCK, folder / "stopped", mesh__size=0.5, optimizer__max_iterations=1, optimizer__checkpoint=checkpoint)
        line = next(line for line in done.stdout.splitlines() if line.startswith("stopped: iteration limit"))
        assert ("--resume" in line) == told, line
    print("a search that stopped before its end says how to go on")


def echo_goes_home(folder: Path) -> None:
    """A run of the scene.toml that a run left goes to the same folder, under its name; other scenes of that name do not."""
    place = folder / "elsewhere"
    place.mkdir()
    scene = place / "block.toml"
    scene.write_text(BLOCK.read_text().replace('"square.geo"', f'"{SOURCE / "tests" / "data" / "square.geo"}"'))
    ok("simulate", "block.toml", *QUICK, cwd=place)
    home = place / "results" / "block"
    assert json.loads((home / "run.json").read_text())["scene"] == "block"
    for words, cwd in ((("results/block/scene.toml",), place), (("./scene.toml",), home), (("block/scene.toml",), home.parent)):
        (home / "steps.csv").unlink()
        ok("simulate", *words, cwd=cwd)
        assert (home / "steps.csv").exists() and json.loads((home / "run.json").read_text())["scene"] == "block"
    assert {path.name for path in (place / "results").iterdir()} == {"block"} and not (home / "results").exists()
    shutil.copy(scene, place / "scene.toml")
    ok("simulate", "scene.toml", *QUICK, cwd=place)
    assert (place / "results" / "scene" / "run.json").exists()
    (home / "scene.toml").write_text("# edited\n" + (home / "scene.toml").read_text())
    done = captured([str(SIGNORINI), "simulate", str(home / "scene.toml")], cwd=place)
    assert done.returncode == 2 and "its own scene file" in done.stderr, done.stderr
    print("the echo of a run is run again in its own folder")


def missing_package(folder: Path) -> None:
    """A Python without a package that pages need is told so, and which."""
    (folder / "h5py.py").write_text('raise ModuleNotFoundError("gone", name="h5py")\n')
    done = subprocess.run([SIGNORINI, "report", folder], env=os.environ | {"PYTHONPATH": str(folder)}, capture_output=True, text=True)
    assert done.returncode == 2 and done.stderr.startswith("signorini report: found no Python package h5py ("), done.stderr
    assert len(done.stderr.splitlines()) == 1
    print("a package that is missing is named")


def main() -> int:
    version()
    options_where_they_work()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        for part in (completion, temporary_folder, how_to_go_on, echo_goes_home, missing_package):
            part(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
