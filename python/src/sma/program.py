"""The program ``sma``: where it is, and how it is run."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from .errors import ProgramError

#: ``True`` shows progress on stderr, ``False`` does not, ``None`` does on a terminal and in a notebook; a function gets each line.
Progress = bool | Callable[[str], None] | None

#: Variable of the environment that names another program, for development.
OVERRIDE = "SMA_PROGRAM"

#: Seconds that the program has to leave after it was asked to; it keeps nothing that would be lost.
LEAVE_S = 2.0


@dataclass(frozen=True)
class Ended:
    """A call that has ended."""

    code: int
    #: stdout.
    text: str
    #: Lines of stderr that begin with ``note: ``, without that.
    notes: tuple[str, ...]
    #: All else on stderr.
    errors: str


def program_path() -> Path:
    """The program that came with this package.

    Raises:
        ProgramError: if it is not there.
    """
    override = os.environ.get(OVERRIDE)
    if override is not None:
        path = Path(override)
        if path.is_file():
            return path
        raise ProgramError(f"{OVERRIDE} = {override}: no such file; expected the program sma")
    name = "sma.exe" if os.name == "nt" else "sma"
    folders = [
        Path(sysconfig.get_path("scripts")),
        Path(sys.executable).parent,
        Path(sysconfig.get_path("scripts", f"{os.name}_user")),
        # pip install --target
        Path(__file__).parents[1] / "bin",
    ]
    for folder in folders:
        if (folder / name).is_file():
            return folder / name
    places = ", ".join(str(folder) for folder in dict.fromkeys(folders))
    raise ProgramError(
        f"the program {name} is in none of {places}; expected it where pip installs it: pip install --force-reinstall sma-actuator"
    )


def run(arguments: Sequence[str], *, progress: Progress = None, scratch: Path) -> Ended:
    """Run the program to its end.

    Ctrl-C ends it at once: KeyboardInterrupt is raised when it is gone. ``scratch`` is a folder for its stdout.
    """
    show, clear = shown(progress)
    output = scratch / "stdout"
    environment = os.environ | {"NO_COLOR": "1"}
    if show is not None:
        environment["SMA_PROGRESS"] = "lines"
    notes: list[str] = []
    errors: list[str] = []
    with output.open("wb") as stdout:
        child = subprocess.Popen(
            [str(program_path()), *arguments],
            stdin=subprocess.DEVNULL,
            stdout=stdout,
            stderr=subprocess.PIPE,
            env=environment,
            encoding="utf-8",
            errors="replace",
        )
        with child:
            try:
                assert child.stderr is not None
                for line in child.stderr:
                    line = line.rstrip("\n")
                    if line.startswith("progress: "):
                        if show is not None:
                            show(line.removeprefix("progress: "))
                    elif line.startswith("note: "):
                        notes.append(line.removeprefix("note: "))
                    else:
                        errors.append(line)
                child.wait()
            except BaseException:
                _end(child)
                raise
            finally:
                clear()
    if child.returncode in (130, -signal.SIGINT):
        raise KeyboardInterrupt
    text = output.read_text(encoding="utf-8", errors="replace")
    return Ended(child.returncode, text, tuple(notes), "\n".join(errors).strip())


def _end(child: subprocess.Popen[str]) -> None:
    child.terminate()
    try:
        child.wait(LEAVE_S)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()


def shown(progress: Progress) -> tuple[Callable[[str], None] | None, Callable[[], None]]:
    """Where lines of progress go, and how the last one is cleared."""
    if progress is False or (progress is None and not _is_watched(sys.stderr)):
        return None, lambda: None
    if callable(progress):
        return progress, lambda: None
    width = 0

    def show(line: str) -> None:
        nonlocal width
        sys.stderr.write("\r" + line.ljust(width))
        sys.stderr.flush()
        width = len(line)

    def clear() -> None:
        if width:
            with contextlib.suppress(OSError, ValueError):
                sys.stderr.write("\r" + " " * width + "\r")
                sys.stderr.flush()

    return show, clear


def _is_watched(stream: TextIO | None) -> bool:
    """True for a terminal and for a notebook."""
    if stream is None:
        return False
    if type(stream).__module__.startswith("ipykernel"):
        return True
    try:
        return stream.isatty()
    except ValueError:
        return False
