"""Simulations of the paper's spacecraft from its own start and from others."""

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
"""Number of runs of 100 001 samples that are in memory together."""
JUDGED = 7000.0
"""Start of the interval in which errors are evaluated, s."""


@dataclass(frozen=True)
class Case:
    """Initial conditions and plant of a run.

    Attributes:
        total: Inertia J_t of the plant with locked wheels, (3, 3), kg·m².
        momentum: Amplitude of each component of H_0, N·m·s.
        shift: Angle added to the phases of H_0, rad.
        axis: Axis of the initial rotation.
        torque_limit: Torque limit of each wheel, N·m.
    """

    total: Any = field(default_factory=lambda: setup.ACTUAL)
    momentum: float = setup.MOMENTUM
    shift: float = 0.0
    axis: tuple[float, ...] = setup.AXIS
    torque_limit: float = np.inf

    def plant(self) -> SpeedDrivenSpacecraft:
        """Spacecraft with its momentum."""
        body = setup.spacecraft(np.asarray(self.total), self.torque_limit)
        return SpeedDrivenSpacecraft(body, setup.momentum(self.momentum, self.shift))


@dataclass(frozen=True)
class Flight:
    """One run.

    Attributes:
        time: Time, (N,), s.
        output: Outputs q1 and q2, (N, 2).
        speed: Commanded wheel speeds, (N, 2), rad/s.
        virtual: Virtual input mu, (N, 2), 1/s.
        gain: Gain of the compensator, (N, 2, 2), 1/s.
        error: Pointing error, (N,), degrees.
        valid_until: Time until which the run did not diverge, s; later values are NaN.
    """

    time: np.ndarray
    output: np.ndarray
    speed: np.ndarray
    virtual: np.ndarray
    gain: np.ndarray
    error: np.ndarray
    valid_until: float

    def error_at(self, time: float) -> float:
        """Pointing error, degrees, at a time, s."""
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
        """Time from which the error stays below 0.05 degrees, s; None if it does not."""
        above = np.flatnonzero(~(self.error < setup.REQUIRED))
        last = above[-1] + 1 if len(above) else 0
        return None if last == len(self.error) else float(self.time[last])

    @property
    def outcome(self) -> str:
        """Sentence on the settling time and the final error."""
        end = f"{self.error_at(setup.DURATION):.3g} degrees at {setup.DURATION:g} s"
        if self.settled is None:
            return f"Never below {setup.REQUIRED:g} degrees permanently; {end}."
        return f"Below {setup.REQUIRED:g} degrees permanently from {self.settled:.1f} s on; {end}."

    def distance(self, ideal: "Flight") -> float:
        """Root mean square distance of the outputs from those of another run."""
        return float(np.sqrt(np.mean(np.sum((self.output - ideal.output) ** 2, axis=1))))


class Ideal(eqx.Module):
    """Error-free sensor of attitude, body rate and wheel speeds.

    Attributes:
        plant: Plant that is measured.
    """

    plant: SpeedDrivenSpacecraft

    def start(self, state: GyrostatState, period: Scalar) -> None:
        """The sensor has no memory."""

    def __call__(
        self, memory: None, state: GyrostatState, key: PRNGKeyArray
    ) -> tuple[None, SpacecraftMeasurement]:
        """Measure the state; the key is unused."""
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
    """Simulate cases, each with its controller of a common type; one block at a time is in memory.

    Args:
        cases: Cases, one for each run.
        controllers: Controllers, one for each run.
        duration: Duration, s.
    """
    pairs = list(zip(cases, controllers, strict=True))
    # the last block is filled up with its last run, so that one size is compiled
    for rows, count in blocks(len(pairs), min(BLOCK, len(pairs))):
        runs = _simulate([pairs[row] for row in rows], duration)
        yield from (_flight(runs.isel(run=k)) for k in range(count))


def _simulate(pairs: Sequence[tuple[Case, Any]], duration: float) -> "xr.Dataset":
    plants = [case.plant() for case, _ in pairs]
    starts = [
        plant.start(attitude=setup.attitude(case.axis))
        for plant, (case, _) in zip(plants, pairs, strict=True)
    ]
    plant: Any = stack(plants)
    controller: Any = stack([controller for _, controller in pairs])
    sensor: Any = stack([Ideal(body) for body in plants])
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
    def copy_of(name: str) -> np.ndarray:
        # a view would keep the whole block
        return np.array(run[name].values)

    output = np.array(run.attitude.values[:, 1:3])
    # the argument exceeds 1 by rounding errors only
    half = np.minimum(np.hypot(output[:, 0], output[:, 1]), 1.0)
    return Flight(
        time=run.time.values,
        output=output,
        speed=copy_of("speed"),
        virtual=copy_of("virtual_input"),
        gain=copy_of("gain"),
        error=np.rad2deg(2.0 * np.arcsin(half)),
        valid_until=float(run.valid_until),
    )
