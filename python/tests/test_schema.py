"""The program's JSON has the form on which this package and others rely; tests/schema says it, a file a command."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from conftest import BUNDLED

import sma

SCHEMAS = Path(__file__).parent / "schema"


def check(command: str, document: Any) -> None:
    schema = json.loads((SCHEMAS / f"{command}.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(document, schema)
    # A schema that lets anything pass would hold nothing.
    for key in schema["required"]:
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({other: value for other, value in document.items() if other != key}, schema)


def test_identify(identified: sma.Identified) -> None:
    check("identify", identified.raw)


def test_diagnose(diagnosed: sma.Diagnosed) -> None:
    check("diagnose", diagnosed.raw)


def test_tune(tuned: tuple[sma.Tuned, list[str]]) -> None:
    check("tune", tuned[0].raw)


def test_inspect() -> None:
    check("inspect", sma.inspect([BUNDLED / "train.csv", BUNDLED / "validate.csv"]).raw)


def test_batch() -> None:
    rigs = [
        sma.Rig("whole", BUNDLED / "rod.toml", BUNDLED / "train.csv"),
        sma.Rig("none", BUNDLED / "rod.toml", BUNDLED / "rod.toml"),
    ]
    check("batch", sma.batch(rigs, do="identify").raw)
