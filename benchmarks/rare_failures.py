"""Coverage of the intervals of `gyrostat campaign --rare`, against known failure probabilities.

python benchmarks/rare_failures.py analytic [SEEDS [RUNS]]
    functions of normal numbers with a probability of 1e-6 in closed form
python benchmarks/rare_failures.py truth FILE.npz RUNS
    brute force: the largest metrics of independent runs of short flights
python benchmarks/rare_failures.py scenario FILE.npz METRIC [SEEDS [RUNS]]
    searches for the value of the metric that about one in 1e5 of these runs exceeds
"""

import os
import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy.special import ndtri

from gyrostat.campaigns import Campaign
from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.engine import fly_given, prepare
from gyrostat.campaigns.executors import kept_open, threads
from gyrostat.campaigns.reading.scenario_file import read_scenario
from gyrostat.campaigns.search.condition import Condition
from gyrostat.campaigns.search.estimate import rarity
from gyrostat.campaigns.search.flights import Flights, together
from gyrostat.campaigns.search.moves import Answers
from gyrostat.campaigns.search.noise import parts_of
from gyrostat.campaigns.search.rare import REPLICATIONS, chains_of
from gyrostat.campaigns.search.subset import subset_simulation

EXAMPLES = Path(__file__).parents[1] / "examples" / "scenarios"
SHORT = {
    'duration = "400 s"': 'duration = "10 s"',
    'after = "60 s"': 'after = "2 s"',
    'crossing_window = "20 s"': 'crossing_window = "2 s"',
    'file = "cubesat.toml"': f'file = "{EXAMPLES / "cubesat.toml"}"',
}
METRICS = ("error_max", "momentum_peak", "torque_peak")
TRUTH_SEED, AT_ONCE, KEPT = 987654, 4096, 3000
SMALL = -ndtri(1e-6)
PARTS = 160
# name -> response of dispersions z and of the noise of each part w, number of dispersions, parts
CASES = {
    "one parameter of ten": (lambda z, w: z[:, 0] - SMALL, 10, 1),
    "sum of five parameters": (lambda z, w: z.sum(axis=1) / np.sqrt(5.0) - SMALL, 5, 1),
    "sum of noise": (lambda z, w: w.sum(axis=1) / np.sqrt(PARTS) - SMALL, 2, PARTS),
    "parameters and noise": (
        lambda z, w: (w.sum(axis=1) / np.sqrt(PARTS) + z[:, 0]) / np.sqrt(2.0) - SMALL,
        3,
        PARTS,
    ),
    "two sides": (lambda z, w: np.abs(z[:, 0]) + ndtri(5e-7), 3, 1),
    "all around": (lambda z, w: np.sum(z**2, axis=1) + 2.0 * np.log(1e-6), 2, 1),
}


def short_scenario():
    """The zero crossing of the examples, 10 s of it."""
    text = (EXAMPLES / "zero_crossing.toml").read_text()
    for old, new in SHORT.items():
        assert old in text
        text = text.replace(old, new)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scenario.toml"
        path.write_text(text)
        return read_scenario(path)


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
    chains = chains_of(runs)
    searches = [subset_simulation(chains, [seed, k]) for k in range(REPLICATIONS)]
    return rarity(together(searches, fly))


def report(name, truth, found, flown):
    """Print one row; `truth` is a probability, or the ends of its 95 % interval."""
    low, high = np.broadcast_to(truth, 2)
    answered = [each for each in found if each.probability is not None]
    covers = sum(each.low <= high and each.high >= low for each in answered)
    fine = [each for each in answered if not each.doubts]
    trusted = sum(each.low <= high and each.high >= low for each in fine)
    values = np.array([each.probability for each in answered])
    print(
        f"{name} | {np.mean([low, high]):.2e} | {np.mean(values):.2e} | {np.mean(flown):.0f} | "
        f"{100 * np.std(values) / np.mean(values):.0f} % | {covers} of {len(found)} | "
        f"{len(found) - len(fine)} | {trusted} of {len(fine)}",
        flush=True,
    )


def analytic(seeds=100, runs=20_000):
    for name, (response, size, parts) in CASES.items():
        flights = [Functions(response, size, parts, seed) for seed in range(seeds)]
        found = [searched(each.fly, runs, seed) for seed, each in enumerate(flights)]
        report(name, 1e-6, found, [each.count for each in flights])


def truth(file, runs):
    scenario, done = short_scenario(), 0
    largest = {name: np.zeros(0) for name in METRICS}
    while done < runs:
        numbers = np.arange(done, done + AT_ONCE)
        columns = fly_given(scenario, numbers, *draw(scenario, TRUTH_SEED, numbers)).columns
        assert not np.any(columns["status"])
        for name in METRICS:
            largest[name] = np.sort(np.concatenate([largest[name], columns[name]]))[::-1][:KEPT]
        done += AT_ONCE
        if done % (64 * AT_ONCE) == 0:
            np.savez(file, done=done, **largest)
            print(f"{done} runs", flush=True)
    np.savez(file, done=done, **largest)


def scenario(file, metric, seeds=100, runs=20_000):
    known = np.load(file)
    short, done = short_scenario(), int(known["done"])
    count = max(round(1e-5 * done), 1)
    bound = float(np.mean(known[metric][count - 1 : count + 1]))
    # 95 % interval of the truth itself
    half = 1.96 * np.sqrt(count)
    failure = Condition.parse(f"{metric} > {bound!r}", short, "benchmark")
    prepare(short, parts=parts_of(short))
    found, flown = [], []
    with kept_open(threads(len(os.sched_getaffinity(0)))) as pool:
        for seed in range(seeds):
            about = Campaign("", "", seed, runs, 1, {})
            flights = Flights(short, about, failure.response, found=lambda _: None, opener=pool)
            found.append(searched(flights.fly, runs, seed))
            flown.append(flights.count)
            if seed % 10 == 9:
                report(
                    f"{metric}, {seed + 1} seeds",
                    (count + np.array([-half, half])) / done,
                    found,
                    flown,
                )


if __name__ == "__main__":
    mode, *given = sys.argv[1:]
    numbers = [int(float(each)) if each[0].isdigit() else each for each in given]
    {"analytic": analytic, "truth": truth, "scenario": scenario}[mode](*numbers)
