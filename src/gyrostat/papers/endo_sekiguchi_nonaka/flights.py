"""The runs: the paper's three, fixed gains, and the same with other starts."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import equinox as eqx
import numpy as np
from jaxtyping import PRNGKeyArray

from gyrostat._jax import jnp
from gyrostat.body import (
    GyrostatState,
    SpacecraftMeasurement,
    SpeedDrivenSpacecraft,
)
from gyrostat.friction import Scalar
from gyrostat.papers.endo_sekiguchi_nonaka.printed import (
    ACTUAL,
    AXIS,
    DURATION,
    MOMENTUM,
    PERIOD,
    REQUIRED,
    attitude,
    momentum,
    spacecraft,
)
from gyrostat.simulate import simulate, stack

LANES = 8
"""Runs of 100 001 samples that are held in memory together."""
JUDGED = 7000.0
"""s: errors are judged from here to the end."""


@dataclass(frozen=True)
class Case:
    """What a run starts from.

    Attributes:
        name: in words.
        total: (3, 3) J_t of the plant, kg·m².
        momentum: size of each component of H_0, N·m·s.
        shift: added to the phases of H_0, rad.
        axis: of the initial rotation.
        torque_limit: of each wheel, N·m.
    """

    name: str
    total: Any = field(default_factory=lambda: ACTUAL)
    momentum: float = MOMENTUM
    shift: float = 0.0
    axis: tuple[float, ...] = AXIS
    torque_limit: float = np.inf

    def plant(self) -> SpeedDrivenSpacecraft:
        """What flies."""
        body = spacecraft(np.asarray(self.total), self.torque_limit)
        return SpeedDrivenSpacecraft(body, momentum(self.momentum, self.shift))


@dataclass(frozen=True)
class Flight:
    """One run.

    Attributes:
        time: (N,) s.
        output: (N, 2) q1 and q2.
        speed: (N, 2) commanded wheel speeds, rad/s.
        virtual: (N, 2) virtual input mu, 1/s.
        model_error: (N, 2) h_n - h.
        gain: (N, 2, 2) of the compensator, 1/s.
        error: (N,) of pointing, degrees.
        valid_until: until when it did not diverge, s; values after that are NaN.
    """

    time: np.ndarray
    output: np.ndarray
    speed: np.ndarray
    virtual: np.ndarray
    model_error: np.ndarray
    gain: np.ndarray
    error: np.ndarray
    valid_until: float

    def error_at(self, time: float) -> float:
        """Pointing error at a time, s; degrees."""
        return float(self.error[round(time / PERIOD)])

    @property
    def judged(self) -> np.ndarray:
        """Pointing errors from 7000 s to the end, degrees."""
        return self.error[round(JUDGED / PERIOD) :]

    @property
    def top_speed(self) -> float:
        """Largest commanded wheel speed, rad/s."""
        return float(np.nanmax(np.abs(self.speed)))

    @property
    def settled(self) -> float | None:
        """From when on the error is below 0.05 degrees for good, s; None where never."""
        above = np.flatnonzero(~(self.error < REQUIRED))
        last = above[-1] + 1 if len(above) else 0
        return None if last == len(self.error) else float(self.time[last])


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
        """Measure; the key is of no account."""
        wheels = self.plant.spacecraft.wheels
        return None, SpacecraftMeasurement(
            attitude=state.attitude,
            rate=self.plant.rate(state),
            wheel_speed=state.wheel_speed,
            wheel_measured=jnp.ones(wheels.count, dtype=bool),
        )


def flown(
    cases: Sequence[Case], controllers: Sequence[Any], duration: float = DURATION
) -> Iterator[Flight]:
    """Fly cases, each with its controller, all of one kind; a few at a time are in memory.

    Args:
        cases: one for each run.
        controllers: one for each run.
        duration: s.
    """
    lanes = min(LANES, len(cases))
    for first in range(0, len(cases), lanes):
        # the last block is filled up with its last run, so that one size is compiled
        rows = [min(first + k, len(cases) - 1) for k in range(lanes)]
        picked = [cases[row] for row in rows]
        plants = [case.plant() for case in picked]
        starts = [
            plant.start(attitude=attitude(case.axis))
            for plant, case in zip(plants, picked, strict=True)
        ]
        plant: Any = stack(plants)
        controller: Any = stack([controllers[row] for row in rows])
        sensor: Any = stack([Ideal(one) for one in plants])
        runs = simulate(
            plant,
            controller,
            sensor,
            start=stack(starts),
            duration=duration,
            control_period=PERIOD,
            runs=lanes,
            engine="auto",
        )
        for lane in range(min(lanes, len(cases) - first)):
            yield _flight(runs.isel(run=lane))


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
        model_error=own("model_error"),
        gain=own("gain"),
        error=np.rad2deg(2.0 * np.arcsin(half)),
        valid_until=float(run.valid_until),
    )
