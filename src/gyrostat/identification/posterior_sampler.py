"""No-U-turn sampler (Hoffman and Gelman 2014) of blackjax, in many short chains.

The chains advance together in one compiled program and share the covariance that they find.
"""

from collections.abc import Callable
from functools import lru_cache
from importlib.util import find_spec
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Vector

CHAINS, WARM_UP, DRAWS = 32, 60, 125
"""Chains, which advance together; steps of each of the two stages of warm-up; draws of each chain.
Many short chains cost little more than a few, and share what they learn about the covariance."""
STEP, DEEPEST = 0.4, 5
"""Step size in coordinates of unit covariance, and largest number of doublings of a trajectory."""
CHUNK = 20
"""Steps between two messages."""


def check_sampler() -> None:
    """Refuse to start where the sampler is not installed.

    Raises:
        InputError: blackjax is not installed.
    """
    if find_spec("blackjax") is None:
        raise InputError(
            "--posterior: found no blackjax, expected the extra: pip install 'gyrostat[posterior]'"
        )


def chain(log_density: Callable) -> Callable:
    """CHUNK steps of one chain: function (key, position, mass matrix, data) -> draws, divergent.

    Args:
        log_density: Function (u, data) -> logarithm of the density.
    """
    import blackjax  # pyright: ignore[reportMissingImports]

    def chunk(key, position, mass, data):
        nuts = blackjax.nuts(lambda u: log_density(u, data), STEP, mass, max_num_doublings=DEEPEST)

        def one(state, own):
            state, info = nuts.step(own, state)
            return state, (state.position, info.is_divergent)

        keys = jax.random.split(key, CHUNK)
        return jax.lax.scan(one, nuts.init(position), keys)[1]

    return chunk


@lru_cache
def _program(log_density: Callable):
    """Compile CHUNK steps of several chains."""
    return jax.jit(jax.vmap(chain(log_density), (0, 0, None, None)))


def sample(
    log_density: Callable,
    data: Any,
    dimension: int,
    *,
    seed: int = 0,
    chains: int = CHAINS,
    warm_up: int = WARM_UP,
    draws: int = DRAWS,
    on_progress: Callable[[int], None] = lambda count: None,
) -> tuple[Vector, int]:
    """Draw from a density by several chains.

    The first stage of warm-up has unit covariance; the second one and the draws have that of all
    chains in the second half of the first stage.

    Args:
        log_density: Function (u, data) -> logarithm of the density; u of about unit scale around
            zero.
        data: Pytree of arrays.
        dimension: Length n of u.
        seed: Seed of all random numbers.
        chains: Number of chains.
        warm_up: Steps of each of the two stages of warm-up, which are discarded.
        draws: Draws of each chain.
        on_progress: Called with the draws of each chain so far, 0 before the warm-up.

    Returns:
        Draws, (chains, draws, n), and the number of divergent trajectories among them.
    """
    chunk = _program(log_density)
    key, own = jax.random.split(jax.random.key(seed))
    position, mass = jax.random.normal(own, (chains, dimension)), jnp.eye(dimension)

    def run(steps: int, said: Callable[[int], None]) -> tuple[Vector, int]:
        nonlocal key, position
        parts, divergent = [], 0
        for done in range(0, steps, CHUNK):
            key, own = jax.random.split(key)
            drawn, failed = chunk(jax.random.split(own, chains), position, mass, data)
            position, used = drawn[:, -1], min(CHUNK, steps - done)
            parts.append(np.asarray(drawn)[:, :used])
            divergent += int(np.sum(np.asarray(failed)[:, :used]))
            said(done + used)
        return np.concatenate(parts, axis=1), divergent

    on_progress(0)
    first, _ = run(warm_up, lambda count: None)
    late = first[:, warm_up // 2 :].reshape(-1, dimension)
    mass = jnp.asarray(np.cov(late.T).reshape(dimension, dimension) + 1e-6 * np.eye(dimension))
    run(warm_up, lambda count: None)
    return run(draws, on_progress)
