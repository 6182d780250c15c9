# SPDX-License-Identifier: GPL-3.0-or-later
"""A run has its folder for itself and replaces nothing there that no run wrote; what it makes in folders that anyone may write to
belongs to it alone from the start."""

import json
import os
import re
import signal
import socket
import subprocess
import time
from pathlib import Path

import pytest
from harness import FAULTS, HALF_DISC, SIGNORINI, SOURCE, captured, preloadable

LOCK = ".signorini-lock"
QUICK = ("--set", "mesh.size=6", "--set", "time.end=1e-3", "--set", "optimizer.max_iterations=2")
STUDY = ("--sizes", "6", "--steps", "5e-5", "--quantity", "J", "--set", "time.end=1e-3")


def run(verb: str, scene: Path, out: Path | str, *options: str, ranks: int = 1, cwd: Path | None = None) -> subprocess.CompletedProcess:
    launcher = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    quick = STUDY if verb == "study" else QUICK
    command = [*launcher, str(SIGNORINI), verb, str(scene), "--out", str(out), *quick, *options]
    return captured(command, timeout=120, cwd=cwd)


def refuses(done: subprocess.CompletedProcess, *texts: str) -> None:
    """One sentence and status 2, before any work."""
    own = [line for line in done.stderr.splitlines() if line.startswith("signorini: ")]
    assert done.returncode == 2 and len(own) == 1, (done.stdout, done.stderr)
    assert own[0].startswith("signorini: --out: ") and not [text for text in texts if text not in own[0]]
    assert "unknowns" not in done.stdout, "it had begun"


