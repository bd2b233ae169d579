"""``sma demo``: recordings of a simulated wire that conceals something."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path

from .call import Call
from .program import Progress
from .results import Reported


@dataclass(frozen=True)
class Demo(Reported):
    """Files of the demonstration."""

    rod: Path
    #: A recording to fit, and one to check the fit on, CSV.
    train: Path
    unseen: Path
    report: str = field(repr=False)
    text: str = field(repr=False)


def demo(folder: str | os.PathLike[str] = "sma-demo", *, progress: Progress = None) -> Demo:
    """Show all of it on a simulated wire, and leave its files in a folder; files of their names in it are replaced.

    Raises:
        ProgramError: the program is missing or failed.
    """
    place = Path(folder)
    with Call() as call:
        ended = call.run(["demo", "--out", str(place)], progress)
    report = (place / "report.html").read_text(encoding="utf-8")
    return Demo(place / "rod.toml", place / "train.csv", place / "unseen.csv", report, ended.text)
