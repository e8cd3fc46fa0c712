"""Recoveries of many dispersed cases, simulated in blocks."""

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
"""Cases that are simulated together."""


class Dispersed(NamedTuple):
    """One case.

    Attributes:
        plant: the spacecraft after the failure.
        controller: for it.
        start: state of the plant.
        target: (4,) attitude to settle at.
        allowed: time to settle, s.
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
    """Histories of some cases over `run` and `time`, with `error`, the angle left, rad.

    Args:
        cases: of one kind.
        sensor: of a plant.
        duration: s, a whole number of periods.
        period: of control, s.
        engine: see `gyrostat.simulation.simulate`.
    """
    plants: Any = stack([case.plant for case in cases])
    controllers: Any = stack([case.controller for case in cases])
    sensors: Any = stack([sensor(case.plant) for case in cases])
    flown = simulate(
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
    errors = jax.jit(jax.vmap(over_time))(jnp.asarray(flown.attitude.values), targets)
    flown["error"] = (("run", "time"), np.asarray(errors), {"units": "rad"})
    return flown


def settling_times(flown: "xr.Dataset", slowest: float = np.inf) -> Vector:
    """(runs,) from when each stays within 0.05 deg to its end, s; infinite where it does not.

    Args:
        flown: with `error` and `rate`.
        slowest: rate below which it has to stay as well, rad/s.
    """
    turns = np.linalg.norm(flown.rate.values, axis=2)
    # comparisons with NaN are false
    out = ~((flown.error.values < ANGLE) & (turns < slowest))
    last = np.where(out.any(axis=1), out.shape[1] - np.argmax(out[:, ::-1], axis=1), 0)
    times = np.append(flown.time.values, np.inf)
    return times[last]
