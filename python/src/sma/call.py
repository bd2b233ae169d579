"""One call of the program: what was given as files, and what came back in the caller's terms."""

from __future__ import annotations

import json
import os
import re
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, runtime_checkable

from . import files
from .errors import InputError, NoControllerError, ProgramError
from .program import Ended, Progress, run
from .rod import to_toml
from .table import Table, as_table

#: A path that the program reads, or the tables of a rod file as nested dicts.
RodLike = str | os.PathLike[str] | Mapping[str, Any]

#: A path, a :class:`sma.Table`, a frame of pandas or polars, a dict of arrays, a matrix or a structured array.
RecordingLike = Any

#: One recording, several, or several by name.
Recordings = RecordingLike | Sequence[RecordingLike] | Mapping[str, RecordingLike]

#: Version of the program's JSON that this package reads.
SCHEMA_VERSION = 1

#: Exit codes of the program, as its README says them.
DONE, USAGE, BAD_INPUT, NOT_TO_BE_USED = 0, 2, 3, 4


@dataclass(frozen=True)
class Use:
    """Part of the recordings that counts. A rod file may say the same for each recording (``recordings``)."""

    #: From when to when each recording is used, s, by its name.
    window_s: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    #: A span of each recording that is left out, s, by its name. One in the middle leaves two recordings, ``name:from..to``.
    exclude_s: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    #: Every how manieth row is used, with the mean of those around it.
    decimate: int | None = None
    #: True takes the straight line that the output follows from rest to rest off.
    detrend: bool = False


@runtime_checkable
class HasModel(Protocol):
    """A result that keeps a model."""

    @property
    def model(self) -> Model | None: ...


