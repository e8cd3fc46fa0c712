"""C text of expressions, for reports."""

from gyrostat.codegen.flight.reader.syntax import (
    Address,
    Binary,
    Choice,
    Expression,
    Invocation,
    Literal,
    Place,
    Unary,
)


def spelled(expression: Expression) -> str:
    """C text of an expression, with brackets around every operation inside another."""
    match expression:
        case Literal(value=value):
            return str(value).lower() if isinstance(value, bool) else repr(value)
        case Place():
            return _place(expression)
        case Address(place=place):
            return f"&{_place(place)}"
        case Unary(operation=operation, operand=operand):
            sign = operation if operation in "-!~" else f"({operation})"
            return f"{sign}{_inner(operand)}"
        case Binary(operation=operation, left=left, right=right):
            return f"{_inner(left)} {operation} {_inner(right)}"
        case Choice(test=test, yes=yes, no=no):
            return f"{_inner(test)} ? {_inner(yes)} : {_inner(no)}"
        case Invocation(function=function, arguments=arguments):
            return f"{function}({', '.join(map(spelled, arguments))})"


def _inner(expression: Expression) -> str:
    text = spelled(expression)
    return f"({text})" if isinstance(expression, Binary | Choice) else text


def _place(place: Place) -> str:
    text = f"*{place.name}" if place.is_target else place.name
    if place.path:
        text += f"->{place.path}"
    return text + "".join(f"[{spelled(index)}]" for index in place.indices)
