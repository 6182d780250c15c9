# SPDX-License-Identifier: GPL-3.0-or-later
"""Expressions of a scene in x, y, z and t, evaluated by muParser as the program does, and time series in their place."""

import ctypes
import ctypes.util
import re
from functools import cache
from pathlib import Path

import numpy as np

from files import NotInRun, Unreadable

DOUBLES = ctypes.POINTER(ctypes.c_double)
CONSTANTS = {"pi": np.pi, "e": np.e}


@cache
def library() -> ctypes.CDLL:
    """muParser's interface for C. Raises NotInRun where the library is missing."""
    name = ctypes.util.find_library("muparser")
    if not name:
        raise NotInRun("the library muParser, which evaluates expressions, is not here")
    parser = ctypes.CDLL(name)
    parser.mupCreate.restype = ctypes.c_void_p
    parser.mupGetErrorMsg.restype = ctypes.c_char_p
    for function, arguments in {"mupCreate": [ctypes.c_int], "mupRelease": [], "mupError": [], "mupGetErrorMsg": [],
                                "mupSetExpr": [ctypes.c_char_p], "mupEvalBulk": [DOUBLES, ctypes.c_int],
                                "mupDefineConst": [ctypes.c_char_p, ctypes.c_double],
                                "mupDefineVar": [ctypes.c_char_p, DOUBLES]}.items():  # fmt: skip
        handle = [] if function == "mupCreate" else [ctypes.c_void_p]
        getattr(parser, function).argtypes = handle + arguments
    return parser


class Expression:
    """The text of an expression."""

    def __init__(self, text: str) -> None:
        self.text = text

    @property
    def moves(self) -> bool:
        """Whether it contains the time."""
        return re.search(r"\bt\b", self.text) is not None

    def __call__(self, x: np.ndarray, time: float) -> np.ndarray:
        """Values at points (n × dim, m) and a time (s). Raises Unreadable where the expression is none."""
        parser = library()
        columns = np.zeros((4, len(x)))
        columns[: x.shape[1]] = x.T
        columns[3] = time
        values = np.empty(len(x))
        handle = parser.mupCreate(0)
        try:
            for name, value in CONSTANTS.items():
                parser.mupDefineConst(handle, name.encode(), value)
            for name, column in zip("xyzt", columns):
                parser.mupDefineVar(handle, name.encode(), column.ctypes.data_as(DOUBLES))
            parser.mupSetExpr(handle, self.text.encode())
            parser.mupEvalBulk(handle, values.ctypes.data_as(DOUBLES), len(x))
            if parser.mupError(handle):
                reason = parser.mupGetErrorMsg(handle).decode(errors="replace")
                raise Unreadable(f'the expression "{self.text}" of the scene cannot be evaluated: {reason}')
        finally:
            parser.mupRelease(handle)
        return values


class TimeSeries:
    """A column of a table, linear between its times (s; in the column time or t, else in the first). Raises NotInRun where
    the table is not there any more."""

    def __init__(self, file: Path, column: str) -> None:
        try:
            text = file.read_text(encoding="utf-8-sig")
            lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
            between = next(separator for separator in "\t;," if separator in lines[0])
            names, *rows = [[cell.strip(' \t"') for cell in line.split(between)] for line in lines]
            times = next((names.index(name) for name in ("time", "t") if name in names), 0)
            self.times, self.values = np.array([[float(row[i]) for i in (times, names.index(column))] for row in rows]).T
        except (OSError, ValueError, IndexError, StopIteration) as error:
            raise NotInRun(f"the time series {file} cannot be read") from error

    def __call__(self, time: float) -> float:
        """Beyond its times the first or the last value."""
        return float(np.interp(time, self.times, self.values))
