"""Flight module of the controller of a scenario, with estimator, compensator and guard."""

from dataclasses import replace
from typing import Any

import numpy as np

from gyrostat.codegen.evaluation import evaluated
from gyrostat.control import FieldLimits, MeasurementGuard
from gyrostat.control.measurement_guard import UNLIMITED
from gyrostat.core.jax64 import jax, jnp
from gyrostat.exports.target import STEPS, Target
from gyrostat.exports.targets import flight_loop
from gyrostat.runs.phases import Phases
from gyrostat.runs.plans import plans_of, setup_of
from gyrostat.scenario.kinds.orbits import PHASE, has_own_orbits, nominal_orbit
from gyrostat.scenario.kinds.registry import chosen
from gyrostat.scenario.reference_kind import POSITION_ERROR
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.sensing import first_measurement, limits_of
from gyrostat.scenario.structure import measured_names, structure_of

MARGIN = 1.1
"""Limit of a measured value over the largest that its sensor gives."""


def scenario_controller(scenario: Scenario, on_bad: str) -> Target:
    """Flight module of the controller that a scenario names, user-defined parts included.

    The module has the estimator and the compensator of the scenario, and its limits of
    measurements. Where the scenario gives none, the data of the sensors do, with `MARGIN`: a
    quaternion has elements of up to 1, a gyro has a largest rate. Events and dispersions have no
    effect: the controller is that of the first phase.

    Args:
        scenario: Scenario.
        on_bad: Safe command after a rejected sample if the scenario has no [guard]: "hold" or
            "zero".

    Raises:
        InputError: A part refuses its parameters.
    """
    # the error of the position belongs to the run, not to the controller
    prefixes = (POSITION_ERROR, *(f"event.{event.name}." for event in scenario.events))
    values = {k: v for k, v in scenario.values.items() if not k.startswith(prefixes)}
    if has_own_orbits(scenario.dispersed):
        values[PHASE] = 0.0  # the tables of the nominal run start there
    nominal = replace(scenario, events=(), dispersions=(), guard=None, values=values)
    # without dispersions, the tables would have other splines than those of the campaign
    plans = plans_of(nominal)._replace(orbit=nominal_orbit(scenario))
    setup = setup_of(nominal, plans)
    period = scenario.values["run.control_period"]
    sample = _first_measurement(setup.sensor, setup.start, period)
    limits, largest = limits_of(structure_of(scenario), scenario.values, sample), _largest(scenario)
    ranges = []
    for name, (lower, upper, rate) in limits.items():
        size = MARGIN * largest[name] if name in largest else UNLIMITED
        if name in largest and not (np.isfinite(lower) and np.isfinite(upper)):
            ranges.append(f"`{name}` ±{size:g} ({MARGIN:g} times its largest size)")
        limits[name] = FieldLimits(
            lower if np.isfinite(lower) else -size, upper if np.isfinite(upper) else size, rate
        )
    guard = MeasurementGuard.of(sample, limits, scenario.guard or on_bad)
    wrappers = (scenario.estimator, scenario.unloading, scenario.compensator)
    kinds = [kind for kind in wrappers if kind != "none"]
    title = f"Attitude control of {scenario.name}: {', '.join([*kinds, scenario.controller])}"
    controller = setup.controller
    if not chosen(scenario, "reference").moves:
        controller = jax.tree.map(
            lambda part: _at_start(part) if _is_phases(part) else part,
            controller,
            is_leaf=_is_phases,
        )
    target = flight_loop("controller", title, controller, period, guard, _test_run(sample))
    return replace(
        target,
        digests={"scenario": f"SHA-256 {scenario.digest()}"},
        ranges=tuple(ranges),
    )


def _largest(scenario: Scenario) -> dict[str, float]:
    """Largest sizes of measured values by the data of the sensors, in SI units."""
    sizes = {"attitude": 1.0, "rate": scenario.values.get("sensors.rate_limit", np.inf)}
    names = measured_names(scenario)
    return {name: size for name, size in sizes.items() if name in names and np.isfinite(size)}


def _is_phases(part: Any) -> bool:
    return isinstance(part, Phases)


_first_measurement = evaluated(first_measurement)
_at_start = evaluated(lambda phases: phases.at(0.0))


def _test_run(sample: Any) -> Any:
    """Measurements of a test run: small oscillations about the first sample, three bad samples."""
    step = np.arange(STEPS)

    def vary(leaf: Any) -> Any:
        value = np.asarray(leaf)
        rows = np.repeat(value[None], STEPS, axis=0)
        if value.dtype.kind != "f":
            return jnp.asarray(rows)
        phase = np.arange(value.size).reshape(value.shape)
        size = 1e-3 * np.maximum(1.0, np.abs(value))
        rows = rows + size * np.sin(0.3 * step.reshape(-1, *[1] * value.ndim) + phase)
        rows[[7, 15, 16]] = np.reshape([np.nan, np.inf, -np.inf], (3, *[1] * value.ndim))
        return jnp.asarray(rows)

    return jax.tree.map(vary, sample)
