"""Error vectors of a sample, which the loop records for pointing requirements."""

from typing import Any

from gyrostat.core.arrays import Quaternion, Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import error, rotation_vector, to_inertial
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.requirement import PERFORMANCE, ErrorSignal
from gyrostat.spacecraft.imbalance import across


def error_vector(signal: ErrorSignal, sample: Sample) -> Vector3:
    """Error vector of a sample, (3,), rad.

    Args:
        signal: Which error.
        sample: Sample.

    Raises:
        InputError: The sample has no such estimate.
    """
    if signal.kind == PERFORMANCE:
        turn = error(sample.state.attitude, sample.reference.attitude)
    else:
        turn = error(_estimate(signal, sample), sample.state.attitude)
    if signal.boresight is None:
        return rotation_vector(turn)
    return across_and_about(turn, jnp.asarray(signal.boresight))


def across_and_about(turn: Quaternion, axis: Vector3) -> Vector3:
    """Rotation vector that tilts an axis, plus that of the rotation about it before, rad.

    Args:
        turn: Error quaternion, scalar part 0 or more.
        axis: Unit vector.
    """
    about = 2.0 * jnp.arctan2(turn[1:] @ axis, turn[0])
    direction = to_inertial(turn, axis)
    normal = jnp.cross(axis, direction)
    sine = jnp.sqrt(normal @ normal)
    angle = jnp.arctan2(sine, axis @ direction)
    scale = jnp.where(sine > 0.0, angle / jnp.where(sine > 0.0, sine, 1.0), 1.0)
    # opposite to the target, any axis across the boresight will do
    opposite = (sine == 0.0) & (axis @ direction < 0.0)
    tilt = jnp.where(opposite, jnp.pi * across(axis[:, None])[0][:, 0], scale * normal)
    return tilt + about * axis


def _estimate(signal: ErrorSignal, sample: Sample) -> Quaternion:
    """Known attitude."""
    fields: dict[str, Any] = {}
    for part in (sample.record, sample.measurement, sample.command):
        fields |= part._asdict()
    default = "estimated_attitude" if "estimated_attitude" in fields else "attitude"
    name = signal.estimate or default
    estimate = fields.get(name)
    if estimate is None or jnp.shape(estimate) != (4,):
        raise InputError(
            f"key requirement.estimate: found {name!r}, expected a quaternion of the command, of "
            f"the measurement or of the record: "
            f"{', '.join(each for each, value in fields.items() if jnp.shape(value) == (4,))}"
        )
    return estimate
