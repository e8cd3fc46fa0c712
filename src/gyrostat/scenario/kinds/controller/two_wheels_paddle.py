"""Three-axis control by two wheels and a driven paddle."""

from dataclasses import dataclass, replace
from typing import Annotated

from gyrostat.control import PaddleRecovery
from gyrostat.core.arrays import Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import PADDLE, part_named
from gyrostat.scenario.controller_kind import IGNORED, Beginning, ControllerKind, DesignCase
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.schema import positive
from gyrostat.spacecraft import Gyrostat, PaddleGyrostat


@dataclass(frozen=True, eq=False)
class TwoWheelsPaddle(ControllerKind):
    """Three-axis control by two wheels and a driven paddle, without total momentum.

    See `gyrostat.control.PaddleRecovery`. The paddle is the last [[wheel]] of the spacecraft file:
    its axis is the hinge line, its momentum limit is its inertia times its largest rate. It needs a
    `[[sensor]]` named `paddle_angle`. Turns beyond the range of the paddle are made by sweeps of
    the two wheels. Wheel failures are not taken into account. Of the references, only `fixed` is
    possible.
    """

    name = "two_wheels_paddle"
    losses = IGNORED
    follows = False
    needs = frozenset({part_named("sensor", "paddle_angle")})
    provides = frozenset({PADDLE})
    paddle_limit: Annotated[
        Scalar,
        positive("angle", None, "Largest angle of the paddle to either side, where a stop is."),
    ]
    paddle_share: Annotated[
        Scalar,
        positive(
            "1", 0.9, "Fraction of the limit at which the use of the paddle begins.", most=1.0
        ),
    ]
    turn_gain: Annotated[
        Scalar, positive("1/s", 0.5, "Commanded rate per attitude error near the target.")
    ]
    rate_gain: Annotated[Scalar, positive("1/s", 2.0, "Gain of the rate loop.")]
    drag_time: Annotated[Scalar, positive("time", 2.0, "Time constant of the drag estimate.")]
    holding_gain: Annotated[
        Scalar,
        positive("1/s", 2.0, "Gain of the rate loop that holds the paddle while the wheels sweep."),
    ]

    @classmethod
    def check(cls, place: str, scenario: Scenario) -> None:
        """Check that the wheels have neither imbalance nor drivers, which a paddle has not."""
        for key, section in (("static_imbalance", "imbalance"), ("motor_constant", "driver")):
            if f"wheel.{scenario.wheels[0]}.{key}" in scenario.values:
                raise InputError(
                    f"key {place}.kind: found {cls.name} with [{section}], expected none"
                )

    @classmethod
    def plan(cls, case: DesignCase) -> PaddleRecovery:
        """See `ControllerKind.plan`."""
        return PaddleRecovery.plan(
            case.spacecraft,
            paddle=case.spacecraft.wheels.count - 1,
            angle_limit=1.0,
            target=jnp.asarray(case.target),
        )

    def controller(self, design: PaddleRecovery, beginning: Beginning) -> PaddleRecovery:
        """See `ControllerKind.controller`."""
        law = design.turning.law
        loop = replace(law.wheels, gain=self.rate_gain, drag_time=self.drag_time)
        law = replace(law, wheels=loop, total_momentum=beginning.momentum, turn_gain=self.turn_gain)
        return replace(
            design,
            turning=replace(design.turning, law=law),
            angle_limit=self.paddle_limit,
            share=self.paddle_share,
            holding=self.holding_gain,
        )

    def body(self, plant: Gyrostat) -> PaddleGyrostat:
        """Plant with the paddle in the place of the last wheel."""
        count = plant.spacecraft.wheels.count
        return PaddleGyrostat(plant, jnp.full(count, jnp.inf).at[-1].set(self.paddle_limit))
