"""Identify, diagnose and control shape-memory-alloy (SMA) actuators from recordings of drive and displacement.

A thin layer over the program ``sma``, which comes with the package::

    import sma

    rig = sma.identify("rod.toml", train=frame)
    print(rig["tau_s"], rig.train_rmse)

Recordings are paths, frames of pandas or polars, dicts of arrays or matrices; results are dataclasses with units, 95 % intervals
and arrays. Bad input is an :class:`InputError` with file, line or row, and column. Nothing that is given is altered.
"""

from __future__ import annotations

from .batch import Batched, Estimate, Failure, Rig, Row, RowFinding, batch
from .call import Model, ModelLike, RecordingLike, Recordings, RodLike, Use
from .demo import Demo, demo
from .diagnose import Diagnosed, Entry, Finding, Stage, diagnose
from .errors import InputError, MissingExtraError, NoControllerError, ProgramError, SmaError
from .files import read
from .identify import Identified, identify
from .init import init
from .inspect import Channel, Inspected, Inspection, inspect
from .program import Progress, program_path
from .results import Parameter, Series
from .simulate import Simulated, simulate
from .table import Table
from .trial import Score, Tried, trial
from .tune import Controller, Gains, Response, Tuned, tune

__all__ = [
    "Batched",
    "Channel",
    "Controller",
    "Demo",
    "Diagnosed",
    "Entry",
    "Estimate",
    "Failure",
    "Finding",
    "Gains",
    "Identified",
    "InputError",
    "Inspected",
    "Inspection",
    "MissingExtraError",
    "Model",
    "ModelLike",
    "NoControllerError",
    "Parameter",
    "ProgramError",
    "Progress",
    "RecordingLike",
    "Recordings",
    "Response",
    "Rig",
    "RodLike",
    "Row",
    "RowFinding",
    "Score",
    "Series",
    "Simulated",
    "SmaError",
    "Stage",
    "Table",
    "Tried",
    "Tuned",
    "Use",
    "batch",
    "demo",
    "diagnose",
    "identify",
    "init",
    "inspect",
    "program_path",
    "read",
    "simulate",
    "trial",
    "tune",
]
