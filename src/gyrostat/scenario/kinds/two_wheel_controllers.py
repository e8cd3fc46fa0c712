"""Controllers for two wheels that a scenario can name, one entry each."""

from dataclasses import replace

from gyrostat.control import PaddleRecovery, TwoWheelPointing, WheelSpeedLoops
from gyrostat.core.arrays import Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import to_inertial
from gyrostat.scenario.kinds.components import Options
from gyrostat.scenario.kinds.controllers import IGNORED, DesignCase, PlannedController
from gyrostat.scenario.schema import positive, size


def _plan_two_wheels(case: DesignCase) -> TwoWheelPointing:
    along = to_inertial(jnp.asarray(case.target), jnp.array([0.0, 0.0, 1.0]))
    return TwoWheelPointing(case.spacecraft, along=along)


def _two_wheels(plan: TwoWheelPointing, options: Options, momentum: Vector3) -> WheelSpeedLoops:
    wheels = plan.spacecraft.wheels
    pointing = replace(
        plan,
        law=replace(plan.law, gain=options["turn_gain"]),
        filter=replace(plan.filter, bandwidth=options["bandwidth"]),
        momentum_time=options["momentum_time"],
        rotor_sigma=options["rotor_sigma"],
        gain=options["compensator_gain"] * jnp.ones(2),
    )
    limits = (jnp.asarray(wheels.inertia), jnp.asarray(wheels.torque_limit))
    return WheelSpeedLoops(pointing, *limits, options["natural_frequency"])


def _plan_paddle(case: DesignCase) -> PaddleRecovery:
    wheels = case.spacecraft.wheels
    return PaddleRecovery.plan(
        case.spacecraft, paddle=wheels.count - 1, angle_limit=1.0, target=jnp.asarray(case.target)
    )


def _paddle(plan: PaddleRecovery, options: Options, momentum: Vector3) -> PaddleRecovery:
    law = plan.turning.law
    loop = replace(law.wheels, gain=options["rate_gain"], drag_time=options["drag_time"])
    law = replace(law, wheels=loop, total_momentum=momentum, turn_gain=options["turn_gain"])
    return replace(
        plan,
        turning=replace(plan.turning, law=law),
        angle_limit=options["paddle_limit"],
        share=options["paddle_share"],
        holding=options["holding_gain"],
    )


TWO_WHEEL_CONTROLLERS: dict[str, PlannedController] = {
    "two_wheels": PlannedController(
        "Pointing of the body z axis by two speed-commanded wheels "
        "(`gyrostat.control.TwoWheelPointing`) with speed loops and a model error compensator. "
        "Only the direction of body z is controlled, towards its direction at the target. Set "
        "`metrics.boresight` to z. Wheel failures are not taken into account. Of the references, "
        "only `fixed` is possible.",
        {
            "turn_gain": positive("1/s", 0.1, "Commanded rate per pointing error near the target."),
            "compensator_gain": size(
                "1/s", 0.05, "Gain of the model error compensator; 0: no compensator."
            ),
            "momentum_time": positive("time", 30.0, "Time constant of the total momentum filter."),
            "rotor_sigma": positive(
                "1", 0.05, "Relative standard deviation of the rotor inertias, which are estimated."
            ),
            "bandwidth": positive("rad/s", 0.05, "Bandwidth of the attitude and gyro bias filter."),
            "natural_frequency": positive("rad/s", 2.0, "Natural frequency of the speed loops."),
        },
        _two_wheels,
        _plan_two_wheels,
        IGNORED,
        follows=False,
    ),
    "two_wheels_paddle": PlannedController(
        "Three-axis control by two wheels and a driven paddle, without total momentum "
        "(`gyrostat.control.PaddleRecovery`). The paddle is the last [[wheel]] of the spacecraft "
        "file: its axis is the hinge line, its momentum limit is its inertia times its largest "
        "rate. It needs a `[[sensor]]` named `paddle_angle`. Turns beyond the range of the paddle "
        "are made by sweeps of the two wheels. Wheel failures are not taken into account. Of the "
        "references, only `fixed` is possible.",
        {
            "paddle_limit": positive(
                "angle", None, "Largest angle of the paddle to either side, where a stop is."
            ),
            "paddle_share": positive(
                "1", 0.9, "Fraction of the limit at which the use of the paddle begins.", most=1.0
            ),
            "turn_gain": positive("1/s", 0.5, "Commanded rate per attitude error near the target."),
            "rate_gain": positive("1/s", 2.0, "Gain of the rate loop."),
            "drag_time": positive("time", 2.0, "Time constant of the drag estimate."),
            "holding_gain": positive(
                "1/s", 2.0, "Gain of the rate loop that holds the paddle while the wheels sweep."
            ),
        },
        _paddle,
        _plan_paddle,
        IGNORED,
        follows=False,
        needs=("paddle_angle",),
    ),
}
