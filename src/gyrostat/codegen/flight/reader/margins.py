"""Operations of C on arrays of lanes that also give the margins of logical values.

The margin of a comparison is the difference of its operands, positive if it is true: the number
that a search brings to the other sign. Margins of && and || are those of robust semantics, the
smallest and the largest of the operands (Fainekos, Pappas: Robustness of temporal logic
specifications for continuous-time signals, Theoretical Computer Science 410, 2009).
"""

from typing import Any

import numpy as np

from gyrostat.codegen.flight.reader.arithmetic import (
    OPERATIONS,
    Lanes,
    bits_of_real,
    element,
    pick,
    put,
    real_of_bits,
)

LARGEST = 1e300
"""Margin of a comparison with NaN, or of a value that is given as true or false."""


class Logic:
    """Logical values with their margins.

    Attributes:
        value: Whether it is true.
        margin: Margin, positive if it is true; zero is either.
    """

    __slots__ = ("margin", "value")

    def __init__(self, value: Lanes, margin: Lanes) -> None:
        self.value = value
        self.margin = margin


def logic(value: Lanes) -> Logic:
    """Logical values with a margin of 1."""
    return Logic(value, np.where(value, 1.0, -1.0))


YES, NO = Logic(True, 1.0), Logic(False, -1.0)


def as_logic(value: Any) -> Logic:
    """Value as logical one."""
    return value if isinstance(value, Logic) else logic(value)


def value_of(value: Any) -> Lanes:
    """Value without a margin."""
    return value.value if isinstance(value, Logic) else value


class Comparisons:
    """Comparisons with margins in units of the typical difference of their operands.

    Attributes:
        scales: Name of a comparison -> typical difference, from the first run that evaluates it.
    """

    def __init__(self) -> None:
        self.scales: dict[str, float] = {}

    def operations(self) -> dict[str, Any]:
        """Name in translated code -> comparison."""
        return {
            "lt": self._below(np.less, lambda a, b: np.subtract(b, a, dtype=float)),
            "le": self._below(np.less_equal, lambda a, b: np.subtract(b, a, dtype=float)),
            "gt": self._below(np.greater, lambda a, b: np.subtract(a, b, dtype=float)),
            "ge": self._below(np.greater_equal, lambda a, b: np.subtract(a, b, dtype=float)),
            "eq": lambda a, b, name: negated(self._differs(a, b, name)),
            "ne": self._differs,
        }

    def _below(self, value: Any, margin: Any) -> Any:
        def compare(a: Lanes, b: Lanes, name: str) -> Logic:
            return self._signed(value(a, b), np.fmax(margin(a, b), -LARGEST), name)

        return compare

    def _differs(self, a: Any, b: Any, name: str) -> Logic:
        if isinstance(a, Logic) or isinstance(b, Logic):
            a, b = as_logic(a), as_logic(b)
            return either(both(a, negated(b)), both(negated(a), b))
        margin = np.fmin(np.abs(np.subtract(a, b, dtype=float)), LARGEST)
        return self._signed(np.not_equal(a, b), margin, name)

    def _signed(self, value: Lanes, margin: Lanes, name: str) -> Logic:
        """Logical values; of equal operands with the largest margin, so that none is aimed at."""
        if name not in self.scales:
            sizes = np.abs(np.ravel(margin))
            sizes = sizes[(sizes > 0.0) & (sizes < LARGEST)]
            self.scales[name] = float(np.median(sizes)) if len(sizes) else 1.0
        margin = margin / self.scales[name]
        return Logic(value, np.where(margin == 0.0, np.where(value, LARGEST, -LARGEST), margin))


def negated(a: Any) -> Logic:
    """Negation."""
    a = as_logic(a)
    return Logic(np.logical_not(a.value), -a.margin)


def both(a: Any, b: Any) -> Logic:
    """Conjunction."""
    a, b = as_logic(a), as_logic(b)
    return Logic(np.logical_and(a.value, b.value), np.minimum(a.margin, b.margin))


