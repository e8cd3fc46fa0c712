"""State, command and record of a spacecraft with wheels."""

from typing import Annotated, NamedTuple

from jaxtyping import Array, Bool

from gyrostat.core.arrays import PerWheel, Quaternion, Vector3

FASTEST = 10.0
"""rad/s: beyond this body rate no controller means what it does."""


class GyrostatState(NamedTuple):
    """State of a spacecraft with wheels.

    Attributes:
        attitude: (4,) quaternion of the body in inertial space, scalar first.
        momentum: (3,) of everything, in inertial axes, N·m·s.
        wheel_speed: (wheels,) relative to the body, rad/s; exactly zero is at rest.
        wheel_angle: (wheels,) of the rotors relative to the body, rad; None where no part of the
            plant needs it (`ImbalancedGyrostat` does).
        motor_current: (wheels,) A; None where the motors give their torque at once, without a
            `DrivenGyrostat`.
    """

    attitude: Annotated[Quaternion, "1"]
    momentum: Annotated[Vector3, "N·m·s"]
    wheel_speed: Annotated[PerWheel, "rad/s"]
    wheel_angle: Annotated[PerWheel | None, "rad"] = None
    motor_current: Annotated[PerWheel | None, "A"] = None


class WheelTorqueCommand(NamedTuple):
    """Motor torque of each wheel.

    Attributes:
        torque: (wheels,) N·m; positive speeds the wheel up and pushes the body back.
    """

    torque: Annotated[PerWheel, "N·m"]


class GyrostatRecord(NamedTuple):
    """What is worth recording.

    Attributes:
        rate: (3,) of the body without jitter, in body axes, rad/s.
        wheel_momentum: (wheels,) rotor inertia times speed relative to the body, N·m·s.
        saturated: (wheels,) whether a limit cuts the command.
        jitter: (3,) rotation vector from the attitude with balanced wheels to the attitude, rad;
            None for balanced wheels.
    """

    rate: Annotated[Vector3, "rad/s"]
    wheel_momentum: Annotated[PerWheel, "N·m·s"]
    saturated: Bool[Array, " wheels"]
    jitter: Annotated[Vector3 | None, "rad"] = None


class RateRecord(NamedTuple):
    """What is worth recording of a plant without wheel limits.

    Attributes:
        rate: (3,) of the body, in body axes, rad/s.
    """

    rate: Annotated[Vector3, "rad/s"]


def too_fast(rate: Vector3) -> Bool[Array, ""]:
    """Whether a body rate, rad/s, is beyond `FASTEST`, or no number."""
    return ~(rate @ rate < FASTEST**2)
