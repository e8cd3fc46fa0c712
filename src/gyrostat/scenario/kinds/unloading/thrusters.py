"""Unloading of the wheels by thrusters."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control.thruster_unloading import ThrusterUnloading
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.component import Context, Kind, part_named
from gyrostat.scenario.kinds.actuator.thrusters import ARM, FORCE, MINIMUM
from gyrostat.scenario.kinds.unloading.torque_rods import COMPENSATION, MOMENTUM
from gyrostat.scenario.schema import positive


@dataclass(frozen=True, eq=False)
class ThrusterUnloadingKind(Kind):
    """Unloading of the wheels by pairs of thrusters, with hysteresis about each axis.

    See `gyrostat.control.ThrusterUnloading`. It needs an `[[actuator]]` of the kind and name
    `thrusters`; `arm`, `force` and `minimum` are those that the controller knows.
    """

    name = "thrusters"
    needs = frozenset({part_named("actuator", "thrusters")})
    arm: Annotated[Scalar, ARM]
    force: Annotated[Scalar, FORCE]
    minimum: Annotated[Scalar, MINIMUM]
    begin: Annotated[
        Scalar, positive("momentum", None, "Momentum above which an axis is unloaded.")
    ]
    end: Annotated[Scalar, positive("momentum", None, "Momentum below which its unloading ends.")]
    impulse: Annotated[
        Scalar,
        positive(
            "momentum",
            None,
            "Largest angular impulse about each axis in a control period; over the period, it must "
            "stay below the torque of the wheels.",
        ),
    ]
    momentum: Annotated[Vector3, MOMENTUM]
    compensation: Annotated[Scalar, COMPENSATION]

    def make(self, context: Context) -> ThrusterUnloading:
        """Controller with unloading."""
        assert context.spacecraft is not None
        return ThrusterUnloading(context.controller, context.spacecraft.wheels, **self.options())
