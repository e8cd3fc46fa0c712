"""C expressions for operations on one number and on a vector with one number in each lane."""

from collections.abc import Mapping, Sequence

from gyrostat.codegen.program import Kind, Number, Operand

VECTOR = {
    **{"real": "real", "integer": "integer", "logical": "mask", "bits": "bits"},
    "index": "integer",
}
"""Kind of number -> C type of a vector of lanes, which is also the suffix of function names."""
ONE = {
    **{"real": "double", "integer": "int64_t", "logical": "bool", "bits": "uint64_t"},
    "index": "int64_t",
}
"""Kind of number -> C type of a single number."""

INFIX = {
    **{"add": "+", "sub": "-", "mul": "*", "div": "/", "shift_left": "<<"},
    **{"and": "&", "or": "|", "xor": "^"},
}
"""Operations with a C operator, which also works on lanes."""
MOST_COMMON = 1024
"""Largest number of results common to all runs that a header may keep in a memory of its choice."""
_COMPARED = {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "==", "ne": "!="}
BOUND = {"max": "at_least", "min": "at_most"}
"""Operations with a simpler function if one operand is a constant."""
_OWN_FOR_ONE = frozenset({"max", "min", "sign", "quotient", "remainder"})
_WITHOUT_LIBRARY = frozenset({"erf_inv", "threefry"})
"""Functions implemented only for lanes."""


def number(constant: Number) -> str:
    """Constant as a C literal."""
    value = constant.value
    if constant.kind == "logical":
        return "true" if value else "false"
    if constant.kind == "bits":
        return f"UINT64_C({int(value)})"
    if constant.kind == "integer" and value == -(2**63):  # C has no such literal
        return "INT64_MIN"
    if constant.kind in ("integer", "index"):
        return f"INT64_C({int(value)})"
    if value != value:
        return "NAN"
    if value in (float("inf"), float("-inf")):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    return repr(value) if value >= 0 and repr(value)[0] != "-" else f"({value!r})"


def shared_word(kind: Kind, place: str) -> str:
    """Number in the memory that all runs share."""
    word = f"SHARED({place})"
    return f"one_as_real({word})" if kind == "real" else f"({ONE[kind]}){word}"


def converted(operation: str, kind: Kind, text: str) -> str | None:
    """Type conversion of lanes; None for another operation."""
    target = operation.removeprefix("to_")
    if operation.startswith("as_"):
        return _reinterpreted(VECTOR, kind, operation[3:], text)
    if target == operation:
        return None
    if target == "word":
        return f"(bits){text} & 0xffffffffu"
    if target == "half":
        return f"(integer)((bits){text} << 32) >> 32"
    vector = VECTOR[target]  # pyright: ignore[reportArgumentType]
    if kind == "logical" and target == "real":
        return f"real_of_mask({text})"
    if kind == "logical":
        return f"({vector})integer_of_mask({text})"
    if target == "real" or kind == "real":
        return f"{vector}_of_{VECTOR[kind]}({text})"
    return f"({vector}){text}"


def on_one(operation: str, operands: Sequence[Operand], texts: list[str]) -> str:
    """Operation on single numbers."""
    kind = operands[0].kind
    if operation in ("shift_left", "shift_right"):
        return f"({ONE[kind]})one_{operation}({', '.join(texts)})"
    sign = INFIX.get(operation) or _COMPARED.get(operation)
    if sign is not None:
        return f"{texts[0]} {sign} {texts[1]}"
    if operation == "select":
        return f"{texts[0]} ? {texts[1]} : {texts[2]}"
    if operation == "neg":
        return f"-{texts[0]}"
    if operation == "not":
        return f"{'!' if kind == 'logical' else '~'}{texts[0]}"
    if operation in _OWN_FOR_ONE:
        return f"one_{operation}_{kind}({', '.join(texts)})"
    if operation in ("to_integer", "to_bits") and kind == "real":
        return f"one_{operation[3:]}_of_real({texts[0]})"
    if operation == "to_word":
        return f"(uint64_t){texts[0]} & 0xffffffffu"
    if operation == "to_half":
        return f"(int64_t)(int32_t){texts[0]}"
    if operation.startswith("to_"):
        return f"({ONE[operation[3:]]}){texts[0]}"  # pyright: ignore[reportArgumentType]
    if operation.startswith("as_"):
        return _reinterpreted(ONE, kind, operation[3:], texts[0])
    if operation in _WITHOUT_LIBRARY:
        lanes = ", ".join(
            f"all_{VECTOR[o.kind]}({t})" for o, t in zip(operands, texts, strict=True)
        )
        return f"one_of_{VECTOR[kind]}({operation}_{VECTOR[kind]}({lanes}))"
    name = {"abs": "fabs", "finite": "isfinite"}.get(operation, operation)
    return f"{name}({', '.join(texts)})"


def _reinterpreted(types: Mapping[str, str], kind: Kind, target: str, text: str) -> str:
    """Value of another kind with the same 64 bits; `types` are those of lanes or of one number."""
    prefix, whole = ("one_", "int64_t") if types is ONE else ("", "integer")
    if target == kind == "real":
        return text
    if target == "real":
        return f"{prefix}as_real(({whole}){text})"
    if kind == "real":
        text = f"{prefix}as_integer({text})"
    return f"({types[target]}){text}"


def case_test(kind: Kind, text: str, is_one: bool, case: int, last: int) -> str:
    """C test that selects one of several blocks by an index.

    Args:
        kind: Kind of number of the index.
        text: Index.
        is_one: Whether it is a single number.
        case: Number of the block.
        last: Number of the last block.
    """
    if kind == "logical":
        return text if case else f"{'!' if is_one else 'not_mask'}({text})"
    if is_one:
        return f"{text} {'<=' if case == 0 else '>=' if case == last else '=='} {case}"
    comparison = "le" if case == 0 else "ge" if case == last else "eq"
    return f"{comparison}_{kind}({text}, all_{kind}({case}))"
