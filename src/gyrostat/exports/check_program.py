"""Check program for emitted C: compares a run, step by step, with Python."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.module import Entry, Module, Port, Precision, by_address
from gyrostat.codegen.flight.structs import Leaf, Struct, scalars
from gyrostat.codegen.program import Number
from gyrostat.core.jax64 import jax
from gyrostat.exports.targets import STEPS, Target

TOLERANCE = {"double": 1e-12, "float": 1e-3}
"""Largest error of an output, over the largest value that it takes in the run."""


PROGRAM = """\
/* {title}: {steps} steps against the results of Python. */
#include "{name}.h"

#include <math.h>
#include <stdio.h>

{given}
{expected}
{scale}
static const char *const name[{count}] = {{
{names}
}};

int main(int arguments, char **argument)
{{
    double worst[{count}] = {{0.0}};
    int status = 0;
{declared}
    (void)argument;
{begin}
    for (int k = 0; k < {steps}; ++k) {{
{inputs}
{calls}
        const double seen[{count}] = {{
{seen}
        }};
        for (int n = 0; n < {count}; ++n) {{
            const double error = fabs(seen[n] - expected[k][n]) / scale[0][n];
            if (!(error <= worst[n])) {{ worst[n] = error; }} /* NaN is the worst */
        }}
    }}
    for (int n = 0; n < {count}; ++n) {{
        const int fine = worst[n] <= {tolerance!r};
        status |= !fine;
        if (arguments > 1) {{
            printf("%s %.1e\\n", name[n], worst[n]);
        }} else {{
            printf("%s: %s\\n", name[n], fine ? "as in Python" : "not as in Python");
        }}
    }}
    return status;
}}
"""


def program(target: Target, module: Module, precision: Precision) -> tuple[str, str]:
    """Text of the test program, and what it prints where all is well."""
    dialect, double = Dialect(precision), Dialect()
    ports = {port.name: port for every in module.ports.values() for port in every}
    made = target.run()
    outputs = list(made[0])
    seen = _texts(ports, outputs)
    names = [text.strip("(*)") for text in seen]
    given = np.array([_row(target.inputs, k) for k in range(STEPS)])
    expected = np.array([[x for name in outputs for x in _numbers(step[name])] for step in made])
    finite = np.where(np.isfinite(expected), np.abs(expected), 0.0)
    scale = np.maximum(np.max(finite, axis=0), np.finfo(np.float32).tiny)

    def calls(entries: Sequence[Entry], indent: str) -> str:
        return "\n".join(f"{indent}status |= {_called(module, e.name)};" for e in entries)

    inputs = (f"{text} = given[k][{n}];" for n, text in enumerate(_texts(ports, target.inputs)))
    text = PROGRAM.format(
        title=target.title,
        name=module.name,
        steps=STEPS,
        count=len(seen),
        tolerance=TOLERANCE[precision],
        given=_table("given", given, dialect),
        expected=_table("expected", expected, double),
        scale=_table("scale", scale[None], double),
        names="\n".join(f'    "{name}",' for name in names),
        declared="\n".join(f"    {_declared(p, target, dialect)}" for p in ports.values()),
        begin=calls(target.begin, "    "),
        inputs="\n".join(f"        {line}" for line in inputs),
        calls=calls(target.steps, "        "),
        seen="\n".join(f"            (double)({text})," for text in seen),
    )
    return text, "".join(f"{name}: as in Python\n" for name in names)


def _texts(ports: dict[str, Port], names: Any) -> list[str]:
    """How C reaches the numbers of some arguments."""
    return [
        scalar.hint
        for name in names
        for array in scalars(ports[name].content, name, pointer=False)
        for scalar in array.flat
    ]


def _numbers(tree: Any) -> list[float]:
    return [float(x) for leaf in jax.tree.leaves(tree) for x in np.ravel(leaf)]


def _row(inputs: Any, step: int) -> list[float]:
    trees = (jax.tree.map(lambda x: x[step], tree) for tree in inputs.values())
    return [x for tree in trees for x in _numbers(tree)]


def _table(name: str, rows: np.ndarray, dialect: Dialect) -> str:
    head = f"static const {dialect.real} {name}[{rows.shape[0]}][{rows.shape[1]}] = {{"
    texts = (", ".join(dialect.number(Number("real", x)).text for x in row) for row in rows)
    return "\n".join([head, *(f"    {{{text}}}," for text in texts), "};"])


def _declared(port: Port, target: Target, dialect: Dialect) -> str:
    content = port.content
    if isinstance(content, Struct):
        return f"{content.name} {port.name};"
    size = "".join(f"[{count}]" for count in content.shape)
    value = target.constants.get(port.name)
    first = "{0}" if content.shape else "0"
    if value is not None:
        first = dialect.number(Number("real", float(value))).text
    return f"{dialect.type_of(content.kind)} {port.name}{size} = {first};"


def _called(module: Module, entry: str) -> str:
    ports: Sequence[Port] = module.ports[entry]
    given = [
        f"&{p.name}" if by_address(p) or not isinstance(p.content, Leaf) else p.name for p in ports
    ]
    return f"{entry}({', '.join(given)})"
