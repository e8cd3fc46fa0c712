"""Rules for loops and branches."""

import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from gyrostat.codegen.builder import Builder
from gyrostat.codegen.data import Data
from gyrostat.codegen.jax_versions import scan_counts
from gyrostat.codegen.primitives import Scalars, one_by_one
from gyrostat.codegen.program import (
    Assign,
    Block,
    Branch,
    Carried,
    Loop,
    Name,
    Number,
    Operand,
    Store,
    Table,
)
from gyrostat.codegen.source import refusal

UNBOUNDED = 2**62
"""Number of passes of a loop that is bounded only by its test."""


def argument_name(closed: Any, number: int) -> str:
    """Name of an argument in Python, as a C identifier."""
    names = getattr(getattr(closed.jaxpr, "debug_info", None), "arg_names", None) or ()
    name = names[number] if number < len(names) else ""
    return re.sub(r"\W+", "_", str(name or "")).strip("_")


def is_rows(array: Scalars | Data) -> bool:
    """Whether an array stands for the rows of a long scan."""
    return not isinstance(array, Data) and array.shape == () and isinstance(array.item(), Table)


def _carried_names(build: Builder, body: Any, fixed: int, count: int) -> list[Scalars]:
    """Names of the variables carried by a loop: those of its body's arguments, if known."""
    return [
        build.names(atom, argument_name(body, fixed + k) or None)
        for k, atom in enumerate(build.equation.outvars[:count])
    ]


def _inner(
    build: Builder, closed: Any, inputs: list[Scalars | Data], block: Block
) -> list[Scalars]:
    """Lower the body of a loop or branch; return its results. Rows of a long scan are refused."""
    results = [build.scalars(array) for array in build.lower(closed, inputs, block)]
    if any(is_rows(array) for array in results):
        raise refusal(
            build.where,
            f"rows of a scan of more than {build.scope.longest} passes inside a loop or branch",
            "them only as a result",
        )
    return results


def _row(build: Builder, body: Block, rows: Scalars | Data, index: Operand, atom: Any) -> Scalars:
    """Row of a table at an index. The table is built before the loop; its body reads the row."""
    names = build.names(atom)
    if not names.size:
        return names
    table, first, (width, *strides) = build.table(rows)
    inside = build.inside(body)
    for column, name in np.ndenumerate(names):
        offset = first + sum(k * stride for k, stride in zip(column, strides, strict=True))
        position: Operand = index
        if width != 1:
            position = inside.compute("mul", index, Number("integer", width), hint="index")
        names[column] = inside.element(table, position, offset, name)
    return names


def _scan(build: Builder, *operands: Scalars | Data) -> Sequence[Scalars]:
    params, where = build.params, build.where
    constants, carries = scan_counts(params)
    body_jaxpr, count = params["jaxpr"], params["length"]
    split = constants + carries
    fixed, rows = operands[:constants], operands[split:]
    first = [build.scalars(array) for array in operands[constants:split]]
    results = build.equation.outvars
    if count == 0:
        return [*first, *(np.empty(atom.aval.shape, object) for atom in results[carries:])]
    counter = Name("integer", "pass", next(build.groups))
    carried = _carried_names(build, body_jaxpr, constants, carries)
    body: Block = []
    index: Operand = counter
    if params["reverse"]:
        index = Name("integer", "backward", next(build.groups))
        body.append(Assign(index, "sub", (Number("integer", count - 1), counter), where))
    elements = [
        _row(build, body, array, index, atom)
        for array, atom in zip(rows, body_jaxpr.jaxpr.invars[split:], strict=True)
    ]
    outputs = _inner(build, body_jaxpr, [*fixed, *carried, *elements], body)
    tables = []
    as_tables = count > build.scope.longest
    for array, atom in zip(outputs[carries:], results[carries:], strict=True):
        table = Table(build.scope.kind(atom), count * array.size, where.name, as_tables)
        tables.append(table)
        for offset, value in enumerate(array.flat):
            body.append(Store(table, index, array.size, offset, value, where))
    variables = _loop_variables(carried, first, outputs[:carries])
    build.block.append(Loop(count, counter, variables, body, [], None, tables, where))
    if as_tables:
        return [*carried, *(np.array(table, dtype=object) for table in tables)]
    arrays = []
    for table, atom in zip(tables, results[carries:], strict=True):
        names: Any = build.names(atom)
        for offset, name in enumerate(names.flat):
            build.element(table, Number("integer", 0), offset, name)
        arrays.append(names)
    return [*carried, *arrays]


def _loop_variables(
    names: Sequence[Scalars], first: Sequence[Scalars], last: Sequence[Scalars]
) -> list[Carried]:
    return [
        Carried(*each)
        for arrays in zip(names, first, last, strict=True)
        for each in zip(*(array.flat for array in arrays), strict=True)
    ]


