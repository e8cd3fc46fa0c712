"""Short flights of the example scenarios, and the largest metrics of very many independent runs.

Events and dispersed times are moved into the shorter flights, and one slew is left out; everything
else is as in the examples.

python benchmarks/short_flights.py FLIGHT FILE.npz RUNS [SEED]
    brute force on one core; the same command with more runs continues from the file

The file has for each metric its largest values in all runs, and for the first 2^20 runs the largest
one and the largest one of the runs whose dispersions are within 3 sigma (`first`).
"""

import os
import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy.special import ndtri

from gyrostat.campaigns.draws import draw, shares
from gyrostat.campaigns.engine import fly_given
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.search.worst_case import WorstCase

EXAMPLES = Path(__file__).parents[1] / "examples" / "scenarios"
SLEW = """[[event]]
name = "turn"
kind = "slew"
time = "120 s"
target = [0.9659258, 0.0, 0.258819, 0.0]    # 30 deg about y

"""
# name -> scenario file, its changes
FLIGHTS = {
    "crossing": (
        "zero_crossing_model.toml",
        {
            'duration = "400 s"': 'duration = "10 s"',
            'after = "60 s"': 'after = "2 s"',
            'crossing_window = "20 s"': 'crossing_window = "2 s"',
        },
    ),
    "failure": (
        "wheel_failure.toml",
        {
            'duration = "300 s"': 'duration = "15 s"',
            'time = "60 s"': 'time = "5 s"',
            'low = "40 s"': 'low = "3 s"',
            'high = "80 s"': 'high = "7 s"',
            'detected_after = "5 s"': 'detected_after = "2 s"',
            SLEW: "",
            'after = "220 s"': 'after = "8 s"',
        },
    ),
    "array": (
        "wheel_array.toml",
        {
            'duration = "600 s"': 'duration = "20 s"',
            'time = "150 s"': 'time = "12 s"',
            'time = "400 s"': 'time = "7 s"',
            'detected_after = "10 s"': 'detected_after = "1 s"',
            'low = "350 s"': 'low = "5 s"',
            'high = "450 s"': 'high = "9 s"',
            'after = "300 s"': 'after = "3 s"',
        },
    ),
    "slew": (
        "nadir_and_slew.toml",
        {
            'duration = "300 s"': 'duration = "10 s"',
            'until_time = "170 s"': 'until_time = "8 s"',
            'after = "30 s"': 'after = "3 s"',
        },
    ),
    "table": (
        "carrara_kuga.toml",
        {
            'duration = "400 s"': 'duration = "10 s"',
            'after = "60 s"': 'after = "2 s"',
            '"-673.5 rpm"': '"-30 rpm"',
            'crossing_window = "60 s"': 'crossing_window = "2 s"',
        },
    ),
    "worn": (
        "moreira_lopes_kuga.toml",
        {
            'duration = "300 s"': 'duration = "20 s"',
            'time = "150 s"': 'time = "10 s"',
            'after = "50 s"': 'after = "5 s"',
            'crossing_window = "30 s"': 'crossing_window = "3 s"',
        },
    ),
    "regulator": (
        "carvalho_fenili.toml",
        {
            'duration = "200 s"': 'duration = "20 s"',
            'low = "5 s"': 'low = "2 s"',
            'high = "60 s"': 'high = "18 s"',
            'after = "100 s"': 'after = "10 s"',
        },
    ),
}
BODIES = ("cubesat", "table", "cube")
METRICS = ("error_max", "error_rms", "error_end", "momentum_peak", "torque_peak", "torque_rms")
SEED, AT_ONCE, FIRST, KEPT, SAVED = 987654, 4096, 2**20, 3000, 2**18


def short_flight(name):
    """Scenario of a short flight."""
    file, changes = FLIGHTS[name]
    text = (EXAMPLES / file).read_text()
    for old, new in changes.items():
        assert text.count(old) == 1, f"{file}: {old}"
        text = text.replace(old, new)
    for body in BODIES:
        text = text.replace(f'file = "{body}.toml"', f'file = "{EXAMPLES / body}.toml"')
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scenario.toml"
        path.write_text(text)
        return read_scenario(path)


def brute_force(name, file, runs, seed=SEED):
    """Simulate runs that are not yet in a file, and store their largest metrics."""
    flight = short_flight(name)
    bounds = WorstCase.of(flight, METRICS[0], "3sigma").bounds
    known = {"flight": name, "seed": seed, "done": 0, "within": 0}
    if Path(file).exists():
        known = dict(np.load(file))
    assert str(known["flight"]) == name, f"{file}: another flight"
    assert known["seed"] == seed, f"{file}: another seed"
    done = int(known["done"])
    while done < runs:
        numbers = np.arange(done, done + AT_ONCE)
        columns = fly_given(flight, numbers, *draw(flight, seed, numbers)).columns
        assert not np.any(columns["status"])
        first = done < FIRST
        if first:
            place = bounds.coordinates(ndtri(shares(flight, seed, numbers)))
            inside = np.all(np.abs(place) <= 1.0, axis=1)
            known["within"] += np.sum(inside)
        for metric in METRICS:
            values = columns[metric]
            if first:
                worst = [np.max(values), np.max(values[inside])]
                known[f"{metric}.first"] = np.maximum(known.get(f"{metric}.first", 0.0), worst)
            values = np.concatenate([known.get(metric, np.zeros(0)), values])
            known[metric] = np.sort(values)[::-1][:KEPT]
        done += AT_ONCE
        if done % SAVED == 0 or done >= runs:
            known["done"] = done
            np.savez(f"{file}.part.npz", **known)
            os.replace(f"{file}.part.npz", file)
            print(f"{name}: {done} runs", flush=True)


if __name__ == "__main__":
    brute_force(*sys.argv[1:3], *(int(float(each)) for each in sys.argv[3:]))
