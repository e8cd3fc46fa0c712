"""Functions whose general case is rare, for batches of runs."""

from collections.abc import Callable
from typing import Any

from gyrostat.core.jax64 import jax, jnp

TOGETHER = 8
"""Runs in which the general case is computed together."""


def rarely(quick: Callable[..., Any], exact: Callable[..., Any]) -> Callable[..., Any]:
    """Function that equals `exact`; of a batch by `vmap`, few runs compute it.

    `vmap` computes both branches of a condition in every run of a batch. Here every run of a batch
    computes `quick`, and `exact` is computed for the runs that need it, `TOGETHER` at a time.

    Args:
        quick: Function of trees of arrays; returns a result and whether it is that of `exact`.
        exact: Function of the same arguments; returns a tree of arrays.
    """
    function = jax.custom_batching.custom_vmap(exact)

    @function.def_vmap
    def batched(size: int, in_batched: list[Any], *arguments: Any) -> tuple[Any, Any]:
        leaves, tree = jax.tree.flatten(arguments)
        flags = jax.tree.leaves(in_batched)
        axes = jax.tree.unflatten(tree, [0 if flag else None for flag in flags])
        result, fine = jax.vmap(quick, axes, axis_size=size)(*arguments)
        order, count = jnp.argsort(fine), jnp.sum(~fine)

        def step(carry: tuple[Any, Any]) -> tuple[Any, Any]:
            result, first = carry
            position = first + jnp.arange(TOGETHER)
            at = order[jnp.minimum(position, size - 1)]
            picked = [leaf[at] if flag else leaf for leaf, flag in zip(leaves, flags, strict=True)]
            chunk = jax.vmap(exact, axes, axis_size=TOGETHER)(*jax.tree.unflatten(tree, picked))
            # of the runs beyond the last one nothing is kept
            where = jnp.where(position < count, at, size)
            result = jax.tree.map(
                lambda all, part: all.at[where].set(part, mode="drop"), result, chunk
            )
            return result, first + TOGETHER

        result, _ = jax.lax.while_loop(lambda carry: carry[1] < count, step, (result, 0))
        return result, jax.tree.map(lambda _: True, result)

    # differentiated, the exact function alone is used: a tangent may be of a batch where its value
    # is not
    smooth = jax.custom_jvp(function)
    smooth.defjvp(lambda values, tangents: jax.jvp(exact, values, tangents))
    return smooth
