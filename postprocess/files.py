# SPDX-License-Identifier: GPL-3.0-or-later
"""Files as a run leaves them: whole, or refused in one sentence."""

import io
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path

import h5py
import numpy as np


class NotInRun(Exception):
    """The run did not write, or had no reason to write, what a figure shows."""


class Unreadable(Exception):
    """The folder is no run's folder, or a file in it is damaged."""


class Table(dict[str, np.ndarray]):
    """The columns of a .csv file by name; asking for one that is not there raises Unreadable."""

    def __init__(self, file: Path, columns: Iterable[tuple[str, np.ndarray]]) -> None:
        super().__init__(columns)
        self.file = file

    def __missing__(self, name: str) -> np.ndarray:
        raise Unreadable(f"{self.file}: there is no column {name}")


def whole_text(file: Path, with_names: bool = False) -> str:
    """A text file that ends as every line of it does; with names of files, which may have bytes that no text has. Raises ValueError
    where it does not: then its end is missing."""
    text = file.read_text(encoding="utf-8", errors="surrogateescape" if with_names else "strict")
    if not text.endswith("\n"):
        raise ValueError("its end is missing")
    return text


def read_csv(file: Path, obstacles: Sequence[str] = ()) -> Table:
    """A table below one line of column names. In a column `obstacle` numbers stand for the names, which are `obstacles`. Raises
    ValueError where a row is not whole."""
    header, _, body = whole_text(file).partition("\n")
    columns = header.split(",")
    if "obstacle" in columns:
        body = numbered(body, columns.index("obstacle"), obstacles)
    with warnings.catch_warnings(action="ignore"):
        rows = np.loadtxt(io.StringIO(body), delimiter=",", ndmin=2)
    if rows.size == 0:
        raise ValueError("there are no rows below the column names")
    if rows.shape[1] != len(columns):
        raise ValueError(f"{len(columns)} column names above {rows.shape[1]} columns")
    return Table(file, zip(columns, rows.T))


def numbered(body: str, column: int, names: Sequence[str]) -> str:
    """Rows with a name's number in its place in a column, where earlier versions wrote the number. Raises ValueError at what
    is neither."""
    rows = [line.split(",") for line in body.splitlines()]
    for row in rows:
        if len(row) > column:
            row[column] = str(names.index(row[column]) if row[column] in names else int(row[column]))
    return "\n".join(map(",".join, rows)) + "\n"


def read_dataset(file: Path, dataset: str) -> np.ndarray:
    """One dataset of an HDF5 file. Raises Unreadable if the file or the dataset is missing or damaged."""
    if not file.is_file():
        raise Unreadable(f"{file}: there is no such file")
    try:
        with h5py.File(file, "r") as data:
            return data[dataset][()]
    except (OSError, KeyError) as error:
        raise Unreadable(f"{file}: {dataset} cannot be read ({error})") from None
