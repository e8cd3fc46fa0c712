"""Failure probabilities of short flights by importance sampling, a truth beside random runs.

python benchmarks/importance_sampling.py FLIGHT RUNS [FOUND.npz]
    probability of the failure of rare_failures.py and, with FOUND.npz, how many of its searches
    cover it

The dispersed values are drawn around the failures, and each run counts with the ratio of the
densities; the noise is that of ordinary runs. The normal distribution of the values is adapted by
the cross-entropy method (R. Y. Rubinstein and D. P. Kroese, "The Cross-Entropy Method", 2004). The
estimate has no bias, but few runs far from the failures that the adaptation found: random runs show
whether there are others. Where noise drives the failure (`worn`), the adaptation does not find it.
"""

import sys

import numpy as np
from rare_failures import FAILURES, report
from scipy.special import ndtr
from scipy.stats import multivariate_normal
from short_flights import AT_ONCE, short_flight

from gyrostat.campaigns.draws import dispersed_relations, noise_keys, values_at
from gyrostat.campaigns.engine import fly_given
from gyrostat.search.condition import Condition
from gyrostat.search.flights import allowed

SEED, ROUNDS, ADAPTING, KEPT = 77, 7, 8192, 0.1
WIDER, FAR, SHARE_FAR = 1.5, 0.3, 0.3


class Sampler:
    """Responses of runs with given standard normal numbers."""

    def __init__(self, name):
        self.flight, self.count = short_flight(name), 0
        self.relations = dispersed_relations(self.flight)
        self.failure = Condition.parse(FAILURES[name], self.flight, "benchmark")

    def responses(self, normal):
        values = values_at(self.flight, ndtr(normal))
        fine = allowed(self.flight, values, self.relations)
        numbers = self.count + np.arange(len(values))
        self.count += len(values)
        keys = noise_keys(SEED, numbers)
        found = np.full(len(values), -np.inf)
        for part in np.array_split(np.flatnonzero(fine), -(-len(values) // AT_ONCE)):
            columns = fly_given(self.flight, numbers[part], values[part], keys[part]).columns
            found[part] = self.failure.response(columns)
        return found


def adapted(sampler, random):
    """Mean and covariance of the values of failing runs, for standard normal ones."""
    size = len(sampler.flight.dispersed)
    plain = multivariate_normal(np.zeros(size))
    mean, covariance = np.zeros(size), np.eye(size)
    for _ in range(ROUNDS):
        normal = random.multivariate_normal(mean, covariance, ADAPTING)
        found = sampler.responses(normal)
        high = found > min(np.quantile(found, 1.0 - KEPT), 0.0)
        weights = plain.logpdf(normal) - multivariate_normal(mean, covariance).logpdf(normal)
        weights = np.exp(weights[high] - np.max(weights[high]))
        mean = np.average(normal[high], axis=0, weights=weights)
        covariance = np.cov(normal[high].T, aweights=weights) + 1e-3 * np.eye(size)
    return mean, covariance


def main(name, runs, file=None):
    sampler, random = Sampler(name), np.random.default_rng(SEED)
    mean, covariance = adapted(sampler, random)
    size = len(mean)
    # most runs near the failures; some wider, so that no weight is large
    near = multivariate_normal(mean, WIDER * covariance, seed=random)
    far = multivariate_normal(mean, covariance + FAR * np.eye(size), seed=random)
    plain, weights = multivariate_normal(np.zeros(size)), []
    for first in range(0, int(float(runs)), ADAPTING):
        count = min(ADAPTING, int(float(runs)) - first)
        is_far = random.random(count) < SHARE_FAR
        normal = np.where(is_far[:, None], far.rvs(count), near.rvs(count))
        density = np.logaddexp(
            np.log(1.0 - SHARE_FAR) + near.logpdf(normal), np.log(SHARE_FAR) + far.logpdf(normal)
        )
        failed = sampler.responses(normal) > 0.0
        weights.append(np.where(failed, np.exp(plain.logpdf(normal) - density), 0.0))
    weights = np.concatenate(weights)
    probability, error = np.mean(weights), np.std(weights) / np.sqrt(len(weights))
    print(
        f"{name}, {sampler.failure.text}: {probability:.3e}, standard error {error:.1e}, "
        f"{np.sum(weights > 0.0)} of {len(weights)} runs fail"
    )
    if file is not None:
        ends = probability + 1.96 * error * np.array([-1.0, 1.0])
        report(name, ends, np.load(file)["found"])


if __name__ == "__main__":
    main(*sys.argv[1:])
