"""The app of the documentation, as a person uses it who drops files and moves the drive."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import sma

pytest.importorskip("marimo")

APP = Path(__file__).parents[2] / "docs" / "app.py"


def file(path: Path) -> SimpleNamespace:
    """A file that was dropped."""
    return SimpleNamespace(name=path.name, contents=path.read_bytes())


def test_dropped_files_are_diagnosed_and_the_model_predicts(demo: sma.Demo) -> None:
    spec = importlib.util.spec_from_file_location("app", APP)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    dropped = {
        "training": SimpleNamespace(value=[file(demo.train)]),
        "unseen": SimpleNamespace(value=[file(demo.unseen)]),
        # Nobody but the person at the bench knows the rod.
        "rod_text": SimpleNamespace(value=demo.rod.read_text(encoding="utf-8")),
        "effort": SimpleNamespace(value="quick"),
        "begin": SimpleNamespace(value=True),
    }
    _, shown = module.app.run(defs=dropped)
    assert [finding.effect for finding in shown["found"].findings] == ["latent-heat", "dead-time"]
    assert 'drive = { name = "current_a" }' in shown["first_rod"]
    moved = shown["predicted"]["displacement_mm"]
    assert np.ptp(moved) > 0.1
