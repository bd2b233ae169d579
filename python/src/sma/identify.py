"""``sma identify``: recordings in, an identified model out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from .call import Call, Model, ModelLike, Recordings, RodLike, Use
from .program import Progress
from .results import Array, Parameter, Reported, Series, parameters, plot_series, series

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class Identified(Reported):
    """An identified model, and how far to trust it."""

    #: True if the search found the minimum, and nothing says that no rig can be so. Else the numbers are not to be used.
    usable: bool
    #: True if the search found the minimum.
    converged: bool
    #: Why no rig can be so, a sentence each.
    implausible: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    #: Root of the mean square error on the training recordings, in ``output_unit``.
    train_rmse: float
    #: That on recordings that the fit has not seen; ``None`` without any.
    validate_rmse: float | None
    #: 1 - error / standard deviation of the recordings, %.
    fit_percent: float
    output_unit: str
    #: The recordings, sample by sample, with the model through them.
    series: tuple[Series, ...]
    #: The model, to simulate, to tune, and to keep.
    model: Model
    #: What the program remarks.
    notes: tuple[str, ...]
    report: str = field(repr=False)
    text: str = field(repr=False)
    #: The program's JSON.
    raw: Mapping[str, Any] = field(repr=False)

    def __getitem__(self, name: str) -> Parameter:
        """The parameter of this name; KeyError names those that there are."""
        for one in self.parameters:
            if one.name == name:
                return one
        raise KeyError(f"{name}: expected one of {', '.join(one.name for one in self.parameters)}")

    def fraction(self, one: Series) -> Array | None:
        """State: transformed fraction of the rod in one of :attr:`series`, a value a sample.

        ``None`` where the model's output is no multiple of it: with a lagging sensor, of a heat balance alone, or of two rods.
        """
        names = {parameter.name for parameter in self.parameters if not parameter.fixed or parameter.value}
        if "gain" not in names or not names <= PLAIN:
            return None
        gain = self["gain"].value
        stated = [
            recording for recording in self.raw["recordings"] if recording["role"] == one.role and recording["name"] == one.name
        ]
        if gain is None or not stated:
            return None
        offset = stated[0].get("offset")
        if offset is None:
            trained = [recording["name"] for recording in self.raw["recordings"] if recording["role"] == "train"]
            offset = self["offset"].values[trained.index(one.name)]
        if offset is None:
            return None
        return (one.simulated - float(offset)) / gain

    def plot(self) -> Figure:
        """Each recording with the model through it, and what is left; needs matplotlib."""
        return plot_series(self.series)

    def __repr__(self) -> str:
        state = "" if self.usable else ", NOT TO BE USED"
        values = ", ".join(str(one) for one in self.parameters if not one.fixed)
        return f"<sma.Identified: {values}{state}>"


#: Parameters of the plain cascade, whose output is offset + gain · fraction.
PLAIN = frozenset(
    "tau_s loop_center_degc loop_half_width_k loop_spread_k zeta gain offset start_rise_k start_share "
    "start_since_reversal_k ambient_level_k loop_center loop_half_width loop_spread conductance_w_per_k ambient_degc".split()
)


def identify(
    rod: RodLike,
    train: Recordings,
    validate: Recordings | None = None,
    *,
    use: Use | None = None,
    from_model: ModelLike | None = None,
    seed: int = 1,
    threads: int = 0,
    flags: Sequence[str] = (),
    progress: Progress = None,
) -> Identified:
    """Fit the grey-box model to recordings, and check it on recordings that it has not seen.

    Args:
        rod: what is known of the rig: a path to a ``rod.toml``, or its tables as nested dicts.
        train: recordings to fit: one or a list, or a dict of them by name. A recording is a path (CSV, ``.mat``, ``.tdms``,
            ``.xlsx``, ``.parquet`` …), a frame of pandas or polars, a dict of arrays, a matrix or a :class:`sma.Table`. Columns have
            their units in their names: ``time_s``, ``current_a``, ``displacement_mm``; the rod file may name others.
        validate: recordings to check the fit on.
        use: the part of the recordings that counts.
        from_model: an earlier model to start one more search from.
        seed: same seed and inputs, same result.
        threads: 0 takes all; the result does not depend on it.
        flags: further flags of ``sma identify``, such as ``["--loss", "huber"]``.
        progress: see :data:`sma.Progress`.

    Not converging is a result: see :attr:`Identified.usable`.

    Raises:
        InputError: bad input, with file, line or row, and column.
        ProgramError: the program is missing or failed.
    """
    with Call() as call:
        arguments = ["identify", call.rod(rod), "--train", *call.recordings(train, "train")]
        unseen = call.recordings(validate, "validate")
        if unseen:
            arguments += ["--validate", *unseen]
        if from_model is not None:
            arguments += ["--from-model", call.model(from_model)]
        places = {name: call.place(name) for name in ("json", "series", "report", "save-model")}
        # What an interrupted search keeps goes with the call.
        arguments += ["--resume", str(call.place("kept"))]
        for name, place in places.items():
            arguments += [f"--{name}", str(place)]
        arguments += ["--seed", str(seed), "--threads", str(threads), *call.used(use), *flags]
        ended = call.run(arguments, progress)
        raw = call.document(places["json"].read_text(encoding="utf-8"))
        fit = raw["fit"]
        return Identified(
            usable=ended.code == 0,
            converged=fit["converged"],
            implausible=tuple(one["sentence"] for one in raw["implausible"]),
            parameters=parameters(raw["parameters"]),
            train_rmse=fit["train_rmse"],
            validate_rmse=fit["validate_rmse"],
            fit_percent=fit["fit_percent"],
            output_unit=raw["output_unit"],
            series=series(call.document(places["series"].read_text(encoding="utf-8"))),
            model=Model(call.named(places["save-model"].read_text(encoding="utf-8"), is_json=True)),
            notes=ended.notes,
            report=call.named(places["report"].read_text(encoding="utf-8")),
            text=ended.text,
            raw=raw,
        )
