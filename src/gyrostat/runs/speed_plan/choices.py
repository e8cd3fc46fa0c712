"""Linear inequalities with choices of intervals: solution, and certificate that there is none.

A problem has variables x within bounds and rows A x <= b. Besides, all rows of each choice,
P x + q, must be in one and the same of some disjoint intervals. It is a mixed-integer linear
program; the search for a certificate is independent of the solver of that program.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from time import monotonic
from typing import Any

import numpy as np

from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector

SLACK = 1e-6
"""Smallest violation that proves a linear program to be infeasible; variables are of order 1."""
OPEN = -1
"""Choice that has not been made."""


@dataclass(frozen=True, eq=False)
class Choice:
    """Choice of an interval.

    Attributes:
        rows: Matrix P, (rows, variables).
        low: Least part q of the rows, (rows,).
        high: Largest part q of the rows, (rows,).
        intervals: Lower and upper ends, increasing, (intervals, 2).
    """

    rows: Matrix
    low: Vector
    high: Vector
    intervals: Matrix


@dataclass(frozen=True, eq=False)
class Problem:
    """Linear inequalities with choices.

    Attributes:
        matrix: Matrix A, (rows, variables).
        bound: Right-hand side b, (rows,).
        size: Largest size of each variable, (variables,).
        choices: Choices of intervals.
    """

    matrix: Matrix
    bound: Vector
    size: Vector
    choices: tuple[Choice, ...]

    def relaxed(self, made: tuple[int, ...]) -> tuple[Matrix, Vector]:
        """Rows A x <= b of the problem in which the choices that are `OPEN` allow their hull.

        Args:
            made: Interval of each choice, or `OPEN`.
        """
        matrices, bounds = [self.matrix], [self.bound]
        for choice, number in zip(self.choices, made, strict=True):
            low, high = (
                (choice.intervals[0, 0], choice.intervals[-1, 1])
                if number == OPEN
                else choice.intervals[number]
            )
            matrices += [choice.rows, -choice.rows]
            bounds += [high - choice.high, choice.low - low]
        return np.vstack(matrices), np.concatenate(bounds)


@dataclass(frozen=True, eq=False)
class Leaf:
    """Proof that a relaxation has no solution (lemma of Farkas).

    With y >= 0, every x with A x <= b has y'A x <= y'b; there is none if even the least y'A x
    within the sizes of the variables is larger.

    Attributes:
        made: Interval of each choice, or `OPEN`.
        weights: Weights y of the rows of the relaxation, (rows,).
    """

    made: tuple[int, ...]
    weights: Vector

    def proves(self, problem: Problem) -> bool:
        """Whether the weights prove it, by the numbers of the problem in rational arithmetic."""
        matrix, bound = problem.relaxed(self.made)
        rows = np.flatnonzero(self.weights > 0.0)
        weights = [Fraction(float(weight)) for weight in self.weights[rows]]

        def weighted(values: Vector) -> Fraction:
            pairs = zip(weights, values[rows], strict=True)
            return sum((w * Fraction(float(v)) for w, v in pairs if v != 0.0), Fraction(0))

        sums = zip(problem.size, matrix.T, strict=True)
        least = -sum(Fraction(float(size)) * abs(weighted(column)) for size, column in sums)
        return least > weighted(bound)


@dataclass(frozen=True, eq=False)
class Certificate(Described):
    """Proof that a problem has no solution: leaves that cover all choices."""

    leaves: tuple[Leaf, ...]

    def proves(self, problem: Problem) -> bool:
        """Whether all leaves prove their relaxation, and cover every combination of choices."""
        counts = tuple(len(choice.intervals) for choice in problem.choices)
        made = [leaf.made for leaf in self.leaves]
        return _covered(made, counts) and all(leaf.proves(problem) for leaf in self.leaves)


def _covered(made: list[tuple[int, ...]], counts: tuple[int, ...]) -> bool:
    """Whether partial choices cover every combination."""
    if any(all(number == OPEN for number in each) for each in made):
        return True
    if not made:
        return False
    # a choice that every leaf has made, as the root of the tree
    for index, count in enumerate(counts):
        if all(each[index] != OPEN for each in made):
            return all(
                _covered([_without(m, index) for m in made if m[index] == number], counts)
                for number in range(count)
            )
    return False


def _without(made: tuple[int, ...], index: int) -> tuple[int, ...]:
    return (*made[:index], OPEN, *made[index + 1 :])


def infeasible(problem: Problem, seconds: float = 20.0) -> Certificate | Vector | None:
    """Search for a certificate that there is no solution.

    Branch and bound: where a relaxation has a solution, the choice that it violates most is made in
    each way.

    Args:
        problem: Problem.
        seconds: Time after which the search ends.

    Returns:
        Certificate; a solution, (variables,), if there is one; None: the time did not suffice.
    """
    end = monotonic() + seconds
    leaves: list[Leaf] = []
    stack = [(OPEN,) * len(problem.choices)]
    while stack:
        if monotonic() > end:
            return None
        made = stack.pop()
        point, weights = _least_violation(problem, made)
        if weights is not None:
            leaf = Leaf(made, weights)
            if not leaf.proves(problem):
                return None
            leaves.append(leaf)
            continue
        assert point is not None
        index = _most_violated(problem, point)
        if index is None:
            return point
        if made[index] != OPEN:
            return None
        count = len(problem.choices[index].intervals)
        stack += [(*made[:index], number, *made[index + 1 :]) for number in range(count)]
    return Certificate(tuple(leaves))


def _least_violation(
    problem: Problem, made: tuple[int, ...]
) -> tuple[Vector | None, Vector | None]:
    """Point of least violation of a relaxation, or the weights that prove that there is none."""
    from scipy.optimize import linprog  # slow to import

    matrix, bound = problem.relaxed(made)
    count = len(problem.size)
    result = linprog(
        np.append(np.zeros(count), 1.0),
        A_ub=np.column_stack([matrix, -np.ones(len(bound))]),
        b_ub=bound,
        bounds=[*((-size, size) for size in problem.size), (0.0, None)],
        method="highs",
    )
    if result.status != 0:
        return None, np.zeros(len(bound))
    if result.fun > SLACK:
        return None, -np.asarray(result.ineqlin.marginals)
    return result.x[:count], None


def _distances(choice: Choice, point: Vector) -> Iterator[float]:
    """Distance of the rows from each interval."""
    value = choice.rows @ point
    for low, high in choice.intervals:
        yield max(np.max(value + choice.high) - high, low - np.min(value + choice.low), 0.0)


def _most_violated(problem: Problem, point: Vector) -> int | None:
    """Choice of which no interval has all rows; None: there is no such choice."""
    least = np.array([min(_distances(choice, point)) for choice in problem.choices])
    return int(np.argmax(least)) if len(least) and np.max(least) > 10.0 * SLACK else None


def solve(problem: Problem, cost: Vector, seconds: float = 20.0) -> tuple[Vector | None, bool]:
    """Solution of least cost by a solver of mixed-integer linear programs.

    Args:
        problem: Problem.
        cost: Cost of each variable, (variables,).
        seconds: Time after which the best solution so far is taken.

    Returns:
        Solution, (variables,), or None; and whether the solver ended in time.
    """
    from scipy.optimize import Bounds, LinearConstraint, milp  # slow to import

    count = len(cost)
    total = sum(len(choice.intervals) for choice in problem.choices)
    rows = [np.column_stack([problem.matrix, np.zeros((len(problem.bound), total))])]
    lower, upper = [np.full(len(problem.bound), -np.inf)], [problem.bound]
    start = count
    for choice in problem.choices:
        length = len(choice.intervals)
        one = np.zeros((1, count + total))
        one[0, start : start + length] = 1.0
        rows.append(one)
        lower.append(np.ones(1))
        upper.append(np.ones(1))
        for side, part, unlimited in ((0, choice.low, upper), (1, choice.high, lower)):
            block = np.zeros((len(part), count + total))
            block[:, :count] = choice.rows
            block[:, start : start + length] = -choice.intervals[:, side]
            rows.append(block)
            (lower if side == 0 else upper).append(-part)
            unlimited.append(np.full(len(part), np.inf if side == 0 else -np.inf))
        start += length
    ends: tuple[Any, Any] = np.concatenate(lower), np.concatenate(upper)
    sides: tuple[Any, Any] = (
        np.append(-problem.size, np.zeros(total)),
        np.append(problem.size, np.ones(total)),
    )
    result = milp(
        np.append(cost, np.zeros(total)),
        constraints=LinearConstraint(np.vstack(rows), *ends),
        integrality=np.append(np.zeros(count), np.ones(total)),
        bounds=Bounds(*sides),
        options={"time_limit": seconds},
    )
    return (None if result.x is None else np.asarray(result.x)[:count]), result.status != 1
