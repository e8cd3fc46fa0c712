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
        given = dict(limits or {})
        for name in given:
            if name not in ("current", "measured"):
                raise InputError(
                    f"limits of a measurement: found {name}, expected current or measured"
                )
        checked = [{n: given[n]} if n in given else {} for n in ("current", "measured")]
        return cls(
            MeasurementGuard.of(AppliedCurrent(0.0), checked[0], on_bad),
            MeasurementGuard.of(MeasuredSpeed(0.0), checked[1], on_bad),
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
    jaxpr = jax.make_jaxpr(lambda seen: controller(memory, seen))(measurement).jaxpr
    used = {id(atom) for equation in jaxpr.eqns for atom in equation.invars}
    names = zip(measurement._fields, jaxpr.invars, strict=True)
    read = [name for name, variable in names if id(variable) in used]
    for name in limits or {}:
        if name not in read:
            raise InputError(
                f"limits of a measurement: found {name}, expected one of {', '.join(read)}"
            )
    guard = MeasurementGuard.of(measurement, limits, on_bad)
    kept = {name: limit for name, limit in guard.limits.items() if name in read}
    return MeasurementGuard(kept, on_bad, guard.sample)


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
    seen = guard.current(check.current, AppliedCurrent(current), period)
    last = check.current.last.current
    safe = last if guard.current.on_bad == "hold" else jnp.zeros_like(last)
    used = jnp.where(seen.good, seen.measurement.current, safe)
    estimate, status = _kept(filter.predict(estimate, used, period), estimate, seen)
    after = jax.tree.map(lambda a, b: jnp.where(seen.good, a, b), seen.used, seen.missed)
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
    seen = guard.measured(check.measured, MeasuredSpeed(measured), period)
    # the filter counts NaN as a missed sample
    used = jnp.where(seen.good, seen.measurement.measured, jnp.nan)
    estimate, status = _kept(filter.correct(estimate, used), estimate, seen)
    after = jax.tree.map(lambda a, b: jnp.where(seen.good, a, b), seen.used, seen.missed)
    return estimate, check._replace(measured=after), SampleReport(status, after.samples_missed)


def _kept(new: Any, old: Any, seen: Validated) -> tuple[Any, Any]:
    """New estimate if it is finite, otherwise the old one; and the status."""
    stays = finite(new)
    status = jnp.where(seen.good & ~stays, int(SampleStatus.NOT_COMPUTED), seen.status)
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
