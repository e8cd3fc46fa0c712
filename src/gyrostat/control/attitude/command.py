"""Current command of a wheel."""

from typing import Annotated, NamedTuple

from gyrostat.core.arrays import Scalar


class CurrentCommand(NamedTuple):
    """Motor current command, and its two terms before the limit.

    In the histories of a run with a command delay, the current is recorded at the time from which
    it acts, and its two terms at the sample at which they were computed.

    Attributes:
        current: Motor current after the limit, A.
        attitude_current: Current for the torque that the attitude law demands, A.
        friction_current: Current for the expected friction, A.
    """

    current: Annotated[Scalar, "A"]
    attitude_current: Annotated[Scalar, "A"]
    friction_current: Annotated[Scalar, "A"]
