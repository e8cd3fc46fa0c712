"""Flight modules: functions, state and check run of each part that can be exported."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from gyrostat.codegen.evaluation import evaluated
from gyrostat.codegen.tracing import as_arrays
from gyrostat.control import (
    CurrentMode,
    EstimatingCompensator,
    FieldLimits,
    Guarded,
    MeasurementGuard,
)
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import FrictionScaleFilter
from gyrostat.exports import entries
from gyrostat.exports.compensated_wheel import BodyMeasurement, CompensatedWheel
from gyrostat.exports.target import STEPS, Target, flight_module
from gyrostat.spacecraft import TableMeasurement
from gyrostat.wheel import Wheel

Limits = Mapping[str, FieldLimits] | None
"""Name of a measured field -> its limits; None to test only that values are finite."""
UNITS = {
    "speed": "rad/s",
    "initial_speed": "rad/s",
    "current": "A",
    "slope": "A/s",
    "duration": "s",
    "period": "s",
}


def _measurements() -> TableMeasurement:
    """Test measurements: table oscillations, a zero crossing of the wheel, three bad samples."""
    random, step = np.random.default_rng(0), np.arange(STEPS)
    speed = np.linspace(-3.0, 3.0, STEPS) + 0.2 * random.standard_normal(STEPS)
    attitude = 1e-3 * np.sin(0.3 * step)
    rate = 2e-4 * np.cos(0.3 * step) + 1e-5 * random.standard_normal(STEPS)
    attitude[7], rate[15], speed[16] = np.nan, np.inf, -np.inf
    return TableMeasurement(*map(jnp.asarray, (attitude, rate, speed)))


def _loop(
    name: str, title: str, controller: Any, period: float, limits: Limits, on_bad: str
) -> Target:
    measured = _measurements()
    sample = jax.tree.map(lambda x: x[0], measured)
    guard = entries.guard_of(controller, period, sample, limits, on_bad)
    return flight_loop(name, title, controller, period, guard, measured)


_start = evaluated(Guarded.start)


def flight_loop(
    name: str, title: str, controller: Any, period: float, guard: MeasurementGuard, measured: Any
) -> Target:
    """Flight module of any controller of a loop.

    Args:
        name: Name of the module.
        title: One-line title.
        controller: Controller.
        period: Control period, s.
        guard: Validation of its measurements.
        measured: Measurements of the test run; the first axis is the step.
    """
    memory = as_arrays(_start(Guarded(controller, guard), period))
    return flight_module(
        name,
        {"controller": controller, "guard": guard},
        {"memory": memory},
        [("start", entries.starting(guard), ("memory",))],
        [("step", entries.command, ("memory", "command", "report"))],
        title=title,
        period=period,
        constants={"period": period},
        inputs={"measurement": measured},
        units=UNITS,
        on_bad=guard.on_bad,
    )


def compensator(
    controller: EstimatingCompensator, period: float, limits: Limits = None, on_bad: str = "hold"
) -> Target:
    """Flight module of friction compensation with a Kalman filter.

    Args:
        controller: Compensator.
        period: Control period, s.
        limits: Limits of fields of the measurement, see `MeasurementGuard`.
        on_bad: Safe command after a rejected sample: "hold" or "zero".
    """
    title = "Friction compensation of a reaction wheel with a Kalman filter of its speed"
    return _loop("compensator", title, controller, period, limits, on_bad)


def controller(
    law: CurrentMode, period: float, limits: Limits = None, on_bad: str = "hold"
) -> Target:
    """Flight module of the attitude law alone; for the arguments see `compensator`."""
    title = "Attitude law of one axis, which commands a motor current"
    return _loop("controller", title, law, period, limits, on_bad)


def estimator(
    filter: FrictionScaleFilter, period: float, limits: Limits = None, on_bad: str = "hold"
) -> Target:
    """Flight module that estimates speed and friction level from current and tachometer.

    Args:
        filter: Estimator.
        period: Sample period, s.
        limits: Limits of `current` and `measured`, see `MeasurementGuard`.
        on_bad: Current that replaces a rejected one: "hold" (the last accepted one) or "zero". A
            rejected speed is ignored.
    """
    random = np.random.default_rng(0)
    inputs = {
        "current": np.linspace(-0.02, 0.1, STEPS),
        "measured": np.linspace(-1.0, 2.0, STEPS) + 0.1 * random.standard_normal(STEPS),
    }
    inputs["current"][7], inputs["measured"][[15, 16]] = np.nan, np.inf
    guard = entries.EstimatorGuard.of(limits, on_bad)
    estimate, check = as_arrays((filter.start(0.0), guard.start()))
    names = ("estimate", "check")
    return flight_module(
        "estimator",
        {"filter": filter, "guard": guard},
        {"estimate": estimate, "check": check},
        [("start", entries.tracking(guard), names)],
        [
            ("predict", entries.predict, (*names, "current_report")),
            ("correct", entries.correct, (*names, "measured_report")),
            ("friction", entries.friction, ("torque", "sigma")),
        ],
        title="Speed and friction level of a reaction wheel from its current and tachometer",
        period=period,
        constants={"period": period, "speed": -1.0},
        inputs=inputs,
        # and one of a period that needs too many segments
        cases=(
            *_landing("filter.wheel", "speed", {"current": 0.0}),
            {"period": 1e6, "speed": 100.0, "current": 0.1},
        ),
        units={**UNITS, "measured": "rad/s", "torque": "N·m", "sigma": "N·m"},
        on_bad=on_bad,
        untested=("torque", "sigma"),
    )


def wheel(model: Wheel, period: float) -> Target:
    """Flight module of the wheel itself with its dry friction, for simulation."""
    return flight_module(
        "wheel",
        {"wheel": model},
        {},
        [],
        [("step", entries.move, ("speed", "resolved"))],
        title="A reaction wheel with dry friction that sticks, breaks away and crosses zero speed",
        period=period,
        constants={"speed": -1.0, "slope": 0.0, "duration": period},
        inputs={"current": 0.1 * np.sin(0.2 * np.arange(STEPS))},
        units=UNITS,
        cases=_touching(),
    )


def _named(place: str, inertia: float, friction: Mapping[str, float]) -> dict[str, float]:
    """Values of a wheel by their names in C; a law of friction without these has no such case."""
    values = {f"{place}.friction.{name}": value for name, value in friction.items()}
    return values | {f"{place}.inertia": inertia, f"{place}.motor_constant": 1.0}


def _touching() -> tuple[Mapping[str, float], ...]:
    """Cases of a wheel whose speed falls to zero, exactly or nearly, and rises again.

    Without friction the speed is 1/4 - t + t^2, which is zero at t = 1/2 only. With a little
    viscous friction, the parabola through both ends of the step is below zero there, but not the
    speed.
    """
    friction = {"viscous": 0.0, "coulomb": 0.0, "static_": 0.0, "stribeck_speed": 1.0}
    exact = _named("wheel", 1.0, friction)
    exact |= {"speed": 0.25, "current": -1.0, "slope": 2.0, "duration": 1.0}
    return exact, exact | {"wheel.friction.viscous": 0.1, "speed": 0.25425}


def _landing(
    place: str, speed: str, others: Mapping[str, float]
) -> tuple[Mapping[str, float], Mapping[str, float]]:
    """Cases of a wheel that friction stops within a period.

    Coulomb friction stops it exactly at the end: 3 - t / 2 is 0 at 6. A negative Stribeck speed, at
    which friction has another shape, leads Newton's steps to the end out of their bracket.
    """
    friction = {"viscous": 0.0, "coulomb": 0.5, "static_": 0.5, "stribeck_speed": 100.0}
    shape = {"viscous": -1e-3, "static_": 14.5, "stribeck_speed": -0.5}
    exact, outside = (_named(place, 1.0, friction | change) for change in ({}, shape))
    motion = {speed: 3.0, "period": 6.0, **others}
    return exact | motion, outside | motion


def compensated_wheel(
    unit: CompensatedWheel, period: float, limits: Limits = None, on_bad: str = "hold"
) -> Target:
    """Flight module of the wheel with its compensator, for simulation; see `compensator`."""
    guard = MeasurementGuard.of(unit.guard.sample, limits, on_bad)
    unit = unit if limits is None and on_bad == "hold" else replace(unit, guard=guard)
    measured = _measurements()
    return flight_module(
        "compensated_wheel",
        {"unit": unit},
        {"state": as_arrays(unit.start(0.0, period))},
        [("start", entries.at_speed, ("state",))],
        [("step", entries.carry_on, ("state", "output"))],
        title="A reaction wheel with dry friction and its compensator",
        period=period,
        constants={"period": period, "initial_speed": -1.0},
        inputs={"measurement": BodyMeasurement(measured.attitude, measured.rate)},
        cases=_landing("unit.wheel", "initial_speed", {"unit.compensator.law.torque_limit": 0.0}),
        units=UNITS,
        on_bad=on_bad,
        untested=("state.speed", "output.torque", "output.speed"),
    )
