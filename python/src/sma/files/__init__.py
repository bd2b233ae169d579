"""Recordings in the files of other programs: one module a format."""

from .read import READERS, read

__all__ = ["READERS", "read"]
