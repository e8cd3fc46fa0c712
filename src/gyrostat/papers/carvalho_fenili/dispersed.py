"""Recoveries of dispersed cases, simulated in blocks."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import error_angle
from gyrostat.core.types import Vector
from gyrostat.failures.recovery import ANGLE
from gyrostat.simulation import simulate, stack

if TYPE_CHECKING:
    import xarray as xr

BLOCK = 50
"""Number of cases that are simulated together."""


class Dispersed(NamedTuple):
    """One dispersed case.

    Attributes:
        plant: Spacecraft after the failure.
        controller: Controller.
        start: Initial state of the plant.
        target: Attitude to settle at, (4,).
        allowed: Allowed settling time, s.
    """

    plant: Any
    controller: Any
    start: Any
    target: Float[Array, "4"]
    allowed: float


def fly(
    cases: Sequence[Dispersed],
    sensor: Callable[[Any], Any],
    *,
    duration: float,
    period: float,
    engine: str = "auto",
) -> "xr.Dataset":
    """Histories of cases over `run` and `time`, with `error`, the angle to the target, rad.

    Args:
        cases: Cases of equal types.
        sensor: Builds the sensor for a plant.
        duration: Duration, s, a whole number of control periods.
        period: Control period, s.
        engine: See `gyrostat.simulation.simulate`.
    """
    plants: Any = stack([case.plant for case in cases])
    controllers: Any = stack([case.controller for case in cases])
    sensors: Any = stack([sensor(case.plant) for case in cases])
    histories = simulate(
        plants,
        controllers,
        sensors,
        start=stack([case.start for case in cases]),
        duration=duration,
        control_period=period,
        runs=len(cases),
        engine=engine,
    )
    over_time = jax.vmap(error_angle, in_axes=(0, None))
    targets = jnp.stack([case.target for case in cases])
    errors = jax.jit(jax.vmap(over_time))(jnp.asarray(histories.attitude.values), targets)
    histories["error"] = (("run", "time"), np.asarray(errors), {"units": "rad"})
    return histories


def settling_times(flown: "xr.Dataset", slowest: float = np.inf) -> Vector:
    """Time after which each run stays within 0.05 deg, (runs,), s; infinite if it does not.

    Args:
        flown: Histories with `error` and `rate`.
        slowest: Rate below which the run must stay too, rad/s.
    """
    turns = np.linalg.norm(flown.rate.values, axis=2)
    # comparisons with NaN are false
    out = ~((flown.error.values < ANGLE) & (turns < slowest))
    index = np.where(out.any(axis=1), out.shape[1] - np.argmax(out[:, ::-1], axis=1), 0)
    return np.append(flown.time.values, np.inf)[index]
