# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line beside its runs: --version, what bash completes, where an option is known, the folder of a run of an echo."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from harness import BUILD, SIGNORINI, SOURCE, captured, signorini

BLOCK = SOURCE / "tests" / "data" / "block.toml"
QUICK = ("--set", "mesh.size=0.5", "--set", "time.end=0.04", "--set", "optimizer.max_iterations=1")


def ok(*words: str, cwd: Path | None = None) -> str:
    done = captured([str(SIGNORINI), *words], cwd=cwd)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_version() -> None:
    assert re.fullmatch(r"signorini \d+\.\d+\S*, dolfinx \S+, petsc \S+, gmsh \S+\n", ok("--version"))


# --- A folder for temporary files ---------------------------------------------------------------------------------------

VARIABLES = ("TMPDIR", "TEMP", "TMP")
INFO = [str(SIGNORINI), "info", str(BLOCK), "--quiet"]
PYTHON = [sys.executable, "-c", "import signorini; signorini.rank"]


def run_with(name: str, folder: Path | str, command: list[str]) -> subprocess.CompletedProcess:
    """Runs a command with a folder for temporary files by one variable alone."""
    own = {key: value for key, value in os.environ.items() if key not in VARIABLES} | {name: str(folder)}
    own["PYTHONPATH"] = f"{BUILD / 'python'}:{own.get('PYTHONPATH', '')}"
    return subprocess.run(command, env=own, capture_output=True, text=True, stdin=subprocess.DEVNULL)


def refuses(done: subprocess.CompletedProcess, name: str, folder: Path | str, why: str) -> None:
    assert f"{name}: the folder {folder} for temporary files is not writable ({why}" in done.stderr.splitlines()[-1]


@pytest.fixture(params=("a file", "/proc"))
def unusable(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Path | str, str]:
    """A folder that cannot be made, and why. In /proc root may write, and cannot."""
    if request.param == "/proc":
        return "/proc", ""
    (tmp_path / "file").write_text("")
    return tmp_path / "file" / "below", "Not a directory"


@pytest.mark.parametrize("name", VARIABLES)
def test_temporary_folder_that_cannot_be_made(name: str, unusable: tuple[Path | str, str]) -> None:
    """It is refused before MPI starts, which would crash."""
    done = run_with(name, unusable[0], INFO)
    refuses(done, name, *unusable)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1


@pytest.mark.skipif(not (BUILD / "python" / "signorini").is_dir(), reason="the Python module is not built")
def test_temporary_folder_that_cannot_be_made_from_python(unusable: tuple[Path | str, str]) -> None:
    done = run_with("TMPDIR", unusable[0], PYTHON)
    refuses(done, "TMPDIR", *unusable)
    assert done.returncode == 1


@pytest.mark.parametrize("name", VARIABLES)
@pytest.mark.parametrize("made", (True, False), ids=("made", "of the system"))
def test_temporary_folder_is_made(made: bool, name: str, tmp_path: Path) -> None:
    """As by Open MPI."""
    done = run_with(name, tmp_path / "made" if made else "", INFO)
    assert done.returncode == 0 and not done.stderr


# --- Help and completion ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def completed(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., set[str]]:
    """Completes by the function that bash itself would call, for the words as bash splits them."""
    folder = tmp_path_factory.mktemp("completion")
    script = folder / "completion.bash"
    script.write_text(ok("completion"))
    (folder / "own scene.toml").write_text("")
    (folder / "notes.txt").write_text("")

    def complete(*words: str) -> set[str]:
        given = " ".join(shlex.quote(word) for word in ("signorini", *words))
        command = f"source {shlex.quote(str(script))}; COMP_WORDS=({given}); COMP_CWORD={len(words)}; _signorini; "
        command += "printf '%s\\n' \"${COMPREPLY[@]}\""
        done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=True, cwd=folder)
        assert not done.stderr
        return set(done.stdout.splitlines()) - {""}

    return complete


@pytest.fixture(scope="module")
def verbs() -> set[str]:
    return set(re.findall(r"(?m)^  ([a-z]+) ", ok("--help")))


def test_help_is_a_verb_too() -> None:
    assert ok("help") == ok("--help") and all(ok("help", verb) == ok(verb, "--help") for verb in ("study", "report"))


def test_completes_verbs(completed: Callable[..., set[str]], verbs: set[str]) -> None:
    assert {"simulate", "completion"} < verbs and completed("") == verbs | {"--help", "--version"}
    assert completed("op") == {"optimize"} and completed("nonsense") == set()


