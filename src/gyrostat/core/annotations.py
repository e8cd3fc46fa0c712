"""Notes in the annotations of the fields of a dataclass, `field: Annotated[type, note]`."""

from dataclasses import fields
from typing import Any, TypeVar

Note = TypeVar("Note")


def notes_of(kind: Any, wanted: type[Note]) -> dict[str, Note]:
    """Field -> its note, of the fields with a note of a type.

    Args:
        kind: Dataclass, or an instance of it.
        wanted: Type of the notes.
    """
    return {
        field.name: note
        for field in fields(kind)
        for note in getattr(field.type, "__metadata__", ())
        if isinstance(note, wanted)
    }
