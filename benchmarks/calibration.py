"""Simulation-based calibration of `identify --posterior` (Talts et al. 2018).

    python benchmarks/calibration.py [--records 1008] [--seed 90000]

For each record, parameters are drawn from the prior, a small record is simulated from them (12 s at
10 Hz, 5 rpm noise) and the posterior is sampled. If the sampler is right, the rank of the truth
among independent draws is uniform. Printed for each parameter: chi-square of the ranks in ten bins
with its probability, and coverage of the 95 % interval. Needs the extra `posterior`.
"""

import argparse
import sys

import numpy as np
from scipy.stats import chi2

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import RPM
from gyrostat.identification.fit.least_squares import Prior
from gyrostat.identification.fit.prediction import SpeedPrediction
from gyrostat.identification.uncertainty.posterior import parameters_of
from gyrostat.identification.uncertainty.posterior_density import (
    Posed,
    RecordData,
    density,
    posed,
    record_data,
)
from gyrostat.identification.uncertainty.posterior_sampler import chain
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import Stribeck

INERTIA, NOISE, COUNT = 1.5e-3, 5.0 * RPM, 121
NAMES = ("motor_constant", "viscous", "coulomb", "static")
MEAN = np.array([0.0228, 5e-6, 0.88e-3, 0.91e-3])
SIGMA = np.array([2e-4, 2e-6, 30e-6, 50e-6])
PRIOR = Prior(MEAN, SIGMA)
TOGETHER, CHAINS, WARM_UP, CHUNKS = 16, 8, 3, 8
"""Records sampled together, chains of each, and chunks of warm-up and of draws."""
STEP = 2.38 / np.sqrt(len(NAMES)) * jnp.eye(len(NAMES))
"""Size of a step; the coordinates are whitened by the linear estimate."""
BINS, RANKS = 10, 79
"""Bins of the ranks, and draws of each record that the truth is ranked among."""
TIME = np.arange(COUNT) / 10.0
CURRENT = 0.045 + 0.05 * np.sin(2.0 * np.pi * TIME / 8.0)


def truth(random: np.random.Generator) -> np.ndarray:
    """Parameters from the prior, within the limits of the posterior, (4,)."""
    while True:
        drawn = MEAN + SIGMA * random.standard_normal(4)
        if np.all(drawn > 0.0) and drawn[3] > drawn[2]:
            return drawn


def small_record(true: np.ndarray, random: np.random.Generator) -> Posed:
    """Posterior of a record of a wheel with these parameters, which starts from rest."""
    held = {"inertia": INERTIA, "stribeck_speed": 0.4189, "current_bias": 0.0, "initial_speed": 0.0}
    empty = Record("small", TIME, CURRENT, np.zeros(COUNT), TIME >= 0.0)
    prediction = SpeedPrediction([empty], Stribeck, "zero-order")
    values = {**held, **dict(zip(NAMES, true.tolist(), strict=True))}
    ((speed, rows),) = prediction(np.array([values[n] for n in prediction.names]))
    error = NOISE * random.standard_normal(COUNT)
    # coordinates around the linear estimate; the density does not depend on them
    own = rows[:, [prediction.names.index(n) for n in NAMES]] / NOISE
    covariance = np.linalg.inv(own.T @ own + PRIOR.information())
    near = true + covariance @ (own.T @ error / NOISE + PRIOR.information() @ (MEAN - true))
    values |= dict(zip(NAMES, near.tolist(), strict=True))
    made = record_data(prediction, 0, NOISE)
    parts, first = made.noise
    data = RecordData(
        inputs=tuple(each[:COUNT] for each in made.inputs),
        place=made.place[:COUNT],
        at=made.at,
        averaged=made.averaged[:COUNT],
        speed=speed + error,
        variance=made.variance[:COUNT],
        noise=(parts[:COUNT], first),
        columns=made.columns[:COUNT],
    )
    return posed(prediction, NAMES, values, covariance, PRIOR, [data])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=1008)
    parser.add_argument("--seed", type=int, default=90000)
    given = parser.parse_args()
    step = jax.jit(jax.vmap(chain(density(Stribeck, "zero-order", 7)), (0, 0, None, 0)))
    ranks, inside = [], []
    for first in range(0, given.records, TOGETHER):
        randoms = [np.random.default_rng([given.seed, first + k]) for k in range(TOGETHER)]
        true = np.array([truth(random) for random in randoms])
        made = [small_record(*each) for each in zip(true, randoms, strict=True)]
        data = jax.tree.map(lambda *parts: jnp.repeat(jnp.stack(parts), CHAINS, axis=0), *made)
        key = jax.random.key(given.seed + first)
        position, parts = jax.random.normal(key, (TOGETHER * CHAINS, 4)), []
        for k in range(WARM_UP + CHUNKS):
            keys = jax.random.split(jax.random.fold_in(key, k), TOGETHER * CHAINS)
            drawn, _ = step(keys, position, STEP, data)
            position = drawn[:, -1]
            parts.append(drawn)
        drawn = np.concatenate(parts[WARM_UP:], axis=1).reshape(TOGETHER, -1, 4)
        for own, random, wheel, u in zip(made, randoms, true, drawn, strict=True):
            every = parameters_of(own, u[None])[0]
            every = np.column_stack([every, every[:, 3] - every[:, 2]])
            wheel = np.append(wheel, wheel[3] - wheel[2])
            few = every[random.permutation(len(every))[:RANKS]]
            ranks.append((few < wheel).sum(axis=0))
            low, high = np.quantile(every, [0.025, 0.975], axis=0)
            inside.append((low <= wheel) & (wheel <= high))
        print(f"{len(ranks)} records", file=sys.stderr, flush=True)
    show(np.array(ranks), np.array(inside))


def show(ranks: np.ndarray, inside: np.ndarray) -> None:
    """Print chi-square of the ranks and coverage for each parameter."""
    print(f"{len(ranks)} records; chi-square over {BINS} bins; 95 % interval")
    for k, name in enumerate([*NAMES, "static-coulomb"]):
        counts = np.bincount(ranks[:, k] * BINS // (RANKS + 1), minlength=BINS)
        expected = len(ranks) / BINS
        size = float(np.sum((counts - expected) ** 2) / expected)
        chance = chi2.sf(size, BINS - 1)
        covered = 100.0 * np.mean(inside[:, k])
        print(f"{name:>16s}  {size:6.1f}  p = {chance:.2f}  {covered:5.1f} %  {counts.tolist()}")


if __name__ == "__main__":
    main()
