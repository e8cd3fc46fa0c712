"""Tolerance limits of lots of wheels: share of the lots whose limits hold.

    python benchmarks/lot.py [--lots 1000] [--wheels 20,200] [--errors 0.3] [--seed 90000]
        [--truth normal,...] [--shape unknown,normal,log-normal] [--outliers]

True values are drawn from a known distribution, estimates with normal errors whose standard
deviation, of the stated share of the spread, scatters by a factor of 1.35 between wheels. For
each shape that the analysis is told: share of the lots in which at least 95 % of the true
distribution is above the lower limit, below the upper limit, and inside the interval, at 95 %
confidence; the same with classical factors and the standard deviation of the estimates; the ratio
of the standard deviation of the wheels to the truth, and of that of the estimates.
With `--outliers`: share of the lots in which a wheel is called an outlier, none being one.
Seeds below 90000 served development.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import stats

from gyrostat.core.skewed_normal import deviation
from gyrostat.identification.lot.limits import (
    one_sided_factor,
    tolerance_limits,
    two_sided_factor,
)
from gyrostat.identification.lot.outliers import outliers
from gyrostat.identification.lot.posterior import SHAPES, lot_draws

CONTENT = CONFIDENCE = 0.95
MEAN = 10.0


@dataclass(frozen=True)
class Truth:
    """Distribution of the true values.

    Attributes:
        draw: Values of n wheels.
        below: Share of the lot below a value.
        sigma: Standard deviation.
    """

    draw: Callable[[np.random.Generator, int], np.ndarray]
    below: Callable[[float], float]
    sigma: float


def of_scipy(law: object) -> Truth:
    """Distribution of scipy.stats."""
    return Truth(lambda random, n: law.rvs(n, random_state=random), law.cdf, float(law.std()))


def two_suppliers() -> Truth:
    """Two normal halves, four standard deviations of one apart."""
    halves = [stats.norm(MEAN + shift, 1.0) for shift in (-2.0, 2.0)]

    def draw(random: np.random.Generator, count: int) -> np.ndarray:
        return MEAN + random.choice([-2.0, 2.0], count) + random.standard_normal(count)

    return Truth(draw, lambda x: float(np.mean([h.cdf(x) for h in halves])), float(np.sqrt(5.0)))


TRUTHS = {
    "normal": of_scipy(stats.norm(MEAN, 1.0)),
    "log-normal 0.15": of_scipy(stats.lognorm(0.15, scale=MEAN)),
    "log-normal 0.3": of_scipy(stats.lognorm(0.3, scale=MEAN)),
    "log-normal 0.5": of_scipy(stats.lognorm(0.5, scale=MEAN)),
    "gamma 4": of_scipy(stats.gamma(4.0, loc=MEAN)),
    "Weibull 2": of_scipy(stats.weibull_min(2.0, loc=MEAN, scale=3.0)),
    "t 5": of_scipy(stats.t(5, loc=MEAN)),
    "uniform": of_scipy(stats.uniform(MEAN, 3.0)),
    "two suppliers": two_suppliers(),
}


def estimates(
    truth: Truth, random: np.random.Generator, count: int, ratio: float
) -> tuple[np.ndarray, np.ndarray]:
    """Estimates of a lot, and the standard deviations of their errors."""
    errors = ratio * truth.sigma * np.exp(0.3 * random.standard_normal(count))
    return truth.draw(random, count) + errors * random.standard_normal(count), errors


def holds(truth: Truth, lower: float, upper: float, low: float, high: float) -> list[bool]:
    """Whether lower limit, upper limit and interval contain the share."""
    return [
        truth.below(lower) <= 1.0 - CONTENT,
        truth.below(upper) >= CONTENT,
        truth.below(high) - truth.below(low) >= CONTENT,
    ]


def measure(name: str, count: int, shape: str, arguments: argparse.Namespace) -> None:
    """Print the row of one true distribution, number of wheels and shape."""
    truth, factors = TRUTHS[name], (one_sided_factor, two_sided_factor)
    one, two = (factor(count, CONTENT, CONFIDENCE) for factor in factors)
    limits_hold, classical, ratios, effective, alarms = [], [], [], [], 0
    began = time.process_time()
    for lot in range(arguments.lots):
        random = np.random.default_rng([arguments.seed, count, lot])
        values, errors = estimates(truth, random, count, arguments.errors)
        draws = lot_draws(values, errors, shape)
        limits = tolerance_limits(draws, CONTENT, CONFIDENCE)
        ends = limits.lower, limits.upper, limits.low, limits.high
        limits_hold.append(holds(truth, *ends))
        mean, sigma = values.mean(), values.std(ddof=1)
        k = sigma * np.array([-one, one, -two, two])
        classical.append(holds(truth, *(mean + k)))
        spread = float(deviation(*draws.typical()[1:]))
        ratios.append([spread / truth.sigma, sigma / truth.sigma])
        effective.append(draws.effective)
        if arguments.outliers:
            alarms += bool(outliers(values, errors, shape, 1))
    seconds = (time.process_time() - began) / arguments.lots
    shares = [100.0 * np.mean(rows, axis=0) for rows in (limits_hold, classical)]
    text = " | ".join(" ".join(f"{s:5.1f}" for s in row) for row in shares)
    spread, naive = np.mean(ratios, axis=0)
    print(
        f"{name:16} {count:4} {shape:10} {text} | {spread:.3f} {naive:.3f} | "
        f"{np.median(effective):5.0f} {np.min(effective):4.0f} {seconds:.3f} s"
        + (f" | outliers {100.0 * alarms / arguments.lots:.1f} %" if arguments.outliers else ""),
        flush=True,
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lots", type=int, default=1000)
    parser.add_argument("--wheels", default="20,200")
    parser.add_argument("--errors", type=float, default=0.3)
    parser.add_argument("--seed", type=int, default=90000)
    parser.add_argument("--truth", default=",".join(TRUTHS))
    parser.add_argument("--shape", default=",".join(SHAPES))
    parser.add_argument("--outliers", action="store_true")
    arguments = parser.parse_args()
    print("truth, wheels, shape; limits hold, %: lower upper interval | classical factors | ")
    print(
        "sigma / truth, of the estimates / truth | effective draws, fewest; processor time per lot"
    )
    for name in arguments.truth.split(","):
        for count in map(int, arguments.wheels.split(",")):
            for shape in arguments.shape.split(","):
                measure(name, count, shape, arguments)


if __name__ == "__main__":
    main()
