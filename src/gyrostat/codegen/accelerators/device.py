"""Interface of a device that runs programs with one run in each work item."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Words = NDArray[np.uint64]


class Usage(NamedTuple):
    """What a kernel takes of its device; None where the device does not tell.

    Attributes:
        registers: Registers of a work item, of 32 bits.
        private: Private memory of a work item, bytes.
        group: Work items of a work group.
        occupancy: Share of the work items which a processor can hold, that it holds of this kernel.
    """

    registers: int | None
    private: int | None
    group: int
    occupancy: float | None

    def text(self) -> str:
        """One line."""
        occupancy = None if self.occupancy is None else f"{100.0 * self.occupancy:.0f} %"
        names = {"registers": self.registers, "bytes private": self.private}
        told = [f"{'?' if value is None else value} {name}" for name, value in names.items()]
        return ", ".join([*told, f"groups of {self.group}", f"occupancy {occupancy or '?'}"])


class Kernel(Protocol):
    """Compiled program of a device."""

    @property
    def usage(self) -> Usage:
        """What it takes of the device."""
        ...


class Queue(Protocol):
    """Memory and operations of one thread, executed one after the other."""

    def memory(self, words: int) -> Any:
        """Memory of a number of words of 64 bits."""
        ...

    def write(self, memory: Any, first: int, words: Words) -> None:
        """Copy words to memory, from its word `first` on."""
        ...

    def read(self, memory: Any, first: int, words: Words) -> None:
        """Copy memory, from its word `first` on, to an array; waits for all operations before."""
        ...

    def copy(self, source: Any, first: int, target: Any, start: int, words: int) -> None:
        """Copy words from one memory to another."""
        ...

    def launch(self, kernel: Any, runs: int, arguments: Sequence[Any]) -> None:
        """Start a kernel.

        Args:
            kernel: Kernel of this device.
            runs: Number of runs.
            arguments: Memories, numbers, and words that all runs share.
        """
        ...


class Device(Protocol):
    """Device with its compiler.

    Attributes:
        name: Names and versions of device, driver and compiler: the same text, the same bits.
        group: Work items of a work group.
        by_value: Largest number of words that all runs share, which a kernel takes by value; more
            are in memory.
    """

    name: str
    group: int
    by_value: int

    def kernel(self, text: str, name: str) -> Kernel:
        """Compile a text, once per process.

        Args:
            text: Text.
            name: Name of its kernel.

        Raises:
            InputError: The compiler refuses it.
        """
        ...

    def queue(self) -> Queue:
        """Queue of the current thread."""
        ...
