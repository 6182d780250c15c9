# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of the Python module share. SOURCE is their last argument but options."""

import sys
from pathlib import Path

import numpy as np

import signorini

SOURCE = Path(__file__).resolve().parents[2]
SCENES = SOURCE / "scenes"
PUSHED = ["0", "-0.9*(1 + 0.2*sin(800*t))"]  # a control under which the half disc touches, leaves and comes back


def half_disc(size: float = 2, **overrides: object) -> signorini.Scene:
    """The half disc; an override key's double underscore stands for the dot."""
    return signorini.Scene(SCENES / "half-disc.toml", {"mesh.size": size, **{key.replace("__", "."): one for key, one in overrides.items()}})


def direction(problem: signorini.Problem, phase: float = 0.0) -> np.ndarray:
    """A smooth change of the control, the same on any number of ranks."""
    x, t = problem.points @ [0.13, 0.21, 0.17][: problem.points.shape[1]], problem.times / problem.times[-1]
    components = [np.sin(3 * t[:, None] + x + phase + c) for c in range(len(problem.components))]
    return np.stack(components, axis=2).reshape(problem.shape)


def show(text: str) -> None:
    """Prints on rank 0."""
    if signorini.rank == 0:
        print(text, flush=True)


def raised(kind: type, call: object) -> str:
    """The sentence of the error that a call raises. Fails if it raises none."""
    try:
        call()
    except kind as error:
        return str(error)
    raise AssertionError(f"{call} raised no {kind.__name__}")


sys.stdout.reconfigure(line_buffering=True)
