# SPDX-License-Identifier: GPL-3.0-or-later
"""The control problem of a scene, for any optimizer.

u is an array (intervals × values): row j is the control on time interval j, place by place and, at a place, component by
component. On several ranks each has its own places, and arrays are local parts. J(u) has

- a *derivative* dJ(u) (intervals × values), dJ/du by the entries: what SciPy and other optimizers of R^n call the gradient.
  In a change d of the control J changes by the sum of the entries of dJ · d, in first order: `Problem.pairing(dJ, d)`;
- its *Riesz representative* g in the metric: `metric.product(g, d)` is that same number. It is the field to plot,
  and steps along it do not depend on the mesh. `metric.apply_inverse(dJ)` is g.

Without bounds the metric is the product of L2(0,T; L2). With bounds it has the lumped mass matrix, with which clipping is
the projection; for values on cells the mass matrix is diagonal anyway.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _signorini
from .world import RANK, RANKS, WORLD, of_all

if TYPE_CHECKING:
    from .scene import Scene


def fixed(values: np.ndarray | None) -> np.ndarray | None:
    """Returns the array, made read-only, since the solver computes with its memory; None for None."""
    if values is not None:
        values.flags.writeable = False
    return values


def shaped(values: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Returns the array unchanged. Raises ValueError if its shape differs from `shape`."""
    if np.shape(values) != shape:
        raise ValueError(f"found an array of shape {np.shape(values)}; expected {shape}")
    return values


class Sweeps(NamedTuple):
    """Numbers of sweeps so far; a linearised sweep counts as a forward sweep."""

    forward: int
    adjoint: int


class Parts(NamedTuple):
    """Parts of the objective J."""

    tracking: float
    terminal: float
    control: float


class Batch(NamedTuple):
    """J of several controls, and its derivatives by their entries (controls × intervals × values) if requested."""

    values: np.ndarray
    gradients: np.ndarray | None


class Metric:
    """The product in which the scene's optimizer measures controls, a symmetric positive matrix. All members are
    collective."""

    def __init__(self, problem: _signorini.ControlProblem) -> None:
        self._problem = problem

    def product(self, u: np.ndarray, w: np.ndarray) -> float:
        """Returns the metric's product of two controls, summed over all ranks."""
        return self._problem.inner(u, w)

    def apply(self, u: np.ndarray) -> np.ndarray:
        """Returns the metric's matrix times a control, the derivative of half the squared norm. (intervals × values)"""
        return self._problem.dual(u)

    def apply_inverse(self, d: np.ndarray) -> np.ndarray:
        """Returns the Riesz representative of a derivative: the metric's inverse matrix times d, up to rounding. (intervals × values)"""
        return self._problem.riesz(d)

    @cached_property
    def diagonal(self) -> np.ndarray | None:
        """Diagonal of the metric's matrix if the matrix is diagonal, as with bounds or values on cells; else None. (intervals × values)"""
        return self.weights if self._problem.diagonal else None

    @cached_property
    def weights(self) -> np.ndarray:
        """`diagonal` if there is one, else that of the lumped matrix, which is near the matrix on every mesh. In entries scaled
        by its root, u·√weights, the Euclidean product is nearly the metric's. (intervals × values)"""
        return fixed(self._problem.weights())


