"""Tracking of wheel friction along telemetry, a health indicator of the bearing."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.pictured import PicturedText
from gyrostat.core.types import Vector
from gyrostat.estimation.friction_scale import FrictionScaleFilter

UNKNOWN = 1e3
"""Initial standard deviation of the speed over that of a measurement."""
FASTEST = 1e4
"""Largest speed accepted, rad/s; no wheel bearing reaches it."""


@dataclass(frozen=True)
class FrictionTrack(PicturedText):
    """Result of the filter after each sample.

    Attributes:
        time: Time, (N,), s.
        speed: Estimated wheel speed, (N,), rad/s.
        scale: Friction of the wheel over friction of the model, (N,).
        scale_sigma: Standard deviation of `scale`, (N,).
        normalised_innovation_squared: Normalised innovation squared, (N,); chi-square with one
            degree of freedom if the filter is consistent. NaN where a measurement is missing, and
            at the first measurement, which initialises the filter.
        missed: Number of samples without a speed.
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
        values = self.normalised_innovation_squared[np.isfinite(self.normalised_innovation_squared)]
        return bool(abs(np.mean(values) - 1.0) < 1.96 * np.sqrt(2.0 / len(values)))


@jax.jit
def _run_filter(estimator: FrictionScaleFilter, initial_speed, current, duration, speed):
    def tick(estimate, sample):
        drive, length, measurement = sample
        corrected = estimator.correct(estimate, measurement)
        return estimator.predict(corrected, drive, length), corrected

    start = estimator.start(initial_speed, UNKNOWN * estimator.speed_sigma)
    return jax.lax.scan(tick, start, (current, duration, speed))[1]


def _series(name: str, values: ArrayLike) -> Vector:
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: found values that are no numbers, expected numbers") from None
    if array.ndim != 1:
        raise InputError(f"{name}: found shape {array.shape}, expected one value for each sample")
    return array


def track_friction(
    estimator: FrictionScaleFilter, time: ArrayLike, current: ArrayLike, speed: ArrayLike
) -> FrictionTrack:
    """Run the filter along a record. Sample intervals may vary; the current is held during each.

    Args:
        estimator: Filter with the identified wheel.
        time: Time, (N,), s, increasing.
        current: Motor current, (N,), A.
        speed: Measured wheel speed, (N,), rad/s; NaN where it is missing.

    Raises:
        InputError: Fewer than two samples or speeds; different lengths; time that does not
            increase; a current or time that is not finite; a speed above `FASTEST`; an interval too
            long for the wheel model; or a filter with parameters that are not single numbers.
    """
    estimator.check()
    shapes = {np.shape(leaf) for leaf in jax.tree.leaves(estimator)} - {()}
    if shapes:
        raise InputError(f"filter: found parameters of shape {shapes.pop()}, expected numbers")
    time, current, speed = (
        _series(name, values)
        for name, values in (("time", time), ("current", current), ("speed", speed))
    )
    if not len(time) == len(current) == len(speed) >= 2:
        raise InputError(
            f"record: found {len(time)}, {len(current)} and {len(speed)} samples of time, current "
            "and speed, expected equally many, 2 or more"
        )
    for name, values, unit in (("time", time, "s"), ("current", current, "A")):
        invalid = np.flatnonzero(~np.isfinite(values))
        if len(invalid):
            raise InputError(
                f"{name} of sample {invalid[0]}: found {values[invalid[0]]}, expected finite {unit}"
            )
    steps = np.diff(time)
    back = np.flatnonzero(steps <= 0.0)
    if len(back):
        raise InputError(
            f"time of sample {back[0] + 1}: found {time[back[0] + 1]:g} s after "
            f"{time[back[0]]:g} s, expected increasing times"
        )
    valid = np.isfinite(speed)
    if valid.sum() < 2:
        raise InputError(f"speed: found {valid.sum()} finite samples, expected 2 or more")
    fast = np.flatnonzero(valid & (np.abs(speed) > FASTEST))
    if len(fast):
        raise InputError(
            f"speed of sample {fast[0]}: found {speed[fast[0]]:g} rad/s, expected at most "
            f"{FASTEST:g} rad/s, or NaN where it is missing"
        )
    first = int(np.argmax(valid))
    estimates = _run_filter(
        jax.tree.map(lambda leaf: jnp.asarray(leaf, float), estimator),
        speed[first],
        current,
        np.append(steps, 0.0),
        speed,
    )
    _check_resolved(np.asarray(estimates.state), np.asarray(estimates.unresolved), time)
    squared = np.asarray(estimates.innovation) ** 2 / np.where(
        valid, estimates.innovation_variance, 1.0
    )
    squared[~valid] = squared[first] = np.nan
    return FrictionTrack(
        time=time,
        speed=np.asarray(estimates.state)[:, 0],
        scale=np.asarray(estimates.state)[:, 1],
        scale_sigma=np.sqrt(np.asarray(estimates.covariance)[:, 1, 1]),
        normalised_innovation_squared=squared,
        missed=int(np.sum(~valid)),
    )


def _check_resolved(state: np.ndarray, unresolved: np.ndarray, time: Vector) -> None:
    indices = np.flatnonzero((unresolved > 0.0) | ~np.all(np.isfinite(state), axis=1))
    if len(indices):
        k = max(int(indices[0]), 1)
        raise InputError(
            f"time of sample {k}: found an interval of {time[k] - time[k - 1]:g} s at "
            f"{time[k - 1]:g} s, too long for the wheel model, expected a shorter one: track the "
            "parts before and after it separately"
        )
