"""Pointing budgets of annex C from an ensemble of errors over time, and rules of annex A."""

import numpy as np
from jaxtyping import Float
from scipy.special import ndtr
from scipy.stats import chi2

from gyrostat.campaigns.pointing.indices import WindowIndex
from gyrostat.core.types import Vector
from gyrostat.papers.claims import Value
from gyrostat.papers.ecss_control_performance.budget import Budget, Index
from gyrostat.papers.ecss_control_performance.figures import figures
from gyrostat.papers.ecss_control_performance.setup import (
    ARCSEC,
    AXES,
    FACTOR,
    LEVEL,
    PERIOD,
    PRIME,
    REQUIRED,
    SAMPLES,
    SOURCES,
    requirement,
)
from gyrostat.papers.reproduction import Part, Run

DIRECTIONAL = {"95": 0.95, "9973": 0.9973}
"""Levels of directional errors in A.2.4: end of a name -> level."""


def index_of(index: str, errors: Float[np.ndarray, "members samples 3"]) -> Index:
    """Index of errors as a requirement takes it, over time and members, arcsec.

    Args:
        index: Key of `REQUIRED`.
        errors: Errors over a window, rad.
    """
    needed = requirement(index)
    made = WindowIndex(needed, len(errors), round(needed.window / PERIOD))
    parts = [made.add(errors, np.ones(errors.shape[:2], bool)), made.finish()]
    found = [p.vectors[np.isfinite(p.sizes)] for p in parts if p.vectors is not None]
    return np.concatenate(found) / ARCSEC


def stratified(count: int, random: np.random.Generator) -> Float[np.ndarray, "members count"]:
    """Points in the unit cube, of which each pair of coordinates fills its square evenly.

    An orthogonal array of strength 2 (R. C. Bose, 1938): the pair of any two columns takes each of
    `PRIME`² values once. Points drawn freely correlate by chance, which changes sums of biases.

    Args:
        count: Number of coordinates, at most `PRIME`.
        random: Generator of the order of the strata and of the places within them.
    """
    first, second = np.divmod(np.arange(PRIME**2), PRIME)
    strata = (first[:, None] + second[:, None] * np.arange(count)) % PRIME
    mixed = np.stack([random.permutation(PRIME)[column] for column in strata.T], axis=1)
    return (mixed + random.uniform(0.0, 1.0, mixed.shape)) / PRIME


def compiled(run: Run) -> dict[str, Budget]:
    """Budget of each index."""
    run.say(f"{PRIME**2} members of the ensemble")
    random = np.random.default_rng(0)
    shares = np.split(stratified(6 * len(SOURCES), random), len(SOURCES), axis=1)
    sums = np.zeros((PRIME**2, SAMPLES, 3))
    means: dict[str, dict[str, Vector]] = {index: {} for index in REQUIRED}
    sigmas: dict[str, dict[str, Vector]] = {index: {} for index in REQUIRED}
    for (name, source), its in zip(SOURCES.items(), shares, strict=True):
        errors = source.histories(its, random)
        sums += errors
        for index in REQUIRED:
            values = index_of(index, errors)
            means[index][name], sigmas[index][name] = values.mean(axis=0), values.std(axis=0)
    return {i: Budget(means[i], sigmas[i], index_of(i, sums)) for i in REQUIRED}


def budgets(run: Run) -> Part:
    """Tables C-2 to C-4, compliance, and the whole error without taking it for normal."""
    found, values = run.once(compiled), _ensemble()
    facts: dict[str, object] = {"members": PRIME**2}
    off_centre = 0.0
    for index, budget in found.items():
        name, required = index.lower(), np.array(REQUIRED[index])
        for source in SOURCES:
            values |= _rows(name, source, budget.sigmas[source])
            # against the whole: some sources are not in an index
            off_centre = max(off_centre, *np.abs(budget.means[source]) / budget.sigma)
        for axis, sigma, size in zip(AXES, budget.sigma, budget.size, strict=True):
            values[f"{name}.total_{axis}_arcsec"] = float(sigma)
            values[f"{name}.total_{axis}_doubled_arcsec"] = float(FACTOR * sigma)
            values[f"{name}.size_{axis}_arcsec"] = float(size)
        values[f"{name}.compliant"] = bool(np.all(FACTOR * budget.sigma <= required))
        within = np.mean(np.abs(budget.whole) <= required, axis=0)
        facts[f"{name}_within"] = [100.0 * float(share) for share in within]
    values["mixed.zero_mean"] = bool(off_centre < 0.01)
    facts["off_centre"] = 100.0 * off_centre
    directional = np.hypot(*found["APE"].whole[:, 1:].T)
    values["ape.half_cone_arcsec"] = float(np.quantile(directional, LEVEL))
    facts["rayleigh"] = float(np.sqrt(chi2.ppf(LEVEL, 2)) * np.max(found["APE"].sigma[1:]))
    return Part(values, facts, figures(found))


def _ensemble() -> dict[str, Value]:
    """Computed columns of table C-2."""
    shares = (np.arange(PRIME**2) + 0.5) / PRIME**2
    drawn = {name: source.parameters[0].drawn(shares) for name, source in SOURCES.items()}
    heat, control = drawn["thermoelastic"], drawn["controller"]
    return {
        "ensemble.controller_rms_arcsec": float(np.sqrt(np.mean(control**2))),
        "ensemble.thermoelastic_mean_arcsec": float(np.mean(heat)),
        "ensemble.thermoelastic_sigma_arcsec": float(np.std(heat)),
        "ensemble.thermoelastic_rms_arcsec": float(np.sqrt(np.mean(heat**2))),
        "ensemble.misalignment_sigma_arcsec": float(np.std(drawn["misalignment"])),
    }


def _rows(index: str, name: str, sigma: Vector) -> dict[str, Value]:
    """Standard deviations of a source: one for all axes with the same parameter."""
    groups: dict[object, list[int]] = {}
    for k, parameter in enumerate(SOURCES[name].parameters):
        groups.setdefault(parameter, []).append(k)
    rows: dict[str, Value] = {}
    for axes in groups.values():
        about = "" if len(axes) == len(AXES) else "_" + "".join(AXES[k] for k in axes)
        rows[f"{index}.{name}{about}_arcsec"] = float(np.sqrt(np.mean(sigma[axes] ** 2)))
    return rows


def rules(run: Run) -> Part:
    """Probabilities and factors of annex A.2.4."""
    del run
    values: dict[str, Value] = {
        f"rule.normal_{k}_sigma_percent": 100.0 * float(ndtr(k) - ndtr(-k)) for k in (1, 2, 3)
    }
    for (level, share), factor in zip(DIRECTIONAL.items(), (2, 3), strict=True):
        values[f"rule.directional_{level}"] = float(np.sqrt(chi2.ppf(share, 2)))
        values[f"rule.directional_{level}_simplified"] = float(np.sqrt(2.0) * factor)
    return Part(values)
