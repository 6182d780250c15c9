"""Files as a run leaves them: whole, or refused in one sentence."""

import io
import warnings
from collections.abc import Iterable
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


def whole_text(file: Path) -> str:
    """A text file that ends as every line of it does. Raises ValueError where it does not: then its end is missing."""
    text = file.read_text(encoding="utf-8")
    if not text.endswith("\n"):
        raise ValueError("its end is missing")
    return text


def read_csv(file: Path, names: str | None = None) -> Table:
    """A table below one line of column names. Where a column, `names`, has texts, numbers stand for them, in the order in
    which they come first. Raises ValueError where a row is not whole."""
    header, _, body = whole_text(file).partition("\n")
    columns = header.split(",")
    if names is not None:
        body = numbered(body, columns.index(names))
    with warnings.catch_warnings(action="ignore"):
        rows = np.loadtxt(io.StringIO(body), delimiter=",", ndmin=2)
    if rows.size == 0:
        raise ValueError("there are no rows below the column names")
    if rows.shape[1] != len(columns):
        raise ValueError(f"{len(columns)} column names above {rows.shape[1]} columns")
    return Table(file, zip(columns, rows.T))


def numbered(body: str, column: int) -> str:
    """Rows with a number in place of each different text in a column."""
    rows, numbers = [line.split(",") for line in body.splitlines()], {}
    for row in rows:
        if len(row) > column:
            row[column] = str(numbers.setdefault(row[column], len(numbers)))
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
