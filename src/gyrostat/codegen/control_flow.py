"""Rules for loops and branches."""

import math
import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gyrostat.codegen.arrays import Array, Data
from gyrostat.codegen.assignment import set_tables
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.jax_versions import scan_counts
from gyrostat.codegen.nests import declared, filled, kind_of, placed, settled, store
from gyrostat.codegen.primitives import Scalars
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


def is_rows(array: Array) -> bool:
    """Whether an array stands for the rows of a long scan."""
    return isinstance(array, np.ndarray) and array.shape == () and isinstance(array.item(), Table)


class _Variables:
    """Arrays that a pass of a loop hands to the next: names of scalars, and tables.

    Attributes:
        arrays: The arrays, as the body of the loop reads them.
    """

    def __init__(self, build: Builder, body: Any, fixed: int, first: Sequence[Array]) -> None:
        self._first = [settled(build, array) for array in first]
        self.arrays: list[Array] = []
        for k, (atom, array) in enumerate(zip(build.equation.outvars, self._first, strict=False)):
            if array.size > build.scope.few:
                self.arrays.append(filled(build, array, changes=True))
            else:
                # the name of the argument of the body, if it is known
                self.arrays.append(build.names(atom, argument_name(body, fixed + k) or None))

    def carried(self, inside: Builder, after: Sequence[Array]) -> list[Carried]:
        """Scalars with their values for the next pass; tables are set at the end of the body.

        Args:
            inside: Builder of the body.
            after: Arrays after the pass.
        """
        carried: list[Carried] = []
        changes: list[tuple[Array, Data]] = []
        for name, first, new in zip(self.arrays, self._first, after, strict=True):
            if isinstance(name, Data):
                changes.append((new, name))
                continue
            assert isinstance(name, np.ndarray)
            assert isinstance(first, np.ndarray)
            each = zip(name.flat, first.flat, inside.scalars(new).flat, strict=True)
            carried += [Carried(*three) for three in each]
        set_tables(inside, changes)
        return carried

    def numbers(self, after: Sequence[Array]) -> list[Carried]:
        """Scalars that the body hands on, without those of tables and of deferred operations."""
        return [
            Carried(*three)
            for arrays in zip(self.arrays, self._first, after, strict=True)
            if all(isinstance(each, np.ndarray) for each in arrays)
            for three in zip(*(each.flat for each in arrays), strict=True)  # pyright: ignore[reportAttributeAccessIssue]
        ]


def _inner(build: Builder, closed: Any, inputs: list[Array], block: Block) -> list[Array]:
    """Lower the body of a loop or branch; return its results. Rows of a long scan are refused."""
    results = build.lower(closed, inputs, block)
    if any(is_rows(array) for array in results):
        raise refusal(
            build.where,
            f"rows of a scan of more than {build.scope.longest} passes inside a loop or branch",
            "them only as a result",
        )
    return results


def _row(build: Builder, body: Block, rows: Array, index: Operand, atom: Any) -> Array:
    """Row of a table at an index. The table is built before the loop; its body reads the row."""
    if not rows.size:
        return build.names(atom)
    data, inside = placed(build, rows), build.inside(body)
    stride = (data.strides() or [0])[0]
    base: Operand = index
    if stride != 1:
        base = inside.index("mul", Number("index", stride), index)
    base = inside.index("add", data.base, base)
    return settled(inside, Data(data.table, data.places[0], base))


def _scan(build: Builder, *operands: Array) -> Sequence[Array]:
    params, where = build.params, build.where
    constants, carries = scan_counts(params)
    body_jaxpr, count = params["jaxpr"], params["length"]
    split = constants + carries
    fixed = [settled(build, array) for array in operands[:constants]]
    rows = [settled(build, array) for array in operands[split:]]
    results = build.equation.outvars
    if count == 0:
        empty = (np.empty(atom.aval.shape, object) for atom in results[carries:])
        return [*operands[constants:split], *empty]
    counter = Name("index", "pass", next(build.groups))
    variables = _Variables(build, body_jaxpr, constants, operands[constants:split])
    body: Block = []
    inside, index = build.inside(body), counter
    if params["reverse"]:
        index = Name("index", "backward", next(build.groups))
        body.append(Assign(index, "sub", (Number("index", count - 1), counter), where))
    elements = [
        _row(build, body, array, index, atom)
        for array, atom in zip(rows, body_jaxpr.jaxpr.invars[split:], strict=True)
    ]
    outputs = _inner(build, body_jaxpr, [*fixed, *variables.arrays, *elements], body)
    tables = []
    as_tables = count > build.scope.longest
    for array, atom in zip(outputs[carries:], results[carries:], strict=True):
        table = Table(build.scope.kind(atom), count * array.size, where.name, as_tables)
        tables.append(table)
        _store_row(inside, array, table, index)
    carried = variables.carried(inside, outputs[:carries])
    build.block.append(Loop(count, counter, carried, body, [], None, tables, where))
    if as_tables:
        return [*variables.arrays, *(np.array(table, dtype=object) for table in tables)]
    arrays: list[Array] = []
    for table, atom in zip(tables, results[carries:], strict=True):
        places = np.arange(table.size).reshape(atom.aval.shape)
        arrays.append(settled(build, Data(table, places)))
    return [*variables.arrays, *arrays]


