"""Exceptions of the package."""

from __future__ import annotations


class SmaError(Exception):
    """Every error of this package."""


class InputError(SmaError, ValueError):
    """Something that was given cannot be read, or makes no sense.

    The text names file or variable, row or line, value, and what would be accepted. The parts that are known stand beside it:

    - ``file``: name of the file, or of the table that was given (``train1``);
    - ``line``: line of a text file, counted from 1;
    - ``row``: row of a table, counted as its source does: arrays and frames from 0, sheets from 1;
    - ``column``: name of the column, the variable, or the key of the rod file.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | None = None,
        line: int | None = None,
        row: int | None = None,
        column: str | None = None,
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.row = row
        self.column = column


class ProgramError(SmaError, RuntimeError):
    """The program failed for another reason than its input, or is not there. ``code`` is its exit code, if it ran."""

    def __init__(self, message: str, *, code: int | None = None) -> None:
        super().__init__(message)
        self.code = code


class NoControllerError(ProgramError):
    """The inputs are sound, and no gains meet what is required of them."""


class MissingExtraError(SmaError, ImportError):
    """A package that is needed for this kind of file is not installed; the text says which extra has it."""


def missing(package: str, extra: str, purpose: str) -> MissingExtraError:
    """An error that says what to install."""
    return MissingExtraError(f"{purpose} needs {package}, which is not installed; expected: pip install 'sma-actuator[{extra}]'")
