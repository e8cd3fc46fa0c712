"""Polynomial chaos: orthonormal polynomials of independent standard variables.

B. Sudret, "Global sensitivity analysis using polynomial chaos expansions", Reliability Engineering
and System Safety 93 (2008). The terms follow G. Blatman and B. Sudret, "Adaptive sparse polynomial
chaos expansion based on least angle regression", J. Comput. Phys. 230 (2011): those of few
variables and low degree come first, in the order of the hyperbolic norm of their degrees.
"""

from collections.abc import Sequence
from itertools import combinations, permutations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.orthonormal import BOUNDED, UNBOUNDED, Family
from gyrostat.core.types import Matrix

TERMS = 200
"""Largest number of terms."""
_NORM = 0.75
_TOGETHER = 3
"""Largest number of variables in a term."""

Term = tuple[tuple[int, int], ...]
"""Pairs of variable and degree."""


class Basis(NamedTuple):
    """Terms of an expansion.

    Attributes:
        terms: Terms; the first is the constant.
        cuts: Numbers of terms of the expansions to choose from, growing.
    """

    terms: list[Term]
    cuts: list[int]


def _patterns() -> list[tuple[int, ...]]:
    """Degrees of the variables of a term, falling, by their norm."""
    patterns = [(first,) for first in range(1, max(BOUNDED, UNBOUNDED) + 1)]
    for count in range(2, _TOGETHER + 1):
        grown = [(*each, n) for each in patterns for n in range(1, each[-1] + 1)]
        patterns += [each for each in grown if len(each) == count]
    return sorted(patterns, key=lambda degrees: (sum(d**_NORM for d in degrees), degrees))


def basis_of(families: Sequence[Family], order: NDArray[np.int64], most: int) -> Basis:
    """Terms up to a number; where not all variables have room, the first ones of an order.

    Args:
        families: Polynomials of each variable, (variables,).
        order: Variables, the most important first, (variables,).
        most: Largest number of terms, at least one more than variables.
    """
    terms: list[Term] = [()]
    cuts = []
    for pattern in _patterns():
        places = sorted(set(permutations(pattern)))
        count = len(order)
        while count >= len(pattern):
            subsets = (c for c in combinations(order[:count].tolist(), len(pattern)))
            new = [tuple(zip(c, p, strict=True)) for c in subsets for p in places]
            new = [term for term in new if all(n <= families[v].highest for v, n in term)]
            if len(terms) + len(new) <= most:
                break
            count -= 1
        else:
            break
        if new:
            terms += new
            cuts.append(len(terms))
    return Basis(terms, cuts)


def design_matrix(basis: Basis, share: Matrix, families: Sequence[Family]) -> Matrix:
    """Values of the terms, (n, terms).

    Args:
        basis: Terms.
        share: Values of the cumulative distribution functions, (n, variables).
        families: See `basis_of`.
    """
    highest = np.zeros(len(families), int)
    for term in basis.terms:
        for variable, degree in term:
            highest[variable] = max(highest[variable], degree)
    single = [each.values(share[:, v], int(highest[v])) for v, each in enumerate(families)]
    matrix = np.ones((len(share), len(basis.terms)))
    for column, term in zip(matrix.T, basis.terms, strict=True):
        for variable, degree in term:
            column *= single[variable][:, degree]
    return matrix
