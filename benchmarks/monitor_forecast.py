"""Judge the forecast of the monitor on simulated wheels whose friction grows.

    python benchmarks/monitor_forecast.py [--wheels 600] [--sigma 0.006]

The Coulomb torque of each wheel begins to grow on a day of its own; its slope wanders, and in a
quarter of the wheels the growth stops before the limit of 1.5 times the torque: they are censored,
not left out. Each wheel has one forecast, 30 days before the true day, or, where it never comes, on
a day on which the growth looks alike. Wheels below 1000 set the walks of the slope that the
forecast allows; they are not judged. The peer is a straight line through the last 30 days with the
error of its intersection.
"""

import argparse

import numpy as np

from gyrostat.monitoring.change.channels import Observation, Reference
from gyrostat.monitoring.change.detector import Detector
from gyrostat.monitoring.change.forecast import Forecast, Series, forecast

LIMIT = 1.5
AHEAD = 30
HORIZON = np.unique(np.round(np.geomspace(1.0, 2000.0, 300), 1))
SCORED = 365.0
"""Days over which the score is integrated."""


def wheel(number, longest=700):
    """Coulomb torque of each day, and the day on which it reaches the limit; infinite if never."""
    random = np.random.default_rng([number, 31])
    onset = int(random.integers(40, 80))
    slope = 4e-3 * np.exp(0.5 * random.standard_normal())
    wander = slope * np.exp(np.cumsum(0.02 * random.standard_normal(longest)))
    day = np.arange(longest)
    torque = 1.0 + np.cumsum(np.where(day >= onset, wander, 0.0))
    if random.uniform() < 0.25:
        torque = np.minimum(torque, random.uniform(1.2, 1.45))
    reached = np.flatnonzero(torque >= LIMIT)
    return torque, float(reached[0]) if reached.size else np.inf, random


def forecasts(number, sigma):
    """Forecasts of the monitor and of a straight line for one wheel; the true time, days."""
    torque, day, random = wheel(number)
    if np.isfinite(day):
        now = int(day) - AHEAD
    else:
        now = int(np.argmax(torque >= 1.0 + 0.8 * (torque[-1] - 1.0)))
    if now < 40:
        return None
    values = torque[:now] + sigma * random.standard_normal(now)
    detector = Detector(Reference(1.0, 1.0, 1.0), onsets=120)
    information = np.diag([sigma**-2.0, 1e4, 1e5, 1e4])
    nothing = np.full(4, np.nan)
    for value in values:
        seen = np.array([value, 1.0, 1.0, 0.0])
        seen[1:] += np.array([1e-2, 3e-3, 1e-2]) * random.standard_normal(3)
        verdict = detector.take(Observation.of(information @ seen, information, nothing))
    series = Series(values, np.full(now, sigma**2), np.ones(now))
    ours = forecast(series, verdict.onset or (), LIMIT, HORIZON)
    # both count from the last day seen
    return ours, line(values), day - (now - 1)


def line(values):
    """Distribution from a straight line through the last 30 days."""
    last = values[-30:]
    x = np.arange(last.size) - (last.size - 1.0)
    (slope, level), covariance = np.polyfit(x, last, 1, cov=True)
    if slope <= 0.0:
        return Forecast(HORIZON, np.zeros(HORIZON.size))
    random = np.random.default_rng(0)
    slopes, levels = random.multivariate_normal([slope, level], covariance, 4000).T
    times = np.where(slopes > 0.0, (LIMIT - levels) / np.where(slopes > 0.0, slopes, 1.0), np.inf)
    return Forecast(HORIZON, np.mean(times[:, None] <= HORIZON, axis=0))


def score(found, time):
    """Continuous ranked probability score up to `SCORED`, days."""
    grid = np.arange(1.0, SCORED)
    law = np.interp(grid, found.days, found.reached)
    return float(np.sum((law - (time <= grid)) ** 2))


def main():
    """Run all wheels."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wheels", type=int, default=600)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--sigma", type=float, default=0.006)
    arguments = parser.parse_args()
    results = [
        forecasts(n, arguments.sigma)
        for n in range(arguments.first, arguments.first + arguments.wheels)
    ]
    results = [each for each in results if each is not None]
    reach = [each for each in results if np.isfinite(each[2])]
    print(f"{len(results)} forecasts, {len(reach)} of wheels that reach the limit")
    for name, k in (("monitor", 0), ("straight line", 1)):
        inside = np.array([r[k].quantile(0.1) <= r[2] <= r[k].quantile(0.9) for r in reach])
        width = np.median([r[k].quantile(0.9) - r[k].quantile(0.1) for r in reach])
        scores = np.array([score(r[k], r[2]) for r in results])
        error = 1.96 * np.std(inside) / np.sqrt(inside.size)
        never = np.mean([r[k].quantile(0.9) == np.inf for r in results if not np.isfinite(r[2])])
        print(
            f"{name}: 80 % interval holds {inside.mean():.3f} +- {error:.3f}, median width "
            f"{width:.0f} days; score {scores.mean():.2f} +- "
            f"{1.96 * scores.std() / np.sqrt(scores.size):.2f} days; upper limit open for "
            f"{never:.2f} of the wheels that never reach it"
        )


if __name__ == "__main__":
    main()
