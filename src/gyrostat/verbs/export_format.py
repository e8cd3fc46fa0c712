"""Base of the formats that `export` writes, whose classes are in `formats`.

Their modules import what is slow to load in their methods, because the help of the command line
names every format.
"""

from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from gyrostat.verbs.arguments import Say

if TYPE_CHECKING:
    from gyrostat.exports import Search, Target
    from gyrostat.wheel import WheelModel


class ExportFormat:
    """Format that `export` writes.

    Attributes:
        name: Name on the command line.
        about: Description for the help of the command line.
    """

    name: ClassVar[str]
    about: ClassVar[str]


class WheelFormat(ExportFormat):
    """Format of a wheel model."""

    @classmethod
    def texts(cls, model: "WheelModel") -> dict[str, str]:
        """Files: name -> text.

        Args:
            model: Content of a model file.

        Raises:
            InputError: The format cannot represent the wheel.
        """
        raise NotImplementedError


class ModuleFormat(ExportFormat):
    """Format of a flight module, which is written as a whole."""

    @classmethod
    def write(cls, target: "Target", folder: Path, say: Say) -> list[str]:
        """Write the files; return their names.

        Args:
            target: Flight module.
            folder: Folder for the files.
            say: Function that receives each message for the user.

        Raises:
            InputError: The module cannot be emitted.
        """
        raise NotImplementedError


class CodeFormat(ExportFormat):
    """Format of a flight module that consists of texts.

    The controller of a scenario can be written in it, and its numbers can have single precision.
    """

    @classmethod
    def texts(
        cls, target: "Target", precision: str, origin: str, search: "Search | None"
    ) -> dict[str, str]:
        """Files: name relative to the folder -> text.

        Args:
            target: Flight module.
            precision: Precision of real numbers: "double" or "float".
            origin: Origin of the parameters, for the README.
            search: Search for test vectors; None for those of the test run.

        Raises:
            InputError: The module cannot be emitted.
        """
        raise NotImplementedError
