# SPDX-License-Identifier: GPL-3.0-or-later
"""Public names of the package signorini. Importing this module starts MPI."""

import atexit

from . import _signorini

_signorini.require_temporary_folder()  # before MPI starts, which would crash without one
try:
    from mpi4py import MPI as _MPI  # starts MPI, and ends it after PETSc
except ImportError:  # then the module does both
    _MPI = None

_signorini.start()
atexit.register(_signorini.leave)

SceneError = _signorini.SceneError
SolverFailure = _signorini.SolverFailure
for _error in (SceneError, SolverFailure):
    _error.__module__ = __package__
SceneError.__doc__ = "The scene, the mesh, an override or a folder is wrong: what, where, what was found, what to do."
SolverFailure.__doc__ = "A solver failed: at which step, why, with which residual."

from .fit import Fit  # noqa: E402
from .problem import Metric, Problem, Replicated  # noqa: E402
from .run import Field, Run, read  # noqa: E402
from .scene import Scene  # noqa: E402
from .world import RANK as rank  # noqa: E402, N811
from .world import RANKS as ranks  # noqa: E402, N811
from .world import end_all_at_exceptions as _end_all_at_exceptions  # noqa: E402

_end_all_at_exceptions()


def versions() -> str:
    """Versions of signorini and of its main libraries."""
    return _signorini.versions()
