"""HDF5, by h5py: MATLAB's ``.mat`` v7.3, and ``.h5`` of anybody."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import missing
from ..table import Table, table_of
from .variables import Unknown, Variable, table_of_variables

SIGNATURE = b"\x89HDF\r\n\x1a\n"

#: Places where the signature may stand; MATLAB puts 512 bytes of its own before it.
PLACES = (0, 512, 1024, 2048)


def is_hdf5(path: Path) -> bool:
    """True if the file has the signature of HDF5."""
    with path.open("rb") as file:
        start = file.read(PLACES[-1] + len(SIGNATURE))
    return any(start[at : at + len(SIGNATURE)] == SIGNATURE for at in PLACES)


def read(path: Path, table: str | None) -> Table:
    """The recording in an HDF5 file; ``table`` names a group or a data set of its root."""
    try:
        import h5py
    except ImportError:
        raise missing("h5py", "mat", f"{path}: a file in HDF5 (.mat v7.3, .h5)") from None
    with h5py.File(path, "r") as file:
        variables = _group(file)
    compound = _compound(variables, table)
    if compound is not None:
        title, values = compound
        columns: list[tuple[object, object]] = [(key, values[key]) for key in values.dtype.names or ()]
        return table_of(path.name, columns, place=f'variable "{title}"')
    return table_of_variables(path, variables, table)


def _group(group: Any) -> dict[str, Variable]:
    # #refs# and #subsystem# hold the insides of MATLAB's cells and objects.
    return {title: _variable(item) for title, item in group.items() if not title.startswith("#")}


def _variable(item: Any) -> Variable:
    of_matlab = item.attrs.get("MATLAB_class")
    kind = of_matlab.decode() if isinstance(of_matlab, bytes) else of_matlab
    if "MATLAB_object_decode" in item.attrs:
        return Unknown("an object, such as a table, a timetable or a string")
    if not hasattr(item, "dtype"):
        return Unknown("a sparse matrix") if "MATLAB_sparse" in item.attrs else _group(item)
    if kind == "char":
        return np.array("text")
    if "MATLAB_empty" in item.attrs:
        return np.zeros(0)
    if kind == "cell" or item.dtype.kind == "O":
        return Unknown("a cell array" if kind == "cell" else "an array of objects or of text")
    values: Any = item[()]
    if not isinstance(values, np.ndarray):
        return np.asarray(values)
    if kind is not None and values.dtype.names is not None or values.dtype.kind == "c":
        return Unknown("an array of complex numbers")
    # MATLAB counts along columns first, HDF5 along rows.
    return values.T if kind is not None else values


def _compound(variables: dict[str, Variable], wanted: str | None) -> tuple[str, np.ndarray[Any, Any]] | None:
    """A data set with named fields, if that is what is asked for or alone there."""
    titles = list(variables) if wanted is None else [wanted]
    if len(titles) != 1:
        return None
    values = variables.get(titles[0])
    if isinstance(values, np.ndarray) and values.dtype.names is not None:
        return titles[0], values
    return None
