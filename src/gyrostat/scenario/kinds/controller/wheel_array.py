"""Control of any number of wheels."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from math import inf
from typing import Annotated, Any, ClassVar

import numpy as np

from gyrostat.control import (
    AttitudeTargets,
    MinimaxAllocation,
    MomentumPlan,
    MomentumUnloading,
    NullSpaceControl,
    PseudoInverse,
    WheelArrayControl,
    WheelFaultDetector,
    WheelWear,
)
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import NULL_SPACE
from gyrostat.scenario.controller_kind import DETECTED, Beginning, ControllerKind, DesignCase
from gyrostat.scenario.schema import positive, size
from gyrostat.spacecraft import Gyrostat

LARGEST_RATE_GAIN, SMALLEST_TURN_GAIN = 0.8, 0.05
"""Bounds of the default gains, 1/s."""
GAIN_RATIO = 0.3125
"""Default turn gain over rate gain."""
LARGEST_LAG = 0.4
"""Largest product of default rate gain and mean age of a command. With `GAIN_RATIO` the loop gain
is 1 at 1.04 times the rate gain, so that the phase margin is 73 deg - 1.04 x 0.4 rad = 49 deg."""


@dataclass(frozen=True, eq=False)
class WheelArray(ControllerKind):
    """Control of any number of wheels (`gyrostat.control.WheelArrayControl`).

    It has minimax torque allocation, null-space control away from zero speed and saturation,
    estimates of drag and external torque, and momentum unloading.
    """

    name = "wheel_array"
    provides = frozenset({NULL_SPACE})
    allocation: ClassVar[MinimaxAllocation | PseudoInverse] = MinimaxAllocation()
    turn_gain: Annotated[
        Scalar,
        positive(
            "1/s",
            GAIN_RATIO * LARGEST_RATE_GAIN,
            "Commanded rate per attitude error near the target. The default is at most 0.3125 "
            "times the rate gain, and at most the noise of the rate over that of the attitude, but "
            "not below 0.05 for that reason.",
        ),
    ]
    rate_gain: Annotated[
        Scalar,
        positive(
            "1/s",
            LARGEST_RATE_GAIN,
            "Gain of the rate loop. The default is at most 0.4 over the age of the commands: the "
            "control period, times the command delay and a half if there is a delay.",
        ),
    ]
    torque_time: Annotated[
        Scalar, positive("time", 20.0, "Time constant of the external torque estimate.")
    ]
    largest_rate: Annotated[Scalar, positive("speed", 0.05, "Largest slew rate.")]
    drag_time: Annotated[
        Scalar, positive("time", 10.0, "Time constant of the wheel drag estimate.")
    ]
    null_space_gain: Annotated[
        Scalar,
        size(
            "1/s",
            0.05,
            "Gain of the null-space control of wheel speeds, for four or more wheels; 0: none.",
        ),
    ]
    clearance: Annotated[
        Scalar,
        positive(
            "speed",
            inf,
            "Distance of wheel speeds from zero and from `[[controller.band]]` that suffices; "
            "none: as far as possible.",
        ),
    ]
    crossing_gain: Annotated[
        Scalar,
        positive("1/s", 0.2, "Gain of the null-space control while wheels cross zero or a band."),
    ]
    wear_time: Annotated[
        Scalar,
        positive(
            "time",
            inf,
            "Time constant of the estimate of wear, the friction of each wheel over that of its "
            "model; none: no estimate.",
        ),
    ]
    external_torque_limit: Annotated[
        Scalar,
        size(
            "torque",
            0.0,
            "Torque limit of the actuator that unloads the wheels, about each body axis; 0: no "
            "actuator.",
        ),
    ]
    momentum_gain: Annotated[Scalar, positive("1/s", 1e-3, "Gain of the momentum unloading.")]

    @classmethod
    def defaults(cls, values: Mapping[str, float], delay: int) -> dict[str, float]:
        """Default gains, 1/s, from control period, command delay and sensor noise.

        The rate gain is limited by the age of the commands. White noise of rate and attitude with
        the standard deviations s_w and s_a causes an attitude error of variance
        T (s_w²/k_t + k_t s_a²)/2 in a loop with turn gain k_t and control period T. The turn gain
        is that of the smallest error, s_w / s_a, within bounds.

        Args:
            values: Values of the other sections.
            delay: Command delay, periods.
        """
        age = values["run.control_period"] * max(1.0, delay + 0.5)
        rate_gain = min(LARGEST_RATE_GAIN, LARGEST_LAG / age)
        turn_gain = GAIN_RATIO * rate_gain
        rate, attitude = (values.get(f"sensors.{name}_sigma", 0.0) for name in ("rate", "attitude"))
        if "sensors.rate_sigma" in values and attitude > 0.0:
            best = max(rate / attitude, SMALLEST_TURN_GAIN)
            turn_gain = min(turn_gain, best)
        return {"rate_gain": rate_gain, "turn_gain": turn_gain}

    @classmethod
    def plan(cls, case: DesignCase) -> WheelArrayControl:
        """See `ControllerKind.plan`."""
        wheels, null_space = case.spacecraft.wheels, None
        if wheels.count > 3:
            null_space = NullSpaceControl.plan(wheels.axes, wheels.momentum_limit)
        return WheelArrayControl(
            case.spacecraft,
            AttitudeTargets.hold(case.target),
            allocation=cls.allocation,
            null_space=null_space,
            detector=WheelFaultDetector(
                notified=np.where(case.working, np.inf, 0.0), delay=case.delay
            ),
        )

    def controller(self, design: WheelArrayControl, beginning: Beginning) -> WheelArrayControl:
        """See `ControllerKind.controller`."""
        limit = self.external_torque_limit * jnp.ones(3)
        null_space, inertia = design.null_space, jnp.asarray(design.spacecraft.wheels.inertia)
        if null_space is not None:
            bands = [[band.above * inertia, band.below * inertia] for band in beginning.bands]
            null_space = replace(
                null_space,
                gain=self.null_space_gain,
                bands=jnp.array(bands) if bands else None,
                clearance=self.clearance * jnp.max(inertia),
                crossing_gain=self.crossing_gain,
            )
        wear = 1.0 if beginning.wear is None else beginning.wear
        return replace(
            design,
            wear=WheelWear(wear * jnp.ones(len(inertia)), self.wear_time),
            turn_gain=self.turn_gain,
            rate_gain=self.rate_gain,
            torque_time=self.torque_time,
            largest_rate=self.largest_rate,
            null_space=null_space,
            plan=_momentum_plan(beginning.plan),
            unloading=MomentumUnloading(limit, self.momentum_gain),
            detector=replace(design.detector, drag_time=self.drag_time),
        )

    def body(self, plant: Gyrostat) -> Gyrostat:
        """Plant with the actuator that unloads the wheels."""
        return replace(plant, external_torque_limit=self.external_torque_limit * jnp.ones(3))


def _momentum_plan(entries: Sequence[Any]) -> MomentumPlan | None:
    """Momentum plan of the entries; None without any."""
    if not entries:
        return None
    return MomentumPlan(
        **{
            each.name: jnp.stack([getattr(entry, each.name) for entry in entries])
            for each in fields(MomentumPlan)
        }
    )


@dataclass(frozen=True, eq=False)
class WheelArrayPseudoInverse(WheelArray):
    """As `wheel_array`, with torque allocation by the pseudo-inverse (least sum of squares)."""

    name = "wheel_array_pseudo_inverse"
    allocation = PseudoInverse()


@dataclass(frozen=True, eq=False)
class WheelArrayDetecting(WheelArray):
    """As `wheel_array`, but not notified of wheel failures; it detects them.

    If a wheel gives `failure_torque` less than commanded, it is declared failed for the rest of the
    run. Choose `failure_torque` above the drag of the bearings and below half the torque limit, up
    to which drag compensation raises the command to a failed motor.
    """

    name = "wheel_array_detecting"
    losses = DETECTED
    failure_torque: Annotated[
        Scalar, positive("torque", None, "Lost torque above which a wheel is declared failed.")
    ]
    failure_time: Annotated[
        Scalar,
        positive("time", 5.0, "Time constant of the low-pass filter of the lost torque."),
    ]

    def controller(self, design: WheelArrayControl, beginning: Beginning) -> WheelArrayControl:
        """See `ControllerKind.controller`."""
        control = super().controller(design, beginning)
        detector = replace(
            control.detector, failure_torque=self.failure_torque, failure_time=self.failure_time
        )
        return replace(control, detector=detector)
