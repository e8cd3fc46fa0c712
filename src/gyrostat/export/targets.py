"""What of a wheel model can fly: the functions, their state and a run to test them with."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gyrostat._jax import jax, jnp
from gyrostat.body import TableMeasurement
from gyrostat.control import (
    CurrentMode,
    EstimatingCompensator,
    FieldLimits,
    Guarded,
    MeasurementGuard,
)
from gyrostat.estimate import FrictionScaleFilter
from gyrostat.export.compensated_wheel import BodyMeasurement, CompensatedWheel
from gyrostat.export.module import Entry
from gyrostat.lowering.tracing import as_arrays
from gyrostat.wheel import Wheel, advance

STEPS = 40
"""Of the run that a test program repeats."""
Limits = Mapping[str, FieldLimits] | None
"""Name of a measured field -> its limits; None: values are only tested to be finite."""
UNITS = {
    "speed": "rad/s",
    "initial_speed": "rad/s",
    "current": "A",
    "slope": "A/s",
    "duration": "s",
    "period": "s",
}


@dataclass(frozen=True)
class Target:
    """What is emitted as one module.

    Attributes:
        name: of the module, and first word of its functions.
        title: one line.
        period: s, that the numbers were tuned for.
        begin: functions called once, in this order.
        steps: functions called once in every period, in this order.
        constants: name -> value of arguments that stay.
        inputs: name -> value of arguments that change, first axis the step, for a test run.
        units: name -> unit of arguments and results that are single numbers.
    """

    name: str
    title: str
    period: float
    begin: tuple[Entry, ...]
    steps: tuple[Entry, ...]
    constants: Mapping[str, Any]
    inputs: Mapping[str, Any]
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def entries(self) -> tuple[Entry, ...]:
        """All functions."""
        return (*self.begin, *self.steps)

    def run(self) -> list[dict[str, Any]]:
        """What Python says in the test run: name -> value of all results, one for each step."""
        values = {name: as_arrays(value) for name, value in self.constants.items()}
        # what is called once is not worth compiling
        called = {entry.name: entry.function for entry in self.begin}
        called |= {entry.name: jax.jit(entry.function) for entry in self.steps}
        made = []

        def call(entry: Entry) -> None:
            results = called[entry.name](*(values[name] for name in entry.arguments))
            several = results if len(entry.results) > 1 else (results,)
            values.update(zip(entry.results, several, strict=True))

        for entry in self.begin:
            call(entry)
        for step in range(STEPS):
            values |= {n: jax.tree.map(lambda x, k=step: x[k], v) for n, v in self.inputs.items()}
            for entry in self.steps:
                call(entry)
            names = dict.fromkeys(name for entry in self.steps for name in entry.results)
            made.append({name: values[name] for name in names})
        return made


def starting(guard: MeasurementGuard) -> Callable[[Any, Any], Any]:
    """The function that makes the state before the first measurement."""

    def begin(controller: Any, period: Any) -> Any:
        """Set the state before the first measurement; the period is in s."""
        return Guarded(controller, guard).start(period)

    return begin


def command(controller: Any, guard: MeasurementGuard, memory: Any, measurement: Any) -> Any:
    """Validate a measurement, give a command; once in every control period."""
    return Guarded(controller, guard).step(memory, measurement)


def track(filter: FrictionScaleFilter, speed: Any) -> Any:
    """Begin about a wheel speed, rad/s."""
    return filter.start(speed)


def predict(filter: FrictionScaleFilter, estimate: Any, current: Any, period: Any) -> Any:
    """Carry the estimate over a period, s, in which the current, A, was held."""
    return filter.predict(estimate, current, period)


def correct(filter: FrictionScaleFilter, estimate: Any, measured: Any) -> Any:
    """Take in a measured speed, rad/s; one that is not finite is counted and left out."""
    return filter.correct(estimate, measured)


def friction(filter: FrictionScaleFilter, estimate: Any) -> Any:
    """Friction torque of the turning wheel and its standard deviation, N·m."""
    return filter.friction(estimate)


def move(wheel: Wheel, speed: Any, current: Any, slope: Any, duration: Any) -> Any:
    """Carry a wheel's speed, rad/s, over a time, s, of a current, A, with a slope, A/s."""
    return advance(wheel, speed, current, slope, duration)


def at_speed(unit: CompensatedWheel, initial_speed: Any, period: Any) -> Any:
    """Set the state at a wheel speed, rad/s; the control period is in s."""
    return unit.start(initial_speed, period)


def carry_on(unit: CompensatedWheel, state: Any, measurement: Any) -> Any:
    """Take in attitude and rate of the body, carry the wheel over one control period."""
    return unit(state, measurement)


def _parameters(name: str, **values: Any) -> Entry:
    def parameters() -> Any:
        every = tuple(values.values())
        return every if len(every) > 1 else every[0]

    parameters.__doc__ = "Set the parameters to the values that were identified and tuned."
    return Entry(f"{name}_parameters", parameters, {}, tuple(values))


