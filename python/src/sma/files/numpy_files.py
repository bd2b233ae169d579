"""Arrays that numpy has saved: ``.npz`` and ``.npy``."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..table import Table, as_table
from .variables import Unknown, Variable, table_of_variables


def read_npz(path: Path, table: str | None) -> Table:
    """The recording in an ``.npz`` file; ``table`` names a matrix or a structured array."""
    if not zipfile.is_zipfile(path):
        raise InputError(f"{path}: no archive, or one that is cut off; expected a whole .npz file", file=str(path))
    with np.load(path, allow_pickle=False) as archive:
        variables: dict[str, Variable] = {}
        for title in archive.files:
            try:
                variables[title] = archive[title]
            except ValueError as error:
                if "allow_pickle" not in str(error):
                    raise
                variables[title] = Unknown("an array of objects")
    return table_of_variables(path, variables, table)


def read_npy(path: Path, table: str | None) -> Table:
    """The recording in an ``.npy`` file: a matrix with a row a sample, or a structured array."""
    if table is not None:
        raise InputError(f'{path}: holds one array; expected no table="{table}"', file=str(path), column=table)
    try:
        array = np.load(path, allow_pickle=False)
    except ValueError as error:
        if "allow_pickle" not in str(error):
            raise
        raise InputError(f"{path}: an array of objects; expected an array of numbers", file=str(path)) from None
    return as_table(array, path.name)
