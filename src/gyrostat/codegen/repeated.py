"""Equations of a jaxpr that repeat earlier ones."""

from typing import Any, NamedTuple

import numpy as np

from gyrostat.codegen.tracing import constant


class Distinct(NamedTuple):
    """Equations of a jaxpr without those that repeat an earlier one.

    Attributes:
        equations: Equations that are left.
        same: Variable of a repeated equation -> variable of the earlier one.
    """

    equations: list[Any]
    same: dict[Any, Any]

    def first(self, atom: Any) -> Any:
        """The variable that has the value of an atom, or the literal."""
        return atom if constant(atom) is not None else self.same.get(atom, atom)


def distinct(jaxpr: Any) -> Distinct:
    """Leave out equations with the operation, parameters and operands of an earlier one."""
    known: dict[Any, Any] = {}
    result = Distinct([], {})
    for equation in jaxpr.eqns:
        key = _key(equation, result)
        earlier = None if key is None else known.setdefault(key, equation)
        if earlier is None or earlier is equation:
            result.equations.append(equation)
        else:
            result.same.update(zip(equation.outvars, earlier.outvars, strict=True))
    return result


def _key(equation: Any, so_far: Distinct) -> Any:
    """Key that is equal for equations with equal results; None if parameters have no hash."""
    operands = []
    for atom in equation.invars:
        value = constant(atom)
        array = None if value is None else np.asarray(value)
        operands.append(
            so_far.first(atom)
            if array is None
            else (str(array.dtype), array.shape, array.tobytes())
        )
    params = equation.params
    key = (
        equation.primitive,
        tuple(operands),
        tuple(sorted(params)),
        tuple(params[name] for name in sorted(params)),
    )
    try:
        hash(key)
    except TypeError:
        return None
    return None if equation.effects else key
