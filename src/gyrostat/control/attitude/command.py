"""Current command of a wheel."""

from typing import Annotated, NamedTuple

from gyrostat.core.arrays import Scalar


class CurrentCommand(NamedTuple):
    """A motor current and the two parts that it is the sum of, before its limit.

    In the histories of a run with a command delay the current stands at the time from which it
    acts, its parts at the sample that they were made at.

    Attributes:
        current: of the motor, A.
        attitude_current: for the torque that the attitude law demands, A.
        friction_current: for the friction that is expected, A.
    """

    current: Annotated[Scalar, "A"]
    attitude_current: Annotated[Scalar, "A"]
    friction_current: Annotated[Scalar, "A"]
