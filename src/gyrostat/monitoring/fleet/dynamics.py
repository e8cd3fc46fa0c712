"""Motion of spacecraft with wheels over hours of flight, for many flights at once.

Exact within a step are the sampled attitude loop, its noise, the null-space loop and the total
momentum. Held over a step are friction, gyroscopic torque and external torque. The momentum of the
wheels follows from the total momentum, so that it is conserved: A g = H - J w, where g are the
rotors' momenta and the null-space part of g is a state of its own. Dry friction is implicit: it
takes at most the impulse that stops the wheel within the step.
"""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from gyrostat.codegen.simd.batch import Lanes, lanes
from gyrostat.codegen.simd.compiler import require_compiler
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Vector
from gyrostat.monitoring.fleet.attitude_loop import AttitudeLoop
from gyrostat.monitoring.fleet.states import Commanded, FlightState, Slow, Telemetered
from gyrostat.monitoring.fleet.vehicle import Vehicle
from gyrostat.simulation.runner import by_engine

NORMALS = 13
"""Normal numbers per step and flight beside one for each wheel's friction: 6 of sensors, 6 of the
loop, then those of friction, 1 of bursts."""


class Constants(NamedTuple):
    """Numbers of a vehicle and its loop that the step uses; see `constants`."""

    step: Any
    inertia: Any
    rotor: Any
    axes: Any
    spread: Any
    null: Any
    null_target: Any
    null_time: Any
    null_decay: Any
    null_gain: Any
    stiffness: Any
    damping: Any
    transition: Any
    disturbance: Any
    first_noise: Any
    later_noise: Any
    attitude_sigma: Any
    rate_sigma: Any
    stribeck_speed: Any
    torque_limit: Any
    constant_torque: Any
    rods: Any
    unloading_rate: Any
    thrust: Any
    momentum_limit: Any
    noise_sigma: Any
    noise_decay: Any
    burst_decay: Any


def constants(
    vehicle: Vehicle,
    loop: AttitudeLoop,
    *,
    rods: bool,
    bias_share: float,
    noise: tuple[float, float],
) -> Constants:
    """Numbers of a vehicle for the step.

    Args:
        vehicle: Spacecraft.
        loop: Its loop over one step.
        rods: Whether torque rods unload momentum, at all times; else thrusters at a limit.
        bias_share: Share of the bias speed that the null-space loop holds.
        noise: Standard deviation and correlation time (s) of the relative Coulomb noise.
    """
    swing = vehicle.wheel.inertia * vehicle.largest_swing
    return Constants(
        step=loop.step,
        inertia=vehicle.inertia,
        rotor=vehicle.wheel.inertia,
        axes=vehicle.axes,
        spread=vehicle.spread,
        null=vehicle.null,
        null_target=float(np.sum(np.abs(vehicle.null)))
        * vehicle.wheel.inertia
        * vehicle.bias_speed
        * bias_share,
        null_time=vehicle.null_time,
        null_decay=loop.null_decay,
        null_gain=loop.null_gain,
        stiffness=loop.stiffness,
        damping=loop.damping,
        transition=loop.transition,
        disturbance=loop.disturbance,
        first_noise=loop.first_noise,
        later_noise=loop.later_noise,
        attitude_sigma=vehicle.attitude_sigma,
        rate_sigma=vehicle.rate_sigma,
        stribeck_speed=vehicle.wheel.stribeck_speed,
        torque_limit=vehicle.wheel.torque_limit,
        constant_torque=vehicle.constant_torque,
        rods=1.0 if rods else 0.0,
        unloading_rate=1.0 / 2000.0,
        thrust=0.1 * vehicle.wheel.torque_limit,
        momentum_limit=1.15 * swing,
        noise_sigma=noise[0],
        noise_decay=float(np.exp(-loop.step / noise[1])),
        burst_decay=float(np.exp(-loop.step / 15.0)),
    )


def start(count: int, momentum: Vector, numbers: Constants, noise: Vector) -> FlightState:
    """State at the start of the flights, at rest on the commanded motion.

    Args:
        count: Number of flights.
        momentum: Total momentum, inertial axes, (B, 3), N·m·s.
        numbers: Numbers of the vehicle.
        noise: Relative deviations of the Coulomb torque, (B, wheels).
    """
    return FlightState(
        np.zeros((count, 3)),
        np.zeros((count, 3)),
        momentum,
        np.full(count, numbers.null_target),
        noise,
        np.zeros(count),
        np.zeros(count, bool),
    )


