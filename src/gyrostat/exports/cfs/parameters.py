"""Table of the parameters: values, accepted ranges, and the C that validates them."""

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.module import Port
from gyrostat.codegen.flight.structs import Leaf, Struct
from gyrostat.codegen.program import Number
from gyrostat.control import FieldLimits
from gyrostat.control.measurement_guard import UNLIMITED
from gyrostat.core.jax64 import jax
from gyrostat.core.validation import SMALLEST
from gyrostat.exports.message_fields import leaves

FACTOR = 10.0
"""Largest factor between an accepted parameter and the designed one."""


@dataclass(frozen=True)
class Parameter:
    """Number or array of the table.

    Attributes:
        name: Path in the table, such as "controller.law.proportional".
        leaf: Type.
        meaning: Description.
        value: Designed value, an array of the shape of the type.
        lower: Smallest accepted value of every element.
        upper: Largest accepted value of every element.
        above: Name of the parameter that must be below this one; "" if there is none.
    """

    name: str
    leaf: Leaf
    meaning: str
    value: np.ndarray
    lower: float
    upper: float
    above: str = ""


def parameters_of(ports: Mapping[str, Port], values: Mapping[str, Any]) -> list[Parameter]:
    """Parameters of a flight module, in the order of the table.

    Args:
        ports: Name -> argument of the module in C; without arguments that contain no numbers.
        values: Name -> designed value.
    """
    return [p for name, port in ports.items() for p in _of_port(name, port.content, values[name])]


def _of_port(name: str, content: Leaf | Struct, value: Any) -> Iterator[Parameter]:
    arrays = [np.asarray(leaf) for leaf in jax.tree.leaves(value)]
    roles = jax.tree.leaves(
        jax.tree.map(_roles, value, is_leaf=lambda part: isinstance(part, FieldLimits))
    )
    kept = [(array, role) for array, role in zip(arrays, roles, strict=True) if array.size]
    places = leaves(content, name)
    for (path, leaf, meaning), (array, role) in zip(places, kept, strict=True):
        lower, upper = _range(array, role)
        above = f"{path.rpartition('.')[0]}.lower" if role == "upper" else ""
        yield Parameter(path, leaf, meaning, array.reshape(leaf.shape), lower, upper, above)


def _roles(part: Any) -> Any:
    """Role of each leaf: the name of its field in limits of a measurement, otherwise ""."""
    if not isinstance(part, FieldLimits):
        return ""
    named = part._asdict().items()
    return FieldLimits(*(jax.tree.map(lambda _, n=name: n, limit) for name, limit in named))


def _range(value: np.ndarray, role: str) -> tuple[float, float]:
    """Accepted values of every element.

    A number may change by a factor of `FACTOR` and keeps its sign; zero stays zero, and a number
    that is infinite by design may have any value of its sign. The elements of
    an array whose signs differ, or that contains zeros, may have that factor of the largest. An
    integer keeps its value, a logical value may change. Limits of measurements may have any value.
    """
    if value.dtype.kind == "b":
        return 0.0, 1.0
    if value.dtype.kind == "i":
        return float(value.min()), float(value.max())
    if role in ("lower", "upper"):
        return -UNLIMITED, UNLIMITED
    if role == "rate":
        return SMALLEST, UNLIMITED
    least, most = float(value.min()), float(value.max())
    if least > 0.0:
        return (SMALLEST if np.isinf(least) else least / FACTOR), most * FACTOR
    if most < 0.0:
        return least * FACTOR, (-SMALLEST if np.isinf(most) else most / FACTOR)
    size = FACTOR * max(-least, most)
    return -size + 0.0, size


def check_lines(parameters: list[Parameter], dialect: Dialect) -> list[str]:
    """C that sets `Fault` to the name of the first parameter of `Table` that is out of range."""
    lines = []
    by_name = {p.name: p for p in parameters}
    for p in parameters:
        given = f'Fault, "{p.name}", {_address(p)}, {p.value.size}U'
        limits = f"{_number(p.lower, p.leaf, dialect)}, {_number(p.upper, p.leaf, dialect)}"
        if p.leaf.kind == "logical":
            lines += _wrapped(f"Fault = Logical({given});")
        else:
            check = "Within" if p.leaf.kind == "real" else "WithinIntegers"
            lines += _wrapped(f"Fault = {check}({given}, {limits});")
        if p.above:
            lower = by_name[p.above]
            lines += _wrapped(f"Fault = Ordered({given}, {_address(lower)}, {lower.value.size}U);")
    return lines


def _address(p: Parameter) -> str:
    return f"&Table->{p.name}{''.join('[0]' for _ in p.leaf.shape)}"


def _number(value: float, leaf: Leaf, dialect: Dialect) -> str:
    kind = "integer" if leaf.kind == "integer" else "real"
    return dialect.number(Number(kind, int(value) if kind == "integer" else value)).text


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(
        text,
        100,
        initial_indent="    ",
        subsequent_indent="        ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def initial_values(ports: Mapping[str, Port], values: Mapping[str, Any], dialect: Dialect) -> str:
    """Initial values of the table in C, with the descriptions of the fields."""
    lines: list[str] = []

    def add(content: Leaf | Struct, name: str, numbers: Iterator[np.ndarray], depth: int) -> None:
        indent = "    " * depth
        if isinstance(content, Struct):
            lines.append(f"{indent}.{name} = {{")
            for member in content.members:
                add(member.content, member.name, numbers, depth + 1)
            lines.append(f"{indent}}},")
            return
        text = _elements(next(numbers).reshape(content.shape), content, dialect)
        lines.extend(
            textwrap.wrap(
                f".{name} = {text},", 100, initial_indent=indent, subsequent_indent=f"{indent}    "
            )
        )

    for name, port in ports.items():
        arrays = (np.asarray(leaf) for leaf in jax.tree.leaves(values[name]))
        add(port.content, name, iter([a for a in arrays if a.size]), 1)
    return "\n".join(lines)


def _elements(value: np.ndarray, leaf: Leaf, dialect: Dialect) -> str:
    if value.ndim:
        return f"{{{', '.join(_elements(part, leaf, dialect) for part in value)}}}"
    return dialect.number(Number(leaf.kind, value.item())).text
