"""``sma batch``: one command on every rig of a fleet."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from .call import Call, Recordings, RodLike
from .errors import ProgramError
from .program import Progress
from .results import Interval, Reported, interval
from .rod import rig_table


@dataclass(frozen=True)
class Rig:
    """A rig of a fleet that is given by its parts, and not as a folder or a manifest."""

    name: str
    rod: RodLike
    #: One recording, several, or several by name, as of :func:`sma.identify`.
    train: Recordings
    validate: Recordings | None = None


@dataclass(frozen=True)
class Estimate:
    """A size in a table of rigs."""

    name: str
    value: float
    ci95: Interval | None
    #: "1" for a pure number.
    unit: str


@dataclass(frozen=True)
class RowFinding:
    """Physics that is missing in a rig."""

    effect: str
    #: Effects that these recordings cannot tell from it.
    could_also_be: tuple[str, ...]
    probability: float | None
    parameters: tuple[Estimate, ...]


@dataclass(frozen=True)
class Failure:
    """Reason why a rig has no result."""

    sentence: str
    file: str | None
    line: int | None


@dataclass(frozen=True)
class Row:
    """A rig and its result."""

    rig: str
    #: "done", "failed" (bad input, or a crash), or "open": not run, and run by the next call.
    status: Literal["done", "failed", "open"]
    #: True if there is a result that may be used: the search converged, and a rig can be like that.
    usable: bool
    #: Verdict of the diagnosis; of an identification ``identified`` or ``not_converged``.
    verdict: str | None
    findings: tuple[RowFinding, ...]
    #: Parameters that all recordings of the rig share.
    parameters: tuple[Estimate, ...]
    output_unit: str | None
    #: Errors of the baseline model, RMS, in ``output_unit``.
    train_rmse: float | None
    validate_rmse: float | None
    #: The same with what was found.
    extended_train_rmse: float | None
    extended_validate_rmse: float | None
    failure: Failure | None
    #: Name of its file in ``units``, without ``.json``.
    unit: str | None

    def __getitem__(self, name: str) -> Estimate:
        """The parameter of a name."""
        for one in self.parameters:
            if one.name == name:
                return one
        names = ", ".join(one.name for one in self.parameters) or "none, since it has no result"
        raise KeyError(f"{name}: expected one of {names}")


@dataclass(frozen=True, eq=False, repr=False)
class Batched(Reported):
    """A fleet, a row a rig, in the order of the fleet."""

    rows: tuple[Row, ...]
    #: The table by its columns: numbers where all are, ``None`` where a rig has none. ``pandas.DataFrame(found.columns)`` takes it.
    columns: Mapping[str, Sequence[str | float | None]] = field(repr=False)
    notes: tuple[str, ...]
    report: str = field(repr=False)
    text: str = field(repr=False)
    #: The program's JSON.
    raw: Mapping[str, Any] = field(repr=False)

    def __getitem__(self, rig: str) -> Row:
        """The row of a rig."""
        for row in self.rows:
            if row.rig == rig:
                return row
        raise KeyError(f"{rig}: expected one of {', '.join(row.rig for row in self.rows)}")

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        counts = {status: sum(row.status == status for row in self.rows) for status in ("done", "failed", "open")}
        said = ", ".join(f"{n} {status}" for status, n in counts.items() if n)
        return f"<sma.Batched: {len(self.rows)} rigs, {said}>"


def batch(
    fleet: str | os.PathLike[str] | Sequence[Rig],
    out: str | os.PathLike[str] | None = None,
    *,
    do: Literal["diagnose", "identify"] = "diagnose",
    seed: int = 1,
    jobs: int = 0,
    retry: bool = False,
    scheduler: str | None = None,
    flags: Sequence[str] = (),
    progress: Progress = None,
) -> Batched:
    """Diagnose or identify every rig of a fleet. A rig that fails is a row, and no exception.

    Args:
        fleet: a folder of rigs, a manifest (``.csv``, ``.toml``), or a list of :class:`Rig`.
        out: folder of results, with which a later call goes on; none is left unless given.
        do: the command on each rig.
        seed: same seed and inputs, same results.
        jobs: rigs under way at a time; 0 takes as many as there are processors.
        retry: try rigs again that failed.
        scheduler: address of a Dask scheduler, on whose workers the rigs are run instead; needs the extra ``dask``.
        flags: further flags of ``sma batch``.
        progress: as of :func:`sma.identify`.

    Raises:
        InputError: the fleet cannot be read.
        MissingExtraError: Dask is not installed.
        ProgramError: the program is missing or failed, or is another build on the workers.
    """
    with Call() as call:
        folder = Path(out) if out is not None else call.place("batch")
        place = call.path(fleet) if isinstance(fleet, (str, os.PathLike)) else _manifest(call, fleet)
        of_units = ["--do", do, "--seed", str(seed), *flags]
        if scheduler is not None:
            from . import dask

            said = dask.run_units(scheduler, place, folder, of_units, retry=retry, progress=progress)
            of_run = ["--merge", str(folder)]
        else:
            said, of_run = [], ["--jobs", str(jobs), *(["--retry"] if retry else [])]
        places = {name: call.place(name) for name in ("csv", "report", "json")}
        for name, path in places.items():
            of_run += [f"--{name}", str(path)]
        try:
            ended = call.run(["batch", place, "--out", str(folder), *of_units, *of_run], progress)
            text, notes = ended.text, ended.notes
        except ProgramError as error:
            # Rigs that have no result yet are rows.
            if error.code != 1 or not places["json"].is_file():
                raise
            text, notes = str(error), (str(error),)
        raw = call.document(places["json"].read_text(encoding="utf-8"))
        table = list(csv.reader(io.StringIO(call.named(places["csv"].read_text(encoding="utf-8")))))
        return Batched(
            rows=tuple(_row(one) for one in raw["rigs"]),
            columns={title: _column([row[k] for row in table[1:]]) for k, title in enumerate(table[0])},
            notes=(*said, *notes),
            report=call.named(places["report"].read_text(encoding="utf-8")),
            text=text,
            raw=raw,
        )


def _manifest(call: Call, rigs: Sequence[Rig]) -> str:
    """A manifest of rigs that are given by their parts."""
    text = ""
    for k, rig in enumerate(rigs):
        train = call.recordings(rig.train, f"rig{k + 1}-train")
        validate = call.recordings(rig.validate, f"rig{k + 1}-validate")
        rod = call.rod(rig.rod, f"rod{k + 1}.toml")
        train, validate = (list(map(os.path.abspath, paths)) for paths in (train, validate))
        text += rig_table(rig.name, os.path.abspath(rod), train, validate)
    return call.written("fleet.toml", text)


def _column(cells: Sequence[str]) -> list[str | float | None]:
    """A column of the table: numbers, if all that is in it are."""
    try:
        return [float(cell) if cell else None for cell in cells]
    except ValueError:
        return [cell or None for cell in cells]


def _row(one: Mapping[str, Any]) -> Row:
    failure = one["failure"]
    return Row(
        rig=one["rig"],
        status=one["status"],
        usable=one["status"] == "done" and one["exit_code"] == 0,
        verdict=one["verdict"],
        findings=tuple(
            RowFinding(
                effect=found["effect"],
                could_also_be=tuple(found["could_also_be"]),
                probability=found["probability"],
                parameters=_estimates(found["parameters"]),
            )
            for found in one["findings"]
        ),
        parameters=_estimates(one["parameters"]),
        output_unit=one["output_unit"],
        train_rmse=one["train_rmse"],
        validate_rmse=one["validate_rmse"],
        extended_train_rmse=one["extended_train_rmse"],
        extended_validate_rmse=one["extended_validate_rmse"],
        failure=None if failure is None else Failure(failure["sentence"], failure["file"], failure["line"]),
        unit=one["unit"],
    )


def _estimates(sizes: Sequence[Mapping[str, Any]]) -> tuple[Estimate, ...]:
    return tuple(Estimate(one["name"], one["value"], interval(one["ci95"]), one["unit"]) for one in sizes)
