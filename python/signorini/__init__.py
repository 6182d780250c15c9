# SPDX-License-Identifier: GPL-3.0-or-later
"""Optimal control of dynamic contact with exact discrete gradients::

    import signorini
    scene = signorini.Scene("scenes/half-disc.toml", {"mesh.size": 1})
    run = scene.simulate()                       # as the program does; tables, fields and a page
    problem = scene.problem()                    # J of the control: value, derivative, Hessian product
    fit = scene.fit()                            # residuals of a scene's measurements by its unknowns
    run = signorini.read("results/half-disc")    # an earlier run

The package works under `mpirun -n 2 python3 -m mpi4py script.py`. Every rank makes the calls that docstrings name
"collective", in the same order. An exception that one rank does not catch ends all ranks, after its message; `-m mpi4py`
does so at sys.exit() with another status than 0, too. Ctrl-C stops a sweep after the current time step, and raises
KeyboardInterrupt.

The compiled module is loaded, and MPI started, when a name of this package is first used. The package signorini.post,
which draws the results of runs, does neither.

Threads may share an object: computations wait for each other. On several ranks one thread makes all collective calls.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .program import *  # noqa: F403

__all__ = ["Field", "Fit", "Metric", "Problem", "Replicated", "Run", "Scene", "SceneError", "SolverFailure", "rank", "ranks", "read", "versions"]


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module 'signorini' has no attribute {name!r}")
    from . import program  # noqa: PLC0415

    return getattr(program, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
