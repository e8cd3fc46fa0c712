"""Kalman filter of 15 states, as a user writes it: attitude and calibration of the sensors.

The rotation d from estimated to true attitude, q* = q exp(d), the gyro's bias and scale errors, the
misalignment of the star tracker and the offset of the magnetometer. Jacobians by forward
differentiation, gain by `jnp.linalg.solve`, covariance in Joseph form.
"""

from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax, jnp

SAMPLES = 256
"""Measurements, a period of a periodic motion."""
PERIOD = 0.25
ANGLE_WALK, BIAS_WALK, SCALE_WALK = 2e-5, 1e-7, 1e-7
TRACKER_SIGMA, MISALIGNMENT_WALK = 5e-5, 1e-8
FIELD_SIGMA, OFFSET_WALK = 2e-7, 1e-10
GYRO = (
    PERIOD * np.repeat([ANGLE_WALK, BIAS_WALK, SCALE_WALK, MISALIGNMENT_WALK, OFFSET_WALK], 3) ** 2
)
SENSORS = np.repeat([TRACKER_SIGMA, FIELD_SIGMA], 3) ** 2
START = np.repeat([1e-2, 1e-4, 1e-3, 1e-4, 1e-6], 3) ** 2


class Estimate(NamedTuple):
    """Attitude, calibration of the sensors, and covariance of their errors.

    Attributes:
        attitude: Attitude quaternion, (4,).
        bias: Gyro bias, (3,), rad/s.
        scale: Scale errors of the gyro, (3,).
        misalignment: Rotation from star tracker to body, (3,), rad.
        offset: Offset of the magnetometer, (3,), T.
        covariance: Covariance of attitude error, bias, scale, misalignment and offset, (15, 15).
    """

    attitude: Any
    bias: Any
    scale: Any
    misalignment: Any
    offset: Any
    covariance: Any


class Sensors(NamedTuple):
    """Measurements.

    Attributes:
        rate: Gyro, (3,), rad/s.
        attitude: Star tracker, (4,).
        field: Magnetometer, body axes, (3,), T.
        model_field: Field of the model, inertial axes, (3,), T.
    """

    rate: Any
    attitude: Any
    field: Any
    model_field: Any


def multiply(p, q):
    """Product of quaternions."""
    vector = p[0] * q[1:] + q[0] * p[1:] + jnp.cross(p[1:], q[1:])
    return jnp.concatenate([(p[0] * q[0] - p[1:] @ q[1:])[None], vector])


def conjugate(q):
    """Inverse rotation."""
    return q * jnp.array([1.0, -1.0, -1.0, -1.0])


def rotation(vector):
    """Quaternion of a rotation vector."""
    half = 0.5 * jnp.sqrt(vector @ vector + 1e-30)
    return jnp.concatenate([jnp.cos(half)[None], 0.5 * jnp.sin(half) / half * vector])


def small(vector):
    """Quaternion of a small rotation, to first order."""
    return jnp.concatenate([jnp.ones(1), 0.5 * vector])


def moved(estimate, rate, error):
    """Error after a period, to first order in the error before it."""
    turn = PERIOD * (rate * (1.0 - estimate.scale) - estimate.bias)
    change = rate * (estimate.scale + error[6:9]) + estimate.bias + error[3:6]
    true = multiply(small(error[:3]), rotation(PERIOD * (rate - change)))
    angle = 2.0 * multiply(conjugate(rotation(turn)), true)[1:]
    return jnp.concatenate([angle, error[3:]])


def expected(attitude, estimate, sensors, error):
    """Expected innovation of star tracker and magnetometer for an error."""
    true = multiply(attitude, small(error[:3]))
    seen = multiply(true, small(estimate.misalignment + error[9:12]))
    predicted = multiply(attitude, small(estimate.misalignment))
    angle = 2.0 * multiply(conjugate(predicted), seen)[1:]
    pure = jnp.concatenate([jnp.zeros(1), sensors.model_field])
    field = multiply(multiply(conjugate(true), pure), true)[1:]
    return jnp.concatenate([angle, field + estimate.offset + error[12:]])


def filtered(estimate, sensors):
    """Predict over a period and update with both sensors."""
    zero, unit = jnp.zeros(15), jnp.eye(15)
    forward = jax.jacfwd(lambda error: moved(estimate, sensors.rate, error))(zero)
    covariance = forward @ estimate.covariance @ forward.T + jnp.diag(GYRO)
    turn = PERIOD * (sensors.rate * (1.0 - estimate.scale) - estimate.bias)
    attitude = multiply(estimate.attitude, rotation(turn))

    def model(error):
        return expected(attitude, estimate, sensors, error)

    seen = jax.jacfwd(model)(zero)
    predicted = multiply(attitude, small(estimate.misalignment))
    difference = multiply(conjugate(predicted), sensors.attitude)
    angle = 2.0 * jnp.sign(difference[0]) * difference[1:]
    innovation = jnp.concatenate([angle, sensors.field - model(zero)[3:]])
    scatter = seen @ covariance @ seen.T + jnp.diag(SENSORS)
    gain = jnp.linalg.solve(scatter, seen @ covariance).T
    change = gain @ innovation
    rest = unit - gain @ seen
    covariance = rest @ covariance @ rest.T + gain @ jnp.diag(SENSORS) @ gain.T
    attitude = multiply(attitude, rotation(change[:3]))
    return Estimate(
        attitude / jnp.sqrt(attitude @ attitude),
        estimate.bias + change[3:6],
        estimate.scale + change[6:9],
        estimate.misalignment + change[9:12],
        estimate.offset + change[12:],
        0.5 * (covariance + covariance.T),
    )


def sensed():
    """Measurements of a periodic motion, with noise."""
    random, phase = np.random.default_rng(0), 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
    angle = np.stack([0.3 * np.sin(phase), 0.2 * np.sin(2.0 * phase), 0.1 * np.cos(phase)], 1)
    length = np.linalg.norm(angle, axis=1, keepdims=True)
    q = np.concatenate([np.cos(length / 2.0), np.sin(length / 2.0) / length * angle], 1)
    before = np.roll(q, 1, 0)
    scalar = np.sum(before * q, 1, keepdims=True)
    vector = before[:, :1] * q[:, 1:] - q[:, :1] * before[:, 1:]
    vector -= np.cross(before[:, 1:], q[:, 1:])
    rate = 2.0 * np.arctan2(vector, scalar) / PERIOD
    noise = random.standard_normal((4, SAMPLES, 3))
    rate = rate * 1.001 + [1e-4, -2e-4, 1e-4] + ANGLE_WALK / np.sqrt(PERIOD) * noise[0]
    measured = q + TRACKER_SIGMA / 2.0 * np.concatenate([0.0 * noise[1, :, :1], noise[1]], 1)
    model = 3e-5 * np.stack([np.cos(phase), np.sin(phase), 0.5 + 0.0 * phase], 1)
    twice = 2.0 * np.cross(-q[:, 1:], model)
    field = model + q[:, :1] * twice + np.cross(-q[:, 1:], twice)
    field = field + [1e-7, 0.0, -2e-7] + FIELD_SIGMA * noise[2]
    return Sensors(rate, measured, field, model)
