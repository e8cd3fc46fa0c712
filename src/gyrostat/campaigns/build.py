"""Build the plant, controller, sensor and initial state of a run from a scenario."""

from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Array, Float

from gyrostat.campaigns.build_parts import (
    modes_of_run,
    named_parts,
    with_events,
)
from gyrostat.campaigns.build_reference import (
    navigated,
    planned_reference,
    reference_of,
)
from gyrostat.campaigns.build_spacecraft import (
    failures_of,
    friction_steps_of,
    has_section,
    of_wheels,
    spacecraft_of,
)
from gyrostat.campaigns.controllers import IGNORED, NOTIFIED, DesignCase
from gyrostat.campaigns.environments import environment_torques
from gyrostat.campaigns.kinds import check_needs, chosen
from gyrostat.campaigns.metrics.budget import Budget
from gyrostat.campaigns.orbits import orbit_of_run, planned_orbit
from gyrostat.campaigns.phases import Phases, in_orbit
from gyrostat.campaigns.references import PlannedReference
from gyrostat.campaigns.scenario import Event, Scenario
from gyrostat.campaigns.schema import START
from gyrostat.campaigns.sensing import Values, arrays_of, guarded, options_of, with_faults
from gyrostat.campaigns.structure import Structure, notified, structure_of
from gyrostat.campaigns.wheel_disturbances import imbalance_of
from gyrostat.control import AttitudeTargets
from gyrostat.control.guidance import Guided, Reference
from gyrostat.core.arrays import Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import from_rotation_vector, product
from gyrostat.core.validation import check_parts
from gyrostat.spacecraft import (
    AddedSensors,
    DrivenGyrostat,
    Gyrostat,
    ImbalancedGyrostat,
    PaddleGyrostat,
    Spacecraft,
)
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.sensors.star_tracker_heads import StarTrackerHeads
from gyrostat.wheel import Driver


class Setup(NamedTuple):
    """Parts of one run.

    Attributes:
        plant: Spacecraft with the values of the run.
        controller: Controller, planned for the nominal spacecraft.
        sensor: Sensor of the plant.
        start: State of the plant at time 0.
        starts: Start times of the phases, (phases,), s.
        targets: Target attitude of each phase, (phases, 4), scalar first.
        metrics: Own metrics by name.
        reference: Reference attitude at the true position; None for the targets of the phases.
        budget: Momentum budget; None unless it is requested.
    """

    plant: Any
    controller: Any
    sensor: Any
    start: Any
    starts: Float[Array, " phases"]
    targets: Float[Array, "phases 4"]
    metrics: dict[str, Any]
    reference: Reference | None = None
    budget: Budget | None = None


class Plans(NamedTuple):
    """Controller designs of a scenario, computed once from its nominal values.

    Attributes:
        controllers: Design of the controller for each phase.
        targets: Target attitude of each phase, (phases, 4), scalar first.
        attitude: Initial attitude before its error, (4,), scalar first.
        known: Nominal spacecraft, the model of the controller.
        sensors: Nominal options of the sensors, the model of the estimator.
        reference: Part of the reference that is computed once; None for fixed targets.
        orbit: Tables along the orbit; None without an orbit.
    """

    controllers: tuple[Any, ...]
    targets: np.ndarray
    attitude: np.ndarray
    known: Spacecraft
    sensors: dict[str, np.ndarray]
    reference: PlannedReference | None = None
    orbit: OrbitEnvironment | None = None


def phases_of(structure: Structure) -> list[Event]:
    """Events that start a new phase with another controller design, in nominal order."""
    is_notified = chosen(structure, "controller").losses == NOTIFIED
    return [e for e in structure.turning_points if is_notified or e.kind == "slew"]


def phase_starts(structure: Structure, values: Values) -> list[Scalar]:
    """Start time of each phase, s."""
    return [0.0, *(notified(event, values) for event in phases_of(structure))]


def plan(scenario: Scenario) -> Plans:
    """Design the controller for every phase, from the nominal values.

    Raises:
        InputError: The working wheels do not suffice in a phase.
    """
    check_needs(scenario)
    structure = structure_of(scenario)
    known = spacecraft_of(structure, scenario.values)
    modes = modes_of_run(structure, scenario.values, known)
    if modes is not None:
        modes.check()
        modes.check_inertia(known.inertia)
    controller = chosen(scenario, "controller")
    count = len(scenario.wheels)
    left, seized = np.ones(count, bool), np.zeros(count, bool)
    target, found, targets, working = scenario.target, [], [], []
    if scenario.reference != "fixed" and not controller.follows:
        raise InputError(
            f"key controller.kind: found {scenario.controller} with the reference "
            f"{scenario.reference}, expected a controller of three axes or the reference fixed"
        )
    slews = {event.name: event.target for event in scenario.events}
    for event in (None, *structure.turning_points):
        wheel = None if event is None else event.wheel
        if event is not None and wheel is not None and controller.losses != IGNORED:
            left[wheel] = False
            seized[wheel] |= event.kind == "seized"
        if event is not None:
            target = slews[event.name] or target
        rank = np.linalg.matrix_rank(np.asarray(scenario.axes) * left[:, None], tol=1e-6)
        # a controller that ignores failures validates its wheels itself
        if rank < 3 and controller.losses != IGNORED:
            raise InputError(
                f"key {'controller' if event is None else f'event[{event.name}]'}: found working "
                "wheels that do not span space, expected wheels about every axis (gyrostat recover "
                "simulates fewer)"
            )
        told = controller.losses == NOTIFIED
        if wheel is not None and not told:
            continue
        case = DesignCase(
            spacecraft=known,
            working=left.copy() if told else np.ones(count, bool),
            seized=seized.copy() if told else np.zeros(count, bool),
            target=np.array(target),
            delay=scenario.command_delay,
        )
        made = controller.plan(case)
        check_parts(made)
        found.append(jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype=float), made))
        targets.append(target)
        working.append(case.working)
    sensors = options_of(scenario.values, "sensors")
    return Plans(
        tuple(found),
        np.array(targets),
        np.array(scenario.attitude),
        known,
        {name: np.asarray(value) for name, value in sensors.items()},
        planned_reference(scenario, known, np.array(working)),
        planned_orbit(scenario),
    )


