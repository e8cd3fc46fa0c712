"""Friction of a wheel along its telemetry: the health signal of its bearing."""

from dataclasses import dataclass

import numpy as np

from gyrostat._jax import jax, jnp
from gyrostat._types import Vector
from gyrostat.errors import InputError
from gyrostat.estimate.friction_scale import FrictionScaleFilter


@dataclass(frozen=True)
class FrictionTrack:
    """What the filter knew after each sample.

    Attributes:
        time: (N,) s.
        speed: (N,) estimated, rad/s.
        scale: (N,) friction of the wheel over friction of the model.
        scale_sigma: (N,) its standard deviation.
        normalised_innovation_squared: (N,) chi-square with one degree of freedom where the filter
            is consistent; NaN where there was no measurement.
        missed: samples without a speed.
    """

    time: Vector
    speed: Vector
    scale: Vector
    scale_sigma: Vector
    normalised_innovation_squared: Vector
    missed: int

    @property
    def consistent(self) -> bool:
        """Whether the mean normalised innovation squared is within its 95 % band."""
        seen = self.normalised_innovation_squared[np.isfinite(self.normalised_innovation_squared)]
        return bool(abs(np.mean(seen) - 1.0) < 1.96 * np.sqrt(2.0 / len(seen)))


@jax.jit
def _tracked(estimator: FrictionScaleFilter, first, current, duration, speed):
    def tick(estimate, now):
        drive, length, measured = now
        corrected = estimator.correct(estimate, measured)
        return estimator.predict(corrected, drive, length), corrected

    return jax.lax.scan(tick, estimator.start(first), (current, duration, speed))[1]


def track_friction(
    estimator: FrictionScaleFilter, time: Vector, current: Vector, speed: Vector
) -> FrictionTrack:
    """Run the filter along a record; intervals may be uneven, the current is held through each.

    Args:
        estimator: filter with the identified wheel.
        time: (N,) s, increasing.
        current: (N,) A.
        speed: (N,) measured, rad/s; NaN where it is missing.

    Raises:
        InputError: fewer than two samples or speeds, lengths that differ, time that does not
            increase, or a current or time that is not finite.
    """
    estimator.check()
    if not len(time) == len(current) == len(speed) >= 2:
        raise InputError(
            f"record: found {len(time)}, {len(current)} and {len(speed)} samples of time, current "
            "and speed, expected equally many, 2 or more"
        )
    for name, values, unit in (("time", time, "s"), ("current", current, "A")):
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise InputError(
                f"{name} of sample {bad[0]}: found {values[bad[0]]}, expected finite {unit}"
            )
    steps = np.diff(time)
    back = np.flatnonzero(steps <= 0.0)
    if len(back):
        raise InputError(
            f"time of sample {back[0] + 1}: found {time[back[0] + 1]:g} s after "
            f"{time[back[0]]:g} s, expected increasing times"
        )
    seen = np.isfinite(speed)
    if seen.sum() < 2:
        raise InputError(f"speed: found {seen.sum()} finite samples, expected 2 or more")
    found = _tracked(
        jax.tree.map(jnp.asarray, estimator),
        jnp.asarray(speed[np.argmax(seen)]),
        jnp.asarray(current),
        jnp.asarray(np.append(steps, 0.0)),
        jnp.asarray(speed),
    )
    squared = np.asarray(found.innovation) ** 2 / np.where(seen, found.innovation_variance, 1.0)
    return FrictionTrack(
        time=np.asarray(time),
        speed=np.asarray(found.state)[:, 0],
        scale=np.asarray(found.state)[:, 1],
        scale_sigma=np.sqrt(np.asarray(found.covariance)[:, 1, 1]),
        normalised_innovation_squared=np.where(seen, squared, np.nan),
        missed=int(np.sum(~seen)),
    )
