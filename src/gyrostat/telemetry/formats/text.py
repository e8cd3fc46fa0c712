"""Delimited text; see `gyrostat.telemetry.text`."""

from pathlib import Path
from typing import ClassVar

from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.record_format import RecordFormat, Request
from gyrostat.telemetry.text import read_text


class DelimitedText(RecordFormat):
    """Text with any delimiter."""

    suffixes: ClassVar[tuple[str, ...]] = (".csv", ".txt", ".tsv", ".dat")

    @staticmethod
    def read(file: Path, request: Request) -> Measured:
        """See `RecordFormat.read`."""
        return read_text(file, request.choose, request.max_samples, request.tolerant)
