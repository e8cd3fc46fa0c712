"""Coverage of the intervals of `gyrostat campaign --rare`, against known failure probabilities.

python benchmarks/rare_failures.py analytic [SEEDS [RUNS [PROBABILITY [FIRST]]]]
    functions of normal numbers with a probability in closed form; FIRST: first seed
python benchmarks/rare_failures.py flight FLIGHT TRUTHS FOUND.npz [SEEDS [RUNS [FIRST]]]
    a failure of a short flight, against its share in the files of short_flights.py, separated by
    commas; the same command continues from FOUND.npz
"""

import os
import sys
from pathlib import Path

import numpy as np
from scipy.special import ndtri
from short_flights import short_flight

from gyrostat.campaigns import Campaign
from gyrostat.campaigns.executors import kept_open, threads
from gyrostat.campaigns.noise import parts_of
from gyrostat.campaigns.ready import prepare
from gyrostat.search.condition import Condition
from gyrostat.search.estimate import rarity
from gyrostat.search.flights import Flights, together
from gyrostat.search.moves import Answers
from gyrostat.search.rare import searches_of

FAILURES = {
    "slew": "error_max > 0.475 deg",
    "worn": "error_end > 0.082 deg",
    "failure": "error_max > 0.82 deg",
    "crossing": "torque_peak > 61 uN*m",
}
PARTS = 160


def cases(probability):
    """Name -> response of dispersions z and noise w of each part, and the numbers of both."""
    small = -ndtri(probability)
    return {
        "one parameter of ten": (lambda z, w: z[:, 0] - small, 10, 1),
        "sum of five parameters": (lambda z, w: z.sum(axis=1) / np.sqrt(5.0) - small, 5, 1),
        "sum of noise": (lambda z, w: w.sum(axis=1) / np.sqrt(PARTS) - small, 2, PARTS),
        "parameters and noise": (
            lambda z, w: (w.sum(axis=1) / np.sqrt(PARTS) + z[:, 0]) / np.sqrt(2.0) - small,
            3,
            PARTS,
        ),
        "two sides": (lambda z, w: np.abs(z[:, 0]) + ndtri(probability / 2.0), 3, 1),
        "all around": (lambda z, w: np.sum(z**2, axis=1) + 2.0 * np.log(probability), 2, 1),
    }


class Functions:
    """Flights that are a function of normal numbers."""

    def __init__(self, response, size, parts, seed):
        self.response, self.size, self.parts = response, size, parts
        self.random = np.random.default_rng([seed, 1])
        self.noise, self.count = np.zeros((0, parts)), 0

    def fly(self, moves):
        return [self.answers(each) for each in moves]

    def answers(self, moves):
        normal, noise = moves.normal, self.random.standard_normal((moves.size, self.parts))
        if normal is None:
            normal = self.random.standard_normal((moves.size, self.size))
        else:
            kept = self.random.random(noise.shape) >= moves.share
            noise = np.where(kept, self.noise[moves.parents], noise)
        numbers = self.count + np.arange(moves.size)
        self.count += moves.size
        self.noise = np.concatenate([self.noise, noise])
        return Answers(numbers, normal, self.response(normal, noise))


def searched(fly, runs, seed):
    """Probability, ends of its interval (NaN: no answer) and number of doubts."""
    found = rarity(together(searches_of(runs, seed), fly))
    values = (found.probability, found.low, found.high)
    return [*(np.nan if each is None else each for each in values), len(found.doubts)]


def report(name, truth, found):
    """Print one row; `truth` is a probability, or the ends of its 95 % interval."""
    low, high = np.broadcast_to(truth, 2)
    values, lower, upper, doubts, flown = np.array(found).T
    covers, fine = (lower <= high) & (upper >= low), doubts == 0
    strict = (lower <= np.mean([low, high])) & (upper >= np.mean([low, high]))
    mean, count = np.nanmean(values), len(values)
    print(
        f"{name} | {np.mean([low, high]):.2e} | {mean:.2e} | {np.mean(flown):.0f} | "
        f"{100 * np.nanstd(values) / mean:.0f} % | {np.sum(strict)} of {count} | "
        f"{np.sum(covers)} of {count} | {count - np.sum(fine)} | "
        f"{np.sum(strict & fine)} of {np.sum(fine)}",
        flush=True,
    )


def analytic(seeds=100, runs=20_000, probability=1e-6, first=0):
    for name, (response, size, parts) in cases(probability).items():
        found = []
        for seed in range(int(first), int(first + seeds)):
            flights = Functions(response, size, parts, seed)
            found.append([*searched(flights.fly, int(runs), seed), flights.count])
        report(name, probability, found)


def flight(name, truths, file, seeds=100, runs=20_000, first=0):
    scenario, seeds, runs, first = short_flight(name), int(seeds), int(runs), int(first)
    failure = Condition.parse(FAILURES[name], scenario, "benchmark")
    prepare(scenario, parts=parts_of(scenario))
    found = np.load(file)["found"].tolist() if Path(file).exists() else []
    with kept_open(threads(len(os.sched_getaffinity(0)))) as pool:
        for seed in range(first + len(found), first + seeds):
            about = Campaign("", "", seed, runs, 1, {})
            flights = Flights(scenario, about, failure.response, found=lambda _: None, opener=pool)
            found.append([*searched(flights.fly, runs, seed), flights.count])
            np.savez(file, found=found)
    count = done = 0
    for truth in truths.split(","):
        known = np.load(truth)
        assert str(known["flight"]) == name, f"{truth}: another flight"
        count += np.sum(known[failure.metric] > failure.bound)
        done += int(known["done"])
    # 95 % interval of the truth itself
    ends = (count + 1.96 * np.sqrt(count) * np.array([-1.0, 1.0])) / done
    print(f"{name}, {failure.text}: {count} of {done} runs, {ends[0]:.2e} to {ends[1]:.2e}")
    report(name, ends, found)


if __name__ == "__main__":
    mode, *given = sys.argv[1:]
    numbers = [float(each) if each[0].isdigit() else each for each in given]
    {"analytic": analytic, "flight": flight}[mode](*numbers)
