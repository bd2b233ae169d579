"""MATLAB's ``.mat``: versions 4 and 5 to 7 by scipy, 7.3 by h5py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import missing
from ..table import Table
from . import hdf5
from .variables import Unknown, Variable, table_of_variables


def read(path: Path, table: str | None) -> Table:
    """The recording in a ``.mat`` file; ``table`` names a struct or a matrix."""
    if hdf5.is_hdf5(path):
        return hdf5.read(path, table)
    try:
        import scipy.io
    except ImportError:
        raise missing("scipy", "mat", f"{path}: a .mat file") from None
    loaded = scipy.io.loadmat(path, struct_as_record=True, mat_dtype=False, chars_as_strings=True)
    variables = {title: _variable(value) for title, value in loaded.items() if not title.startswith("__")}
    # What MATLAB stores of its own classes has no name.
    opaque = [title for title in loaded if title in ("None", "__function_workspace__")]
    if opaque and "None" in loaded:
        variables.pop("None", None)
        variables["(without a name)"] = Unknown("an object, such as a table, a timetable or a string")
    return table_of_variables(path, variables, table)


def _variable(value: Any) -> Variable:
    kind = type(value).__name__
    if kind in ("MatlabOpaque", "MatlabFunction", "MatlabObject"):
        return Unknown("an object, such as a table, a timetable or a function")
    if not isinstance(value, np.ndarray):
        return Unknown("a sparse matrix")
    if value.dtype.names is not None:
        if value.size != 1:
            return Unknown(f"an array of {value.size} structs")
        record = value.reshape(-1)[0]
        return {title: _variable(record[title]) for title in value.dtype.names}
    if value.dtype.kind == "O":
        return Unknown("a cell array")
    if value.dtype.kind == "c":
        return Unknown("an array of complex numbers")
    return value
