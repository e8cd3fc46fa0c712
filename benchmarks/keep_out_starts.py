"""Turns around keep-out cones from random starts, found when they start: violations, share solved.

The reference is that of a scenario: an instrument, or two, and a mode that points to nadir or to a
fixed attitude, or sways about that. Each case draws an attitude and a time. The angles along its
turn are computed apart from gyrostat, but for the orbit: the Sun by ERFA, rotations by SciPy; at
240 times, and at 240 more about the nearest one of them. No margin covers errors.

Run with: python benchmarks/keep_out_starts.py --cases 10000 --seed 1
"""

import argparse
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import equinox as eqx
import erfa
import numpy as np
from scipy.spatial.transform import Rotation

from gyrostat.control.guidance import AttitudeReference
from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp
from gyrostat.runs.reference_path import nominal_setup
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[1] / "examples" / "scenarios"
DURATION, SAMPLES, CHUNK = 6000.0, 240, 500
EARTH = 6378137.0
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
keep_out_margin = 0
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
MODES = {
    "nadir": (1, 0.0),
    "fixed": (2, 0.0),
    "swaying in 300 s": (2, 300.0),
    "swaying in 60 s": (2, 60.0),
    "swaying in 20 s": (2, 20.0),
}
"""Name -> number of the mode, period of its sway by 5 deg, s."""


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


def sky(place, time):
    """Directions to Sun and Earth in GCRS, angle of the Earth's disc, whether the Sun is hidden."""
    radius = np.linalg.norm(place, axis=-1)
    days = 69.2 / 86400.0 + time / 86400.0
    earth = erfa.epv00(DATE, days)[0]["p"]  # of the Earth about the Sun, au
    sun = -earth * 1.495978707e11 - place
    sun = sun / np.linalg.norm(sun, axis=-1, keepdims=True)
    down = -place / radius[..., None]
    disc = np.arcsin(EARTH / radius)
    hidden = np.arccos(np.sum(sun * down, axis=-1)) < disc - np.radians(0.266)
    return sun, down, disc, hidden


def least_angles(turned, place, time, instruments):
    """Least angle of any instrument beyond that which it keeps, at each sample, rad."""
    sun, down, disc, hidden = sky(place, time)
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


class Swaying(eqx.Module):
    """Attitude that sways about an axis."""

    attitude: Any
    sway: Any
    period: Any

    def __call__(self, time):
        """Attitude at a time, s."""
        angle = self.sway * jnp.sin(2.0 * jnp.pi * time / self.period)
        turn = rotations.from_rotation_vector(angle * jnp.array([0.6, 0.8, 0.0]))
        return rotations.product(self.attitude, turn)


def reference_of(scenario, period):
    """Reference of a scenario; with a period, s, the last mode sways by 5 deg."""
    reference = nominal_setup(scenario).reference
    if not period:
        return reference
    target = rotations.normalised(jnp.array([0.1, 0.7, -0.5, 0.5]))
    swaying = Swaying(target, jnp.radians(5.0), jnp.asarray(period))
    return replace(reference, modes=(*reference.modes[:-1], swaying))


def turns(reference, to, attitude, start, instruments):
    """Least angles along the turns, whether they are blocked, durations with and without."""

    @jax.jit
    @jax.vmap
    def entered(attitude, start):
        before = AttitudeReference(attitude, jnp.zeros(3), jnp.zeros(3))
        mode = reference.start(watched=False)
        mode = reference.entered(mode, jnp.asarray(to), start, lambda _: before)
        turn = mode.transition
        return mode, (turn.first.blocked, turn.duration, turn.first.fading)

    @jax.jit
    @jax.vmap
    def flown(mode, shares):
        time = mode.start + mode.transition.duration * shares
        along = jax.vmap(lambda t: reference.at(mode, t).attitude)(time)
        return along, jax.vmap(reference.around.keep_outs[0].orbit.position)(time), time

    def angles(mode, shares):
        along, place, time = map(np.asarray, flown(mode, shares))
        turned = Rotation.from_quat(along.reshape(-1, 4), scalar_first=True)
        return least_angles(turned, place, time, instruments)

    parts = []
    for k in range(0, len(start), CHUNK):
        mode, said = entered(attitude[k : k + CHUNK], start[k : k + CHUNK])
        shares = np.tile(np.linspace(0.0, 1.0, SAMPLES), (len(mode.start), 1))
        least = angles(mode, shares)
        near = shares[0][np.argmin(least, axis=1)][:, None]
        beside = near + np.linspace(-1.0, 1.0, SAMPLES) / (SAMPLES - 1.0)
        nearest = np.min(angles(mode, np.clip(beside, 0.0, 1.0)), axis=1)
        parts.append((least, nearest, *said))
    return [np.concatenate(each) for each in zip(*parts, strict=True)]


def measured(name, instruments, to, count, seed, period=0.0):
    """Row of the table, and the number of violations of turns that are not said to be blocked."""
    rng = np.random.default_rng(seed)
    attitude = rng.normal(size=(count, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    start = rng.uniform(0.0, 2500.0, count)
    with tempfile.TemporaryDirectory() as folder:
        scenario = scenario_of(folder, instruments)
        reference = reference_of(scenario, period)
        found = turns(reference, to, attitude, start, instruments)
    least, nearest, blocked, duration, direct = found
    inside = least[:, 0] < 0.0
    ends = least[:, -1] < np.radians(1.0)
    free = ~inside & ~ends
    nearest = np.minimum(np.min(least, axis=1), nearest)
    violated = nearest < 0.0
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
        "nearest without a word, deg": float(np.degrees(np.min(nearest[~said]))),
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
        for mode, (to, period) in MODES.items():
            case = f"{name}, {mode}"
            row = measured(case, instruments, to, options.cases, options.seed, period)
            print(row, flush=True)


if __name__ == "__main__":
    main()
