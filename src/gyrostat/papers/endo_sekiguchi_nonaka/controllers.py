"""Controllers of the dispersed cases, and summaries of their runs."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np

from gyrostat.control import FirstOrderLags, SafeFrit, TwoWheelPointing
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import to_body
from gyrostat.core.types import Vector
from gyrostat.estimation import SteadyAttitudeEstimate, SteadyAttitudeFilter
from gyrostat.papers.blocks import in_blocks
from gyrostat.papers.endo_sekiguchi_nonaka.dispersion import AS_KNOWN, Case
from gyrostat.papers.endo_sekiguchi_nonaka.setup import PERIOD, REQUIRED, fixed, tuned
from gyrostat.simulation import Runner, by_engine, control_loop, stack

BLOCK = 64
"""Number of runs that one thread simulates together."""
THREADS = min(2, os.cpu_count() or 1)


class Estimated(eqx.Module):
    """Output feedback: a controller that uses attitude and rate of the attitude filter.

    Attributes:
        controller: Controller of the loop.
        filter: Filter of star tracker and gyro.
    """

    controller: Any
    filter: SteadyAttitudeFilter = SteadyAttitudeFilter()

    def start(self, period: Scalar) -> tuple[SteadyAttitudeEstimate, Any, Scalar]:
        """Memories of both, and the control period."""
        return self.filter.start(), self.controller.start(period), jnp.asarray(period, dtype=float)

    def __call__(self, memory: Any, measurement: Any) -> tuple[Any, Any]:
        """Update the estimate, then compute the command."""
        estimate, inner, period = memory
        estimate = self.filter(estimate, measurement.attitude, measurement.rate, period)
        filtered = measurement._replace(attitude=estimate.attitude, rate=estimate.rate)
        inner, command = self.controller(inner, filtered)
        return (estimate, inner, period), command


def _safe_tuner() -> SafeFrit:
    """FRIT with dead zone and covariance bound chosen for the noise of the attitude filter."""
    return SafeFrit(
        feedback=jnp.full(2, 0.1),
        reference=FirstOrderLags(jnp.full(2, 0.1)),
        forgetting=0.995,
        smoothing=0.45,
        dead_zone=jnp.full(2, 1e-5),
        initial_gain=jnp.full(2, 0.05),
        lowest=jnp.full(2, 0.02),
        highest=jnp.full(2, 0.2),
        largest_covariance=1e10,
    )


@dataclass(frozen=True)
class Candidate:
    """A controller of the comparison.

    Attributes:
        key: Name in the ids of its claims.
        name: Name in figures.
        make: Builds the controller.
        duration: Duration of a run, s.
        judged: Length of the final window, s, in which the error must stay below the required one.
    """

    key: str
    name: str
    make: Callable[[], Any]
    duration: float = 6000.0
    judged: float = 4000.0


# The rotors of these cases are those of the model.
_KNOWN_ROTORS = TwoWheelPointing(AS_KNOWN, rotor_sigma=None, torque_share=0.98)
OURS = Candidate("pointing", "pointing law with governor", lambda: _KNOWN_ROTORS)
SAFE_FRIT = Candidate(
    "safe_frit",
    "the same with safe on-line FRIT",
    lambda: replace(_KNOWN_ROTORS, tuner=_safe_tuner()),
)
UNCOMPENSATED = Candidate(
    "uncompensated",
    "the same without compensator",
    lambda: replace(_KNOWN_ROTORS, gain=jnp.zeros(2)),
)
SLOW = (
    Candidate("paper", "paper's MEC with FRIT", lambda: Estimated(tuned()), 15_000.0, 5000.0),
    Candidate("fixed_gain", "MEC with K = 0.1", lambda: Estimated(fixed(0.1)), 15_000.0, 5000.0),
    Candidate("no_mec", "without MEC", lambda: Estimated(fixed(0.0)), 15_000.0, 5000.0),
)


class Outcome(NamedTuple):
    """Summary of runs, each array over the runs.

    Attributes:
        settled: Time from which the error stays below 0.05 degrees, s.
        last: Largest error in the final window, degrees; infinite if the run failed.
        demand: Largest torque demand of a wheel, N·m.
        roll: Largest rate about body z, rad/s.
    """

    settled: Vector
    last: Vector
    demand: Vector
    roll: Vector

    @property
    def holds(self) -> np.ndarray:
        """Whether the error stays below the required one."""
        return self.last < REQUIRED


def _fold(summary, time, row, judged_from):
    settled, last, demand, roll = summary
    p = to_body(row.state.attitude, jnp.array([0.0, 0.0, 1.0]))
    error = jnp.rad2deg(jnp.arctan2(jnp.sqrt(p[0] ** 2 + p[1] ** 2), p[2]))
    error = jnp.where(row.status == 0, error, jnp.inf)
    return (
        jnp.where(error < REQUIRED, settled, time + PERIOD),
        jnp.where(time >= judged_from, jnp.maximum(last, error), last),
        jnp.maximum(demand, jnp.max(jnp.abs(row.state.torque_demand))),
        jnp.maximum(roll, jnp.abs(row.record.rate[2])),
    )


def _runner(controller: Any, count: int, judged_from: float, engine: str) -> Runner:
    """Runs of a controller: (plant, start, sensor, key of the noise) of each."""

    def make(plant, start, sensor, key):
        loop = control_loop(plant, controller, sensor, start, key, PERIOD)
        return loop.folded(
            lambda summary, row, k: (_fold(summary, k * PERIOD, row, judged_from), None),
            (jnp.zeros(()),) * 4,
        )

    return Runner(make, (True,) * 4, count, engine=engine)


def evaluate(
    candidate: Candidate,
    cases: Sequence[Case],
    *,
    seed: int = 0,
    block_size: int = BLOCK,
    say: Callable[[str], None] = lambda text: None,
) -> Outcome:
    """Simulate a controller in all cases. The noise of a case is the same for every controller.

    Args:
        candidate: Controller with its duration.
        cases: Dispersed cases, one for each run.
        seed: Seed of the noise.
        block_size: Number of runs that are simulated together.
        say: Called after each block.
    """
    controller, count = candidate.make(), round(candidate.duration / PERIOD)
    judged_from = candidate.duration - candidate.judged
    # not `split`, whose keys may depend on their number
    keys = jax.vmap(jax.random.fold_in, (None, 0))(jax.random.key(seed), jnp.arange(len(cases)))

    runs = list(zip(cases, keys, strict=True))

    def simulate_with(engine: str) -> list[np.ndarray]:
        runner = _runner(controller, count, judged_from, engine)

        def block(block_runs: list[tuple[Case, Any]]) -> np.ndarray:
            plants, starts, sensors = (
                stack([getattr(case, name) for case, _ in block_runs]).items
                for name in ("plant", "start", "sensor")
            )
            keys = jnp.stack([key for _, key in block_runs])
            (((_, summary), _),) = runner.chunks(plants, starts, sensors, keys)
            return np.stack(summary, axis=1)

        name = f"{candidate.name}, runs of {candidate.duration:g} s"
        return list(in_blocks(runs, block_size, block, say=say, name=name, threads=THREADS))

    return Outcome(*np.concatenate(by_engine("auto", simulate_with)).T)
