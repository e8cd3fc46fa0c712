"""Gains found by `gyrostat tune`, against random search with ten times the flights.

python benchmarks/tuning.py [RUNS [SEED]]

Candidates of the random search are uniform in the coordinates of the search, and are judged on as
many common runs. Given values and both results are then compared in fresh runs.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from short_flights import short_flight

import gyrostat as gs
from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.engine import fly_given
from gyrostat.search.tune import COMMON, PERCENT
from gyrostat.search.tuning import found_tuning

CASES = {
    "crossing": (
        ("controller.rate_gain", "controller.turn_gain", "compensator.band"),
        "error_p95",
        "torque_rms < 30 uN*m",
    ),
    "failure": (
        ("controller.rate_gain", "controller.turn_gain", "controller.drag_time"),
        "error_p95",
        "torque_rms < 60 uN*m",
    ),
    "worn": (
        ("controller.attitude_weight", "controller.rate_weight", "compensator.torque_drift"),
        "error_p95",
        "torque_rms < 40 mN*m",
    ),
}
TIMES, AT_ONCE, FRESH, FRESH_SEED = 10, 32, 2048, 424242


def judged(question, scenario, candidates, seed, runs):
    """Values of candidates, (n, metrics), on common runs of a seed."""
    asked, found = question.scenario(scenario), []
    values, keys = draw(scenario, seed, np.arange(runs))
    for first in range(0, len(candidates), AT_ONCE):
        free = question.numbers(candidates[first : first + AT_ONCE])
        given = np.concatenate(
            [np.tile(values, (len(free), 1)), np.repeat(free, runs, axis=0)], axis=1
        )
        numbers = np.arange(len(given))
        columns = fly_given(asked, numbers, given, np.tile(keys, len(free))).columns
        metrics = -question.response(columns).reshape(len(free), runs, -1)
        found.append(np.quantile(metrics, PERCENT / 100.0, axis=1, method="inverted_cdf"))
    return np.concatenate(found)


def random_search(question, scenario, runs, seed):
    """Best of random candidates, (free,)."""
    random = np.random.default_rng([seed, 2])
    candidates = random.uniform(-1.0, 1.0, (runs // COMMON, len(question.free)))
    values = judged(question, scenario, candidates, seed, COMMON)
    beyond = np.array([question.excess(value) for value in values])
    loss = np.where(beyond <= 0.0, values[:, 0], np.inf)
    return candidates[np.argmin(loss)]


def compared(name, runs, seed):
    free, metric, limit = CASES[name]
    scenario = short_flight(name)
    with tempfile.TemporaryDirectory() as folder:
        gs.tune(scenario, free, metric, folder, subject_to=limit, runs=runs, seed=seed)
        found = found_tuning(Path(folder))
    question, tuned = found.question, found.tuned
    other = random_search(question, scenario, TIMES * runs, seed)
    three = np.array([tuned.start, tuned.best, other])
    values = judged(question, scenario, three, FRESH_SEED, FRESH)
    own, bounds = values[:, 0], [question.excess(value) for value in values]
    print(
        f"{name} | {metric}, {limit} | {len(tuned.tried)} | {own[0]:.4g} | "
        f"{own[1] / own[0]:.3f} | {own[2] / own[0]:.3f} | {own[1] / own[2]:.3f} | "
        + " | ".join(f"{bound:+.1%}" for bound in bounds)
    )
    for numbers in question.numbers(three):
        told = [f"{key} {each:.4g}" for key, each in zip(free, numbers, strict=True)]
        print("   ", ", ".join(told))


def main(runs=30_000, seed=1):
    for name in CASES:
        compared(name, int(runs), int(seed))


if __name__ == "__main__":
    main(*sys.argv[1:])
