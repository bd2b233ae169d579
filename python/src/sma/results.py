"""Parts that several results have."""

from __future__ import annotations

import html
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .errors import missing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]

#: Bounds of a 95 % interval.
Interval = tuple[float, float]


@dataclass(frozen=True)
class Parameter:
    """A parameter of a model."""

    name: str
    #: "1" for a pure number.
    unit: str
    #: Values: one, or one a training recording if ``per_recording``; ``None`` where the recordings do not determine it.
    values: tuple[float | None, ...]
    #: 95 % intervals of the values; ``None`` where there is none, as of a fixed value.
    intervals: tuple[Interval | None, ...]
    per_recording: bool = False
    fixed: bool = False
    #: True if the value lies on a bound of its search, which is then not to be trusted.
    at_bound: bool = False

    @property
    def value(self) -> float | None:
        """The value; that of the first recording if each has its own."""
        return self.values[0]

    @property
    def ci95(self) -> Interval | None:
        """The 95 % interval of :attr:`value`."""
        return self.intervals[0]

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        if self.value is None:
            return f"{self.name}: not determined"
        if self.ci95 is None:
            return f"{self.name} = {self.value:.4g}{unit}"
        return f"{self.name} = {self.value:.4g}{unit} ({self.ci95[0]:.4g} to {self.ci95[1]:.4g})"


@dataclass(frozen=True, eq=False)
class Series:
    """A recording as it was fitted, sample by sample, with the model through it. All arrays have one value a sample."""

    #: Name of the recording.
    name: str
    #: "train" or "validate".
    role: str
    #: Times, s; ``None`` in static data.
    time_s: Array | None
    #: Drive, in ``drive_unit``.
    drive: Array
    drive_unit: str
    #: Recorded output, in ``output_unit``.
    output: Array
    output_unit: str
    #: Output of the model, in ``output_unit``.
    simulated: Array
    #: State: temperature of the model's rod, °C; ``None`` in static data, where it is the drive.
    temperature_degc: Array | None
    #: Output of the baseline model, where ``simulated`` is that of one with effects.
    baseline: Array | None = None

    @property
    def residuals(self) -> Array:
        """Recorded minus simulated output, in ``output_unit``."""
        return self.output - self.simulated

    @property
    def rmse(self) -> float:
        """Root of the mean square of the residuals, in ``output_unit``."""
        return float(np.sqrt(np.mean(self.residuals**2)))


def parameters(document: Iterable[Mapping[str, Any]]) -> tuple[Parameter, ...]:
    """Parameters of a fit."""
    return tuple(
        Parameter(
            name=one["name"],
            unit=one["unit"],
            values=tuple(one["values"]),
            intervals=tuple(interval(bounds) for bounds in one["ci95"]),
            per_recording=one["per_recording"],
            fixed=one["fixed"],
            at_bound=one["at_bound"],
        )
        for one in document
    )


def interval(bounds: Sequence[float] | None) -> Interval | None:
    """Two bounds, if there are any."""
    return None if bounds is None else (float(bounds[0]), float(bounds[1]))


def series(document: Mapping[str, Any]) -> tuple[Series, ...]:
    """The recordings of a ``--series`` document."""
    return tuple(_series(one) for one in document["recordings"])


def _series(one: Mapping[str, Any]) -> Series:
    models = one["models"]
    last = models[-1]
    return Series(
        name=one["name"],
        role=one["role"],
        time_s=_array(one["time_s"]),
        drive=np.asarray(one["drive"], dtype=np.float64),
        drive_unit=one["drive_unit"],
        output=np.asarray(one["output"], dtype=np.float64),
        output_unit=one["output_unit"],
        simulated=np.asarray(last["output"], dtype=np.float64),
        temperature_degc=_array(last["temperature_degc"]),
        baseline=_array(models[0]["output"]) if len(models) > 1 else None,
    )


def _array(values: Sequence[float] | None) -> Array | None:
    return None if values is None else np.asarray(values, dtype=np.float64)


class Reported:
    """A result with a page for people."""

    #: The page of ``--report``, HTML; empty if the program has none for this result.
    report: str
    #: What the program prints for people.
    text: str

    def save_report(self, path: str | os.PathLike[str]) -> None:
        """Write the page as one HTML file that needs no network."""
        Path(path).write_text(self.report, encoding="utf-8")

    def __str__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        if not self.report:
            return f"<pre>{html.escape(self.text)}</pre>"
        # The page has its own style and scripts: a frame keeps them apart from the notebook's.
        page = html.escape(self.report, quote=True)
        return f'<iframe srcdoc="{page}" sandbox="allow-scripts" style="width:100%;height:40em;border:0"></iframe>'


def plot_series(series: Sequence[Series]) -> Figure:
    """Each recording over time with the model through it, and what is left between them."""
    figure, axes = subplots(2, len(series))
    for k, one in enumerate(series):
        above, below = axes[0, k], axes[1, k]
        at = one.drive if one.time_s is None else one.time_s
        line = "." if one.time_s is None else "-"
        above.plot(at, one.output, ".", markersize=2, color="0.6", label="recorded")
        if one.baseline is not None:
            above.plot(at, one.baseline, line, linewidth=1, label="baseline model")
        label = "model" if one.baseline is None else "extended model"
        above.plot(at, one.simulated, line, linewidth=1, label=label)
        above.set_title(f"{Path(one.name).name} ({one.role})", fontsize="medium")
        above.set_ylabel(f"output, {one.output_unit}")
        above.legend(fontsize="small")
        below.plot(at, one.residuals, line, linewidth=0.8, color="0.4")
        below.set_ylabel(f"recorded - model, {one.output_unit}")
        below.set_xlabel(f"drive, {one.drive_unit}" if one.time_s is None else "time, s")
    return figure


def subplots(rows: int, columns: int) -> tuple[Figure, Any]:
    """A figure with its axes as a matrix.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise missing("matplotlib", "plot", "plot()") from None
    figure, axes = plt.subplots(rows, columns, squeeze=False, sharex="col", figsize=(6 * columns, 3 * rows), layout="constrained")
    return figure, axes
