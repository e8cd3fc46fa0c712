"""Operation count of an emitted function."""

from collections import Counter
from collections.abc import Mapping

from gyrostat.codegen.flight.tested_sums import TESTED_ADD, TESTED_AND, TESTED_FINITE
from gyrostat.codegen.program import Assign, Block, Branch, Call, Function, Loop

CLASSES: Mapping[str, tuple[str, ...]] = {
    "additions, multiplications": ("add", TESTED_ADD, "sub", "mul", "neg"),
    "divisions, roots": ("div", "quotient", "remainder", "sqrt", "cbrt"),
    "comparisons, choices": (
        *("lt", "le", "gt", "ge", "eq", "ne", "and", TESTED_AND, "or", "not", "xor", "select"),
        *("shift_left", "shift_right"),
        *("max", "min", "sign", "abs", "finite", TESTED_FINITE),
        *("floor", "ceil", "rint", "round"),
    ),
}
ELEMENTARY = "elementary functions"
_CLASS_OF = {operation: name for name, members in CLASSES.items() for operation in members}
_FREE = ("element", "to_real", "to_integer")


def operations(function: Function, *, one_pass: bool = False) -> Counter[str]:
    """Operation count of one call, by class.

    Args:
        function: Function of an emitted module.
        one_pass: Whether a loop that may end early is counted as one pass; otherwise with all its
            passes.
    """
    return _of(function.body, one_pass)


def _of(block: Block, one_pass: bool) -> Counter[str]:
    total: Counter[str] = Counter()
    for statement in block:
        match statement:
            case Assign(operation=operation):
                if operation not in _FREE:
                    total[_CLASS_OF.get(operation, ELEMENTARY)] += 1
            case Loop(count=count, test=test, body=body, goes_on=goes_on):
                times = 1 if one_pass and goes_on is not None else count
                for name, number in (_of(test, one_pass) + _of(body, one_pass)).items():
                    total[name] += times * number
            case Branch(blocks=blocks):
                most: Counter[str] = Counter()
                for inner in blocks:
                    most |= _of(inner, one_pass)  # largest count of each class
                total += most
            case Call(function=function):
                total += _of(function.body, one_pass)
    return total
