"""``sma simulate``: what an identified model says of a drive."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from .call import Call, ModelLike, RecordingLike, Use
from .columns import numbers
from .program import Progress
from .results import Array, subplots

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class Simulated:
    """A prediction, sample by sample."""

    #: Columns as the program writes them, with units in their names: ``time_s``, ``current_a``, ``displacement_mm``,
    #: ``temperature_degc`` …
    columns: Mapping[str, Array]
    #: Caveats, and how well a recorded output beside the drive is met.
    notes: tuple[str, ...]
    #: The same as CSV, which is itself a recording.
    csv: str = field(repr=False)

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    def __repr__(self) -> str:
        n = len(next(iter(self.columns.values())))
        return f"<sma.Simulated: {n} rows of {', '.join(self.columns)}>"

    def _repr_html_(self) -> str:
        notes = "".join(f"<li>{html.escape(note)}</li>" for note in self.notes)
        return f"{html.escape(repr(self))}<ul>{notes}</ul>"

    def plot(self) -> Figure:
        """Each column over the first; needs matplotlib."""
        titles = list(self.columns)
        figure, axes = subplots(len(titles) - 1, 1)
        for k, title in enumerate(titles[1:]):
            axes[k, 0].plot(self.columns[titles[0]], self.columns[title], linewidth=1)
            axes[k, 0].set_ylabel(title)
        axes[-1, 0].set_xlabel(titles[0])
        return figure


def simulate(
    model: ModelLike,
    drive: RecordingLike,
    *,
    use: Use | None = None,
    flags: Sequence[str] = (),
    progress: Progress = None,
) -> Simulated:
    """Predict what a rig does under a drive.

    Args:
        model: a path to a ``model.toml``, a :class:`sma.Model`, or a result of identify or diagnose.
        drive: a profile with the columns of the model's rod file; with a recorded output, both are compared in the notes.
        use, progress: as of :func:`sma.identify`.
        flags: further flags of ``sma simulate``.

    Raises:
        InputError: bad input, with file, line or row, and column.
        ProgramError: the program is missing or failed.
    """
    with Call() as call:
        place = call.place("predicted.csv")
        arguments = ["simulate", call.model(model), "--drive", call.recording(drive, "drive"), "--output", str(place)]
        ended = call.run([*arguments, *call.used(use), *flags], progress)
        csv = place.read_text(encoding="utf-8")
        return Simulated(columns=numbers(csv), notes=ended.notes, csv=csv)
