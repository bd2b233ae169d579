"""LabVIEW's ``.tdms``, by npTDMS."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, missing
from ..table import Table, table_of

#: Names by which a channel is a time.
TIME = re.compile(r"(time|zeit|t|timestamp)([ _\[(].*)?", re.IGNORECASE)


def read(path: Path, table: str | None) -> Table:
    """The recording in a ``.tdms`` file; ``table`` names a group."""
    try:
        import nptdms
    except ImportError:
        raise missing("npTDMS", "tdms", f"{path}: a .tdms file") from None
    with path.open("rb") as stream:
        if stream.read(4) != b"TDSm":
            raise InputError(f"{path}: does not begin as TDMS does; expected a .tdms file of LabVIEW", file=str(path))
    file: Any = nptdms.TdmsFile.read(path)
    if file.file_status.incomplete_final_segment:
        raise InputError(
            f"{path}: ends within a segment of data; expected a whole .tdms file: was it copied to its end, was the writer closed?",
            file=str(path),
        )
    groups = {group.name: group for group in file.groups() if any(len(one) for one in group.channels())}
    if table is not None and table not in groups:
        raise InputError(
            f'{path}: no group "{table}"; expected one of {", ".join(groups) or "none, it has no data"}',
            file=str(path),
            column=table,
        )
    if table is None:
        if len(groups) != 1:
            raise InputError(
                f'{path}: groups with data: {", ".join(groups) or "none"}; expected one, or table="NAME"', file=str(path)
            )
        table = next(iter(groups))
    channels = [one for one in groups[table].channels() if len(one)]
    columns: list[tuple[object, object]] = [(_name(one), one[:]) for one in channels]
    steps = [one.properties.get("wf_increment") for one in channels]
    notes: tuple[str, ...] = ()
    if not any(TIME.fullmatch(one.name) for one in channels) and steps[0] is not None:
        if len(set(steps)) > 1:
            raise InputError(
                f'{path}, group "{table}": channels of different steps, {", ".join(f"{step} s" for step in steps)}; expected one',
                file=str(path),
            )
        offset = float(channels[0].properties.get("wf_start_offset", 0.0))
        columns.insert(0, ("time_s", offset + np.arange(len(channels[0])) * float(steps[0])))
        notes = (f"time_s is counted from the waveform's step of {steps[0]} s",)
    return table_of(path.name, columns, place=f'group "{table}"', notes=notes)


def _name(channel: Any) -> str:
    """A channel's name, with the unit of its properties if it has none of its own."""
    name: str = channel.name
    unit = str(channel.properties.get("unit_string", "")).strip()
    if not unit or re.search(r"[\])]$", name) or name.lower().endswith("_" + unit.lower()):
        return name
    return f"{name} [{unit}]"
