"""Nonlinear least squares with a-priori information in square-root form, solved by Householder QR.

The whitened a-priori and the whitened measurements are stacked and triangularised; the triangle is
the square root of the information matrix. Carrara and Kuga, eqs. (10)-(14), after Lawson and
Hanson, "Solving Least Squares Problems" (1974); here iterated on the correction, with the a-priori
residual always taken relative to the original a-priori.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.loss import Loss

Evaluation = tuple[Vector, Matrix]

FIRST_DAMPING, DAMPING_STEP = 0.01, 30.0
"""Damping of a correction after a full one has failed, as a fraction of the squared column norms,
and the factor by which it grows with every further failure and falls with success."""
KINK, CORNER = 0.1, 2.0
"""Convergence at a kink of the cost, in standard deviations. A sample at a zero crossing, or a
start from rest, gives the cost a kink, which may be its minimum. The iteration has converged if
damped corrections down to the first value do not lower the cost and the undamped one is below the
second. The second test is needed because damping makes any correction small."""

UNFINISHED = "the iterations ran out"
WALL = "every smaller correction led to parameters that are not admissible"
STALLED = "no correction lowered the cost"


@dataclass(frozen=True)
class Prior:
    """A-priori knowledge of parameters, or of differences between them, all independent.

    Attributes:
        mean: Means in the units of the parameters, (n,).
        sigma: Standard deviations, (n,); infinite if nothing is known.
        differences: Index of a parameter -> index of its reference. The sigma of the parameter then
            applies to its difference from the reference; the mean of this difference is the
            difference of the means.
    """

    mean: Vector
    sigma: Vector
    differences: Mapping[int, int] = field(default_factory=dict)

    @classmethod
    def unknown(cls, count: int) -> Self:
        """No a-priori knowledge of a number of parameters."""
        return cls(np.zeros(count), np.full(count, np.inf))

    def rows(self) -> Matrix:
        """Whitened rows of the a-priori knowledge, (k, n)."""
        rows = np.diag(1.0 / self.sigma)
        for index, reference in self.differences.items():
            rows[index, reference] = -rows[index, index]
        return rows[np.isfinite(self.sigma)]

    def residual(self, x: Vector) -> Vector:
        """Whitened distance from the a-priori, (k,)."""
        return self.rows() @ (x - self.mean)

    def information(self) -> Matrix:
        """Information matrix, (n, n)."""
        rows = self.rows()
        return rows.T @ rows


@dataclass(frozen=True)
class Solution:
    """Result of an iteration.

    Attributes:
        x: Parameters, (n,).
        reason: Reason why the iteration did not converge; empty if it did.
        iterations: Corrections tried, including rejected ones.
        cost: Half the sum of the loss of measurements and a-priori.
        residual: Whitened measurement residuals, measured minus modelled, (m,).
        jacobian: Jacobian of the whitened modelled measurements, (m, n).
        triangle: Upper triangular square root of the information matrix, (n, n).
    """

    x: Vector
    reason: str
    iterations: int
    cost: float
    residual: Vector
    jacobian: Matrix
    triangle: Matrix

    @property
    def converged(self) -> bool:
        """Whether the last full correction was negligible relative to the uncertainty."""
        return not self.reason

    def covariance(self) -> Matrix:
        """Formal covariance of the parameters for unit measurement noise, (n, n)."""
        inverse = np.linalg.inv(self.triangle)
        return inverse @ inverse.T


def triangularise(rows: Matrix, right: Vector) -> tuple[Matrix, Vector]:
    """Reduce a stacked system to its triangle by Householder QR, eq. (12).

    Args:
        rows: Rows of the system, (m, n) with m >= n.
        right: Right-hand side, (m,).

    Returns:
        The (n, n) upper triangle H_1 and the (n,) vector y_1.
    """
    count = rows.shape[1]
    # LAPACK's Householder triangle of the system with its right-hand side as a last column
    triangle: Matrix = np.linalg.qr(np.column_stack([rows, right]), mode="r")  # pyright: ignore[reportAssignmentType]
    return triangle[:count, :count], triangle[:count, count]


@dataclass(frozen=True)
class _Problem:
    """Measurements and a-priori as one cost, and as one stack of whitened rows."""

    prior: Prior
    loss: Loss

    def cost(self, x: Vector, residual: Vector) -> float:
        """Half the sum of the loss of measurements and a-priori."""
        misfit = np.sum(self.prior.residual(x) ** 2)
        return 0.5 * float(misfit) + float(np.sum(self.loss.value(residual)))

    def stack(self, x: Vector, point: Evaluation) -> tuple[Matrix, Vector]:
        """Rows and right-hand side of the linear problem for a correction of x."""
        residual, jacobian = point
        weight = np.sqrt(self.loss.weight(residual))
        rows = np.vstack([self.prior.rows(), weight[:, None] * jacobian])
        return rows, np.concatenate([-self.prior.residual(x), weight * residual])


def minimise(
    evaluate: Callable[[Vector], Evaluation | None],
    start: Vector,
    prior: Prior,
    loss: Loss,
    *,
    tolerance: float = 1e-2,
    max_iterations: int = 50,
    on_iteration: Callable[[int, float], None] | None = None,
) -> Solution | None:
    """Iterate Gauss-Newton corrections, damped only if a full one does not lower the cost.

    Args:
        evaluate: Function from parameters (n,) to whitened measurement residuals (m,), measured
            minus modelled, and the whitened Jacobian (m, n) of the modelled measurements; None if
            the parameters are not admissible. NaN rows are not allowed: omit missing measurements.
        start: Start values, (n,).
        prior: A-priori knowledge.
        loss: Loss of one whitened residual.
        tolerance: Size of a correction, in standard deviations, below which the iteration ends.
        max_iterations: Largest number of corrections.
        on_iteration: Function called with the count and the cost after each correction.

    Returns:
        The solution; None if the start values are not admissible.
    """
    problem = _Problem(prior, loss)
    point = evaluate(start)
    if point is None:
        return None
    x, cost, iterations, damping = start, problem.cost(start, point[0]), 0, 0.0
    reason = UNFINISHED
    while iterations < max_iterations and reason == UNFINISHED:
        rows, right = problem.stack(x, point)
        size = np.linalg.norm(rows, axis=0)
        triangle, full = triangularise(rows, right)
        while iterations < max_iterations:
            iterations += 1
            stack = np.vstack([rows, np.sqrt(damping) * np.diag(size)])
            h1, y1 = triangularise(stack, np.concatenate([right, np.zeros(len(x))]))
            correction = np.linalg.solve(h1, y1)
            in_sigmas = float(np.linalg.norm(triangle @ correction))
            trial = x + correction
            trial_point = evaluate(trial)
            trial_cost = np.inf if trial_point is None else problem.cost(trial, trial_point[0])
            # near the optimum the cost changes by less than its rounding error
            if trial_point is not None and trial_cost <= cost + 1e-12 * abs(cost) + 1e-12:
                x, point, cost = trial, trial_point, trial_cost
                reason = "" if in_sigmas < tolerance and damping == 0.0 else UNFINISHED
                damping = 0.0 if damping <= FIRST_DAMPING else damping / DAMPING_STEP
                break
            if in_sigmas < KINK:
                failure = WALL if trial_point is None else STALLED
                near = KINK if trial_point is None else CORNER
                reason = "" if np.linalg.norm(full) < near else failure
                break
            damping = max(DAMPING_STEP * damping, FIRST_DAMPING)
        if on_iteration is not None:
            on_iteration(iterations, cost)
    triangle, _ = triangularise(*problem.stack(x, point))
    return Solution(x, reason, iterations, cost, point[0], point[1], triangle)
