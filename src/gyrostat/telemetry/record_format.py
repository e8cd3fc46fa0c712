"""Format of a record's file, as the files of `gyrostat.telemetry.formats` define it."""

import abc
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.columns import Chosen, Header


@dataclass(frozen=True)
class Request:
    """What is read from a file.

    Attributes:
        choose: Function from the header to role -> column.
        max_samples: Largest number of samples that is accepted.
        tolerant: Whether 'NA' and similar words are empty cells.
        packets: XTCE description of the packets, for files that need one.
    """

    choose: Callable[[Header], Mapping[str, Chosen]]
    max_samples: int
    tolerant: bool = False
    packets: Path | None = None


class RecordFormat(abc.ABC):
    """Format of a record's file.

    Attributes:
        suffixes: Suffixes of its files, in lower case.
        in_parts: Whether `parts` needs no more memory than one part.
    """

    suffixes: ClassVar[tuple[str, ...]]
    in_parts: ClassVar[bool] = False

    @staticmethod
    @abc.abstractmethod
    def read(file: Path, request: Request) -> Measured:
        """Read the chosen columns of a file.

        Args:
            file: A regular file that is not empty.
            request: What to read.

        Raises:
            InputError: The content cannot be used, or a package that reads it is not installed.
            OSError: The file cannot be read.
        """

    @classmethod
    def parts(cls, file: Path, request: Request) -> Iterator[Measured]:
        """Read the chosen columns of a file in parts of at most `request.max_samples` samples.

        A format that cannot be read in parts gives the whole file, which may not be longer.

        Args:
            file: A regular file that is not empty.
            request: What to read.

        Raises:
            InputError: As for `read`.
            OSError: The file cannot be read.
        """
        yield cls.read(file, request)
