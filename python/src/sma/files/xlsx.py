"""Excel's ``.xlsx``, by openpyxl."""

from __future__ import annotations

import datetime
import numbers
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, missing
from ..table import Table, table_of

#: First bytes of a workbook with a password, and of one in the old format.
COMPOUND = bytes.fromhex("d0cf11e0a1b11ae1")


def read(path: Path, table: str | None) -> Table:
    """The recording in a sheet: a row of names, then numbers. ``table`` names the sheet."""
    try:
        import openpyxl
    except ImportError:
        raise missing("openpyxl", "xlsx", f"{path}: an .xlsx file") from None
    with path.open("rb") as file:
        if file.read(8) == COMPOUND:
            raise InputError(
                f"{path}: a workbook with a password, or an old .xls; expected .xlsx without a password: save it anew",
                file=str(path),
            )
    if not zipfile.is_zipfile(path):
        raise InputError(f"{path}: no workbook, or one that is cut off; expected a whole .xlsx file", file=str(path))
    with zipfile.ZipFile(path) as archive:
        damaged = archive.testzip()
    if damaged is not None:
        raise InputError(f"{path}: damaged inside, at {damaged}; expected a whole .xlsx file", file=str(path))
    workbook: Any = openpyxl.load_workbook(path, read_only=True, data_only=True)
    try:
        sheets = {sheet.title: _rows(sheet) for sheet in workbook.worksheets}
    finally:
        workbook.close()
    filled = {title: rows for title, rows in sheets.items() if rows}
    if table is not None and table not in sheets:
        raise InputError(f'{path}: no sheet "{table}"; expected one of {", ".join(sheets)}', file=str(path), column=table)
    if table is None:
        if len(filled) != 1:
            raise InputError(
                f'{path}: sheets that are not empty: {", ".join(filled) or "none"}; expected one, or table="NAME"',
                file=str(path),
            )
        table = next(iter(filled))
    if table not in filled:
        raise InputError(f'{path}, sheet "{table}": empty; expected a row of names, then numbers', file=str(path))
    return _table(path, table, filled[table])


def _rows(sheet: Any) -> dict[int, tuple[object, ...]]:
    """Rows by their number in the sheet, from the first to the last that hold anything."""
    rows = {k: row for k, row in enumerate(sheet.iter_rows(values_only=True), start=1) if not all(cell is None for cell in row)}
    if not rows:
        return {}
    return {k: rows.get(k, ()) for k in range(min(rows), max(rows) + 1)}


def _table(path: Path, sheet: str, rows: dict[int, tuple[object, ...]]) -> Table:
    place = f'sheet "{sheet}"'
    first = min(rows)
    head = _cut(rows[first])
    has_names = not any(isinstance(cell, (numbers.Real, datetime.date, datetime.time)) for cell in head)
    start = first + 1 if has_names else first
    width = len(head)
    body = [(k, _cut(row)) for k, row in rows.items() if k >= start]
    for k, row in body:
        if len(row) > width:
            expected = "a name in the first row for each" if has_names else "as many in each row"
            raise InputError(
                f"{path}, {place}, row {k}: {len(row)} cells, beside {width} in row {first}; expected {expected}",
                file=str(path),
                row=k,
            )
    columns: list[tuple[object, object]] = []
    for c in range(width):
        title = head[c] if has_names else c + 1
        cells = [row[c] if c < len(row) else None for _, row in body]
        if title is None:
            if all(cell is None for cell in cells):
                continue
            raise InputError(
                f"{path}, {place}, row {first}: no name over column {c + 1}; expected one, such as current_a",
                file=str(path),
                row=first,
            )
        values = np.empty(len(cells), dtype=object)
        values[:] = cells
        columns.append((str(title), values))
    return table_of(path.name, columns, place=place, first_row=start, has_names=has_names)


def _cut(row: tuple[object, ...]) -> tuple[object, ...]:
    """A row without the empty cells at its end."""
    n = len(row)
    while n and row[n - 1] is None:
        n -= 1
    return row[:n]
