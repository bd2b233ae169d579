"""``sma tune``: a controller for an identified model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from .call import Call, ModelLike
from .columns import grouped
from .errors import InputError
from .program import Progress
from .results import Array, Reported, subplots

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Gains:
    """Gains of a PID in its parallel form, drive per error; the error in the output's unit."""

    #: drive / output
    kp: float
    #: drive / (output s)
    ki: float
    #: drive s / output
    kd: float


@dataclass(frozen=True)
class Controller:
    """A controller and its response to the step."""

    #: "tuned", or that which it is compared with, such as "SIMC".
    name: str
    gains: Gains
    cost: float | None
    #: Mean square error, in the square of the output's unit.
    mse: float
    #: Times after the step, s, and overshoot, a share of the step; ``None`` where it never gets there.
    rise_time_s: float | None
    settling_time_s: float | None
    overshoot: float | None
    #: Margins where the loop is steepest; ``None`` without a limit.
    gain_margin: float | None
    phase_margin_deg: float | None
    #: Largest share of the drive's range by which a jump of the sensor moves the drive.
    kick: float | None


@dataclass(frozen=True, eq=False, repr=False)
class Response:
    """A simulated response to a reference. All arrays have one value a sample."""

    #: "step", or the name of a reference.
    reference: str
    #: Name of the controller.
    controller: str
    time_s: Array
    #: Set point and output, in ``output_unit``.
    setpoint: Array
    output: Array
    output_unit: str
    #: Drive, in ``drive_unit``.
    drive: Array
    drive_unit: str


@dataclass(frozen=True, eq=False, repr=False)
class Tuned(Reported):
    """A controller, how good it is, and what it stands beside."""

    #: Gains of the tuned controller; with ``--gain-schedule`` among the flags those where the rig is steepest, and
    #: ``raw["controller"]["gain_schedule"]`` has the factors elsewhere.
    gains: Gains
    #: All controllers that are compared, the tuned one among them.
    controllers: tuple[Controller, ...]
    responses: tuple[Response, ...]
    output_unit: str
    drive_unit: str
    #: Sample time of the controller, s.
    sample_time_s: float
    #: Whether a recording of the rig did as promised (``--check`` among the flags); ``None`` without one.
    as_promised: bool | None
    notes: tuple[str, ...]
    report: str = field(repr=False)
    text: str = field(repr=False)
    #: The program's JSON.
    raw: Mapping[str, Any] = field(repr=False)

    def plot(self) -> Figure:
        """Output and drive of each controller over time, a column a reference; needs matplotlib."""
        references = list(dict.fromkeys(one.reference for one in self.responses))
        figure, axes = subplots(2, len(references))
        for k, reference in enumerate(references):
            above, below = axes[0, k], axes[1, k]
            own = [one for one in self.responses if one.reference == reference]
            above.plot(own[0].time_s, own[0].setpoint, "--", color="0.6", label="set point")
            for one in own:
                above.plot(one.time_s, one.output, linewidth=1, label=one.controller)
                below.plot(one.time_s, one.drive, linewidth=1)
            above.set_title(reference, fontsize="medium")
            above.set_ylabel(f"output, {self.output_unit}")
            above.legend(fontsize="small")
            below.set_ylabel(f"drive, {self.drive_unit}")
            below.set_xlabel("time, s")
        return figure

    def __repr__(self) -> str:
        return f"<sma.Tuned: kp = {self.gains.kp:.4g}, ki = {self.gains.ki:.4g}, kd = {self.gains.kd:.4g}>"


def tune(
    model: ModelLike,
    step_output: float,
    drive_max: float | None = None,
    *,
    gains: tuple[float, float, float] | None = None,
    seed: int = 1,
    threads: int = 0,
    flags: Sequence[str] = (),
    progress: Progress = None,
) -> Tuned:
    """Tune a PID controller on an identified model.

    Args:
        model: a path to a ``model.toml``, a :class:`sma.Model`, or a result of identify or diagnose.
        step_output: set point of the step, as the sensor reads it, in the output's unit.
        drive_max: largest drive, in its unit; that of the model's rod file unless given.
        gains: kp, ki and kd of your own, to stand beside.
        seed, threads, progress: as of :func:`sma.identify`.
        flags: further flags of ``sma tune``, such as ``["--rods", "20", "--check", "rig.csv"]``.

    Raises:
        NoControllerError: no gains meet what is required.
        InputError: bad input, with file, line or row, and column.
        ProgramError: the program is missing or failed.
    """
    with Call() as call:
        arguments = ["tune", call.model(model), "--step-output", repr(float(step_output))]
        if drive_max is not None:
            arguments += ["--drive-max", repr(float(drive_max))]
        if gains is not None:
            if len(gains) != 3:
                raise InputError(f"gains = {gains!r}: expected three numbers, kp, ki and kd", column="gains")
            arguments += ["--gains", *(repr(float(one)) for one in gains)]
        places = {name: call.place(name) for name in ("json", "responses", "report")}
        for name, place in places.items():
            arguments += [f"--{name}", str(place)]
        ended = call.run([*arguments, "--seed", str(seed), "--threads", str(threads), *flags], progress)
        raw = call.document(places["json"].read_text(encoding="utf-8"))
        controllers = tuple(_controller(one) for one in raw["controllers"])
        units = (raw["output_unit"], raw["drive_unit"])
        return Tuned(
            gains=next(one.gains for one in controllers if one.name == "tuned"),
            controllers=controllers,
            responses=_responses(places["responses"].read_text(encoding="utf-8"), *units),
            output_unit=units[0],
            drive_unit=units[1],
            sample_time_s=raw["sample_time_s"],
            as_promised=raw["checked"] and raw["checked"]["as_promised"],
            notes=ended.notes,
            report=call.named(places["report"].read_text(encoding="utf-8")),
            text=ended.text,
            raw=raw,
        )


def _controller(one: Mapping[str, Any]) -> Controller:
    terms, margins = one["terms"], one["margins"] or {}
    return Controller(
        name=one["name"],
        gains=Gains(**one["gains"]),
        cost=one["cost"],
        mse=terms["mse"],
        rise_time_s=terms["rise_time_s"],
        settling_time_s=terms["settling_time_s"],
        overshoot=terms["overshoot"],
        gain_margin=margins.get("gain_margin"),
        phase_margin_deg=margins.get("phase_margin_deg"),
        kick=one["kick"],
    )


def _responses(csv: str, output_unit: str, drive_unit: str) -> tuple[Response, ...]:
    responses = []
    for (reference, controller), columns in grouped(csv, ("reference", "controller")).items():
        time_s, setpoint, output, drive = columns.values()
        responses.append(Response(reference, controller, time_s, setpoint, output, output_unit, drive, drive_unit))
    return tuple(responses)
