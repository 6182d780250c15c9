# SPDX-License-Identifier: GPL-3.0-or-later
"""Exchange among the ranks of MPI_COMM_WORLD, on which everything runs; one rank alone does not need mpi4py."""

import sys
from types import TracebackType
from typing import TypeVar

from . import _signorini

try:
    from mpi4py import MPI

    WORLD = MPI.COMM_WORLD
    RANK, RANKS = WORLD.rank, WORLD.size
except ImportError:
    WORLD = None
    RANK, RANKS = 0, 1
    if _signorini.ranks() > 1:
        raise ImportError(f"signorini: found {_signorini.ranks()} ranks without mpi4py; install mpi4py, or use one rank") from None

T = TypeVar("T")


def from_root(value: T) -> T:
    """Returns the argument of rank 0 on every rank. Collective."""
    return WORLD.bcast(value) if RANKS > 1 else value


def of_all(value: T) -> list[T]:
    """Returns the arguments of all ranks, in the order of the ranks, on every rank. Collective."""
    return WORLD.allgather(value) if RANKS > 1 else [value]


def end_all_at_exceptions() -> None:
    """Makes an exception that is not caught end all ranks; otherwise the others would wait for this one for ever."""
    if RANKS == 1:
        return
    report = sys.excepthook

    def report_and_end(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        report(kind, error, trace)
        print(f"signorini: rank {RANK} of {RANKS} failed and ends all ranks", file=sys.stderr)
        sys.stdout.flush()
        sys.stderr.flush()
        WORLD.Abort(130 if issubclass(kind, KeyboardInterrupt) else 1)

    sys.excepthook = report_and_end


def wait() -> None:
    """Waits until all ranks have made this call. Collective."""
    if RANKS > 1:
        WORLD.Barrier()
