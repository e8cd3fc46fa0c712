"""Delimited text; see `gyrostat.telemetry.text`."""

from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.record_format import RecordFormat, Request
from gyrostat.telemetry.text import text_parts


class DelimitedText(RecordFormat):
    """Text with any delimiter."""

    suffixes: ClassVar[tuple[str, ...]] = (".csv", ".txt", ".tsv", ".dat")
    in_parts: ClassVar[bool] = True

    @staticmethod
    def read(file: Path, request: Request) -> Measured:
        """See `RecordFormat.read`."""
        (measured,) = text_parts(
            file, request.choose, request.max_samples, request.tolerant, single=True
        )
        return measured

    @classmethod
    def parts(cls, file: Path, request: Request) -> Iterator[Measured]:
        """See `RecordFormat.parts`."""
        yield from text_parts(file, request.choose, request.max_samples, request.tolerant)
