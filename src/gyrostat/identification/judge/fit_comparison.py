"""Comparison of fits: one wheel over dates, or the wheels of a batch.

The covariance of all estimates together includes what the fits share. The error of a given
inertia is the same in all fits of one wheel, the errors of current scale, speed scale and clock are
the same in all fits from one bench; in differences they cancel. All tests of a comparison are one
family: the probability of any false alarm among them is at most 5 %
(`gyrostat.identification.judge.spread.holm`).
"""

from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import permutations

import numpy as np
from scipy.special import chdtrc

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.judge.fit_changes import (
    ALL,
    OTHERS,
    BatchSpread,
    Change,
    Comparison,
    Trend,
    common_parameters,
    days,
    in_order_of_date,
)
from gyrostat.identification.judge.spread import between, from_others, holm, line, two_sided
from gyrostat.identification.result.stored_fit import StoredFit

SAME_TEMPERATURE = 2.0
"""Temperature difference from which friction may differ because of it, °C."""
FEWEST = 3
"""Smallest number of fits for a trend or for a comparison with a batch."""
BENCH = ("current_scale", "speed_scale", "clock")
"""Tolerances that belong to the bench and not to the wheel."""


class _Joint:
    """Estimates of all fits with their covariance, including the errors that they share."""

    def __init__(self, fits: Sequence[StoredFit], tolerances: Sequence[str]) -> None:
        self.fits = fits
        pairs = [(k, name) for k, fit in enumerate(fits) for name in fit.names]
        self.places = {pair: index for index, pair in enumerate(pairs)}
        self.values = np.concatenate([fit.values for fit in fits])
        self.covariance = np.zeros((len(self.values), len(self.values)))
        columns = [[self.places[k, n] for n in fit.names] for k, fit in enumerate(fits)]
        for fit, index in zip(fits, columns, strict=True):
            self.covariance[np.ix_(index, index)] = fit.covariance
        self.shared = set()
        for name in tolerances:
            for i, j in permutations(range(len(fits)), 2):
                if _alike(fits[i], fits[j], name):
                    errors = (fits[k].tolerances[name].errors for k in (i, j))
                    self.covariance[np.ix_(columns[i], columns[j])] += np.outer(*errors)
                    self.shared.add(name)

    def estimates(self, name: str) -> tuple[list[int], Vector, Matrix]:
        """Fits that have a parameter, its values and their covariance."""
        fits = [k for k, fit in enumerate(self.fits) if name in fit.names]
        columns = [self.places[k, name] for k in fits]
        return fits, self.values[columns], self.covariance[np.ix_(columns, columns)]

    def change(self, fit: int, reference: int, names: Sequence[str]) -> tuple[Vector, Matrix]:
        """Differences of several parameters between two fits, and their covariance."""
        rows = np.zeros((len(names), len(self.values)))
        for k, name in enumerate(names):
            rows[k, self.places[fit, name]], rows[k, self.places[reference, name]] = 1.0, -1.0
        return rows @ self.values, rows @ self.covariance @ rows.T


def _alike(first: StoredFit, second: StoredFit, name: str) -> bool:
    """Whether two fits were given the same quantity with the same tolerance."""
    if name not in first.tolerances or name not in second.tolerances:
        return False
    same_sigma = first.tolerances[name].sigma == second.tolerances[name].sigma
    return same_sigma and (name != "inertia" or first.inertia == second.inertia)


def _over_time(joint: _Joint, labels: Sequence[str]) -> tuple[list[Change], list[Trend]]:
    """Changes of one wheel from its first fit, and trends; p-values of single tests."""
    changes, trends = [], []
    fits, times = joint.fits, days(joint.fits)
    for k in range(1, len(fits)):
        names = [n for n in fits[k].names if n in fits[0].names]
        if not names:
            continue
        apart, covariance = joint.change(k, 0, names)
        sigma = np.sqrt(np.diag(covariance))
        correlation = covariance / np.outer(sigma, sigma)
        z = apart / sigma
        statistic = float(z @ np.linalg.pinv(correlation, rcond=1e-9, hermitian=True) @ z)
        freedom = int(np.linalg.matrix_rank(correlation, tol=1e-9, hermitian=True))
        chance = float(chdtrc(freedom, statistic))
        changes.append(Change(ALL, labels[k], labels[0], None, None, "", chance))
        for n, d, s in zip(names, apart.tolist(), sigma.tolist(), strict=True):
            unit = fits[k].units[fits[k].names.index(n)]
            changes.append(Change(n, labels[k], labels[0], d, s, unit, two_sided(d / s)))
    for name in common_parameters(fits):
        places, values, covariance = joint.estimates(name)
        if times is None or len(np.unique(times[places])) < FEWEST:
            continue
        trend = line(times[places], values, covariance)
        unit = fits[places[0]].units[fits[places[0]].names.index(name)]
        sigma = float(np.sqrt(trend.covariance[1, 1]))
        trends.append(
            Trend(name, trend.start, trend.slope, sigma, trend.covariance, unit, trend.chance)
        )
    return changes, trends


