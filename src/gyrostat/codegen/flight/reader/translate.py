"""Translation of emitted C to Python that evaluates it for many inputs at once.

A number of C is an array with an axis of lanes, one for each set of inputs. Both sides of a branch
are evaluated, and assignments keep the old values of the lanes that do not take it. Every decision
is passed to a recorder, with the lanes that reach it.
"""

import re
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.codegen.flight.reader.arithmetic import ELEMENTARY
from gyrostat.codegen.flight.reader.decisions import Decision
from gyrostat.codegen.flight.reader.expressions import ExpressionWriter
from gyrostat.codegen.flight.reader.syntax import (
    Assignment,
    Break,
    Declaration,
    Evaluation,
    Expression,
    For,
    FunctionText,
    If,
    Invocation,
    Literal,
    Place,
    Return,
    Statement,
    Unary,
    addressed,
)

LIBRARY = re.compile(rf"\bc_(?:{'|'.join(ELEMENTARY)})f?\(")
SLOW = 10
"""Work of an elementary function, which is evaluated number by number, in lines."""
_DTYPE = {"double": float, "float": np.float32, "bool": bool}


@dataclass(frozen=True)
class Translation:
    """Python for the functions of a C file.

    Attributes:
        text: Definitions of functions; C's `f(x)` is `f_f(lanes, path, x)`.
        constants: Name -> object that the text refers to.
        decisions: Decisions, in the order of the file.
        compared: Operands of comparisons.
    """

    text: str
    constants: dict[str, Any]
    decisions: tuple[Decision, ...]
    compared: tuple[tuple[Expression, Expression], ...]


def translate(
    functions: Sequence[FunctionText], entries: Collection[str], *, has_margins: bool
) -> Translation:
    """Translate the functions of a C file.

    Args:
        functions: Functions, each after those that it calls.
        entries: Functions that are always called for all lanes.
        has_margins: Whether logical values have margins.

    Raises:
        UnreadableError: A function has something that emitted C has not.
    """
    constants: dict[str, Any] = {}
    decisions: list[Decision] = []
    names = {function.name for function in functions}
    texts: list[str] = []
    compared: list[tuple[Expression, Expression]] = []
    for function in functions:
        writer = _FunctionWriter(function, names, constants, decisions, has_margins=has_margins)
        texts += writer.lines(function.name in entries)
        compared += writer.compared
    text = "\n".join([*texts, ""])
    return Translation(text, constants, tuple(decisions), tuple(compared))


@dataclass
class _Block:
    """Names of the variables with the lanes that a block is evaluated for, and their path."""

    lanes: str
    path: str
    outer: "_Block | None" = None
    is_loop: bool = False