def content(folder: Path) -> dict[str, bytes | None]:
    return {str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


def files_listed(out: Path) -> list[str]:
    return sorted(json.loads((out / "run.json").read_text())["files"])


def files_there(out: Path) -> list[str]:
    return sorted(path.name for path in out.iterdir())


# --- Files of the user --------------------------------------------------------------------------------------------------


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    """A folder with a scene called scene.toml."""
    folder = tmp_path / "mine"
    folder.mkdir()
    mesh = str((SOURCE / "meshes/half-disc.geo").resolve())
    (folder / "scene.toml").write_text(HALF_DISC.read_text().replace("../meshes/half-disc.geo", mesh))
    return folder


@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("verb", ("simulate", "optimize"))
def test_scene_is_not_replaced(verb: str, ranks: int, mine: Path) -> None:
    """By --out . beside it."""
    before = content(mine)
    refuses(run(verb, Path("scene.toml"), ".", ranks=ranks, cwd=mine), "scene.toml", "choose another folder")
    assert content(mine) == before


def test_echo_is_run_again_until_it_is_edited(mine: Path, tmp_path: Path) -> None:
    out = tmp_path / "echo"
    assert run("optimize", mine / "scene.toml", out).returncode == 0
    assert run("optimize", out / "scene.toml", out, "--resume").returncode == 0
    edited = out / "scene.toml"
    edited.write_text("# my own\n" + edited.read_text())
    before = content(out)
    refuses(run("optimize", edited, out), "its own scene file")
    assert content(out) == before


@pytest.mark.parametrize("verb, name, ranks", [
    ("simulate", "history.csv", 1), ("simulate", "history.csv", 2), ("simulate", "control.h5", 1), ("optimize", "checkpoint.h5", 1),
    ("optimize", "history.csv", 1), ("simulate", "run.json", 1), ("study", "study.csv", 1), ("study", "study.csv", 2),
    ("study", "rungs", 1),
])  # fmt: skip
def test_files_that_no_run_wrote_stay(verb: str, name: str, ranks: int, tmp_path: Path) -> None:
    """Also where another program's run.json is."""
    out = tmp_path / "foreign"
    out.mkdir()
    if verb != "study":
        (out / "run.json").write_text('{"program": "another"}')
    if name == "rungs":
        (out / name).mkdir()
        (out / name / "ladder.txt").write_text("mine")
    elif name != "run.json":
        (out / name).write_text("mine")
    before = content(out)
    refuses(run(verb, HALF_DISC, out, ranks=ranks), name if verb == "study" else "/", "was not written by a run in that folder")
    assert content(out) == before


def test_file_that_the_list_of_a_run_lacks_stays(tmp_path: Path) -> None:
    """It does not belong to the run, though it is in its folder."""
    out = tmp_path / "listed"
    assert run("simulate", HALF_DISC, out).returncode == 0
    assert files_listed(out) == files_there(out)
    (out / "history.csv").write_text("mine")
    refuses(run("optimize", HALF_DISC, out), "history.csv")
    (out / "history.csv").unlink()
    assert run("optimize", HALF_DISC, out).returncode == 0
    assert files_listed(out) == files_there(out)


@pytest.mark.parametrize("ranks", (1, 2))
def test_optimum_is_not_replaced_by_a_simulation(ranks: int, tmp_path: Path) -> None:
    out = tmp_path / "optimum"
    assert run("optimize", HALF_DISC, out).returncode == 0
    before = content(out)
    refuses(run("simulate", HALF_DISC, out, ranks=ranks), " has an optimum", f"--out {out}-simulate", "--replace")
    assert content(out) == before


def test_replaced_optimum_leaves_its_checkpoint(tmp_path: Path) -> None:
    out = tmp_path / "optimum"
    assert run("optimize", HALF_DISC, out).returncode == 0
    assert run("simulate", HALF_DISC, out, "--replace").returncode == 0
    assert (out / "checkpoint.h5").exists() and not (out / "control.h5").exists()
    assert run("optimize", HALF_DISC, out, "--resume").returncode == 0


@pytest.mark.parametrize("name", (b"not UTF-8 \xff", b"two\nlines", b"\x7f\xe9 \"\\n"), ids=("not UTF-8", "two lines", "quote"))
def test_search_resumes_in_a_folder_of_any_name(name: bytes, tmp_path: Path) -> None:
    """Another problem there is refused by its key; a report of the folder, and a comparison, print its name."""
    place = tmp_path / os.fsdecode(name)
    place.mkdir()
    (place / "half-disc.geo").write_bytes((SOURCE / "meshes" / "half-disc.geo").read_bytes())
    scene = place / "scene of mine.toml"
    scene.write_text(HALF_DISC.read_text().replace("../meshes/half-disc.geo", "half-disc.geo"))

    def optimize(*options: str) -> subprocess.CompletedProcess:
        command = [SIGNORINI, "optimize", scene, "--out", place / "out", *QUICK, *options]
        return subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=120)

    more = ("--resume", "--set", "optimizer.max_iterations=3")
    done = optimize()
    assert done.returncode == 0, done.stderr
    done = optimize(*more)
    assert done.returncode == 0 and "resumed after iteration 2" in done.stdout, done.stderr
    done = optimize(*more, "--set", "objective.alpha=7")
    assert done.returncode == 2 and "this scene has objective.alpha = 7;" in done.stderr
    if name.startswith(b"not UTF-8"):
        for given, page in (([place / "out"], "report.html"), ([place / "out", place / "out"], "comparison.html")):
            done = subprocess.run([SIGNORINI, "report", *given], capture_output=True, timeout=120)
            page = place / "out" / page
            assert done.returncode == 0 and done.stdout.endswith(os.fsencode(page) + b"\n") and page.is_file(), done.stderr


# --- Several runs -------------------------------------------------------------------------------------------------------


def started(out: Path) -> subprocess.Popen:
    """A search that does not end by itself soon, once its folder has a checkpoint."""
    process = subprocess.Popen([str(SIGNORINI), "optimize", str(HALF_DISC), "--quiet", "--out", str(out), "--set", "mesh.size=2",
                                "--set", 'optimizer.method="projected-gradient"', "--set", "optimizer.max_iterations=100000",
                                "--set", "optimizer.tolerance=0"])  # fmt: skip
    while not (out / "checkpoint.h5").exists():
        assert process.poll() is None, "ended too early"
        time.sleep(0.01)
    return process


def test_second_run_in_a_folder(tmp_path: Path) -> None:
    """It is refused and names the first one, which comes to its end."""
    out = tmp_path / "two"
    with started(out) as first:
        try:
            holder = f'process {first.pid} on "{socket.gethostname()}"'
            refuses(run("optimize", HALF_DISC, out), "in use by", holder)
            refuses(run("optimize", HALF_DISC, out, "--resume", ranks=2), holder)
            refuses(run("simulate", HALF_DISC, out), holder)
            refuses(run("study", HALF_DISC, out), holder)
        finally:
            first.send_signal(signal.SIGINT)
        assert first.wait(timeout=120) == 130
    written = json.loads((out / "run.json").read_text())
    assert written["stop_reason"] == "interrupted" and sorted(written["files"]) == files_there(out)


