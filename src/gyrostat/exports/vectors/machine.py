"""Evaluation of a flight module for many inputs at once, as its C code computes."""

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np

from gyrostat.codegen.flight.module import Module, Precision, by_address, ports_of
from gyrostat.codegen.flight.reader.arithmetic import PLAIN
from gyrostat.codegen.flight.reader.functions import functions
from gyrostat.codegen.flight.reader.margins import MARGINS, Comparisons, logic, value_of
from gyrostat.codegen.flight.reader.syntax import (
    Expression,
    Invocation,
    Literal,
    Place,
    Unary,
)
from gyrostat.codegen.flight.reader.translate import Translation, translate
from gyrostat.codegen.flight.structs import Struct
from gyrostat.exports.target import Target
from gyrostat.exports.vectors.fields import Field, fields_of, whole

PASSES = 8
"""Number of passes of a loop that may end early after which a lane is given up, at first."""
ALL_PASSES = sys.maxsize
"""Number of passes that no loop makes."""
Recorder = Callable[[int, np.ndarray, Any, tuple[Any, ...]], None]
"""Receives a decision's number, the lanes that reach it, the margin of the path to it (None
without margins) and the value of each condition."""


class Machine:
    """Functions of a flight module on arrays of lanes.

    Attributes:
        fields: Numbers of the module.
        decisions: Decisions of its C code.
        limits: Field -> other fields, as their indices, and numbers that it is compared with.
        most_passes: Number of passes after which a lane is given up.
        dead: Lanes of the last run that were given up. Their results are not valid.
        work: Work of the last run: executed lines of translated code, where 500 lanes count as a
            line more, and lines with margins three times.
    """

    def __init__(self, target: Target, module: Module, precision: Precision) -> None:
        self.fields = fields_of(target, module)
        self._functions = functions(module.source)
        self.most_passes = PASSES
        self.dead = np.zeros(0, bool)
        self.work = self._line_work = 0.0
        self._parameters = target.begin[0].name
        self._module, self._target = module, target
        self._real = np.float32 if precision == "float" else float
        self._recorder: Recorder = _ignore
        self._spaces: dict[bool, dict[str, Any]] = {}
        translation = self._compile(has_margins=False)
        self.decisions = translation.decisions
        self.limits = self._limits(translation.compared)
        self.need = self._spaces[False]["need"]

    def rounded(self, values: Mapping[int, float]) -> dict[int, float]:
        """Values of fields as the C code can hold them."""
        with np.errstate(all="ignore"):
            return {
                k: float(self._real(value)) if self.fields[k].kind == "real" else value
                for k, value in values.items()
            }

    def _compile(self, *, has_margins: bool) -> Translation:
        """Translate the module and define its functions."""
        entries = [entry.name for entry in self._target.entries]
        translation = translate(self._functions, entries, has_margins=has_margins)
        space = {**(MARGINS | Comparisons().operations() if has_margins else PLAIN)}
        space |= translation.constants
        space |= {"record": self._record, "passes": self._passes, "spend": self._spend}
        space["stop"] = partial(self._stop, has_margins)
        space["need"] = [True] * len(translation.decisions)
        exec(compile(translation.text, f"{self._module.name}.c", "exec"), space)
        self._spaces[has_margins] = space
        return translation

    def run(
        self,
        values: np.ndarray,
        recorder: Recorder,
        *,
        begins: bool,
        has_margins: bool = False,
    ) -> np.ndarray:
        """Values of all fields after a step.

        Args:
            values: Values before it, (fields, lanes).
            recorder: Receives every decision that `need` marks.
            begins: Whether the functions that set the state are called first.
            has_margins: Whether conditions and paths have margins.
        """
        if has_margins and True not in self._spaces:
            self._compile(has_margins=True)
            self._spaces[True]["need"] = self.need
        space, lanes = self._spaces[has_margins], values.shape[1]
        self._recorder = recorder
        self.dead = np.zeros(lanes, bool)
        self.work = 0.0
        self._line_work = (3.0 if has_margins else 1.0) * (1.0 + lanes / 500.0)
        entries = self._target.steps
        if begins:
            entries = (*self._target.begin[1:], *entries)
        with np.errstate(all="ignore"):
            if begins and self._needs_parameters():
                # it has no inputs: one lane is enough, and its results are in the values
                self._call(space, self._parameters, self._store(values[:, :1], has_margins), 1)
            store = self._store(values, has_margins)
            for entry in entries:
                self._call(space, entry.name, store, lanes)
            return self._values(store, lanes)

    @contextmanager
    def up_to(self, passes: int) -> Iterator[None]:
        """Give up a lane only after another number of passes."""
        most, self.most_passes = self.most_passes, passes
        yield
        self.most_passes = most

    def _needs_parameters(self) -> bool:
        """Whether decisions of the function that sets the parameters are recorded."""
        return any(self.need[d.number] for d in self.decisions if d.function == self._parameters)

    def _limits(
        self, compared: Sequence[tuple[Expression, Expression]]
    ) -> dict[int, list[int | float]]:
        """Fields and numbers that each field is compared with, a number as float."""
        places = {(field.port, field.path, field.indices): k for k, field in enumerate(self.fields)}

        def operand(expression: Expression) -> int | float | None:
            while isinstance(expression, Unary) or (
                isinstance(expression, Invocation) and len(expression.arguments) == 1
            ):
                expression = (
                    expression.operand if isinstance(expression, Unary) else expression.arguments[0]
                )
            match expression:
                case Literal(value=value):
                    return float(value)
                case Place(name=name, path=path, indices=indices):
                    known = tuple(int(i.value) for i in indices if isinstance(i, Literal))
                    return places.get((name, path, known))
            return None

        limits: dict[int, list[int | float]] = {}
        for pair in compared:
            one, other = map(operand, pair)
            for a, b in ((one, other), (other, one)):
                if isinstance(a, int) and b is not None:
                    limits.setdefault(a, []).append(b)
        return limits

    def _call(
        self, space: Mapping[str, Any], entry: str, store: dict[str, Any], lanes: int
    ) -> None:
        arguments, numbers = [], {}
        for port in self._module.ports[entry]:
            value = store[port.name]
            if by_address(port) and not isinstance(port.content, Struct):
                numbers[port.name] = value = [value]
            arguments.append(value)
        space[f"f_{entry}"](np.ones(lanes, bool), None, *arguments)
        store.update({name: cell[0] for name, cell in numbers.items()})

    def _store(self, values: np.ndarray, has_margins: bool) -> dict[str, Any]:
        """Arguments in translated code: a number, nested lists, or a dictionary of them."""
        store: dict[str, Any] = {name: {} for name in ports_of(self._module)}
        for field, row in zip(self.fields, values, strict=True):
            member = store[field.port]
            _set(member, field.path, field.indices, self._typed(field, row, has_margins))
        return {
            name: members[""] if list(members) == [""] else members
            for name, members in store.items()
        }

    def _typed(self, field: Field, row: np.ndarray, has_margins: bool) -> Any:
        if field.kind == "real":
            return row.astype(self._real)
        if field.kind == "integer":
            return whole(row)
        return logic(row != 0.0) if has_margins else row != 0.0

    def _values(self, store: Mapping[str, Any], lanes: int) -> np.ndarray:
        rows = np.empty((len(self.fields), lanes))
        for field, row in zip(self.fields, rows, strict=True):
            value = store[field.port]
            value = value[field.path] if isinstance(value, dict) else value
            for index in field.indices:
                value = value[index]
            row[:] = value_of(value)
        return rows

    def _stop(self, has_margins: bool, lanes: np.ndarray, number: int) -> bool:
        """Whether no lane goes on, or one has made too many passes: it is dead from then on."""
        if number > self.most_passes:
            self.dead |= lanes
            return True
        # with margins, one pass shows what lanes that skip the loop would compute
        return (number > 0 or not has_margins) and not lanes.any()

    def _spend(self, lines: int) -> None:
        self.work += lines * self._line_work

    def _record(self, number: int, lanes: Any, path: Any, values: tuple[Any, ...]) -> None:
        lanes = lanes & ~self.dead
        self._recorder(number, lanes, path, values)

    def _passes(self, number: int, lanes: Any, path: Any, is_run: bool) -> None:
        """Record a loop that every lane passes to its end: its test is true, if run, then false."""
        for value in (True, False) if is_run else (False,):
            self._record(number, lanes, path, (value,))


def _ignore(number: int, lanes: Any, path: Any, values: tuple[Any, ...]) -> None:
    """Recorder that records nothing."""


def _set(members: dict[str, Any], path: str, indices: tuple[int, ...], value: Any) -> None:
    """Set an element of nested lists, which grow in C's order."""
    if not indices:
        members[path] = value
        return
    array = members.setdefault(path, [])
    for index in indices[:-1]:
        if index == len(array):
            array.append([])
        array = array[index]
    array.append(value)