class _FunctionWriter(ExpressionWriter):
    """Writer of one function."""

    def __init__(
        self,
        function: FunctionText,
        names: Collection[str],
        constants: dict[str, Any],
        decisions: list[Decision],
        *,
        has_margins: bool,
    ) -> None:
        super().__init__(function.name, names, constants, decisions, has_margins=has_margins)
        self._function = function
        self.addressed = addressed(function.body)
        self._home: dict[str, str] = {}
        self._outermost = ""
        self._may_return = False

    def lines(self, is_entry: bool) -> list[str]:
        """Python of the function."""
        names = "".join(f", v_{p.name}" for p in self._function.parameters)
        self._home = {p.name: "m" for p in self._function.parameters if not p.is_address}
        self._outermost = "m" if is_entry else ""
        self._may_return = any(
            isinstance(s.statement, If) and _leaves_by(Return, [s]) for s in self._function.body
        )
        if self._may_return:
            self.line("out = None")
        for parameter in self._function.parameters:
            if parameter.name in self.addressed:
                self.line(f"v_{parameter.name} = [v_{parameter.name}]")
        with self._counted():
            self._block(self._function.body, _Block("m", "p"))
        return [f"def f_{self._function.name}(m, p{names}):", *self.taken(), "    return 0"]

    def _block(self, statements: Sequence[Statement], block: _Block) -> None:
        for each in statements:
            self.at(block.lanes, block.path, each.source)
            match each.statement:
                case Declaration():
                    self._declare(each.statement, block)
                case Assignment(place, value):
                    self._assign(place, self.text(value), block)
                case If():
                    self._if(each.statement, block)
                case For():
                    self._for(each.statement, block)
                case Evaluation(value):
                    if isinstance(value, Invocation):
                        self.line(self.text(value))
                case Break():
                    self._leave(block, lambda outer: outer.is_loop)
                case Return(value):
                    self._return(value, block)

    def _declare(self, declaration: Declaration, block: _Block) -> None:
        name, kind, values = declaration.name, declaration.kind, declaration.values
        self._home[name] = block.lanes
        if declaration.sizes:
            numbers = [_number(value) for value in values or ()]
            if numbers and None not in numbers:
                array = np.array(numbers, _DTYPE.get(kind, np.int64)).reshape(declaration.sizes)
                self.line(f"v_{name} = {self.constant(array)}")
                return
            texts = [self.text(value) for value in values or ()] or None
            self.line(f"v_{name} = {_nested(texts, declaration.sizes, _zero(kind))}")
            return
        if values is None:
            text = _zero(kind)
        elif declaration.is_constant:
            text = self.definition(name, values[0])
        else:
            text = self.text(values[0])
        self.line(f"v_{name} = [{text}]" if name in self.addressed else f"v_{name} = {text}")

    def _assign(self, place: Place, text: str, block: _Block) -> None:
        target = self.text(place)
        if not self.is_fixed(place):
            indices = ", ".join(self.text(index) for index in place.indices)
            base = self.text(Place(place.name, place.path))
            self.line(f"put({base}, ({indices},), {block.lanes}, {text})")
            return
        is_local = not place.path and not place.is_target
        home = self._home.get(place.name) if is_local else self._outermost
        if home != block.lanes:
            text = f"pick({block.lanes}, {text}, {target}, {block.path})"
        self.line(f"{target} = {text}")

    def _if(self, branch: If, block: _Block) -> None:
        test = self.decision(branch.test, "if", branch.at)
        sides = []
        for statements, name in ((branch.yes, "and"), (branch.no, "and_not")):
            inner = self.narrowed(block.lanes, block.path, name, test)
            sides.append((statements, _Block(*inner, block)))
        for statements, inner in sides:
            if statements:
                self.line(f"if some({inner.lanes}):")
                with self.indented():
                    self._block(statements, inner)

    def _for(self, loop: For, block: _Block) -> None:
        counter = f"v_{loop.counter}"
        start = self.text(loop.start)
        if self.is_uniform(loop.start) and not _leaves_by(Break, loop.body):
            number = self.new_decision([(loop.test, loop.test.at)], 0, "for", loop.test.at)
            is_run = f"{start} < {loop.limit}"
            self.line(f"if need[{number}]: passes({number}, {block.lanes}, {block.path}, {is_run})")
            self.uniform.add(loop.counter)
            with self._counted(f"max({loop.limit} - {start}, 0)"):
                self.line(f"for {counter} in range({start}, {loop.limit}):")
                with self.indented():
                    self._block(loop.body, block)
            self.uniform.discard(loop.counter)
            return
        left = _Block(self.free("m"), self.free("p"))
        inner = _Block(self.free("m"), self.free("p"), block, is_loop=True)
        self._home[loop.counter] = inner.lanes
        number = self.free("k")
        self.line(f"{counter} = {start}")
        self.line(f"{left.lanes}, {left.path} = {block.lanes}, {block.path}")
        self.line(f"for {number} in range({loop.limit + 1}):")
        with self.indented(), self._counted():
            self.at(left.lanes, left.path, self.source)
            test = self.decision(loop.test, "for", loop.test.at)
            self.line(f"{inner.lanes} = lanes_and({left.lanes}, {test})")
            self.line(f"{inner.path} = path_and({left.path}, {test})")
            self.line(f"if stop({inner.lanes}, {number}): break")
            self._block(loop.body, inner)
            self.line(f"{counter} = pick({inner.lanes}, {counter} + 1, {counter})")
            self.line(f"{left.lanes}, {left.path} = {inner.lanes}, {inner.path}")

    @contextmanager
    def _counted(self, passes: str = "1") -> Iterator[None]:
        """Write lines behind one that counts them as work, once for each pass."""
        place = len(self.taken())
        self.line("")
        indent = self.taken()[place]
        yield
        count = sum(1 + SLOW * len(LIBRARY.findall(line)) for line in self.taken()[place:])
        self.taken()[place] = f"{indent}spend({count} * {passes})"

    def _leave(self, block: _Block, is_last: Any) -> None:
        """Take the lanes of a block out of the blocks around it."""
        outer: _Block | None = block
        while outer is not None and not is_last(outer):
            outer = outer.outer
            if outer is not None:
                self.line(f"{outer.lanes} = {outer.lanes} & ~{block.lanes}")
                self.line(f"{outer.path} = path_left({outer.path}, {block.path})")

    def _return(self, value: Any, block: _Block) -> None:
        text = "0" if value is None else self.text(value)
        if block.outer is None:
            self.line(f"return pick(m, {text}, out)" if self._may_return else f"return {text}")
            return
        self.line(f"out = pick({block.lanes}, {text}, out)")
        self._leave(block, lambda outer: outer.outer is None)


def _number(expression: Expression) -> float | int | bool | None:
    """Value of a number, which may have a sign; None for other expressions."""
    match expression:
        case Literal(value=value):
            return value
        case Unary(operation="-", operand=Literal(value=value)):
            return -value
    return None


def _zero(kind: str) -> str:
    return {"bool": "no", "double": "0.0", "float": "0.0"}.get(kind, "0")


def _nested(texts: Sequence[str] | None, sizes: Sequence[int], zero: str) -> str:
    """Python of an array as lists in lists."""
    if not sizes:
        return zero if texts is None else texts[0]
    inner = sizes[1:]
    step = int(np.prod(inner, dtype=int))
    rows = [
        _nested(None if texts is None else texts[k * step : (k + 1) * step], inner, zero)
        for k in range(sizes[0])
    ]
    return f"[{', '.join(rows)}]"


def _leaves_by(kind: type[Break | Return], statements: Sequence[Statement]) -> bool:
    """Whether a block, or a branch in it, is left by a kind of statement."""
    return any(
        isinstance(s.statement, kind)
        or (isinstance(s.statement, If) and _leaves_by(kind, (*s.statement.yes, *s.statement.no)))
        for s in statements
    )
