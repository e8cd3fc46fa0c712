"""Sampled posterior of the parameters of a wheel, where a Gaussian is not the truth.

A posterior is valid if the chains agree (split R-hat) and their draws are effectively many (Vehtari
et al. 2021, Bayesian Analysis 16).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.pictured import Described, PicturedText
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.units import si_unit
from gyrostat.identification.fit.least_squares import Prior
from gyrostat.identification.fit.prediction import SpeedPrediction
from gyrostat.identification.uncertainty.averaging import Effect
from gyrostat.identification.uncertainty.current_errors import CurrentError
from gyrostat.identification.uncertainty.diagnosis import TORQUES
from gyrostat.identification.uncertainty.effects import nuisances
from gyrostat.identification.uncertainty.posterior_density import Posed, density, posed, record_data
from gyrostat.identification.uncertainty.posterior_sampler import sample
from gyrostat.identification.uncertainty.torque_noise import torque_noise

QUANTILES = (0.025, 0.16, 0.5, 0.84, 0.975)
LARGEST_RHAT, FEWEST = 1.05, 400.0
"""Largest R-hat and smallest effective number of draws of a valid posterior. The usual limit of
R-hat, 1.01, is for few long chains; that of many short ones has a larger sampling error."""


@dataclass(frozen=True)
class Marginal(Described):
    """Posterior of one parameter or difference, SI.

    Attributes:
        name: Parameter, or a difference such as "static-coulomb".
        mean: Mean.
        sigma: Standard deviation.
        quantiles: At the probabilities `QUANTILES`, (5,).
        rhat: Split R-hat.
        effective: Effective number of draws.
        draws: All draws, (m,).
        unit: SI unit of the parameter.
    """

    name: str
    mean: float
    sigma: float
    quantiles: Vector
    rhat: float
    effective: float
    draws: Vector
    unit: str = ""


@dataclass(frozen=True)
class Posterior(PicturedText):
    """Sampled posterior.

    Attributes:
        marginals: Each estimated parameter, then the differences that can vanish.
        chains: Number of chains.
        accepted: Rate of accepted steps.
        effects: Names of the effects outside the model in the likelihood.
        faults: Reasons why the posterior is not valid; empty if it is.
    """

    marginals: tuple[Marginal, ...]
    chains: int
    accepted: float
    effects: tuple[str, ...]
    faults: tuple[str, ...]

    @property
    def valid(self) -> bool:
        """Whether the chains mixed."""
        return not self.faults

    def to_dict(self) -> dict[str, object]:
        """Entry `posterior` of fit.json."""
        return {
            "sampler": "random-walk Metropolis",
            "valid": self.valid,
            "faults": list(self.faults),
            "chains": self.chains,
            "draws": len(self.marginals[0].draws),
            "accepted": self.accepted,
            "effects": list(self.effects),
            "parameters": {
                m.name: {
                    "mean": m.mean,
                    "sigma": m.sigma,
                    "quantiles": dict(zip(map(str, QUANTILES), m.quantiles.tolist(), strict=True)),
                    "interval_95": [float(m.quantiles[0]), float(m.quantiles[-1])],
                    "rhat": m.rhat,
                    "effective_draws": m.effective,
                }
                for m in self.marginals
            },
        }


def sample_posterior(
    prediction: SpeedPrediction,
    names: Sequence[str],
    values: Mapping[str, float],
    covariance: Matrix,
    prior: Prior,
    speed_sigmas: Sequence[float],
    effects: Sequence[Effect] = (),
    *,
    errors: Sequence[CurrentError] = (),
    rounding: Sequence[Vector] = (),
    on_progress: Callable[[int], None] = lambda count: None,
) -> Posterior:
    """Sample the posterior around a fit.

    Args:
        prediction: Records and friction model.
        names: Names of the n estimated parameters.
        values: Name -> value of all parameters, SI.
        covariance: Covariance of the estimates, (n, n), SI.
        prior: A-priori knowledge of the estimated parameters.
        speed_sigmas: Standard deviation of the measured speed of each record, rad/s.
        effects: Effects outside the model; those more likely present than absent take part.
        errors: Errors of the current.
        rounding: Variance of the current in each interval of each record, (N - 1,), A²; none: 0.
        on_progress: Called with the draws of each chain so far.
    """
    likely = {e.name: e for e in effects if e.likely}
    linear = prediction.linearise(np.array([values[n] for n in prediction.names]))
    assert linear is not None  # the fit was predicted
    sigma = dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    every = [error.nuisance(prediction, linear) for error in errors]
    every += nuisances(prediction, linear, values, sigma)
    likely_nuisances = [e for e in every if e.name in likely]
    levels = [likely[n].value if n in likely else 0.0 for n, _ in TORQUES]
    records = []
    parts = zip(prediction.records, linear, speed_sigmas, strict=True)
    for k, (record, each, speed_sigma) in enumerate(parts):
        variance = rounding[k] if rounding else 0.0
        noise = torque_noise(prediction, record, each, values, variance)
        spreads = [_spread(likely[e.name]) * e.columns[k] for e in likely_nuisances]
        columns = np.column_stack([np.zeros((len(record.time), 0)), *spreads])
        records.append(
            record_data(prediction, k, speed_sigma, noise, levels, each.transition, columns)
        )
    data = posed(prediction, names, values, covariance, prior, records)
    log_density = density(prediction.model, prediction.hold, prediction.shared)
    draws, acceptance = sample(log_density, data, len(names), on_progress=on_progress)
    differences = [
        (names.index(n), names.index(r))
        for n, r in prediction.model.vanishing_at.items()
        if n in names and r in names
    ]
    units = [si_unit(prediction.dimensions[name]) for name in names]
    every = parameters_of(data, draws)
    return judged(every, names, differences, acceptance, tuple(likely), units)


def _spread(effect: Effect) -> float:
    """Prior sigma of a coefficient: wide compared with what the fit found."""
    return 3.0 * max(abs(effect.value), effect.sigma or 0.0)


def parameters_of(data: Posed, drawn: Vector) -> Vector:
    """Parameters of draws u, (chains, draws, n), SI."""
    every = jax.vmap(lambda u: data.coordinates.values(u)[0])
    return np.asarray(every(jnp.asarray(drawn.reshape(-1, drawn.shape[-1])))).reshape(drawn.shape)


def judged(
    drawn: Vector,
    names: Sequence[str],
    differences: Sequence[tuple[int, int]],
    accepted: float,
    effects: tuple[str, ...] = (),
    units: Sequence[str] = (),
) -> Posterior:
    """Summarise draws, and judge whether the chains mixed.

    Args:
        drawn: Parameters, (chains, draws, n), SI.
        names: Names of the n parameters.
        differences: Pairs of indices whose difference is listed too.
        accepted: Rate of accepted steps.
        effects: Names of the effects in the likelihood.
        units: SI units of the n parameters.
    """
    from blackjax.diagnostics import (  # pyright: ignore[reportMissingImports]
        effective_sample_size,
        potential_scale_reduction,
    )

    columns = [(name, drawn[:, :, k]) for k, name in enumerate(names)]
    columns += [(f"{names[a]}-{names[b]}", drawn[:, :, a] - drawn[:, :, b]) for a, b in differences]
    marginals = []
    for name, column in columns:
        halves = column[:, : 2 * (column.shape[1] // 2)].reshape(2 * len(column), -1)
        marginals.append(
            Marginal(
                name=name,
                mean=float(np.mean(column)),
                sigma=float(np.std(column)),
                quantiles=np.quantile(column, QUANTILES),
                rhat=float(potential_scale_reduction(halves)),
                effective=float(effective_sample_size(halves)),
                draws=column.ravel(),
                unit=dict(zip(names, units, strict=False)).get(name.partition("-")[0], ""),
            )
        )
    faults = []
    worst = max(marginals, key=lambda m: m.rhat)
    fewest = min(marginals, key=lambda m: m.effective)
    if not worst.rhat <= LARGEST_RHAT:
        faults.append(f"the chains differ in {worst.name} (R-hat {worst.rhat:.3f})")
    if not fewest.effective >= FEWEST:
        faults.append(f"{fewest.name} has only {fewest.effective:.0f} effective draws")
    return Posterior(tuple(marginals), len(drawn), accepted, effects, tuple(faults))
