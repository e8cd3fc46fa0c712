"""Sensor faults of a scenario, and validation of its measurements."""

from collections.abc import Mapping
from math import inf
from typing import Any

from gyrostat.control import FieldLimits, Guarded, MeasurementGuard
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.scenario.component import Options
from gyrostat.scenario.event_kind import SensorFailure
from gyrostat.scenario.kinds.events import events_of
from gyrostat.scenario.schema import Key
from gyrostat.scenario.structure import Structure, measured_names
from gyrostat.spacecraft import FaultySensor, SensorFault

Values = Mapping[str, Scalar]
"""Key -> number, SI."""


def options_of(values: Values, section: str) -> dict[str, Scalar]:
    """Values of a section; the name of the section is removed from the keys."""
    return {
        key.removeprefix(f"{section}."): value
        for key, value in values.items()
        if key.startswith(f"{section}.")
    }


def arrays_of(values: Values, section: str, keys: Mapping[str, Key]) -> Options:
    """Values of some keys of a section; those of the components of an array as one array."""
    arrays = {}
    for name, key in keys.items():
        parts = [values[end] for end in key.ends(f"{section}.{name}")]
        arrays[name] = parts[0]
        if key.shape:
            numbers = [jnp.asarray(part, dtype=float) for part in parts]
            arrays[name] = jnp.stack(numbers).reshape(key.shape)
    return arrays


def with_faults(structure: Structure, values: Values, sensor: Any) -> Any:
    """Add the sensor faults of a scenario's events; without faults, the sensor is unchanged."""
    faults = tuple(
        SensorFault(
            field=event.sensor,
            kind=kind.fault,
            **options_of(values, f"event.{event.name}"),
            element=event.element,
        )
        for event, kind in events_of(structure.events, SensorFailure)
        if event.sensor is not None
    )
    return FaultySensor(sensor, faults) if faults else sensor


def first_measurement(sensor: Any, start: Any, period: Scalar) -> Any:
    """Measurement at time 0 with one draw of the noise.

    Args:
        sensor: Sensor of the loop.
        start: State at time 0.
        period: Control period, s.
    """
    return sensor(sensor.start(start, period), start, jax.random.key(0))[1]


def limits_of(structure: Structure, values: Values, sample: Any) -> dict[str, FieldLimits]:
    """Limits of each real measured field, as the scenario gives them; infinite where it does not.

    Args:
        structure: Structure of the scenario.
        values: Values of this run.
        sample: A measurement, or its shapes.
    """
    options, limits = options_of(values, "guard"), {}
    for name in measured_names(structure):
        if jnp.issubdtype(getattr(sample, name).dtype, jnp.floating):
            lower, upper = options.get(f"{name}_lower", -inf), options.get(f"{name}_upper", inf)
            rate = options[f"{name}_change"] if name in structure.limited else None
            limits[name] = FieldLimits(lower, upper, rate)
    return limits


def guarded(structure: Structure, values: Values, controller: Any, sensor: Any, start: Any) -> Any:
    """Add the measurement guard of a scenario; without guard, the controller is unchanged.

    Args:
        structure: Structure of the scenario.
        values: Values of this run.
        controller: Controller.
        sensor: Sensor of the loop.
        start: State at time 0.
    """
    if structure.guard is None:
        return controller
    shapes = jax.eval_shape(lambda: first_measurement(sensor, start, values["run.control_period"]))
    guard = MeasurementGuard.of(shapes, limits_of(structure, values, shapes), structure.guard)
    actuators = tuple(part.name for part in structure.parts if part.section == "actuator")
    return Guarded(controller, guard, actuators)
