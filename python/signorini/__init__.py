# SPDX-License-Identifier: GPL-3.0-or-later
"""Optimal control of dynamic contact with exact discrete gradients::

    import signorini
    scene = signorini.Scene("scenes/half-disc.toml", {"mesh.size": 1})
    run = scene.simulate()                       # as the program does; its tables, fields and page
    problem = scene.problem()                    # J of the control: value, derivative, Hessian product
    fit = scene.fit()                            # residuals of a scene's measurements by its unknowns
    run = signorini.read("results/half-disc")    # of a run made before

All of it works under `mpirun -n 2 python3 -m mpi4py script.py`, where every rank makes the same calls, in the same
order; "collective" in a docstring says which calls those are. An exception that one rank does not catch ends all ranks,
after its message; `-m mpi4py` does so at sys.exit() with another status than 0, too. Ctrl-C stops a sweep after the time
step that it is at, and raises KeyboardInterrupt.

Threads may share an object: computations wait for each other. On several ranks one thread makes all collective calls.
"""

import atexit

from . import _signorini

_signorini.require_temporary_folder()  # before MPI starts, which would crash
try:
    from mpi4py import MPI as _MPI  # starts MPI, and ends it after PETSc
except ImportError:  # then the module does both
    _MPI = None

_signorini.start()
atexit.register(_signorini.leave)

SceneError = _signorini.SceneError
SolverFailure = _signorini.SolverFailure
for _error in (SceneError, SolverFailure):
    _error.__module__ = __name__
SceneError.__doc__ = "The scene, the mesh, an override or a folder is wrong: what, where, what was found, what is allowed."
SolverFailure.__doc__ = "A solver failed: at which step, why, with which residual."

from .fit import Fit  # noqa: E402
from .problem import Metric, Problem, Replicated  # noqa: E402
from .run import Field, Run, read  # noqa: E402
from .scene import Scene  # noqa: E402
from .world import RANK as rank  # noqa: E402, N811
from .world import RANKS as ranks  # noqa: E402, N811
from .world import end_all_at_exceptions as _end_all_at_exceptions  # noqa: E402

_end_all_at_exceptions()

__all__ = ["Field", "Fit", "Metric", "Problem", "Replicated", "Run", "Scene", "SceneError", "SolverFailure", "rank", "ranks", "read", "versions"]


def versions() -> str:
    """Those of signorini and of its main libraries."""
    return _signorini.versions()
