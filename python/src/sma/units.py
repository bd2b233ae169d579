"""One unit of a fleet on another machine: its files travel with it, and its result comes back."""

from __future__ import annotations

import os
import socket
import subprocess
import tempfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from .errors import ProgramError
from .program import program_path
from .rod import rig_table


@dataclass(frozen=True)
class Sent:
    """A file that travels: its name from the rig's own folder, and its content, packed."""

    name: str
    packed: bytes


@dataclass(frozen=True)
class UnitTask:
    """A rig, and what is to be done with it."""

    #: Name of the unit: a hash of the program, the flags and the files.
    name: str
    #: Flags of ``sma batch`` that can move the result.
    flags: tuple[str, ...]
    rod: Sent
    train: tuple[Sent, ...]
    validate: tuple[Sent, ...]


@dataclass(frozen=True)
class UnitRan:
    """The end of a unit."""

    name: str
    #: Its file, packed; ``None`` where the unit was ended by something else than itself.
    packed: bytes | None
    #: What the program said.
    said: str


def task(name: str, flags: Sequence[str], rod: str, train: Sequence[str], validate: Sequence[str]) -> UnitTask:
    """The task of a rig of ``sma batch --list --json``, with its files as they are now.

    Raises:
        OSError: a file cannot be read.
    """
    recordings = [os.path.abspath(one) for one in (*train, *validate)]
    # The deepest folder that holds them all, as in the names that a unit has for its files.
    home = os.path.commonpath([os.path.dirname(one) for one in recordings])

    def sent(path: str, name: str) -> Sent:
        return Sent(PurePosixPath(Path(name)).as_posix(), zlib.compress(Path(path).read_bytes(), 1))

    files = [sent(one, os.path.relpath(one, home)) for one in recordings]
    n_train = len(train)
    return UnitTask(name, tuple(flags), sent(rod, os.path.basename(rod)), tuple(files[:n_train]), tuple(files[n_train:]))


def run_unit(task: UnitTask, *, folder: str | None = None) -> UnitRan:
    """Run a unit in a folder of its own below ``folder``. The program ends with this process, however that ends.

    Raises:
        ProgramError: the program here is another build than where the task was made, or is missing.
    """
    with tempfile.TemporaryDirectory(prefix="sma-unit-", dir=folder or _local_folder()) as place:
        base = Path(place)
        rod = _unpacked(base / "rod", task.rod)
        train, validate = ([_unpacked(base / "rig", one) for one in files] for files in (task.train, task.validate))
        manifest = base / "fleet.toml"
        manifest.write_text(rig_table("unit", rod, train, validate), encoding="utf-8")
        arguments = [
            "batch",
            str(manifest),
            "--out",
            str(base / "out"),
            "--jobs",
            "1",
            "--quiet",
            "--end-with-stdin",
            *task.flags,
        ]
        with subprocess.Popen(
            [str(program_path()), *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            errors="replace",
        ) as child:
            try:
                assert child.stderr is not None
                # Not communicate(): it would close stdin.
                said = child.stderr.read().strip()
                child.wait()
            except BaseException:
                child.kill()
                raise
        units = {path.stem: path for path in (base / "out" / "units").glob("*.json")}
        if task.name in units:
            return UnitRan(task.name, zlib.compress(units[task.name].read_bytes(), 1), said)
        if units:
            raise ProgramError(
                f"{socket.gethostname()}: the program {program_path()} is another build than the one that made the tasks, and may have other "
                "last digits; expected the same wheel on all machines"
            )
        return UnitRan(task.name, None, said.removeprefix("sma: ") or f"the program ended with code {child.returncode}")


def _local_folder() -> str | None:
    """Folder of a Dask worker, which Dask clears after a worker that was killed; else that for temporary files."""
    try:
        from distributed import get_worker

        return str(get_worker().local_directory)
    except (ImportError, ValueError):
        return None


def _unpacked(folder: Path, file: Sent) -> str:
    path = folder / file.name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(zlib.decompress(file.packed))
    return str(path)
