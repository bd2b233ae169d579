"""A recording from a file of another program."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

from ..errors import InputError, SmaError
from ..table import Table
from . import arrow, hdf5, mat, numpy_files, tdms, xlsx

#: A path and the name of one table in it, to a table.
Reader = Callable[[Path, str | None], Table]

#: Readers by the end of a file's name. All else is text, which the program reads itself.
READERS: dict[str, Reader] = {
    ".mat": mat.read,
    ".h5": hdf5.read,
    ".hdf5": hdf5.read,
    ".tdms": tdms.read,
    ".xlsx": xlsx.read,
    ".xlsm": xlsx.read,
    ".parquet": arrow.read_parquet,
    ".feather": arrow.read_ipc,
    ".arrow": arrow.read_ipc,
    ".npz": numpy_files.read_npz,
    ".npy": numpy_files.read_npy,
}


def read(path: str | os.PathLike[str], *, table: str | None = None, columns: Sequence[str] | None = None) -> Table:
    """Read a recording from a file of MATLAB, LabVIEW, Excel, pandas or numpy.

    Args:
        path: ``.mat`` (v4 to v7.3), ``.h5``, ``.tdms``, ``.xlsx``, ``.parquet``, ``.feather``, ``.npz`` or ``.npy``. Text such as
            ``.csv`` is not read here: give its path where a recording is asked for.
        table: the sheet, group, struct or matrix, where the file has several.
        columns: the columns to keep, in this order; all of them unless given.

    Raises:
        InputError: a file that is cut off, encrypted or of another format; a ragged table; mixed types; a matrix of the wrong
            rank. The text names file, sheet or variable, row, value, and what would be accepted.
        MissingExtraError: the package that reads this format is not installed.
    """
    place = Path(path)
    name = place.name
    reader = READERS.get(place.suffix.lower())
    if reader is None:
        raise InputError(
            f"{path}: read() knows {' '.join(READERS)}; expected one of them. Text, such as CSV, is given by its path",
            file=str(path),
        )
    try:
        with place.open("rb") as file:
            start = file.read(8)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}", file=str(path)) from error
    if not start:
        raise InputError(f"{path}: empty; expected a {place.suffix} file", file=str(path))
    try:
        found = reader(place, table)
    except SmaError:
        raise
    except MemoryError:
        raise InputError(
            f"{path}: claims to be larger than the memory; expected a whole {place.suffix} file", file=str(path)
        ) from None
    except Exception as error:
        # The libraries that read these formats raise errors of all kinds for bytes that are not as they should be.
        said = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"{path}: cannot be read as {place.suffix}: {said[:200]}; expected a whole, unencrypted {place.suffix} file: "
            "was it copied to its end?",
            file=str(path),
        ) from error
    if columns is not None:
        found = _select(found, name, columns)
    return found


def _select(table: Table, name: str, columns: Sequence[str]) -> Table:
    absent = [column for column in columns if column not in table.columns]
    if absent:
        raise InputError(
            f'{table.label}: no column "{absent[0]}"; expected some of {", ".join(table.columns)}',
            file=name,
            column=absent[0],
        )
    kept = {column: table.columns[column] for column in columns}
    return Table(table.name, kept, table.has_names, table.place, table.first_row, table.notes)