def _of_batch(joint: _Joint, labels: Sequence[str]) -> tuple[list[Change], list[BatchSpread]]:
    """Differences of wheels from the others, and spreads; p-values of single tests."""
    changes, spreads = [], []
    for name in common_parameters(joint.fits):
        places, values, covariance = joint.estimates(name)
        first = joint.fits[places[0]]
        unit = first.units[first.names.index(name)]
        spread = between(values, covariance)
        spreads.append(BatchSpread(parameter=name, unit=unit, **asdict(spread)))
        for index, k in enumerate(places if len(places) >= FEWEST else ()):
            difference, sigma, chance = from_others(values, covariance, index)
            changes.append(Change(name, labels[k], OTHERS, difference, sigma, unit, chance))
    return changes, spreads


def temperature_note(fits: Sequence[StoredFit]) -> list[str]:
    """Remark on temperatures at which friction may differ; none if they are alike."""
    warm = [fit.temperature for fit in fits if fit.temperature is not None]
    if not (warm and max(warm) - min(warm) > SAME_TEMPERATURE):
        return []
    return [
        f"the temperatures differ, from {min(warm):.3g} to {max(warm):.3g} °C: friction changes "
        "with temperature"
    ]


def _notes(fits: Sequence[StoredFit], same_wheel: bool, tolerances: Sequence[str]) -> list[str]:
    """Remarks on data that make a comparison less certain."""
    notes = []
    if len({fit.model for fit in fits}) > 1:
        models = ", ".join(dict.fromkeys(fit.model for fit in fits))
        notes.append(
            f"the friction models differ ({models}): a parameter may change with the model"
        )
    if same_wheel and len({fit.inertia for fit in fits}) > 1:
        notes.append(
            "the given inertias differ: motor constant, torques and viscous friction scale with "
            "them"
        )
    notes += temperature_note(fits)
    if same_wheel and days(fits) is None:
        notes.append("no trend: a date is unknown (comment '# date: 2026-03-01' in each record)")
    for name in tolerances:
        with_tolerance = [fit for fit in fits if name in fit.tolerances]
        if with_tolerance and not all(_alike(with_tolerance[0], fit, name) for fit in fits):
            text = f"the tolerances of {name.replace('_', ' ')} differ between fits"
            notes.append(f"{text}: only equal ones are taken as the same error")
    return notes


def compare_fits(
    fits: Sequence[StoredFit], labels: Sequence[str], *, same_wheel: bool, same_bench: bool
) -> Comparison:
    """Compare fits of one wheel over dates, or of the wheels of a batch.

    Args:
        fits: At least two fits.
        labels: Label of each fit.
        same_wheel: Whether all fits are of one wheel, with one inertia.
        same_bench: Whether all records are from one bench, with one error of each scale.

    Raises:
        InputError: There are fewer than two fits, or no two fits have a parameter in common.
    """
    if len(fits) < 2:
        raise InputError(f"compare: found {len(fits)} fit, expected at least 2")
    if not common_parameters(fits):
        raise InputError("compare: found no parameter that two fits have in common, expected one")
    fits, labels = in_order_of_date(fits, labels)
    tolerances = [*(["inertia"] if same_wheel else []), *(BENCH if same_bench else [])]
    joint = _Joint(fits, tolerances)
    trends, spreads = [], []
    if same_wheel:
        changes, trends = _over_time(joint, labels)
    else:
        changes, spreads = _of_batch(joint, labels)
    every = [*changes, *trends, *spreads]
    chances = holm([item.chance for item in every]).tolist()
    results = [replace(item, chance=p) for item, p in zip(every, chances, strict=True)]
    return Comparison(
        fits=tuple(fits),
        labels=tuple(labels),
        same_wheel=same_wheel,
        shared=tuple(name for name in tolerances if name in joint.shared),
        changes=tuple(item for item in results if isinstance(item, Change)),
        trends=tuple(item for item in results if isinstance(item, Trend)),
        spreads=tuple(item for item in results if isinstance(item, BatchSpread)),
        tests=len(every),
        notes=tuple(_notes(fits, same_wheel, tolerances)),
    )
