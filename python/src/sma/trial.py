"""``sma trial``: how often a diagnosis is right, on cases whose answer is concealed from it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .call import Call, RecordingLike, RodLike
from .errors import InputError
from .program import Progress
from .results import Interval, Reported, interval


@dataclass(frozen=True)
class Score:
    """A quantity that was counted, beside its target."""

    quantity: str
    #: The figure; ``None`` where nothing was there to be counted.
    value: float | None
    #: Its 95 % interval; ``None`` where there is none.
    ci95: Interval | None
    #: Cases that count, and those of which they are; ``hits`` is ``None`` where the figure is no share.
    hits: int | None
    n: int
    #: The target in words, empty without one, and whether it was met.
    target: str
    met: bool | None


@dataclass(frozen=True, eq=False, repr=False)
class Tried(Reported):
    """Scores of a trial."""

    #: Cases that were diagnosed.
    n_cases: int
    scores: tuple[Score, ...]
    notes: tuple[str, ...]
    report: str = field(repr=False)
    text: str = field(repr=False)
    #: The program's JSON.
    raw: Mapping[str, Any] = field(repr=False)

    def __repr__(self) -> str:
        return f"<sma.Tried: {self.n_cases} cases>"


def trial(
    cases: int | None = None,
    *,
    out: str | os.PathLike[str] | None = None,
    families: Sequence[str] = (),
    like: RodLike | None = None,
    drive: RecordingLike | None = None,
    seed: str = "1",
    jobs: int = 0,
    flags: Sequence[str] = (),
    progress: Progress = None,
) -> Tried:
    """Try the diagnosis on cases whose answer is concealed from it, and count how often it is right.

    Args:
        cases: cases in all, about; 60 unless given, or every effect in three sizes with ``like``.
        out: folder of the trial, which a later call goes on with; none is left unless given.
        families: families of cases; all unless given.
        like, drive: a rod file and a drive of your own rig, to draw the cases around; both or none.
        seed: any text.
        jobs: cases under way at a time; 0 takes as many as there are processors.
        flags: further flags of ``sma trial``.
        progress: as of :func:`sma.identify`.

    Raises:
        InputError: bad input, with file, line or row, and column.
        ProgramError: the program is missing or failed.
    """
    if (like is None) != (drive is None):
        raise InputError("like and drive belong together; expected both or none", column="drive" if drive is None else "like")
    with Call() as call:
        folder = Path(out) if out is not None else call.place("trial")
        arguments = ["trial", "--out", str(folder), "--seed", seed, "--jobs", str(jobs)]
        if cases is not None:
            arguments += ["--cases", str(cases)]
        if families:
            arguments += ["--family", *families]
        if like is not None:
            arguments += ["--like", call.rod(like), "--drive", call.recording(drive, "drive")]
        places = {name: call.place(name) for name in ("json", "report")}
        for name, place in places.items():
            arguments += [f"--{name}", str(place)]
        ended = call.run([*arguments, *flags], progress)
        raw = call.document(places["json"].read_text(encoding="utf-8"))
        return Tried(
            n_cases=raw["cases"],
            scores=tuple(_score(one) for one in raw["table"]),
            notes=ended.notes,
            report=call.named(places["report"].read_text(encoding="utf-8")),
            text=ended.text,
            raw=raw,
        )


def _score(one: Mapping[str, Any]) -> Score:
    return Score(
        quantity=one["quantity"],
        value=one["value"],
        ci95=interval(one["interval_95"]),
        hits=one["hits"],
        n=one["n"],
        target=one["target"],
        met=one["met"],
    )
