"""Conditioning of a test run: what rounding of the numbers before each step does to the results.

C and Python round in another order. A result may differ by as much as it changes if inputs and
memory change by a unit in the last place: this much is not known of the exact result either. A
wrong result, and one of an algorithm that is less accurate than its problem, differ by more.
"""

from collections.abc import Sequence

import numpy as np

from gyrostat.codegen.flight.module import Precision
from gyrostat.exports.vectors.fields import Field
from gyrostat.exports.vectors.python_run import PythonRun
from gyrostat.exports.vectors.rows import Row

UNIT = {"double": 2.0**-52, "float": 2.0**-23}
"""Relative change of a number by a unit in the last place."""
RUNS = 2
"""Number of runs with changes of random sign."""


def conditioning(
    python: PythonRun,
    fields: Sequence[Field],
    rows: Sequence[Row],
    values: np.ndarray,
    precision: Precision,
) -> np.ndarray:
    """Largest change of each number in a run if inputs and memory change before every step.

    Args:
        python: Functions in Python.
        fields: Numbers of the module.
        rows: Steps.
        values: Values of all fields after each step, (steps, fields).
        precision: Precision of real numbers in C.

    Returns:
        Changes, (fields,); 0 where one of the values is not finite.
    """
    random = np.random.default_rng(0)
    is_real = np.array([f.kind == "real" and f.role in ("input", "state") for f in fields])
    largest = np.zeros(len(fields))
    for _ in range(RUNS):
        signs = random.choice([-1.0, 1.0], (len(rows), len(fields)))
        changed = python.run(rows, 1.0 + UNIT[precision] * signs * is_real)
        with np.errstate(invalid="ignore"):
            change = np.abs(changed - values)
        largest = np.maximum(largest, np.max(np.where(np.isfinite(change), change, 0.0), axis=0))
    return largest
