"""Ranges of integers."""

from collections.abc import Callable, Sequence

Range = tuple[int, int]
"""Smallest and largest value."""
LARGEST = {"integer": 2**63 - 1, "index": 2**31 - 1}
"""Kind of number -> largest one; beyond it, numbers wrap around."""
EVERY: Range = (-(2**63), 2**63 - 1)
"""Range of any integer of 64 bits."""

ALWAYS: dict[str, Callable[[Range, Range], bool]] = {
    "lt": lambda a, b: a[1] < b[0],
    "le": lambda a, b: a[1] <= b[0],
    "gt": lambda a, b: a[0] > b[1],
    "ge": lambda a, b: a[0] >= b[1],
    "eq": lambda a, b: a[0] == a[1] == b[0] == b[1],
    "ne": lambda a, b: a[1] < b[0] or b[1] < a[0],
}
"""Comparison -> whether it is true for all values of two ranges; false if its opposite is."""
OPPOSITE = {"lt": "ge", "le": "gt", "gt": "le", "ge": "lt", "eq": "ne", "ne": "eq"}
"""Comparison -> the one that is true where it is false."""
MIRRORED = {"lt": "gt", "le": "ge", "gt": "lt", "ge": "le", "eq": "eq", "ne": "ne"}
"""Comparison -> the same with its operands exchanged."""
ARITHMETIC: dict[str, Callable[[Range, Range], tuple[int, ...]]] = {
    "add": lambda a, b: (a[0] + b[0], a[1] + b[1]),
    "sub": lambda a, b: (a[0] - b[1], a[1] - b[0]),
    "mul": lambda a, b: tuple(x * y for x in a for y in b),
    "max": lambda a, b: (max(a[0], b[0]), max(a[1], b[1])),
    "min": lambda a, b: (min(a[0], b[0]), min(a[1], b[1])),
    "remainder": lambda a, b: _remainders(a, max(map(abs, b))) if b[0] > 0 or b[1] < 0 else EVERY,
}
"""Operation -> numbers between which its results are."""
UNCHANGED: dict[str, Range] = {"to_word": (0, 2**32 - 1), "to_half": (-(2**31), 2**31 - 1)}
"""Narrowing of an integer -> its results, which are the integers that it does not change."""


def _remainders(dividend: Range, divisor: int) -> Range:
    """Range of remainders with the sign of the dividend, of a divisor of at most some size."""
    low, high = max(dividend[0], 1 - divisor), min(dividend[1], divisor - 1)
    return min(low, 0), max(high, 0)


def of_kind(range_: Range, kind: str) -> Range | None:
    """A range if the numbers of a kind have room for it; None if some wrap around."""
    largest = LARGEST[kind]
    return range_ if -largest <= range_[0] and range_[1] <= largest else None


def within(inner: Range | None, outer: Range) -> bool:
    """Whether a known range is inside another one."""
    return inner is not None and outer[0] <= inner[0] and inner[1] <= outer[1]


def narrowed(within: Range, operation: str, bound: Range) -> Range:
    """Range of the values of a range for which a comparison with another one can be true."""
    low, high = within
    match operation:
        case "lt":
            high = min(high, bound[1] - 1)
        case "le":
            high = min(high, bound[1])
        case "gt":
            low = max(low, bound[0] + 1)
        case "ge":
            low = max(low, bound[0])
        case "eq":
            low, high = max(low, bound[0]), min(high, bound[1])
    # the comparison is never true: any range will do
    return (low, high) if low <= high else within


def union(ranges: Sequence[Range | None]) -> Range | None:
    """Smallest range with all others; None if one of them is not known."""
    known = [each for each in ranges if each is not None]
    if len(known) < len(ranges):
        return None
    return min(low for low, _ in known), max(high for _, high in known)