def either(a: Any, b: Any) -> Logic:
    """Disjunction."""
    a, b = as_logic(a), as_logic(b)
    return Logic(np.logical_or(a.value, b.value), np.maximum(a.margin, b.margin))


def _pick(lanes: Lanes, new: Any, old: Any, path: Any = None) -> Any:
    if old is None or not (isinstance(new, Logic) or isinstance(old, Logic)):
        return pick(lanes, new, old)
    new, old = as_logic(new), as_logic(old)
    value = pick(lanes, new.value, old.value)
    if path is None:
        return Logic(value, pick(lanes, new.margin, old.margin))
    taken = Logic(lanes, path)
    return Logic(value, either(both(taken, new), both(negated(taken), old)).margin)


def _choose(test: Any, yes: Any, no: Any) -> Any:
    return _pick(value_of(test), yes, no)


def _plain(array: Any) -> Any:
    if isinstance(array, list):
        return [_plain(each) for each in array]
    return value_of(array)


def _element(array: Any, indices: Any) -> Any:
    found = element(_plain(array), indices)
    return logic(found) if np.asarray(found).dtype == bool else found


def _put(array: list[Any], indices: Any, lanes: Lanes, value: Any) -> None:
    plain = _plain(array)
    put(plain, indices, lanes, value_of(value))
    _copy(plain, array)


def _copy(plain: list[Any], array: list[Any]) -> None:
    for k, each in enumerate(plain):
        if isinstance(each, list):
            _copy(each, array[k])
        else:
            array[k] = logic(each) if each.dtype == bool else each


def _alternative(value: Any, test: Any, yes: Any, no: Any) -> Logic:
    """Comparison with the margin of a choice between comparisons."""
    margin = either(both(test, yes), both(negated(test), no)).margin
    return Logic(as_logic(value).value, margin)


def _is_finite(x: Any) -> Logic:
    """Finiteness, with the share of the exponents that are left up to infinity as the margin."""
    x = np.asarray(value_of(x))
    value, largest = np.isfinite(x), np.log(np.finfo(x.dtype).max)
    size = np.maximum(np.abs(np.where(value, x, 1.0)), 1.0)
    return Logic(value, np.where(value, 1.0 - np.log(size) / (1.001 * largest), -1.0))


def _path_and(path: Any, test: Any) -> Any:
    margin = as_logic(test).margin
    return margin if path is None else np.minimum(path, margin)


def _path_left(path: Any, inner: Any) -> Any:
    """Margin of a path on which a branch that leaves was not taken."""
    return np.negative(inner) if path is None else np.minimum(path, np.negative(inner))


MARGINS: dict[str, Any] = {  # and those of `Comparisons`
    **OPERATIONS,
    "both": both,
    "either": either,
    "negated": negated,
    "yes": YES,
    "no": NO,
    "alternative": _alternative,
    "choose": _choose,
    "pick": _pick,
    "element": _element,
    "put": _put,
    "is_finite": _is_finite,
    "bits_of_real": bits_of_real,
    "real_of_bits": real_of_bits,
    "real": lambda x: np.asarray(value_of(x), float),
    "single": lambda x: np.asarray(value_of(x), np.float32),
    "whole": lambda x: np.asarray(value_of(x)).astype(np.int64),
    "word": lambda x: np.asarray(value_of(x)).astype(np.uint64),
    "lanes_and": lambda lanes, test: np.logical_and(lanes, value_of(test)),
    "lanes_and_not": lambda lanes, test: lanes & np.logical_not(value_of(test)),
    "path_and": _path_and,
    "path_and_not": lambda path, test: _path_and(path, negated(test)),
    "path_left": _path_left,
    # what the other side would compute is wanted too
    "some": lambda lanes: True,
}
"""Operations that give values and margins."""
