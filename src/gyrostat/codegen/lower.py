"""Lower a jaxpr to a program: small arrays become scalars, large ones tables that loops fill."""

import math
from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from functools import partial
from itertools import count
from typing import Any

import numpy as np

from gyrostat.codegen.arrays import SMALL, Array, Data, Deferred, is_plain
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.constants import constant_table
from gyrostat.codegen.control_flow import argument_name, is_rows
from gyrostat.codegen.given import are_scalars, are_small, key, read_in_place
from gyrostat.codegen.memo import Memo
from gyrostat.codegen.nests import filled
from gyrostat.codegen.primitives import (
    ALIKE,
    COMPILED,
    ELEMENTWISE,
    MOVES,
    OVERFLOWING,
    Scalars,
)
from gyrostat.codegen.program import Block, Call, Function
from gyrostat.codegen.repeated import distinct
from gyrostat.codegen.row_loops import directed, moved_rows, rows_of
from gyrostat.codegen.row_tables import settled_rows
from gyrostat.codegen.rules import OF_ARRAYS, ROW_BY_ROW, RULES
from gyrostat.codegen.scope import FLIGHT, TYPES, Scope
from gyrostat.codegen.source import NOWHERE, Source, UnsupportedError, refused, source
from gyrostat.codegen.tracing import called, constant, is_own, own_function


