"""Pointing of one axis by two speed-commanded wheels."""

from dataclasses import dataclass, replace
from typing import Annotated

from gyrostat.control import TwoWheelPointing, WheelSpeedLoops
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import to_inertial
from gyrostat.scenario.controller_kind import IGNORED, Beginning, ControllerKind, DesignCase
from gyrostat.scenario.schema import positive, size


@dataclass(frozen=True, eq=False)
class TwoWheels(ControllerKind):
    """Pointing of the body z axis by two speed-commanded wheels.

    It has speed loops and a model error compensator (`gyrostat.control.TwoWheelPointing`). Only the
    direction of body z is controlled, towards its direction at the target. Set `metrics.boresight`
    to z. Wheel failures are not taken into account. Of the references, only `fixed` is possible.
    """

    name = "two_wheels"
    losses = IGNORED
    follows = False
    turn_gain: Annotated[
        Scalar, positive("1/s", 0.1, "Commanded rate per pointing error near the target.")
    ]
    compensator_gain: Annotated[
        Scalar, size("1/s", 0.05, "Gain of the model error compensator; 0: no compensator.")
    ]
    momentum_time: Annotated[
        Scalar, positive("time", 30.0, "Time constant of the total momentum filter.")
    ]
    rotor_sigma: Annotated[
        Scalar,
        positive(
            "1", 0.05, "Relative standard deviation of the rotor inertias, which are estimated."
        ),
    ]
    bandwidth: Annotated[
        Scalar, positive("rad/s", 0.05, "Bandwidth of the attitude and gyro bias filter.")
    ]
    natural_frequency: Annotated[
        Scalar, positive("rad/s", 2.0, "Natural frequency of the speed loops.")
    ]

    @classmethod
    def plan(cls, case: DesignCase) -> TwoWheelPointing:
        """See `ControllerKind.plan`."""
        along = to_inertial(jnp.asarray(case.target), jnp.array([0.0, 0.0, 1.0]))
        return TwoWheelPointing(case.spacecraft, along=along)

    def controller(self, design: TwoWheelPointing, beginning: Beginning) -> WheelSpeedLoops:
        """See `ControllerKind.controller`."""
        wheels = design.spacecraft.wheels
        pointing = replace(
            design,
            law=replace(design.law, gain=self.turn_gain),
            filter=replace(design.filter, bandwidth=self.bandwidth),
            momentum_time=self.momentum_time,
            rotor_sigma=self.rotor_sigma,
            gain=self.compensator_gain * jnp.ones(2),
        )
        limits = (jnp.asarray(wheels.inertia), jnp.asarray(wheels.torque_limit))
        return WheelSpeedLoops(pointing, *limits, self.natural_frequency)
