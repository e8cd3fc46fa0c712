"""Percentiles of 64 runs of 1601 samples: every error sorted, against counting in bins.

python benchmarks/percentiles.py [--repeats 50]

Three percentiles; the errors come in segments of 401 samples, as the engine gives them. The bins of
2 % are those used until 2026-11-22: the engine took a logarithm of every error for their places,
which is not counted here. Times are those of the processor.
"""

import argparse
import time

import numpy as np

from gyrostat.runs.metrics.percentiles import BinnedErrors, SortedErrors

PERCENTS = (50.0, 95.0, 99.7)
LEAST, WIDTH, OLD_BINS = 1e-8, 0.02, 990


def old(places):
    """Histograms of (runs, samples) places, and the percentiles."""
    counts = np.zeros((len(places[0]), OLD_BINS), np.int64)
    for part in places:
        rows = (OLD_BINS + 1) * np.arange(len(part))[:, None]
        found = np.bincount((rows + part).ravel(), minlength=(OLD_BINS + 1) * len(part))
        counts += found.reshape(len(part), -1)[:, :OLD_BINS]
    ranks = [np.ceil(p / 100.0 * counts.sum(axis=1)) for p in PERCENTS]
    return [np.argmax(np.cumsum(counts, axis=1) >= rank[:, None], axis=1) for rank in ranks]


def new(made, parts):
    """Percentiles by a collector."""
    for part in parts:
        made.add(part)
    return [made.percentile(percent) for percent in PERCENTS]


def main():
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--repeats", type=int, default=50)
    repeats = arguments.parse_args().repeats
    errors = np.random.default_rng(1).lognormal(-7.0, 1.0, (64, 1604))
    parts = [np.ascontiguousarray(part) for part in np.split(errors, 4, axis=1)]
    places = [(np.log(part / LEAST) / np.log1p(WIDTH)).astype(int) for part in parts]
    ways = {
        "sorted, exact": lambda: new(SortedErrors(64, 1604), parts),
        "bins of 0.1 to 0.2 %": lambda: new(BinnedErrors(64), parts),
        "old bins of 2 %": lambda: old(places),
    }
    exact = ways["sorted, exact"]()
    print("| way | median | least | largest deviation |\n|---|---|---|---|")
    for name, way in ways.items():
        took = []
        for _ in range(repeats):
            begun = time.process_time()
            found = way()
            took.append(1e3 * (time.process_time() - begun))
        if name.startswith("old"):
            found = [LEAST * (1.0 + WIDTH) ** (place + 0.5) for place in found]
        deviation = max(np.max(np.abs(f / e - 1.0)) for f, e in zip(found, exact, strict=True))
        print(f"| {name} | {np.median(took):.2f} ms | {min(took):.2f} ms | {deviation:.2g} |")


if __name__ == "__main__":
    main()
