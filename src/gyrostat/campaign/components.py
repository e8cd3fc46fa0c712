"""What a scenario can name: controllers, compensators and sensors, one entry each.

To add a component is to add an entry: its keys, and how it is made of their values.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gyrostat._jax import jnp
from gyrostat.body import Gyrostat, Spacecraft, SpacecraftSensor
from gyrostat.body.rotations import Vector
from gyrostat.campaign.schema import ENVIRONMENT, Key, positive, size
from gyrostat.control import FrictionFeedForward, MomentumRecovery
from gyrostat.friction import Scalar

Options = Mapping[str, Scalar]
"""Values of a component's keys, SI."""


@dataclass(frozen=True)
class Component:
    """A part of the loop.

    Attributes:
        meaning: one sentence for the documentation.
        keys: of its numbers.
        make: from their values and what it is made for; traced, so no check of values.
    """

    meaning: str
    keys: Mapping[str, Key]
    make: Callable[..., Any]


@dataclass(frozen=True)
class PlannedController(Component):
    """A controller that is planned once for each set of working wheels and target.

    Attributes:
        make: (plan, options, total momentum (3,) N·m·s) -> controller.
        plan: (spacecraft, working (wheels,), seized (wheels,), target (4,)) -> plan, outside the
            loop; plans of one scenario differ in their numbers only. Raises `InputError` for wheels
            that do not suffice.
    """

    plan: Callable[..., Any]


def _plan_three_axis(
    spacecraft: Spacecraft, working: np.ndarray, seized: np.ndarray, target: Any
) -> MomentumRecovery:
    return MomentumRecovery.plan(
        spacecraft, working, seized=seized, target=target, total_momentum=np.zeros(3)
    )


def _three_axis(plan: MomentumRecovery, options: Options, momentum: Vector) -> MomentumRecovery:
    loop = replace(plan.law.wheels, gain=options["rate_gain"], drag_time=options["drag_time"])
    law = replace(
        plan.law,
        wheels=loop,
        total_momentum=momentum,
        turn_gain=options["turn_gain"],
        largest_rate=options["largest_rate"],
    )
    return replace(plan, law=law)


def _friction_model(options: Options, controller: Any, known: Spacecraft) -> FrictionFeedForward:
    wheels = known.wheels
    return FrictionFeedForward(
        controller,
        wheels.friction,
        jnp.asarray(wheels.inertia),
        jnp.asarray(wheels.torque_limit),
        options["band"],
        options["share"],
    )


def _white_noise(options: Options, plant: Gyrostat) -> SpacecraftSensor:
    return SpacecraftSensor(plant, **options)


def _constant_torque(options: Options) -> dict[str, Any]:
    return {"external_torque": jnp.stack([options[f"external_torque.{axis}"] for axis in "xyz"])}


CONTROLLERS: dict[str, PlannedController] = {
    "three_axis": PlannedController(
        "Turns about the error axis within the wheels' limits (`gyrostat.control.ThreeAxisLaw`); "
        "learns the drag of the wheels slowly.",
        {
            "turn_gain": positive("1/s", 0.25, "Rate over error near the target."),
            "largest_rate": positive("speed", 0.1, "Of a turn."),
            "rate_gain": positive("1/s", 0.8, "Of the rate loop."),
            "drag_time": positive("time", 10.0, "Of the filter that learns the drag."),
        },
        _three_axis,
        _plan_three_axis,
    ),
}
COMPENSATORS: dict[str, Component] = {
    "none": Component("None.", {}, lambda options, controller, known: controller),
    "friction_model": Component(
        "Adds the friction of the wheel's nominal model at the measured speed "
        "(`gyrostat.control.FrictionFeedForward`).",
        {
            "band": positive("speed", 1.0, "Speed below which its sign counts for nothing."),
            "share": size("1", 1.0, "Of the friction that is compensated."),
        },
        _friction_model,
    ),
}
SENSORS: dict[str, Component] = {
    "white_noise": Component(
        "Attitude, rate and wheel momenta with white noise (`gyrostat.body.SpacecraftSensor`).",
        {
            "attitude_sigma": size("angle", 0.0, "Of a sample about each body axis."),
            "rate_sigma": size("speed", 0.0, "Of a sample of each component."),
            "wheel_sigma": size("momentum", 0.0, "Of a sample of each wheel's momentum."),
        },
        _white_noise,
    ),
}
SURROUNDINGS = Component(
    "Torque from outside; gives the arguments of `gyrostat.body.Gyrostat`.",
    ENVIRONMENT,
    _constant_torque,
)