class Problem:
    """J(u) of a scene's control, reduced to the control, with derivatives by adjoint sweeps: see the module's text.

    The motions of the last two controls are cached: evaluating them again makes no sweep. Arrays that methods return own
    their memory, which is the solver's, not a copy; arrays that are attributes are read-only. Members that take a control are
    collective. They raise SolverFailure if a step has no solution, KeyboardInterrupt at Ctrl-C, and ValueError on every rank
    if one rank's array has another shape, nan or inf.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._problem = _signorini.ControlProblem(scene._scene)
        self.metric = Metric(self._problem)

    @property
    def comm(self) -> object:
        """Communicator (mpi4py) of all ranks; None without mpi4py."""
        return WORLD

    # --- Controls ---------------------------------------------------------------------------------------

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of a control on this rank: intervals × values."""
        return self._problem.intervals, self._problem.width

    @property
    def size(self) -> int:
        """Number of entries of a control on this rank."""
        return self._problem.intervals * self._problem.width

    def zero(self) -> np.ndarray:
        """Returns a control that is zero."""
        return self._problem.zero()

    def first_guess(self) -> np.ndarray:
        """Returns the scene's control.initial, clipped to the bounds. Collective."""
        return self._problem.first_guess()

    @cached_property
    def lower(self) -> np.ndarray | None:
        """Lower bound of each value of a control; None without lower bounds."""
        return fixed(self._problem.lower())

    @cached_property
    def upper(self) -> np.ndarray | None:
        """Upper bound of each value of a control; None without upper bounds."""
        return fixed(self._problem.upper())

    @cached_property
    def times(self) -> np.ndarray:
        """Middle of each interval, s; 0 for a control that is constant in time. (intervals)"""
        return fixed(self._problem.times())

    @cached_property
    def lengths(self) -> np.ndarray:
        """Lengths of the intervals, s. (intervals)"""
        return fixed(self._problem.lengths())

    @cached_property
    def points(self) -> np.ndarray:
        """Points of the control's values on this rank: nodes or midpoints of cells of the undeformed body, m. (places × dim)"""
        return fixed(self._problem.points())

    @property
    def components(self) -> str:
        """Components in which the control acts, such as "xy". u.reshape(len(times), len(points), len(components)) separates them."""
        return "".join("xyz"[one] for one in self._problem.components)

    # --- J and its derivatives ------------------------------------------------------------------------

    def value(self, u: np.ndarray) -> float:
        """Returns J(u), computed by a forward sweep."""
        return self._problem.value(u)

    def value_and_gradient(self, u: np.ndarray) -> tuple[float, np.ndarray]:
        """Returns J(u) and its *derivative* by the entries of u (intervals × values), by a forward and an adjoint sweep."""
        return self._problem.value_and_derivative(u)

    def gradient(self, u: np.ndarray) -> np.ndarray:
        """Returns only the derivative of J that value_and_gradient() returns. (intervals × values)"""
        return self.value_and_gradient(u)[1]

    def batch(self, controls: npt.ArrayLike, gradients: bool = False) -> Batch:
        """Returns J of several controls (controls × intervals × values) and, if `gradients`, its derivatives. Up to 16 motions make
        their steps together, which takes a fraction of their time one by one. On one rank a result does not depend on the other
        controls. It differs by rounding from those of value() and value_and_gradient(), whose cached motions stay. Raises ValueError
        unless each control has the shape `shape`."""
        controls = np.ascontiguousarray(controls, dtype=float)
        if controls.shape[1:] != self.shape:
            raise ValueError(f"found controls of shape {controls.shape}; expected (controls, {', '.join(map(str, self.shape))})")
        return Batch(*self._problem.batch(controls, gradients))

    def representative(self, u: np.ndarray) -> np.ndarray:
        """Returns the gradient as a control: the Riesz representative of the derivative in the metric."""
        return self._problem.representative(u)

    def riesz(self, derivative: np.ndarray) -> np.ndarray:
        """Returns the Riesz representative of a derivative in the metric."""
        return self._problem.riesz(derivative)

    def hessian_product(self, u: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Returns the second derivative of J at u in the direction d, as a derivative (intervals × values). A linearised and an
        adjoint sweep have the active sets of u's motion; J is smooth where no small change of u changes these."""
        return self._problem.hessian_product(u, d)

    def pairing(self, derivative: np.ndarray, d: np.ndarray) -> float:
        """Returns the first-order change of J for a change d of the control: the sum of products of entries, over all ranks."""
        return float(sum(of_all(float(np.vdot(shaped(derivative, self.shape), shaped(d, self.shape))))))

    def parts(self, u: np.ndarray) -> Parts:
        """Returns the parts of J(u)."""
        return Parts(*self._problem.parts(u))

    # --- The motion ------------------------------------------------------------------------------------

    @cached_property
    def step_times(self) -> np.ndarray:
        """Times of the states, s. (steps + 1)"""
        return fixed(self._problem.step_times())

    @cached_property
    def nodes(self) -> np.ndarray:
        """Points of this rank's nodes in the undeformed body, m. (nodes × dim)"""
        return fixed(self._problem.nodes())

    def states(self, u: np.ndarray) -> np.ndarray:
        """Returns a copy of the displacements of this rank's nodes at all step_times, in the motion under u, m. (steps + 1 × nodes × dim)"""
        return self._problem.displacements(u, 0, self._problem.steps + 1)

    def displacement(self, u: np.ndarray, step: int) -> np.ndarray:
        """Returns the displacement of this rank's nodes at the end of a step, in the motion under u, m; step 0: the start. (nodes × dim)"""
        if not 0 <= step <= self._problem.steps:
            raise IndexError(f"step: found {step}; expected 0 to {self._problem.steps}")
        return self._problem.displacements(u, step, 1)[0]

    def active(self, u: np.ndarray) -> np.ndarray:
        """Returns the number of active candidates of the whole body at all step_times, in the motion under u; 0 at the start. (steps + 1)"""
        return np.array(self._problem.active(u), dtype=int)

    # --- Costs ------------------------------------------------------------------------------------------

    @property
    def sweeps(self) -> Sweeps:
        """Numbers of sweeps so far."""
        return Sweeps(*self._problem.sweeps())

    @property
    def timings(self) -> dict[str, tuple[float, int]]:
        """Seconds and calls of the phases of the computation on this rank, as in run.json; a phase excludes those within it."""
        return self._problem.timings()

    @property
    def sweep_seconds(self) -> float:
        """Seconds of the solver's own work in value() and value_and_gradient() so far; the rest of the calls' time is spent on arrays
        and in Python."""
        return self._problem.seconds

    # --- Several ranks ---------------------------------------------------------------------------------

    @cached_property
    def _order(self) -> np.ndarray:
        """Permutation from the concatenated values of all ranks to a whole row of a control, whose order does not depend on the ranks."""
        points = np.concatenate(of_all(self.points))
        extent = np.ptp(points, axis=0).max(initial=0) or 1
        places = np.lexsort(np.round(points / extent, 9).T[::-1])
        components = len(self.components)
        return (places[:, None] * components + np.arange(components)).ravel()

    @cached_property
    def _widths(self) -> np.ndarray:
        """Number of values of an interval on each rank."""
        return np.array(of_all(self.shape[1]))

    @property
    def _size_of_all(self) -> int:
        """Number of entries of a control on all ranks."""
        return self.shape[0] * len(self._order)

    @cached_property
    def _of_whole(self) -> tuple[np.ndarray, np.ndarray]:
        """Offsets of this rank's values in the first row of a whole control, and strides to the next row."""
        first = sum(self._widths[:RANK])
        own = np.argsort(self._order)[first : first + self.shape[1] : len(self.components)]
        return own, np.full_like(own, len(self._order))

    @cached_property
    def _of_ranks(self) -> tuple[np.ndarray, np.ndarray]:
        """Offsets of a whole control's values in the concatenated controls of all ranks, and strides to the next row."""
        first = np.concatenate([[0], np.cumsum(self._widths)])
        places = self._order[:: len(self.components)]
        rank = np.searchsorted(first, places, side="right") - 1
        return self.shape[0] * first[rank] + places - first[rank], self._widths[rank]

    def _rows(self, places: tuple[np.ndarray, np.ndarray], row: np.ndarray | None, column: np.ndarray | None) -> _signorini.Rows:
        """Returns the order that takes these places of arrays of all ranks' values, times a factor of each row and of each column."""
        width = len(places[0]) * len(self.components)
        row = np.ones(self.shape[0]) if row is None else row
        return _signorini.Rows(self._size_of_all, *places, row, np.ones(width) if column is None else column)

    def _to_whole(self, row: np.ndarray | None = None, column: np.ndarray | None = None) -> _signorini.Rows:
        return self._rows(self._of_ranks, row, column)

    def _to_own(self, row: np.ndarray | None = None, column: np.ndarray | None = None) -> _signorini.Rows:
        return self._rows(self._of_whole, row, column)

    def _of_all(self, u: np.ndarray) -> np.ndarray:
        """Returns the concatenated controls of all ranks."""
        values = np.ascontiguousarray(shaped(u, self.shape), dtype=float)
        if RANKS == 1:
            return values
        everyone = np.empty(self._size_of_all)
        WORLD.Allgatherv(values.ravel(), (everyone, self.shape[0] * self._widths))
        return everyone

    def gather(self, u: np.ndarray) -> np.ndarray:
        """Returns a whole control or derivative (intervals × all values) on every rank, with places in the order of their coordinates
        for any number of ranks."""
        return self._to_whole().of(self._of_all(u))

    def scatter(self, whole: np.ndarray) -> np.ndarray:
        """Returns this rank's part of a whole control: the inverse of gather()."""
        return self._to_own().of(shaped(whole, (self.shape[0], len(self._order))))

    def replicated(self) -> Replicated:
        """Returns the problem in terms of vectors that are the same on every rank, for optimizers without support for MPI."""
        return Replicated(self)


class Replicated:
    """A control problem in vectors x of R^n, the same on every rank, for an optimizer that every rank runs alike, such as
    SciPy's. The order of entries does not depend on the number of ranks. Entries are scaled by the root of the metric's
    weights, x = √w·u: the Euclidean product is the metric's, or nearly, and iterations do not depend on the mesh. All members
    are collective, and raise the errors of Problem's.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        # √w is the root of an interval's length times that of a place's weight.
        row = np.sqrt(problem.lengths)
        own = np.sqrt(problem.metric.weights[0]) / row[0]
        column = problem.gather(np.tile(own, (len(row), 1)))[0]
        self._vectors, self._derivatives = problem._to_whole(row, column), problem._to_whole(1 / row, 1 / column)
        self._controls = problem._to_own(1 / row, 1 / own)

    @property
    def size(self) -> int:
        """Number n of entries of x."""
        return self.problem._size_of_all

    def vector(self, u: np.ndarray) -> np.ndarray:
        """Returns the vector x of a control. (n)"""
        return self._vectors.of(self.problem._of_all(u)).ravel()

    def control(self, x: np.ndarray) -> np.ndarray:
        """Returns this rank's part of the control with the vector x. (intervals × values)"""
        return self._controls.of(shaped(x, (self.size,)))

    @property
    def start(self) -> np.ndarray:
        """Vector x of the first guess. (n)"""
        return self.vector(self.problem.first_guess())

    @property
    def bounds(self) -> list[tuple[float, float]] | None:
        """Pairs of lower and upper bound of each entry of x, as scipy.optimize expects them; None without bounds."""
        lower, upper = self.problem.lower, self.problem.upper
        if lower is None and upper is None:
            return None
        sides = [np.full(self.size, beyond) if side is None else self.vector(side) for side, beyond in ((lower, -np.inf), (upper, np.inf))]
        return list(zip(*sides, strict=True))

    def value(self, x: np.ndarray) -> float:
        """Returns J at x."""
        return self.problem._problem.value(x, self._controls)

    def value_and_gradient(self, x: np.ndarray) -> tuple[float, np.ndarray]:
        """Returns J and its gradient with respect to x. (n)"""
        value, derivative = self.problem._problem.value_and_derivative(x, self._controls)
        return value, self._by_x(derivative)

    def hessian_product(self, x: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Returns the Hessian of J at x times d, with the active sets of the motion at x. (n)"""
        return self._by_x(self.problem._problem.hessian_product(x, d, self._controls))

    def _by_x(self, derivative: np.ndarray) -> np.ndarray:
        """Converts a derivative with respect to u into one with respect to x; overwrites the argument. (n)"""
        if RANKS > 1:
            return self._derivatives.of(self.problem._of_all(derivative)).ravel()
        self._derivatives.in_place(derivative)
        return derivative.ravel()
