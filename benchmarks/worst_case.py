"""Worst cases found by `gyrostat campaign --worst-case`, against the worst of 2^20 random runs.

python benchmarks/worst_case.py FOLDER [RUNS [SEED]]
    FOLDER has the results of short_flights.py, FLIGHT.npz with at least 2^20 runs each

Each worst case is simulated again from what is stored, and has to be the same to the last bit.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from short_flights import FIRST, short_flight

import gyrostat as gs
from gyrostat.campaigns.engine import fly_given
from gyrostat.campaigns.noise import given_of
from gyrostat.campaigns.store import Store
from gyrostat.search.worst_case import found_worst

CASES = (
    ("crossing", "error_max"),
    ("failure", "error_max"),
    ("slew", "error_max"),
    ("table", "error_max"),
    ("array", "torque_peak"),
    ("worn", "torque_rms"),
    ("worn", "error_end"),
)
WITHIN = ("3sigma", "5sigma")
AT_BOUND = 0.99


def again(folder, scenario, number, metric):
    """Metric of a stored run that is simulated again."""
    store = Store(folder)
    values, keys = given_of(store.known(), store.read_table(), [number])
    return fly_given(scenario, [number], values, keys).columns[metric][0]


def searched(flight, metric, within, truth, runs, seed):
    scenario = short_flight(flight)
    with tempfile.TemporaryDirectory() as folder:
        options = {"worst_case": metric, "within": within, "seed": seed, "worst": 0}
        said = []
        made = gs.campaign(scenario, runs, folder, say=said.append, **options)
        worst = found_worst(Path(folder)).worst
        assert again(Path(folder), scenario, worst.number, metric) == worst.response
    known = np.load(truth)
    assert str(known["flight"]) == flight
    assert known["done"] >= FIRST
    anywhere, inside = known[f"{metric}.first"]
    bound = [
        key
        for key, place in zip(scenario.dispersed, worst.coordinates, strict=True)
        if abs(place) > AT_BOUND
    ]
    noisy = any("noise drives" in line.lower() for line in said)
    print(
        f"{flight} | {metric} | {within} | {made.sizes['run']} | {worst.response:.5g} | "
        f"{worst.response / worst.random:.3f} | {worst.response / inside:.3f} | "
        f"{worst.response / anywhere:.3f} | {worst.noise_share:.0%}{', said' if noisy else ''} | "
        f"{len(bound)} of {len(scenario.dispersed)}",
        flush=True,
    )


def main(folder, runs=10_000, seed=1):
    for flight, metric in CASES:
        for within in WITHIN:
            searched(flight, metric, within, f"{folder}/{flight}.npz", int(runs), int(seed))


if __name__ == "__main__":
    main(*sys.argv[1:])
