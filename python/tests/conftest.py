"""Recordings and results that several tests share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import sma

BUNDLED = Path(__file__).parents[2] / "sma-cli" / "bundled"

Columns = dict[str, "np.ndarray[tuple[int], np.dtype[np.float64]]"]


@pytest.fixture(scope="session")
def rod() -> Path:
    """Rod file of the bundled recordings."""
    return BUNDLED / "rod.toml"


@pytest.fixture(scope="session")
def train() -> Path:
    """Bundled recording, CSV."""
    return BUNDLED / "train.csv"


@pytest.fixture(scope="session")
def columns(train: Path) -> Columns:
    """Columns of the bundled recording."""
    lines = [line for line in train.read_text().splitlines() if not line.startswith("#")]
    values = np.array([[float(field) for field in line.split(",")] for line in lines[1:]])
    return {title: values[:, k].copy() for k, title in enumerate(lines[0].split(","))}


@pytest.fixture(scope="session")
def identified(rod: Path, train: Path) -> sma.Identified:
    """Model of the bundled recordings."""
    return sma.identify(rod, train=train, validate=BUNDLED / "validate.csv")


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> sma.Demo:
    """Files of the demonstration."""
    return sma.demo(tmp_path_factory.mktemp("demo"))


@pytest.fixture(scope="session")
def diagnosed(demo: sma.Demo) -> sma.Diagnosed:
    """Diagnosis of the demonstration."""
    return sma.diagnose(demo.rod, train=demo.train, validate=demo.unseen)