def test_completes_the_options_of_each_verb(completed: Callable[..., set[str]], verbs: set[str]) -> None:
    for verb in verbs:
        assert completed(verb, "--") == set(re.findall(r"(?m)--[a-z-]+", ok(verb, "--help"))), verb
    assert "--resume" in completed("optimize", "--") and "--resume" not in completed("simulate", "--")


@pytest.mark.parametrize("words, expected", [
    (("mesh.s",), {"mesh.size=", "mesh.scale=", "mesh.split="}), (("solver.vi", "="), {"condensed", "full"}),
    (("solver.linear", "=", "it"), {"iterative"}), (("control.constant_in_time", "="), {"true", "false"}), (("mesh.size", "="), set()),
])  # fmt: skip
def test_completes_keys_and_choices(words: tuple[str, ...], expected: set[str], completed: Callable[..., set[str]]) -> None:
    assert completed("simulate", "--set", *words) == expected


def test_completes_scenes(completed: Callable[..., set[str]]) -> None:
    assert completed("simulate", "own") == {"own scene.toml"} and completed("simulate", "no") == set()
    assert "own scene.toml" not in completed("simulate", "a.toml", "--out", "")


@pytest.mark.parametrize("verb", ("simulate", "check", "info", "study"))
def test_resume_is_an_option_of_optimize_alone(verb: str) -> None:
    assert "--resume" not in ok(verb, "--help")
    done = captured([str(SIGNORINI), verb, str(BLOCK), "--resume"])
    assert done.returncode == 2 and f"--resume: {verb} writes no checkpoints; use it with optimize" in done.stderr


def test_misspelt_option_names_those_of_the_verb() -> None:
    done = captured([str(SIGNORINI), "optimize", str(BLOCK), "--replac"])
    assert done.returncode == 2 and "--replace" not in done.stderr and "--resume" in done.stderr


# --- Runs ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("checkpoint", (10, 0))
def test_stopped_search_says_how_to_resume(checkpoint: int, tmp_path: Path) -> None:
    """If it wrote a checkpoint."""
    done = signorini("optimize", BLOCK, tmp_path, mesh__size=0.5, optimizer__max_iterations=1, optimizer__checkpoint=checkpoint)
    line = next(line for line in done.stdout.splitlines() if line.startswith("stopped: iteration limit"))
    assert ("--resume" in line) == (checkpoint > 0)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A folder with block.toml and its run in results/block."""
    scene = tmp_path / "block.toml"
    scene.write_text(BLOCK.read_text().replace('"square.geo"', f'"{SOURCE / "tests" / "data" / "square.geo"}"'))
    ok("simulate", "block.toml", *QUICK, cwd=tmp_path)
    assert json.loads((tmp_path / "results" / "block" / "run.json").read_text())["scene"] == "block"
    return tmp_path


@pytest.mark.parametrize(
    "scene, cwd", (("results/block/scene.toml", "."), ("./scene.toml", "results/block"), ("block/scene.toml", "results"))
)
def test_run_of_an_echo_goes_to_its_own_folder(scene: str, cwd: str, place: Path) -> None:
    """Under its name."""
    home = place / "results" / "block"
    (home / "steps.csv").unlink()
    ok("simulate", scene, cwd=place / cwd)
    assert (home / "steps.csv").exists() and json.loads((home / "run.json").read_text())["scene"] == "block"
    assert [path.name for path in (place / "results").iterdir()] == ["block"] and not (home / "results").exists()


def test_other_scenes_of_that_name_have_results_of_their_own(place: Path) -> None:
    shutil.copy(place / "block.toml", place / "scene.toml")
    ok("simulate", "scene.toml", *QUICK, cwd=place)
    assert (place / "results" / "scene" / "run.json").exists()


def test_edited_echo_is_not_replaced(place: Path) -> None:
    echo = place / "results" / "block" / "scene.toml"
    echo.write_text("# edited\n" + echo.read_text())
    done = captured([str(SIGNORINI), "simulate", str(echo)], cwd=place)
    assert done.returncode == 2 and "its own scene file" in done.stderr


def test_missing_package_is_named(tmp_path: Path) -> None:
    """By report, in one line."""
    (tmp_path / "h5py.py").write_text('raise ModuleNotFoundError("gone", name="h5py")\n')
    done = subprocess.run([SIGNORINI, "report", tmp_path], env=os.environ | {"PYTHONPATH": str(tmp_path)}, capture_output=True, text=True)
    assert done.returncode == 2 and done.stderr.startswith("signorini report: the Python package h5py is missing (")
    assert len(done.stderr.splitlines()) == 1
