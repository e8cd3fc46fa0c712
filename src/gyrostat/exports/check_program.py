"""Test vectors and check program for emitted C: each step is compared with Python."""

from collections.abc import Callable, Sequence

import numpy as np

from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.header import declaration
from gyrostat.codegen.flight.module import Entry, Module, Port, Precision, call, ports_of
from gyrostat.codegen.flight.structs import Struct
from gyrostat.codegen.program import Kind, Number
from gyrostat.exports.target import STEPS, Target
from gyrostat.exports.template import filled
from gyrostat.exports.vectors.fields import Field, arrays_of
from gyrostat.exports.vectors.vectors import Vectors

TOLERANCE = {"double": 1e-12, "float": 1e-3}
"""Largest error of an output, relative to its largest value in the test run or, if this is larger,
to its value in the step."""
ROUNDING = {"double": 2.0**-47, "float": 2.0**-18}
"""Error that is allowed too, relative to the largest value of its array: 32 units in the last
place. An element, as of a covariance, can be nothing but the rounding error of the others."""


def check_files(
    target: Target, module: Module, precision: Precision, vectors: Vectors
) -> dict[str, str]:
    """Test vectors as CSV and as C, and the test program with its expected output."""
    outputs = output_fields(target, vectors.fields)
    names = [vectors.fields[k].name for k in outputs]
    name = module.name
    return {
        "vectors.csv": vectors.csv(),
        f"{name}_vectors.h": _vectors(target, module, Dialect(precision), vectors),
        f"{name}_test.c": filled(
            "check.c",
            title=target.title,
            name=name,
            rows=len(vectors.rows),
            count=len(names),
            tolerance=TOLERANCE[precision],
            expected=_table("expected", "VECTOR_ROWS", vectors.values[:, outputs]),
            scale=_table("scale", "1", scales(vectors, outputs, precision)[None]),
            first=_numbers(_arrays(vectors.fields, outputs)),
            share=f"{ROUNDING[precision] / TOLERANCE[precision]:.1e}",
            names="\n".join(f'    "{name}",' for name in names),
            seen="\n".join(f"            (double)vector.{name}," for name in names),
        ),
        "expected.txt": "".join(f"{name}: as in Python\n" for name in names),
    }


def output_fields(target: Target, fields: Sequence[Field]) -> list[int]:
    """Indices of the results of the functions that are called in every step."""
    results = list(dict.fromkeys(name for entry in target.steps for name in entry.results))
    return [k for name in results for k, field in enumerate(fields) if field.port == name]


def scales(vectors: Vectors, outputs: Sequence[int], precision: Precision) -> np.ndarray:
    """Number that the error of each output is divided by, if the output itself is smaller.

    It is the largest finite value in the test run, at least a share of that of its array, and
    more where the output is ill-conditioned.
    """
    share = ROUNDING[precision] / TOLERANCE[precision]
    tiny = float(np.finfo(np.float32).tiny)
    sizes = np.abs(vectors.values[:STEPS, outputs])
    largest = np.max(sizes, axis=0, where=np.isfinite(sizes), initial=tiny)
    for members in arrays_of([vectors.fields[k] for k in outputs]):
        largest[members] = np.maximum(largest[members], share * np.max(largest[members]))
    tolerance = TOLERANCE[precision]
    return np.maximum(
        largest, vectors.conditioning.allowed(outputs, largest, tolerance) / tolerance
    )


def _arrays(fields: Sequence[Field], outputs: Sequence[int]) -> list[int]:
    """For each output, the place of the first element of its array."""
    arrays = arrays_of([fields[k] for k in outputs])
    first = {place: members[0] for members in arrays for place in members}
    return [first[place] for place in range(len(outputs))]


_WHOLE = """\
/* as a real number, the largest integer is rounded up */
static int64_t vector_whole({real} value)
{{
    return (value < {limit}) ? (int64_t)value : INT64_MAX;
}}

"""


