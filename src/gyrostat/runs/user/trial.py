"""Trial of user-defined parts: one control period on shapes alone, then the first command."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jax
from gyrostat.core.user_errors import UserPartError
from gyrostat.core.user_modules import is_user_kind
from gyrostat.runs.build import Setup, build
from gyrostat.runs.designs import Plans
from gyrostat.runs.mode_inputs import condition_values, probed
from gyrostat.runs.user.repeated import try_parts
from gyrostat.runs.user.support import EXPORTED, Support, support_of
from gyrostat.scenario.kinds.registry import kinds_of
from gyrostat.scenario.scenario import LAW, Scenario
from gyrostat.scenario.sensing import Values, first_measurement
from gyrostat.scenario.structure import Structure, structure_of
from gyrostat.scenario.user.live_calls import traced_law
from gyrostat.scenario.user.recording import Call
from gyrostat.scenario.user.world import UserActuator, UserTorque
from gyrostat.simulation import Status
from gyrostat.spacecraft import Gyrostat
from gyrostat.spacecraft.torque_models import commanded_torques
from gyrostat.wheel.friction import Friction
from gyrostat.wheel.friction_laws import law_of

LOOP = ("reference", "controller", "compensator", "estimator")
"""Sections whose components compute the command, from the inside to the outside."""


def try_shapes(scenario: Scenario, plans: Plans) -> tuple[Call, ...]:
    """Trace one control period of a scenario several times, so that every part is called.

    Returns:
        The calls of user-defined parts.

    Raises:
        InputError: A user-defined part cannot be traced, is not pure, or returns something else
            than expected.
    """
    names = [f"{name} {kind}" for name, kind in kinds_of(scenario).items() if is_user_kind(kind)]
    return try_parts(structure_of(scenario), plans, ", ".join(names))


def supports_of(scenario: Scenario, plans: Plans) -> dict[str, Support]:
    """Name of the component of each user-defined part -> what it can be compiled for.

    Raises:
        InputError: See `try_shapes`.
    """
    calls, supports = try_shapes(scenario, plans), {}
    for name, kind in kinds_of(scenario).items():
        if is_user_kind(kind):
            matching = [s for s in EXPORTED if f"{name}.".startswith(f"{s}.")]
            section = max(matching, key=len, default=name)
            labels = f"{name} {kind}", f"{section} {kind}"
            part_calls = [call for call in calls if call.part in labels]
            supports[name] = support_of(part_calls, exported=section in EXPORTED)
    if is_user_kind(scenario.friction):
        law = law_of(scenario.friction, scenario.sources)
        if issubclass(law, Friction):
            call = Call(f"friction {scenario.friction}", "torque", traced_law(law), simulated=True)
            # a compensator computes the friction
            supports["friction"] = support_of([call], exported=scenario.compensator != "none")
    return supports


def first_sample(structure: Structure, values: Values, plans: Plans) -> tuple[Setup, Any, Any, Any]:
    """Parts of a run; memory and command after the first sample; own torques; divided states.

    The last are the states of own actuators after a period, and after two parts of it in turn.
    """
    setup = build(structure, values, plans)
    period = values["run.control_period"]
    measurement = first_measurement(setup.sensor, setup.start, period)
    controller = probed(setup.controller)
    outputs = controller(controller.start(period), measurement)
    bodies = jax.tree.leaves(setup.plant, is_leaf=lambda part: isinstance(part, Gyrostat))
    body = next(part for part in bodies if isinstance(part, Gyrostat))
    torques = _user_torques(setup, body, outputs[1])
    states = {
        each.name: _states_in_turn(each, getattr(outputs[1], name), period)
        for name, each in body.actuators.items()
        if isinstance(each, UserActuator)
    }
    return setup, outputs, torques, states


def _user_torques(setup: Setup, body: Gyrostat, command: Any) -> dict[str, Vector3]:
    """Name of each own environment torque and actuator -> its torque at the first command."""
    attitude = setup.start.attitude
    torques = {
        item.name: item(body.spacecraft, attitude, 0.0)
        for item in body.environment
        if isinstance(item, UserTorque)
    }
    states = getattr(setup.start, "actuators", None)
    for item in commanded_torques(body.actuators, command, states, 0.0):
        torques[f"actuator.{item.name}"] = item(body.spacecraft, attitude, 0.0)
    return torques


def _states_in_turn(actuator: UserActuator, value: Any, period: Scalar) -> tuple[Any, Any]:
    """State of an actuator after a period of another command, and after two parts of it in turn."""
    value = jax.tree.map(lambda leaf: leaf + 1, value)
    start = actuator.start()
    part = actuator.advanced(start, value, 0.3 * period)
    return (
        (start, actuator.advanced(start, value, period)),
        (
            actuator.advanced(start, value, 0.0 * period),
            actuator.advanced(part, value, 0.7 * period),
        ),
    )


def check_first_sample(
    scenario: Scenario, made: Any, torques: Mapping[str, Any], states: Mapping[str, Any]
) -> None:
    """Validate memory and command after the first sample, torques, and states of actuators.

    Args:
        scenario: Scenario.
        made: Memory and command.
        torques: Name -> torque, N·m.
        states: Name of an actuator -> states at the start and after a period, and the same after
            no time and after two parts of a period in turn.

    Raises:
        UserPartError: A number is not finite, or the states differ.
    """
    memory, command = made
    names = _user_names(scenario)
    for name, value in condition_values(scenario, command).items():
        if not np.isfinite(value):
            raise UserPartError(
                f"{name}: found the condition {np.asarray(value)} at the first sample, expected a "
                "finite number, above 0 while it holds"
            )
    entries = {f"command.{n}": v for n, v in zip(command._fields, command, strict=True)}
    for label, value in {**entries, "memory": memory}.items():
        for leaf in jax.tree.leaves(value):
            if not np.all(np.isfinite(leaf)) and names:
                raise UserPartError(
                    f"{names}: found {label} with NaN or an infinite number at the first "
                    "sample, expected finite numbers"
                )
    for name, torque in torques.items():
        if not np.all(np.isfinite(torque)):
            raise UserPartError(
                f"{name}: found the torque {np.asarray(torque)} at the first sample, expected "
                "finite numbers, N·m"
            )
    _check_states(states)


def _check_states(states: Mapping[str, Any]) -> None:
    for name, (once, in_turn) in states.items():
        for expected, found in zip(jax.tree.leaves(once), jax.tree.leaves(in_turn), strict=True):
            rounding = 1e-9 * np.max(np.abs(expected), initial=0.0)
            if not np.allclose(expected, found, rtol=1e-6, atol=rounding):
                raise UserPartError(
                    f"{name}: found the state {np.asarray(found)} after no time or after two times "
                    f"in turn, expected {np.asarray(expected)} as after their sum: advanced(state, "
                    "value, elapsed) is the motion in time at a constant command"
                )


def say_bad_commands(
    scenario: Scenario, columns: Mapping[str, Any], say: Callable[[str], None]
) -> None:
    """Report runs that ended because of a command that was not finite.

    Args:
        scenario: Scenario of the runs.
        columns: Columns of the table of runs.
        say: Called with the message if there are such runs.
    """
    bad = np.flatnonzero(np.asarray(columns["status"]) == Status.BAD_COMMAND)
    if len(bad):
        run, time = (np.asarray(columns[name])[bad[0]] for name in ("run", "ended"))
        say(
            f"{_user_names(scenario) or scenario.controller}: found a command with NaN or an "
            f"infinite number in {len(bad)} of {len(columns['status'])} runs, first after "
            f"{time:g} s in run {run}, expected finite numbers"
        )


def _user_names(scenario: Scenario) -> str:
    """Names of the user-defined parts that compute the command."""
    kinds = {name: getattr(scenario, name) for name in LOOP}
    parts = [part for part in scenario.parts if part.section in ("reference.mode", LAW)]
    kinds |= {f"{part.section}.{part.name}": part.kind for part in parts}
    return ", ".join(f"{name} {kind}" for name, kind in kinds.items() if is_user_kind(kind))
