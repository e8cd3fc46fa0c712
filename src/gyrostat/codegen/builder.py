"""Builder: appends the statements of one equation of a jaxpr to a block of a program."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from gyrostat.codegen import whole
from gyrostat.codegen.data import Data
from gyrostat.codegen.primitives import FOLDED, LOGICAL_ONLY, TEST, WRAPPED, Scalars, one_by_one
from gyrostat.codegen.program import Assign, Block, Fill, Name, Number, Operand, Table
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
    """

    equation: Any
    block: Block
    where: Source
    scope: Scope
    groups: Iterator[int]
    lower: Callable[..., list[Scalars | Data]]

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
        if operation in whole.OPERATIONS and operands[0].kind != "real":
            return whole.OPERATIONS[operation](
                lambda inner, *inputs: self.compute(inner, *inputs, hint=target.hint), *operands
            )
        if operation in FOLDED and all(isinstance(o, Number) for o in operands):
            value = FOLDED[operation](*(o.value for o in operands if isinstance(o, Number)))
            return Number(target.kind, WRAPPED.get(target.kind, lambda v: v)(value))
        if operation == "mul":
            for first, second in (operands, operands[::-1]):
                if first == Number("real", 1.0):
                    return second
        if operation == "select":
            test, yes, no = operands
            if isinstance(test, Number):
                return yes if test.value else no
            if yes is no or (isinstance(yes, Number) and repr(yes) == repr(no)):
                return yes
        if operation in LOGICAL_ONLY and len(operands) == 2 and target.kind == "logical":
            for first, second in (operands, operands[::-1]):
                if operation != "xor" and isinstance(first, Number):
                    return second if first.value == (operation == "and") else first
        self.block.append(Assign(target, operation, tuple(operands), self.where))
        return target

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

    def apply(self, operation: str, *arrays: Any) -> Scalars:
        """Apply an operation to each element; an array without axes is broadcast."""
        names = self.names(self.target)

        def make(name: Name, *operands: Operand) -> Operand:
            return self.assign(operation, operands, name)

        broadcast = (np.broadcast_to(array, names.shape) for array in arrays)
        return one_by_one(names.shape, make, names, *broadcast)

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

    def signed(self, index: Operand) -> Operand:
        """Index as a signed integer, which the limits of an array are."""
        if index.kind != "bits":
            return index
        return self.assign("to_integer", (index,), Name("integer", "index", next(self.groups)))

    def scalars(self, array: Scalars | Data) -> Scalars:
        """Elements of an array as scalars.

        Raises:
            InputError: The array is too large.
        """
        if not isinstance(array, Data):
            return array
        if array.size > self.scope.largest:
            raise self.refused(
                f"an array of {'×'.join(map(str, array.shape))}",
                f"at most {self.scope.largest} elements, or rows read one at a time by an index "
                "(jax.lax.dynamic_slice)",
            )
        return array.scalars()

    def table(self, array: Scalars | Data) -> tuple[Table, int, list[int]]:
        """Table that contains an array, to be read at a computed index.

        Returns:
            The table, the index of the array's first element, and the distance between neighbours
            along each axis.
        """
        strides = array.strides() if isinstance(array, Data) else None
        if isinstance(array, Data) and strides is not None:
            return array.table, int(array.places.flat[0]), strides
        array = self.scalars(array)
        table = Table(array.flat[0].kind, array.size, self.where.name)
        self.block.append(Fill(table, tuple(array.flat), self.where))
        return table, 0, [int(np.prod(array.shape[k + 1 :])) for k in range(array.ndim)]

    def element(self, table: Table, index: Operand, offset: int, name: Name) -> Operand:
        """Append the reading of a table's element at an index plus a constant offset."""
        constant = Number("integer", offset)
        if (table.memory or table.values) and isinstance(index, Number):
            return table.known(int(index.value) + offset)
        if not table.memory and offset:
            index = self.compute("add", index, constant, hint="index")
        operands = (index, constant) if table.memory else (index,)
        self.block.append(Assign(name, "element", operands, self.where, table))
        return name
