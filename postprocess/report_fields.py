# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields that a run stored, as a number at each node, for colouring the body."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from .files import NotInRun
from .mesh import Mesh, Series
from .run_folder import RunFolder, nearest

VECTORS = {"displacement": ("state", "m"), "velocity": ("state", "m/s"), "control": ("control", "× control.scale"),
           "adjoint": ("adjoint", ""), "friction": ("state", "Pa")}  # fmt: skip
SCALARS = {"von_mises": ("von Mises stress", "Pa"), "pressure": ("contact pressure", "Pa")}
TENSORS = {"stress": "Pa", "strain": ""}


@dataclass(frozen=True)
class Field:
    """Number for each node or cell, made of a field's components by `of`. `support`: nodes of the part of the boundary that the
    field belongs to; None if it belongs to the body."""

    name: str
    unit: str
    series: Series
    of: Callable[[np.ndarray], np.ndarray]
    support: np.ndarray | None = None

    @property
    def prefixed(self) -> bool:
        """Whether the unit of the field may get an SI prefix."""
        return self.unit != "" and not self.unit.startswith("×")

    def at(self, time: float) -> np.ndarray:
        """Returns the values at the nodes at the stored time nearest to `time` (s)."""
        return nodal(self.series, self.of(self.series.components(nearest(self.series.times, time))), self.support)

    def vectors(self, time: float) -> np.ndarray:
        """Returns the field's vectors at the nodes at the stored time nearest to `time` (s), nodes × dim."""
        return nodal(self.series, self.series.at(nearest(self.series.times, time)), self.support)


def stored_fields(run: RunFolder) -> list[Field]:
    """Returns all fields of state.xdmf, control.xdmf and adjoint.xdmf."""
    return [*vectors(run, "displacement", "velocity"), *scalars(run), *vectors(run, "friction"), *tensors(run),
            *vectors(run, "control", "adjoint")]  # fmt: skip


def vectors(run: RunFolder, *names: str) -> Iterator[Field]:
    """Yields the magnitudes of vector fields that are stored."""
    for name in names:
        file, unit = VECTORS[name]
        if (series := held(run, file, name)) is not None:
            support = support_of(run, series) if name == "control" else None
            yield Field(name, unit, series, lambda values: np.linalg.norm(values, axis=1), support)


def scalars(run: RunFolder) -> Iterator[Field]:
    for name, (title, unit) in SCALARS.items():
        if (series := held(run, "state", name)) is not None:
            yield Field(title, unit, series, lambda values: values[:, 0])


def tensors(run: RunFolder) -> Iterator[Field]:
    """Yields each component of stored tensors that is not zero throughout."""
    for name, unit in TENSORS.items():
        if (series := held(run, "state", name)) is None:
            continue
        width = int(np.sqrt(series.components(0).shape[1]))
        last = series.components(len(series.times) - 1)
        for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)):
            if max(i, j) < width and (run.dim == 3 or last[:, width * i + j].any()):
                around = ", around the axis" if run.axisymmetric and i == j == 2 else ""
                yield Field(f"{name} {'xyz'[i]}{'xyz'[j]}{around}", unit, series, lambda values, at=width * i + j: values[:, at])


def held(run: RunFolder, file: str, name: str) -> Series | None:
    """Returns the field `name` of a file; None if the file has no such field."""
    try:
        return run.field(file, name)
    except NotInRun:
        return None


def nodal(series: Series, values: np.ndarray, support: np.ndarray | None = None) -> np.ndarray:
    """Returns values at the nodes. A field that is constant in each cell has the mean over the cells there; if it belongs to the
    boundary, over those cells that have a value."""
    if not series.cellwise:
        return values
    mesh = series.mesh
    counted = np.ones(len(values)) if support is None else values.reshape(len(values), -1).any(axis=1).astype(float)
    total, count = np.zeros((len(mesh.points), *values.shape[1:])), np.zeros(len(mesh.points))
    for corner in mesh.cells.T:
        np.add.at(total, corner, values)
        np.add.at(count, corner, counted)
    return total / np.maximum(count, 1).reshape(-1, *[1] * (values.ndim - 1))


def support_of(run: RunFolder, control: Series) -> np.ndarray | None:
    """Flags the nodes at which a control of a part of the boundary ever acts; None for a control of the body."""
    if run.entry(lambda: run.manifest["control_unit"]) != "N/m²":
        return None
    acts = np.any([control.at(i).any(axis=1) for i in range(len(control.times))], axis=0)
    if not control.cellwise:
        return acts
    return nodes_of_facets(control.mesh, acts)


def nodes_of_facets(mesh: Mesh, acts: np.ndarray) -> np.ndarray:
    """Flags the nodes of those facets of the boundary by which a field acts on the cells `acts`. Of a cell with several facets, at an
    edge of the body, those count that are joined to the only facet of another cell."""
    facets, owner = mesh.facets()
    facets, owner = facets[acts[owner]], owner[acts[owner]]
    alone = np.bincount(owner, minlength=len(acts))[owner] == 1
    found = np.zeros(len(mesh.points), bool)
    found[facets[alone]] = True
    joined = found[facets].sum(axis=1) >= facets.shape[1] - 1
    found[facets[joined if alone.any() else np.ones_like(alone)]] = True
    return found


def area(mesh: Mesh, facets: np.ndarray) -> np.ndarray:
    """Returns the length of each edge, m, or the area of each triangle, m²."""
    corners = mesh.points[facets]
    if facets.shape[1] == 2:
        return np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
