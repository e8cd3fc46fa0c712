"""Check program for emitted C: compares a run, step by step, with Python."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.header import declaration
from gyrostat.codegen.flight.module import Entry, Module, Port, Precision, call
from gyrostat.codegen.flight.structs import Struct, scalars
from gyrostat.codegen.program import Number
from gyrostat.core.jax64 import jax
from gyrostat.exports.target import STEPS, Target
from gyrostat.exports.template import filled

TOLERANCE = {"double": 1e-12, "float": 1e-3}
"""Largest error of an output, relative to its largest value in the run."""
ROUNDING = {"double": 2.0**-47, "float": 2.0**-18}
"""Error that is allowed too, relative to the largest value of its array: 32 units in the last
place. An element, as of a covariance, can be nothing but the rounding error of the others."""


def program(target: Target, module: Module, precision: Precision) -> tuple[str, str]:
    """Text of the test program, and its expected output."""
    dialect, double = Dialect(precision), Dialect()
    ports = {port.name: port for every in module.ports.values() for port in every}
    run = target.run()
    outputs = list(run[0])
    texts = _texts(ports, outputs)
    names = [text.strip("(*)") for text in texts]
    input_rows = np.array([_row(target.inputs, k) for k in range(STEPS)])
    expected = np.array([[x for name in outputs for x in _numbers(step[name])] for step in run])
    share = ROUNDING[precision] / TOLERANCE[precision]
    scale = np.array([x for name in outputs for x in _scales([step[name] for step in run], share)])

    def calls(entries: Sequence[Entry], indent: str) -> str:
        return "\n".join(f"{indent}status |= {call(module, e.name)};" for e in entries)

    inputs = (f"{text} = given[k][{n}];" for n, text in enumerate(_texts(ports, target.inputs)))
    text = filled(
        "check.c",
        title=target.title,
        name=module.name,
        steps=STEPS,
        count=len(texts),
        tolerance=TOLERANCE[precision],
        given=_table("given", input_rows, dialect),
        expected=_table("expected", expected, double),
        scale=_table("scale", scale[None], double),
        names="\n".join(f'    "{name}",' for name in names),
        declared="\n".join(f"    {definition(p, target, dialect)}" for p in ports.values()),
        begin=calls(target.begin, "    "),
        inputs="\n".join(f"        {line}" for line in inputs),
        calls=calls(target.steps, "        "),
        seen="\n".join(f"            (double)({text})," for text in texts),
    )
    return text, "".join(f"{name}: as in Python\n" for name in names)


def _texts(ports: dict[str, Port], names: Any) -> list[str]:
    """C expressions for the numbers of some arguments."""
    return [
        scalar.hint
        for name in names
        for array in scalars(ports[name].content, name, pointer=False)
        for scalar in array.flat
    ]


def _numbers(tree: Any) -> list[float]:
    return [float(x) for leaf in jax.tree.leaves(tree) for x in np.ravel(leaf)]


def _scales(trees: Sequence[Any], share: float) -> Iterator[float]:
    """Largest finite value of each number in the run; at least a share of that of its array."""
    for arrays in zip(*map(jax.tree.leaves, trees), strict=True):
        every = np.abs(np.array(arrays, dtype=float)).reshape(len(arrays), -1)
        tiny = float(np.finfo(np.float32).tiny)
        largest = np.max(every, axis=0, where=np.isfinite(every), initial=tiny)
        yield from np.maximum(largest, share * np.max(largest, initial=tiny)).tolist()


def _row(inputs: Any, step: int) -> list[float]:
    trees = (jax.tree.map(lambda x: x[step], tree) for tree in inputs.values())
    return [x for tree in trees for x in _numbers(tree)]


def _table(name: str, rows: np.ndarray, dialect: Dialect) -> str:
    head = f"static const {dialect.real} {name}[{rows.shape[0]}][{rows.shape[1]}] = {{"
    texts = (", ".join(dialect.number(Number("real", x)).text for x in row) for row in rows)
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
