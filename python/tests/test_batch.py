"""Fleets: rows, failures, rigs that are given by their parts, and the workers of a Dask cluster."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import BUNDLED, Columns

import sma
from sma import units
from sma.dask import main


def make_fleet(folder: Path, columns: Columns, n_rigs: int, every: int) -> Path:
    """Rigs of one rod, with a recording each of every so manieth sample; the last one has no numbers."""
    folder.mkdir()
    (folder / "rod.toml").write_bytes((BUNDLED / "rod.toml").read_bytes())
    values = np.stack(list(columns.values()), axis=1)[::every]
    for k in range(n_rigs):
        rows = values + [0.0, 0.0, 0.01 * k]
        np.savetxt(folder / f"wire-{k}.csv", rows, "%.6f", ",", header=",".join(columns), comments="")
    (folder / f"wire-{n_rigs - 1}.csv").write_text(",".join(columns) + "\n0,-,0\n1,-,0\n", encoding="utf-8")
    return folder


def tree(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_a_fleet_has_a_row_a_rig(tmp_path: Path, columns: Columns) -> None:
    fleet = make_fleet(tmp_path / "fleet", columns, 3, 10)
    (fleet / "wire-unread.csv").symlink_to("/proc/self/mem")
    found = sma.batch(fleet, tmp_path / "night", do="identify")
    assert repr(found) == "<sma.Batched: 4 rigs, 2 done, 1 failed, 1 open>"
    assert [row.status for row in found] == ["done", "done", "failed", "open"]
    first = found["wire-0.csv"]
    assert first.verdict == "identified" and first.usable and first.output_unit == "mm" and not first.findings
    assert first["tau_s"].unit == "s" and first["tau_s"].value == pytest.approx(12.38, rel=0.3)
    assert first["tau_s"].ci95 is not None and first["tau_s"].ci95[0] < first["tau_s"].value < first["tau_s"].ci95[1]
    failed = found["wire-2.csv"]
    assert failed.failure is not None and (failed.failure.file, failed.failure.line) == ("wire-2.csv", 2)
    with pytest.raises(KeyError, match="expected one of none, since it has no result"):
        failed["tau_s"]
    with pytest.raises(KeyError, match="expected one of wire-0.csv, "):
        found["wire"]
    assert "1 of 4 rigs have no result yet; the same call goes on" in found.notes[-1]
    assert found.columns["rig"] == [row.rig for row in found.rows]
    assert found.columns["tau_s"] == [first["tau_s"].value, found["wire-1.csv"]["tau_s"].value, None, None]
    assert found.report.startswith("<!DOCTYPE html>")
    # What has a file is not run again.
    (fleet / "wire-unread.csv").unlink()
    kept = tree(tmp_path / "night")
    again = sma.batch(fleet, tmp_path / "night", do="identify")
    assert again["wire-1.csv"] == found["wire-1.csv"] and "2 with a result, 1 failed" in again.text
    assert tree(tmp_path / "night") == kept
    with pytest.raises(sma.InputError, match="none: cannot be read"):
        sma.batch(tmp_path / "none")


def test_rigs_may_be_given_by_their_parts(columns: Columns, rod: Path) -> None:
    frame = {name: values[::10] for name, values in columns.items()}
    known = {"rod": {"diameter_mm": 1.2, "length_mm": 110.0}, "surroundings": {"ambient_degc": 22.0}}
    rigs = [sma.Rig("a", rod, frame), sma.Rig("b, new", known, {"first": frame, "second": frame}, BUNDLED / "validate.csv")]
    found = sma.batch(rigs, do="identify")
    assert [row.rig for row in found] == ["a", "b, new"]
    assert [row.status for row in found] == ["done", "done"], found.text
    assert found["a"].validate_rmse is None and found["b, new"].validate_rmse is not None
    ragged = sma.batch([sma.Rig("c", rod, BUNDLED / "rod.toml")], do="identify")
    assert ragged["c"].failure is not None and ragged["c"].failure.file == "rod.toml"


def test_a_unit_travels_with_its_files(tmp_path: Path, columns: Columns) -> None:
    fleet = make_fleet(tmp_path / "fleet", columns, 2, 20)
    (fleet / "may").mkdir()
    (fleet / "wire-0.csv").rename(fleet / "may" / "1.csv")
    manifest = fleet / "fleet.csv"
    manifest.write_text("name,rod,train,validate\na,rod.toml,may/1.csv,may/../wire-1.csv\n", encoding="utf-8")
    sma.batch(manifest, tmp_path / "whole", do="identify")
    (path,) = (tmp_path / "whole" / "units").iterdir()
    recordings = [str(fleet / "may" / "1.csv")], [str(fleet / "wire-1.csv")]
    flags = ["--do", "identify"]
    task = units.task(path.stem, flags, str(fleet / "rod.toml"), *recordings)
    ran = units.run_unit(task, folder=str(tmp_path))
    assert ran.packed is not None and units.zlib.decompress(ran.packed) == path.read_bytes()
    assert sorted(one.name for one in tmp_path.iterdir()) == ["fleet", "whole"]
    # Another build, which says nothing of this unit.
    with pytest.raises(sma.ProgramError, match="expected the same wheel on all machines"):
        units.run_unit(units.task("0a" * 32, flags, str(fleet / "rod.toml"), *recordings), folder=str(tmp_path))


def test_without_dask_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(sma.MissingExtraError, match=r"pip install 'sma-actuator\[dask\]'"):
        sma.batch(tmp_path, tmp_path / "out", scheduler="tcp://127.0.0.1:1")


def test_a_killed_worker_costs_its_unit_alone(
    tmp_path: Path, columns: Columns, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed")
    make_fleet(tmp_path / "fleet", columns, 7, 4)

    def places(out: str) -> list[str]:
        return ["--csv", f"{out}/table.csv", "--json", f"{out}/table.json", "--report", f"{out}/table.html"]

    monkeypatch.chdir(tmp_path)
    whole = sma.batch("fleet", "whole", do="identify", flags=["--memory", "nested"])
    assert len(whole) == len(tree(tmp_path / "whole")) == 7
    command = [str(sma.program_path()), "batch", "fleet", "--do", "identify", "--memory", "nested", "--quiet", "--out"]
    assert subprocess.run([*command, "whole", *places("whole")], check=False).returncode == 0
    with distributed.LocalCluster(n_workers=0, dashboard_address=None, scheduler_port=0) as cluster:
        worker = [sys.executable, "-m", "distributed.cli.dask_worker", cluster.scheduler_address, "--no-nanny", "--nthreads", "1"]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        workers = [
            subprocess.Popen([*worker, "--no-dashboard", "--local-directory", str(tmp_path / f"w{k}")], **quiet) for k in range(2)
        ]
        arguments = [
            "--scheduler",
            cluster.scheduler_address,
            "fleet",
            "--out",
            "night",
            "--do",
            "identify",
            "--memory",
            "nested",
        ]
        code = [-1]
        try:
            cluster.wait_for_workers(2)
            # In the middle of a unit: its folder is there.
            killing = subprocess.Popen(
                [sys.executable, "-c", KILL, str(tmp_path / "w0"), str(workers[0].pid), str(tmp_path / "night")],
                stdout=subprocess.PIPE,
            )
            code = [main([*arguments, "--quiet", *places("night")])]
            n_kept, _ = killing.communicate()
            code.append(killing.returncode)
            assert int(n_kept) < 7, "the others were still to be run"
            assert workers[0].wait() == -signal.SIGKILL and workers[1].poll() is None
            # A second call finds all done, and runs none.
            assert main([*arguments, "--quiet"]) == 0
        finally:
            for one in workers:
                one.kill()
                one.wait()
    assert code == [0, 0], capfd.readouterr()
    assert tree(tmp_path / "night") == tree(tmp_path / "whole")
    document = json.loads((tmp_path / "night" / "table.json").read_text(encoding="utf-8"))
    assert document["counts"] == {"done": 6, "to_be_used": 6, "failed": 1, "open": 0}
    assert main(["--scheduler", "nonsense:", "none", "--out", "night"]) == 3
    assert "sma: none: cannot be read" in capfd.readouterr().err


#: Waits until a worker has the folder of a unit, and kills it.
KILL = """
import glob, os, signal, sys, time
begun = time.monotonic()
while not glob.glob(sys.argv[1] + "/**/sma-unit-*", recursive=True):
    assert time.monotonic() - begun < 60
    time.sleep(0.002)
os.kill(int(sys.argv[2]), signal.SIGKILL)
print(len(glob.glob(sys.argv[3] + "/units/*.json")))
"""
