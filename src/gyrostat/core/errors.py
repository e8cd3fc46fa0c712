"""The error raised for unusable user input."""

LONGEST = 900
"""Bytes of a message: a file's own text in it may be of any length."""


def printable(text: str) -> str:
    """Text with line breaks and other control characters, which a terminal obeys, written out."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def one_line(text: str, longest: int = LONGEST) -> str:
    """One line of at most so many bytes: what is too long loses its middle.

    Args:
        text: Any text.
        longest: Bytes in UTF-8.
    """
    line = printable(text)
    encoded = line.encode("utf-8", errors="backslashreplace")
    if len(encoded) <= longest:
        return line
    end = (longest - 5) // 3
    ends = encoded[: longest - 5 - end], encoded[-end:]
    return " ... ".join(part.decode("utf-8", errors="ignore") for part in ends)


class InputError(ValueError):
    """Input that cannot be used.

    Its text is one line that names the file or place, what was found and what was expected. The
    command line prints it and exits with 2.
    """

    def __init__(self, text: str):
        super().__init__(one_line(text))
