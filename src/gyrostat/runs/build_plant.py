"""Stages that build the plant of a run, its orbit and its state at time 0."""

from dataclasses import fields
from typing import Any

from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import from_rotation_vector, product
from gyrostat.core.user_modules import is_user_kind
from gyrostat.runs.assembly import Assembly, context_of
from gyrostat.runs.build_parts import modes_of_run, named_parts
from gyrostat.scenario.build_spacecraft import (
    failures_of,
    friction_steps_of,
    has_section,
    of_wheels,
    spacecraft_of,
)
from gyrostat.scenario.kinds.orbits import orbit_of_run
from gyrostat.scenario.kinds.registry import component
from gyrostat.scenario.kinds.wheel_disturbances import imbalance_of
from gyrostat.scenario.metrics.budget import Budget
from gyrostat.scenario.schema import START
from gyrostat.scenario.sensing import arrays_of
from gyrostat.spacecraft import (
    ChangingPlant,
    DrivenGyrostat,
    Gyrostat,
    HarmonicTorque,
    ImbalancedGyrostat,
    PlantChange,
)
from gyrostat.wheel import Driver


def add_orbit(run: Assembly) -> dict[str, Any]:
    """Orbit of the run."""
    return {"orbit": orbit_of_run(run.values, run.plans.orbit, run.structure.dispersed)}


def add_body(run: Assembly) -> dict[str, Any]:
    """Spacecraft with environment, actuators, appendages and failures, and the momentum budget."""
    structure, values = run.structure, run.values
    environment = run.component("environment")
    environment_torques = environment.torques()
    craft = spacecraft_of(structure, values)
    steps = friction_steps_of(structure, values, craft.wheels.friction)
    context = context_of(run, "orbit")
    torques = named_parts(structure, values, "environment.torque", context)
    actuators = named_parts(structure, values, "actuator", context)
    plant = Gyrostat(
        craft,
        failures_of(structure, values),
        external_torque=environment.external_torque,
        environment=(*environment_torques, *torques.values()),
        friction_steps=steps,
        actuators=actuators,
        modes=modes_of_run(structure, values, craft),
    )
    all_torques = {"constant": HarmonicTorque(0.0, constant=environment.external_torque)}
    all_torques |= dict(zip(environment.torque_names, environment_torques, strict=True)) | torques
    period = values["run.control_period"]
    budget = Budget(craft, all_torques, actuators, period) if structure.budget else None
    return {"plant": plant, "budget": budget}


def add_motion(run: Assembly) -> dict[str, Any]:
    """Attitude, body rate and wheel speeds at time 0."""
    begin = arrays_of(run.values, "start", START)
    error = from_rotation_vector(begin["attitude_error"])
    motion = {
        "attitude": product(jnp.asarray(run.plans.attitude), error),
        "rate": begin["rate"],
        "wheel_speed": of_wheels(run.structure, run.values, "speed"),
    }
    return {"motion": motion}


def add_of_controller(run: Assembly) -> dict[str, Any]:
    """What belongs to the controller, such as a paddle in the place of the last wheel."""
    return {"plant": run.law.body(run.plant)}


def add_imbalance(run: Assembly) -> dict[str, Any]:
    """Imbalance and harmonics of the wheels."""
    structure, values = run.structure, run.values
    harmonics = named_parts(structure, values, "imbalance.harmonic", context_of(run))
    imbalance = imbalance_of(structure, values, list(harmonics.values()))
    if imbalance is None:
        return {}
    angle = of_wheels(structure, values, "angle")
    return {
        "plant": ImbalancedGyrostat(run.plant, imbalance),
        "motion": {**run.motion, "wheel_angle": angle},
    }


def add_drivers(run: Assembly) -> dict[str, Any]:
    """Motor drivers of the wheels."""
    structure, values = run.structure, run.values
    if not has_section(structure, "motor_constant"):
        return {}
    names = [field.name for field in fields(Driver)]
    # the torque limit is that of the wheel, not of the driver
    numbers = {n: of_wheels(structure, values, n) for n in names if n != "torque_limit"}
    constant = of_wheels(structure, values, "motor_constant")
    return {"plant": DrivenGyrostat(run.plant, Driver(**numbers), constant)}


def add_changes(run: Assembly) -> dict[str, Any]:
    """Changes of the plant by user-defined events."""
    changes = []
    for event in run.structure.events:
        if is_user_kind(event.kind):
            place = f"event.{event.name}"
            kind = component("event", event.kind, run.structure.sources)
            instance = kind.of(arrays_of(run.values, place, kind.keys()))
            change = instance.make(context_of(run)._replace(place=place))
            changes.append(PlantChange(event.name, run.values[f"{place}.time"], change))
    return {"plant": ChangingPlant(run.plant, tuple(changes))} if changes else {}


def add_start(run: Assembly) -> dict[str, Any]:
    """State of the whole plant at time 0."""
    return {"start": run.plant.start(**run.motion)}