def _step(
    numbers: Constants, slow: Slow, state: FlightState, inputs: tuple[Commanded, Any]
) -> tuple[FlightState, Telemetered]:
    commanded, normals = inputs
    n, h = numbers, numbers.step
    reference, acceleration = commanded.rate, commanded.acceleration
    momentum = commanded.to_inertial.T @ state.momentum
    momentum = momentum - jnp.cross(state.angle, momentum)
    rate = reference - jnp.cross(state.angle, reference) + state.rate
    rotors = n.spread @ (momentum - n.inertia * rate) + n.null * state.null_momentum
    speed = rotors / n.rotor - n.axes.T @ rate

    angle_noise, rate_noise = n.attitude_sigma * normals[:3], n.rate_sigma * normals[3:6]
    noise_torque = -(n.stiffness * angle_noise + n.damping * rate_noise)
    feedback = -n.stiffness * state.angle - n.damping * state.rate
    feedforward = n.inertia * acceleration + jnp.cross(reference, momentum)
    misread = n.null @ (n.rotor * slow.tachometer * speed)
    null_torque = -(state.null_momentum + misread - n.null_target) / n.null_time
    quiet = -n.spread @ (feedforward + feedback) + n.null * null_torque
    torque = jnp.clip(quiet - n.spread @ noise_torque, -n.torque_limit, n.torque_limit)

    coulomb = slow.coulomb * (1.0 + state.noise) + slow.burst * jnp.abs(state.burst)
    dry = coulomb + slow.excess * jnp.exp(-((speed / n.stribeck_speed) ** 2))
    motor = jnp.clip(quiet, -n.torque_limit, n.torque_limit) * (1.0 + slow.gain)
    other = motor - slow.viscous * speed - slow.offset
    friction = jnp.clip(n.rotor / h * speed + other, -dry, dry)
    # at the middle of the step
    viscous = slow.viscous * (speed + 0.5 * h / n.rotor * (other - friction))
    # with the torque that the motor lacks
    drag = friction + viscous + slow.offset + quiet - motor

    outside, firing = _external(n, commanded, momentum, state.firing)
    disturbance = (
        n.axes @ drag
        + outside
        - jnp.cross(rate - reference, momentum)
        + n.inertia * (jnp.cross(state.angle, acceleration) + jnp.cross(state.rate, reference))
    )
    t, z = n.transition, normals[6:12]
    angle, body_rate = (
        t[k, 0] * state.angle
        + t[k, 1] * state.rate
        + n.disturbance[k] * disturbance
        + n.first_noise[k] * noise_torque
        + n.later_noise[k, 0] * z[:3]
        + n.later_noise[k, 1] * z[3:]
        for k in range(2)
    )
    decay = n.noise_decay
    following = FlightState(
        angle,
        body_rate,
        state.momentum + h * (commanded.to_inertial @ outside),
        n.null_target
        + (state.null_momentum - n.null_target) * n.null_decay
        - n.null_gain * (n.null @ drag + misread / n.null_time),
        decay * state.noise + n.noise_sigma * jnp.sqrt(1.0 - decay**2) * normals[12:-1],
        n.burst_decay * state.burst + jnp.sqrt(1.0 - n.burst_decay**2) * normals[-1],
        firing,
    )
    return following, Telemetered(
        speed * (1.0 + slow.tachometer),
        torque,
        state.angle + angle_noise,
        state.rate + rate_noise,
        coulomb,
        firing,
    )


def _external(n: Constants, commanded: Commanded, momentum: Any, firing: Any) -> tuple[Any, Any]:
    """External torque in body axes, and whether thrusters fire."""
    size = jnp.sqrt(momentum @ momentum) + 1e-300
    lines = commanded.field
    across = momentum - lines * (lines @ momentum)
    firing = jnp.where(firing, size > 0.1 * n.momentum_limit, size > n.momentum_limit)
    firing = firing & (n.rods < 0.5)
    push = jnp.where(firing, jnp.minimum(n.thrust, 0.5 * size / n.step), 0.0)
    unloading = -n.rods * n.unloading_rate * across - push * momentum / size
    return n.constant_torque + commanded.gradient + unloading, firing


def _advance(
    numbers: Constants, state: FlightState, slow: Slow, commanded: Commanded, normals: Any
) -> tuple[FlightState, Telemetered]:
    """See `advance`; one flight."""
    steps = normals.shape[0]
    held = steps // slow.coulomb.shape[0]

    def step(state: FlightState, inputs: Any) -> tuple[FlightState, Telemetered]:
        k, commanded, normals = inputs
        return _step(
            numbers, Slow(*(each[k // held] for each in slow)), state, (commanded, normals)
        )

    return jax.lax.scan(step, state, (jnp.arange(steps), commanded, normals))


_OWN = (False, True, True, False, True)
_with_jax = jax.jit(jax.vmap(_advance, in_axes=tuple(0 if own else None for own in _OWN)))


@lru_cache(maxsize=8)
def _native(structure: Any, shapes: tuple[tuple[int, ...], ...], types: tuple[str, ...]) -> Lanes:
    """Compiled for arguments of these shapes and types."""
    leaves = [jax.ShapeDtypeStruct(s, t) for s, t in zip(shapes, types, strict=True)]
    return lanes(_advance, _OWN, jax.tree.unflatten(structure, leaves))


def advance(
    numbers: Constants,
    state: FlightState,
    slow: Slow,
    commanded: Commanded,
    normals: Any,
    engine: str = "auto",
) -> tuple[FlightState, Telemetered]:
    """Fly N steps.

    Args:
        numbers: Numbers of the vehicle.
        state: State of the flights at the start, (B, ...).
        slow: Parameters, (B, M, wheels), each held for N/M steps.
        commanded: Commanded motion, (N, ...).
        normals: Normal numbers, (B, N, NORMALS + wheels).
        engine: "jax", "native" or "auto", which is native where there is a compiler.

    Returns:
        The state at the end, and the samples at the start of each step, (B, N, ...).

    Raises:
        InputError: There is no compiler for "native".
    """
    arguments = jax.tree.map(np.asarray, (numbers, state, slow, commanded, normals))

    def attempt(engine: str) -> tuple[FlightState, Telemetered]:
        if engine == "jax":
            return jax.tree.map(np.asarray, _with_jax(*arguments))
        require_compiler()
        leaves, structure = jax.tree.flatten(arguments)
        kind = (leaf.shape for leaf in leaves), (str(leaf.dtype) for leaf in leaves)
        return _native(structure, *map(tuple, kind))(*arguments)

    return by_engine(engine, attempt)
