"""Lower loops and branches of a jaxpr to loops and branches."""

import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

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
from gyrostat.codegen.source import Source, refusal, refused

if TYPE_CHECKING:
    from gyrostat.codegen.lower import Lowering


UNBOUNDED = 2**62
"""Passes of a loop that nothing bounds but its test."""


def argument_name(closed: Any, number: int) -> str:
    """What Python calls an argument, in the letters of a C name."""
    names = getattr(getattr(closed.jaxpr, "debug_info", None), "arg_names", None) or ()
    name = names[number] if number < len(names) else ""
    return re.sub(r"\W+", "_", str(name or "")).strip("_")


def _carried_names(
    lowering: "Lowering", body: Any, fixed: int, atoms: Sequence[Any], where: Source
) -> list[Scalars]:
    """Names for what a loop carries: those of the Python that its body is, where they are known."""
    return [
        lowering.names(atom, where._replace(name=argument_name(body, fixed + k) or where.name))
        for k, atom in enumerate(atoms)
    ]


def _inner(lowering: "Lowering", closed: Any, inputs: list[Scalars], block: Block, where: Source):
    """Results of what a loop or a branch does; rows of a long scan are none."""
    made = lowering.graph(closed, inputs, block)
    if any(array.shape == () and isinstance(array.item(), Table) for array in made):
        raise refusal(
            where,
            f"rows of a scan of more than {lowering.scope.longest} passes inside a loop or branch",
            "them only as a result",
        )
    return made


def _scan(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block):
    params, where = equation.params, lowering.source(equation)
    constants, carries = params["num_consts"], params["num_carry"]
    body_jaxpr, count = params["jaxpr"], params["length"]
    fixed, first, rows = (
        given[:constants],
        given[constants : constants + carries],
        given[constants + carries :],
    )
    results = equation.outvars
    if count == 0:
        return [*first, *(np.empty(atom.aval.shape, object) for atom in equation.outvars[carries:])]
    counter = Name("integer", "pass", lowering.new_group())
    carried = _carried_names(lowering, body_jaxpr, constants, results[:carries], where)
    body: Block = []
    index: Operand = counter
    if params["reverse"]:
        index = Name("integer", "backward", lowering.new_group())
        body.append(Assign(index, "sub", (Number("integer", count - 1), counter), where))
    picked = [
        lowering.picked(block, body, array, index, atom, where)
        for array, atom in zip(rows, body_jaxpr.jaxpr.invars[constants + carries :], strict=True)
    ]
    made = _inner(lowering, body_jaxpr, [*fixed, *carried, *picked], body, where)
    tables = []
    kept = count > lowering.scope.longest
    for array, atom in zip(made[carries:], results[carries:], strict=True):
        table = Table(lowering.kind(atom), count * array.size, where.name, kept)
        tables.append(table)
        for offset, value in enumerate(array.flat):
            body.append(Store(table, index, array.size, offset, value, where))
    block.append(
        Loop(
            count, counter, _carried(carried, first, made[:carries]), body, [], None, tables, where
        )
    )
    if kept:
        return [*carried, *(np.array(table, dtype=object) for table in tables)]
    stacked = []
    for table, atom in zip(tables, results[carries:], strict=True):
        names = lowering.names(atom, where)
        for offset, name in enumerate(names.flat):
            block.append(Assign(name, "element", (Number("integer", offset),), where, table))
        stacked.append(names)
    return [*carried, *stacked]


def _carried(names: list[Scalars], first: list[Scalars], last: list[Scalars]) -> list[Carried]:
    return [
        Carried(*each)
        for arrays in zip(names, first, last, strict=True)
        for each in zip(*(array.flat for array in arrays), strict=True)
    ]


def _while(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block):
    params, where = equation.params, lowering.source(equation)
    split = params["cond_nconsts"]
    ends = split + params["body_nconsts"]
    test_fixed, body_fixed, first = given[:split], given[split:ends], given[ends:]
    fixed = params["body_nconsts"]
    carried = _carried_names(lowering, params["body_jaxpr"], fixed, equation.outvars, where)
    test: Block = []
    goes_on = lowering.graph(params["cond_jaxpr"], [*test_fixed, *carried], test)[0].item()
    body: Block = []
    made = _inner(lowering, params["body_jaxpr"], [*body_fixed, *carried], body, where)
    every = _carried(carried, first, made)
    count = _bound(goes_on, test, every, body)
    if count is None and lowering.scope.unbounded:
        count = UNBOUNDED
    if count is None:
        raise refused(
            equation,
            where,
            "a loop without a bound",
            "a test that ends with `& (number < BOUND)`, where number starts at a constant and "
            "grows by 1",
        )
    counter = Name("integer", "pass", lowering.new_group())
    block.append(Loop(count, counter, every, body, test, goes_on, [], where))
    return carried


def _bound(goes_on: Operand, test: Block, carried: list[Carried], body: Block) -> int | None:
    """Largest number of passes, from a part `counter < constant` of the test; None without one."""
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
            more = statement.operation in ("le", "ge")
            bounds.append(max(int(high.value) + more - int(counters[low]), 0))
    return min(bounds, default=None)


def _grows(carried: Carried, assigned: dict[Name, Assign]) -> bool:
    """Whether each pass adds 1."""
    step = assigned.get(carried.next)  # pyright: ignore[reportArgumentType]
    if step is None or step.operation != "add":
        return False
    return set(step.operands) == {carried.name, Number("integer", 1)}


def _cond(lowering: "Lowering", equation: Any, given: list[Scalars], block: Block):
    where = lowering.source(equation)
    index, operands = given[0].item(), given[1:]
    branches = equation.params["branches"]
    if isinstance(index, Number):
        chosen = min(max(int(index.value), 0), len(branches) - 1)
        return lowering.graph(branches[chosen], operands, block)
    targets = [lowering.names(atom, where) for atom in equation.outvars]
    blocks: list[Block] = []
    values: list[list[Operand]] = []
    for branch in branches:
        inner: Block = []
        made = _inner(lowering, branch, operands, inner, where)
        blocks.append(inner)
        values.append([scalar for array in made for scalar in array.flat])
    flat = [name for array in targets for name in array.flat]
    for statement in block:
        # jax.lax.cond makes a number of its condition
        if isinstance(statement, Assign) and statement.target is index:
            if statement.operation == "to_integer":
                index = statement.operands[0]
            break
    block.append(Branch(index, blocks, values, flat, where))
    return targets


LOWERED: dict[str, Callable[..., list[Scalars]]] = {"cond": _cond, "scan": _scan, "while": _while}
"""Primitive -> (lowering, equation, operands, block) -> results."""
