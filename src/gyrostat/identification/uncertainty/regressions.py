"""Linear regressions of many hypotheses that share their columns.

A hypothesis chooses a scale for each effect: the prior standard deviation of its coefficients, zero
where the effect is absent. Normal matrices are S P S + B with the products P of all columns, the
scales S and the information B of the prior, which is the identity for coefficients in prior sigmas.
Gaussian elimination leaves the Schur complement of the columns not yet eliminated, including the
residual. It depends only on the scales chosen so far: hypotheses that begin alike share it (Golub
and Van Loan, "Matrix Computations", sections 3.2.11 and 4.2).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector

Indices = NDArray[np.intp]


def _in_sigmas(mean: Vector | float, sigma: Vector) -> Vector:
    """Prior means in prior sigmas; zero for absent effects."""
    return np.divide(mean, sigma, out=np.zeros_like(sigma), where=sigma > 0.0)


@dataclass(frozen=True)
class Regressions:
    """Regressions of h hypotheses at g levels of torque noise.

    Attributes:
        products: Sums of products of the residual, n parameters and m coefficients,
            (g, 1 + n + m, 1 + n + m).
        information: Information matrix of the prior of the parameters, (n, n).
        pull: Information vector of the prior of the parameters, (n,).
        widths: Number of coefficients of each effect.
        choices: Scale of each effect, (h, effects); zero: absent.
        means: Prior means of the coefficients of each effect, relative to the linearisation.
    """

    products: Vector
    information: Matrix
    pull: Vector
    widths: Sequence[int]
    choices: Matrix
    means: Sequence[Vector]

    def deviances(self) -> Matrix:
        """Misfit plus log determinant of the normal matrix of every hypothesis, (g, h).

        The misfit is the sum of squares of the residual and of the distances from the prior means
        at the solution.

        Raises:
            numpy.linalg.LinAlgError: A normal matrix is not positive definite.
        """
        # wide effects first: large matrices are then shared by most hypotheses
        order = np.argsort(-np.array(self.widths, dtype=int), kind="stable")
        rows = np.lexsort(self.choices.T[order[::-1]]) if len(order) else np.zeros(1, dtype=int)
        choices = self.choices[rows]
        rest, determinant = self._without_parameters(order)
        rest, determinant = rest[:, None], determinant[:, None]
        group = np.zeros(len(choices), dtype=int)
        for k in order:
            begins = np.diff(group, prepend=-1) != 0
            begins[1:] |= choices[1:, k] != choices[:-1, k]
            scale, parent = choices[begins, k], group[begins]
            rest, determinant = rest[:, parent], determinant[:, parent]
            group = np.cumsum(begins) - 1
            for mean in self.means[k]:
                pull = _in_sigmas(mean, scale)
                cross = scale[:, None] * rest[:, :, 0, 1:]
                cross[..., -1] += pull
                pivot = 1.0 + scale**2 * rest[:, :, 0, 0]
                if not np.all(pivot > 0.0):
                    raise np.linalg.LinAlgError("normal matrix is not positive definite")
                share = cross / pivot[..., None]
                rest = rest[:, :, 1:, 1:] - cross[..., :, None] * share[..., None, :]
                rest[..., -1, -1] += pull**2
                determinant = determinant + np.log(pivot)
        results = np.empty((len(rest), len(choices)))
        results[:, rows] = (rest[:, :, 0, 0] + determinant)[:, group]
        return results

    def _without_parameters(self, order: Indices) -> tuple[Vector, Vector]:
        """Schur complements of the effects' columns in some order and the residual; log dets.

        Returns:
            Complements, (g, m + 1, m + 1), and log determinants of the parameters' block, (g,).
        """
        count = len(self.pull)
        first = 1 + count + np.cumsum([0, *self.widths])
        columns = [c for k in order for c in range(first[k], first[k + 1])]
        full = self.products.copy()
        full[:, 1 : count + 1, 1 : count + 1] += self.information
        full[:, 1 : count + 1, 0] += self.pull
        # the least distance from the prior of the parameters, without which this is no square
        nearest = np.linalg.pinv(self.information, hermitian=True)
        full[:, 0, 0] += float(self.pull @ nearest @ self.pull)
        block = full[:, 1 : count + 1, 1 : count + 1]
        # normalise: otherwise very different precisions of the parameters cause rounding errors
        unit = np.sqrt(np.diagonal(block, axis1=1, axis2=2))
        if not np.all(unit > 0.0):
            raise np.linalg.LinAlgError("normal matrix is not positive definite")
        factor = np.linalg.cholesky(block / (unit[:, :, None] * unit[:, None, :]))
        kept = [*columns, 0]
        across = np.linalg.solve(factor, full[:, 1 : count + 1][:, :, kept] / unit[:, :, None])
        rest = full[:, kept][:, :, kept] - across.transpose(0, 2, 1) @ across
        pivots = unit * np.diagonal(factor, axis1=1, axis2=2)
        return rest, 2.0 * np.sum(np.log(pivots), axis=1)

    def moments(self, level: Indices, which: Indices) -> tuple[Matrix, Vector, Matrix]:
        """Posteriors of some hypotheses.

        Args:
            level: Index of the level of each of k posteriors, (k,).
            which: Index of its hypothesis, (k,).

        Returns:
            Means of parameters and coefficients, (k, n + m); covariances of the parameters,
            (k, n, n); variances of parameters and coefficients, (k, n + m).
        """
        count, size = len(self.pull), len(self.pull) + sum(self.widths)
        spread = np.ones((len(which), size))
        spread[:, count:] = np.repeat(self.choices[which], self.widths, axis=1)
        right = spread * self.products[level, 1:, 0]
        right[:, :count] += self.pull
        right[:, count:] += _in_sigmas(np.concatenate([[], *self.means]), spread[:, count:])
        mean, variance = np.zeros((2, len(which), size))
        covariance = np.zeros((len(which), count, count))
        patterns, group = np.unique(spread > 0.0, axis=0, return_inverse=True)
        for k, present in enumerate(patterns):
            # in units of its prior sigma, the coefficient of an absent effect is zero
            at, rows = np.flatnonzero(present), np.flatnonzero(group == k)
            scale = spread[np.ix_(rows, at)]
            matrix = self.products[np.ix_(level[rows], 1 + at, 1 + at)]
            matrix *= scale[:, :, None] * scale[:, None, :]
            matrix[:, :count, :count] += self.information
            matrix[:, range(count, len(at)), range(count, len(at))] += 1.0
            unit = np.sqrt(np.diagonal(matrix, axis1=1, axis2=2))
            matrix /= unit[:, :, None] * unit[:, None, :]
            unit = scale / unit
            inverse = np.linalg.inv(matrix)
            solution = inverse @ (right[np.ix_(rows, at)] / scale * unit)[:, :, None]
            mean[np.ix_(rows, at)] = unit * solution[:, :, 0]
            variance[np.ix_(rows, at)] = unit**2 * np.diagonal(inverse, axis1=1, axis2=2)
            wide = unit[:, :count, None] * unit[:, None, :count]
            covariance[rows] = wide * inverse[:, :count, :count]
        return mean, covariance, variance
