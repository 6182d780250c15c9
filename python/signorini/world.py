# SPDX-License-Identifier: GPL-3.0-or-later
"""What the ranks of MPI_COMM_WORLD, on which everything runs, tell each other; nothing of it needs mpi4py on one."""

from typing import TypeVar

try:
    from mpi4py import MPI

    WORLD = MPI.COMM_WORLD
    RANK, RANKS = WORLD.rank, WORLD.size
except ImportError:
    WORLD = None
    RANK, RANKS = 0, 1

T = TypeVar("T")


def from_root(value: T) -> T:
    """What rank 0 has. Collective."""
    return WORLD.bcast(value) if RANKS > 1 else value


def of_all(value: T) -> list[T]:
    """What each has. Collective."""
    return WORLD.allgather(value) if RANKS > 1 else [value]


def wait() -> None:
    """Until every rank is here. Collective."""
    if RANKS > 1:
        WORLD.Barrier()
