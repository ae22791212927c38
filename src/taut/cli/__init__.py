"""The command ``taut``: thin, every command is a few calls of the library and a report of what came out."""

from taut.cli.application import main

__all__ = ["main"]
