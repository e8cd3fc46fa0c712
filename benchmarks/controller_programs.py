"""Controllers as a user writes them, and controllers of this package, with measurements.

`PROGRAMS` names a Kalman filter of 15 states, a model predictive controller, a multilayer
perceptron, and controllers of this package. `program_sizes.py` measures their C, `casadi_peer.py`
compares it with that of CasADi.
"""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from calibrating_filter import PERIOD, SAMPLES, START, Estimate, Sensors, filtered, sensed
from flight_modules import PARTS, of_scenario

import gyrostat as gs
from gyrostat.codegen.flight import Entry
from gyrostat.codegen.tracing import as_arrays
from gyrostat.control import (
    MinimaxAllocation,
    OutputFeedback,
    WheelArrayControl,
)
from gyrostat.control.attitude.attitude_targets import AttitudeTargets
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import AttitudeFilter
from gyrostat.spacecraft import TrackerGyroMeasurement

EXAMPLES = Path(__file__).parents[1] / "examples"


@dataclass(frozen=True)
class Program:
    """Controller with measurements.

    Attributes:
        function: Function of parameters, state and measurement, in the order of `arguments`.
        arguments: Name -> first value.
        results: Names of the results; the state is among them.
        inputs: Name -> measurements; the first axis is the step.
    """

    function: Callable[..., Any]
    arguments: Mapping[str, Any]
    results: tuple[str, ...]
    inputs: Mapping[str, Any]

    def entry(self, name: str) -> Entry:
        """Entry of the C module."""
        arguments = {key: as_arrays(tree) for key, tree in self.arguments.items()}
        return Entry(name, self.function, arguments, self.results)


def kalman_filter():
    """Attitude and calibration of gyro, star tracker and magnetometer: 15 states."""
    zero = np.zeros(3)
    start = Estimate(np.array([1.0, 0.0, 0.0, 0.0]), zero, zero, zero, zero, np.diag(START))
    sensors = sensed()
    first = Sensors(*(values[0] for values in sensors))
    arguments = {"estimate": start, "sensors": first}
    return Program(filtered, arguments, ("estimate",), {"sensors": sensors})


# ---- Model predictive control -------------------------------------------------------------------

HORIZON, ITERATIONS = 10, 40
TORQUE_LIMIT = 1e-3
INERTIA = np.array([[0.06, 0.002, -0.001], [0.002, 0.12, 0.003], [-0.001, 0.003, 0.14]])


def condensed(horizon=HORIZON, period=1.0):
    """Hessian and linear term of the cost over the torques of the horizon, in units of the limit.

    The model is that of small angles: attitude error and rate of a rigid body, held torques.
    """
    push = TORQUE_LIMIT * np.linalg.inv(INERTIA)
    step = np.block([[np.eye(3), period * np.eye(3)], [np.zeros((3, 3)), np.eye(3)]])
    held = np.concatenate([0.5 * period**2 * push, period * push])
    powers = [np.linalg.matrix_power(step, k) for k in range(horizon + 1)]
    free = np.concatenate(powers[1:])
    zero = np.zeros((6, 3))
    blocks = [
        [powers[i - j] @ held if i >= j else zero for j in range(horizon)] for i in range(horizon)
    ]
    forced = np.block(blocks)
    weights = np.tile(np.repeat([1.0, 4.0], 3), horizon)
    weights[-6:] *= 10.0
    hessian = forced.T @ (weights[:, None] * forced) + 1e-3 * np.eye(3 * horizon)
    return hessian, forced.T @ (weights[:, None] * free)


HESSIAN, LINEAR = condensed()
STEP_SIZE = 1.0 / np.linalg.eigvalsh(HESSIAN)[-1]


class Motion(NamedTuple):
    """Measured motion.

    Attributes:
        angle: Attitude error, (3,), rad.
        rate: Body rate, (3,), rad/s.
    """

    angle: Any
    rate: Any


def predictive(plan, motion):
    """Torques of the horizon by projected gradient steps, from those of the last sample."""
    slope = LINEAR @ jnp.concatenate([motion.angle, motion.rate])
    plan = jnp.concatenate([plan[3:], plan[-3:]])

    def descend(_, plan):
        return jnp.clip(plan - STEP_SIZE * (HESSIAN @ plan + slope), -1.0, 1.0)

    plan = jax.lax.fori_loop(0, ITERATIONS, descend, plan)
    return plan, TORQUE_LIMIT * plan[:3]


def motions():
    """Attitude errors and rates of a periodic motion that saturates the torques now and then."""
    phase = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
    angle = np.stack([0.02 * np.sin(phase), 0.1 * np.sin(2.0 * phase), 0.05 * np.cos(phase)], 1)
    return Motion(angle, 0.1 * np.roll(angle, 7, 0))


