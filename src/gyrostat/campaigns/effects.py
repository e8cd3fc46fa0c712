"""Sobol indices of each metric, from the table of a campaign.

The variance of a metric is divided among the dispersed values by a polynomial chaos expansion,
which is fitted to the runs by least squares. The first-order index of a value is the share of the
variance that it causes alone; the total index includes its interactions with others. Both are sums
of squared coefficients.

The runs are divided into 20 groups, and the expansion is fitted without each of them. The left-out
runs give the Q², the share of variance that is predicted in runs which the fit has not seen. The
delete-a-group jackknife gives corrections of bias and confidence intervals (J. Shao and C. F. J.
Wu, "A general theory for jackknife variance estimation", Annals of Statistics 17, 1989).
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.chaos import TERMS, Basis, basis_of, design_matrix
from gyrostat.campaigns.draws import shares, values_at
from gyrostat.campaigns.drivers import alike
from gyrostat.core.orthonormal import Family
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.kinds.distributions import distributions_of
from gyrostat.scenario.scenario import Scenario

LEAST_Q2 = 0.8
"""Predicted share of the variance below which no indices are given."""
MOST_MISSING = 0.05
"""Share of runs without the metric above which no indices are given."""
MOST_RUNS = 20_000
"""Largest number of runs that are used: the first ones, drawn like any other."""
GROUPS = 20
_QUANTILE = 2.093
"""Quantile of 97.5 % of Student's distribution with 19 degrees of freedom."""
_RIDGE = 1e-9
"""Added to the diagonal of normal equations, which is about 1, against rounding errors."""


class Effects(NamedTuple):
    """Sobol indices of a metric.

    Attributes:
        q2: Share of the variance that is predicted in left-out runs; NaN if not computed.
        runs: Number of runs that are used.
        without: Number of runs without the metric among the runs considered.
        why: Why there are no indices; empty if there are.
        first: First-order indices: value and limits of the 95 % confidence interval, (inputs, 3).
        total: Total indices likewise.
    """

    q2: float
    runs: int
    without: int
    why: str
    first: Matrix
    total: Matrix


class Inputs(NamedTuple):
    """Independent inputs of a campaign.

    Attributes:
        names: Keys of each input; more than one if they are correlated, so that only their joint
            effect is defined.
        share: Values of the cumulative distribution functions, (runs, variables).
        families: Orthonormal polynomials of each variable, (variables,).
        owner: Index of the input of each variable, (variables,).
    """

    names: list[tuple[str, ...]]
    share: Matrix
    families: list[Family]
    owner: NDArray[np.int64]


def inputs_of(scenario: Scenario, seed: int, columns: "Mapping[str, Vector]") -> Inputs | str:
    """Independent inputs of the runs of a campaign, or the reason why there are none.

    Args:
        scenario: Scenario with dispersions.
        seed: Seed of the campaign.
        columns: Columns of the table of runs.
    """
    keys = scenario.dispersed
    missing = [key for key in keys if key not in columns]
    if missing:
        return f"the table of runs has no column {missing[0]}"
    share = shares(scenario, seed, np.asarray(columns["run"])[:MOST_RUNS])
    values = np.stack([columns[key][:MOST_RUNS] for key in keys], axis=1)
    # the distribution of each value is known, and with it the variable that it was made of
    size = np.max(np.abs(values), axis=0)
    if not np.all(np.abs(values_at(scenario, share) - values) <= 1e-9 * size):
        return "the values in the table of runs are not those that the scenario draws"
    names: list[tuple[str, ...]] = []
    owner: list[int] = []
    families: list[Family] = []
    for each, distribution in zip(scenario.dispersions, distributions_of(scenario), strict=True):
        is_joint = distribution.is_joint()
        families += distribution.families()
        for k, key in enumerate(each.keys):
            if k == 0 or not is_joint:
                names.append(each.keys if is_joint else (key,))
            owner.append(len(names) - 1)
    return Inputs(names, share, families, np.array(owner))