def _measurements() -> TableMeasurement:
    """A table that swings a little while its wheel goes through zero speed; three bad samples."""
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
    first = jax.tree.map(lambda x: x[0], measured)
    guard = MeasurementGuard.of(first, limits, on_bad)
    memory = as_arrays(Guarded(controller, guard).start(period))
    return Target(
        name=name,
        title=title,
        period=period,
        begin=(
            _parameters(name, controller=controller, guard=guard),
            Entry(
                f"{name}_start",
                starting(guard),
                {"controller": controller, "period": 0.0},
                ("memory",),
            ),
        ),
        steps=(
            Entry(
                f"{name}_step",
                command,
                {"controller": controller, "guard": guard, "memory": memory, "measurement": first},
                ("memory", "command", "report"),
            ),
        ),
        constants={"period": period},
        inputs={"measurement": measured},
        units=UNITS,
    )


def compensator(
    controller: EstimatingCompensator, period: float, limits: Limits = None, on_bad: str = "hold"
) -> Target:
    """Friction compensation with its Kalman filter.

    Args:
        controller: The compensator.
        period: Control period, s.
        limits: Of fields of the measurement, see `MeasurementGuard`.
        on_bad: Safe command in place of one from a rejected sample: "hold" or "zero".
    """
    title = "Friction compensation of a reaction wheel, its speed estimated by a Kalman filter"
    return _loop("compensator", title, controller, period, limits, on_bad)


def controller(
    law: CurrentMode, period: float, limits: Limits = None, on_bad: str = "hold"
) -> Target:
    """The attitude law alone; for the arguments see `compensator`."""
    title = "Attitude law of one axis, a current as its command"
    return _loop("controller", title, law, period, limits, on_bad)


def estimator(filter: FrictionScaleFilter, period: float) -> Target:
    """Speed and health of a wheel from its current and tachometer."""
    estimate, current = as_arrays(filter.start(0.0)), {"current": 0.0, "period": 0.0}
    known = {"filter": filter, "estimate": estimate}
    random = np.random.default_rng(0)
    return Target(
        name="estimator",
        title="Speed and friction level of a reaction wheel from its current and tachometer",
        period=period,
        begin=(
            _parameters("estimator", filter=filter),
            Entry("estimator_start", track, {"filter": filter, "speed": 0.0}, ("estimate",)),
        ),
        steps=(
            Entry("estimator_predict", predict, {**known, **current}, ("estimate",)),
            Entry("estimator_correct", correct, {**known, "measured": 0.0}, ("estimate",)),
            Entry("estimator_friction", friction, known, ("torque", "sigma")),
        ),
        constants={"period": period, "speed": -1.0},
        inputs={
            "current": np.linspace(-0.02, 0.1, STEPS),
            "measured": np.linspace(-1.0, 2.0, STEPS) + 0.1 * random.standard_normal(STEPS),
        },
        units={**UNITS, "measured": "rad/s", "torque": "N·m", "sigma": "N·m"},
    )


def wheel(model: Wheel, period: float) -> Target:
    """The wheel itself, dry friction and all, to simulate with."""
    return Target(
        name="wheel",
        title="A reaction wheel with dry friction that sticks, breaks away and crosses zero speed",
        period=period,
        begin=(_parameters("wheel", wheel=model),),
        steps=(
            Entry(
                "wheel_step",
                move,
                {"wheel": model, "speed": 0.0, "current": 0.0, "slope": 0.0, "duration": 0.0},
                ("speed", "resolved"),
            ),
        ),
        constants={"speed": -1.0, "slope": 0.0, "duration": period},
        inputs={"current": 0.1 * np.sin(0.2 * np.arange(STEPS))},
        units=UNITS,
    )


def compensated_wheel(unit: CompensatedWheel, period: float) -> Target:
    """The wheel and its compensator as one piece, to simulate with."""
    name, measured = "compensated_wheel", _measurements()
    body = BodyMeasurement(measured.attitude, measured.rate)
    known = {"unit": unit, "state": as_arrays(unit.start(0.0, period))}
    first = jax.tree.map(lambda x: x[0], body)
    return Target(
        name=name,
        title="A reaction wheel with dry friction under its compensator",
        period=period,
        begin=(
            _parameters(name, unit=unit),
            Entry(
                f"{name}_start",
                at_speed,
                {"unit": unit, "initial_speed": 0.0, "period": 0.0},
                ("state",),
            ),
        ),
        steps=(
            Entry(f"{name}_step", carry_on, {**known, "measurement": first}, ("state", "output")),
        ),
        constants={"period": period, "initial_speed": -1.0},
        inputs={"measurement": body},
        units=UNITS,
    )


TARGETS: Mapping[str, Callable[..., Target]] = {
    "compensated-wheel": compensated_wheel,
    "compensator": compensator,
    "controller": controller,
    "estimator": estimator,
    "wheel": wheel,
}
"""Name on the command line -> what makes the target."""
