# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of the Python module share: the half disc, a change of its control, Python started anew on several ranks."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

import signorini

HERE = Path(__file__).resolve().parent
SCENES = HERE.parents[1] / "scenes"
PUSHED = ["0", "-0.9*(1 + 0.2*sin(800*t))"]  # a control under which the half disc touches, leaves and comes back


def half_disc(size: float = 2, **overrides: object) -> signorini.Scene:
    """The half disc; an override key's double underscore stands for the dot."""
    keys = {key.replace("__", "."): one for key, one in overrides.items()}
    return signorini.Scene(SCENES / "half-disc.toml", {"mesh.size": size, **keys})


def direction(problem: signorini.Problem, phase: float = 0.0) -> np.ndarray:
    """A smooth change of the control, the same on any number of ranks."""
    x, t = problem.points @ [0.13, 0.21, 0.17][: problem.points.shape[1]], problem.times / problem.times[-1]
    components = [np.sin(3 * t[:, None] + x + phase + c) for c in range(len(problem.components))]
    return np.stack(components, axis=2).reshape(problem.shape)


def started(*arguments: object, ranks: int = 1, mpi4py: bool = True, **options: object) -> subprocess.CompletedProcess:
    """Python on a script or with -c, in a world of its own, where `common` can be imported. With mpi4py all ranks end
    where one fails. Raises TimeoutExpired where Python never ends."""
    command = ["mpirun", "--oversubscribe", "-n", str(ranks)] * (ranks > 1) + [sys.executable]
    command += ["-m", "mpi4py"] * mpi4py + [str(argument) for argument in arguments]
    # Without what MPI, which this process may have started, left in the environment.
    env = {key: value for key, value in os.environ.items() if not key.startswith(("PMIX_", "PRTE_MCA_ess", "OMPI_COMM_WORLD"))}
    env |= {"PYTHONPATH": f"{HERE}:{env['PYTHONPATH']}"} | options.pop("env", {})
    return subprocess.run(command, capture_output=True, text=True, timeout=400, env=env, **options)