def find_effects(inputs: Inputs, metrics: Matrix) -> list[Effects]:
    """Compute the Sobol indices of each metric.

    Args:
        inputs: Inputs of the runs.
        metrics: Values of the metrics, (runs, metrics), NaN for missing ones.
    """
    metrics = metrics[: len(inputs.share)]
    effects: dict[int, Effects] = {}
    for pattern, columns in alike(metrics):
        values = metrics[np.ix_(pattern, columns)]
        why, missing = _unfit(pattern, inputs), int(np.sum(~pattern))
        varies = np.zeros(len(columns), bool)
        if not why:
            varies = np.ptp(values, axis=0) > 1e-9 * np.max(np.abs(values), axis=0)
        subset = inputs._replace(share=inputs.share[pattern])
        results = iter(_expand(subset, values[:, varies]) if np.any(varies) else ())
        none = _none(inputs, pattern, why or "it is the same in all runs")
        for column, is_varying in zip(columns.tolist(), varies, strict=True):
            effects[column] = (next(results) if is_varying else none)._replace(without=missing)
    return [effects[column] for column in range(metrics.shape[1])]


def _unfit(has: NDArray[np.bool_], inputs: Inputs) -> str:
    """Why there are no indices of a metric that these runs have."""
    if np.mean(~has) > MOST_MISSING:
        return (
            f"{np.sum(~has)} of {len(has)} runs do not have it; in the others the dispersed values "
            "are not independent"
        )
    least = max(2 * GROUPS, 3 * (1 + len(inputs.families)))
    if np.sum(has) < least:
        return f"not enough runs: {np.sum(has)}, at least {least} are needed"
    return ""


def _none(inputs: Inputs, has: NDArray[np.bool_], why: str, q2: float = np.nan) -> Effects:
    empty = np.full((len(inputs.names), 3), np.nan)
    return Effects(q2, int(np.sum(has)), 0, why, empty, empty)


