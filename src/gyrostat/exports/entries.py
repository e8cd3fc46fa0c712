"""Functions of the emitted modules, in Python."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, NamedTuple, Self

import equinox as eqx

from gyrostat.control import FieldLimits, Guarded, MeasurementGuard, SampleStatus
from gyrostat.control.guarded import finite
from gyrostat.control.measurement_guard import GuardMemory, SampleReport, Validated
from gyrostat.core.arrays import Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import FrictionScaleFilter
from gyrostat.exports.compensated_wheel import CompensatedWheel
from gyrostat.wheel import Wheel, advance


class AppliedCurrent(NamedTuple):
    """Input of the estimator.

    Attributes:
        current: Motor current, A.
    """

    current: Annotated[Scalar, "A"]


class MeasuredSpeed(NamedTuple):
    """Measurement of the estimator.

    Attributes:
        measured: Wheel speed, rad/s.
    """

    measured: Annotated[Scalar, "rad/s"]


class EstimatorCheck(NamedTuple):
    """State of the validation of an estimator's inputs.

    Attributes:
        current: State of the validation of the current.
        measured: State of the validation of the measured speed.
    """

    current: GuardMemory
    measured: GuardMemory


class EstimatorGuard(eqx.Module):
    """Limits of an estimator's inputs.

    Attributes:
        current: Validation of the current.
        measured: Validation of the measured speed.
    """

    current: MeasurementGuard
    measured: MeasurementGuard

    @classmethod
    def of(cls, limits: Mapping[str, FieldLimits] | None, on_bad: str) -> Self:
        """Guard with the given limits.

        Args:
            limits: Limits of `current` and `measured`.
            on_bad: Current that replaces a rejected one: "hold" or "zero".

        Raises:
            InputError: Limits are given for another name.
        """
        by_name = dict(limits or {})
        for name in by_name:
            if name not in ("current", "measured"):
                raise InputError(
                    f"limits of a measurement: found {name}, expected current or measured"
                )
        groups = [{n: by_name[n]} if n in by_name else {} for n in ("current", "measured")]
        return cls(
            MeasurementGuard.of(AppliedCurrent(0.0), groups[0], on_bad),
            MeasurementGuard.of(MeasuredSpeed(0.0), groups[1], on_bad),
        )

    def start(self) -> EstimatorCheck:
        """State before the first input is accepted."""
        return EstimatorCheck(self.current.start(), self.measured.start())


def guard_of(
    controller: Any,
    period: float,
    measurement: Any,
    limits: Mapping[str, FieldLimits] | None,
    on_bad: str,
) -> MeasurementGuard:
    """Guard for the fields of a measurement that a controller reads.

    Args:
        controller: Controller of the loop.
        period: Control period, s.
        measurement: Example, each field one number.
        limits: Limits of some fields.
        on_bad: Safe command, "hold" or "zero".

    Raises:
        InputError: Limits are given for a field that is not read.
    """
    memory = controller.start(period)
    jaxpr = jax.make_jaxpr(lambda sample: controller(memory, sample))(measurement).jaxpr
    operands = {id(atom) for equation in jaxpr.eqns for atom in equation.invars}
    names = zip(measurement._fields, jaxpr.invars, strict=True)
    read_names = [name for name, variable in names if id(variable) in operands]
    for name in limits or {}:
        if name not in read_names:
            raise InputError(
                f"limits of a measurement: found {name}, expected one of {', '.join(read_names)}"
            )
    guard = MeasurementGuard.of(measurement, limits, on_bad)
    read_limits = {name: limit for name, limit in guard.limits.items() if name in read_names}
    return MeasurementGuard(read_limits, on_bad, guard.sample)


def starting(guard: MeasurementGuard) -> Callable[[Any, Any], Any]:
    """Function that creates the state before the first measurement."""

    def begin(controller: Any, period: Any) -> Any:
        """Set the state before the first measurement; the period is in s."""
        return Guarded(controller, guard).start(period)

    return begin


def command(controller: Any, guard: MeasurementGuard, memory: Any, measurement: Any) -> Any:
    """Validate a measurement and compute the command; call once in every control period."""
    return Guarded(controller, guard).step(memory, measurement)


def tracking(guard: EstimatorGuard) -> Callable[[FrictionScaleFilter, Any], Any]:
    """Function that creates the estimate before the first measurement."""

    def track(filter: FrictionScaleFilter, speed: Any) -> Any:
        """Initialise the estimate at a wheel speed, rad/s."""
        return filter.start(speed), guard.start()

    return track


def predict(
    filter: FrictionScaleFilter,
    guard: EstimatorGuard,
    estimate: Any,
    check: EstimatorCheck,
    current: Any,
    period: Any,
) -> Any:
    """Validate a current, A, and predict the estimate over the period, s, for which it was held."""
    sample = guard.current(check.current, AppliedCurrent(current), period)
    last_current = check.current.last.current
    safe = last_current if guard.current.on_bad == "hold" else jnp.zeros_like(last_current)
    drive = jnp.where(sample.good, sample.measurement.current, safe)
    estimate, status = _update(filter.predict(estimate, drive, period), estimate, sample)
    after = jax.tree.map(lambda a, b: jnp.where(sample.good, a, b), sample.used, sample.missed)
    return estimate, check._replace(current=after), SampleReport(status, after.samples_missed)


def correct(
    filter: FrictionScaleFilter,
    guard: EstimatorGuard,
    estimate: Any,
    check: EstimatorCheck,
    measured: Any,
    period: Any,
) -> Any:
    """Validate a measured speed, rad/s, and correct the estimate; a rejected speed is ignored."""
    sample = guard.measured(check.measured, MeasuredSpeed(measured), period)
    # the filter counts NaN as a missed sample
    speed = jnp.where(sample.good, sample.measurement.measured, jnp.nan)
    estimate, status = _update(filter.correct(estimate, speed), estimate, sample)
    after = jax.tree.map(lambda a, b: jnp.where(sample.good, a, b), sample.used, sample.missed)
    return estimate, check._replace(measured=after), SampleReport(status, after.samples_missed)


def _update(new: Any, old: Any, sample: Validated) -> tuple[Any, Any]:
    """New estimate if it is finite, otherwise the old one; and the status."""
    stays = finite(new)
    status = jnp.where(sample.good & ~stays, int(SampleStatus.NOT_COMPUTED), sample.status)
    return jax.tree.map(lambda a, b: jnp.where(stays, a, b), new, old), status


def friction(filter: FrictionScaleFilter, estimate: Any) -> Any:
    """Friction torque of the turning wheel and its standard deviation, N·m."""
    return filter.friction(estimate)


def move(wheel: Wheel, speed: Any, current: Any, slope: Any, duration: Any) -> Any:
    """Propagate a wheel's speed, rad/s, over a time, s, with a current, A, and its slope, A/s."""
    return advance(wheel, speed, current, slope, duration)


def at_speed(unit: CompensatedWheel, initial_speed: Any, period: Any) -> Any:
    """Set the state at a wheel speed, rad/s; the control period is in s."""
    return unit.start(initial_speed, period)


def carry_on(unit: CompensatedWheel, state: Any, measurement: Any) -> Any:
    """Read attitude and rate of the body and propagate the wheel over one control period."""
    return unit(state, measurement)
