"""Tables of columns: frames, arrays and dicts in, the text that the program reads out."""

from __future__ import annotations

import datetime
import decimal
import math
import numbers
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TextIO

import numpy as np
import numpy.typing as npt

from .errors import InputError

Column = npt.NDArray[Any]

#: What a column may hold.
ACCEPTED = "numbers, dates, or text throughout"


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of one length: a recording before it is read.

    A column holds float64, integers, datetime64 or text. NaN is a missing value: the program fills few of them, says so, and
    refuses many.
    """

    #: Name in reports and errors: a file, or the place among the arguments, such as ``train1``.
    name: str
    #: Columns by name, in order; by "1", "2", … if ``has_names`` is false.
    columns: Mapping[str, Column]
    #: False for a bare matrix, whose columns a rod file gives by number.
    has_names: bool = True
    #: Sheet, group or variable in the file, as it stands in errors.
    place: str = ""
    #: Number of the first row of data, as its source counts.
    first_row: int = 0
    #: What was left out or changed in reading.
    notes: tuple[str, ...] = field(default=())

    def __len__(self) -> int:
        """Rows."""
        return len(next(iter(self.columns.values())))

    @property
    def label(self) -> str:
        """Name and place, as errors have them."""
        return f"{self.name}, {self.place}" if self.place else self.name

    def __repr__(self) -> str:
        return f"<Table {self.label}: {len(self)} rows of {', '.join(self.columns)}>"

    def write_csv(self, out: TextIO) -> None:
        """Write the table as the program reads it; every float is written so that it is read with the same bits."""
        if self.has_names:
            out.write(",".join(_quoted(name) for name in self.columns) + "\n")
        texts = [_texts(column) for column in self.columns.values()]
        out.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))


def as_table(given: object, name: str) -> Table:
    """A frame of pandas or polars, a dict of arrays, a matrix, a structured array or a pyarrow table as a :class:`Table`.

    What is given is not altered.

    Raises:
        InputError: for anything else, a ragged table, a column of another rank, mixed types or infinite numbers.
    """
    if isinstance(given, Table):
        return given
    frame = _frame_columns(given)
    if frame is not None:
        return table_of(name, *frame)
    if isinstance(given, Mapping):
        return table_of(name, [(key, value) for key, value in given.items()])
    if isinstance(given, np.ndarray):
        if given.dtype.names is not None and given.ndim == 1:
            return table_of(name, [(key, given[key]) for key in given.dtype.names])
        if given.ndim == 2:
            return matrix_table(name, given)
        raise InputError(
            f"{name}: an array of shape {given.shape}; expected a matrix with a row a sample, a structured array, or a dict of "
            "one-dimensional arrays",
            file=name,
        )
    raise InputError(
        f"{name}: a {type(given).__module__}.{type(given).__qualname__}; expected a path, a frame of pandas or polars, a dict of "
        "arrays, a matrix, or a sma.Table",
        file=name,
    )


def matrix_table(name: str, matrix: npt.NDArray[Any], place: str = "", first_row: int = 0) -> Table:
    """A matrix with a row a sample; its columns have numbers from 1 instead of names."""
    columns: list[tuple[object, object]] = [(str(k + 1), matrix[:, k]) for k in range(matrix.shape[1])]
    return table_of(name, columns, place=place, first_row=first_row, has_names=False)


def table_of(
    name: str,
    columns: list[tuple[object, object]],
    *,
    place: str = "",
    first_row: int = 0,
    has_names: bool = True,
    notes: tuple[str, ...] = (),
) -> Table:
    """Check columns and put them together.

    Raises:
        InputError: as :func:`as_table`.
    """
    at = f"{name}, {place}" if place else name
    if not columns:
        raise InputError(f"{at}: no column; expected at least a drive and an output", file=name)
    # A frame without names counts its columns from 0.
    if has_names and [key for key, _ in columns] == list(range(len(columns))):
        has_names = False
        columns = [(str(k + 1), values) for k, (_, values) in enumerate(columns)]
    checked: dict[str, Column] = {}
    for key, values in columns:
        title = str(key)
        if has_names and _is_number(title):
            raise InputError(
                f'{at}: column "{title}" has a number for a name; expected a name with a unit, such as current_a',
                file=name,
                column=title,
            )
        if title in checked:
            raise InputError(f'{at}: two columns are named "{title}"; expected different names', file=name, column=title)
        checked[title] = _column(at, name, title, values, first_row)
    lengths = {title: len(values) for title, values in checked.items()}
    if len(set(lengths.values())) > 1:
        counts = ", ".join(f"{title} {n}" for title, n in lengths.items())
        usual = max(set(lengths.values()), key=list(lengths.values()).count)
        odd = next(title for title, n in lengths.items() if n != usual)
        raise InputError(
            f"{at}: columns of different lengths ({counts}); expected one length: select those of one recording",
            file=name,
            column=odd,
            row=first_row + min(lengths.values()),
        )
    return Table(name, checked, has_names, place, first_row, notes)


def _frame_columns(given: object) -> tuple[list[tuple[object, object]]] | None:
    """Columns of a frame, recognized by where its class is defined: none of these packages is imported for it."""
    package = type(given).__module__.partition(".")[0]
    kind = type(given).__name__
    frame: Any = given
    if package == "polars" and kind == "LazyFrame":
        frame, kind = frame.collect(), "DataFrame"
    if package == "polars" and kind == "DataFrame":
        return ([(key, frame.get_column(key).to_numpy()) for key in frame.columns],)
    if package == "pyarrow" and kind == "Table":
        names = frame.column_names
        return ([(key, arrow_values(frame.column(k))) for k, key in enumerate(names) if not _is_index(key)],)
    if package == "pandas" and kind == "DataFrame":
        # An index that has a name or holds times is a column; 0, 1, 2, … is none.
        index = frame.index
        columns: list[tuple[object, object]] = []
        if index.name is not None or index.dtype.kind == "M":
            columns.append((index.name if index.name is not None else "time", _pandas_values(index)))
        columns += [(key, _pandas_values(frame.iloc[:, k])) for k, key in enumerate(frame.columns)]
        return (columns,)
    return None


def _is_index(key: str) -> bool:
    """True for the index without a name that pandas writes beside the columns."""
    return key.startswith("__index_level_")


def arrow_values(column: Any) -> Column:
    """A column of pyarrow as an array; what has no value becomes NaN."""
    values: Column = column.to_numpy() if hasattr(column, "chunks") else column.to_numpy(zero_copy_only=False)
    return values


def _pandas_values(series: Any) -> object:
    dtype = series.dtype
    if getattr(dtype, "tz", None) is not None:
        return series.to_numpy(dtype="datetime64[ns]")
    # Columns that know missing values by another name than NaN.
    if not isinstance(dtype, np.dtype) and getattr(dtype, "kind", "") in "iufb" and series.isna().any():
        return series.to_numpy(dtype="float64", na_value=math.nan)
    return series.to_numpy()


def _column(at: str, file: str, title: str, given: object, first_row: int) -> Column:
    if isinstance(given, np.ma.MaskedArray):
        masked: Any = given.astype(float)
        given = masked.filled(math.nan)
    try:
        values = np.asarray(given)
    except ValueError:
        raise InputError(f'{at}: column "{title}" is ragged; expected one value a row', file=file, column=title) from None
    if values.ndim != 1:
        shape = " x ".join(str(n) for n in values.shape) or "a single value"
        raise InputError(
            f'{at}: column "{title}" has the shape {shape}; expected one dimension, a value a row',
            file=file,
            column=title,
        )
    kind = values.dtype.kind
    if kind == "O":
        values = _of_objects(at, file, title, values, first_row)
        kind = values.dtype.kind
    if kind in "iuU" or kind == "M":
        return values
    if kind == "b":
        return values.astype(np.int64)
    if kind == "S":
        return np.char.decode(values, "utf-8", "replace")
    if kind == "T":
        return values.astype(str)
    if kind == "f":
        if values.dtype.itemsize <= 8:
            floats = values.astype(np.float64)
            infinite = np.flatnonzero(np.isinf(floats))
            if infinite.size:
                k = int(infinite[0])
                raise _wrong(at, file, title, first_row + k, floats[k].item(), "a finite number, or NaN where one is missing")
            return floats
        raise InputError(
            f'{at}: column "{title}" has numbers of {8 * values.dtype.itemsize} bits; expected float64: values.astype(float)',
            file=file,
            column=title,
        )
    what = {"c": "complex numbers", "m": "durations", "V": "records"}.get(kind, f"values of type {values.dtype}")
    instead = "seconds as numbers" if kind == "m" else ACCEPTED
    raise InputError(f'{at}: column "{title}" has {what}; expected {instead}', file=file, column=title)


def _of_objects(at: str, file: str, title: str, values: Column, first_row: int) -> Column:
    """A column of Python objects as numbers, dates or text, if all are."""
    present = [(k, value) for k, value in enumerate(values) if not _is_missing(value)]
    kinds = [(k, value, _kind(value)) for k, value in present]
    if not kinds:
        return np.full(len(values), math.nan)
    counts: dict[str, int] = {}
    for _, _, kind in kinds:
        counts[kind] = counts.get(kind, 0) + 1
    most = max(counts, key=lambda kind: counts[kind])
    wrong = next(((k, value) for k, value, kind in kinds if kind != most or kind == "other"), None)
    if wrong is not None:
        expected = ACCEPTED if most == "other" else f"{most}s, as in most of its rows"
        raise _wrong(at, file, title, first_row + wrong[0], wrong[1], expected)
    if most == "number":
        numeric = np.full(len(values), math.nan)
        for k, value in present:
            numeric[k] = float(value)
        return _column(at, file, title, numeric, first_row)
    if most == "date":
        stamps = np.full(len(values), np.datetime64("NaT", "us"), dtype="datetime64[us]")
        for k, value in present:
            if isinstance(value, datetime.datetime) and value.tzinfo is not None:
                value = value.astimezone(datetime.timezone.utc).replace(tzinfo=None)
            stamps[k] = np.datetime64(value, "us")
        return stamps
    texts = dict(present)
    words = ["" if (value := texts.get(k)) is None else str(value) for k in range(len(values))]
    return np.array(words, dtype=str)


def _kind(value: object) -> str:
    if isinstance(value, (bool, np.bool_, numbers.Real, decimal.Decimal)):
        return "number"
    if isinstance(value, (datetime.datetime, datetime.date, np.datetime64)):
        return "date"
    if isinstance(value, (str, datetime.time)):
        return "text"
    return "other"


def _is_missing(value: object) -> bool:
    if value is None or type(value).__name__ in ("NAType", "NaTType"):
        return True
    return isinstance(value, (float, np.floating)) and math.isnan(value)


def _wrong(at: str, file: str, title: str, row: int, value: object, expected: str) -> InputError:
    shown = repr(value)
    if len(shown) > 60:
        shown = shown[:57] + "…"
    return InputError(f"{at}, row {row}: {title} = {shown}; expected {expected}", file=file, row=row, column=title)


def _texts(column: Column) -> list[str]:
    kind = column.dtype.kind
    if kind == "f":
        # NaN is a field without a number.
        return ["" if math.isnan(value) else repr(value) for value in column.tolist()]
    if kind in "iu":
        return [str(value) for value in column.tolist()]
    if kind == "M":
        stamps = np.datetime_as_string(column, unit="us" if column.dtype != np.dtype("datetime64[ns]") else "ns")
        return ["" if stamp == "NaT" else stamp.replace("T", " ") for stamp in stamps.tolist()]
    return [_quoted(value) for value in column.tolist()]


def _quoted(text: str) -> str:
    return '"' + re.sub(r"\s+", " ", text).replace('"', "'") + '"'


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
