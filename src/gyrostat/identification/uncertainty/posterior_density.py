"""Posterior density of the parameters of a wheel, without linearisation.

The likelihood is that of the prediction errors: the residual of the exact prediction, whitened by
the Kalman filter of `innovations` with the gains of the fit, and with the coefficients of lag and
drift integrated out. In white noise without further effects it is the Gaussian likelihood of the
residual. The prior is that of the fit, limited to wheels that can exist: friction parameters, and
differences such as that of static and Coulomb torque, of 0 or more.

Sampling takes place in unlimited coordinates, whitened by the covariance of the fit.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.least_squares import Prior
from gyrostat.identification.fit.prediction import (
    CurrentHold,
    SpeedPrediction,
    build_wheel,
    wheel_dimensions,
)
from gyrostat.identification.uncertainty.speed_error import corrected, first_covariance, predicted
from gyrostat.identification.uncertainty.torque_noise import TorqueNoise
from gyrostat.wheel.friction import Friction
from gyrostat.wheel.response import advance, sample_intervals, slope_within

FAR = 8.0
"""Distance from its limit, in standard deviations, from which a parameter has no limit."""


class RecordData(NamedTuple):
    """One record as arrays, padded to a rounded length P.

    Attributes:
        inputs: Time, current and whether a segment starts, each (P,).
        place: Index of the initial speed of each sample's segment, (P,).
        at: Map of the parameters to those at the temperature of the record, (n, n).
        averaged: Weight of the sample before each one in its mean, (P,): 0 or 1/2.
        speed: Measured speed, (P,), rad/s; 0 where missing.
        variance: Variance of the measured speed, (P,); infinite where missing.
        noise: Rows of `TorqueNoise.intervals`, (P, 8), the variances of the first random torques,
            (2,), and the squared levels of the fit, (2,).
        columns: Derivatives of the speed with respect to m coefficients in units of their prior
            sigma, (P, m).
    """

    inputs: tuple
    place: Vector
    at: Matrix
    averaged: Vector
    speed: Vector
    variance: Vector
    noise: tuple
    columns: Matrix


class Coordinates(NamedTuple):
    """Map of whitened coordinates u to the n estimated parameters.

    The limited quantities are g = D x; those near their limit are g = s log(1 + exp(z)), the others
    g = s z, with z = z0 + L u.

    Attributes:
        mix: D inverse, (n, n).
        scale: s, (n,).
        limited: Whether each quantity is near its limit, (n,).
        centre: z0, (n,).
        root: L, (n, n).
    """

    mix: Matrix
    scale: Vector
    limited: Any
    centre: Vector
    root: Matrix

    def values(self, u):
        """Parameters, (n,), and the logarithm of the Jacobian determinant up to a constant."""
        z = self.centre + self.root @ u
        quantity = self.scale * jnp.where(self.limited, jax.nn.softplus(z), z)
        return self.mix @ quantity, jnp.sum(jnp.where(self.limited, jax.nn.log_sigmoid(z), 0.0))


class Posed(NamedTuple):
    """Everything that the density needs.

    Attributes:
        records: Data of each record.
        coordinates: Map to the estimated parameters.
        start: All parameters of the prediction, (p,), SI; held ones keep their value.
        free: Indices of the n estimated parameters among them.
        rows: Whitened rows of the a-priori knowledge, (k, n).
        mean: Mean of the a-priori knowledge, (n,).
    """

    records: tuple[RecordData, ...]
    coordinates: Coordinates
    start: Vector
    free: Any
    rows: Matrix
    mean: Vector


def coordinates(
    model: type[Friction], names: Sequence[str], values: Vector, covariance: Matrix
) -> Coordinates:
    """Whitened coordinates around an estimate.

    Args:
        model: Friction model.
        names: Names of the n estimated parameters.
        values: Estimates, (n,), SI.
        covariance: Their covariance, (n, n), SI.
    """
    difference = np.eye(len(names))
    for name, reference in model.vanishing_at.items():
        if name in names and reference in names:
            difference[names.index(name), names.index(reference)] = -1.0
    centre, spread = difference @ values, difference @ covariance @ difference.T
    scale = np.sqrt(np.diag(spread))
    limits = {"inertia", *model.dimensions()} - set(model.signed())
    positive = np.array([n in limits for n in names])
    limited = positive & (centre < FAR * scale)
    # the start lies inside the limits: at one sigma where the estimate lies outside
    z = np.where(limited, np.maximum(centre / scale, 0.5), centre / scale)
    z = np.where(limited, np.log(np.expm1(np.where(limited, z, 1.0))), z)
    correlation = spread / np.outer(scale, scale)
    root: Any = np.linalg.cholesky(correlation + 1e-12 * np.eye(len(names)))
    mix: Any = np.linalg.inv(difference)
    return Coordinates(mix, scale, limited, z, root)


def record_data(
    prediction: SpeedPrediction,
    number: int,
    sigma: float,
    noise: TorqueNoise | None = None,
    levels: Sequence[float] = (0.0, 0.0),
    transition: Vector | None = None,
    columns: Matrix | None = None,
) -> RecordData:
    """Arrays of one record of a prediction.

    Args:
        prediction: Records and friction model.
        number: Index of the record.
        sigma: Standard deviation of the measured speed, rad/s.
        noise: Random torque at level one; None without.
        levels: Levels of ripple and wandering torque.
        transition: Transition of each interval at the fit, (N - 1,), with `noise`.
        columns: Derivatives by the coefficients of further effects in units of their prior sigma,
            (N, m); None without.
    """
    record, inputs = prediction.records[number], prediction.inputs[number]
    size, count = len(inputs[0]), len(record.time)
    index = np.zeros(size, dtype=int)
    weight = np.zeros(size)
    for column, part in zip(prediction.columns[number], record.segments, strict=True):
        index[part] = column
        weight[part.start + 1 : part.stop] = 0.5 if record.averaged else 0.0

    def pad(values: Vector, value: float = 0.0) -> Vector:
        fill = [(0, size - len(values)), *[(0, 0)] * (values.ndim - 1)]
        return np.pad(values, fill, constant_values=value)

    intervals, first = np.zeros((count - 1, 8)), np.zeros(2)
    if noise is not None and transition is not None:
        intervals, first = noise.intervals(transition), np.array([noise.first, noise.ripple])
    return RecordData(
        inputs=inputs,
        place=index,
        at=prediction.at_temperature[number],
        averaged=weight,
        speed=pad(np.where(record.valid, np.nan_to_num(record.speed), 0.0)),
        variance=pad(np.where(record.valid, sigma**2, np.inf), np.inf),
        noise=(pad(intervals), first, np.square(levels)),
        columns=pad(np.zeros((count, 0)) if columns is None else columns),
    )


@lru_cache
def density(model: type[Friction], hold: CurrentHold, shared: int):
    """Logarithm of the density, a function (u, `Posed`) -> number; minus infinity if unresolved.

    Args:
        model: Friction model.
        hold: Interpolation of the current between samples.
        shared: Number of parameters that all records share.
    """
    names = tuple(wheel_dimensions(model))

    def products(values, data: RecordData):
        """Sums of products of the whitened residual and columns, and whether all is resolved."""
        parameters = data.at @ values
        wheel = build_wheel(model, dict(zip(names, parameters[: shared - 1], strict=True)))
        bias, first = parameters[shared - 1], parameters[data.place]
        time, current, restart = data.inputs
        duration, slope = sample_intervals(time, current, hold)
        # the motion in a gap is unknown
        duration = jnp.append(jnp.where(restart[1:], 0.0, duration), 0.0)
        slope = jnp.append(slope, 0.0)
        intervals, random, squared = (jnp.asarray(part) for part in data.noise)

        def sample(carry, entry):
            (speed, before, resolved), (state, spread), total = carry
            start, change, length, anew, initial, weight, reading, variance, columns, noise = entry
            speed = jnp.where(anew, initial, speed)
            mean = (1.0 - weight) * speed + weight * before
            # a missing sample has no residual, and the padding none either
            valid = jnp.isfinite(variance)
            error = jnp.where(valid, jnp.append(reading - mean, columns), 0.0) - state[0]
            share = jnp.where(valid, 1.0 / (spread[0] + variance), 0.0)
            total = total + share * error[:, None] * error
            gains, spread = corrected(spread, share)
            x, u, b = (each + k * error for each, k in zip(state, gains, strict=True))
            step = advance(wheel, speed, start + bias, slope_within(change, hold), length)
            motion = step.speed, speed, resolved & step.resolved
            return (motion, predicted((x, u, b), spread, noise, squared), total), None

        zeros = jnp.zeros(1 + data.columns.shape[1])
        entries = (
            *(current, slope, duration, jnp.asarray(restart).at[0].set(True), first),
            *(data.averaged, data.speed, data.variance, data.columns, intervals),
        )
        begin = (
            (first[0], first[0], jnp.array(True)),
            ((zeros,) * 3, first_covariance(random, squared)),
            jnp.outer(zeros, zeros),
        )
        ((_, _, resolved), _, total), _ = jax.lax.scan(sample, begin, entries)
        return total, resolved

    def log_density(u, problem: Posed):
        x, determinant = problem.coordinates.values(u)
        values = jnp.asarray(problem.start).at[problem.free].set(x)
        parts = [products(values, data) for data in problem.records]
        total = jnp.sum(jnp.stack([part for part, _ in parts]), axis=0)
        effects = jnp.eye(total.shape[0] - 1) + total[1:, 1:]
        misfit = total[0, 0] - total[0, 1:] @ jnp.linalg.solve(effects, total[1:, 0])
        apart = problem.rows @ (x - problem.mean)
        log = determinant - 0.5 * misfit - 0.5 * apart @ apart
        sound = jnp.all(jnp.array([resolved for _, resolved in parts])) & jnp.isfinite(log)
        return jnp.where(sound, log, -jnp.inf)

    return log_density


def posed(
    prediction: SpeedPrediction,
    names: Sequence[str],
    values: Mapping[str, float],
    covariance: Matrix,
    prior: Prior,
    records: Sequence[RecordData],
) -> Posed:
    """Collect what the density needs.

    Args:
        prediction: Records and friction model.
        names: Names of the n estimated parameters.
        values: Name -> value of all parameters of the prediction, SI.
        covariance: Covariance of the estimates, (n, n), SI.
        prior: A-priori knowledge of the estimated parameters.
        records: Data of each record.
    """
    estimates = np.array([values[n] for n in names])
    return Posed(
        records=tuple(records),
        coordinates=coordinates(prediction.model, names, estimates, covariance),
        start=np.array([values[n] for n in prediction.names]),
        free=np.array([prediction.names.index(n) for n in names]),
        rows=prior.rows(),
        mean=prior.mean,
    )
