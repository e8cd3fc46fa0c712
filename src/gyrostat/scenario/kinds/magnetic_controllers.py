"""Detumbling, sun pointing and momentum unloading, for scenarios."""

from dataclasses import replace

from gyrostat.control.attitude.sun_pointing import SunPointing
from gyrostat.control.magnetic.b_cross import BCross, least_inertia
from gyrostat.control.magnetic.rod_unloading import RodUnloading
from gyrostat.control.thruster_unloading import ThrusterUnloading
from gyrostat.core.arrays import Vector3
from gyrostat.scenario.kinds.actuators import DIPOLE_LIMIT, DUTY, THRUSTERS
from gyrostat.scenario.kinds.components import Component, Options
from gyrostat.scenario.kinds.controllers import IGNORED, DesignCase, PlannedController
from gyrostat.scenario.schema import positive, size, vector


def _plan_detumbling(case: DesignCase) -> BCross:
    return BCross(case.spacecraft, least_inertia(case.spacecraft))


def _detumbling(plan: BCross, options: Options, momentum: Vector3) -> BCross:
    return replace(plan, gain=options["gain"] * plan.gain, speed_gain=options["speed_gain"])


def _sun_pointing(plan: SunPointing, options: Options, momentum: Vector3) -> SunPointing:
    return replace(plan, **options)


_MOMENTUM = vector("momentum", "Target of the wheels' momentum, in body axes.")
_COMPENSATION = size(
    "1",
    0.0,
    "Share of the torque of the unloading that is added to the wheel torques; 0 for controllers "
    "that estimate external torques, such as `wheel_array`.",
    most=1.0,
)
MAGNETIC_CONTROLLERS: dict[str, PlannedController] = {
    "detumbling": PlannedController(
        "Detumbling by torque rods with the B-cross law (`gyrostat.control.BCross`). It needs a "
        "`[[sensor]]` named `magnetometer` and an `[[actuator]]` named `torque_rods`, and controls "
        "no attitude.",
        {
            "gain": positive(
                "1/s",
                4e-3,
                "Gain over the smallest principal inertia: 2 n (1 + sin i), with the mean motion n "
                "and the inclination i to the geomagnetic equator.",
            ),
            "speed_gain": size(
                "1/s", 0.0, "Gain that holds the initial wheel speeds; 0: no wheel torque."
            ),
        },
        _detumbling,
        _plan_detumbling,
        IGNORED,
        follows=False,
        needs=("magnetometer", "torque_rods"),
    ),
    "sun_pointing": PlannedController(
        "Sun pointing of a body axis by wheels (`gyrostat.control.SunPointing`). It needs a "
        "`[[sensor]]` named `sun_sensor` or `coarse_sun_sensors`. While the Sun is not seen, the "
        "rate is damped only.",
        {
            "axis": vector("1", "Body axis, of any length.", (0.0, 0.0, 1.0)),
            "turn_gain": positive("1/s", 0.05, "Commanded rate per angle to the Sun."),
            "rate_gain": positive("1/s", 0.2, "Gain of the rate loop."),
            "largest_rate": positive("speed", 0.02, "Largest commanded rate."),
            "search_rate": vector("speed", "Commanded rate while the Sun is not seen."),
        },
        _sun_pointing,
        lambda case: SunPointing(case.spacecraft),
        IGNORED,
        follows=False,
        needs=("sun_sensor",),
    ),
}
UNLOADINGS: dict[str, Component] = {
    "none": Component(
        "No unloading in addition to that of the controller.",
        {},
        lambda options, controller, known: controller,
    ),
    "torque_rods": Component(
        "Unloading of the wheels by torque rods with the cross-product law "
        "(`gyrostat.control.RodUnloading`). It needs a `[[sensor]]` named `magnetometer` and an "
        "`[[actuator]]` named `torque_rods`.",
        {
            "limit": replace(DIPOLE_LIMIT, meaning="Largest commanded dipole moment of each rod."),
            "gain": positive("1/s", 1e-3, "Gain, slow compared with the attitude loop."),
            "momentum": _MOMENTUM,
            "duty": replace(DUTY, meaning="Share of each control period in which the rods are on."),
            "compensation": _COMPENSATION,
        },
        lambda options, controller, known: RodUnloading(controller, known.wheels, **options),
        needs=("magnetometer", "torque_rods"),
    ),
    "thrusters": Component(
        "Unloading of the wheels by pairs of thrusters, with hysteresis about each axis "
        "(`gyrostat.control.ThrusterUnloading`). It needs an `[[actuator]]` of the kind and name "
        "`thrusters`; `arm`, `force` and `minimum` are those that the controller knows.",
        {
            **THRUSTERS,
            "begin": positive("momentum", None, "Momentum above which an axis is unloaded."),
            "end": positive("momentum", None, "Momentum below which its unloading ends."),
            "impulse": positive(
                "momentum",
                None,
                "Largest angular impulse about each axis in a control period; over the period, it "
                "must stay below the torque of the wheels.",
            ),
            "momentum": _MOMENTUM,
            "compensation": _COMPENSATION,
        },
        lambda options, controller, known: ThrusterUnloading(controller, known.wheels, **options),
        needs=("thrusters",),
    ),
}
"""Kind of [unloading] -> component, which wraps the controller outside the compensator."""
