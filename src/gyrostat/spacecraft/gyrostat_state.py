"""State, command and record of a spacecraft with wheels."""

from typing import Annotated, NamedTuple

from jaxtyping import Array, Bool

from gyrostat.core.arrays import PerWheel, Quaternion, Vector3

FASTEST = 10.0
"""Body rate above which a run counts as diverged, rad/s."""


class GyrostatState(NamedTuple):
    """State of a spacecraft with wheels.

    Attributes:
        attitude: Attitude quaternion, body with respect to inertial, (4,), scalar first.
        momentum: Total momentum in inertial axes, (3,), N·m·s.
        wheel_speed: Wheel speeds relative to the body, (wheels,), rad/s; exactly zero at rest.
        wheel_angle: Rotor angles relative to the body, (wheels,), rad; None unless the plant needs
            them (`ImbalancedGyrostat` does).
        motor_current: Motor currents, (wheels,), A; None for ideal torque motors, without a
            `DrivenGyrostat`.
        deflection: Deflections of the bristles, (wheels,), rad; None unless the friction is LuGre.
    """

    attitude: Annotated[Quaternion, "1"]
    momentum: Annotated[Vector3, "N·m·s"]
    wheel_speed: Annotated[PerWheel, "rad/s"]
    wheel_angle: Annotated[PerWheel | None, "rad"] = None
    motor_current: Annotated[PerWheel | None, "A"] = None
    deflection: Annotated[PerWheel | None, "rad"] = None


class WheelTorqueCommand(NamedTuple):
    """Motor torque of each wheel.

    Attributes:
        torque: Motor torques on the wheels, (wheels,), N·m; the body gets the opposite torque.
    """

    torque: Annotated[PerWheel, "N·m"]


class GyrostatRecord(NamedTuple):
    """Recorded signals of a gyrostat.

    Attributes:
        rate: Body rate without jitter, in body axes, (3,), rad/s.
        wheel_momentum: Rotor inertia times speed relative to the body, (wheels,), N·m·s.
        saturated: Whether a limit reduces the command of each wheel, (wheels,).
        jitter: Rotation vector from the attitude with balanced wheels to the attitude, (3,), rad;
            None for balanced wheels.
    """

    rate: Annotated[Vector3, "rad/s"]
    wheel_momentum: Annotated[PerWheel, "N·m·s"]
    saturated: Bool[Array, " wheels"]
    jitter: Annotated[Vector3 | None, "rad"] = None


class RateRecord(NamedTuple):
    """Recorded signals of a plant without wheel limits.

    Attributes:
        rate: Body rate in body axes, (3,), rad/s.
    """

    rate: Annotated[Vector3, "rad/s"]


def too_fast(rate: Vector3) -> Bool[Array, ""]:
    """Whether a body rate, (3,), rad/s, is above `FASTEST` or NaN."""
    return ~(rate @ rate < FASTEST**2)
