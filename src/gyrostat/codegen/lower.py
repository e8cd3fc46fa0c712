"""Lower a jaxpr to a program of scalars: arrays become scalars, functions and loops stay."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gyrostat.codegen import control_flow, indexing, ordering, special, whole
from gyrostat.codegen.primitives import (
    ALIKE,
    COMPILED,
    ELEMENTWISE,
    FOLDED,
    LOGICAL_ONLY,
    MOVES,
    OVERFLOWING,
    REDUCTIONS,
    WRAPPED,
    Scalars,
    one_by_one,
)
from gyrostat.codegen.program import (
    Assign,
    Block,
    Call,
    Fill,
    Function,
    Kind,
    Name,
    Number,
    Operand,
    Table,
)
from gyrostat.codegen.scope import FLIGHT, Scope
from gyrostat.codegen.source import NOWHERE, Source, refusal, refused, source
from gyrostat.codegen.tracing import called, constant, own_function
from gyrostat.core.errors import InputError


class Lowering:
    """Lowers jaxprs; remembers the functions that it has made."""

    def __init__(self, scope: Scope = FLIGHT) -> None:
        self.scope = scope
        self.functions: list[Function] = []
        self._known: dict[int, tuple[Any, Function]] = {}
        self._groups = 0
        self._library_call: Source | None = None

    def graph(self, closed: Any, inputs: Sequence[Scalars], block: Block) -> list[Scalars]:
        """Append a closed jaxpr to a block and return its results."""
        jaxpr = closed.jaxpr
        constants = dict(zip(jaxpr.constvars, closed.consts, strict=True))
        values: dict[Any, Scalars] = dict(zip(jaxpr.invars, inputs, strict=True))

        def read(atom: Any) -> Scalars:
            value = constant(atom)
            if value is None and atom in constants:
                value = constants[atom]
            return values[atom] if value is None else self.numbers(value)

        for equation in jaxpr.eqns:
            self._refuse_arrays(equation)
            given = [read(atom) for atom in equation.invars]
            made = self._narrowed(equation, self._equation(equation, given, block), block)
            values.update(zip(equation.outvars, made, strict=True))
        return [read(atom) for atom in jaxpr.outvars]

    def numbers(self, array: Any) -> Scalars:
        """An array of constants."""
        array = self.scope.array(array)
        kind = self.scope.kind_of(array.dtype)
        if kind is None or array.size > self.scope.largest:
            raise InputError(
                f"constant: found {array.dtype}{list(array.shape)}, expected float64, integer or "
                f"logical arrays of at most {self.scope.largest} elements"
            )
        return one_by_one(array.shape, lambda value: Number(kind, value.item()), array)

    def names(self, atom: Any, origin: Source) -> Scalars:
        """An array of new names for a variable."""
        kind, group, shape = self.kind(atom), self.new_group(), atom.aval.shape
        made = np.empty(shape, dtype=object)
        for place in np.ndindex(shape):
            made[place] = Name(kind, origin.name, group, place)
        return made

    def assigned(
        self, block: Block, operation: str, operands: Sequence[Operand], target: Name, where: Source
    ) -> Operand:
        """The result of an operation on scalars: a constant, an operand, or assigned in a block."""
        if operation in whole.OPERATIONS and operands[0].kind != "real":
            return whole.lowered(self, block, operation, operands, target, where)
        if operation in FOLDED and all(isinstance(o, Number) for o in operands):
            value = FOLDED[operation](*(o.value for o in operands if isinstance(o, Number)))
            return Number(target.kind, WRAPPED.get(target.kind, lambda v: v)(value))
        if operation == "mul":
            for one, other in (operands, operands[::-1]):
                if one == Number("real", 1.0):
                    return other
        if operation == "select":
            test, yes, no = operands
            if isinstance(test, Number):
                return yes if test.value else no
            if yes is no or (isinstance(yes, Number) and repr(yes) == repr(no)):
                return yes
        if operation in LOGICAL_ONLY and len(operands) == 2 and target.kind == "logical":
            for one, other in (operands, operands[::-1]):
                if operation != "xor" and isinstance(one, Number):
                    return other if one.value == (operation == "and") else one
        block.append(Assign(target, operation, tuple(operands), where))
        return target

    def kind(self, atom: Any) -> Kind:
        """The kind of number of a variable."""
        kind = self.scope.kind_of(atom.aval.dtype)
        assert kind is not None  # `_refuse_arrays` has seen to it
        return kind

    def new_group(self) -> int:
        """A number for what one operation makes."""
        self._groups += 1
        return self._groups

    def applied(self, block: Block, operation: str, target: Any, where: Source, *arrays: Scalars):
        """Apply an operation to each element; `target` is the variable of the result."""
        names = self.names(target, where)

        def make(name: Name, *operands: Operand) -> Operand:
            return self.assigned(block, operation, operands, name, where)

        # a number may stand for an array of it
        filled = (np.broadcast_to(array, names.shape) for array in arrays)
        return one_by_one(names.shape, make, names, *filled)

    def tested(self, block: Block, test: str, array: Scalars, number: Number, where: Source):
        """Compare each element with a number."""
        group = self.new_group()

        def make(operand: Operand) -> Operand:
            name = Name("logical", where.name, group)
            return self.assigned(block, test, (operand, number), name, where)

        return one_by_one(array.shape, make, array)

    def folded(self, block: Block, operation: str, scalars: Sequence[Operand], where: Source):
        """Join scalars by an operation, the first ones first."""
        if not scalars:
            raise refusal(where, "a sum of no elements", "one or more")
        total, group = scalars[0], self.new_group()
        for scalar in scalars[1:]:
            name = Name(scalar.kind, where.name, group)
            total = self.assigned(block, operation, (total, scalar), name, where)
        return total

    def within(
        self, block: Block, index: Operand, first: Operand, last: Operand, where: Source
    ) -> Operand:
        """An index kept between the first and the last."""
        for test, limit in (("lt", first), ("gt", last)):
            beyond = Name("logical", "beyond", self.new_group())
            beyond = self.assigned(block, test, (index, limit), beyond, where)
            kept = Name("integer", "index", self.new_group())
            index = self.assigned(block, "select", (beyond, limit, index), kept, where)
        return index

    def picked(
        self, block: Block, body: Block, rows: Scalars, index: Operand, atom: Any, where: Source
    ) -> Scalars:
        """The row of a table, made in a block, at the index of a loop, read in its body."""
        names = self.names(atom, where)
        if not names.size:
            return names
        table = Table(self.kind(atom), rows.size, where.name)
        block.append(Fill(table, tuple(rows.flat), where))
        width = Number("integer", names.size)
        for offset, name in enumerate(names.flat):
            place: Operand = index
            for operation, other in (("mul", width), ("add", Number("integer", offset))):
                if other.value == (operation == "mul"):  # times 1, plus 0
                    continue
                made = Name("integer", "index", self.new_group())
                place = self.assigned(body, operation, (place, other), made, where)
            body.append(Assign(name, "element", (place,), where, table))
        return names

    def _equation(self, equation: Any, given: list[Scalars], block: Block) -> Sequence[Scalars]:
        name, params = equation.primitive.name, equation.params
        where = self.source(equation)
        inner = called(equation)
        if inner is not None:
            own = None if self.scope.in_place else own_function(equation, inner)
            if own is None:
                return self.library(inner, given, block, where)
            return self._call(own, inner, given, block, where)
        if any(array.shape == () and isinstance(array.item(), Table) for array in given):
            raise refused(equation, where, "rows of a long scan", "them only as a result")
        if name in self.scope.lowered:
            return self.scope.lowered[name](self, equation, given, block, where)
        if name in ALIKE:
            return given
        if name in MOVES:
            return [np.asarray(array, dtype=object) for array in MOVES[name](params, *given)]
        if name in REDUCTIONS:
            return [self._reduced(REDUCTIONS[name], params["axes"], given[0], block, where)]
        if name in control_flow.LOWERED:
            return control_flow.LOWERED[name](self, equation, given, block)
        if name in special.LOWERED:
            return [special.LOWERED[name](self, equation, given, block, where)]
        if name in indexing.LOWERED:
            return [indexing.LOWERED[name](self, equation, given, block, where)]
        if name in ordering.LOWERED:
            return ordering.LOWERED[name](self, equation, given, block, where)
        if name not in ELEMENTWISE:
            raise refused(equation, where, "a primitive", COMPILED)
        return [self.applied(block, ELEMENTWISE[name], equation.outvars[0], where, *given)]

    def _narrowed(self, equation: Any, made: Sequence[Scalars], block: Block) -> Sequence[Scalars]:
        if equation.primitive.name not in OVERFLOWING:
            return made
        target = equation.outvars[0]
        operation = self.scope.narrow.get(target.aval.dtype)
        if operation is None:
            return made
        return [self.applied(block, operation, target, self.source(equation), *made)]

    def source(self, equation: Any) -> Source:
        """Line of Python of an equation: inside a library's function, that which calls it."""
        return self._library_call or source(equation, NOWHERE)

    def library(self, inner: Any, given: list[Scalars], block: Block, where: Source):
        """Append what a function of a library does; JAX traces such a function only once."""
        before, self._library_call = self._library_call, where
        results = self.graph(inner, given, block)
        self._library_call = before
        return results

    def _call(self, name: str, inner: Any, given: list[Scalars], block: Block, where: Source):
        """Call a function of scalars, lowered at its first call."""
        # the jaxpr is kept with its function: an id is one's own only as long as one lives
        if id(inner.jaxpr) not in self._known:
            body: Block = []
            hinted = [
                self.names(variable, where._replace(name=control_flow.argument_name(inner, k)))
                for k, variable in enumerate(inner.jaxpr.invars)
            ]
            results = self.graph(inner, hinted, body)
            function = Function(name, _flat(hinted), body, _flat(results), where)
            self.functions.append(function)
            self._known[id(inner.jaxpr)] = (inner, function)
        function = self._known[id(inner.jaxpr)][1]
        results = [self.names(variable, where) for variable in inner.jaxpr.outvars]
        block.append(Call(function, _flat(given), _flat(results), where))
        return results

    def _reduced(
        self, operation: str, axes: Sequence[int], array: Scalars, block: Block, where: Source
    ) -> Scalars:
        kept = [axis for axis in range(array.ndim) if axis not in axes]
        count = int(np.prod([array.shape[k] for k in axes]))
        rows = array.transpose([*kept, *axes]).reshape([*(array.shape[k] for k in kept), count])
        made = np.empty(rows.shape[:-1], dtype=object)
        for place in np.ndindex(made.shape):
            made[place] = self.folded(block, operation, list(rows[place]), where)
        return made

    def _refuse_arrays(self, equation: Any) -> None:
        where = self.source(equation)
        # results of a long scan are kept tables, no scalars
        long = equation.params.get("length", 0) > self.scope.longest or called(equation) is not None
        for atom in (*equation.invars, *equation.outvars):
            size, dtype = int(np.prod(atom.aval.shape)), atom.aval.dtype
            is_kept = long and np.isfinite(self.scope.longest) and atom in equation.outvars
            if size > self.scope.largest and not is_kept:
                found = "×".join(map(str, atom.aval.shape))
                expected = f"at most {self.scope.largest} elements"
                raise refused(equation, where, f"an array of {found}", expected)
            if self.scope.kind_of(dtype) is None and str(dtype).startswith("key<"):
                raise refused(equation, where, "random numbers", "none: flight code draws no noise")
            if self.scope.kind_of(dtype) is None:
                expected = "float64, int32, int64 or logical ones"
                raise refused(equation, where, f"numbers of type {dtype}", expected)


def _flat(arrays: Sequence[Scalars]) -> list[Any]:
    return [scalar for array in arrays for scalar in array.flat]
