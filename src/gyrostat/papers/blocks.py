"""Evaluation of many cases in blocks of equal size, so that a single size is compiled."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import chain
from typing import Any

from gyrostat.simulation import blocks


def in_blocks(
    cases: Sequence[Any],
    size: int,
    compute: Callable[[list[Any]], Any],
    *,
    say: Callable[[str], None],
    name: str,
    threads: int = 1,
) -> Iterator[Any]:
    """Call a function with `size` cases at a time; the last block is padded with its last case.

    Args:
        cases: All cases.
        size: Number of cases in a block.
        compute: Called with the cases of a block; returns an array with one row for each. The first
            call ends before other threads start, because it may compile a program for all.
        say: Called after each block.
        name: Name of the computation in progress messages.
        threads: Number of threads that call the function.

    Yields:
        For each block in order, the rows without those of the padding.
    """

    def block(rows_and_count: Any) -> Any:
        rows, count = rows_and_count
        return compute([cases[row] for row in rows])[:count]

    first_block, *later_blocks = blocks(len(cases), size)
    with ThreadPoolExecutor(threads) as pool:
        results = pool.map(block, later_blocks) if threads > 1 else map(block, later_blocks)
        for number, result in enumerate(chain([block(first_block)], results), start=1):
            say(f"{name}: {min(number * size, len(cases))} of {len(cases)}")
            yield result
