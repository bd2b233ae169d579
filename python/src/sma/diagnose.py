"""``sma diagnose``: recordings in, the physics that the baseline model leaves out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from .call import Call, Model, ModelLike, Recordings, RodLike, Use
from .program import Progress
from .results import Interval, Parameter, Reported, Series, interval, parameters, plot_series, series

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Finding:
    """An effect that the baseline model leaves out."""

    #: Id of the effect, such as "latent-heat".
    effect: str
    #: Effects that these recordings cannot tell from it.
    could_also_be: tuple[str, ...]
    #: Posterior probability of the name; ``None`` of a suspect.
    probability: float | None
    parameters: tuple[Parameter, ...]
    #: False if the literature has no such value.
    plausible: bool
    #: All of it in a sentence.
    sentence: str

    def __str__(self) -> str:
        return self.sentence


@dataclass(frozen=True)
class Stage:
    """A model of a diagnosis: the baseline model, or the one with the effects that were found."""

    #: Effects beside the baseline model.
    effects: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    #: Root of the mean square error on the training recordings, in the output's unit.
    train_rmse: float | None
    #: That on unseen recordings, each stretch with the offset that the others tell; with that of the whole recording, as in the
    #: series, it differs by little.
    validate_rmse: float | None
    #: That on unseen recordings, of which the samples at rest alone are read.
    predicted_rmse: float | None
    #: That of the recorded temperatures of the training, K; ``None`` without any.
    temperature_rmse_k: float | None


@dataclass(frozen=True)
class Entry:
    """What the recordings say of one effect of the catalogue."""

    effect: str
    #: "detected", "excluded", "not_testable", …
    verdict: str
    #: Largest size that the recordings allow, in ``unit``; ``None`` where it is not excluded.
    upper_limit: float | None
    #: Smallest size that would be seen, in ``unit``.
    minimum_detectable: float | None
    unit: str
    #: Why it cannot be tested.
    reason: str | None


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosed(Reported):
    """What the baseline model leaves out, or that it leaves out nothing that shows."""

    #: "adequate", "explained", "ambiguous", "explained_in_part", "unexplained", "not_converged"; ``None`` if nothing can be tested.
    verdict: str | None
    #: False if the baseline model did not converge or is implausible; then nothing is to be used.
    usable: bool
    #: Why no rig can be so, a sentence each.
    implausible: tuple[str, ...]
    findings: tuple[Finding, ...]
    #: Candidates where the catalogue does not account for the misfit.
    suspects: tuple[Finding, ...]
    baseline: Stage
    #: The model with what was found; ``None`` where nothing was.
    extended: Stage | None
    #: Share of the explainable error that findings and suspects explain, 0 to 1, on unseen recordings, with its 95 % interval.
    explained_fraction: float | None
    explained_interval: Interval | None
    #: The same by the findings alone; ``None`` without findings or unseen recordings.
    explained_by_findings: float | None
    #: Lower and upper estimate of the noise, in ``output_unit``.
    noise_floor: tuple[float | None, float | None]
    #: Part of the model where the mismatch is: "drive", "heat-balance", "transformation", "displacement"; ``None`` without one.
    block: str | None
    catalogue: tuple[Entry, ...]
    #: Parts of the search that were left out for the effort or the time limit: "other_loops", "more_effects", "other_starts", "next_run".
    left_out: tuple[str, ...]
    output_unit: str
    #: The recordings, sample by sample, with the last model and the baseline model through them; empty for static recordings.
    series: tuple[Series, ...]
    #: The model with what was found, to simulate, to tune, and to keep; ``None`` where none is to be used.
    model: Model | None
    #: The run that would tell more, CSV text with time and drive; ``None`` where none is proposed.
    next_run: str | None
    notes: tuple[str, ...]
    report: str = field(repr=False)
    text: str = field(repr=False)
    #: The program's JSON.
    raw: Mapping[str, Any] = field(repr=False)

    def plot(self) -> Figure:
        """Each recording with both models through it, and what is left; needs matplotlib.

        Raises:
            ValueError: static recordings, which have no series.
        """
        if not self.series:
            raise ValueError("no series: the recordings are static, or the model did not converge")
        return plot_series(self.series)

    def __repr__(self) -> str:
        said = "; ".join(one.sentence for one in self.findings) or "no finding"
        return f"<sma.Diagnosed {self.verdict}: {said}>"


def diagnose(
    rod: RodLike,
    train: Recordings,
    validate: Recordings | None = None,
    *,
    use: Use | None = None,
    without: Sequence[str] = (),
    from_model: ModelLike | None = None,
    effort: Literal["quick", "normal", "thorough"] = "normal",
    time_limit_s: float | None = None,
    seed: int = 1,
    threads: int = 0,
    flags: Sequence[str] = (),
    progress: Progress = None,
) -> Diagnosed:
    """Say which physics the baseline model of a rig leaves out, or that it leaves out nothing that shows.

    Args:
        rod, train, validate, use, from_model, seed, threads, progress: as of :func:`sma.identify`.
        without: effects that are not to be found, such as ``["latent-heat"]``.
        effort: how widely is searched; what "quick" leaves out stands in ``left_out``.
        time_limit_s: time after which nothing more is begun that may be left out, s; the result then depends on the machine.
        flags: further flags of ``sma diagnose``, such as ``["--hypothesis", "own.toml"]``.

    Raises:
        InputError: bad input, with file, line or row, and column.
        ProgramError: the program is missing or failed.
    """
    with Call() as call:
        arguments = ["diagnose", call.rod(rod), "--train", *call.recordings(train, "train")]
        unseen = call.recordings(validate, "validate")
        if unseen:
            arguments += ["--validate", *unseen]
        if without:
            arguments += ["--without", *without]
        if from_model is not None:
            arguments += ["--from-model", call.model(from_model)]
        arguments += ["--effort", effort]
        if time_limit_s is not None:
            arguments += ["--time-limit-s", repr(float(time_limit_s))]
        places = {name: call.place(name) for name in ("json", "series", "report", "save-model", "save-next")}
        # What an interrupted search keeps goes with the call.
        arguments += ["--resume", str(call.place("kept"))]
        for name, place in places.items():
            arguments += [f"--{name}", str(place)]
        arguments += ["--seed", str(seed), "--threads", str(threads), *call.used(use), *flags]
        ended = call.run(arguments, progress)
        # What the program has nothing to say in, it does not write.
        written = {
            name: place.read_text(encoding="utf-8") if place.is_file() and place.stat().st_size else None
            for name, place in places.items()
        }
        raw = call.document(written["json"] or "null")
        return _diagnosed(call, raw, written, usable=ended.code == 0, notes=ended.notes, text=ended.text)


def _diagnosed(
    call: Call,
    raw: Mapping[str, Any],
    written: Mapping[str, str | None],
    *,
    usable: bool,
    notes: tuple[str, ...],
    text: str,
) -> Diagnosed:
    simulated, page, model = written["series"], written["report"], written["save-model"]
    floor, explained = raw["noise_floor"], raw["explained_fraction"]
    return Diagnosed(
        verdict=raw["verdict"],
        usable=usable,
        implausible=tuple(one["sentence"] for one in raw["implausible"] or ()),
        findings=tuple(_finding(one) for one in raw["findings"]),
        suspects=tuple(_finding(one) for one in raw["suspects"]),
        baseline=_stage(raw["baseline"]),
        extended=None if raw["extended"] is None else _stage(raw["extended"]),
        explained_fraction=explained["validate"],
        explained_interval=interval(explained["validate_interval"]),
        explained_by_findings=explained["by_findings"],
        noise_floor=(floor["lower"], floor["upper"]),
        block=raw["mismatch"]["block"],
        catalogue=tuple(_entry(one) for one in raw["catalogue"]),
        left_out=tuple(raw.get("left_out", ())),
        output_unit=raw["output_unit"],
        series=series(call.document(simulated)) if simulated is not None else (),
        model=Model(call.named(model, is_json=True)) if model is not None else None,
        next_run=written["save-next"],
        notes=notes,
        report=call.named(page) if page is not None else "",
        text=text,
        raw=raw,
    )


def _finding(one: Mapping[str, Any]) -> Finding:
    return Finding(
        effect=one["effect"],
        could_also_be=tuple(one["could_also_be"]),
        probability=one["probability"],
        parameters=tuple(
            Parameter(
                name=parameter["name"],
                unit=parameter["unit"],
                values=(parameter["value"],),
                intervals=(interval(parameter["ci95"]),),
            )
            for parameter in one["parameters"]
        ),
        plausible=one["plausible"],
        sentence=one["sentence"],
    )


def _stage(one: Mapping[str, Any]) -> Stage:
    # Those of static recordings are the sizes of effects, which stand in the findings.
    fitted = [parameter for parameter in one["parameters"] if "values" in parameter]
    return Stage(
        effects=tuple(one.get("effects", ())),
        parameters=parameters(fitted),
        train_rmse=one["train_rmse"],
        validate_rmse=one["validate_rmse"],
        predicted_rmse=one["predicted_rmse"],
        temperature_rmse_k=one["temperature_rmse_k"],
    )


def _entry(one: Mapping[str, Any]) -> Entry:
    return Entry(
        effect=one["effect"],
        verdict=one["verdict"],
        upper_limit=one["upper_limit"],
        minimum_detectable=one["minimum_detectable"],
        unit=one["unit"],
        reason=one["reason"],
    )
