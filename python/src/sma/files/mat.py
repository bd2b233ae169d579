"""MATLAB's ``.mat``: version 4 by scipy, 5 to 7 in :mod:`sma.files.mat5`, 7.3 by h5py."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import missing
from ..table import Table
from . import hdf5, mat5
from .variables import Unknown, Variable, table_of_variables


def read(path: Path, table: str | None) -> Table:
    """The recording in a ``.mat`` file; ``table`` names a struct or a matrix."""
    if hdf5.is_hdf5(path):
        return hdf5.read(path, table)
    with path.open("rb") as file:
        start = file.read(mat5.HEADER)
    variables = mat5.variables(path) if mat5.is_mat5(start) else _version4(path)
    return table_of_variables(path, variables, table)


def _version4(path: Path) -> dict[str, Variable]:
    """Variables of version 4, whose reader is Python."""
    try:
        import scipy.io
        import scipy.io.matlab
    except ImportError:
        raise missing("scipy", "mat", f"{path}: a .mat file of version 4") from None
    with path.open("rb") as file:
        if scipy.io.matlab.matfile_version(file)[0] != 0:
            raise ValueError("no .mat file of version 4, 5, 7 or 7.3")
    loaded = scipy.io.loadmat(path)
    found: dict[str, Variable] = {}
    for title, value in loaded.items():
        if not title.startswith("__"):
            found[title] = value if isinstance(value, np.ndarray) else Unknown("a sparse matrix")
            if isinstance(value, np.ndarray) and value.dtype.kind == "c":
                found[title] = Unknown("an array of complex numbers")
    return found
