"""Dispersed recoveries with two of three wheels and momentum.

A case is a spacecraft with three orthogonal wheels (0.1 N·m, 3 N·m·s), one of which has failed. The
component of the total momentum orthogonal to the failed axis is 0.1 to 2.9 N·m·s (log-uniform). The
momentum of the failed wheel is uniform in +-2.9 N·m·s. The target is a feasible attitude (uniform
phase and roll, up to 180 deg away). The initial states, in turn:

    frozen    at rest with the momentum in all three wheels; the failed wheel keeps its momentum
    emptied   the same; the failed wheel stops at once and the body takes its momentum, total <= 2.9
    drifting  any attitude; the working wheels stop the body as far as possible
    tumbling  any attitude; momenta of the working wheels between zero and those of the target
"""

import numpy as np
from scipy.spatial.transform import Rotation

from gyrostat.control import MomentumRecovery
from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Matrix, Vector
from gyrostat.papers.blocks import in_blocks
from gyrostat.papers.carvalho_fenili import setup
from gyrostat.papers.carvalho_fenili.dispersed import BLOCK, Dispersed, fly, settling_times
from gyrostat.papers.carvalho_fenili.reduced_gyrostat import (
    ReducedGyrostat,
    ReducedSensor,
    ReducedState,
)
from gyrostat.papers.reproduction import Say
from gyrostat.spacecraft import Spacecraft, SpacecraftSensor

KINDS = ("frozen", "emptied", "drifting", "tumbling")
PRINCIPAL = {"cube": (12.0, 12.0, 12.0), "tilted": (8.0, 12.0, 16.0)}
"""Principal inertias, kg·m²; tilted: about random axes."""
MOST = 2.9
"""Largest total momentum, N·m·s."""
PERIOD = 0.5
"""Control period, s."""
LENGTHS = (400 * 1.35 ** np.arange(12)).astype(int)
"""Durations of runs, periods. There are few, because each length is compiled separately."""


def _start(
    random: np.random.Generator, kind: str, failed: int
) -> tuple[Rotation, Rotation, Vector, Vector, float]:
    """Attitudes at the start and at the target, total momentum (inertial), rotor momenta, and rho.

    Momenta in N·m·s, those of rotors about their axes; rho is the momentum orthogonal to the failed
    axis.
    """
    works = np.arange(3) != failed
    rho = np.exp(random.uniform(np.log(0.1), np.log(MOST)))
    failed_momentum = random.uniform(-MOST, MOST)

    def on_circle() -> Vector:
        phase = random.uniform(-np.pi, np.pi)
        return np.insert(rho * np.array([np.cos(phase), np.sin(phase)]), failed, failed_momentum)

    start = Rotation.random(rng=random)
    rotors = on_circle()
    total = start.apply(rotors)
    if kind == "emptied":
        scale = min(1.0, MOST / float(np.linalg.norm(rotors)))
        total, rotors = total * scale, rotors * scale * works
        rho, failed_momentum = float(np.linalg.norm(total)), 0.0
    if kind in ("drifting", "tumbling"):
        start = Rotation.random(rng=random)
        carried = start.inv().apply(total)
        if kind == "tumbling":
            carried = random.uniform(-rho, rho, 3)
        rotors = np.where(works, np.clip(carried, -setup.MOMENTUM, setup.MOMENTUM), rotors)
    goal, goal_rotors = Rotation.random(rng=random), on_circle()
    goal = goal * Rotation.align_vectors(goal.inv().apply(total)[None], goal_rotors[None])[0]
    return start, goal, total, rotors, float(rho)


def _quaternion(rotation: Rotation):
    return jnp.asarray(rotation.as_quat(scalar_first=True))


