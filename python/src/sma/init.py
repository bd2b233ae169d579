"""``sma init``: a rod file to begin with."""

from __future__ import annotations

from .call import Call, Recordings


def init(recordings: Recordings) -> str:
    """Propose a rod file: which column of recordings is what, as far as their names and ranges tell.

    Args:
        recordings: one or several with the same columns, as of :func:`sma.identify`.

    Returns:
        The text of a ``rod.toml``. Guesses in it have a question mark; what nobody but you knows is left open.

    Raises:
        InputError: bad input, with file, line or row, and column.
        ProgramError: the program is missing or failed.
    """
    with Call() as call:
        place = call.place("rod.toml")
        call.run(["init", *call.recordings(recordings, "recording"), "--rod", str(place)], False)
        return call.named(place.read_text(encoding="utf-8"))
