"""State, parameters, inputs and samples of the motion of a flight.

Shapes are those of one flight; those of a fleet have a leading axis of B flights.
"""

from typing import Any, NamedTuple


class FlightState(NamedTuple):
    """State of a flight.

    Attributes:
        angle: Attitude error, (3,), rad.
        rate: Rate error, (3,), rad/s.
        momentum: Total momentum, inertial axes, (3,), N·m·s.
        null_momentum: Null-space momentum of the rotors, scalar, N·m·s.
        noise: Relative deviation of the Coulomb torque, (wheels,).
        burst: Noise of torque bursts, standardised, scalar.
        firing: Whether thrusters unload, scalar.
    """

    angle: Any
    rate: Any
    momentum: Any
    null_momentum: Any
    noise: Any
    burst: Any
    firing: Any


class Slow(NamedTuple):
    """Parameters that change over minutes, each (wheels,); with a leading axis of minutes.

    Attributes:
        coulomb: N·m.
        viscous: N·m·s/rad.
        excess: Breakaway torque beyond Coulomb, N·m.
        gain: Relative deviation of the motor constant from the one that the drive uses.
        offset: Friction torque independent of the sign of the speed, N·m.
        tachometer: Relative error of the measured speed.
        burst: Size of torque bursts, N·m.
    """

    coulomb: Any
    viscous: Any
    excess: Any
    gain: Any
    offset: Any
    tachometer: Any
    burst: Any


class Commanded(NamedTuple):
    """Commanded motion and surroundings, common to the flights; with leading axes of time.

    Attributes:
        to_inertial: (3, 3).
        rate: rad/s, (3,).
        acceleration: rad/s², (3,).
        gradient: Gravity gradient torque, N·m, (3,).
        field: Direction of the magnetic field, (3,).
    """

    to_inertial: Any
    rate: Any
    acceleration: Any
    gradient: Any
    field: Any


class Telemetered(NamedTuple):
    """Samples at the start of each step.

    Attributes:
        speed: Measured wheel speeds, (wheels,), rad/s.
        torque: Commanded motor torques, (wheels,), N·m.
        angle: Measured attitude error, (3,), rad.
        rate: Measured rate error, (3,), rad/s.
        coulomb: Realised Coulomb torque, (wheels,), N·m.
        firing: scalar.
    """

    speed: Any
    torque: Any
    angle: Any
    rate: Any
    coulomb: Any
    firing: Any
