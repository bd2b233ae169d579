"""Rod files: what is known of a rig, as nested dicts."""

from __future__ import annotations

import json
import math
import numbers
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .errors import InputError


def to_toml(rod: Mapping[str, Any]) -> str:
    """The tables of a rod file as TOML. Raises InputError for a value that TOML or the program does not know."""
    lines: list[str] = []
    for title, table in rod.items():
        if not isinstance(table, Mapping):
            raise InputError(
                f"rod[{title!r}] = {table!r}: expected a table, as in {{'rod': {{'diameter_mm': 0.5}}}}",
                file="rod.toml",
                column=str(title),
            )
        lines.append(f"[{_key(title)}]")
        lines += [f"{_key(key)} = {_value(f'{title}.{key}', value)}" for key, value in table.items()]
        lines.append("")
    return "\n".join(lines)


def toml_string(text: str) -> str:
    """A string of TOML, which knows no pairs of surrogates."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def rig_table(name: str, rod: str, train: Sequence[str], validate: Sequence[str]) -> str:
    """A rig of a fleet's manifest: its name, and the places of its files."""

    def listed(paths: Sequence[str]) -> str:
        return f"[{', '.join(map(toml_string, paths))}]"

    return (
        f"[[rig]]\nname = {toml_string(name)}\nrod = {toml_string(rod)}\ntrain = {listed(train)}\nvalidate = {listed(validate)}\n"
    )


def _key(key: object) -> str:
    text = str(key)
    return text if re.fullmatch(r"[A-Za-z0-9_-]+", text) else toml_string(text)


def _value(place: str, value: object) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, str):
        return toml_string(value)
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        number = float(value)
        if math.isfinite(number):
            return repr(number)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {_value(f'{place}.{key}', one)}" for key, one in value.items()) + " }"
    if isinstance(value, (Sequence, np.ndarray)):
        return "[" + ", ".join(_value(place, one) for one in value) + "]"
    raise InputError(
        f"rod: {place} = {value!r}; expected a finite number, text, true or false, a list, or a table of these; leave out what "
        "you do not know",
        file="rod.toml",
        column=place,
    )
