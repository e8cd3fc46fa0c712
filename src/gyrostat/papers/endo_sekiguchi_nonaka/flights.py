"""Simulations of the paper's spacecraft, from its own start and from others."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import equinox as eqx
import numpy as np
from jaxtyping import PRNGKeyArray

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.papers.endo_sekiguchi_nonaka import setup
from gyrostat.simulation import blocks, simulate, stack
from gyrostat.spacecraft import GyrostatState, SpacecraftMeasurement, SpeedDrivenSpacecraft

if TYPE_CHECKING:
    import xarray as xr

BLOCK = 8
"""Runs of 100 001 samples that are in memory together."""
JUDGED = 7000.0
"""s: errors are judged from here to the end."""


@dataclass(frozen=True)
class Case:
    """What a run starts from.

    Attributes:
        total: (3, 3) J_t of the plant, kg·m².
        momentum: size of each component of H_0, N·m·s.
        shift: added to the phases of H_0, rad.
        axis: of the initial rotation.
        torque_limit: of each wheel, N·m.
    """

    total: Any = field(default_factory=lambda: setup.ACTUAL)
    momentum: float = setup.MOMENTUM
    shift: float = 0.0
    axis: tuple[float, ...] = setup.AXIS
    torque_limit: float = np.inf

    def plant(self) -> SpeedDrivenSpacecraft:
        """The spacecraft with its momentum."""
        body = setup.spacecraft(np.asarray(self.total), self.torque_limit)
        return SpeedDrivenSpacecraft(body, setup.momentum(self.momentum, self.shift))


@dataclass(frozen=True)
class Flight:
    """One run.

    Attributes:
        time: (N,) s.
        output: (N, 2) q1 and q2.
        speed: (N, 2) commanded wheel speeds, rad/s.
        virtual: (N, 2) virtual input mu, 1/s.
        gain: (N, 2, 2) of the compensator, 1/s.
        error: (N,) of pointing, degrees.
        valid_until: until when it did not diverge, s; values after that are NaN.
    """

    time: np.ndarray
    output: np.ndarray
    speed: np.ndarray
    virtual: np.ndarray
    gain: np.ndarray
    error: np.ndarray
    valid_until: float

    def error_at(self, time: float) -> float:
        """Pointing error at a time, s; degrees."""
        return float(self.error[round(time / setup.PERIOD)])

    @property
    def judged(self) -> np.ndarray:
        """Pointing errors from 7000 s to the end, degrees."""
        return self.error[round(JUDGED / setup.PERIOD) :]

    @property
    def top_speed(self) -> float:
        """Largest commanded wheel speed, rad/s."""
        return float(np.nanmax(np.abs(self.speed)))

    @property
    def settled(self) -> float | None:
        """From when on the error is below 0.05 degrees for good, s; None where never."""
        above = np.flatnonzero(~(self.error < setup.REQUIRED))
        last = above[-1] + 1 if len(above) else 0
        return None if last == len(self.error) else float(self.time[last])

    @property
    def outcome(self) -> str:
        """Sentence on when the run settles, and its error at the end."""
        end = f"{self.error_at(setup.DURATION):.3g} degrees at {setup.DURATION:g} s"
        if self.settled is None:
            return f"Never below {setup.REQUIRED:g} degrees for good; {end}."
        return f"Below {setup.REQUIRED:g} degrees for good from {self.settled:.1f} s on; {end}."

    def distance(self, ideal: "Flight") -> float:
        """Root mean square over the run of the outputs' distance from those of another."""
        return float(np.sqrt(np.mean(np.sum((self.output - ideal.output) ** 2, axis=1))))


class Ideal(eqx.Module):
    """Measures attitude, body rate and wheel speeds without error.

    Attributes:
        plant: that is measured.
    """

    plant: SpeedDrivenSpacecraft

    def start(self, state: GyrostatState, period: Scalar) -> None:
        """No memory."""

    def __call__(
        self, memory: None, state: GyrostatState, key: PRNGKeyArray
    ) -> tuple[None, SpacecraftMeasurement]:
        """Measure; the key is unused."""
        wheels = self.plant.spacecraft.wheels
        return None, SpacecraftMeasurement(
            attitude=state.attitude,
            rate=self.plant.rate(state),
            wheel_speed=state.wheel_speed,
            wheel_measured=jnp.ones(wheels.count, dtype=bool),
        )


def flown(
    cases: Sequence[Case], controllers: Sequence[Any], duration: float = setup.DURATION
) -> Iterator[Flight]:
    """Simulate cases, each with its controller, all of one kind; one block at a time is in memory.

    Args:
        cases: one for each run.
        controllers: one for each run.
        duration: s.
    """
    pairs = list(zip(cases, controllers, strict=True))
    # the last block is filled up with its last run, so that one size is compiled
    for rows, kept in blocks(len(pairs), min(BLOCK, len(pairs))):
        runs = _simulated([pairs[row] for row in rows], duration)
        yield from (_flight(runs.isel(run=k)) for k in range(kept))


def _simulated(pairs: Sequence[tuple[Case, Any]], duration: float) -> "xr.Dataset":
    plants = [case.plant() for case, _ in pairs]
    starts = [
        plant.start(attitude=setup.attitude(case.axis))
        for plant, (case, _) in zip(plants, pairs, strict=True)
    ]
    plant: Any = stack(plants)
    controller: Any = stack([controller for _, controller in pairs])
    sensor: Any = stack([Ideal(one) for one in plants])
    return simulate(
        plant,
        controller,
        sensor,
        start=stack(starts),
        duration=duration,
        control_period=setup.PERIOD,
        runs=len(pairs),
        engine="auto",
    )


def _flight(run: Any) -> Flight:
    def own(name: str) -> np.ndarray:
        # a view would keep the whole block
        return np.array(run[name].values)

    output = np.array(run.attitude.values[:, 1:3])
    # beyond the sphere by rounding only
    half = np.minimum(np.hypot(output[:, 0], output[:, 1]), 1.0)
    return Flight(
        time=run.time.values,
        output=output,
        speed=own("speed"),
        virtual=own("virtual_input"),
        gain=own("gain"),
        error=np.rad2deg(2.0 * np.arcsin(half)),
        valid_until=float(run.valid_until),
    )
