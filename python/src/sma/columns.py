"""CSV that the program writes, as arrays."""

from __future__ import annotations

import csv

import numpy as np

from .results import Array


def numbers(text: str) -> dict[str, Array]:
    """The columns of a table of numbers, by name, each with a value a row."""
    rows = _rows(text)
    values = np.array([[float(field) for field in row] for row in rows[1:]], dtype=np.float64)
    return {title: values[:, k] for k, title in enumerate(rows[0])}


def grouped(text: str, by: tuple[str, ...]) -> dict[tuple[str, ...], dict[str, Array]]:
    """The columns of numbers beside columns of names, a table for each set of names, in the order of the file."""
    rows = _rows(text)
    head = rows[0]
    names = [head.index(title) for title in by]
    rest = [k for k, title in enumerate(head) if title not in by]
    groups: dict[tuple[str, ...], list[list[float]]] = {}
    for row in rows[1:]:
        groups.setdefault(tuple(row[k] for k in names), []).append([float(row[k]) for k in rest])
    tables: dict[tuple[str, ...], dict[str, Array]] = {}
    for key, group in groups.items():
        values = np.array(group, dtype=np.float64)
        tables[key] = {head[k]: values[:, c] for c, k in enumerate(rest)}
    return tables


def _rows(text: str) -> list[list[str]]:
    return list(csv.reader(line for line in text.splitlines() if line and not line.startswith("#")))
