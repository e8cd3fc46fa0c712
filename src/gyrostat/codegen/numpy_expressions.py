"""Expressions of Python in place of functions of `numpy_rules`, of which a loop calls thousands."""

import math
from collections.abc import Callable
from typing import Any

from gyrostat.codegen.numpy_rules import same

OPERATORS = {
    **{"add": "{} + {}", "add_any": "{} + {}", "sub": "{} - {}", "neg": "-{}", "mul": "{} * {}"},
    **{"lt": "{} < {}", "le": "{} <= {}", "gt": "{} > {}", "ge": "{} >= {}"},
    **{"eq": "{} == {}", "ne": "{} != {}", "and": "{} & {}", "or": "{} | {}", "xor": "{} ^ {}"},
    **{"not": "~{}", "div": "{} / {}"},
}
"""Primitive with a rule -> its operator in Python, with numbers several times as fast as NumPy's
function."""


def expression(equation: Any, function: Callable[..., Any]) -> str | None:
    """Expression of Python in place of the function of a rule, or None: it is faster than a call.

    Args:
        equation: Equation.
        function: Function of its operands, by its rule.

    Returns:
        Text with a place in braces for each operand.
    """
    name, params, shape = equation.primitive.name, equation.params, equation.outvars[0].aval.shape
    if function is same:
        return "{}"
    if name == "transpose":
        return f"{{}}.transpose({params['permutation']})"
    if name == "select_n" and equation.invars[0].aval.shape == ():
        return "{2} if {0} else {1}"
    if name == "integer_pow" and params["y"] == 2:
        return "{0} * {0}"
    if name == "broadcast_in_dim" and equation.invars[0].aval.size == math.prod(shape) > 0:
        return f"{{}}.reshape({shape})" if shape else "{}"
    if name in ("reshape", "squeeze", "expand_dims"):
        first = ", ".join("0" for _ in equation.invars[0].aval.shape)
        return f"{{}}.reshape({shape})" if shape else f"{{}}[{first}]" if first else "{}"
    if name == "slice":
        bounds = zip(params["start_indices"], params["limit_indices"], strict=True)
        steps = params["strides"] or (1,) * len(shape)
        parts = (f"{a}:{b}:{c}" for (a, b), c in zip(bounds, steps, strict=True))
        return f"{{}}[{', '.join(parts)}]" if shape else "{}"
    return OPERATORS.get(name)
