"""Build the spacecraft of a run, its wheel failures and friction steps from a scenario."""

from functools import partial
from typing import Any

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.scenario.event_kind import FrictionChange, WheelFailure
from gyrostat.scenario.kinds.events import events_of
from gyrostat.scenario.scenario import AXES, INERTIA
from gyrostat.scenario.sensing import Values, options_of
from gyrostat.scenario.structure import Structure
from gyrostat.spacecraft import FrictionSteps, Spacecraft, Surfaces, WheelFailures
from gyrostat.wheel import WheelArray
from gyrostat.wheel.friction import AnyFriction
from gyrostat.wheel.friction_laws import law_of


def of_wheels(structure: Structure, values: Values, name: str) -> Any:
    """Values of one key for all wheels, (wheels,)."""
    return jnp.stack([jnp.asarray(values[f"wheel.{w}.{name}"]) for w in structure.wheels])


def has_section(structure: Structure, name: str) -> bool:
    """Whether the scenario has the optional section with this wheel key."""
    return f"wheel.{structure.wheels[0]}.{name}" in structure.keys


def spacecraft_of(structure: Structure, values: Values) -> Spacecraft:
    """Spacecraft with the given values."""
    xx, yy, zz, xy, xz, yz = (values[f"body.inertia.{end}"] for end in INERTIA)
    rows = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    per_wheel = partial(of_wheels, structure, values)
    model = law_of(structure.friction, structure.sources)
    wheels = WheelArray(
        axes=jnp.asarray(structure.axes).T,
        inertia=per_wheel("inertia"),
        torque_limit=per_wheel("torque_limit"),
        momentum_limit=per_wheel("momentum_limit"),
        friction=model.of(**{name: per_wheel(name) for name in model.dimensions()}),
    )
    inertia = jnp.stack([jnp.stack(jax.tree.map(jnp.asarray, row)) for row in rows])
    centre = None
    if "body.centre_of_mass.x" in structure.keys:
        centre = jnp.stack([jnp.asarray(values[f"body.centre_of_mass.{axis}"]) for axis in AXES])
    surfaces = Surfaces.of_rows(np.array(structure.surfaces)) if structure.surfaces else None
    return Spacecraft(inertia, wheels, values.get("body.mass"), centre, surfaces)


def failures_of(structure: Structure, values: Values) -> WheelFailures | None:
    """Wheel failures of the scenario's events; None if there are none."""
    pairs = events_of(structure.events, WheelFailure)
    if not pairs:
        return None
    failures = WheelFailures.none(len(structure.wheels))
    defaults = {"torque_share": 1.0, "stuck_torque": 0.0, "sensor_lost": False}
    for event, kind in pairs:
        options = options_of(values, f"event.{event.name}")
        index = jnp.arange(len(structure.wheels)) == event.wheel
        failure = WheelFailures(
            time=options["time"],
            seized=kind.stops_rotor,
            added_viscous=options.get("added_viscous", 0.0),
            **(defaults | kind.of(options).effect()),
        )
        failures = jax.tree.map(
            lambda new, old, mask=index: jnp.where(mask, new, old), failure, failures
        )
    return failures


def friction_steps_of(
    structure: Structure, values: Values, before: AnyFriction
) -> FrictionSteps | None:
    """Friction steps of the scenario's events; None if there are none."""
    pairs = events_of(structure.events, FrictionChange)
    if not pairs:
        return None
    time, dimensions = jnp.full(len(structure.wheels), jnp.inf), before.dimensions()
    length = jnp.zeros(time.shape)
    after = before.parameters()
    for event, kind in pairs:
        options = options_of(values, f"event.{event.name}")
        change = kind.of(options)
        index = jnp.arange(len(structure.wheels)) == event.wheel
        time = jnp.where(index, options["time"], time)
        length = jnp.where(index, options.get("rise_time", 0.0), length)
        for name, dimension in dimensions.items():
            value = change.after(name, dimension, after[name], options)
            after[name] = jnp.where(index, value, after[name])
    return FrictionSteps(time, type(before).of(**after), length)
