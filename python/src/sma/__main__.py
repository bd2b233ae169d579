"""``python -m sma``: the program itself."""

from __future__ import annotations

import os
import subprocess
import sys

from .errors import ProgramError
from .program import program_path


def main() -> int:
    """Give this process to the program, or wait for it where that cannot be done."""
    try:
        program = str(program_path())
    except ProgramError as error:
        print(f"sma: {error}", file=sys.stderr)
        return 1
    arguments = [program, *sys.argv[1:]]
    if os.name == "posix":
        os.execv(program, arguments)
    return subprocess.run(arguments, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
