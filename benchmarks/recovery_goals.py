"""Recovery with two of three wheels: how many dispersed cases settle in time.

A case is a spacecraft with three orthogonal wheels (0.1 N·m, 3 N·m·s), one of which has failed, a
total momentum whose part across the failed axis is 0.1 to 2.9 N·m·s (log-uniform), what the failed
wheel holds uniform in +-2.9 N·m·s, and a holdable target (uniform phase and roll: up to 180 deg
away). Starts, in turn:

    frozen    at rest where all three wheels held the momentum; the failed one keeps its own
    seized    the same, the failed wheel's momentum goes to the body at once (all of it <= 2.9)
    drifting  any attitude, the working wheels stop the body as far as they can
    tumbling  any attitude, the momenta of the working wheels anything up to that of the target

Allowed is 100 s + 15 J / rho; settled means within 0.05 deg of the target from then on.

    python benchmarks/recovery_goals.py [--cases N] [--period S]
"""

import argparse
import functools
import time

import numpy as np
from scipy.spatial.transform import Rotation

from gyrostat._jax import jax, jnp
from gyrostat.body import ReducedGyrostat, ReducedSensor, ReducedState, Spacecraft
from gyrostat.body.rotations import error_angle
from gyrostat.control import MomentumRecovery
from gyrostat.simulate import stack
from gyrostat.simulate.loop import run
from gyrostat.wheel import WheelArray

KINDS = ("frozen", "seized", "drifting", "tumbling")
PRINCIPAL = {"cube": (12.0, 12.0, 12.0), "tilted": (8.0, 12.0, 16.0)}
TORQUE, MOMENTUM, MOST = 0.1, 3.0, 2.9
BLOCK = 50
LENGTHS = (400 * 1.35 ** np.arange(12)).astype(int)


def quaternion(rotation):
    """Scalar first."""
    return np.roll(rotation.as_quat(), 1)


def draw(random, kind, shape, error):
    """One case: plant, controller, start, rho, allowed time."""
    failed = int(random.integers(3))
    works = np.arange(3) != failed
    normal, rho = np.eye(3)[failed], np.exp(random.uniform(np.log(0.1), np.log(MOST)))
    held = random.uniform(-MOST, MOST)
    principal = np.array(PRINCIPAL[shape])
    turn = Rotation.random(rng=random).as_matrix() if shape == "tilted" else np.eye(3)

    def inertia(factors):
        matrix = turn @ np.diag(principal * factors) @ turn.T
        return jnp.asarray(0.5 * (matrix + matrix.T))

    def on_circle():
        phase = random.uniform(-np.pi, np.pi)
        return rho * np.insert([np.cos(phase), np.sin(phase)], failed, 0.0) + held * normal

    start = Rotation.random(rng=random)
    body = on_circle()
    total = start.apply(body)
    rotors = body.copy()
    if kind == "seized":
        scale = min(1.0, MOST / np.linalg.norm(body))
        total, rotors = total * scale, rotors * scale * works
        rho, held = np.linalg.norm(total), 0.0
    if kind in ("drifting", "tumbling"):
        start = Rotation.random(rng=random)
        carried = start.inv().apply(total)
        if kind == "tumbling":
            carried = random.uniform(-rho, rho, 3)
        rotors = np.where(works, np.clip(carried, -MOMENTUM, MOMENTUM), rotors)
    goal, wanted = Rotation.random(rng=random), on_circle()
    goal = goal * Rotation.align_vectors(goal.inv().apply(total)[None], wanted[None])[0]
    wheels = WheelArray(jnp.eye(3), jnp.zeros(3), TORQUE * jnp.ones(3), MOMENTUM * jnp.ones(3))
    plant = ReducedGyrostat(
        Spacecraft(inertia(1.0), wheels), jnp.asarray(works), jnp.asarray(total)
    )
    controller = MomentumRecovery.plan(
        Spacecraft(inertia(1.0 + error * random.choice([-1.0, 1.0], 3)), wheels),
        works,
        total_momentum=total,
        target=quaternion(goal),
    )
    state = ReducedState(jnp.asarray(quaternion(start)), jnp.asarray(rotors))
    return plant, controller, state, rho, 100.0 + 15.0 * principal.max() / rho


@functools.partial(jax.jit, static_argnames="count")
def settled(items, period, count):
    """Time from which each run stays within 0.05 deg, s; infinite where it does not."""

    def single(plant, controller, state):
        histories = run(
            plant, controller, ReducedSensor(plant), state, jax.random.key(0), period, count=count
        )
        errors = jax.vmap(error_angle, in_axes=(0, None))(
            histories.state.attitude, controller.law.target
        )
        out = ~(errors < np.radians(0.05))
        last = jnp.where(jnp.any(out), count + 1 - jnp.argmax(out[::-1]), 0)
        return jnp.where(out[-1], jnp.inf, last * period)

    return jax.vmap(single)(*items)


def ratios(cases, period):
    """Settling time over allowed time, case by case."""
    allowed = np.array([case[4] for case in cases])
    order, found = np.argsort(allowed), np.empty(len(cases))
    for first in range(0, len(cases), BLOCK):
        rows = order[first : first + BLOCK]
        least = (1.1 * allowed[rows[-1]] + 20.0) / period
        # few lengths, since each is compiled
        count = int(LENGTHS[np.searchsorted(LENGTHS, least)])
        items = tuple(stack([cases[row][k] for row in rows]).items for k in range(3))
        found[rows] = np.asarray(settled(items, period, count))
    return found / allowed


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description="Recovery with two of three wheels.")
    parser.add_argument("--cases", type=int, default=400)
    parser.add_argument("--period", type=float, default=0.5)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print(f"{'inertia':8}{'error':7}{'start':10}{'in time':>10}{'worst':>8}{'median':>8}{'s':>6}")
    for shape in PRINCIPAL:
        for error in (0.0, 0.05):
            begun = time.perf_counter()
            random = np.random.default_rng(options.seed)
            kinds = [KINDS[k % len(KINDS)] for k in range(options.cases)]
            cases = [draw(random, kind, shape, error) for kind in kinds]
            found = ratios(cases, options.period)
            for kind in KINDS:
                own = found[[k == kind for k in kinds]]
                print(
                    f"{shape:8}{error:<7.0%}{kind:10}{np.sum(own <= 1.0):6d}/{len(own):<3d}"
                    f"{own.max():8.2f}{np.median(own):8.2f}",
                    f"{time.perf_counter() - begun:5.0f}",
                    flush=True,
                )
            for row in np.flatnonzero(found > 1.0):
                print(f"    case {row}: rho {cases[row][3]:.2f}, ratio {found[row]:.2f}")


if __name__ == "__main__":
    main()
