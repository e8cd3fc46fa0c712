"""What a controller of a wheel's current commands."""

from typing import NamedTuple

from jaxtyping import Array, Float


class CurrentCommand(NamedTuple):
    """A motor current and the two parts that it is the sum of, before its limit.

    Attributes:
        current: of the motor, A.
        attitude_current: for the torque that the attitude law demands, A.
        friction_current: for the friction that is expected, A.
    """

    current: Float[Array, ""]
    attitude_current: Float[Array, ""]
    friction_current: Float[Array, ""]

    UNITS = {"current": "A", "attitude_current": "A", "friction_current": "A"}  # noqa: RUF012
