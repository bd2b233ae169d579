"""Frames, dicts and arrays in; nothing given is altered; what makes no sense is refused with its row and column."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pyarrow
import pytest

import sma


def test_every_kind_of_table_gives_the_bytes_of_the_path(columns: Any, rod: Path, train: Path) -> None:
    frame = pd.DataFrame(columns)
    given: dict[str, Any] = {
        "dict": columns,
        "lists": {title: values.tolist() for title, values in columns.items()},
        "pandas": frame,
        "pandas by index": frame.set_index("time_s"),
        "pandas of missing values": frame.convert_dtypes(),
        "polars": pl.DataFrame(columns),
        "polars lazy": pl.DataFrame(columns).lazy(),
        "pyarrow": pyarrow.table(columns),
        "structured": frame.to_records(index=False),
        "table": sma.Table("table", columns),
    }
    whole = sma.identify(rod, train=train)
    for name, one in given.items():
        found = sma.identify(rod, train=one)
        assert found.raw["parameters"] == whole.raw["parameters"], name
        assert found.raw["fit"] == whole.raw["fit"], name


def test_a_first_rod_file_names_the_columns(columns: Any, tmp_path: Path, identified: sma.Identified) -> None:
    text = sma.init({"run": columns})
    assert 'drive = { name = "current_a" }' in text and "from run" in text
    path = tmp_path / "rod.toml"
    path.write_text(text)
    assert sma.identify(path, train=columns).output_unit == identified.output_unit


def test_a_rod_of_dicts_is_the_rod_file(columns: Any, rod: Path, identified: sma.Identified) -> None:
    tables = {
        "rod": {
            "diameter_mm": 1.2,
            "length_mm": np.float64(110),
            "density_kg_per_m3": 6450,
            "specific_heat_j_per_kg_k": 480.0,
            "resistance_ohm_per_m": 0.83,
        },
        "surroundings": {"ambient_degc": 22.0},
        "drive": {"kind": "current"},
        "recordings": {"run 1.csv": {"window_s": [0, 1e6]}},
    }
    found = sma.identify(tables, train={"run 1.csv": columns})
    assert found.raw["parameters"] == identified.raw["parameters"]
    assert found.series[0].name == "run 1.csv"


def test_what_is_given_is_not_altered(columns: Any, rod: Path) -> None:
    frame = pd.DataFrame(columns)
    frame.loc[7, "displacement_mm"] = np.nan
    before = frame.copy(deep=True)
    arrays = {title: values.copy() for title, values in columns.items()}
    for values in arrays.values():
        values.flags.writeable = False
    tables = {"surroundings": {"ambient_degc": 22.0}}
    sma.identify(tables, train=[frame, arrays])
    pd.testing.assert_frame_equal(frame, before)
    assert tables == {"surroundings": {"ambient_degc": 22.0}}


def test_a_missing_number_is_filled_and_said(columns: Any) -> None:
    holed = dict(columns, displacement_mm=columns["displacement_mm"].copy())
    holed["displacement_mm"][[50, 51]] = np.nan
    said = '"displacement_mm" has no number: taken from its neighbors (2 rows, first 50)'
    assert sma.inspect(holed).recordings[0].adaptations == (said,)
    assert f"train1: {said}" in sma.identify({"surroundings": {"ambient_degc": 22.0}}, train=holed).notes


def test_many_missing_numbers_are_refused(columns: Any, rod: Path) -> None:
    holed = dict(columns, displacement_mm=columns["displacement_mm"].copy())
    holed["displacement_mm"][50:100] = np.nan
    with pytest.raises(sma.InputError) as caught:
        sma.identify(rod, train=holed)
    assert (caught.value.file, caught.value.row, caught.value.column) == ("train1", 50, "displacement_mm"), caught.value


@pytest.mark.parametrize(
    ("changed", "row", "column", "said"),
    [
        ({"current_a": [0.0, np.inf, 1.0]}, 1, "current_a", "train1, row 1: current_a = inf; expected a finite number"),
        ({"current_a": [0.0, 1.0]}, 2, "current_a", "columns of different lengths"),
        ({"current_a": [0.0, "x", 1.0]}, None, "current_a", "expected a finite number in A"),
        ({"current_a": np.array([0.0, "x", 1.0], dtype=object)}, 1, "current_a", "current_a = 'x'; expected numbers"),
        ({"current_a": np.array([0.0, {}, 1.0], dtype=object)}, 1, "current_a", "current_a = {}; expected numbers"),
        ({"current_a": [1j, 2j, 3j]}, None, "current_a", "complex numbers; expected numbers"),
        ({"current_a": np.zeros((3, 2))}, None, "current_a", "shape 3 x 2; expected one dimension"),
        ({"current_a": 1.0}, None, "current_a", "a single value; expected one dimension"),
        ({"current_a": [[1.0], [1.0, 2.0], [1.0]]}, None, "current_a", "ragged; expected one value a row"),
        ({"current_a": np.array([1, 2, 3], dtype="timedelta64[s]")}, None, "current_a", "durations; expected seconds as numbers"),
        ({"current_a": np.zeros(3, dtype=np.longdouble)}, None, "current_a", "expected float64"),
        ({"time_s": [0.0, 2.0, 1.0]}, 2, "time_s", "time_s = 1 after 2 in the row before; expected time to rise"),
        ({"3": [0.0, 2.0, 1.0]}, None, "3", "a number for a name"),
    ],
)
def test_columns_that_make_no_sense_are_refused(
    changed: dict[str, Any], row: int | None, column: str, said: str, rod: Path
) -> None:
    good: dict[str, Any] = {"time_s": [0.0, 1.0, 2.0], "current_a": [0.0, 1.0, 1.0], "displacement_mm": [0.0, 0.5, 1.0]}
    with pytest.raises(sma.InputError) as caught:
        sma.identify(rod, train=good | changed)
    assert said in str(caught.value)
    assert (caught.value.file, caught.value.column) == ("train1", column)
    if row is not None:
        assert caught.value.row == row


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (3, "a builtins.int; expected a path, a frame"),
        (np.zeros(4), "an array of shape (4,); expected a matrix"),
        ({}, "no column; expected at least a drive"),
        (None, "a builtins.NoneType; expected a path"),
        ([[0.0, 1.0]], "a builtins.list; expected a path"),
    ],
)
def test_what_is_no_table_is_refused(given: Any, said: str, rod: Path) -> None:
    with pytest.raises(sma.InputError, match="train1: ") as caught:
        sma.identify(rod, train=[given])
    assert said in str(caught.value)


def test_faults_of_text_files_have_line_and_column(rod: Path, train: Path, tmp_path: Path) -> None:
    lines = train.read_text().splitlines()
    lines[40] = lines[40].split(",")[0] + ",oops,0.5"
    bad = tmp_path / "bad.csv"
    bad.write_text("\n".join(lines))
    with pytest.raises(sma.InputError) as caught:
        sma.identify(rod, train=bad)
    error = caught.value
    assert (error.file, error.line, error.row, error.column) == (str(bad), 41, None, "current_a")
    assert 'current_a = "oops": not a number; expected a finite number in A' in str(error)


def test_faults_of_rods_name_the_key(train: Path, tmp_path: Path) -> None:
    with pytest.raises(sma.InputError, match="rod.toml:2:.*unknown field `diametr_mm`") as caught:
        sma.identify({"rod": {"diametr_mm": 3.0}}, train=train)
    assert (caught.value.file, caught.value.line) == ("rod.toml", 2)
    with pytest.raises(sma.InputError, match="rod.diameter_mm = -1: must be finite and > 0") as caught:
        sma.identify({"rod": {"diameter_mm": -1}}, train=train)
    assert caught.value.column == "rod.diameter_mm"
    for value in [float("nan"), None, {1}]:
        with pytest.raises(sma.InputError, match="rod: rod.length_mm = .*; expected a finite number, text") as caught:
            sma.identify({"rod": {"length_mm": value}}, train=train)
        assert caught.value.column == "rod.length_mm"
    with pytest.raises(sma.InputError, match="expected a table"):
        sma.identify({"diameter_mm": 3.0}, train=train)
    with pytest.raises(sma.InputError, match="absent.toml: cannot be read") as caught:
        sma.identify(tmp_path / "absent.toml", train=train)
    assert caught.value.file == str(tmp_path / "absent.toml")


def test_times_of_day_and_dates_are_seconds(columns: Any, rod: Path) -> None:
    start = datetime.datetime(2024, 5, 2, 23, 59, 58)
    stamps = [start + datetime.timedelta(seconds=float(t)) for t in columns["time_s"]]
    rest = {title: values for title, values in columns.items() if title != "time_s"}
    for frame in (
        pd.DataFrame({"time": stamps} | rest),
        pd.DataFrame(rest, index=pd.DatetimeIndex(stamps, tz="Europe/Berlin")),
        pl.DataFrame({"time": stamps} | rest),
        {"time": stamps} | rest,
    ):
        found = sma.inspect(frame, rod).recordings[0]
        assert found.duration_s == pytest.approx(399.8)
        assert found.dt_s == pytest.approx(0.2)


def test_usage_that_is_none_is_refused(rod: Path, train: Path, columns: Any) -> None:
    with pytest.raises(sma.InputError, match="invalid value '0' for '--starts"):
        sma.identify(rod, train=train, flags=["--starts", "0"])
    with pytest.raises(sma.InputError, match='use: "x" is no recording of this call; expected one of train1, validate.csv'):
        sma.identify(rod, columns, rod.parent / "validate.csv", use=sma.Use(window_s={"x": (0, 1)}))
    with pytest.raises(sma.InputError, match="like and drive belong together"):
        sma.trial(like=rod)
    half = sma.identify(rod, train={"a b": columns}, use=sma.Use(window_s={"a b": (0.0, 200.0)}, decimate=2))
    assert len(half.series[0].output) == 501
    part = sma.identify(rod, train=train, use=sma.Use(exclude_s={"train.csv": (390.0, 400.0)}))
    assert len(part.series[0].output) == 1950


def test_a_package_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, identified: sma.Identified) -> None:
    for suffix, module, extra in [
        (".mat", "scipy.io", "mat"),
        (".h5", "h5py", "mat"),
        (".tdms", "nptdms", "tdms"),
        (".xlsx", "openpyxl", "xlsx"),
        (".parquet", "pyarrow.parquet", "parquet"),
    ]:
        (tmp_path / f"run{suffix}").write_bytes(b"x" * 100)
        monkeypatch.setitem(__import__("sys").modules, module, None)
        with pytest.raises(sma.MissingExtraError, match=rf"pip install 'sma-actuator\[{extra}\]'"):
            sma.read(tmp_path / f"run{suffix}")
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.pyplot", None)
    with pytest.raises(sma.MissingExtraError, match=r"sma-actuator\[plot\]"):
        identified.plot()
