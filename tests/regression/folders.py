# SPDX-License-Identifier: GPL-3.0-or-later
"""A run has its folder for itself and replaces nothing there that no run wrote; what lies in folders that anyone may write to is its
own from the start.

    folders.py SIGNORINI SOURCE LIBRARY (tests/faults/fail_nth.c)"""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SIGNORINI, SOURCE, captured, preloadable  # noqa: E402

LIBRARY = Path(sys.argv[3]).resolve()
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
    assert done.returncode == 2 and len(own) == 1, (done.returncode, done.stdout, done.stderr)
    assert own[0].startswith("signorini: --out: ") and all(text in own[0] for text in texts), own[0]
    assert "unknowns" not in done.stdout, "it had begun"


def content(folder: Path) -> dict[str, bytes | None]:
    return {str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


def scene_of_the_users(folder: Path) -> None:
    """--out . beside a scene called scene.toml; the echo of a run may be run again in its folder until it is edited."""
    mine = folder / "mine"
    mine.mkdir()
    mesh = str((SOURCE / "meshes/half-disc.geo").resolve())
    (mine / "scene.toml").write_text(HALF_DISC.read_text().replace("../meshes/half-disc.geo", mesh))
    before = content(mine)
    for verb in ("simulate", "optimize"):
        for ranks in (1, 2):
            refuses(run(verb, Path("scene.toml"), ".", ranks=ranks, cwd=mine), "scene.toml", "choose another folder")
            assert content(mine) == before
    out = folder / "echo"
    assert run("optimize", mine / "scene.toml", out).returncode == 0
    assert run("optimize", out / "scene.toml", out, "--resume").returncode == 0
    edited = out / "scene.toml"
    edited.write_text("# my own\n" + edited.read_text())
    before = content(out)
    refuses(run("optimize", edited, out), "its own scene file")
    assert content(out) == before
    print("the scene that is run is not replaced, unless it is the echo of a run")


def files_of_the_users(folder: Path) -> None:
    """Files with a run's names that no run wrote stay, and so do they where another program's run.json is."""
    for number, (verb, name) in enumerate((("simulate", "history.csv"), ("simulate", "control.h5"), ("optimize", "checkpoint.h5"),
                                           ("optimize", "history.csv"), ("simulate", "run.json"), ("study", "study.csv"),
                                           ("study", "rungs"))):  # fmt: skip
        for ranks in (1, 2) if number in (0, 5) else (1,):
            out = folder / f"foreign-{number}-{ranks}"
            out.mkdir()
            (out / "run.json").write_text('{"program": "another"}')
            if name == "rungs":
                (out / name).mkdir()
                (out / name / "ladder.txt").write_text("mine")
            elif name != "run.json":
                (out / name).write_text("mine")
            if verb == "study":
                (out / "run.json").unlink()
            before = content(out)
            refuses(run(verb, HALF_DISC, out, ranks=ranks), name if verb == "study" else "/", "was not written by a run in that folder")
            assert content(out) == before
    # What another run's list leaves out is not its own, though it stands in its folder.
    out = folder / "listed"
    assert run("simulate", HALF_DISC, out).returncode == 0
    listed = json.loads((out / "run.json").read_text())["files"]
    assert sorted(listed) == sorted(path.name for path in out.iterdir())
    (out / "history.csv").write_text("mine")
    refuses(run("optimize", HALF_DISC, out), "history.csv")
    (out / "history.csv").unlink()
    assert run("optimize", HALF_DISC, out).returncode == 0
    assert sorted(json.loads((out / "run.json").read_text())["files"]) == sorted(path.name for path in out.iterdir())
    before = content(out)
    for ranks in (1, 2):
        refuses(run("simulate", HALF_DISC, out, ranks=ranks), " has an optimum", f"--out {out}-simulate", "--replace")
        assert content(out) == before
    assert run("simulate", HALF_DISC, out, "--replace").returncode == 0
    assert (out / "checkpoint.h5").exists() and not (out / "control.h5").exists()
    assert run("optimize", HALF_DISC, out, "--resume").returncode == 0
    print("files that no run wrote stay, with one sentence")


def started(out: Path, *options: str) -> subprocess.Popen:
    """A run that does not end by itself soon, from where it has its folder on and a line of its history is there."""
    process = subprocess.Popen([str(SIGNORINI), "optimize", str(HALF_DISC), "--quiet", "--out", str(out), "--set", "mesh.size=2",
                                "--set", 'optimizer.method="projected-gradient"', "--set", "optimizer.max_iterations=100000",
                                "--set", "optimizer.tolerance=0", *options])  # fmt: skip
    while not (out / "checkpoint.h5").exists():
        assert process.poll() is None, "ended too early"
        time.sleep(0.01)
    return process


def two_at_once(folder: Path) -> None:
    out = folder / "two"
    first = started(out)
    holder = f'process {first.pid} on "{socket.gethostname()}"'
    refuses(run("optimize", HALF_DISC, out), "in use by", holder)
    refuses(run("optimize", HALF_DISC, out, "--resume", ranks=2), holder)
    refuses(run("simulate", HALF_DISC, out), holder)
    refuses(run("study", HALF_DISC, out), holder)
    first.send_signal(signal.SIGINT)
    assert first.wait(timeout=120) == 130
    written = json.loads((out / "run.json").read_text())
    assert written["stop_reason"] == "interrupted" and sorted(written["files"]) == sorted(path.name for path in out.iterdir())
    print("a second run in a folder is told who has it, and the first comes to its end")


def killed(folder: Path) -> None:
    """kill -9 leaves a lock that nobody holds, and a search's early files, which the next run goes on from or replaces."""
    for resume in ((), ("--resume",)):
        out = folder / f"killed{len(resume)}"
        first = started(out)
        first.kill()
        first.wait()
        assert LOCK in content(out) and not (out / "run.json").exists()
        done = run("optimize", HALF_DISC, out, "--set", "mesh.size=2", "--set", "time.end=7.5e-3", "--set",
                   'optimizer.method="projected-gradient"', *resume)  # fmt: skip
        assert done.returncode == 0 and ("resumed after" in done.stdout) == bool(resume), done.stdout + done.stderr
        assert not [name for name in content(out) if name.startswith(".")]
    for number, text in enumerate((json.dumps({"process": 4194304, "host": socket.gethostname(), "early": []}), "", "nothing of ours")):
        out = folder / f"stale-{number}"
        out.mkdir()
        (out / LOCK).write_text(text)
        assert run("simulate", HALF_DISC, out).returncode == 0 and LOCK not in content(out)
    failed = folder / "failed"
    assert run("simulate", HALF_DISC, failed, "--set", "contact.on=nothing").returncode == 2 and not failed.exists()
    print("after kill -9 the folder is free, and what the search left is known")


def states_on_disk(folder: Path) -> None:
    """Files for the states of a motion are made in a folder of the process alone, and are gone once they are open."""
    scratch = folder / "scratch"
    scratch.mkdir()
    log = folder / "log"
    env = os.environ | {"TMPDIR": str(scratch), "LD_PRELOAD": preloadable(LIBRARY, folder), "SIGNORINI_FAIL_UNDER": str(scratch),
                        "SIGNORINI_FAIL_LOG": str(log)}  # fmt: skip
    subprocess.run([str(SIGNORINI), "optimize", str(HALF_DISC), "--quiet", "--out", str(folder / "disk"), *QUICK, "--set",
                    'trajectory.storage="disk"'], check=True, env=env)  # fmt: skip
    made = [line.split(" ", 2)[2] for line in log.read_text().splitlines() if " create " in line or " open " in line]
    states = [path for path in made if path.startswith("signorini-")]
    assert states and all(re.fullmatch(r"signorini-\w{6}/states", path) for path in states), states
    assert not [path for path in scratch.iterdir() if path.name.startswith("signorini-")]
    print("states on disk: in a folder of the process alone, gone as soon as they are open")


def scratch_of_dev(folder: Path) -> None:
    """dev's scratch folder, where it makes one, is nobody else's, whatever lies under the names that it might take."""
    name = f"test-{os.getpid()}"
    hostile, elsewhere = Path("/var/tmp") / f"signorini-{name}", folder / "elsewhere"
    elsewhere.mkdir(mode=0o777)
    hostile.symlink_to(elsewhere)
    text = (SOURCE / "dev").read_text()
    functions = text[: text.index('\nverb=${1:-help}')].replace('here=$(cd "$(dirname "$0")" && pwd -P)', f"here='{SOURCE}'")
    script = folder / "dev"
    script.write_text(functions + f"""
on_system() {{ return 1; }}
id() {{ case $1 in -u) echo 1000 ;; *) echo {name} ;; esac; }}
unshare() {{ echo "$TMPDIR"; stat -L -c %a "$TMPDIR"; stat -L -c %u "$TMPDIR"; touch "$TMPDIR/left"; }}
inside true
inside true
""")
    try:
        said = subprocess.run(["sh", str(script)], capture_output=True, text=True, check=True,
                              env=os.environ | {"SIGNORINI_BUILD": str(folder / "build"), "XDG_CACHE_HOME": str(folder / "cache")})  # fmt: skip
    finally:
        hostile.unlink()
    place, mode, owner, again, *_ = said.stdout.split()
    assert Path(place).resolve() != elsewhere.resolve() and place == again, said.stdout
    assert mode == "700" and int(owner) == os.getuid() and not Path(place).exists(), said.stdout
    assert not list(elsewhere.iterdir())
    print("dev: a scratch folder that nobody can have made before, gone at its end")


def any_name(folder: Path) -> None:
    """A search goes on in a folder whose name is not UTF-8, or has a line break; another problem there is refused by its key."""
    for name in (b"not UTF-8 \xff", b"two\nlines", b"\x7f\xe9 \"\\n"):
        place = folder / os.fsdecode(name)
        place.mkdir()
        (place / "half-disc.geo").write_bytes((SOURCE / "meshes" / "half-disc.geo").read_bytes())
        scene = place / "scene of mine.toml"
        scene.write_text(HALF_DISC.read_text().replace("../meshes/half-disc.geo", "half-disc.geo"))
        more = ("--resume", "--set", "optimizer.max_iterations=3")
        for options in ((), more, (*more, "--set", "objective.alpha=7")):
            done = subprocess.run([SIGNORINI, "optimize", scene, "--out", place / "out", *QUICK, *options], capture_output=True, text=True, errors="replace",
                                  timeout=120)  # fmt: skip
            assert options[-1:] == ("objective.alpha=7",) or done.returncode == 0, done.stderr
            assert options != more or "resumed after iteration 2" in done.stdout, done.stdout
        assert done.returncode == 2 and "this scene has objective.alpha = 7;" in done.stderr, done.stderr
        if name.startswith(b"not UTF-8"):
            for given in ([place / "out"], [place / "out", place / "out"]):
                done = subprocess.run([SIGNORINI, "report", *given], capture_output=True, timeout=120)
                page = place / "out" / ("report.html" if len(given) == 1 else "comparison.html")
                assert done.returncode == 0 and done.stdout.endswith(os.fsencode(page) + b"\n") and page.is_file(), (done.stdout, done.stderr)
    print("searches go on in folders of any name")


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        for part in (scene_of_the_users, files_of_the_users, any_name, two_at_once, killed, states_on_disk, scratch_of_dev):
            part(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
