"""Sample of a run, from which metrics are computed."""

from typing import Any, NamedTuple

from jaxtyping import Array, Bool

from gyrostat.control.guidance import AttitudeReference, Mode
from gyrostat.core.arrays import Scalar, Vector3


class Sample(NamedTuple):
    """Sample of a run, from which metrics are computed.

    Attributes:
        time: Time, s.
        error: Pointing error, rad; of the direction `metrics.boresight` if there is one.
        rate_error: Body rate relative to the reference, body axes, (3,), rad/s.
        reference: Reference attitude, and its rate and acceleration in axes of the reference.
        mode: Mode of the reference.
        windows: Name of a window -> whether the sample is in it.
        state: State of the plant.
        measurement: Measurement.
        command: Command that acts from this time.
        record: Record of the plant.
    """

    time: Scalar
    error: Scalar
    rate_error: Vector3
    reference: AttitudeReference
    mode: Mode
    windows: dict[str, Bool[Array, ""]]
    state: Any
    measurement: Any
    command: Any
    record: Any
