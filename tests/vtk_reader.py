# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a VTKHDF file by VTK's own reader and writes what it found to a .npz file: in a process of its own, since VTK and h5py have
different libraries of HDF5. Usage: vtk_reader.py FILE OUT.npz [pyvista]"""

import sys

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOHDF import vtkHDFReader


def arrays(data: object) -> dict[str, np.ndarray]:
    """What one time of an unstructured grid has."""
    cells = data.GetCells()
    found = {"points": vtk_to_numpy(data.GetPoints().GetData()), "cells": vtk_to_numpy(cells.GetConnectivityArray()),
             "offsets": vtk_to_numpy(cells.GetOffsetsArray()), "types": vtk_to_numpy(data.GetCellTypesArray())}  # fmt: skip
    for place, values in (("point", data.GetPointData()), ("cell", data.GetCellData())):
        found |= {f"{place}.{values.GetArrayName(i)}": vtk_to_numpy(values.GetArray(i)) for i in range(values.GetNumberOfArrays())}
    return {name: value.copy() for name, value in found.items()}


def by_vtk(file: str) -> tuple[list[float], list[dict[str, np.ndarray]]]:
    reader = vtkHDFReader()
    reader.SetFileName(file)
    complaints = []
    reader.AddObserver("ErrorEvent", lambda *_: complaints.append("VTK's reader reports an error"))
    if not reader.CanReadFile(file):
        sys.exit("VTK's reader refuses the file")
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    states = []
    for time in times:
        reader.UpdateTimeStep(time)
        states.append(arrays(reader.GetOutputDataObject(0)))
    if complaints:
        sys.exit(complaints[0])
    return list(times), states


def by_pyvista(file: str) -> tuple[list[float], list[dict[str, np.ndarray]]]:
    import pyvista

    reader = pyvista.HDFReader(file)
    grid = reader.read()  # of the last time that VTK was asked for: the first
    return [0.0], [arrays(grid)]


if __name__ == "__main__":
    file, out, *tool = sys.argv[1:]
    times, states = by_pyvista(file) if tool else by_vtk(file)
    np.savez(out, times=times, **{f"{number}.{name}": value for number, state in enumerate(states) for name, value in state.items()})
