"""Parameters of one reaction wheel: rotor, motor, bearing friction."""

import equinox as eqx

from gyrostat.core.arrays import Scalar
from gyrostat.core.validation import check_parts, require
from gyrostat.wheel.friction import Friction, LuGre


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

    def check(self) -> None:
        """Validate parameters.

        Raises:
            InputError: inertia or motor constant are not positive, or see the friction.
        """
        require("wheel inertia", self.inertia, "kg·m²", positive=True)
        require("motor_constant", self.motor_constant, "N·m/A", positive=True)
        check_parts(self.friction)
