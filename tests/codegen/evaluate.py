"""Programs of scalars executed by Python: what a compiler of them must compute."""

import math
import operator

from gyrostat.codegen.program import Assign, Branch, Call, Fill, Loop, Number, Store

OPERATIONS = {
    **{name: getattr(operator, name) for name in ("add", "sub", "mul", "neg")},
    **{name: getattr(operator, name) for name in ("lt", "le", "gt", "ge", "eq", "ne")},
    **{name: getattr(math, name) for name in ("sin", "cos", "exp", "sqrt", "floor")},
    "div": operator.truediv,
    "and": operator.and_,
    "or": operator.or_,
    "not": operator.not_,
    "max": max,
    "min": min,
    "select": lambda test, yes, no: yes if test else no,
    "to_real": float,
    "to_integer": int,
    "to_index": int,
    "to_half": lambda number: (number + 2**31) % 2**32 - 2**31,
    "to_word": lambda number: number % 2**32,
}


def evaluate(function, arguments):
    """Values of a function's results.

    Args:
        function: a `gyrostat.codegen.program.Function`.
        arguments: its values, in the order of its parameters.
    """
    values = dict(zip(function.parameters, arguments, strict=True))
    _execute(function.body, values)
    return [_value(result, values) for result in function.results]


def _value(operand, values):
    return operand.value if isinstance(operand, Number) else values[operand]


def _execute(block, values):
    for statement in block:
        match statement:
            case Assign(target, "element", (index,), _, table):
                elements = table.values or values[table]
                values[target] = elements[_value(index, values)]
            case Assign(target, operation, operands):
                values[target] = OPERATIONS[operation](*(_value(o, values) for o in operands))
            case Fill(table, content):
                values[table] = [_value(each, values) for each in content] or [None] * table.size
            case Store(table, (index,), content):
                values[table][_value(index, values)] = _value(content, values)
            case Loop():
                _repeat(statement, values)
            case Branch():
                chosen = min(
                    max(int(_value(statement.index, values)), 0), len(statement.blocks) - 1
                )
                _execute(statement.blocks[chosen], values)
                made = [_value(each, values) for each in statement.values[chosen]]
                values.update(zip(statement.targets, made, strict=True))
            case Call(function, operands, targets):
                made = evaluate(function, [_value(each, values) for each in operands])
                values.update(zip(targets, made, strict=True))


def _repeat(loop, values):
    values.update({table: [None] * table.size for table in loop.stacked})
    values.update({each.name: _value(each.first, values) for each in loop.carried})
    for number in range(loop.count):
        values[loop.counter] = number
        _execute(loop.test, values)
        if loop.goes_on is not None and not _value(loop.goes_on, values):
            break
        _execute(loop.body, values)
        # all at once: a carried value may become another one
        values.update({c.name: v for c, v in [(c, _value(c.next, values)) for c in loop.carried]})
