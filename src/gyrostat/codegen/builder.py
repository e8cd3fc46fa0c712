"""Builder: appends the statements of one equation of a jaxpr to a block of a program."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from gyrostat.codegen import whole
from gyrostat.codegen.arrays import SMALL, Array, Data, Deferred, Element, is_plain, spread
from gyrostat.codegen.constants import TooManyError, constant_table, folded, with_zero
from gyrostat.codegen.memo import Memo
from gyrostat.codegen.primitives import TEST, Scalars, one_by_one
from gyrostat.codegen.program import (
    MINUS_ONE,
    Assign,
    Block,
    Fill,
    Kind,
    Name,
    Number,
    Operand,
    Table,
)
from gyrostat.codegen.rows import Row, assigned
from gyrostat.codegen.scope import Scope
from gyrostat.codegen.source import Source, refusal, refused
from gyrostat.core.errors import InputError


@dataclass(frozen=True)
class Builder:
    """Insertion point for the statements of one equation.

    Attributes:
        equation: Equation of a jaxpr.
        block: Block that the statements are appended to.
        where: Line of Python that the equation comes from.
        scope: Allowed array types and primitives.
        groups: Iterator of new numbers, one for each array operation; see `Name.group`.
        lower: Function that appends a closed jaxpr to a block: (closed jaxpr, inputs, block) ->
            results. If the further argument `called_at`, a line of Python, is given, all
            statements get that line.
        memo: What has been made so far.
    """

    equation: Any
    block: Block
    where: Source
    scope: Scope
    groups: Iterator[int]
    lower: Callable[..., list[Array]]
    memo: Memo

    @property
    def params(self) -> dict[str, Any]:
        """Parameters of the equation."""
        return self.equation.params

    @property
    def target(self) -> Any:
        """Variable of the first result."""
        return self.equation.outvars[0]

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the first result."""
        return self.target.aval.shape

    @property
    def size(self) -> int:
        """Number of elements of the first result."""
        return math.prod(self.shape)

    def inside(self, block: Block) -> Self:
        """Builder of the same equation that appends to another block."""
        return replace(self, block=block)

    def refused(self, what: str, expected: str) -> InputError:
        """Error for an equation that cannot be compiled; see `refused` in `source`."""
        return refused(self.equation, self.where, what, expected)

    def names(self, atom: Any, hint: str | None = None) -> Scalars:
        """Array of new names for a variable."""
        kind, group, shape = self.scope.kind(atom), next(self.groups), atom.aval.shape
        names = np.empty(shape, dtype=object)
        for index in np.ndindex(shape):
            names[index] = Name(kind, self.where.name if hint is None else hint, group, index)
        return names

    def assign(self, operation: str, operands: Sequence[Operand], target: Name) -> Operand:
        """Append an operation; return a constant, one of the operands, or the assigned target."""
        if any(isinstance(each, Row) for each in operands):
            return assigned(self, operation, operands, target)
        if operation in whole.OPERATIONS and operands[0].kind != "real":
            return whole.OPERATIONS[operation](
                lambda inner, *inputs: self.compute(inner, *inputs, hint=target.hint), *operands
            )
        known = folded(operation, operands, target.kind)
        if known is not None:
            return known
        if operation == "mul" and MINUS_ONE in operands:
            others = [each for each in operands if each != MINUS_ONE]
            return self.assign("neg", others, target)
        statement = Assign(target, operation, tuple(operands), self.where)
        return self.memo.appended(self.block, statement)

    def index(self, operation: str, first: Operand | None, second: Operand) -> Operand:
        """Append an operation on indices, "add", "sub" or "mul"; None is a missing first term."""
        if first is None or (operation == "add" and first == Number("index", 0)):
            return second
        if operation == "add" and second == Number("index", 0):
            return first
        return self.compute(operation, first, second, hint="index")

    def as_index(self, operand: Operand) -> Operand:
        """Integer as an index."""
        if isinstance(operand, Number):
            return Number("index", int(operand.value))
        name = Name("index", "index", next(self.groups))
        return operand if operand.kind == "index" else self.assign("to_index", (operand,), name)

    def compute(
        self,
        operation: str,
        *operands: Operand,
        hint: str | None = None,
        group: int | None = None,
    ) -> Operand:
        """Append an operation on scalars and return its result.

        The result is logical or has the kind of the last operand.

        Args:
            operation: Name of the operation.
            operands: Operands.
            hint: Name for the result; None for the name that the line of Python assigns.
            group: Number of the array operation that this operation is part of; None for a new one.
        """
        name = Name(
            "logical" if operation in TEST else operands[-1].kind,
            self.where.name if hint is None else hint,
            next(self.groups) if group is None else group,
        )
        return self.assign(operation, operands, name)

    def apply(self, operation: str, *arrays: Any) -> Array:
        """Apply an operation to each element; an array without axes is broadcast.

        Arrays of scalars give scalars. The operation on a large array is deferred, unless known
        zeros leave little of it.
        """
        kind, shape = self.scope.kind(self.target), self.shape
        return self.elementwise(operation, kind, shape, *arrays)

    def elementwise(
        self, operation: str, kind: Kind, shape: tuple[int, ...], *arrays: Any
    ) -> Array:
        """Apply an operation to arrays, with a given kind and shape of the result; see `apply`."""
        size, plain = math.prod(shape), all(map(is_plain, arrays))
        if plain and any(isinstance(each, Row) for array in arrays for each in array.flat):
            return self._one_by_one(operation, kind, shape, arrays)
        if size > (SMALL if plain else self.scope.few):
            known = self._if_few(operation, kind, shape, arrays) if plain else None
            full = tuple(spread(each, shape) for each in arrays)
            return Deferred(operation, full, kind, self.where) if known is None else known
        return self._one_by_one(operation, kind, shape, arrays)

    def _one_by_one(
        self,
        operation: str,
        kind: Kind,
        shape: tuple[int, ...],
        arrays: Sequence[Array],
        limit: float = math.inf,
    ) -> Scalars:
        """Scalars of the result.

        A known zero in an array means that two quantities have nothing to do with each other: NaN
        and infinity do not spread through it.
        """
        group = next(self.groups)
        full = [np.broadcast_to(self.scalars(each), shape) for each in arrays]
        results = np.empty(shape, dtype=object)
        for place in np.ndindex(shape):
            operands: tuple[Any, ...] = tuple(each[place] for each in full)
            result = with_zero(operation, operands) if shape and kind == "real" else None
            if result is None:
                name = Name(kind, self.where.name, group, place)
                result = self.assign(operation, operands, name)
            results[place] = result
            if len(self.block) > limit:
                raise TooManyError
        return results

    def _if_few(
        self, operation: str, kind: Kind, shape: tuple[int, ...], arrays: Sequence[Array]
    ) -> Scalars | None:
        """Scalars of the result, if known zeros leave few operations; otherwise None."""
        inside = self.inside([])
        try:
            results = inside._one_by_one(operation, kind, shape, arrays, SMALL)
        except TooManyError:
            return None
        self.block.extend(inside.block)
        return results

    def fold(self, operation: str, scalars: Sequence[Operand]) -> Operand:
        """Combine scalars by an operation, from first to last."""
        if not scalars:
            raise refusal(self.where, "a sum of no elements", "one or more")
        total, group = scalars[0], next(self.groups)
        for scalar in scalars[1:]:
            name = Name(scalar.kind, self.where.name, group)
            total = self.assign(operation, (total, scalar), name)
        return total

    def clamp(self, index: Operand, first: Operand, last: Operand) -> Operand:
        """Index limited to the range from the first to the last."""
        for test, limit in (("lt", first), ("gt", last)):
            beyond = self.compute(test, index, limit, hint="beyond")
            index = self.compute("select", beyond, limit, index, hint="index")
        return index

    def as_integer(self, index: Operand) -> Operand:
        """Counter of a loop as an integer."""
        return self.assign("to_integer", (index,), Name("integer", "index", next(self.groups)))

    def signed(self, index: Operand) -> Operand:
        """Index as a signed integer, which the limits of an array are."""
        return self.as_integer(index) if index.kind == "bits" else index

    def scalars(self, array: Array) -> Scalars:
        """Elements of an array as scalars.

        Raises:
            InputError: The array is too large.
        """
        if array.size > self.scope.largest and not isinstance(array, np.ndarray):
            raise self.refused(
                f"an array of {'×'.join(map(str, array.shape))}",
                f"at most {self.scope.largest} elements, or rows read one at a time by an index "
                "(jax.lax.dynamic_slice)",
            )
        if isinstance(array, Deferred):
            inside = replace(self, where=array.source)
            kind, shape = array.kind, array.shape
            return inside._one_by_one(array.operation, kind, shape, array.operands)
        if isinstance(array, Data) and array.base is not None:
            return one_by_one(array.shape, lambda k: self._read(array, int(k)), array.places)
        scalars = array.elements() if isinstance(array, Data) else array
        if not any(isinstance(each, Element) for each in scalars.flat):
            return scalars
        return one_by_one(scalars.shape, self.scalar, scalars)

    def _read(self, data: Data, place: int) -> Operand:
        name = Name(data.table.kind, self.where.name, next(self.groups))
        return self.element(data.table, data.base or Number("index", 0), place, name)

    def scalar(self, each: Operand | Element) -> Operand:
        """Scalar, or element of a table as one."""
        if not isinstance(each, Element):
            return each
        name = Name(each.kind, self.where.name, next(self.groups))
        return self.element(each.table, Number("index", 0), each.place, name)

    def listed(self, array: Scalars) -> Data:
        """Array of scalars as data of a table with a list of all elements."""
        places = np.arange(array.size).reshape(array.shape)
        kind = array.flat[0].kind
        if all(isinstance(each, Number) for each in array.flat):
            return Data(
                constant_table(self.memo.tables, kind, [e.value for e in array.flat]), places
            )
        table = Table(kind, array.size, self.where.name)
        self.block.append(Fill(table, tuple(array.flat), self.where))
        return Data(table, places)

    def element(self, table: Table, index: Operand, offset: int, name: Name) -> Operand:
        """Append the reading of a table's element at an index plus a constant offset."""
        if isinstance(index, Number) and (table.memory or table.values or table.shape):
            return table.known(int(index.value) + offset)
        if not table.memory:
            return self.indexed(table, (self.index("add", index, Number("index", offset)),), name)
        operands = (index, Number("index", offset))
        self.block.append(Assign(name, "element", operands, self.where, table))
        return name

    def indexed(self, table: Table, indices: tuple[Operand, ...], name: Name) -> Operand:
        """Append the reading of a table's element at an index for each axis."""
        numbers = [int(each.value) for each in indices if isinstance(each, Number)]
        if (table.values or table.shape) and len(numbers) == len(indices):
            place = int(np.ravel_multi_index(numbers, table.shape)) if table.shape else numbers[0]
            return table.known(place)
        self.block.append(Assign(name, "element", indices, self.where, table))
        return name
