"""Designs of the controller of a scenario, one for each phase."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.arrays import Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.validation import check_parts
from gyrostat.runs.build_parts import modes_of_run, tables_of
from gyrostat.runs.build_reference import planned_reference
from gyrostat.scenario.build_spacecraft import spacecraft_of
from gyrostat.scenario.controller_kind import IGNORED, NOTIFIED, DesignCase
from gyrostat.scenario.kinds.events import kind_of
from gyrostat.scenario.kinds.orbits import planned_orbit
from gyrostat.scenario.kinds.registry import check_needs, chosen, component
from gyrostat.scenario.reference_kind import PlannedReference
from gyrostat.scenario.scenario import LAW, Event, Scenario
from gyrostat.scenario.sensing import Values, options_of
from gyrostat.scenario.structure import Structure, notified, structure_of
from gyrostat.spacecraft import Spacecraft
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment


class Plans(NamedTuple):
    """Controller designs of a scenario, computed once from its nominal values.

    Attributes:
        controllers: Design of the controller for each phase.
        laws: Designs of each [[controller.law]] for each phase.
        targets: Target attitude of each phase, (phases, 4), scalar first.
        attitude: Initial attitude before its error, (4,), scalar first.
        known: Nominal spacecraft, the model of the controller.
        sensors: Nominal options of the sensors, the model of the estimator.
        reference: Part of the reference that is computed once; None for fixed targets.
        orbit: Tables along the orbit; None without an orbit.
        tables: Place of each metric with a file -> what is computed of the file once.
    """

    controllers: tuple[Any, ...]
    targets: np.ndarray
    attitude: np.ndarray
    known: Spacecraft
    sensors: dict[str, np.ndarray]
    reference: PlannedReference | None = None
    orbit: OrbitEnvironment | None = None
    laws: tuple[tuple[Any, ...], ...] = ()
    tables: Mapping[str, Any] = {}


def phases_of(structure: Structure) -> list[Event]:
    """Events that start a new phase with another controller design, in nominal order."""
    is_notified = chosen(structure, "controller").losses == NOTIFIED
    return [e for e in structure.turning_points if is_notified or kind_of(e).changes_target]


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
    nominal = spacecraft_of(structure, scenario.values)
    modes = modes_of_run(structure, scenario.values, nominal)
    if modes is not None:
        modes.check()
        modes.check_inertia(nominal.inertia)
    controller = chosen(scenario, "controller")
    if chosen(scenario, "reference").moves and not controller.follows:
        raise InputError(
            f"key controller.kind: found {scenario.controller} with the reference "
            f"{scenario.reference}, expected a controller of three axes or the reference fixed"
        )
    cases = list(_design_cases(scenario, structure, nominal, controller.losses))
    sensors = options_of(scenario.values, "sensors")
    laws = [
        component(part.section, part.kind, scenario.sources)
        for part in scenario.parts
        if part.section == LAW
    ]
    return Plans(
        _designs(controller, cases),
        np.array([case.target for case in cases]),
        np.array(scenario.attitude),
        nominal,
        {name: np.asarray(value) for name, value in sensors.items()},
        planned_reference(scenario, nominal, np.array([case.working for case in cases])),
        planned_orbit(scenario),
        tuple(_designs(law, cases) for law in laws),
        tables_of(scenario),
    )


def _designs(controller: Any, cases: Sequence[DesignCase]) -> tuple[Any, ...]:
    """Design of a controller for each case."""
    designs = []
    for case in cases:
        design = controller.plan(case)
        check_parts(design)
        designs.append(jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype=float), design))
    return tuple(designs)


def _design_cases(
    scenario: Scenario, structure: Structure, nominal: Spacecraft, losses: str
) -> Iterator[DesignCase]:
    """Design case of each phase.

    Args:
        scenario: Scenario.
        structure: Its structure.
        nominal: Nominal spacecraft.
        losses: What the controller does about lost wheels.

    Raises:
        InputError: The working wheels do not span space, and the controller does not ignore it.
    """
    count = len(scenario.wheels)
    working, seized = np.ones(count, bool), np.zeros(count, bool)
    target = scenario.target
    slews = {event.name: event.target for event in scenario.events}
    for event in (None, *structure.turning_points):
        wheel = None if event is None else event.wheel
        if event is not None and wheel is not None and losses != IGNORED:
            working[wheel] = False
            seized[wheel] |= kind_of(event).stops_rotor
        if event is not None:
            target = slews[event.name] or target
        rank = np.linalg.matrix_rank(np.asarray(scenario.axes) * working[:, None], tol=1e-6)
        # a controller that ignores failures validates its wheels itself
        if rank < 3 and losses != IGNORED:
            raise InputError(
                f"key {'controller' if event is None else f'event[{event.name}]'}: found working "
                "wheels that do not span space, expected wheels about every axis (gyrostat recover "
                "simulates fewer)"
            )
        is_notified = losses == NOTIFIED
        if wheel is not None and not is_notified:
            continue
        yield DesignCase(
            spacecraft=nominal,
            working=working.copy() if is_notified else np.ones(count, bool),
            seized=seized.copy() if is_notified else np.zeros(count, bool),
            target=np.array(target),
            delay=scenario.command_delay,
        )