def _made(structure: Structure, values: Values, section: str, *given: Any) -> Any:
    """Component of a section, made of its values and of other parts."""
    component = chosen(structure, section)
    return component.make(arrays_of(values, section, component.keys), *given)


def _plant(structure: Structure, values: Values, options: Values, plans: Plans, orbit: Any) -> Any:
    """Spacecraft with environment, actuators and own events, its initial state, and budget."""
    own = _made(structure, values, "environment")
    if "external_torque_limit" in options:
        own["external_torque_limit"] = options["external_torque_limit"] * jnp.ones(3)
    craft = spacecraft_of(structure, values)
    own["friction_steps"] = friction_steps_of(structure, values, craft.wheels.friction)
    given = {"spacecraft": plans.known, "orbit": orbit}
    torques = named_parts(structure, values, "environment.torque", **given)
    actuators = named_parts(structure, values, "actuator", **given)
    every = environment_torques(own) | torques
    period = values["run.control_period"]
    budget = Budget(craft, every, actuators, period) if structure.budget else None
    own["environment"] = (*own.get("environment", ()), *torques.values())
    own["actuators"] = actuators
    own["modes"] = modes_of_run(structure, values, craft)
    plant: Any = Gyrostat(craft, failures_of(structure, values), **own)
    begin = arrays_of(values, "start", START)
    error = from_rotation_vector(begin["attitude_error"])
    motion = {
        "attitude": product(jnp.asarray(plans.attitude), error),
        "rate": begin["rate"],
        "wheel_speed": of_wheels(structure, values, "speed"),
    }
    count = len(structure.wheels)
    harmonics = named_parts(structure, values, "imbalance.harmonic", wheels=count)
    imbalance = imbalance_of(structure, values, list(harmonics.values()))
    if "paddle_limit" in options:
        limit = jnp.full(count, jnp.inf).at[-1].set(options["paddle_limit"])
        plant = PaddleGyrostat(plant, limit)
    if imbalance is not None:
        plant = ImbalancedGyrostat(plant, imbalance)
        motion["wheel_angle"] = of_wheels(structure, values, "angle")
    if has_section(structure, "motor_constant"):
        names = [field.name for field in fields(Driver)]
        # the torque limit is that of the wheel, not of the driver
        numbers = {n: of_wheels(structure, values, n) for n in names if n != "torque_limit"}
        plant = DrivenGyrostat(
            plant, Driver(**numbers), of_wheels(structure, values, "motor_constant")
        )
    plant = with_events(structure, values, plant, plans.known)
    return plant, plant.start(**motion), budget


def build(structure: Structure, values: Values, plans: Plans) -> Setup:
    """Build the parts of a run from its values; pure, for `jit` and `vmap` over the values."""
    law, known = chosen(structure, "controller"), plans.known
    options = arrays_of(values, "controller", law.keys)
    bands = named_parts(structure, values, "controller.band")
    if bands:
        options["bands"] = dict(sorted(bands.items()))
    if has_section(structure, "wear"):
        options["wear"] = of_wheels(structure, values, "wear")
    orbit = orbit_of_run(values, plans.orbit, structure.dispersed)
    plant, start, budget = _plant(structure, values, options, plans, orbit)
    made = [law.make(plan, options, start.momentum) for plan in plans.controllers]
    starts = jnp.stack([jnp.asarray(t, dtype=float) for t in phase_starts(structure, values)])
    joined = jax.tree.map(lambda *leaves: jnp.stack([jnp.asarray(x) for x in leaves]), *made)
    controller: Any = Phases(starts, joined, orbit=orbit)
    reference = reference_of(structure, values, plans, start, starts, orbit)
    followed, navigation = reference, navigated(values, orbit)
    if navigation is not orbit:
        followed = reference_of(structure, values, plans, start, starts, navigation)
    targets = jnp.asarray(plans.targets)
    if reference is None and getattr(made[0], "takes_reference", False):
        followed = Reference.of(AttitudeTargets(starts, targets))
    if followed is not None:
        controller = Guided(controller, followed, structure.command_delay)
    period = values["run.control_period"]
    others = structure.command_delay, period, plans.sensors
    controller = _made(structure, values, "compensator", controller, known, *others)
    controller = in_orbit(controller, orbit)
    controller = _made(structure, values, "unloading", controller, known)
    controller = _made(structure, values, "estimator", controller, known, plans.sensors)
    controller = in_orbit(controller, orbit)
    sensor = _made(structure, values, "sensors", plant, known)
    heads = named_parts(structure, values, "star_tracker", orbit=orbit)
    if heads:
        tracker = StarTrackerHeads(tuple(heads.values()), sensor.tracker.periods)
        sensor = replace(sensor, tracker=tracker)
    added = named_parts(structure, values, "sensor", plant=plant, spacecraft=known, orbit=orbit)
    if added:
        sensor = AddedSensors(sensor, added)
    sensor = with_faults(structure, values, sensor)
    controller = guarded(structure, values, controller, sensor, start)
    metrics = named_parts(structure, values, "metric", spacecraft=known, orbit=orbit)
    return Setup(plant, controller, sensor, start, starts, targets, metrics, reference, budget)
