"""Random-walk Metropolis sampler of blackjax, in many short chains.

A proposal needs the density alone: its gradient, by the sensitivities of all samples, costs several
times as much, and a posterior of few parameters gains little by it. The chains advance together in
one compiled program and share the covariance that they find (Haario, Saksman and Tamminen 2001, An
adaptive Metropolis algorithm, Bernoulli 7); it is fixed before the first draw.
"""

from collections.abc import Callable
from functools import lru_cache
from importlib.util import find_spec
from typing import Any

import numpy as np

from gyrostat.core.extras import missing
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Vector

CHAINS, STAGES, DRAWS = 32, 5, 150
"""Chains, which advance together; stages of warm-up, a chunk each; draws of each chain."""
THINNED, CHUNK = 10, 10
"""Steps from draw to draw, and draws of a chunk."""
WANTED = 0.25
"""Rate of accepted steps towards which the warm-up adjusts their size; between the optimum of one
dimension, 0.44, and of many, 0.234 (Roberts and Rosenthal 2001, Statistical Science 16)."""


def check_sampler() -> None:
    """Refuse to start where the sampler is not installed.

    Raises:
        InputError: blackjax is not installed.
    """
    if find_spec("blackjax") is None:
        raise missing("--posterior", "blackjax", "posterior")


def chain(log_density: Callable) -> Callable:
    """CHUNK draws of one chain: function (key, position, root, data) -> draws, rate of acceptance.

    Args:
        log_density: Function (u, data) -> logarithm of the density.
    """
    import blackjax  # pyright: ignore[reportMissingImports]

    def chunk(key, position, root, data):
        walk = blackjax.additive_step_random_walk.normal_random_walk(
            lambda u: log_density(u, data), root
        )

        def step(state, step_key):
            state, info = walk.step(step_key, state)
            return state, info.is_accepted

        def draw(state, keys):
            state, acceptance = jax.lax.scan(step, state, keys)
            return state, (state.position, jnp.mean(acceptance))

        keys = jax.random.split(key, (CHUNK, THINNED))
        return jax.lax.scan(draw, walk.init(position), keys)[1]

    return chunk


@lru_cache
def _program(log_density: Callable):
    """Compile CHUNK draws of several chains."""
    return jax.jit(jax.vmap(chain(log_density), (0, 0, None, None)))


def sample(
    log_density: Callable,
    data: Any,
    dimension: int,
    *,
    seed: int = 0,
    chains: int = CHAINS,
    draws: int = DRAWS,
    on_progress: Callable[[int], None] = lambda count: None,
) -> tuple[Vector, float]:
    """Draw from a density by several chains.

    Args:
        log_density: Function (u, data) -> logarithm of the density; u of about unit scale around
            zero.
        data: Pytree of arrays.
        dimension: Length n of u.
        seed: Seed of all random numbers.
        chains: Number of chains.
        draws: Draws of each chain, a multiple of `CHUNK`.
        on_progress: Called with the draws of each chain so far, 0 before the warm-up.

    Returns:
        Draws, (chains, draws, n), and the rate of accepted steps.
    """
    chunk = _program(log_density)
    on_progress(0)
    key, start_key = jax.random.split(jax.random.key(seed))
    position, covariance = jax.random.normal(start_key, (chains, dimension)), np.eye(dimension)
    # best size of the steps in a Gaussian of this covariance (Roberts and Rosenthal)
    size, parts, rates = 2.38 / np.sqrt(dimension), [], []
    for k in range(STAGES + draws // CHUNK):
        key, chunk_key = jax.random.split(key)
        root: Any = np.linalg.cholesky(covariance)
        block, acceptance = chunk(jax.random.split(chunk_key, chains), position, size * root, data)
        position, rate = block[:, -1], float(jnp.mean(acceptance))
        if k < STAGES:
            size *= 2.0 ** np.clip(rate / WANTED - 1.0, -1.0, 1.0)
            late = np.asarray(block[:, CHUNK // 2 :]).reshape(-1, dimension)
            covariance = np.cov(late.T).reshape(dimension, dimension) + 1e-6 * np.eye(dimension)
        else:
            parts.append(np.asarray(block))
            rates.append(rate)
            on_progress(CHUNK * len(parts))
    return np.concatenate(parts, axis=1), float(np.mean(rates))
