"""Detumbling by torque rods."""

from dataclasses import dataclass, replace
from typing import Annotated

from gyrostat.control.magnetic.b_cross import BCross, least_inertia
from gyrostat.core.arrays import Scalar
from gyrostat.scenario.component import part_named
from gyrostat.scenario.controller_kind import IGNORED, Beginning, ControllerKind, DesignCase
from gyrostat.scenario.schema import positive, size


@dataclass(frozen=True, eq=False)
class Detumbling(ControllerKind):
    """Detumbling by torque rods with the B-cross law (`gyrostat.control.BCross`).

    It needs a `[[sensor]]` named `magnetometer` and an `[[actuator]]` named `torque_rods`, and
    controls no attitude.
    """

    name = "detumbling"
    losses = IGNORED
    follows = False
    needs = frozenset({part_named("sensor", "magnetometer"), part_named("actuator", "torque_rods")})
    gain: Annotated[
        Scalar,
        positive(
            "1/s",
            4e-3,
            "Gain over the smallest principal inertia: 2 n (1 + sin i), with the mean motion n "
            "and the inclination i to the geomagnetic equator.",
        ),
    ]
    speed_gain: Annotated[
        Scalar,
        size("1/s", 0.0, "Gain that holds the initial wheel speeds; 0: no wheel torque."),
    ]

    @classmethod
    def plan(cls, case: DesignCase) -> BCross:
        """See `ControllerKind.plan`."""
        return BCross(case.spacecraft, least_inertia(case.spacecraft))

    def controller(self, design: BCross, beginning: Beginning) -> BCross:
        """See `ControllerKind.controller`."""
        return replace(design, gain=self.gain * design.gain, speed_gain=self.speed_gain)
