"""Sample of a run, from which metrics are computed."""

from typing import Any, NamedTuple

from jaxtyping import Array, Bool

from gyrostat.core.arrays import Quaternion, Scalar, Vector3


class Sample(NamedTuple):
    """Sample of a run, from which metrics are computed.

    Attributes:
        time: Time, s.
        error: Pointing error, rad; of the direction `metrics.boresight` if there is one.
        rate_error: Body rate relative to the reference, body axes, (3,), rad/s.
        target: Reference attitude, (4,), scalar first.
        windows: Name of a window -> whether the sample is in it.
        state: State of the plant.
        measurement: Measurement.
        command: Command that acts from this time.
        record: Record of the plant.
    """

    time: Scalar
    error: Scalar
    rate_error: Vector3
    target: Quaternion
    windows: dict[str, Bool[Array, ""]]
    state: Any
    measurement: Any
    command: Any
    record: Any
