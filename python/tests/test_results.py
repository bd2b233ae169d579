"""Results: numbers with units and intervals, arrays, figures, pages."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from conftest import BUNDLED, Followed

import sma

matplotlib.use("agg")


def test_the_truth_of_the_bundled_recordings_is_within_the_intervals(identified: sma.Identified) -> None:
    # As the README of the project states it.
    truth = {
        "tau_s": (12.38, "s"),
        "loop_center_degc": (66.0, "°C"),
        "loop_half_width_k": (9.0, "K"),
        "zeta": (0.85, "1"),
        "gain": (4.2, "mm"),
    }
    for name, (value, unit) in truth.items():
        found = identified[name]
        assert found.ci95 is not None and found.value is not None
        assert found.ci95[0] <= value <= found.ci95[1], found
        assert found.ci95[0] < found.value < found.ci95[1]
        assert found.unit == unit
    assert identified.usable and identified.converged and not identified.implausible
    assert identified.fit_percent > 99.0
    with pytest.raises(KeyError, match="expected one of tau_s"):
        identified["tau"]
    assert str(identified["tau_s"]).startswith("tau_s = 12.38 s (12.37 to ")


def test_series_are_those_of_the_fit(identified: sma.Identified, columns: Any) -> None:
    train, unseen = identified.series
    assert [train.role, unseen.role] == ["train", "validate"]
    assert train.output.tolist() == columns["displacement_mm"].tolist()
    assert train.drive.tolist() == columns["current_a"].tolist()
    assert train.rmse == pytest.approx(identified.train_rmse, rel=1e-9)
    assert unseen.rmse == pytest.approx(identified.validate_rmse, rel=1e-9)
    assert train.temperature_degc is not None and train.temperature_degc[0] == 22.0
    for one in identified.series:
        fraction = identified.fraction(one)
        assert fraction is not None
        assert 0.0 <= fraction.min() < 0.1 and 0.9 < fraction.max() <= 1.0


def test_a_prediction_is_the_series_of_the_unseen_recording(identified: sma.Identified, tmp_path: Path) -> None:
    unseen = identified.series[1]
    for model in (identified, identified.model):
        found = sma.simulate(model, BUNDLED / "validate.csv")
        assert found["displacement_mm"].tolist() == unseen.simulated.tolist()
    identified.model.save(tmp_path / "model.toml")
    drive = {"time_s": unseen.time_s, "current_a": unseen.drive}
    alone = sma.simulate(tmp_path / "model.toml", drive)
    assert list(alone.columns) == ["time_s", "current_a", "displacement_mm", "temperature_degc"]
    assert np.ptp(alone["displacement_mm"] - unseen.simulated) < 1e-12
    assert (
        sma.simulate(identified, {"time_s": unseen.time_s, "current_a": 2.0 * unseen.drive})
        .notes[0]
        .startswith("the drive reaches")
    )
    assert "validate.csv" in str(sma.simulate(identified, BUNDLED / "validate.csv").notes)
    again = sma.identify(BUNDLED / "rod.toml", BUNDLED / "train.csv", from_model=identified)
    assert again["tau_s"].value == pytest.approx(identified["tau_s"].value, rel=1e-4)


def test_the_readme_prints_what_it_says(followed: Followed) -> None:
    assert followed.printed == followed.promised
    assert followed.n_lines <= 12


def test_the_demonstration_is_diagnosed(diagnosed: sma.Diagnosed, demo: sma.Demo) -> None:
    assert [one.effect for one in diagnosed.findings] == ["latent-heat", "dead-time"]
    heat, delay = (one.parameters[0] for one in diagnosed.findings)
    assert (heat.unit, delay.unit) == ("J/kg", "s")
    for found, truth in ((heat, 15e3), (delay, 0.8)):
        assert found.ci95 is not None and found.ci95[0] < truth < found.ci95[1]
    for one in diagnosed.findings:
        # The text of the demonstration is broken into lines.
        _, what = one.sentence.split(": ", 1)
        assert what in " ".join(demo.text.split())
    assert diagnosed.explained_fraction is not None and diagnosed.explained_fraction > 0.999
    assert diagnosed.extended is not None and diagnosed.extended.effects == ("dead-time", "latent-heat")
    # The offset of an unseen recording is that of its other stretches there, of all of them here.
    for one, rmses, rel in zip(diagnosed.series, ("train_rmse", "validate_rmse"), (1e-9, 0.01), strict=True):
        assert one.rmse == pytest.approx(getattr(diagnosed.extended, rmses), rel=rel)
        assert one.baseline is not None
        plain = np.sqrt(np.mean((one.output - one.baseline) ** 2))
        assert plain == pytest.approx(getattr(diagnosed.baseline, rmses), rel=rel)
    assert {one.effect for one in diagnosed.catalogue} >= {"radiation", "backlash", "latent-heat"}
    # The diagnosis takes offset and surroundings of an unseen recording from all of it, the simulation from its rest.
    again = sma.simulate(diagnosed, demo.unseen)["displacement_mm"] - diagnosed.series[1].simulated
    assert np.sqrt(np.mean(again**2)) < 0.2 * diagnosed.series[1].rmse


def test_a_controller_is_tuned(identified: sma.Identified, tuned: tuple[sma.Tuned, list[str]]) -> None:
    found, lines = tuned
    assert any(line.startswith("tune move ") for line in lines)
    own = {one.name: one for one in found.controllers}
    assert found.gains == own["tuned"].gains
    assert own["yours"].gains == sma.Gains(1.0, 0.5, 0.0)
    assert own["tuned"].cost is not None and own["SIMC"].cost is not None
    assert own["tuned"].cost <= own["SIMC"].cost
    assert own["tuned"].gain_margin is not None and own["tuned"].gain_margin >= 2.0
    step = next(one for one in found.responses if one.controller == "tuned")
    assert (step.output_unit, step.drive_unit) == ("mm", "A")
    assert step.setpoint.max() == 2.5 and step.drive.max() <= 5.5 and len(step.time_s) == len(step.output)
    with pytest.raises(sma.InputError, match="expected three numbers"):
        sma.tune(identified, 2.5, 5.5, gains=(1.0, 0.5))  # type: ignore[arg-type]
    with pytest.raises(sma.InputError, match="limits.drive_max is missing"):
        sma.tune(identified, 2.5)
    assert len(found.plot().axes) == 2


def test_a_trial_is_counted(tmp_path: Path) -> None:
    # The cases of the published trial, whose answers are opened, are counted again.
    shutil.copytree(BUNDLED.parents[1] / "blind-trial" / "results", tmp_path / "trial")
    found = sma.trial(0, out=tmp_path / "trial", seed="78df37d2691ed14051715e501e38ee6bccfd9fc6")
    assert found.n_cases == 2111
    named = next(one for one in found.scores if one.quantity == "top-1")
    assert (named.hits, named.n, named.met) == (222, 230, True)
    assert named.ci95 is not None and named.ci95[0] < 222 / 230 < named.ci95[1]
    assert "<svg" in found.report


def test_results_show_themselves(identified: sma.Identified, diagnosed: sma.Diagnosed, tmp_path: Path) -> None:
    for result in (identified, diagnosed):
        shown = result._repr_html_()
        assert shown.startswith("<iframe srcdoc=") and "&lt;svg" in shown
        assert len(result.plot().axes) == 2 * len(result.series)
        result.save_report(tmp_path / "report.html")
        assert (tmp_path / "report.html").read_text(encoding="utf-8") == result.report
        # Nothing tells of the folder in which the program ran.
        for text in (result.report, result.text, str(result.raw), result.model.toml if result.model else "", *result.notes):
            assert not re.search(r"/sma-\w{8}/(in|out)", text)
    assert "tau_s" in identified.text and "tau_s" in repr(identified)
    assert "train.csv" in sma.inspect(BUNDLED / "train.csv")._repr_html_()
    assert "RMS" in sma.simulate(identified, BUNDLED / "validate.csv")._repr_html_()


def test_equal_calls_give_equal_results(identified: sma.Identified) -> None:
    again = sma.identify(BUNDLED / "rod.toml", train=BUNDLED / "train.csv", validate=BUNDLED / "validate.csv", threads=1)
    assert again.raw == identified.raw
    assert again.model.toml.replace("--threads 1", "--threads 0") == identified.model.toml


def test_what_did_not_converge_is_a_result() -> None:
    n = 400
    current = np.where((np.arange(n) // 100) % 2, 1.0, 0.0)
    noise = np.random.default_rng(1).normal(size=n)
    found = sma.identify(
        {"surroundings": {"ambient_degc": 20.0}}, {"time_s": 0.1 * np.arange(n), "current_a": current, "displacement_mm": noise}
    )
    assert not found.usable
    assert "NOT TO BE USED" in repr(found)


CALL = """
import sys, sma
show = lambda line: print(line, flush=True)
sma.identify(sys.argv[1], train=sys.argv[2], flags=["--starts", "1000000"], progress=show)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_an_interrupt_ends_the_program_and_leaves_nothing(tmp_path: Path) -> None:
    call = [sys.executable, "-c", CALL, str(BUNDLED / "rod.toml"), str(BUNDLED / "train.csv")]
    with subprocess.Popen(call, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
        try:
            assert child.stdout is not None
            assert child.stdout.readline() == "identify start 0/1000000\n"
            running = subprocess.run(["pgrep", "-P", str(child.pid)], capture_output=True, text=True, check=True).stdout.split()
            assert len(running) == 1
            # To Python alone, as a notebook sends it.
            child.send_signal(signal.SIGINT)
            _, said = child.communicate()
            assert said.rstrip().endswith("KeyboardInterrupt"), said
            # Python has waited for it.
            assert subprocess.run(["ps", "-p", running[0]], capture_output=True, check=False).returncode == 1
        finally:
            child.kill()
    assert not list(tmp_path.iterdir())


def test_the_module_is_the_program() -> None:
    ran = subprocess.run([sys.executable, "-m", "sma", "--version"], capture_output=True, text=True, check=True)
    assert ran.stdout.startswith("sma ")


def test_a_program_that_is_not_there_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("SMA_PROGRAM", str(tmp_path / "absent"))
    with pytest.raises(sma.ProgramError, match="no such file; expected the program sma"):
        sma.inspect(BUNDLED / "train.csv")
    failing = tmp_path / "failing"
    failing.write_text("#!/bin/sh\necho 'sma: no space left' >&2\nexit 1\n")
    failing.chmod(0o755)
    monkeypatch.setenv("SMA_PROGRAM", str(failing))
    with pytest.raises(sma.ProgramError, match="no space left") as caught:
        sma.inspect(BUNDLED / "train.csv")
    assert caught.value.code == 1
    older = tmp_path / "older"
    older.write_text("#!/bin/sh\necho '{\"schema_version\": 0}'\n")
    older.chmod(0o755)
    monkeypatch.setenv("SMA_PROGRAM", str(older))
    with pytest.raises(sma.ProgramError, match="schema_version 0; expected 1"):
        sma.inspect(BUNDLED / "train.csv")
