# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of a run that say where its fields are: XDMF or VTKHDF, with the same contents."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Protocol

import h5py
import numpy as np

from .files import read_dataset, whole_text
from .mesh import Mesh, Series


class FieldFile(Protocol):
    """File with fields over time on one mesh."""

    dim: int  # of space

    def mesh(self) -> Mesh: ...

    def series(self, name: str) -> Series | None:
        """Returns the field of this name; None if the file has none."""


class XdmfFile:
    """Raises ParseError or ValueError if the file is not whole."""

    def __init__(self, file: Path) -> None:
        self.folder = file.parent
        self.document = ElementTree.fromstring(whole_text(file))
        self.dim = 2 if self.document.find(".//Geometry").get("GeometryType") == "XY" else 3

    def mesh(self) -> Mesh:
        return Mesh(*(read_dataset(*self._reference(self.document.find(f".//{part}/DataItem"))) for part in ("Geometry", "Topology")))

    def series(self, name: str) -> Series | None:
        # One grid a time with all fields.
        found = [(grid, field) for grid in self.document.iter("Grid") if (field := grid.find(f"Attribute[@Name='{name}']")) is not None]
        if not found:
            return None
        times = np.array([float(grid.find("Time").get("Value")) for grid, _ in found])
        datasets = [self._reference(field.find("DataItem")) for _, field in found]
        return Series(self.mesh(), times, datasets, {field.get("Center") for _, field in found} == {"Cell"})

    def _reference(self, item: ElementTree.Element) -> tuple[Path, str]:
        """Returns the file and the dataset that a DataItem such as `state.h5:/Mesh/mesh/geometry` names."""
        file, dataset = item.text.strip().split(":", 1)
        return self.folder / file, dataset


class VtkhdfFile:
    """Raises OSError or ValueError if the file is not whole, or is not one of a run."""

    def __init__(self, file: Path) -> None:
        try:
            with h5py.File(file, "r") as given:
                group = given["VTKHDF"]  # in this file, or in one that it links to
                self.file = Path(group.file.filename)
                self.times = group["Steps/Values"][:]
                self.in_cells = {name: place == "CellData" for place in ("PointData", "CellData") for name in group.get(place, ())}
                self.names = {name: sorted(group.file[f"Function/{name}"]) for name in self.in_cells}
                self.dim = group.file["Mesh/mesh/geometry"].shape[1]
        except KeyError as error:
            raise ValueError(f"{error.args[0]}") from None

    def mesh(self) -> Mesh:
        return Mesh(read_dataset(self.file, "/Mesh/mesh/geometry"), read_dataset(self.file, "/Mesh/mesh/topology"))

    def series(self, name: str) -> Series | None:
        if name not in self.names:
            return None
        datasets = [(self.file, f"/Function/{name}/{number}") for number in self.names[name]]
        return Series(self.mesh(), self.times, datasets, self.in_cells[name])
