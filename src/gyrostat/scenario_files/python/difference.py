"""Difference between an object in memory and the one that its text gives."""

from typing import NamedTuple


class Place(NamedTuple):
    """Where an object was found.

    Attributes:
        text: Description, for messages.
        names: Global names on the way to it, from the outermost to the innermost.
    """

    text: str
    names: tuple[str, ...] = ()

    def inside(self, part: str) -> "Place":
        """Place of an attribute or element."""
        return Place(f"{self.text}{part}", self.names)

    def used(self, name: str) -> "Place":
        """Place of a global name that code refers to."""
        return Place(name, (*self.names, name))


class DifferentError(Exception):
    """An object in memory is not the one that its text gives.

    Attributes:
        place: Where they differ.
        live: What is in memory, for messages.
        loaded: What the text gives, for messages.
    """

    def __init__(self, place: Place, live: str, loaded: str) -> None:
        super().__init__(f"{place.text}: found {live}, and {loaded} from the text")
        self.place, self.live, self.loaded = place, live, loaded


class PatchedError(DifferentError):
    """A name of a library has another value than the library gives to it."""

    def __init__(self, place: Place, live: str) -> None:
        super().__init__(place, live, "the value of the library")


def shown(value: object) -> str:
    """Value for a message: a short one as it is, any other by its kind."""
    text = repr(value) if isinstance(value, bool | int | float | complex | str | bytes) else ""
    if value is None or 0 < len(text) <= 40:
        return text or "None"
    name = getattr(value, "__name__", None)
    kind = type(value).__name__
    return f"{kind} {name}" if isinstance(name, str) else kind
