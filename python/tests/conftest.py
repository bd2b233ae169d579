"""Recordings and results that several tests share."""

from __future__ import annotations

import contextlib
import dataclasses
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

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


@dataclass(frozen=True)
class Followed:
    """What the first block of the README leaves and prints, and what the README says that it prints."""

    demo: sma.Demo
    found: sma.Diagnosed
    printed: str
    promised: str
    n_lines: int


@pytest.fixture(scope="session")
def followed(tmp_path_factory: pytest.TempPathFactory) -> Followed:
    """The first block of the package's README, run in an empty folder."""
    readme = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    code, promised = (readme.split(f"```{kind}\n")[1].split("```")[0] for kind in ("python", "text"))
    names: dict[str, Any] = {}
    with contextlib.chdir(tmp_path_factory.mktemp("readme")), contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(code, names)
        demo = names["demo"]
        demo = dataclasses.replace(demo, **{name: getattr(demo, name).resolve() for name in ("rod", "train", "unseen")})
    return Followed(demo, names["found"], printed.getvalue(), promised, len(code.splitlines()))


@pytest.fixture(scope="session")
def demo(followed: Followed) -> sma.Demo:
    """Files of the demonstration."""
    return followed.demo


@pytest.fixture(scope="session")
def diagnosed(followed: Followed) -> sma.Diagnosed:
    """Diagnosis of the demonstration."""
    return followed.found


#: Flags that make a short run.
QUICK = ("--draws", "10", "--duration-s", "60")


@pytest.fixture(scope="session")
def tuned(identified: sma.Identified) -> tuple[sma.Tuned, list[str]]:
    """A controller for the bundled rig, beside gains of somebody's own, and its lines of progress."""
    lines: list[str] = []
    return sma.tune(identified, 2.5, 5.5, gains=(1.0, 0.5, 0.0), flags=QUICK, progress=lines.append), lines
