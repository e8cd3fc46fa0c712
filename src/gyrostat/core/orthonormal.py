"""Orthonormal polynomials of a random variable.

The variable is given by its share, the value of its cumulative distribution function.
"""

from collections.abc import Callable
from math import factorial
from typing import NamedTuple

import numpy as np
from numpy.polynomial.hermite_e import hermevander
from numpy.polynomial.legendre import legvander

from gyrostat.core.types import Matrix, Vector

BOUNDED, UNBOUNDED = 10, 6
"""Largest degree for a variable with bounds, and for one without."""


class Family(NamedTuple):
    """Orthonormal polynomials of a variable.

    Attributes:
        highest: Largest degree.
        values: Function of shares, (n,), and a largest degree: polynomials, (n, degree + 1).
    """

    highest: int
    values: Callable[[Vector, int], Matrix]


def _legendre(share: Vector, degree: int) -> Matrix:
    scale = np.sqrt(2.0 * np.arange(degree + 1) + 1.0)
    return np.asarray(legvander(2.0 * share - 1.0, degree) * scale, np.float64)


def _hermite(share: Vector, degree: int) -> Matrix:
    from scipy.special import ndtri  # slow to import

    scale = 1.0 / np.sqrt([float(factorial(n)) for n in range(degree + 1)])
    return np.asarray(hermevander(ndtri(share), degree) * scale, np.float64)


LEGENDRE = Family(BOUNDED, _legendre)
"""Polynomials of a uniform variable."""
HERMITE = Family(UNBOUNDED, _hermite)
"""Polynomials of a normal variable."""


def family_of(quantile: Callable[[Vector], Vector], *, is_bounded: bool) -> Family:
    """Polynomials of a variable, by the discretised Stieltjes procedure.

    W. Gautschi, Orthogonal Polynomials: Computation and Approximation, 2004, section 2.2.

    Args:
        quantile: Quantile function, of shares, (n,); increasing.
        is_bounded: Whether the variable has bounds.
    """
    nodes, weights = _nodes()
    points = quantile(nodes)
    mean = float(weights @ points)
    size = np.sqrt(weights @ (points - mean) ** 2)

    def values(share: Vector, degree: int) -> Matrix:
        # the recurrence of the nodes is that of the values
        return _stieltjes((points - mean) / size, weights, (quantile(share) - mean) / size, degree)

    return Family(BOUNDED if is_bounded else UNBOUNDED, values)


def _nodes() -> tuple[Vector, Vector]:
    """Nodes in (0, 1) and weights of the tanh-sinh rule, whose ends may be singular.

    H. Takahasi and M. Mori, "Double exponential formulas for numerical integration", 1974.
    """
    step = np.linspace(-3.0, 3.0, 241)
    inner = np.pi * np.sinh(step)
    share = 1.0 / (1.0 + np.exp(-inner))
    weights = share * (1.0 - share) * np.cosh(step)
    return share, weights / np.sum(weights)


def _stieltjes(nodes: Vector, weights: Vector, points: Vector, degree: int) -> Matrix:
    """Polynomials at points that are orthonormal over weighted nodes, (n, degree + 1)."""
    before, now = np.zeros_like(nodes), np.ones_like(nodes)
    polynomials, past = [np.ones_like(points)], np.zeros_like(points)
    size = 0.0
    for _ in range(degree):
        centre = weights @ (nodes * now**2)
        at_nodes = (nodes - centre) * now - size * before
        at_points = (points - centre) * polynomials[-1] - size * past
        size = float(np.sqrt(weights @ at_nodes**2))
        before, now = now, at_nodes / size
        past = polynomials[-1]
        polynomials.append(at_points / size)
    return np.stack(polynomials, axis=1)