class Lowering:
    """Lower jaxprs, with a cache of the functions made so far."""

    def __init__(self, scope: Scope = FLIGHT) -> None:
        self.functions: list[Function] = []
        self._scope = scope
        self._unchanged: Mapping[str, Hashable] = {}
        self._known: dict[Hashable, tuple[Any, Function]] = {}
        self._groups = count(1)
        self._library_call: Source | None = None
        self._large: dict[int, tuple[Any, Data | None]] = {}
        self.memo = Memo()

    def graph(self, closed: Any, inputs: Sequence[Array], block: Block) -> list[Scalars]:
        """Append a closed jaxpr to a block and return its results as scalars.

        Args:
            closed: Closed jaxpr.
            inputs: Arguments.
            block: Block that the statements are appended to.
        """
        return [self.builder(block).scalars(a) for a in self.arrays(closed, inputs, block)]

    def entry(
        self,
        closed: Any,
        inputs: Sequence[Array],
        block: Block,
        unchanged: Mapping[str, Hashable],
    ) -> list[Array]:
        """Append the closed jaxpr of an entry to a block and return its results.

        Args:
            closed: Closed jaxpr.
            inputs: Arguments.
            block: Block that the statements are appended to.
            unchanged: Type of each argument of the caller that the entry does not change.
        """
        self._unchanged = unchanged
        return self.arrays(closed, inputs, block)

    def arrays(
        self,
        closed: Any,
        inputs: Sequence[Array],
        block: Block,
        called_at: Source | None = None,
        *,
        by_row: bool = False,
    ) -> list[Array]:
        """Append a closed jaxpr to a block and return its results.

        Args:
            closed: Closed jaxpr.
            inputs: Arguments.
            block: Block that the statements are appended to.
            called_at: Line of Python that all statements get, if the jaxpr is a function of a
                library. JAX traces such a function only once.
            by_row: Whether results may be scalars of rows of loops, see `row_loops`.
        """
        outer, self._library_call = self._library_call, called_at or self._library_call
        jaxpr = closed.jaxpr
        unique = distinct(jaxpr)
        read_atoms = [atom for e in unique.equations for atom in e.invars] + jaxpr.outvars
        uses = Counter(unique.first(atom) for atom in read_atoms if constant(atom) is None)
        constants = dict(zip(jaxpr.constvars, closed.consts, strict=True))
        values: dict[Any, Array] = {}

        def keep(variables: Sequence[Any], arrays: Sequence[Array], build: Builder) -> None:
            for variable, array in zip(variables, arrays, strict=True):
                # an operation that is used once is computed where it is used
                is_used_again = isinstance(array, Deferred) and uses[variable] > 1
                values[variable] = filled(build, array) if is_used_again else array

        def read(atom: Any) -> Array:
            value = constant(atom)
            if value is None and atom in constants:
                value = constants[atom]
            if value is None:
                return values[unique.first(atom)]
            return self._data(value) or self._scope.numbers(value)

        def lookup(atom: Any) -> Array | None:
            value = constants.get(atom) if constant(atom) is None else constant(atom)
            return values.get(unique.first(atom)) if value is None else self._data(value)

        keep(jaxpr.invars, inputs, self.builder(block, called_at or NOWHERE))
        for equation in unique.equations:
            where = self._library_call or source(equation, NOWHERE)
            build = self.builder(block, where, equation)
            try:
                self._refuse_arrays(build, [lookup(atom) for atom in equation.invars])
                results = self._equation(build, [read(atom) for atom in equation.invars])
                if isinstance(results, np.ndarray | Data | Deferred):
                    results = [results]
                results = self._narrow(build, results)
                keep(equation.outvars, results, build)
            except UnsupportedError as error:
                error.equations.append(equation)
                raise
        self._library_call = outer
        results = [read(atom) for atom in jaxpr.outvars]
        build = self.builder(block, called_at or NOWHERE)
        return results if by_row else [settled_rows(build, array) for array in results]

    def builder(self, block: Block, where: Source = NOWHERE, equation: Any = None) -> Builder:
        """Builder that appends the statements of an equation to a block."""
        return Builder(equation, block, where, self._scope, self._groups, self.arrays, self.memo)

    def _equation(self, build: Builder, operands: Sequence[Array]) -> Array | Sequence[Array]:
        inner, name = called(build.equation), build.equation.primitive.name
        if inner is not None:
            function = None if self._scope.in_place else own_function(build.equation, inner)
            results = None if function is None else self._call(function, inner, operands, build)
            if results is not None:
                return results
            called_at = None if is_own(build.equation, inner) else build.where
            return self.arrays(inner, operands, build.block, called_at, by_row=True)
        if name in ALIKE:
            return operands
        operands = rows_of(build, operands, are_rows=name in ROW_BY_ROW)
        if name in ("slice", "split"):
            operands = [moved_rows(build, operands[0], partial(MOVES[name], build.params))]
        if name in ELEMENTWISE and all(map(is_plain, operands)):
            operands = directed(build, operands, build.shape)
        if any(is_rows(array) for array in operands):
            raise build.refused("rows of a long scan", "them only as a result")
        if name not in OF_ARRAYS:
            operands = [self._scalars(build, array) for array in operands]
        rule = self._scope.rules.get(name) or RULES.get(name)
        if rule is None:
            raise build.refused("a primitive", COMPILED)
        return rule(build, *operands)

    def _scalars(self, build: Builder, array: Array) -> Scalars:
        """Elements of an array; a loop computes those of a large deferred operation."""
        if isinstance(array, Deferred) and array.size > self._scope.few:
            array = filled(build, array)
        return build.scalars(array)

    def _data(self, value: Any) -> Data | None:
        """Large constant as data of one table, wherever it is read; None if it is not large."""
        # keep the constant alive with its table: the id of a deleted object may be reused
        if id(value) not in self._large:
            array, data = self._scope.array(value), None
            kind = self._scope.kind_of(array.dtype)
            if kind is not None and array.size > SMALL:
                table = constant_table(self.memo.tables, kind, array.ravel().tolist())
                data = Data(table, np.arange(array.size).reshape(array.shape))
            self._large[id(value)] = (value, data)
        return self._large[id(value)][1]

    def _narrow(self, build: Builder, arrays: Sequence[Array]) -> Sequence[Array]:
        name = build.equation.primitive.name
        if name not in OVERFLOWING:
            return arrays
        operation = self._scope.narrow.get(build.target.aval.dtype)
        return arrays if operation is None else [build.apply(operation, *arrays)]

    def _call(
        self, name: str, inner: Any, operands: Sequence[Array], build: Builder
    ) -> list[Scalars] | None:
        """Append a call of a function, which is lowered at its first call.

        Returns:
            Results; None if not all operands and results can be those of a function in C.
        """
        in_place = read_in_place(operands, self._unchanged)
        passed = [array for array, is_read in zip(operands, in_place, strict=True) if not is_read]
        if not are_scalars(passed) or not are_small(build.equation.outvars):
            return None
        # keep the jaxpr alive with its function: the id of a deleted object may be reused
        known = (
            id(inner.jaxpr),
            *(
                key(array, self._unchanged) if is_read else None
                for array, is_read in zip(operands, in_place, strict=True)
            ),
        )
        if known not in self._known:
            body: Block = []
            names = {
                k: build.names(inner.jaxpr.invars[k], argument_name(inner, k))
                for k, is_read in enumerate(in_place)
                if not is_read
            }
            arguments = [names.get(k, array) for k, array in enumerate(operands)]
            results = self.graph(inner, arguments, body)
            parameters = _flat([*names.values()])
            function = Function(name, parameters, body, _flat(results), build.where)
            self.functions.append(function)
            self._known[known] = (inner, function)
        function = self._known[known][1]
        inputs = [build.scalars(array) for array in passed]
        results = [build.names(variable) for variable in inner.jaxpr.outvars]
        build.block.append(Call(function, _flat(inputs), _flat(results), build.where))
        return results

    def _refuse_arrays(self, build: Builder, operands: Sequence[Array | None]) -> None:
        """Check that arrays are not too large and of a supported type; raises `InputError`."""
        scope, equation, where = self._scope, build.equation, build.where
        for k, atom in enumerate((*equation.invars, *equation.outvars)):
            dtype = atom.aval.dtype
            if math.prod(atom.aval.shape) > scope.largest and not (
                isinstance(operands[k], Data)
                if k < len(operands)
                else _keeps_data(scope, equation, operands)
            ):
                found = "×".join(map(str, atom.aval.shape))
                expected = f"at most {scope.largest} elements"
                raise refused(equation, where, f"an array of {found}", expected)
            if scope.kind_of(dtype) is not None:
                continue
            if str(dtype).startswith("key<") or equation.primitive.name.startswith("random_"):
                raise refused(equation, where, "random numbers", "none: flight code draws no noise")
            raise refused(equation, where, f"numbers of type {dtype}", f"{TYPES} ones")


def _keeps_data(scope: Scope, equation: Any, operands: Sequence[Array | None]) -> bool:
    """Whether results are not kept as scalars.

    These are results of a long scan, of an operation that is composed of others, and of one that
    only rearranges the elements of data.
    """
    if np.isfinite(scope.longest) and (
        equation.params.get("length", 0) > scope.longest or called(equation) is not None
    ):
        return True
    if len(operands) != 1 or not isinstance(operands[0], Data):
        return False
    name = equation.primitive.name
    if name == "convert_element_type":
        return equation.invars[0].aval.dtype == equation.outvars[0].aval.dtype
    return name in MOVES or name in ALIKE


def _flat(arrays: Sequence[Scalars]) -> list[Any]:
    return [scalar for array in arrays for scalar in array.flat]
