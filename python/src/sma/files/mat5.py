"""MATLAB's ``.mat`` of versions 5 to 7.

Read here, and not by scipy, whose reader in C ends the interpreter at some damaged files. Form: "MAT-File Format", The MathWorks.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .variables import Unknown, Variable

#: Bytes before the first variable.
HEADER = 128

#: Types of numbers as they are stored, by their code.
STORED = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
INT8, INT32, UINT32, MATRIX, COMPRESSED = 1, 5, 6, 14, 15

#: Types of numbers as they are meant, by the code of an array's class.
MEANT = {6: "f8", 7: "f4", 8: "i1", 9: "u1", 10: "i2", 11: "u2", 12: "i4", 13: "u4", 14: "i8", 15: "u8"}
STRUCT, CHAR, OPAQUE = 2, 4, 17
OTHERS = {1: "a cell array", 3: "an object", 5: "a sparse matrix", 16: "a function"}

#: Bit of an array's flags.
COMPLEX = 0x0800


def is_mat5(start: bytes) -> bool:
    """True for the first bytes of such a file, at least 128."""
    return start[126:128] in (b"IM", b"MI")


def variables(path: Path) -> dict[str, Variable]:
    """All variables of a file.

    Raises:
        ValueError: the file is damaged or cut off.
    """
    data = path.read_bytes()
    order = "<" if data[126:128] == b"IM" else ">"
    found: dict[str, Variable] = {}
    for code, content in _elements(memoryview(data)[HEADER:], order):
        if code == COMPRESSED:
            inflater = zlib.decompressobj()
            inflated = memoryview(inflater.decompress(content))
            if not inflater.eof:
                raise ValueError("a compressed variable is cut off")
            code, content = next(_elements(inflated, order), (0, inflated))
        if code != MATRIX:
            raise ValueError(f"an element of type {code} where a variable should be")
        name, value = _array(content, order)
        # What has no name is MATLAB's own.
        if name:
            found[name] = value
    return found


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Type and content of each element."""
    at = 0
    while at < len(data):
        if len(data) - at < 8:
            raise ValueError("ends within the head of an element")
        code, size = struct.unpack_from(f"{order}II", data, at)
        if code >> 16:
            code, size, start = code & 0xFFFF, code >> 16, at + 4
            at += 8
            if size > 4:
                raise ValueError(f"a short element of {size} bytes")
        else:
            start = at + 8
            # All but what is compressed fills whole words.
            at = start + size + (0 if code == COMPRESSED else -size % 8)
        if start + size > len(data):
            raise ValueError(f"ends within an element of {size} bytes")
        yield code, data[start : start + size]


def _array(content: memoryview, order: str) -> tuple[str, Variable]:
    """Name and value of a variable or of a struct's field."""
    if not len(content):
        return "", np.zeros(0)
    parts = _elements(content, order)
    flags = _numbers(parts, order, UINT32)
    kind = int(flags[0]) & 0xFF
    if kind == OPAQUE:
        return _text(parts), Unknown("an object, such as a table, a timetable or a string")
    shape = tuple(int(n) for n in _numbers(parts, order, INT32))
    name = _text(parts)
    if min(shape, default=0) < 0:
        raise ValueError(f'"{name}" has the shape {shape}')
    if kind == STRUCT:
        return name, _struct(parts, order, math.prod(shape))
    if kind == CHAR:
        return name, np.array("text")
    if kind in OTHERS:
        return name, Unknown(OTHERS[kind])
    if kind not in MEANT:
        raise ValueError(f'"{name}" is an array of the unknown class {kind}')
    values = _numbers(parts, order)
    if int(flags[0]) & COMPLEX:
        return name, Unknown("an array of complex numbers")
    if values.size != math.prod(shape):
        raise ValueError(f'"{name}" has {values.size} numbers for the shape {shape}')
    return name, values.astype(MEANT[kind]).reshape(shape, order="F")


def _struct(parts: Iterator[tuple[int, memoryview]], order: str, size: int) -> Variable:
    length = int(_numbers(parts, order, INT32)[0])
    names = bytes(_next(parts)[1])
    if length < 1:
        raise ValueError(f"names of {length} bytes in a struct")
    if size != 1:
        return Unknown(f"an array of {size} structs")
    fields: dict[str, Variable] = {}
    for k in range(0, len(names), length):
        code, content = _next(parts)
        if code != MATRIX:
            raise ValueError(f"an element of type {code} in a struct")
        fields[_decoded(names[k : k + length])] = _array(content, order)[1]
    return fields


def _next(parts: Iterator[tuple[int, memoryview]]) -> tuple[int, memoryview]:
    part = next(parts, None)
    if part is None:
        raise ValueError("an array ends before its content")
    return part


def _numbers(parts: Iterator[tuple[int, memoryview]], order: str, expected: int | None = None) -> npt.NDArray[Any]:
    code, content = _next(parts)
    if code not in STORED or (expected is not None and code != expected) or (expected is not None and not len(content)):
        raise ValueError(f"an element of type {code} where numbers should be")
    return np.frombuffer(content, dtype=order + STORED[code])


def _text(parts: Iterator[tuple[int, memoryview]]) -> str:
    code, content = _next(parts)
    if code != INT8:
        raise ValueError(f"an element of type {code} where a name should be")
    return _decoded(bytes(content))


def _decoded(name: bytes) -> str:
    return name.split(b"\0")[0].decode("utf-8", "replace")
