"""Bounds of instructions and stack of compiled flight code, from its disassembly.

The files use the standard library and each other alone: an exported folder has a copy of them.
"""

from .instructions import InstructionBound, Instructions
from .listing import Listing, UnboundedError, read_listing
from .passes import CLoop, c_loops
from .stack import Stack, frames

__all__ = [
    "CLoop",
    "InstructionBound",
    "Instructions",
    "Listing",
    "Stack",
    "UnboundedError",
    "c_loops",
    "frames",
    "read_listing",
]
