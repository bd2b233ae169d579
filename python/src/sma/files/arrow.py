"""Parquet and Arrow (``.feather``), as pandas and polars write them, by pyarrow."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import InputError, missing
from ..table import Table, as_table


def read_parquet(path: Path, table: str | None) -> Table:
    """The recording in a ``.parquet`` file."""
    parquet: Any = _module("pyarrow.parquet", path)
    with path.open("rb") as file:
        start = file.read(4)
    if start == b"PARE":
        raise InputError(f"{path}: encrypted; expected .parquet without a key", file=str(path))
    with parquet.ParquetFile(path) as file:
        return _table(path, table, file.read())


def read_ipc(path: Path, table: str | None) -> Table:
    """The recording in an Arrow file (``.feather``, ``.arrow``)."""
    feather: Any = _module("pyarrow.feather", path)
    return _table(path, table, feather.read_table(path, memory_map=False))


def _table(path: Path, table: str | None, read: Any) -> Table:
    if table is not None:
        raise InputError(f'{path}: holds one table; expected no table="{table}"', file=str(path), column=table)
    import pyarrow.types as kinds

    for column in read.schema:
        if kinds.is_nested(column.type):
            raise InputError(
                f'{path}: column "{column.name}" holds {column.type}; expected a number, a date or text a row',
                file=str(path),
                column=column.name,
            )
    return as_table(read, path.name)


def _module(name: str, path: Path) -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError:
        raise missing("pyarrow", "parquet", f"{path}: a {path.suffix} file") from None
