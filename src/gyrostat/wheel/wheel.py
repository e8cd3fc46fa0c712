"""Parameters of one reaction wheel: rotor, motor and bearing friction."""

from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive
from gyrostat.wheel.friction import AnyFriction


class Wheel(Checked):
    """Reaction wheel J dw/dt = k_m I - F(w), with F a static friction curve.

    Carrara and Kuga, "Estimating friction parameters in reaction wheels for attitude control",
    eqs. (1), (2). At rest the friction equals the motor torque up to the breakaway torque.

    Attributes:
        inertia: Inertia of rotor and flywheel about the spin axis, kg·m².
        motor_constant: Motor constant k_m, N·m/A.
        friction: Bearing friction, a static curve or bristles.
    """

    inertia: Annotated[Scalar, positive("wheel inertia", "kg·m²")]
    motor_constant: Annotated[Scalar, positive("motor_constant", "N·m/A")]
    friction: AnyFriction
