"""One reaction wheel: rotor, motor and bearing friction."""

import equinox as eqx

from gyrostat.friction import Friction, LuGre, Scalar


class Wheel(eqx.Module):
    """J dw/dt = k_m I - F(w), with F a static friction curve.

    Carrara and Kuga, "Estimating friction parameters in reaction wheels for attitude control",
    eqs. (1), (2). At rest the friction equals the motor torque up to the breakaway torque.

    Attributes:
        inertia: rotor and flywheel about the spin axis, kg·m².
        motor_constant: N·m/A.
        friction: bearing friction.
    """

    inertia: Scalar
    motor_constant: Scalar
    friction: Friction | LuGre
