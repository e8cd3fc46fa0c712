"""Conditioning of a test run: what rounding of the numbers before each step does to the results.

C and Python round in another order. A result may differ by as much as it changes if inputs and
memory change by a unit in the last place: this much is not known of the exact result either. A
wrong result, and one of an algorithm that is less accurate than its problem, differ by more.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.codegen.flight.module import Precision
from gyrostat.exports.vectors.fields import Field
from gyrostat.exports.vectors.python_run import PythonRun
from gyrostat.exports.vectors.rows import Row

UNIT = {"double": 2.0**-52, "float": 2.0**-23}
"""Relative change of a number by a unit in the last place."""
RUNS = 2
"""Number of runs with changes of random sign."""


CHANGES = 4.0
"""Error of a result that is allowed, relative to its change."""
MOST = 1000.0
"""Largest tolerance of an ill-conditioned result over that of others."""
NOISE = 0.1
"""Relative change of a result that is made of rounding errors: in half of the steps over its value
there, and once over its largest value."""
FEWEST = 5
"""Number of steps with a value or change from which a result counts as made of rounding errors. One
that is not zero in fewer may be an event, which comes a step later."""


@dataclass(frozen=True)
class Conditioning:
    """What is known of the results of a test run.

    Attributes:
        changes: Largest change of each number if inputs and memory change before every step,
            (fields,); 0 where one of the values is not finite.
        are_errors: Whether each number is made of rounding errors, such as the residual of an
            equation, (fields,): only its size is known.
        sizes: Largest finite value of each number, (fields,).
    """

    changes: np.ndarray
    are_errors: np.ndarray
    sizes: np.ndarray

    def allowed(self, places: Sequence[int], largest: np.ndarray, tolerance: float) -> np.ndarray:
        """Errors of some numbers that rounding explains.

        Args:
            places: Indices of the numbers.
            largest: Largest value of each.
            tolerance: Error of a well-conditioned number that is allowed, relative to that.
        """
        changes, are_errors = self.changes[places], self.are_errors[places]
        most = np.where(are_errors, np.inf, MOST * tolerance * largest)
        # of two values of errors one may be zero in C and not in Python; the size of its array,
        # which `largest` may contain, does not count
        changes = np.where(are_errors, np.maximum(changes, self.sizes[places]), changes)
        return np.minimum(CHANGES * changes, most)


def conditioning(
    python: PythonRun,
    fields: Sequence[Field],
    rows: Sequence[Row],
    values: np.ndarray,
    precision: Precision,
    otherwise: np.ndarray | None = None,
) -> Conditioning:
    """Change inputs and memory before every step of a run, and compare the results.

    Args:
        python: Functions in Python.
        fields: Numbers of the module.
        rows: Steps.
        values: Values of all fields after each step, (steps, fields).
        precision: Precision of real numbers in C.
        otherwise: Values of the same run with operations in another order.
    """
    random = np.random.default_rng(0)
    is_real = np.array([f.kind == "real" and f.role in ("input", "state") for f in fields])
    signs = random.choice([-1.0, 1.0], (RUNS, len(rows), len(fields)))
    runs = [python.run(rows, 1.0 + UNIT[precision] * each * is_real) for each in signs]
    runs += [] if otherwise is None else [otherwise]
    with np.errstate(invalid="ignore"):
        changes = np.abs(np.stack(runs) - values)
    changes = np.where(np.isfinite(changes), changes, 0.0)
    known = np.where(np.isfinite(values), np.abs(values), 0.0)
    sizes = np.max(known, axis=0)
    # a memory that is set within the run is zero before
    shown = np.maximum(known, changes)
    ratios = np.divide(changes, shown, out=np.zeros_like(changes), where=shown > 0.0)
    usual = np.ma.median(np.ma.masked_array(ratios, shown == 0.0), axis=1).filled(0.0)
    noisy = (usual > NOISE) & np.any(changes > NOISE * sizes, axis=1)
    noisy &= np.sum(shown > 0.0, axis=1) >= FEWEST
    are_real = np.array([f.kind == "real" for f in fields])
    return Conditioning(np.max(changes, axis=(0, 1)), are_real & np.any(noisy, axis=0), sizes)