def _vectors(target: Target, module: Module, dialect: Dialect, vectors: Vectors) -> str:
    """Header with the test vectors."""
    inputs, fields = vectors.inputs, vectors.fields
    changes = [
        (number, k, value)
        for number, row in enumerate(vectors.rows)
        for k, value in row.changes.items()
        if k not in inputs
    ]
    changed = list(dict.fromkeys(k for _, k, _ in sorted(changes, key=lambda c: c[1])))
    given = np.array([[row.changes[k] for k in inputs] for row in vectors.rows])

    def number(value: float) -> str:
        return dialect.number(Number("real", value)).text

    def calls(entries: Sequence[Entry], indent: str) -> str:
        return "\n".join(f"{indent}status |= {call(module, e.name, 'vector.')};" for e in entries)

    def declared(name: str) -> str:
        return f"    {declaration(ports_of(module)[name].content, name, dialect)};"

    has_integers = any(fields[k].kind == "integer" for k in (*inputs, *changed))
    constants = [
        f"        vector.{name} = {number(float(value))};"
        for name, value in target.constants.items()
        if name in ports_of(module) and not isinstance(ports_of(module)[name].content, Struct)
    ]
    lines = [f"    {{{row}, {changed.index(k)}, {number(v)}}}," for row, k, v in changes]
    return filled(
        "vectors.h",
        title=target.title,
        name=module.name,
        guard=module.name.upper(),
        real=dialect.real,
        whole=_WHOLE.format(real=dialect.real, limit=number(2.0**63)) if has_integers else "",
        rows=len(vectors.rows),
        count=max(len(inputs), 1),
        declared="\n".join(map(declared, ports_of(module))),
        begins=_numbers([row.begins for row in vectors.rows]),
        given=_table("vector_input", "VECTOR_ROWS", given, dialect.real, number),
        changes=max(len(changes), 1),
        change="\n".join(lines or ["    {-1, -1, 0},"]),
        cases="\n".join(
            f"    case {n}: {_assignment(fields[k], 'value')} break;" for n, k in enumerate(changed)
        ),
        parameters=call(module, target.begin[0].name, "vector."),
        constants="\n".join(constants),
        begin=calls(target.begin[1:], "        "),
        inputs="\n".join(
            f"    {_assignment(fields[k], f'vector_input[row][{n}]')}" for n, k in enumerate(inputs)
        ),
        calls=calls(target.steps, "    "),
    )


def _assignment(field: Field, value: str) -> str:
    kinds: dict[Kind, str] = {"integer": f"vector_whole({value})", "logical": f"{value} > 0"}
    return f"vector.{field.name} = {kinds.get(field.kind, value)};"


def _numbers(numbers: Sequence[int]) -> str:
    texts = [str(int(number)) for number in numbers]
    lines = [texts[k : k + 20] for k in range(0, len(texts), 20)]
    return "\n".join(f"    {', '.join(line)}," for line in lines)


def _table(
    name: str,
    count: str,
    rows: np.ndarray,
    real: str = "double",
    number: Callable[[float], str] = lambda x: Dialect().number(Number("real", x)).text,
) -> str:
    head = f"static const {real} {name}[{count}][{max(rows.shape[1], 1)}] = {{"
    texts = (", ".join(map(number, row)) or "0" for row in rows.tolist())
    return "\n".join([head, *(f"    {{{text}}}," for text in texts), "};"])


def definition(port: Port, target: Target, dialect: Dialect) -> str:
    """Definition of a variable for an argument; a constant argument has its value."""
    text, content = declaration(port.content, port.name, dialect), port.content
    if isinstance(content, Struct):
        return f"{text};"
    value = target.constants.get(port.name)
    initial = "{0}" if content.shape else "0"
    if value is not None:
        initial = dialect.number(Number("real", float(value))).text
    return f"{text} = {initial};"
