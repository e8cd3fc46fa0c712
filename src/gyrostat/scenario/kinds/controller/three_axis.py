"""Three-axis control by rotations about the axis of the attitude error."""

from dataclasses import dataclass, replace
from typing import Annotated

import equinox as eqx
import numpy as np

from gyrostat.control import MomentumRecovery
from gyrostat.core.arrays import Scalar
from gyrostat.scenario.controller_kind import Beginning, ControllerKind, DesignCase
from gyrostat.scenario.schema import positive

TORQUE_TIME = replace(
    positive(
        "time",
        20.0,
        "Time constant of the estimate of the external torque, which the wheels take up; "
        '`"none"`: no estimate, and an external torque causes a constant attitude error.',
    ),
    unlimited=True,
)


@dataclass(frozen=True, eq=False)
class ThreeAxis(ControllerKind):
    """Three-axis control by rotations about the axis of the attitude error.

    They are within the limits of the wheels (`gyrostat.control.ThreeAxisLaw`), with a slow estimate
    of the wheel drag.
    """

    name = "three_axis"
    turn_gain: Annotated[
        Scalar, positive("1/s", 0.25, "Commanded rate per attitude error near the target.")
    ]
    largest_rate: Annotated[Scalar, positive("speed", 0.1, "Largest slew rate.")]
    rate_gain: Annotated[Scalar, positive("1/s", 0.8, "Gain of the rate loop.")]
    drag_time: Annotated[
        Scalar, positive("time", 10.0, "Time constant of the wheel drag estimate.")
    ]
    torque_time: Annotated[Scalar, TORQUE_TIME]

    @classmethod
    def plan(cls, case: DesignCase) -> MomentumRecovery:
        """See `ControllerKind.plan`."""
        design = MomentumRecovery.plan(
            case.spacecraft,
            case.working,
            seized=case.seized,
            target=case.target,
            total_momentum=np.zeros(3),
        )
        wheels = replace(design.law.wheels, delay=case.delay)
        return eqx.tree_at(lambda f: f.law.wheels, design, wheels)

    def controller(self, design: MomentumRecovery, beginning: Beginning) -> MomentumRecovery:
        """See `ControllerKind.controller`."""
        loop = replace(design.law.wheels, gain=self.rate_gain, drag_time=self.drag_time)
        law = replace(
            design.law,
            wheels=loop,
            total_momentum=beginning.momentum,
            turn_gain=self.turn_gain,
            largest_rate=self.largest_rate,
        )
        return replace(design, law=law, torque_time=self.torque_time)
