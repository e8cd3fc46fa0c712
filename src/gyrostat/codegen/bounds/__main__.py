"""Prints the bounds of a program beside its counts, as figures of evidence.

`python3 -m bounds PROCESSOR LISTING C_FILE FRAMES [COUNTS ...]`; exit 1 if a bound does not exist
or a count is above it. The roots are the functions call_NAME of the program; the counts are lines
`count`, name, instructions, stack, with tabs between them.
"""

import sys
from pathlib import Path

from . import Instructions, Stack, UnboundedError, c_loops, frames, read_listing
from .library import COUNTED

Counts = dict[str, tuple[int, int]]
"""Function -> largest count of its instructions, bytes of its stack."""


def figures(processor: str, paths: list[Path]) -> tuple[list[str], list[str]]:
    """Lines of the figures, and what is wrong.

    Raises:
        UnboundedError: A bound does not exist.
    """
    listing_file, source, frame_file, *count_files = paths
    counts: Counts = {}
    for path in count_files:
        counts |= _counts(path.read_text(encoding="utf-8"))
    listing = read_listing(listing_file.read_text(encoding="utf-8"))
    library = {name: counts.pop(name)[0] for name in COUNTED if name in counts}
    loops = c_loops(source.read_text(encoding="utf-8"))
    instructions = Instructions(listing, source.name, loops, library)
    stack = Stack(listing, frames(frame_file.read_text(encoding="utf-8")))
    rows, wrong = [], []

    def figure(name: str, value: object, unit: str = "") -> None:
        rows.append(f"figure\t{processor}: {name}\t{value}\t{unit}")

    roots = sorted(s for s in listing.symbols.values() if s.startswith("call_"))
    limits = {root: (instructions.bound(root), stack.bound(root)) for root in roots}
    subnormal = any(bound.normal != bound.any for bound, _ in limits.values())
    for root, (bound, depth) in limits.items():
        name = root.removeprefix("call_")
        figure(f"{name}, bound", bound.any, "instructions")
        if subnormal:
            figure(f"{name}, bound without subnormal operands", bound.normal, "instructions")
        count, used = counts.get(name, (0, 0))
        if count:
            figure(f"{name}, largest count", count, "instructions")
            figure(f"{name}, bound over count", f"{bound.any / count:.2f}")
        figure(f"{name}, stack bound", depth, "bytes")
        if count:
            figure(f"{name}, stack used", used, "bytes")
        if count > bound.any or used > depth:
            wrong.append(f"{processor}: {name} is above its bound")
    for name, count in library.items():
        if name in instructions.reached:
            figure(f"{name}, largest count instead of a bound", count, "instructions")
    return rows, wrong


def _counts(text: str) -> Counts:
    rows = (row.split("\t") for row in text.splitlines() if row.startswith("count\t"))
    return {name: (int(instructions), int(stack)) for _, name, instructions, stack in rows}


def _main() -> int:
    try:
        rows, wrong = figures(sys.argv[1], [Path(word) for word in sys.argv[2:]])
    except UnboundedError as error:
        rows, wrong = [], [f"{sys.argv[1]}: {error}"]
    print("\n".join(rows))
    print("\n".join(wrong), file=sys.stderr, end="")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(_main())
