"""Time until the safe mode has the Sun, from random tumbling.

    python benchmarks/safe_mode.py CASE [--runs 1000] [--seed 1]

The scenario is `safe_mode` of the package, with random attitude, place on the orbit (so that a part
begins in eclipse) and noise, and body rates that are uniform in a box. CASE is

    three     one wheel of four does not work from 1 s on; the momentum is within what the other
              three hold in each attitude
    four      all wheels work; the momentum is within what four wheels hold in each attitude
    rods      up to four times that, which the rods must remove first

The Sun counts as reached when it stays within 10 deg of the panel axis for 60 s in the safe mode;
the time is that of the first such sample. The table of runs stays in a folder that is printed.
"""

import argparse
import tempfile

import jax.numpy as jnp
import numpy as np

import gyrostat as gs
from gyrostat.campaigns.start_momentum import momentum_rooms, start_momentum
from gyrostat.scenario import Dispersion
from gyrostat.scenario_files.scenario_file import read_scenario


class SunReached:
    """Time from which the Sun was near the boresight for 60 s in the safe mode, s."""

    angle: float = np.radians(10.0)
    mode: float = 3.0
    held: float = 60.0
    unit = "s"

    def start(self):
        return -1.0, jnp.inf  # begin of the present stay near the Sun; of the first long one

    def __call__(self, memory, sample):
        begin, first = memory
        near = (sample.error < self.angle) & (sample.mode.number == self.mode)
        begin = jnp.where(near, jnp.where(begin < 0.0, sample.time, begin), -1.0)
        is_long = near & (sample.time - begin >= self.held)
        return begin, jnp.where(is_long, jnp.minimum(first, begin), first)

    def result(self, memory):
        return jnp.where(jnp.isfinite(memory[1]), memory[1], jnp.nan)


RATES = {"three": 3.0, "four": 6.1, "rods": 24.0}
"""Largest rate about each axis, deg/s."""
DURATIONS = {"three": 12000.0, "four": 12000.0, "rods": 60000.0}
"""Duration of a run, s."""


def case(name):
    """Scenario of a case."""
    scenario = read_scenario("safe_mode")
    rate = np.radians(RATES[name])
    others = [d for d in scenario.dispersions if not d.keys[0].startswith(("start.rate", "event"))]
    rates = [Dispersion((f"start.rate.{a}",), "uniform", ((-rate, rate),)) for a in "xyz"]
    changes = {f"start.rate.{axis}": 0.0 for axis in "xyz"}
    changes["event.loss.time"] = 1.0 if name == "three" else DURATIONS[name] - 1.0
    return scenario.replace(
        dispersions=(*others, *rates),
        metric=(SunReached(),),
        **{"run.duration": DURATIONS[name], **changes},
    )


def main():
    """Fly a case and print shares and times."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("case", choices=RATES)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    scenario = case(options.case)
    momentum = start_momentum(scenario, options.seed, options.runs)
    rooms = momentum_rooms(scenario, options.seed, options.runs)
    print("rooms:", [(room.lost, round(1e3 * float(room.every.min()), 2)) for room in rooms])
    print(f"momentum: {1e3 * momentum.min():.3g} to {1e3 * momentum.max():.4g} mN·m·s")
    folder = tempfile.mkdtemp(prefix="safe-mode-")
    runs = gs.campaign(
        scenario, options.runs, out=f"{folder}/{options.case}", seed=options.seed, say=print
    )
    time = np.asarray(runs["sun_reached"])
    reached = np.isfinite(time)
    print(f"{options.runs} runs, seed {options.seed}: Sun reached in {reached.sum()}")
    for share in (50.0, 90.0, 99.0, 100.0):
        print(f"  {share:g} % within {np.percentile(time[reached], share):.0f} s")
    for limit in (1800.0, 3600.0, 5400.0, 7200.0):
        print(f"  within {limit:g} s: {100.0 * np.mean(time <= limit):.1f} %")
    search = sum(np.asarray(runs[f"mode.search_{axis}.time"]) for axis in "xy")
    print(
        f"  longest detumbling {np.asarray(runs['mode.detumble.time']).max():.0f} s, "
        f"longest search {search.max():.0f} s"
    )
    print("  not reached:", np.flatnonzero(~reached).tolist()[:20])


if __name__ == "__main__":
    main()