def model_predictive():
    """Model predictive control: 10 samples of 3 torques, 40 projected gradient steps."""
    motion = motions()
    first = Motion(motion.angle[0], motion.rate[0])
    arguments = {"plan": np.zeros(3 * HORIZON), "motion": first}
    return Program(predictive, arguments, ("plan", "torque"), {"motion": motion})


# ---- Multilayer perceptron ----------------------------------------------------------------------


class Network(NamedTuple):
    """Weights and offsets of each layer."""

    first: Any
    first_offset: Any
    second: Any
    second_offset: Any
    third: Any
    third_offset: Any


def network(sizes=(6, 32, 32, 3)):
    """Random weights of usual size."""
    random, layers = np.random.default_rng(1), []
    for inputs, count in itertools.pairwise(sizes):
        layers += [
            random.standard_normal((count, inputs)) / np.sqrt(inputs),
            0.1 * random.standard_normal(count),
        ]
    return Network(*layers)


def perceptron(network, motion):
    """Torque from attitude error and rate."""
    signal = jnp.concatenate([motion.angle, motion.rate])
    signal = jnp.tanh(network.first @ signal + network.first_offset)
    signal = jnp.tanh(network.second @ signal + network.second_offset)
    return TORQUE_LIMIT * jnp.tanh(network.third @ signal + network.third_offset)


def learned():
    """Multilayer perceptron 6-32-32-3, weights as parameters."""
    motion = motions()
    first = Motion(motion.angle[0], motion.rate[0])
    arguments = {"network": network(), "motion": first}
    return Program(perceptron, arguments, ("torque",), {"motion": motion})


def learned_fixed():
    """Multilayer perceptron 6-32-32-3, weights in the code."""
    program, weights = learned(), network()
    arguments = {"motion": program.arguments["motion"]}
    return Program(
        lambda motion: perceptron(weights, motion), arguments, ("torque",), program.inputs
    )


# ---- Controllers of this package ----------------------------------------------------------------


def call(controller, memory, measurement):
    """Step of a controller."""
    return controller(memory, measurement)


def tracked(spacecraft):
    """Measurements of star tracker, gyro and tachometers."""
    sensors = sensed()
    wheel_speed = np.array([1.0, -1.0, 1.0, -1.0]) * (157.0 + 10.0 * sensors.rate[:, :1])
    valid = np.arange(SAMPLES) % 4 == 0
    measured = np.ones((SAMPLES, spacecraft.wheels.count), bool)
    return TrackerGyroMeasurement(
        sensors.attitude, valid, 0.1 * sensors.rate, wheel_speed, measured
    )


def four_wheels():
    """Four wheels with minimax allocation, fault detector and Kalman filter, without guard."""
    spacecraft = gs.read_spacecraft(EXAMPLES / "scenarios" / "cubesat.toml").spacecraft
    law = WheelArrayControl(
        spacecraft,
        AttitudeTargets.hold([1.0, 0.0, 0.0, 0.0]),
        largest_rate=np.radians(1.0),
        allocation=MinimaxAllocation(),
    )
    controller = OutputFeedback(AttitudeFilter(5e-5, 2e-5, 1e-7, 1e-4), law)
    measurement = tracked(spacecraft)
    arguments = {
        "controller": controller,
        "memory": controller.start(PERIOD),
        "measurement": jax.tree.map(lambda leaf: leaf[0], measurement),
    }
    return Program(call, arguments, ("memory", "command"), {"measurement": measurement})


def four_wheels_fixed():
    """As `four_wheels`, with its parameters in the code."""
    program = four_wheels()
    controller = program.arguments["controller"]
    arguments = {name: program.arguments[name] for name in ("memory", "measurement")}

    def step(memory, measurement):
        return controller(memory, measurement)

    return Program(step, arguments, program.results, program.inputs)


def _of_target(target):
    (step,) = target.steps
    count = len(jax.tree.leaves(target.inputs)[0])
    inputs = jax.tree.map(lambda leaf: np.resize(leaf, (count, *leaf.shape[1:])), target.inputs)
    return Program(step.function, step.arguments, step.results, inputs)


def four_wheels_scenario():
    """Exported controller of `wheel_array.toml`: null space, unloading, filter and guard."""
    return _of_target(of_scenario(EXAMPLES / "scenarios" / "wheel_array.toml"))


def compensator():
    """Exported friction compensator with its Kalman filter and guard."""
    return _of_target(PARTS["compensator"]())


PROGRAMS = {
    "filter": kalman_filter,
    "mpc": model_predictive,
    "mlp": learned,
    "mlp_fixed": learned_fixed,
    "four_wheels": four_wheels,
    "four_wheels_fixed": four_wheels_fixed,
    "four_wheels_scenario": four_wheels_scenario,
    "compensator": compensator,
}
"""Name -> program."""
