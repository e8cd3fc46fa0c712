"""How often chance is taken for a driver, and how often a driver is found.

python benchmarks/soak_drivers.py [--shuffles 200] [--runs 128] [--quick] [--campaign DIR]

A campaign of `zero_crossing_model.toml`, shortened to 60 s, is flown in this process, or
the table of a finished one is read. Then its draws are shuffled against its metrics, so that
nothing drives anything; and keys of known correlation with one metric are planted among the
shuffled ones. Exit code 1 where more shuffled campaigns name a driver than the 99 % limit at a
level of 5 %, where a planted driver of 0.5 is found in less than nine of ten campaigns (at 128 runs
or more), or where more than the 99 % limit name another key beside it.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from scipy.stats import binom, norm, rankdata

from gyrostat.campaigns import Store
from gyrostat.campaigns.drivers import LEVEL, find_drivers
from gyrostat.scenario import Scenario
from gyrostat.scenario.metrics.results import metrics_of

EXAMPLES = Path(__file__).parents[1] / "examples" / "scenarios"
STRENGTHS = (0.2, 0.3, 0.4, 0.5)


def flown(runs):
    """Draws (runs, keys) and metrics (runs, metrics) of a campaign flown here, and their names."""
    import tempfile

    from gyrostat.campaigns.engine import fly
    from gyrostat.campaigns.execute import chosen_engine
    from gyrostat.scenario_files.scenario_file import read_scenario

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file in ("cubesat.toml", "cubesat_wheel.toml"):
            (folder / file).write_text((EXAMPLES / file).read_text())
        text = (EXAMPLES / "zero_crossing_model.toml").read_text()
        text = text.replace('"400 s"', '"60 s"').replace('after = "60 s"', 'after = "20 s"')
        (folder / "scenario.toml").write_text(text)
        scenario = read_scenario(folder / "scenario.toml")
    engine = chosen_engine("auto", scenario, "cpu", print)
    return table_of(scenario, fly(scenario, 1, range(runs), engine=engine).columns)


def finished(folder):
    """The same of a finished campaign."""
    store = Store(folder)
    known, table = store.read(), store.read_table()
    columns = {name: table[name].to_numpy() for name in table.column_names}
    return table_of(Scenario.from_text(known.scenario), columns)


def table_of(scenario, columns):
    """Draws, metrics, and the names of both."""
    keys, names = scenario.dispersed, list(metrics_of(scenario))
    drawn = np.stack([columns[key] for key in keys], axis=1)
    return drawn, np.stack([columns[name] for name in names], axis=1), keys, names


def planted(metric, strength, random):
    """Values whose correlation with the normal scores of a metric is that on average."""
    fine = np.isfinite(metric)
    scores = np.zeros(len(metric))
    scores[fine] = norm.ppf(rankdata(metric[fine]) / (np.sum(fine) + 1.0))
    noise = random.normal(size=len(metric))
    return strength * scores + np.sqrt(1.0 - strength**2) * noise


def main():
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--shuffles", type=int, default=200)
    arguments.add_argument("--runs", type=int, default=128)
    arguments.add_argument("--campaign", type=Path, help="folder of a finished one")
    arguments.add_argument("--quick", action="store_true", help="40 shuffles of 64 runs")
    options = arguments.parse_args()
    if options.quick:
        options.shuffles, options.runs = 40, 64
    found = finished(options.campaign) if options.campaign else flown(options.runs)
    drawn, metrics, keys, names = found
    runs, random = len(drawn), np.random.default_rng(1)
    own = find_drivers(drawn, metrics)
    print(f"{runs} runs, {len(keys)} keys, {len(names)} metrics; as flown:")
    for k, m in np.argwhere(own.named()):
        rho, level = own.rank_correlation[k, m], own.chance_level[m]
        print(f"  {names[m]}: {keys[k]} {rho:+.2f} (level of chance {level:.2f})")

    def shuffled():
        return drawn[random.permutation(runs)]

    count = options.shuffles
    none = sum(np.any(find_drivers(shuffled(), metrics).named()) for _ in range(count))
    most = int(binom.ppf(0.99, count, LEVEL))
    bad = none > most
    print("\n| campaigns | drivers | name the driver | name another key |\n|---|---|---|---|")
    print(f"| {count} shuffled | none | | {none} (at most {most}) |")
    part = max(count // 4, 1)
    most = int(binom.ppf(0.99, part, LEVEL))
    for strength in STRENGTHS:
        right = wrong = 0
        for _ in range(part):
            values = shuffled()
            values[:, 0] = planted(metrics[:, 0], strength, random)
            named = find_drivers(values, metrics).named()
            right += named[0, 0]
            wrong += np.any(named[1:])
        bad |= wrong > most or (strength == 0.5 and runs >= 128 and right < 0.9 * part)
        print(f"| {part} shuffled | one, of {strength:g} | {right} | {wrong} (at most {most}) |")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
