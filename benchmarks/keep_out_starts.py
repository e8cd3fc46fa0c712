"""Turns around keep-out cones from random starts, found when they start: violations, share solved.

The reference is that of a scenario: an instrument, or two, and a mode that points to nadir or to a
fixed attitude. Each case draws an attitude and a time. The angles along its turn are computed apart
from gyrostat: the Sun by ERFA, the orbit by a circle, rotations by SciPy.

Run with: python benchmarks/keep_out_starts.py --cases 10000 --seed 1
"""

import argparse
import shutil
import tempfile
from pathlib import Path

import erfa
import numpy as np
from scipy.spatial.transform import Rotation

from gyrostat.control.guidance import AttitudeReference
from gyrostat.core.jax64 import jax, jnp
from gyrostat.runs.reference_path import nominal_setup
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[1] / "examples" / "scenarios"
DURATION, SAMPLES, CHUNK = 6000.0, 240, 500
EARTH, MU, HEIGHT = 6378137.0, 3.986004418e14, 500e3
TILT, NODE = np.radians(97.4), np.radians(148.0)
DATE = 2461366.9166666665  # 2026-11-22T10:00:00 as a Julian date
TEXT = """
[run]
duration = "6000 s"
control_period = "1 s"
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "three_axis"
torque_time = "none"
[orbit]
kind = "circular"
epoch = "2026-11-22T10:00:00Z"
altitude = "500 km"
inclination = "97.4 deg"
ascending_node = "148 deg"
{instruments}
[reference]
kind = "sequence"
rate = "1 deg/s"
[[reference.mode]]
name = "any"
kind = "fixed"
target = [1, 0, 0, 0]
[[reference.mode]]
name = "nadir"
kind = "nadir"
along = [0, -1, 0]
keep_out = {names}
[[reference.mode]]
name = "fixed"
kind = "fixed"
target = [0.1, 0.7, -0.5, 0.5]
keep_out = {names}
[[reference.transition]]
from = "any"
to = "nadir"
rate_below = 1.0
[[reference.transition]]
from = "nadir"
to = "fixed"
rate_below = 1.0
"""
CASES = {
    "Sun 35 deg": [("camera", [0, 0, 1], 35.0, 0.0)],
    "Sun 60 deg, Earth 20 deg": [("tracker", [0, 2, -1], 60.0, 20.0)],
    "both instruments": [("camera", [0, 0, 1], 35.0, 0.0), ("tracker", [0, 2, -1], 60.0, 20.0)],
}
"""Name -> name, boresight and angles of each instrument to Sun and limb of the Earth, deg."""


def scenario_of(folder, instruments):
    """Scenario with some instruments."""
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, folder)
    tables = [
        f'[[keep_out]]\nname = "{name}"\nboresight = {axis}\n'
        f'sun = "{sun} deg"\nearth = "{earth} deg"\n'
        for name, axis, sun, earth in instruments
    ]
    names = [name for name, *_ in instruments]
    path = Path(folder) / "scenario.toml"
    path.write_text(TEXT.format(instruments="".join(tables), names=str(names).replace("'", '"')))
    return read_scenario(path)


def sky(time):
    """Directions to Sun and Earth in GCRS, angle of the Earth's disc, whether the Sun is hidden."""
    radius = EARTH + HEIGHT
    angle = np.sqrt(MU / radius**3) * time
    along = np.stack([np.cos(NODE), np.sin(NODE), 0.0])
    up = np.array([-np.sin(NODE) * np.cos(TILT), np.cos(NODE) * np.cos(TILT), np.sin(TILT)])
    place = radius * (np.cos(angle)[..., None] * along + np.sin(angle)[..., None] * up)
    earth = erfa.epv00(DATE, 69.2 / 86400.0)[0]["p"]  # of the Earth about the Sun, au
    sun = -earth * 1.495978707e11 - place
    sun = sun / np.linalg.norm(sun, axis=-1, keepdims=True)
    down = -place / radius
    disc = np.arcsin(EARTH / radius)
    hidden = np.arccos(np.sum(sun * down, axis=-1)) < disc - np.radians(0.27)
    return sun, down, disc, hidden


