"""Equality of code objects, and the names that code refers to."""

import __future__

import bisect
import dis
import re
from collections.abc import Iterator
from functools import lru_cache
from types import CodeType
from typing import Any, NamedTuple

EVALUATING = frozenset({"globals", "locals", "vars", "eval", "exec", "compile", "modules"})
"""Names of functions and objects by which code reaches global names without naming them."""
READING = frozenset({"getattr", "__dict__", "attrgetter", "import_module", "__import__"})
"""Names by which code reaches attributes of a module without naming them."""
_GLOBAL = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS", "STORE_GLOBAL", "DELETE_GLOBAL")
_OF_CALLS = ("PUSH_NULL", "PRECALL", "CACHE", "NOP", "EXTENDED_ARG")
_LAYOUT = (
    "co_names",
    "co_varnames",
    "co_freevars",
    "co_cellvars",
    "co_argcount",
    "co_posonlyargcount",
    "co_kwonlyargcount",
    "co_name",
)


class Names(NamedTuple):
    """Names that a code object and the code inside it refer to.

    Attributes:
        global_names: Names that are looked up in the globals of the module.
        imports: Modules that import statements name.
        mentioned: All identifiers, also those of attributes and in texts.
    """

    global_names: frozenset[str]
    imports: frozenset[str]
    mentioned: frozenset[str]


def same_code(one: CodeType, other: CodeType) -> bool:
    """Whether two code objects do the same; file names and line numbers do not count."""
    if one is other:
        return True
    if any(getattr(one, name) != getattr(other, name) for name in _LAYOUT):
        return False
    # annotations as texts do not change what runs; those of classes are compared by themselves
    if (one.co_flags ^ other.co_flags) & ~__future__.annotations.compiler_flag:
        return False
    if one.co_code != other.co_code and _steps(one) != _steps(other):
        return False
    return _equal_constants(one.co_consts, other.co_consts)


def _steps(code: CodeType) -> list[Any]:
    """Instructions without what depends on the text around a definition.

    A call of an attribute of a module is compiled differently if the same text imports the module.
    """
    steps = [s for s in dis.get_instructions(code) if s.opname not in _OF_CALLS]
    offsets = [step.offset for step in steps]

    def number_at(offset: int) -> int:
        return bisect.bisect_left(offsets, offset)

    operations: list[Any] = []
    for step in steps:
        operand: Any = step.arg
        if step.opcode in dis.hasjrel or step.opcode in dis.hasjabs:
            operand = number_at(step.argval)
        elif step.opcode in dis.hasname:
            operand = step.argval
        operations.append((step.opname.replace("LOAD_METHOD", "LOAD_ATTR"), operand))
    bytecode: Any = dis.Bytecode(code)
    for entry in bytecode.exception_entries:
        numbers = [number_at(each) for each in (entry.start, entry.end, entry.target)]
        operations.append((*numbers, entry.depth, entry.lasti))
    return operations


def _equal_constants(left: Any, right: Any) -> bool:
    if isinstance(left, CodeType) and isinstance(right, CodeType):
        return same_code(left, right)
    if type(left) is not type(right):
        return False
    if isinstance(left, tuple):
        return len(left) == len(right) and all(map(_equal_constants, left, right))
    if isinstance(left, frozenset):
        return sorted(map(repr, left)) == sorted(map(repr, right))
    return repr(left) == repr(right)  # tells 0.0 from -0.0, and finds NaN equal to NaN


@lru_cache(maxsize=4096)
def names_of(code: CodeType) -> Names:
    """Names that a code object and the code inside it refer to."""
    global_names: set[str] = set()
    imports: set[str] = set()
    mentioned: set[str] = set()
    for inner in nested(code):
        mentioned.update(inner.co_names)
        evaluates = not EVALUATING.isdisjoint(inner.co_names)
        for text in _texts(inner.co_consts):
            if evaluates:
                mentioned.update(re.findall(r"[^\W\d]\w*", text[:10_000]))
            elif text.isidentifier():
                mentioned.add(text)
        for step in dis.get_instructions(inner):
            if step.opname.startswith(_GLOBAL):
                global_names.add(step.argval)
            elif step.opname == "IMPORT_NAME":
                imports.add(step.argval)
    return Names(frozenset(global_names), frozenset(imports), frozenset(mentioned))


def nested(code: CodeType) -> Iterator[CodeType]:
    """The code object and all code objects inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from nested(constant)


def _texts(constants: tuple[Any, ...]) -> Iterator[str]:
    for constant in constants:
        if isinstance(constant, str):
            yield constant
        elif isinstance(constant, tuple):
            yield from _texts(constant)