def _expand(inputs: Inputs, values: Matrix) -> list[Effects]:
    """Sobol indices of metrics that all runs have and that vary."""
    values = (values - np.mean(values, axis=0)) / np.std(values, axis=0)
    runs = len(values)
    basis = basis_of(inputs.families, _importance(inputs, values), min(TERMS, runs // 3))
    design = design_matrix(basis, inputs.share, inputs.families)
    fits = _Fits(basis, design, values, _members(basis, inputs))
    effects = []
    for m, cut in enumerate(np.argmin(fits.errors, axis=0)):
        q2 = 1.0 - float(fits.errors[cut, m])
        if q2 < LEAST_Q2:
            why = _unexplained(q2, 1.0 - float(np.min(fits.errors_of_half[:, m])))
            effects.append(_none(inputs, np.ones(runs, bool), why, q2))
            continue
        first, total = (jackknife(part[cut, :, :, m]) for part in fits.indices)
        effects.append(Effects(q2, runs, 0, "", first, total))
    return effects


def _unexplained(q2: float, of_half: float) -> str:
    """Why an expansion predicts too little, from its Q² and that with half of the runs."""
    share = max(math.floor(100.0 * q2), 0)
    shortfall = f"{share} % of the variance is predicted, {100.0 * LEAST_Q2:.0f} % needed"
    # the error of a fit is that of infinitely many runs and a part that falls with their number
    if 2.0 * q2 - of_half >= LEAST_Q2:
        return f"not enough runs: {shortfall}, and more runs would help"
    return f"not explained by the dispersed values: {shortfall}"


def _importance(inputs: Inputs, values: Matrix) -> NDArray[np.int64]:
    """Variables in the order of their largest effect on any metric, without interactions."""
    basis = Basis([((v, n),) for n in (1, 2) for v in range(len(inputs.families))], [])
    explained = (design_matrix(basis, inputs.share, inputs.families).T @ values / len(values)) ** 2
    return np.argsort(-np.max(np.sum(np.split(explained, 2), axis=0), axis=1), kind="stable")


def _members(basis: Basis, inputs: Inputs) -> tuple[Matrix, Matrix]:
    """Whether each term has one input alone, and whether it has it at all, (inputs, terms)."""
    contains = np.zeros((len(inputs.names), len(basis.terms)))
    for column, term in enumerate(basis.terms):
        contains[[inputs.owner[variable] for variable, _ in term], column] = 1.0
    return contains * (np.sum(contains, axis=0) == 1.0), contains


class _Fits:
    """Expansions of all sizes, fitted to all runs and without each group of runs.

    Attributes:
        errors: Squared error of left-out runs over the variance, (cuts, metrics).
        errors_of_half: The same with half of the runs left out.
        indices: First-order and total indices, each (cuts, 1 + groups, inputs, metrics): from all
            runs, and without each group.
    """

    def __init__(
        self, basis: Basis, design: Matrix, values: Matrix, members: tuple[Matrix, Matrix]
    ):
        self._cuts, self._members = basis.cuts, members
        self._parts = list(
            zip(np.array_split(design, GROUPS), np.array_split(values, GROUPS), strict=True)
        )
        self._moments = [(x.T @ x, x.T @ y, len(y), np.sum(y**2, axis=0)) for x, y in self._parts]
        self._totals = [sum(each) for each in zip(*self._moments, strict=True)]
        shape = len(basis.cuts), 1 + GROUPS, len(members[0]), values.shape[1]
        self.indices = np.zeros(shape), np.zeros(shape)
        self.errors = self._errors([[k] for k in range(GROUPS)], keep=True)
        half = GROUPS // 2
        self.errors_of_half = self._errors([range(half), range(half, GROUPS)], keep=False)
        self._fit([], 0)

    def _errors(self, leave_out: "Sequence[Sequence[int]]", *, keep: bool) -> Matrix:
        errors = np.zeros((len(self._cuts), self.indices[0].shape[-1]))
        for k, groups in enumerate(leave_out):
            fitted = self._fit(groups, 1 + k if keep else None)
            for x, y in (self._parts[group] for group in groups):
                # one product for all sizes: many small ones wait for each other's threads
                predicted = (x @ fitted.reshape(x.shape[1], -1)).reshape(len(x), -1, y.shape[1])
                errors += np.sum((y[:, None] - predicted) ** 2, axis=0)
        return errors / self._totals[3]

    def _fit(self, groups: "Sequence[int]", slot: int | None) -> NDArray[np.float64]:
        """Coefficients of each size without some groups, (terms, cuts, metrics).

        Terms that an expansion does not have are zero. The indices are written to `slot`.
        """
        gram, projection, count, squares = (
            total - sum(self._moments[group][k] for group in groups)
            for k, total in enumerate(self._totals)
        )
        ridge = _RIDGE * count * np.eye(self._cuts[-1])
        # the leading blocks of the inverse of a triangular matrix are those of smaller expansions
        inverse = np.linalg.inv(np.linalg.cholesky(gram + ridge))
        forward = inverse @ projection
        coefficients = np.zeros((len(inverse), len(self._cuts), forward.shape[1]))
        for c, cut in enumerate(self._cuts):
            coefficients[:cut, c] = inverse[:cut, :cut].T @ forward[:cut]
        if slot is not None:
            residual = (squares - np.cumsum(forward**2, axis=0))[np.array(self._cuts) - 1]
            # the distributions of the inputs are known: their variances are not estimated
            variance = np.sum(coefficients[1:] ** 2, axis=0) + residual / count
            for indices, members in zip(self.indices, self._members, strict=True):
                indices[:, slot] = np.tensordot(members, coefficients**2, 1).swapaxes(0, 1)
                indices[:, slot] /= variance[:, None]
        return coefficients


def jackknife(found: Matrix) -> Matrix:
    """Value without bias, and 95 % confidence limits, by leaving out each group of runs.

    Args:
        found: (1 + groups, inputs).
    """
    estimate, replicates = found[0], found[1:]
    middle = np.mean(replicates, axis=0)
    value = GROUPS * estimate - (GROUPS - 1.0) * middle
    error = np.sqrt((GROUPS - 1.0) / GROUPS * np.sum((replicates - middle) ** 2, axis=0))
    limits = [value, value - _QUANTILE * error, value + _QUANTILE * error]
    return np.clip(np.stack(limits, axis=1), 0.0, 1.0)
