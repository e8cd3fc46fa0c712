"""Faults of the sensors of a scenario, and the validation of what they measure."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gyrostat.campaigns.scenario import Scenario
from gyrostat.campaigns.schema import MEASURED, SENSOR_FAULT
from gyrostat.control import FieldLimits, Guarded, MeasurementGuard
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax
from gyrostat.spacecraft import FaultySensor, SensorFault

Values = Mapping[str, Scalar]
"""Key -> number, SI."""


def options_of(values: Values, section: str) -> dict[str, Scalar]:
    """Values of a section, without its name in their keys."""
    return {
        key.removeprefix(f"{section}."): value
        for key, value in values.items()
        if key.startswith(f"{section}.")
    }


def with_faults(scenario: Scenario, values: Values, sensor: Any) -> Any:
    """A sensor with the faults that the events of a scenario name; itself where there is none."""
    faults = tuple(
        SensorFault(
            field=event.sensor,
            kind=event.kind.removeprefix(SENSOR_FAULT),
            **options_of(values, f"event.{event.name}"),
            element=event.element,
        )
        for event in scenario.events
        if event.sensor is not None
    )
    return FaultySensor(sensor, faults) if faults else sensor


def guarded(scenario: Scenario, values: Values, controller: Any, sensor: Any, start: Any) -> Any:
    """A controller behind the guard of a scenario; itself where there is none.

    Args:
        scenario: What flies.
        values: Of this run.
        controller: Any.
        sensor: That it works with.
        start: State at time 0.
    """
    if scenario.guard is None:
        return controller
    own = options_of(values, "guard")

    def measured() -> Any:
        memory = sensor.start(start, values["run.control_period"])
        return sensor(memory, start, jax.random.key(0))[1]

    limits = {}
    for name in MEASURED:
        # decided by the nominal value: a limit is there in all runs or in none
        limited = np.isfinite(scenario.values.get(f"guard.{name}_change", np.inf))
        rate = own[f"{name}_change"] if limited else None
        limits[name] = FieldLimits(own[f"{name}_lower"], own[f"{name}_upper"], rate)
    guard = MeasurementGuard.of(jax.eval_shape(measured), limits, scenario.guard)
    return Guarded(controller, guard)