def _store_row(inside: Builder, array: Array, table: Table, index: Operand) -> None:
    """Append the assignment of a row of a table."""
    if not array.size:
        return
    base = index
    if array.size > 1:
        base = inside.index("mul", Number("index", array.size), index)
    row = Data(table, np.arange(array.size).reshape(array.shape), base)
    if array.size > inside.scope.few:
        store(inside, array, row)
        return
    for place, value in enumerate(inside.scalars(array).flat):
        position = inside.index("add", base, Number("index", place))
        inside.block.append(Store(table, (position,), value, inside.where))


def _while(build: Builder, *operands: Array) -> Sequence[Array]:
    params = build.params
    split, fixed = params["cond_nconsts"], params["body_nconsts"]
    constants = [settled(build, array) for array in operands[: split + fixed]]
    variables = _Variables(build, params["body_jaxpr"], fixed, operands[split + fixed :])
    test: Block = []
    tests = _inner(build, params["cond_jaxpr"], [*constants[:split], *variables.arrays], test)
    rows = build.inside(test).scalars(tests[0])
    goes_on = build.inside(test).fold("or", list(rows.flat))
    body: Block = []
    inside = build.inside(body)
    results = _inner(build, params["body_jaxpr"], [*constants[split:], *variables.arrays], body)
    numbers = variables.numbers(results)
    if rows.ndim > 0:  # of a batch: a row that has ended stays as it is
        results = [
            _update_rows(inside, rows, *pair)
            for pair in zip(results, variables.arrays, strict=True)
        ]
    carried = variables.carried(inside, results)
    # a row that has ended has ended for good: the loop has the passes of the longest one
    count = max(_bound(each, test, numbers, body) for each in rows.flat)
    if count == UNBOUNDED and not build.scope.unbounded:
        raise build.refused(
            "a loop without a bound",
            "a test that ends with `& (number < BOUND)`, where number starts at a constant and "
            f"grows by 1, or `fori_loop` between constants; by `vmap`, {build.scope.few} rows",
        )
    counter = Name("index" if count < 2**31 else "integer", "pass", next(build.groups))
    build.block.append(Loop(count, counter, carried, body, test, goes_on, [], build.where))
    return variables.arrays


def _update_rows(build: Builder, rows: Scalars, after: Array, before: Array) -> Array:
    """Values after a pass in the rows of a batch that go on, and those before it in the others."""
    mask = np.broadcast_to(rows.reshape(rows.shape + (1,) * (after.ndim - rows.ndim)), after.shape)
    return build.elementwise("select", kind_of(after), after.shape, mask, after, before)


def _bound(goes_on: Operand, test: Block, numbers: list[Carried], body: Block) -> int:
    """Largest number of passes, from a part `counter < constant` of the test, or `UNBOUNDED`."""
    assigned = {s.target: s for s in (*test, *body) if isinstance(s, Assign)}
    counters = {
        each.name: each.first.value
        for each in numbers
        if isinstance(each.first, Number) and each.name.kind == "integer" and _grows(each, assigned)
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
    return min([*bounds, UNBOUNDED])


def _grows(carried: Carried, assigned: dict[Name, Assign]) -> bool:
    """Whether each pass adds 1 to the carried variable."""
    step = assigned.get(carried.next)  # pyright: ignore[reportArgumentType]
    if step is not None and step.operation in ("to_half", "to_word"):  # of int32 and uint32
        step = assigned.get(step.operands[0])  # pyright: ignore[reportArgumentType]
    sums = () if step is None or step.operation != "add" else step.operands
    return {*sums} == {carried.name, Number("integer", 1)}


def _cond(build: Builder, selector: Array, *operands: Array) -> Sequence[Array]:
    index, branches = build.scalars(selector).item(), build.params["branches"]
    if isinstance(index, Number):
        number = min(max(int(index.value), 0), len(branches) - 1)
        return build.lower(branches[number], operands, build.block)
    inputs: list[Array] = [settled(build, array) for array in operands]
    targets: list[Array] = []
    for atom in build.equation.outvars:
        size, kind = math.prod(atom.aval.shape), build.scope.kind(atom)
        if size > build.scope.few:
            table = declared(build, kind, size)
            targets.append(Data(table, np.arange(size).reshape(atom.aval.shape)))
        else:
            targets.append(build.names(atom))
    blocks: list[Block] = []
    values: list[list[Operand]] = []
    for branch in branches:
        inner: Block = []
        results = _inner(build, branch, inputs, inner)
        values.append([])
        for target, array in zip(targets, results, strict=True):
            if isinstance(target, Data):
                store(build.inside(inner), array, target)
            else:
                values[-1] += build.inside(inner).scalars(array).flat
        blocks.append(inner)
    flat: list[Any] = [n for array in targets if isinstance(array, np.ndarray) for n in array.flat]
    for statement in build.block:
        # jax.lax.cond converts its condition to a number
        if isinstance(statement, Assign) and statement.target is index:
            if statement.operation == "to_integer":
                index = statement.operands[0]
            break
    build.block.append(Branch(index, blocks, values, flat, build.where))
    return targets


def _linear_solve(build: Builder, *operands: Array) -> Sequence[Array]:
    """Solution of linear equations: the function that solves them, without its derivatives."""
    counts, functions = build.params["const_lengths"], build.params["jaxprs"]
    start = counts.matvec + counts.vecmat
    constants, right = operands[start : start + counts.solve], operands[sum(counts) :]
    return build.lower(functions.solve, [*constants, *right], build.block, build.where)


RULES: dict[str, Callable[..., Sequence[Array]]] = {
    "cond": _cond,
    "custom_linear_solve": _linear_solve,
    "scan": _scan,
    "while": _while,
}
"""Primitive -> (builder, operands) -> results."""
