"""Named variables of a file, and which of them are the columns of a recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from ..errors import InputError
from ..table import Table, matrix_table, table_of


@dataclass(frozen=True)
class Unknown:
    """A variable that holds no array of numbers, in words."""

    what: str


#: An array, the fields of a struct, or what cannot be read.
Variable = Union[npt.NDArray[Any], "Variables", Unknown]  # noqa: UP007 - it names itself
Variables = Mapping[str, Variable]


def table_of_variables(path: Path, variables: Variables, wanted: str | None, *, select: str = "table") -> Table:
    """The recording in the variables of a file.

    Vectors of one length are its columns; a matrix that stands alone, a row a sample, is a recording without names; so is a
    struct. Single values and text are left out, which the table's notes say.

    Raises:
        InputError: if no variable, or more than one set of them, could be the recording.
    """
    name = path.name
    place = ""
    if wanted is not None:
        if wanted not in variables:
            raise InputError(
                f'{path}: no variable "{wanted}"; expected one of {", ".join(variables) or "none, it is empty"}',
                file=str(path),
                column=wanted,
            )
        place = f'variable "{wanted}"'
        variables = _inside(wanted, variables[wanted])
    vectors, matrices, structs, notes = _sorted(path, variables)
    if not vectors and not matrices and len(structs) == 1:
        title, fields = next(iter(structs.items()))
        place = f'variable "{title}"'
        vectors, matrices, structs, notes = _sorted(path, fields, f"{title}.")
    if vectors and not matrices:
        left = [f'"{title}", a struct, is left out' for title in structs]
        return table_of(name, list(vectors.items()), place=place, notes=tuple(notes + left))
    if matrices and not vectors and len(matrices) == 1:
        title, matrix = next(iter(matrices.items()))
        if matrix.ndim == 2:
            return matrix_table(name, matrix, place or f'variable "{title}"')
    if matrices:
        title, matrix = next(iter(matrices.items()))
        shape = " x ".join(str(n) for n in matrix.shape)
        raise InputError(
            f'{path}: variable "{title}" is {shape}; expected vectors of one length, or one matrix with a row a sample alone: '
            f'{select}="NAME" selects it',
            file=str(path),
            column=title,
        )
    if len(structs) > 1:
        raise InputError(
            f'{path}: several could be the recording: {", ".join(structs)}; expected one: {select}="{next(iter(structs))}"',
            file=str(path),
        )
    held = "; ".join(notes) or "it is empty"
    raise InputError(f"{path}: no vectors of numbers ({held}); expected a drive and an output", file=str(path))


def _inside(title: str, variable: Variable) -> Variables:
    return variable if isinstance(variable, Mapping) else {title: variable}


def _sorted(
    path: Path, variables: Variables, before: str = ""
) -> tuple[dict[str, npt.NDArray[Any]], dict[str, npt.NDArray[Any]], dict[str, Variables], list[str]]:
    vectors: dict[str, npt.NDArray[Any]] = {}
    matrices: dict[str, npt.NDArray[Any]] = {}
    structs: dict[str, Variables] = {}
    notes: list[str] = []
    for title, variable in variables.items():
        if isinstance(variable, Mapping):
            structs[title] = variable
        elif isinstance(variable, Unknown):
            raise InputError(
                f'{path}: variable "{before}{title}" is {variable.what}; expected vectors of numbers of one length: save those alone',
                file=str(path),
                column=f"{before}{title}",
            )
        elif variable.size <= 1 or variable.dtype.kind in "US":
            notes.append(f'"{before}{title}", a single value or text, is left out')
        elif sum(n > 1 for n in variable.shape) == 1:
            vectors[title] = variable.reshape(-1)
        else:
            matrices[title] = np.asarray(variable)
    return vectors, matrices, structs, notes