def least_angles(turned, time, instruments):
    """Least angle of any instrument beyond that which it keeps, at each sample, rad."""
    sun, down, disc, hidden = sky(time)
    least = np.full(time.shape, np.inf)
    for _, axis, of_sun, of_earth in instruments:
        shape = (*time.shape, 3)
        sight = turned.apply(np.array(axis) / np.linalg.norm(axis)).reshape(shape)
        for toward, keep, counts in ((sun, of_sun, ~hidden), (down, of_earth, True)):
            if keep:
                apart = np.arccos(np.clip(np.sum(sight * toward, axis=-1), -1.0, 1.0))
                apart = apart - np.radians(keep) - (disc if toward is down else 0.0)
                least = np.where(counts, np.minimum(least, apart), least)
    return least


def turns(scenario, to, attitude, start):
    """Attitude along the turns, times, whether they are blocked, durations with and without."""
    reference = nominal_setup(scenario).reference

    def one(attitude, start):
        before = AttitudeReference(attitude, jnp.zeros(3), jnp.zeros(3))
        mode = reference.start(watched=False)
        mode = reference.entered(mode, jnp.asarray(to), start, before)
        turn = mode.transition
        time = start + turn.duration * jnp.linspace(0.0, 1.0, SAMPLES)
        along = jax.vmap(lambda t: reference.at(mode, t).attitude)(time)
        return along, time, turn.first.blocked, turn.duration, turn.first.fading

    every = jax.jit(jax.vmap(one))
    parts = [
        every(*(each[k : k + CHUNK] for each in (attitude, start)))
        for k in range(0, len(start), CHUNK)
    ]
    return [np.concatenate(each) for each in zip(*parts, strict=True)]


def measured(name, instruments, to, count, seed):
    """Row of the table, and the number of violations of turns that are not said to be blocked."""
    rng = np.random.default_rng(seed)
    attitude = rng.normal(size=(count, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    start = rng.uniform(0.0, 2500.0, count)
    with tempfile.TemporaryDirectory() as folder:
        scenario = scenario_of(folder, instruments)
        along, time, blocked, duration, direct = turns(scenario, to, attitude, start)
    turned = Rotation.from_quat(along.reshape(-1, 4), scalar_first=True)
    least = least_angles(turned, time, instruments)
    inside = least[:, 0] < 0.0
    ends = least[:, -1] < np.radians(1.0)
    free = ~inside & ~ends
    violated = np.min(least, axis=1) < 0.0
    said = blocked > 0.0
    leaves = inside & ~ends & (blocked == 2.0)
    # after a turn has left the cone it does not come back
    back = [np.any(np.diff((row < 0.0).astype(int)) > 0) for row in least[leaves]]
    detours = free & ~said & (duration > 1.001 * direct)
    ratio = duration[detours] / direct[detours]
    return {
        "case": name,
        "starts outside, target clear": int(free.sum()),
        "solved": int((free & ~said).sum()),
        "eigenaxis is no way": int(detours.sum()),
        "violations without a word": int((violated & ~said).sum()),
        "inside, left": int(leaves.sum()),
        "of inside": int((inside & ~ends).sum()),
        "back inside": int(np.sum(back)),
        "inside without a word": int((inside & ~said).sum()),
        "time over eigenaxis, median and 99 %": np.round(
            np.quantile(ratio, [0.5, 0.99]) if len(ratio) else [1.0, 1.0], 2
        ).tolist(),
    }


def main():
    """Print a row for each case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=10000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    for name, instruments in CASES.items():
        for to, mode in ((1, "nadir"), (2, "fixed")):
            row = measured(f"{name}, {mode}", instruments, to, options.cases, options.seed)
            print(row, flush=True)


if __name__ == "__main__":
    main()