def draw(random: np.random.Generator, kind: str, shape: str, error: float) -> Dispersed:
    """Draw one case for the reduced gyrostat.

    Args:
        random: Random generator.
        kind: Initial state, one of `KINDS`.
        shape: Shape of the body, one of `PRINCIPAL`.
        error: Relative error of each principal inertia in the controller, of either sign.
    """
    failed = int(random.integers(3))
    works = np.arange(3) != failed
    turn = Rotation.random(rng=random).as_matrix() if shape == "tilted" else np.eye(3)
    principal = np.array(PRINCIPAL[shape])
    start, goal, momentum, rotors, rho = _start(random, kind, failed)

    def spacecraft(factors: Vector) -> Spacecraft:
        inertia: Matrix = turn @ np.diag(principal * factors) @ turn.T
        symmetric = jnp.asarray(0.5 * (inertia + inertia.T))
        return Spacecraft(symmetric, setup.wheels_along_axes())

    total = jnp.asarray(momentum)
    model = spacecraft(1.0 + error * random.choice([-1.0, 1.0], 3))
    target = _quaternion(goal)
    return Dispersed(
        plant=ReducedGyrostat(spacecraft(np.ones(3)), jnp.asarray(works), total),
        controller=MomentumRecovery.plan(model, works, total_momentum=total, target=target),
        start=ReducedState(_quaternion(start), jnp.asarray(rotors)),
        target=target,
        allowed=100.0 + 15.0 * principal.max() / rho,
    )


def _duration(allowed: float) -> float:
    least = (1.1 * allowed + 20.0) / PERIOD
    return PERIOD * float(LENGTHS[np.searchsorted(LENGTHS, least)])


def ratios(shape: str, error: float, cases: int, say: Say) -> Vector:
    """Settling time over the allowed time, (cases,); infinite if a case does not settle.

    Args:
        shape: Shape of the body, one of `PRINCIPAL`.
        error: Relative error of each principal inertia in the controller, of either sign.
        cases: Number of cases.
        say: Called after each block.
    """
    random = np.random.default_rng(1)
    draws = [draw(random, KINDS[k % len(KINDS)], shape, error) for k in range(cases)]
    draws.sort(key=lambda case: case.allowed)

    def block(chunk: list[Dispersed]) -> Vector:
        flights = fly(chunk, ReducedSensor, duration=_duration(chunk[-1].allowed), period=PERIOD)
        return settling_times(flights) / np.array([case.allowed for case in chunk])

    name = f"with momentum, {shape}, inertia {error:.0%} wrong"
    return np.concatenate(list(in_blocks(draws, BLOCK, block, say=say, name=name)))


def full_beside_reduced(cases: int) -> tuple[float, float]:
    """Simulate cases with the full gyrostat and with the reduced one.

    Args:
        cases: Number of cases.

    Returns:
        Largest difference of settling times, s (infinite if a case does not settle), and largest
            relative change of the total momentum of the full gyrostat.
    """
    random = np.random.default_rng(2)
    shapes = list(PRINCIPAL)
    draws = [
        draw(random, KINDS[k % len(KINDS)], shapes[k // len(KINDS) % 2], 0.0) for k in range(cases)
    ]
    duration = _duration(max(case.allowed for case in draws))
    options = {"duration": duration, "period": PERIOD, "engine": "jax"}
    reduced = fly(draws, ReducedSensor, **options)
    full = fly([_full(case) for case in draws], SpacecraftSensor, **options)
    times = np.array([settling_times(full), settling_times(reduced)])
    difference = float(np.max(np.abs(times[0] - times[1]))) if np.isfinite(times).all() else np.inf
    return difference, max(_change(draws[k], full.isel(run=k)) for k in range(cases))


def _full(case: Dispersed) -> Dispersed:
    """Case with turning rotors, each with the momentum J (speed + body rate) about its axis."""
    reduced, state = case.plant, case.start
    failed = np.flatnonzero(~np.asarray(reduced.working)).tolist()
    plant = setup.without_torques(reduced.spacecraft, failed, 0.0)
    rate, speed = reduced.rate(state), reduced.relative_momentum(state) / setup.ROTOR
    return case._replace(
        plant=plant, start=plant.start(attitude=state.attitude, rate=rate, wheel_speed=speed)
    )


def _change(case: Dispersed, histories) -> float:
    """Relative change of the momentum computed from attitude, body rate and wheels."""
    locked = case.plant.spacecraft.inertia_locked()
    body = histories.rate.values @ np.asarray(locked) + histories.wheel_momentum.values
    momentum = jax.vmap(rotations.to_inertial)(
        jnp.asarray(histories.attitude.values), jnp.asarray(body)
    )
    total = np.asarray(case.plant.total_momentum)
    return float(np.max(np.abs(momentum - total)) / np.linalg.norm(total))