@pytest.mark.parametrize("resume", ((), ("--resume",)), ids=("anew", "resumed"))
def test_folder_of_a_killed_search_is_free(resume: tuple[str, ...], tmp_path: Path) -> None:
    """kill -9 leaves a lock of no process, and a search's early files, from which the next run resumes or which it replaces."""
    out = tmp_path / "killed"
    first = started(out)
    first.kill()
    first.wait()
    assert LOCK in content(out) and not (out / "run.json").exists()
    done = run("optimize", HALF_DISC, out, "--set", "mesh.size=2", "--set", "time.end=7.5e-3", "--set",
               'optimizer.method="projected-gradient"', *resume)  # fmt: skip
    assert done.returncode == 0 and ("resumed after" in done.stdout) == bool(resume), done.stdout + done.stderr
    assert not [name for name in content(out) if name.startswith(".")]


STALE = {
    "of no process": json.dumps({"process": 4194304, "host": socket.gethostname(), "early": []}),
    "empty": "",
    "of another program": "nothing of ours",
}


@pytest.mark.parametrize("lock", STALE.values(), ids=STALE)
def test_stale_lock(lock: str, tmp_path: Path) -> None:
    (tmp_path / LOCK).write_text(lock)
    assert run("simulate", HALF_DISC, tmp_path).returncode == 0 and LOCK not in content(tmp_path)


def test_run_that_fails_leaves_no_folder(tmp_path: Path) -> None:
    out = tmp_path / "failed"
    assert run("simulate", HALF_DISC, out, "--set", "contact.on=nothing").returncode == 2 and not out.exists()


# --- Scratch folders ----------------------------------------------------------------------------------------------------


def test_states_on_disk(tmp_path: Path) -> None:
    """Files for the states of a motion are made in a folder of the process alone, and are gone once they are open."""
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    log = tmp_path / "log"
    env = os.environ | {"TMPDIR": str(scratch), "LD_PRELOAD": preloadable(FAULTS, tmp_path), "SIGNORINI_FAIL_UNDER": str(scratch),
                        "SIGNORINI_FAIL_LOG": str(log)}  # fmt: skip
    subprocess.run([str(SIGNORINI), "optimize", str(HALF_DISC), "--quiet", "--out", str(tmp_path / "disk"), *QUICK, "--set",
                    'trajectory.storage="disk"'], check=True, env=env)  # fmt: skip
    made = [line.split(" ", 2)[2] for line in log.read_text().splitlines() if " create " in line or " open " in line]
    states = [path for path in made if path.startswith("signorini-")]
    assert states and all(re.fullmatch(r"signorini-\w{6}/states", path) for path in states)
    assert not [path for path in scratch.iterdir() if path.name.startswith("signorini-")]


def test_scratch_folder_of_dev(tmp_path: Path) -> None:
    """Where dev makes one, it is nobody else's, whatever has the names that it might take, and is gone at its end."""
    name = f"test-{os.getpid()}"
    hostile, elsewhere = Path("/var/tmp") / f"signorini-{name}", tmp_path / "elsewhere"
    elsewhere.mkdir(mode=0o777)
    hostile.symlink_to(elsewhere)
    text = (SOURCE / "dev").read_text()
    functions = text[: text.index('\nverb=${1:-help}')].replace('here=$(cd "$(dirname "$0")" && pwd -P)', f"here='{SOURCE}'")
    script = tmp_path / "dev"
    script.write_text(functions + f"""
on_system() {{ return 1; }}
id() {{ case $1 in -u) echo 1000 ;; *) echo {name} ;; esac; }}
unshare() {{ echo "$TMPDIR"; stat -L -c %a "$TMPDIR"; stat -L -c %u "$TMPDIR"; touch "$TMPDIR/left"; }}
inside true
inside true
""")
    env = os.environ | {"SIGNORINI_BUILD": str(tmp_path / "build"), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    try:
        said = subprocess.run(["sh", str(script)], capture_output=True, text=True, check=True, env=env)
    finally:
        hostile.unlink()
    place, mode, owner, again, *_ = said.stdout.split()
    assert Path(place).resolve() != elsewhere.resolve() and place == again
    assert mode == "700" and int(owner) == os.getuid() and not Path(place).exists()
    assert not list(elsewhere.iterdir())
