"""Messages for the user."""

import sys

from gyrostat.core.errors import printable


def silent(line: str) -> None:
    """Drop a message; the default of `say`."""


def to_stderr(line: str) -> None:
    """Print a message on stderr, with control characters replaced."""
    print(printable(line), file=sys.stderr, flush=True)
