"""Twelve files of eight formats hold the same recording; what is no whole recording is refused."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import nptdms
import numpy as np
import openpyxl
import pyarrow
import pyarrow.feather
import pyarrow.parquet
import pytest
import scipy.io

import sma
from sma.files import mat5 as reader

#: Rows of the recording.
N = 600


@pytest.fixture(scope="module")
def recording(columns: Any) -> dict[str, Any]:
    """A recording whose times, multiples of 1/4 s, every format can hold."""
    return {
        "time_s": 0.25 * np.arange(N),
        "current_a": columns["current_a"][:N],
        "displacement_mm": columns["displacement_mm"][:N],
    }


def mat4(path: Path, recording: dict[str, Any]) -> None:
    scipy.io.savemat(path, recording, format="4")


def mat5(path: Path, recording: dict[str, Any]) -> None:
    scipy.io.savemat(path, recording | {"fs_hz": 4.0, "operator": "A. N. Other"}, oned_as="column")


def mat5_struct(path: Path, recording: dict[str, Any]) -> None:
    scipy.io.savemat(path, {"run3": recording}, do_compression=True)


def mat5_matrix(path: Path, recording: dict[str, Any]) -> None:
    scipy.io.savemat(path, {"data": np.column_stack(list(recording.values()))})


def mat73(path: Path, recording: dict[str, Any], group: str = "/") -> None:
    # As MATLAB does: 512 bytes of its own, rows and columns in the other order, classes as attributes.
    with h5py.File(path, "w", userblock_size=512) as file:
        for title, values in recording.items():
            item = file.require_group(group).create_dataset(title, data=values[np.newaxis, :])
            item.attrs["MATLAB_class"] = np.bytes_("double")
        text = file.create_dataset("operator", data=np.array([[65], [78]], dtype=np.uint16))
        text.attrs["MATLAB_class"] = np.bytes_("char")


def mat73_struct(path: Path, recording: dict[str, Any]) -> None:
    mat73(path, recording, "run3")


def tdms(path: Path, recording: dict[str, Any]) -> None:
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([nptdms.ChannelObject("run", title, values) for title, values in recording.items()])


def tdms_waveform(path: Path, recording: dict[str, Any]) -> None:
    step = {"wf_increment": 0.25, "wf_start_offset": 0.0}
    current = nptdms.ChannelObject("run", "current", recording["current_a"], step | {"unit_string": "A"})
    displacement = nptdms.ChannelObject("run", "displacement_mm", recording["displacement_mm"], step | {"unit_string": "mm"})
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([current, displacement])


def xlsx(path: Path, recording: dict[str, Any]) -> None:
    workbook = openpyxl.Workbook()
    sheet = workbook.active
    assert sheet is not None
    sheet.append(list(recording))
    for row in zip(*(values.tolist() for values in recording.values()), strict=True):
        sheet.append(row)
    workbook.create_sheet("empty")
    workbook.save(path)


def parquet(path: Path, recording: dict[str, Any]) -> None:
    pyarrow.parquet.write_table(pyarrow.table(recording), path)


def feather(path: Path, recording: dict[str, Any]) -> None:
    pyarrow.feather.write_feather(pyarrow.table(recording), path)


def npz(path: Path, recording: dict[str, Any]) -> None:
    np.savez(path, **recording)


FILES: dict[str, Callable[[Path, dict[str, Any]], None]] = {
    "v4.mat": mat4,
    "v5.mat": mat5,
    "v5-struct.mat": mat5_struct,
    "v5-matrix.mat": mat5_matrix,
    "v73.mat": mat73,
    "v73-struct.mat": mat73_struct,
    "channels.tdms": tdms,
    "waveform.tdms": tdms_waveform,
    "book.xlsx": xlsx,
    "frame.parquet": parquet,
    "frame.feather": feather,
    "arrays.npz": npz,
}


def bits(values: Any) -> list[int]:
    """Bits of numbers, integers as the floats that they are."""
    found: list[int] = np.asarray(values).astype(np.float64).view(np.uint64).tolist()
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, recording: dict[str, Any]) -> Path:
    place = tmp_path_factory.mktemp("files")
    for name, write in FILES.items():
        write(place / name, recording)
    return place


@pytest.mark.parametrize("name", FILES)
def test_every_file_is_read_to_the_same_bits(name: str, folder: Path, recording: dict[str, Any]) -> None:
    table = sma.read(folder / name)
    expected = list(recording)
    if name == "v5-matrix.mat":
        expected = ["1", "2", "3"]
    elif name == "waveform.tdms":
        expected[1] = "current [A]"
    # Variables of a file have no order of their own.
    assert sorted(table.columns) == sorted(expected)
    for title, values in zip(expected, recording.values(), strict=True):
        assert bits(table.columns[title]) == bits(values), title


def test_the_program_sees_one_recording_in_all_of_them(folder: Path, recording: dict[str, Any]) -> None:
    text = folder / "run.csv"
    with text.open("w") as out:
        sma.Table("run.csv", recording).write_csv(out)
    by_number = {"time": {"number": 1, "unit": "s"}, "drive": {"number": 2, "unit": "A"}, "output": {"number": 3, "unit": "mm"}}
    named = [name for name in FILES if name != "v5-matrix.mat"]
    found = [
        *sma.inspect([text, *(folder / name for name in named)]).raw["recordings"],
        *sma.inspect(folder / "v5-matrix.mat", {"columns": by_number}).raw["recordings"],
    ]
    assert [one.pop("name") for one in found] == [str(text), *named, "v5-matrix.mat"]
    assert len(found) == 13
    for one in found:
        assert one == found[0]


@pytest.mark.parametrize("share", [0.1, 1 / 3, 1 / 2, 2 / 3, 0.9, 0.99])
@pytest.mark.parametrize("name", FILES)
def test_a_file_that_is_cut_off_is_refused(name: str, share: float, folder: Path, tmp_path: Path) -> None:
    whole = (folder / name).read_bytes()
    cut = tmp_path / name
    cut.write_bytes(whole[: int(len(whole) * share)])
    with pytest.raises(sma.InputError) as caught:
        sma.identify({}, train=cut)
    assert str(cut) in str(caught.value)
    assert "expected" in str(caught.value)
    assert caught.value.file == str(cut)


def refused(path: Path, *parts: str, table: str | None = None) -> sma.InputError:
    """Reading fails, and the text has the file and these parts."""
    with pytest.raises(sma.InputError) as caught:
        sma.read(path, table=table)
    for part in (path.name, "expected", *parts):
        assert part in str(caught.value), caught.value
    return caught.value


def book(path: Path, *rows: list[object]) -> Path:
    workbook = openpyxl.Workbook()
    sheet = workbook.active
    assert sheet is not None
    for row in rows:
        sheet.append(row)
    workbook.save(path)
    return path


def test_matrices_of_the_wrong_rank_are_refused(tmp_path: Path) -> None:
    cube = tmp_path / "cube.mat"
    scipy.io.savemat(cube, {"data": np.zeros((4, 3, 2))})
    refused(cube, 'variable "data"', "4 x 3 x 2", "one matrix with a row a sample")
    cube = tmp_path / "cube.h5"
    with h5py.File(cube, "w") as file:
        file["data"] = np.zeros((4, 3, 2))
    refused(cube, 'variable "data"', "4 x 3 x 2")
    cube = tmp_path / "cube.npy"
    np.save(cube, np.zeros((4, 3, 2)))
    refused(cube, "(4, 3, 2)")
    both = tmp_path / "both.npz"
    np.savez(both, time_s=np.arange(4.0), data=np.zeros((4, 2)))
    refused(both, 'variable "data" is 4 x 2', "vectors of one length")
    nested = tmp_path / "nested.parquet"
    pyarrow.parquet.write_table(pyarrow.table({"time_s": [0.0, 1.0], "current_a": [[1.0], [2.0]]}), nested)
    refused(nested, 'column "current_a"', "list")


def test_ragged_tables_are_refused(tmp_path: Path) -> None:
    ragged = {"time_s": np.arange(5.0), "current_a": np.ones(5), "displacement_mm": np.ones(4)}
    for name, write in [("a.mat", mat4), ("b.mat", mat5), ("c.mat", mat73), ("d.tdms", tdms), ("e.npz", npz)]:
        write(tmp_path / name, ragged)
        error = refused(tmp_path / name, "different lengths", "displacement_mm 4")
        assert (error.column, error.row) == ("displacement_mm", 4)
    sheet = book(tmp_path / "ragged.xlsx", ["time_s", "current_a"], [0.0, 1.0], [1.0, 1.0, 7.0])
    assert refused(sheet, 'sheet "Sheet"', "row 3", "3 cells").row == 3


def test_mixed_types_are_refused_with_row_and_value(tmp_path: Path) -> None:
    sheet = book(tmp_path / "mixed.xlsx", ["time_s", "current_a"], [0, 1.0], [1, 2.0], [2, "open"], [3, 1.0])
    error = refused(sheet, 'sheet "Sheet"', "row 4", "current_a = 'open'", "numbers")
    assert (error.row, error.column) == (4, "current_a")
    units = book(tmp_path / "units.xlsx", ["time", "current"], ["s", "A"], [0.0, 1.0], [1.0, 1.0])
    assert refused(units, "row 2", "time = 's'").row == 2
    mixed = tmp_path / "objects.mat"
    scipy.io.savemat(mixed, {"current_a": np.array([1.0, "open", 2.0], dtype=object)})
    refused(mixed, 'variable "current_a"', "cell array")


def test_arrays_of_objects_are_refused(tmp_path: Path) -> None:
    objects = np.array([1.0, None, {}], dtype=object)
    np.savez(tmp_path / "objects.npz", current_a=objects)
    refused(tmp_path / "objects.npz", 'variable "current_a"', "array of objects")
    np.save(tmp_path / "objects.npy", objects)
    refused(tmp_path / "objects.npy", "array of objects")
    with h5py.File(tmp_path / "objects.h5", "w") as file:
        file.create_dataset("label", data=["a", "b"], dtype=h5py.string_dtype())
    refused(tmp_path / "objects.h5", 'variable "label"', "objects or of text")
    for kind, said in [("cell", "a cell array"), ("table", "an object, such as a table")]:
        with h5py.File(tmp_path / f"{kind}.mat", "w", userblock_size=512) as file:
            item = file.create_dataset("run", data=np.zeros((1, 6), dtype=np.uint32))
            item.attrs["MATLAB_class"] = np.bytes_(kind)
            if kind == "table":
                item.attrs["MATLAB_object_decode"] = 3
        refused(tmp_path / f"{kind}.mat", 'variable "run"', said)
    scipy.io.savemat(tmp_path / "complex.mat", {"current_a": np.ones(4) * 1j})
    refused(tmp_path / "complex.mat", 'variable "current_a"', "complex")
    scipy.io.savemat(tmp_path / "sparse.mat", {"current_a": scipy.sparse.eye(4)})
    refused(tmp_path / "sparse.mat", 'variable "current_a"', "sparse")


def test_encrypted_and_foreign_files_are_refused(tmp_path: Path) -> None:
    for name, start, parts in [
        ("locked.xlsx", bytes.fromhex("d0cf11e0a1b11ae1"), ["password"]),
        ("locked.parquet", b"PARE", ["encrypted"]),
        ("text.xlsx", b"time_s,current_a\n", ["no workbook"]),
        ("text.mat", b"time_s,current_a\n0,1\n", []),
        ("text.tdms", b"time_s,current_a\n", ["TDMS"]),
        ("text.parquet", b"time_s,current_a\n", []),
        ("text.feather", b"time_s,current_a\n", []),
        ("text.npz", b"time_s,current_a\n", ["no archive"]),
        ("text.h5", b"time_s,current_a\n", []),
        ("none.mat", b"", ["empty"]),
    ]:
        (tmp_path / name).write_bytes(start + (bytes(1000) if start else b""))
        refused(tmp_path / name, *parts)
    refused(tmp_path / "absent.mat.csv", "read() knows")
    with pytest.raises(sma.InputError, match="absent.mat: cannot be read"):
        sma.read(tmp_path / "absent.mat")


def test_every_class_of_matlab_is_read_as_scipy_does(tmp_path: Path) -> None:
    values = np.arange(-3, 9).reshape(4, 3)
    kinds = ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8", "?"]
    given: dict[str, Any] = {f"kind_{kind.strip('?') or 'b'}": values.astype(kind) for kind in kinds}
    given |= {"scalar": 2.5, "text": "abc", "vector": np.linspace(0, 1, 7), "none": np.zeros((0, 0)), "cube": np.ones((2, 3, 4))}
    given["nested"] = {"a_rather_long_name_of_a_field": values, "inner": {"x": np.pi}}
    for compressed in (False, True):
        path = tmp_path / f"{compressed}.mat"
        scipy.io.savemat(path, given, do_compression=compressed, long_field_names=True)
        ours, theirs = reader.variables(path), scipy.io.loadmat(path)
        assert sorted(ours) == sorted(given)
        for title, value in ours.items():
            if title == "nested":
                record = theirs[title][0, 0]
                assert isinstance(value, dict)
                np.testing.assert_array_equal(value["a_rather_long_name_of_a_field"], record["a_rather_long_name_of_a_field"])
                assert value["inner"]["x"] == record["inner"][0, 0]["x"] == np.pi
            elif title != "text":
                assert isinstance(value, np.ndarray)
                assert (value.dtype, value.shape) == (theirs[title].dtype, theirs[title].shape), title
                np.testing.assert_array_equal(value, theirs[title])


@pytest.mark.parametrize("name", ["v4.mat", "v5.mat", "v5-struct.mat", "channels.tdms", "book.xlsx", "arrays.npz"])
def test_damaged_bytes_end_in_a_table_or_an_error(name: str, folder: Path, tmp_path: Path) -> None:
    whole = (folder / name).read_bytes()
    draw = random.Random(name)
    path = tmp_path / name
    refused = 0
    for _ in range(25):
        damaged = bytearray(whole)
        # Where the structure stands, and anywhere.
        for k in [draw.randrange(min(len(whole), 200)), draw.randrange(len(whole))]:
            damaged[k] = draw.randrange(256)
        path.write_bytes(damaged)
        try:
            sma.read(path)
        except sma.InputError as error:
            assert str(path) in str(error) or path.name in str(error)
            refused += 1
    assert refused > 0 or name == "v4.mat"


def test_one_of_several_tables_is_selected(tmp_path: Path, recording: dict[str, Any]) -> None:
    short = {title: values[:10] for title, values in recording.items()}
    scipy.io.savemat(tmp_path / "two.mat", {"a": short, "b": recording})
    refused(tmp_path / "two.mat", "several could be the recording", "a, b")
    refused(tmp_path / "two.mat", 'no variable "c"', "a, b", table="c")
    assert len(sma.read(tmp_path / "two.mat", table="a")) == 10
    workbook = openpyxl.Workbook()
    for title in ["first", "second"]:
        sheet = workbook.create_sheet(title)
        sheet.append(["time_s", title])
        sheet.append([0.0, 1.0])
    workbook.save(tmp_path / "two.xlsx")
    refused(tmp_path / "two.xlsx", "first, second")
    refused(tmp_path / "two.xlsx", 'no sheet "third"', table="third")
    assert list(sma.read(tmp_path / "two.xlsx", table="second").columns) == ["time_s", "second"]
    assert list(sma.read(tmp_path / "two.mat", table="a", columns=["current_a"]).columns) == ["current_a"]
    with pytest.raises(sma.InputError, match='no column "x"; expected some of'):
        sma.read(tmp_path / "two.mat", table="a", columns=["x"])


def test_a_fault_in_a_sheet_is_named_by_its_row(tmp_path: Path) -> None:
    rows: list[list[object]] = [[0.1 * k, 1.0 + (k > 40), 0.01 * k] for k in range(100)]
    rows[70][0] = 3.0
    sheet = book(tmp_path / "late.xlsx", ["time_s", "current_a", "displacement_mm"], *rows)
    with pytest.raises(sma.InputError) as caught:
        sma.identify({}, train=sheet)
    assert (caught.value.file, caught.value.row, caught.value.column) == ("late.xlsx", 72, "time_s")
    assert 'late.xlsx, sheet "Sheet", row 72: time_s = 3' in str(caught.value)
