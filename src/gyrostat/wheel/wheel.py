"""Parameters of one reaction wheel: rotor, motor, bearing friction."""

from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive
from gyrostat.wheel.friction import Friction, LuGre


class Wheel(Checked):
    """J dw/dt = k_m I - F(w), with F a static friction curve.

    Carrara and Kuga, "Estimating friction parameters in reaction wheels for attitude control",
    eqs. (1), (2). At rest the friction equals the motor torque up to the breakaway torque.

    Attributes:
        inertia: rotor and flywheel about the spin axis, kg·m².
        motor_constant: N·m/A.
        friction: bearing friction.
    """

    inertia: Annotated[Scalar, positive("wheel inertia", "kg·m²")]
    motor_constant: Annotated[Scalar, positive("motor_constant", "N·m/A")]
    friction: Friction | LuGre
