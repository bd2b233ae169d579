"""``sma inspect``: what is in recordings, before anybody fits anything to them."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from .call import Call, Recordings, RodLike, Use
from .program import Progress


@dataclass(frozen=True)
class Channel:
    """A column that has a meaning."""

    #: "drive", "output", "temperature", …
    role: str
    unit: str
    #: Smallest and largest value, in ``unit``.
    lowest: float
    highest: float
    #: Step of the converter, in ``unit``; ``None`` where none shows.
    quantization_step: float | None


@dataclass(frozen=True)
class Inspection:
    """What is in one recording."""

    name: str
    n_samples: int
    #: From the first to the last sample, s; ``None`` in static data.
    duration_s: float | None
    #: Median step, s; ``None`` in static data.
    dt_s: float | None
    channels: tuple[Channel, ...]
    #: Lower and upper estimate of the noise, in the output's unit; ``None`` where it is not estimated.
    noise_floor: tuple[float, float] | None
    #: Whole cycles of the drive.
    cycles: int
    #: What was done to read it, such as missing numbers that were filled, a sentence each.
    adaptations: tuple[str, ...]
    #: What stands in the way of identification, a sentence each.
    warnings: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Inspected:
    """What is in recordings."""

    recordings: tuple[Inspection, ...]
    #: The program's JSON.
    raw: Mapping[str, Any] = field(repr=False)

    def _repr_html_(self) -> str:
        parts = []
        for one in self.recordings:
            rows = "".join(
                f"<tr><td>{html.escape(channel.role)}</td><td>{channel.lowest:.4g} to {channel.highest:.4g}</td>"
                f"<td>{html.escape(channel.unit)}</td></tr>"
                for channel in one.channels
            )
            said = "".join(f"<li>{html.escape(text)}</li>" for text in one.adaptations + one.warnings)
            lasts = "" if one.duration_s is None else f" over {one.duration_s:.4g} s"
            parts.append(
                f"<p><b>{html.escape(one.name)}</b>: {one.n_samples} samples{lasts}</p><table>{rows}</table><ul>{said}</ul>"
            )
        return "".join(parts)


def inspect(
    recordings: Recordings,
    rod: RodLike | None = None,
    *,
    use: Use | None = None,
    flags: Sequence[str] = (),
    progress: Progress = None,
) -> Inspected:
    """Say what is in recordings: sampling, gaps, units, steps of the converter, noise, cycles, and what stands in the way.

    Args:
        recordings: one or a list, or a dict of them by name; see :func:`sma.identify`.
        rod: what is known of the rig, the names of columns and the kind of drive; guessed unless given.
        use, progress: as of :func:`sma.identify`.
        flags: further flags of ``sma inspect``.

    Raises:
        InputError: bad input, with file, line or row, and column.
        ProgramError: the program is missing or failed.
    """
    with Call() as call:
        arguments = ["inspect", *call.recordings(recordings, "recording"), "--json"]
        if rod is not None:
            arguments += ["--rod", call.rod(rod)]
        ended = call.run([*arguments, *call.used(use), *flags], progress)
        raw = call.document(ended.text)
        return Inspected(tuple(_inspection(call, one) for one in raw["recordings"]), raw)


def _inspection(call: Call, one: Mapping[str, Any]) -> Inspection:
    floor, sampling = one["noise_floor"], one["sampling"]
    return Inspection(
        name=one["name"],
        n_samples=one["n_samples"],
        duration_s=one["duration_s"],
        dt_s=sampling.get("dt_s", sampling.get("median_dt_s")),
        channels=tuple(
            Channel(
                role=channel["role"],
                unit=channel["unit"],
                lowest=channel["lowest"],
                highest=channel["highest"],
                quantization_step=channel["quantization_step"],
            )
            for channel in one["channels"]
        ),
        noise_floor=None if floor is None else (floor["lower"], floor["upper"]),
        cycles=one["cycles"],
        adaptations=tuple(call.in_rows(one["name"], _said(text)) for text in one["adaptations"]),
        warnings=tuple(_said(text) for text in one["warnings"]),
    )


def _said(text: object) -> str:
    if isinstance(text, Mapping):
        return str(text.get("sentence", text.get("what", text)))
    return str(text)
