"""Test vectors: steps with the results of Python."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gyrostat.codegen.flight.module import Module, Precision
from gyrostat.core.jax64 import jax
from gyrostat.exports.target import STEPS, Target
from gyrostat.exports.vectors.conditioning import Conditioning, conditioning
from gyrostat.exports.vectors.fields import Field, fields_of, values_of, whole
from gyrostat.exports.vectors.python_run import PythonRun
from gyrostat.exports.vectors.rows import Row


@dataclass(frozen=True)
class Vectors:
    """Test vectors.

    Attributes:
        fields: Numbers of the module.
        rows: Steps; the first `STEPS` are the test run of the module.
        values: Values of all fields after each step in Python, (steps, fields).
        conditioning: What rounding before each step of the test run changes.
    """

    fields: tuple[Field, ...]
    rows: tuple[Row, ...]
    values: np.ndarray
    conditioning: Conditioning

    @property
    def inputs(self) -> tuple[int, ...]:
        """Indices of the inputs, which every step sets."""
        return tuple(k for k, field in enumerate(self.fields) if field.role == "input")

    def columns(self) -> tuple[int, ...]:
        """Indices of the fields that a step sets: the inputs, and all others that change."""
        changed = {k for row in self.rows for k in row.changes}
        return tuple(k for k in range(len(self.fields)) if k in changed)

    def csv(self) -> str:
        """One line for each step: its number, whether it begins anew, and the fields that it sets.

        The columns have the names of C, in the order of the header. An empty cell changes nothing.
        """
        columns = self.columns()
        head = ",".join(["row", "begins", *(self.fields[k].name for k in columns)])
        return "\n".join([head, *self._lines(columns), ""])

    def _lines(self, columns: tuple[int, ...]) -> Iterator[str]:
        for number, row in enumerate(self.rows):
            cells = (self._cell(k, row.changes.get(k)) for k in columns)
            yield ",".join([str(number), str(int(row.begins)), *cells])

    def _cell(self, index: int, value: float | None) -> str:
        if value is None:
            return ""
        if self.fields[index].kind == "real":
            return repr(value)
        return str(whole(np.array(value)).item())


def nominal_rows(target: Target, fields: tuple[Field, ...]) -> tuple[Row, ...]:
    """Test run of a module."""
    inputs = [k for k, field in enumerate(fields) if field.role == "input"]
    rows = []
    for step in range(STEPS):
        trees = {
            name: jax.tree.map(lambda x, k=step: x[k], tree) for name, tree in target.inputs.items()
        }
        values = values_of(fields, trees)
        rows.append(Row(step == 0, {k: float(values[k]) for k in inputs}))
    return tuple(rows)


def nominal_vectors(target: Target, module: Module, precision: Precision) -> Vectors:
    """Test run of a module, with the results of Python."""
    fields = fields_of(target, module)
    rows = nominal_rows(target, fields)
    python = PythonRun(target, fields, is_compiled=False)
    values = python.run(rows)
    rounding = conditioning(python, fields, rows, values, precision)
    return Vectors(fields, rows, values, rounding)
