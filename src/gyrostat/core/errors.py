"""Error for unusable user input, and the one-line form of its message."""

import contextlib
from collections.abc import Iterator

LONGEST = 900
"""Longest message, bytes. Text quoted from a user's file can be of any length."""


def printable(text: str) -> str:
    """Escape line breaks and other control characters, which a terminal would act on."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def one_line(text: str, longest: int = LONGEST) -> str:
    """Shorten a text to one line; a line that is too long loses its middle part.

    Args:
        text: Any text.
        longest: Largest length in UTF-8, bytes.
    """
    line = printable(text)
    encoded = line.encode("utf-8", errors="backslashreplace")
    if len(encoded) <= longest:
        return line
    end = (longest - 5) // 3
    ends = encoded[: longest - 5 - end], encoded[-end:]
    return " ... ".join(part.decode("utf-8", errors="ignore") for part in ends)


def reason_of(error: Exception) -> str:
    """Message of an error of another library, without line breaks; its type if it has none."""
    return " ".join(str(error).split()) or type(error).__name__


class InputError(ValueError):
    """Input that cannot be used.

    The message is one line that names the file or place, what was found and what was expected. The
    command line prints it and exits with status 2.
    """

    def __init__(self, text: str):
        super().__init__(one_line(text))


@contextlib.contextmanager
def placed(where: str) -> Iterator[None]:
    """Put the place of the input in front of the message of an `InputError`.

    Args:
        where: Place, such as a file and a key.

    Raises:
        InputError: The block raises it.
    """
    try:
        yield
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
