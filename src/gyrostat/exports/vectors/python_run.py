"""Run of test vectors in Python."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from gyrostat.codegen.evaluation import evaluated
from gyrostat.codegen.flight.module import Entry
from gyrostat.codegen.tracing import as_arrays
from gyrostat.core.jax64 import jax
from gyrostat.exports.target import Target
from gyrostat.exports.vectors.fields import Field, whole
from gyrostat.exports.vectors.rows import Row


class PythonRun:
    """Functions of a flight module in Python, as functions of the values of all fields.

    Attributes:
        tuned: Values of all fields before the first step; 0 where they are not set yet.
    """

    def __init__(self, target: Target, fields: Sequence[Field], *, is_compiled: bool) -> None:
        """Evaluate the first function.

        Args:
            target: Flight module.
            fields: Numbers of the module.
            is_compiled: Whether the functions are compiled, which takes longer than the 40 steps of
                a test run, but not than a search.
        """
        self._target = target
        compiled = jax.jit if is_compiled else evaluated
        self._functions = {entry.name: compiled(entry.function) for entry in target.entries}
        places: dict[str, list[int]] = {}
        for k, field in enumerate(fields):
            places.setdefault(field.port, []).append(k)
        self._places = {name: np.array(indices) for name, indices in places.items()}
        self._size = len(fields)
        self._examples = self._zeros() | as_arrays(dict(target.constants))
        trees = dict(self._examples)
        self._call(target.begin[0], trees)
        self.tuned = self._vector(trees)

    def _zeros(self) -> dict[str, Any]:
        """Trees of zeros for all arguments and results."""
        every: dict[str, Any] = {}
        for entry in self._target.entries:
            arguments = {name: as_arrays(tree) for name, tree in entry.arguments.items()}
            results = jax.eval_shape(entry.function, *arguments.values())
            for name, tree in (*arguments.items(), *entry.named(results).items()):
                zeros = jax.tree.map(lambda x: np.zeros(x.shape, x.dtype), tree)
                every.setdefault(name, zeros)
        return every

    def _vector(self, trees: dict[str, Any]) -> np.ndarray:
        """Values of all fields."""
        numbers = np.zeros(self._size)
        for name, indices in self._places.items():
            leaves = [np.asarray(leaf).reshape(-1) for leaf in jax.tree.leaves(trees[name])]
            numbers[indices] = np.concatenate(leaves)
        return numbers

    def _trees(self, numbers: np.ndarray) -> dict[str, Any]:
        """Arguments with the values of the fields."""
        trees = dict(self._examples)
        for name, indices in self._places.items():
            leaves, structure = jax.tree.flatten(trees[name])
            values, start, changed = numbers[indices], 0, []
            for leaf in leaves:
                part = values[start : start + leaf.size]
                part = whole(part) if np.issubdtype(leaf.dtype, np.integer) else part
                changed.append(part.reshape(leaf.shape).astype(leaf.dtype))
                start += leaf.size
            trees[name] = jax.tree.unflatten(structure, changed)
        return trees

    def _call(self, entry: Entry, trees: dict[str, Any]) -> None:
        results = self._functions[entry.name](*(trees[name] for name in entry.arguments))
        trees.update(entry.named(results))

    def step(self, values: np.ndarray, *, begins: bool) -> np.ndarray:
        """Values of all fields after a step.

        Args:
            values: Values before it, (fields,).
            begins: Whether the functions that set the state are called first.
        """
        trees = self._trees(values)
        for entry in (*self._target.begin[1:],) * begins + self._target.steps:
            self._call(entry, trees)
        return self._vector(trees)

    def run(self, rows: Iterable[Row], factors: np.ndarray | None = None) -> np.ndarray:
        """Values of all fields after each step, (steps, fields).

        Args:
            rows: Steps.
            factors: Factors of the values before each step, (steps, fields).
        """
        values, history = self.tuned, []
        for number, row in enumerate(rows):
            values = (self.tuned if row.begins else values).copy()
            values[[*row.changes]] = [*row.changes.values()]
            if factors is not None:
                values *= factors[number]
            values = self.step(values, begins=row.begins)
            history.append(values)
        return np.array(history)