class Model:
    """An identified model: the text of a ``model.toml``, which ``sma simulate`` and ``sma tune`` of the shell read as well."""

    def __init__(self, toml: str) -> None:
        self._toml = toml

    @property
    def toml(self) -> str:
        """The file's text."""
        return self._toml

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model to a file."""
        Path(path).write_text(self._toml, encoding="utf-8")

    def __repr__(self) -> str:
        return f"<sma.Model of {len(self._toml)} characters; .save(path) keeps it>"


#: A path to a ``model.toml``, a :class:`Model`, or a result that has one.
ModelLike = str | os.PathLike[str] | Model | HasModel


class Call:
    """A folder that lasts as long as one call, and the names of what is in it."""

    def __init__(self) -> None:
        self._holder = tempfile.TemporaryDirectory(prefix="sma-")
        self.folder = Path(self._holder.name).resolve()
        self._scratch = self.folder / "out"
        self._given = self.folder / "in"
        self._scratch.mkdir()
        self._given.mkdir()
        #: Tables by the name of the file that they were written to.
        self._tables: dict[str, Table] = {}
        #: Files that are read, by the name under which the program is given them.
        self._files: list[str] = []

    def __enter__(self) -> Call:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._holder.cleanup()

    def rod(self, rod: RodLike, name: str = "rod.toml") -> str:
        """The path of a rod file; one that is given as a dict is written under a name."""
        if not isinstance(rod, Mapping):
            return self.path(rod)
        return self.written(name, to_toml(rod))

    def model(self, model: ModelLike) -> str:
        """The path of a model file."""
        if isinstance(model, Model):
            return self.written("model.toml", model.toml)
        if isinstance(model, (str, os.PathLike)):
            return self.path(model)
        if isinstance(model, HasModel):
            kept = model.model
            if kept is not None:
                return self.written("model.toml", kept.toml)
            raise InputError(
                "this result keeps no model, since none is to be used; expected a path, a sma.Model, or another result"
            )
        raise InputError(f"model = {model!r}: expected a path to a model.toml, a sma.Model, or a result of identify or diagnose")

    def recordings(self, given: Recordings | None, role: str) -> list[str]:
        """The paths of recordings; those that are no text are written as such."""
        if given is None:
            return []
        if isinstance(given, Mapping) and given and all(_is_recording(one) for one in given.values()):
            return [self._recording(one, str(name)) for name, one in given.items()]
        if isinstance(given, (list, tuple)):
            return [self._recording(one, f"{role}{k + 1}") for k, one in enumerate(given)]
        return [self._recording(given, f"{role}1")]

    def recording(self, given: RecordingLike, name: str) -> str:
        """The path of one recording."""
        return self._recording(given, name)

    def used(self, use: Use | None) -> list[str]:
        """Flags that say which part of the recordings counts; to be called when they have their names."""
        if use is None:
            return []
        flags: list[str] = []
        for flag, spans in (("--window", use.window_s), ("--exclude", use.exclude_s)):
            for name, span in spans.items():
                file = self._file_of(name)
                flags += [flag, f"{file}:{float(span[0])!r}..{float(span[1])!r}"]
        if use.decimate is not None:
            flags += ["--decimate", str(use.decimate)]
        if use.detrend:
            flags.append("--detrend")
        return flags

    def place(self, name: str) -> Path:
        """Where the program is to write a result."""
        return self._scratch / name

    def run(self, arguments: Iterable[str | os.PathLike[str]], progress: Progress) -> Ended:
        """Run the program; results that are not to be used are results.

        Raises:
            InputError: bad input.
            NoControllerError: no gains meet what is required.
            ProgramError: anything else.
        """
        ended = run([os.fspath(one) for one in arguments], progress=progress, scratch=self._scratch)
        if ended.code == DONE or (ended.code == NOT_TO_BE_USED and not ended.errors):
            notes = [*ended.notes, *ended.errors.splitlines()]
            return Ended(ended.code, self.named(ended.text), tuple(map(self._note, notes)), "")
        said = ended.errors.removeprefix("sma: ").removeprefix("error: ")
        if ended.code == BAD_INPUT:
            raise self._fault(said)
        if ended.code == USAGE:
            raise InputError(self.named(said.partition("\n\nFor more information")[0]))
        said = self.named(said) or f"the program ended with code {ended.code}"
        kind = NoControllerError if ended.code == NOT_TO_BE_USED else ProgramError
        raise kind(said, code=ended.code)

    def document(self, text: str) -> dict[str, Any]:
        """A JSON document of the program, in the caller's names.

        Raises:
            ProgramError: for a document of another version.
        """
        document = json.loads(self.named(text, is_json=True))
        version = document.get("schema_version") if isinstance(document, dict) else None
        if version != SCHEMA_VERSION:
            raise ProgramError(f"the program's JSON has schema_version {version}; expected {SCHEMA_VERSION}: install both anew")
        return dict(document)

    def named(self, text: str, *, is_json: bool = False) -> str:
        """A text of the program with the caller's names instead of this folder's."""
        for folder in (self._given, self._scratch):
            before = f"{folder}{os.sep}"
            text = text.replace(json.dumps(before)[1:-1] if is_json else before, "")
        for file, table in self._tables.items():
            text = text.replace(file, table.name)
        return text

    def in_rows(self, name: str, text: str) -> str:
        """What the program says it did to lines of a recording, in rows if that was given as a table."""
        table = next((table for table in self._tables.values() if table.name == name), None)
        if table is None:
            return text
        shift = table.first_row - 1 - int(table.has_names)
        text = re.sub(r"\(line (\d+)\)$", lambda at: f"(row {int(at[1]) + shift})", text)
        return re.sub(r"\((\d+) lines, first (\d+)\)$", lambda at: f"({at[1]} rows, first {int(at[2]) + shift})", text)

    def _file_of(self, name: str) -> str:
        """The file of a recording of this call, by the name that the caller knows."""
        names = {table.name: file for file, table in self._tables.items()}
        for path in self._files:
            if Path(path).parent != self._given and not path.endswith(".toml"):
                names |= {path: path, Path(path).name: path}
        if name not in names:
            known = ", ".join(dict.fromkeys(Path(one).name for one in names))
            raise InputError(f'use: "{name}" is no recording of this call; expected one of {known}', file=name)
        return names[name]

    def _note(self, note: str) -> str:
        note = self.named(note)
        name = next((table.name for table in self._tables.values() if note.startswith(f"{table.name}: ")), None)
        return note if name is None else self.in_rows(name, note)

    def path(self, path: str | os.PathLike[str]) -> str:
        """The path of a file that the program is given by its name."""
        text = os.fspath(path)
        if text == "-":
            raise InputError('"-" is stdin, which is not read here; expected a path')
        # A name that begins with a dash would be read as a flag.
        text = os.path.join(".", text) if text.startswith("-") else text
        self._files.append(text)
        return text

    def _recording(self, given: RecordingLike, name: str) -> str:
        if isinstance(given, (str, os.PathLike)):
            path = Path(given)
            if path.suffix.lower() not in files.READERS:
                return self.path(given)
            given = files.read(path)
        table = as_table(given, name)
        file = re.sub(r"[^\w.\-]", "_", table.name).lstrip(".-") or "recording"
        while file in self._tables or file == "rod.toml" or file == "model.toml":
            file += "_"
        self._tables[file] = table
        path = self._given / file
        with path.open("w", encoding="utf-8", newline="\n") as out:
            table.write_csv(out)
        self._files.append(str(path))
        return str(path)

    def written(self, name: str, text: str) -> str:
        """The path of a file with a text."""
        path = self._given / name
        path.write_text(text, encoding="utf-8")
        self._files.append(str(path))
        return str(path)

    def _fault(self, said: str) -> InputError:
        """What the program says of bad input, with its place."""
        found = [(said.find(file), file) for file in self._files if file in said]
        if not found:
            return InputError(self.named(said))
        file = min(found, key=lambda one: (one[0], -len(one[1])))[1]
        at = re.search(re.escape(file) + r"(?::(?P<line>\d+))?(?::\d+)?: (?:(?P<column>[^=\n:;]+?) = )?", said)
        line = int(at["line"]) if at and at["line"] else None
        column = at["column"].strip('"') if at and at["column"] else None
        name = Path(file).name
        table = self._tables.get(name) if Path(file).parent == self._given else None
        if table is None:
            text = self.named(said)
            return InputError(text, file=self.named(file), line=line, column=column)
        start = 1 if table.has_names else 0

        def in_rows(match: re.Match[str]) -> str:
            k = int(match[1]) - 1 - start
            return f"{table.label}, row {table.first_row + k}" if k >= 0 else f"{table.label}, names of columns"

        text = self.named(re.sub(re.escape(file) + r":(\d+)", in_rows, said))
        row = table.first_row + line - 1 - start if line is not None and line > start else None
        return InputError(text, file=table.name, row=row, column=column)


def _is_recording(given: object) -> bool:
    """True for what is a recording by itself, and not a column of one."""
    if isinstance(given, (str, os.PathLike, Mapping, Table)):
        return True
    return type(given).__name__ in ("DataFrame", "LazyFrame") or getattr(given, "ndim", 1) == 2