def _while(build: Builder, *operands: Scalars | Data) -> Sequence[Scalars]:
    params = build.params
    split, fixed = params["cond_nconsts"], params["body_nconsts"]
    test_fixed, body_fixed = operands[:split], operands[split:][:fixed]
    first = [build.scalars(array) for array in operands[split + fixed :]]
    carried = _carried_names(build, params["body_jaxpr"], fixed, len(first))
    test: Block = []
    rows = _inner(build, params["cond_jaxpr"], [*test_fixed, *carried], test)[0]
    goes_on = build.inside(test).fold("or", list(rows.flat))
    body: Block = []
    results = _inner(build, params["body_jaxpr"], [*body_fixed, *carried], body)
    if rows.ndim > 0:  # of a batch: a row that has ended stays as it is
        results = [
            _update_rows(build.inside(body), rows, *pair)
            for pair in zip(results, carried, strict=True)
        ]
    variables = _loop_variables(carried, first, results)
    count = _bound(goes_on, test, variables, body)
    if count is None and build.scope.unbounded:
        count = UNBOUNDED
    if count is None:
        raise build.refused(
            "a loop without a bound",
            "a test that ends with `& (number < BOUND)`, where number starts at a constant and "
            "grows by 1",
        )
    counter = Name("integer", "pass", next(build.groups))
    build.block.append(Loop(count, counter, variables, body, test, goes_on, [], build.where))
    return carried


def _update_rows(build: Builder, rows: Scalars, after: Scalars, before: Scalars) -> Scalars:
    """Values after a pass in the rows of a batch that go on, and those before it in the others."""
    mask = np.broadcast_to(rows.reshape(rows.shape + (1,) * (after.ndim - rows.ndim)), after.shape)
    return one_by_one(after.shape, partial(build.compute, "select"), mask, after, before)


def _bound(goes_on: Operand, test: Block, carried: list[Carried], body: Block) -> int | None:
    """Largest number of passes, from a part `counter < constant` of the test; None if unbounded."""
    assigned = {s.target: s for s in (*test, *body) if isinstance(s, Assign)}
    counters = {
        c.name: c.first.value
        for c in carried
        if isinstance(c.first, Number) and c.name.kind == "integer" and _grows(c, assigned)
    }
    parts, bounds = [goes_on], []
    while parts:
        statement = assigned.get(parts.pop())  # pyright: ignore[reportArgumentType]
        if statement is None:
            continue
        if statement.operation == "and":
            parts += statement.operands
            continue
        operands = statement.operands
        if statement.operation in ("gt", "ge"):
            operands = operands[::-1]
        elif statement.operation not in ("lt", "le"):
            continue
        low, high = operands
        if low in counters and isinstance(high, Number):
            inclusive = statement.operation in ("le", "ge")
            bounds.append(max(int(high.value) + inclusive - int(counters[low]), 0))
    return min(bounds, default=None)


def _grows(carried: Carried, assigned: dict[Name, Assign]) -> bool:
    """Whether each pass adds 1 to the carried variable."""
    step = assigned.get(carried.next)  # pyright: ignore[reportArgumentType]
    if step is None or step.operation != "add":
        return False
    return set(step.operands) == {carried.name, Number("integer", 1)}


def _cond(
    build: Builder, selector: Scalars | Data, *operands: Scalars | Data
) -> Sequence[Scalars | Data]:
    index, branches = build.scalars(selector).item(), build.params["branches"]
    if isinstance(index, Number):
        number = min(max(int(index.value), 0), len(branches) - 1)
        return build.lower(branches[number], operands, build.block)
    targets = [build.names(atom) for atom in build.equation.outvars]
    blocks: list[Block] = []
    values: list[list[Operand]] = []
    for branch in branches:
        inner: Block = []
        results = _inner(build, branch, [*operands], inner)
        blocks.append(inner)
        values.append([scalar for array in results for scalar in array.flat])
    flat: list[Any] = [name for array in targets for name in array.flat]
    for statement in build.block:
        # jax.lax.cond converts its condition to a number
        if isinstance(statement, Assign) and statement.target is index:
            if statement.operation == "to_integer":
                index = statement.operands[0]
            break
    build.block.append(Branch(index, blocks, values, flat, build.where))
    return targets


def _linear_solve(build: Builder, *operands: Scalars | Data) -> Sequence[Scalars | Data]:
    """Solution of linear equations: the function that solves them, without its derivatives."""
    counts, functions = build.params["const_lengths"], build.params["jaxprs"]
    start = counts.matvec + counts.vecmat
    constants, right = operands[start : start + counts.solve], operands[sum(counts) :]
    return build.lower(functions.solve, [*constants, *right], build.block, build.where)


RULES: dict[str, Callable[..., Sequence[Scalars | Data]]] = {
    "cond": _cond,
    "custom_linear_solve": _linear_solve,
    "scan": _scan,
    "while": _while,
}
"""Primitive -> (builder, operands) -> results."""
