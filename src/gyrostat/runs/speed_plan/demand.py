"""What a run asks of its wheels: momentum over time, science windows, times for unloading."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from gyrostat.control.allocation.null_space import NullSpaceControl, null_projection
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import rotation_matrix
from gyrostat.core.types import Matrix, Vector
from gyrostat.runs.reference_path import nominal_setup
from gyrostat.scenario.scenario import Scenario
from gyrostat.telemetry.signals import runs


def bands_of(scenario: Scenario, values: Mapping[str, float]) -> Matrix:
    """Bands of speeds to avoid in a run, of either sign, (bands, 2), rad/s.

    Args:
        scenario: Scenario.
        values: Values of the run.
    """
    names = [part.name for part in scenario.parts if part.section == "controller.band"]
    ends = [
        [values[f"controller.band.{name}.{end}"] for end in ("above", "below")] for name in names
    ]
    return np.array(ends, dtype=float).reshape(-1, 2)


class Limits(NamedTuple):
    """Wheels and actuator of a scenario.

    Attributes:
        axes: Spin axes, (3, wheels).
        inertia: Rotor inertias, (wheels,), kg·m².
        momentum: Momentum limits, (wheels,), N·m·s.
        torque: Torque limits, (wheels,), N·m.
        bands: Bands of speeds to avoid, of either sign, (bands, 2), rad/s.
        direction: Direction d of the null-space control, (wheels,); zero without null space.
        crossing_gain: Its gain, 1/s.
        external_torque: Torque limit of the external actuator about each axis, N·m.
        momentum_gain: Its gain, 1/s.
        body: Inertia of the spacecraft with locked wheels, (3, 3), kg·m².
    """

    axes: Matrix
    inertia: Vector
    momentum: Vector
    torque: Vector
    bands: Matrix
    direction: Vector
    crossing_gain: float
    external_torque: float
    momentum_gain: float
    body: Matrix

    @classmethod
    def of(cls, scenario: Scenario) -> "Limits":
        """Wheels and actuator of a scenario.

        Raises:
            InputError: Its controller is no `wheel_array`, or another part unloads the wheels.
        """
        values = scenario.values
        if scenario.unloading != "none":
            raise InputError(
                f"key unloading: found {scenario.unloading}, expected none: a plan of wheel speeds "
                "unloads by controller.external_torque_limit"
            )
        if "controller.crossing_gain" not in values:
            raise InputError(
                f"key controller: found {scenario.controller}, expected a wheel_array, which can "
                "follow a plan of wheel speeds"
            )
        setup = nominal_setup(scenario)
        wheels = setup.plant.spacecraft.wheels
        axes, ones = np.asarray(wheels.axes, dtype=float), np.ones(wheels.count)
        null_space = _null_space(setup.controller)
        direction = np.zeros(wheels.count)
        if null_space is not None:
            # all phases of a run have the same pattern
            pattern = np.ravel(null_space.pattern)[: wheels.count]
            direction = null_projection(axes) @ pattern
        return cls(
            axes,
            ones * np.asarray(wheels.inertia),
            ones * np.asarray(wheels.momentum_limit),
            ones * np.asarray(wheels.torque_limit),
            bands_of(scenario, values),
            direction,
            values["controller.crossing_gain"],
            values["controller.external_torque_limit"],
            values["controller.momentum_gain"],
            np.asarray(setup.plant.spacecraft.inertia, dtype=float),
        )


def _null_space(controller: Any) -> NullSpaceControl | None:
    """Null-space control inside the parts around a controller; None without null space."""
    while not hasattr(controller, "null_space"):
        controller = getattr(controller, "plans", None) or controller.controller
    return controller.null_space


class Window(NamedTuple):
    """Science window, and the time before it in which wheel speeds may change.

    Attributes:
        begin: First sample.
        end: Sample after the last one.
        before: Sample from which wheel speeds may change; the end of the window before.
    """

    begin: int
    end: int
    before: int


class Demand(NamedTuple):
    """Momentum that a run asks of its wheels, without any unloading.

    Attributes:
        time: Times, (samples,), s.
        rotation: Attitude matrices, body to inertial, (samples, 3, 3).
        total: Total momentum in inertial axes, (samples, 3), N·m·s.
        wheels: Part of the wheel momenta outside the null space, (samples, wheels), N·m·s.
        turning: Part of the wheel momenta that the rate of the body needs, (samples, wheels),
            N·m·s.
        level: Null-space momentum z at the start, N·m·s.
        windows: Science windows, in their order.
    """

    time: Vector
    rotation: np.ndarray
    total: Matrix
    wheels: Matrix
    turning: Matrix
    level: float
    windows: tuple[Window, ...]


def demand_of(
    history: Mapping[str, Any], inside: Any, period: float, limits: Limits, delay: int = 0
) -> Demand:
    """Momentum that a simulated run asks of its wheels.

    Args:
        history: Signals of the run by name, NumPy arrays.
        inside: Whether each sample is in a science window, (samples,).
        period: Control period, s.
        limits: Wheels and actuator.
        delay: Control periods from a sample to the start of its command.
    """
    attitude = np.asarray(history["attitude"])
    rotation = np.asarray(jax.vmap(rotation_matrix)(jnp.asarray(attitude)))
    wheels = limits.inertia * np.asarray(history["wheel_speed"])
    across = np.linalg.pinv(limits.axes)
    impulse = np.zeros((len(attitude), 3))
    if "external_torque" in history:
        torque = np.zeros((len(attitude), 3))
        torque[delay:] = np.asarray(history["external_torque"])[: len(attitude) - delay]
        steps = period * np.einsum("tij,tj->ti", rotation, np.nan_to_num(torque))[:-1]
        impulse[1:] = np.cumsum(steps, axis=0)
    needed = np.einsum("wi,tji,tj->tw", across, rotation, impulse)
    row = wheels @ (across @ limits.axes).T
    square = float(limits.direction @ limits.direction)
    windows, before = [], 0
    for begin, end in runs(np.asarray(inside)):
        windows.append(Window(begin, end, before))
        before = end
    return Demand(
        np.asarray(period * np.arange(len(attitude)), dtype=np.float64),
        rotation,
        np.asarray(history["momentum"]) - impulse,
        row - needed,
        np.asarray(history["rate"]) @ (across @ limits.body).T,
        float(limits.direction @ wheels[0]) / square if square else 0.0,
        tuple(windows),
    )
