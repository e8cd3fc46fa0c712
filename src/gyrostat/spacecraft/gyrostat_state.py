"""State, command and record of a spacecraft with wheels."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import PerMode, PerWheel, Quaternion, Vector3
from gyrostat.core.errors import InputError

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
        modal_coordinate: Modal coordinates, (modes,), √kg·m; None for a rigid body, without
            `FlexibleModes`.
        modal_momentum: Generalised momenta of the modes, (modes,), √kg·m/s; None likewise. They
            keep their values where the body rate steps.
        deflection: Deflections of the bristles, (wheels,), rad; None without bristles.
        actuators: Name of an actuator -> its state; None without an `ActuatorWithState`.
    """

    attitude: Annotated[Quaternion, "1"]
    momentum: Annotated[Vector3, "N·m·s"]
    wheel_speed: Annotated[PerWheel, "rad/s"]
    wheel_angle: Annotated[PerWheel | None, "rad"] = None
    motor_current: Annotated[PerWheel | None, "A"] = None
    modal_coordinate: Annotated[PerMode | None, "√kg·m"] = None
    modal_momentum: Annotated[PerMode | None, "√kg·m/s"] = None
    deflection: Annotated[PerWheel | None, "rad"] = None
    actuators: Any = None


def check_sizes(state: GyrostatState, wheels: int, modes: int) -> None:
    """Validate the numbers of components of a state.

    Args:
        state: One state, or several with a leading axis of runs.
        wheels: Number of wheels.
        modes: Number of modes; 0 for a rigid body.

    Raises:
        InputError: A shape is wrong, or the motion of the modes is missing.
    """
    modal = dict.fromkeys(("modal_coordinate", "modal_momentum"), modes)
    sizes = {"attitude": 4, "momentum": 3, **modal}
    for name, value in state._replace(actuators=None)._asdict().items():
        length = sizes.get(name, wheels)
        if value is not None and np.shape(value)[-1:] != (length,):
            raise InputError(f"{name}: found shape {np.shape(value)}, expected ({length},)")
        if value is None and modes and name in modal:
            raise InputError(f"{name}: found none, expected that of {modes} modes")


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
        modal_rate: Rates of the modal coordinates, (modes,), √kg·m/s; None for a rigid body.
    """

    rate: Annotated[Vector3, "rad/s"]
    wheel_momentum: Annotated[PerWheel, "N·m·s"]
    saturated: Bool[Array, " wheels"]
    jitter: Annotated[Vector3 | None, "rad"] = None
    modal_rate: Annotated[PerMode | None, "√kg·m/s"] = None


class RateRecord(NamedTuple):
    """Recorded signals of a plant without wheel limits.

    Attributes:
        rate: Body rate in body axes, (3,), rad/s.
    """

    rate: Annotated[Vector3, "rad/s"]


def too_fast(rate: Vector3) -> Bool[Array, ""]:
    """Whether a body rate, (3,), rad/s, is above `FASTEST` or NaN."""
    return ~(rate @ rate < FASTEST**2)
