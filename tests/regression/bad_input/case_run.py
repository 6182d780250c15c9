# SPDX-License-Identifier: GPL-3.0-or-later
"""Running a case: its folder, its command line, what became of the folder."""

import os
import re
import resource
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import resident
from case import SCENE, Case, square2, write
from harness import SIGNORINI

TIME_LIMIT = 120  # s; a case takes a fraction of a second unless the program hangs
EARLIER = {"run.json": '{ "versions": { "signorini": "0" }, "files": ["run.json", "state.h5"] }\n', "state.h5": "earlier fields",
           "notes.txt": "keep me\n"}  # fmt: skip
NOISE = re.compile(
    r"PETSC ERROR|HDF5-DIAG|Traceback|terminate called|MPI_ABORT|MPI_ERR|Segmentation|Process received signal|"
    r"^(Error|Warning|Info) +:",
    re.MULTILINE,
)
# A library's or the program's own insides say nothing to the user.
INSIDES = re.compile(r"\.unfinished|std::|vector::|\(\)|\bPETSc failed|\bbasic_|\bunknown error\b")


def scene_of(case: Case) -> str:
    """The case's scene."""
    text = SCENE
    for old, new in case.edits:
        assert old in text, f"{case.name}: the scene has no {old!r}"
        text = text.replace(old, new, 1)
    return text


def fill(folder: Path, case: Case) -> None:
    """Writes the scene, the mesh and whatever else the case has."""
    write(folder / "scene.toml", scene_of(case) if case.scene is None else case.scene)
    write(folder / case.mesh_file, square2() if case.mesh is None else case.mesh)
    if case.earlier:
        (folder / "results").mkdir()
        for name, text in EARLIER.items():
            write(folder / "results" / name, text)
    if case.prepare:
        case.prepare(folder)


def content(folder: Path) -> dict[str, bytes | None]:
    """Every file below a folder with its bytes, hidden ones included; None stands for a folder or a dead link."""
    return {str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


def differences(old: dict[str, bytes | None], new: dict[str, bytes | None]) -> list[str]:
    """What became of the files of a folder."""
    return (
        [f"{name} is left over" for name in sorted(new.keys() - old.keys())]
        + [f"{name} is gone" for name in sorted(old.keys() - new.keys())]
        + [f"{name} has changed" for name in sorted(old.keys() & new.keys()) if old[name] != new[name]]
    )


def command_of(case: Case) -> list[str]:
    """The command line of a case."""
    words = case.command
    if words is None:
        folder = () if "--suggest" in case.options else ("--out", case.out)
        words = (case.verb, "scene.toml", *folder, *case.options)
    launcher = ["mpirun", "-n", str(case.ranks)] if case.ranks > 1 else []
    return [*launcher, str(SIGNORINI), *words]


def full_disk(size: int) -> Callable[[], None]:
    """Limits the files that a child process can write: beyond the limit write() fails as it does on a full disk."""

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return limit


def environment(case: Case) -> dict[str, str]:
    """The caller's environment; Open MPI may run as root and on fewer cores than ranks, and fills no files itself."""
    defaults = {
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
        "PRTE_MCA_mapby": ":oversubscribe",
        "OMP_NUM_THREADS": "1",
    }
    return {**defaults, **os.environ, **({"OMPI_MCA_btl": "self"} if case.largest_file else {})}


def run(case: Case, folder: Path) -> subprocess.CompletedProcess:
    """Runs a case in its folder, as text. Raises subprocess.TimeoutExpired."""
    if case.ranks == 1 and case.largest_file is None:
        done = resident.run(command_of(case), cwd=folder, env=environment(case), timeout=TIME_LIMIT)
    else:
        done = subprocess.run(
            command_of(case),
            cwd=folder,
            env=environment(case),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            restore_signals=case.largest_file is None,
            preexec_fn=full_disk(case.largest_file) if case.largest_file else None,
            timeout=TIME_LIMIT,
        )
    done.stdout, done.stderr = done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")
    return done
