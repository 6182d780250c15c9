# SPDX-License-Identifier: GPL-3.0-or-later
"""Readers of a run's files, which refuse those that are not whole, in one sentence."""

import io
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import h5py
import numpy as np


class NotInRun(Exception):
    """Raised where the run did not write, or had no reason to write, the data of a figure."""


class Unreadable(Exception):
    """Raised where a folder is no run's folder, or a file in it is damaged."""


class Table(dict[str, np.ndarray]):
    """The columns of a .csv file by name; asking for one that is not there raises Unreadable."""

    def __init__(self, file: Path, columns: Iterable[tuple[str, np.ndarray]]) -> None:
        super().__init__(columns)
        self.file = file

    def __missing__(self, name: str) -> np.ndarray:
        raise Unreadable(f"{self.file}: there is no column {name}")


def whole_text(file: Path, with_names: bool = False) -> str:
    """Returns the content of a text file. Raises ValueError if its last line does not end: then the file's end is missing.
    `with_names`: it contains names of files, which may have bytes that no text has."""
    text = file.read_text(encoding="utf-8", errors="surrogateescape" if with_names else "strict")
    if not text.endswith("\n"):
        raise ValueError("the end of the file is missing")
    return text


def read_csv(file: Path, words: Mapping[str, Sequence[str]] = MappingProxyType({})) -> Table:
    """Reads a table below one line of column names. `words`: words of some columns, which are read as their numbers. Raises
    ValueError if a row is not whole."""
    header, _, body = whole_text(file).partition("\n")
    columns = header.split(",")
    converters = {columns.index(name): list(known).index for name, known in words.items() if name in columns}
    with warnings.catch_warnings(action="ignore"):
        rows = np.loadtxt(io.StringIO(body), delimiter=",", comments=None, ndmin=2, converters=converters, encoding=None)
    if rows.size == 0:
        raise ValueError("there are no rows below the column names")
    if rows.shape[1] != len(columns):
        raise ValueError(f"{len(columns)} column names above {rows.shape[1]} columns")
    return Table(file, zip(columns, rows.T))


def read_dataset(file: Path, dataset: str) -> np.ndarray:
    """Reads one dataset of an HDF5 file. Raises Unreadable if the file or the dataset is missing or damaged."""
    if not file.is_file():
        raise Unreadable(f"{file}: there is no such file")
    try:
        with h5py.File(file, "r") as data:
            return data[dataset][()]
    except (OSError, KeyError) as error:
        raise Unreadable(f"{file}: {dataset} cannot be read ({error})") from None
