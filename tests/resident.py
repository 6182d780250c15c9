# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs of one rank without the half second that loading two hundred libraries takes: see resident.c."""

import os
import signal
import socket
import struct
import subprocess
import tempfile
import threading
from pathlib import Path

LIBRARY = os.environ.get("SIGNORINI_RESIDENT_LIBRARY")  # of the build; without it every run is started afresh


class Resident:
    """A program that waits, loaded. One run at a time."""

    def __init__(self, program: str, preload: str):
        self.ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs, tempfile.TemporaryDirectory() as folder:
            link = Path(folder) / "resident.so"  # names in LD_PRELOAD end at a space or a colon
            link.symlink_to(LIBRARY)
            env = os.environ | {"LD_PRELOAD": f"{link} {preload}", "SIGNORINI_RESIDENT": str(theirs.fileno())}
            self.process = subprocess.Popen([program], env=env, pass_fds=[theirs.fileno()])
            self.run([program, "--help"], Path(folder), dict(os.environ), 120)  # an answer: the link is needed no more

    def run(self, command: list[str], cwd: Path, env: dict[str, str], timeout: float | None) -> subprocess.CompletedProcess:
        """As subprocess.run does with captured output and no input."""
        entries = [str(cwd), *command, *(f"{name}={value}" for name, value in env.items())]
        request = struct.pack("=ii", len(command), len(env)) + b"".join(os.fsencode(entry) + b"\0" for entry in entries)
        with open(os.devnull) as nothing, tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            socket.send_fds(self.ours, [request], [nothing.fileno(), out.fileno(), err.fileno()])
            process = self.answer()
            self.ours.settimeout(timeout)
            try:
                status = self.answer()
            except TimeoutError:
                os.kill(process, signal.SIGKILL)
                self.ours.settimeout(None)
                self.answer()
                raise subprocess.TimeoutExpired(command, timeout or 0) from None
            out.seek(0), err.seek(0)
            return subprocess.CompletedProcess(command, os.waitstatus_to_exitcode(status), out.read(), err.read())

    def answer(self) -> int:
        message = self.ours.recv(4)
        assert len(message) == 4, f"the waiting program ended with {self.process.wait()}"
        return struct.unpack("=i", message)[0]


RESIDENTS = threading.local()  # by program and preloaded library; of each thread, for one of them runs one thing at a time


def run(
    command: list[str], cwd: Path | None = None, env: dict[str, str] | None = None, timeout: float | None = None
) -> subprocess.CompletedProcess:
    """subprocess.run of a program of ours on one rank, without input, its output captured as bytes."""
    if LIBRARY is None:
        return subprocess.run(command, cwd=cwd, env=env, timeout=timeout, stdin=subprocess.DEVNULL, capture_output=True)
    env = dict(os.environ) if env is None else env
    kind = command[0], env.get("LD_PRELOAD", "")
    residents = RESIDENTS.__dict__.setdefault("made", {})
    if kind not in residents:
        residents[kind] = Resident(*kind)
    return residents[kind].run(command, cwd or Path.cwd(), env, timeout)
