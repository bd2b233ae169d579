"""A fleet on the workers of a Dask cluster::

    python -m sma.dask --scheduler tcp://10.0.0.1:8786 rigs --out night --csv night/table.csv

Each rig is a unit that a worker runs by itself: its files travel with it, so that no folder need be shared, and its result comes back
as a file of ``night/units``. What has a file is not run again. A worker that is killed costs its unit, which another one runs. The table
is made here by ``sma batch --merge``, with the same bytes as without Dask. All machines need the same wheel.
"""

from __future__ import annotations

import argparse
import importlib
import itertools
import json
import os
import subprocess
import sys
import tempfile
import zlib
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

from .errors import InputError, ProgramError, SmaError, missing
from .program import Progress, program_path, run, shown
from .units import UnitRan, UnitTask, run_unit, task

#: Units under way or waiting at the workers, a thread of theirs: the files of more would only wait in the scheduler's memory.
UNITS_PER_THREAD = 2

#: Flags of ``sma batch`` that name a place of a result, or the text beside it.
OF_TABLES = ("csv", "report", "json")


def run_units(
    scheduler: str,
    fleet: str,
    out: Path,
    flags: Sequence[str],
    *,
    retry: bool = False,
    progress: Progress = None,
) -> list[str]:
    """Run the rigs of a fleet that have no result in ``out`` yet, and keep their results there; what was said of those without one.

    ``flags`` are those of ``sma batch`` that can move a result.

    Raises:
        InputError: the fleet cannot be read.
        MissingExtraError: Dask is not installed.
        ProgramError: the program is missing, fails, or is another build on a worker.
    """
    try:
        # Without types.
        distributed: Any = importlib.import_module("distributed")
    except ImportError:
        raise missing("distributed", "dask", "a scheduler of Dask") from None
    rigs = _open(_listed(fleet, out, flags), retry)
    if not rigs:
        return []
    (out / "units").mkdir(parents=True, exist_ok=True)
    said: list[str] = []
    waiting = _tasks(rigs, flags, said)
    show, clear = shown(progress)
    try:
        client = distributed.Client(scheduler, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            f"scheduler = {scheduler}: {error}; expected the address of a Dask scheduler, such as tcp://10.0.0.1:8786"
        ) from None
    with client:
        done, n_sent, n_ended = distributed.as_completed(loop=client.loop), 0, 0

        def send() -> int:
            # Workers come and go.
            n_wanted = max(UNITS_PER_THREAD * sum(client.nthreads().values()), UNITS_PER_THREAD)
            units = list(itertools.islice(waiting, max(n_wanted - (n_sent - n_ended), 0)))
            for unit in units:
                # No result of Dask's own memory: a unit is run again where its file is gone.
                done.add(client.submit(run_unit, unit, key=f"sma-{unit.name}-{os.urandom(4).hex()}", pure=False))
            return len(units)

        try:
            n_sent += send()
            for future in done:
                try:
                    ran = future.result()
                except distributed.KilledWorker as error:
                    said.append(f"a rig whose workers were killed again and again is left out: {error}")
                else:
                    _keep(ran, out, said)
                future.release()
                n_ended += 1
                if show is not None:
                    show(f"batch {n_ended}/{len(rigs)}")
                n_sent += send()
        except CancelledError as error:
            raise ProgramError(
                f"{scheduler}: the scheduler is gone, or dropped a unit ({error}); the same call goes on"
            ) from None
        except BaseException as error:
            client.cancel(list(done.futures))
            if isinstance(error, SmaError) or not isinstance(error, Exception):
                raise
            raise ProgramError(
                f"a worker: {type(error).__name__}: {error}; expected sma-actuator, the same wheel as here, on all machines"
            ) from error
        finally:
            clear()
    return said


def _listed(fleet: str, out: Path, flags: Sequence[str]) -> list[dict[str, Any]]:
    """Rigs of a fleet with their files and units, by the program."""
    with tempfile.TemporaryDirectory(prefix="sma-") as scratch:
        arguments = ["batch", fleet, "--out", str(out), "--list", "--json", "-", "--quiet", *flags]
        ended = run(arguments, progress=False, scratch=Path(scratch))
    if ended.code != 0:
        kind = InputError if ended.code in (2, 3) else ProgramError
        raise kind(ended.errors.removeprefix("sma: "))
    rigs: list[dict[str, Any]] = json.loads(ended.text)["rigs"]
    return rigs


def _open(rigs: Iterable[dict[str, Any]], retry: bool) -> list[dict[str, Any]]:
    """Rigs that are to be run; equal ones once."""
    kept = ("done",) if retry else ("done", "failed")
    units = {rig["unit"]: rig for rig in rigs if rig["unit"] is not None and rig["kept"] not in kept}
    return list(units.values())


def _tasks(rigs: Iterable[dict[str, Any]], flags: Sequence[str], said: list[str]) -> Iterator[UnitTask]:
    """Tasks, each made when it is sent, so that the files of few are in memory at a time."""
    for rig in rigs:
        try:
            yield task(rig["unit"], flags, rig["rod"], rig["train"], rig["validate"])
        except OSError as error:
            said.append(f"{rig['rig']}: {error}")


def _keep(ran: UnitRan, out: Path, said: list[str]) -> None:
    """Keep the file of a unit, at once."""
    if ran.packed is None:
        said.append(ran.said)
        return
    with tempfile.NamedTemporaryFile(dir=out, prefix=".dask-", delete=False) as file:
        file.write(zlib.decompress(ran.packed))
        file.flush()
        os.fsync(file.fileno())
    Path(file.name).chmod(0o644)
    os.replace(file.name, out / "units" / f"{ran.name}.json")


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code is that of ``sma batch``."""
    parser = argparse.ArgumentParser(prog="python -m sma.dask", description="sma batch on the workers of a Dask cluster.")
    parser.add_argument("fleet", help="folder of rigs, or manifest (.csv, .toml)")
    parser.add_argument(
        "--scheduler", required=True, metavar="ADDRESS", help="address of the scheduler, such as tcp://10.0.0.1:8786"
    )
    parser.add_argument("--out", required=True, type=Path, metavar="DIR", help="folder for results, as of sma batch")
    parser.add_argument("--do", choices=["diagnose", "identify"], default="diagnose", help="command on each rig")
    parser.add_argument("--memory", choices=["last-reversal", "nested"], default="last-reversal")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--retry", action="store_true", help="try rigs again that failed")
    parser.add_argument("--quiet", "-q", action="store_true", help="no progress and no notes")
    for name in OF_TABLES:
        parser.add_argument(f"--{name}", metavar="FILE", help=f"as of sma batch --{name}")
    given = parser.parse_args(arguments)
    flags = ["--do", given.do, "--memory", given.memory, "--seed", str(given.seed)]
    try:
        said = run_units(
            given.scheduler, given.fleet, given.out, flags, retry=given.retry, progress=False if given.quiet else None
        )
    except SmaError as error:
        print(f"sma: {error}", file=sys.stderr)
        return 3 if isinstance(error, InputError) else 1
    if not given.quiet:
        for one in said:
            print(f"note: {one}", file=sys.stderr)
    tables = [part for name in OF_TABLES if (place := getattr(given, name)) is not None for part in (f"--{name}", place)]
    quiet = ["--quiet"] if given.quiet else []
    merged = ["batch", given.fleet, "--out", str(given.out), "--merge", str(given.out), *flags, *tables, *quiet]
    return subprocess.run([str(program_path()), *merged], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
