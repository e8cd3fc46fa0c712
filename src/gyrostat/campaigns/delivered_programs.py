"""Native programs that workers without a common disk or a compiler receive as machine code.

All workers of a campaign run the same bytes, so that it does not matter which compiler a machine
has, or what it would make of the text. A program is identified by the digest of its content and is
sent only to a process that does not have it.
"""

import ctypes
import hashlib
import pickle
import threading
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from gyrostat.codegen.simd.compiler import delivered_library
from gyrostat.core.cache import private_cache
from gyrostat.core.errors import InputError
from gyrostat.scenario.scenario import Scenario

if TYPE_CHECKING:
    from gyrostat.campaigns.native import Program, Stored


class Label(NamedTuple):
    """Which runs a program simulates, and its digest.

    Attributes:
        scenario: Digest of the scenario.
        parts: Number of parts of a run whose noise has its own random key; 0: one for the run.
        program: SHA-256 digest of the content.
    """

    scenario: str
    parts: int
    program: str


def content_of(program: "Program") -> bytes:
    """Content of a program: how to call it, and its machine code.

    Raises:
        InputError: The cache does not have its libraries.
    """
    cache = private_cache()
    names = [part.library for part in program.stored[:2]]
    libraries = [None if cache is None else cache.read(name) for name in names]
    if None in libraries:
        raise InputError(
            "cache of compiled programs: found no program that was just compiled, expected it "
            "(is GYROSTAT_CACHE_LIMIT too small?)"
        )
    return pickle.dumps((program.stored, libraries))


def digest_of_content(content: bytes) -> str:
    """Digest of the content of a program."""
    return hashlib.sha256(content).hexdigest()


_lock = threading.Lock()
_contents: "dict[str, tuple[Stored, list[ctypes.CDLL]]]" = {}
_labels: dict[tuple[str, int], str] = {}


def missing_programs(labels: Iterable[Label]) -> list[str]:
    """Digests of the programs that this process does not have."""
    return [label.program for label in labels if label.program not in _contents]


def install_programs(labels: Iterable[Label], contents: Mapping[str, bytes]) -> bool:
    """Load programs; `delivered_program` then gives them for their scenarios.

    Args:
        labels: Labels of the programs.
        contents: Digest -> content, of the programs that this process does not have.

    Returns:
        Whether a scenario had another program before.

    Raises:
        InputError: A content is damaged, or a library cannot be loaded.
    """
    replaced = False
    with _lock:
        for label in labels:
            if label.program not in _contents:
                content = contents[label.program]
                digest = digest_of_content(content)
                if digest != label.program:
                    raise InputError(f"program: found digest {digest}, expected {label.program}")
                stored, libraries = pickle.loads(content)
                _contents[label.program] = stored, [delivered_library(each) for each in libraries]
            runs = label.scenario, label.parts
            replaced |= _labels.get(runs, label.program) != label.program
            _labels[runs] = label.program
    return replaced


def delivered_program(scenario: Scenario, parts: int) -> "Program | None":
    """Program that was delivered to this process for a scenario; None if there is none.

    Args:
        scenario: Scenario.
        parts: See `Label`.
    """
    if not _labels:
        return None
    digest = _labels.get((scenario.digest(), parts))
    if digest is None:
        return None
    from gyrostat.campaigns.native import load
    from gyrostat.scenario.structure import structure_of

    stored, libraries = _contents[digest]
    return load(structure_of(scenario), stored, *libraries)
