"""Functions whose general case few runs of a batch compute."""

import numpy as np
import pytest

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rarely import TOGETHER, rarely


def root(x, n):
    """Square root by n steps of Newton's method."""
    return jax.lax.fori_loop(0, n, lambda _, y: 0.5 * (y + x / y), x + 1.0)


def exact(x, scale):
    return {"root": root(x, 60), "scaled": scale * x}


def quick(x, scale):
    # wrong by a constant, so that a test sees which function was used
    return {"root": jnp.sqrt(x) + 100.0, "scaled": scale * x}, x < 1.0


batch = jax.jit(jax.vmap(rarely(quick, exact), (0, None)))


@pytest.mark.parametrize("size", [1, TOGETHER - 1, TOGETHER, 3 * TOGETHER + 2])
@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_every_run_of_a_batch_gets_its_own_result(size, share):
    random = np.random.default_rng(size)
    x = np.where(random.uniform(size=size) < share, 4.0, 0.25) * random.uniform(0.5, 2.0, size)
    found = batch(x, 3.0)
    np.testing.assert_allclose(found["root"], np.sqrt(x) + np.where(x < 1.0, 100.0, 0.0), 1e-14)
    np.testing.assert_array_equal(found["scaled"], 3.0 * x)


def test_a_single_run_computes_the_exact_function():
    assert rarely(quick, exact)(0.25, 1.0)["root"] == pytest.approx(0.5)


def test_derivatives_pass_through_a_batch():
    x = np.array([0.3, 2.0, 5.0])

    def slope(x):
        return jax.jvp(lambda x: rarely(quick, exact)(x, 1.0)["root"], (x,), (1.0,))[1]

    np.testing.assert_allclose(jax.jit(jax.vmap(slope))(x), 0.5 / np.sqrt(x), rtol=1e-12)

    def both(x, dx):
        return jax.jvp(lambda x: rarely(quick, exact)(x, 1.0)["root"], (x,), (dx,))

    value, change = jax.jit(jax.vmap(both))(x, 2.0 * x)
    np.testing.assert_allclose(value, np.sqrt(x), rtol=1e-12)
    np.testing.assert_allclose(change, np.sqrt(x), rtol=1e-12)
    root_of = jax.jit(jax.jacfwd(lambda p: rarely(quick, exact)(p[0], p[1])["root"]))
    one = root_of(jnp.array([2.0, 1.0]))
    np.testing.assert_allclose(one, [0.5 / np.sqrt(2.0), 0.0], rtol=1e-12)


def test_batches_of_batches():
    x = np.linspace(0.1, 3.0, 12).reshape(3, 4)
    found = jax.jit(jax.vmap(batch, (0, None)))(x, 1.0)["root"]
    np.testing.assert_allclose(np.where(found > 50.0, found - 100.0, found), np.sqrt(x), rtol=1e-12)
