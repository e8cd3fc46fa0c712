"""The speed of a wheel driven by a sampled current."""

from typing import Literal

from jaxtyping import Array, Bool, Float

from gyrostat._jax import jax, jnp
from gyrostat.friction import Scalar
from gyrostat.wheel.stepping import advance
from gyrostat.wheel.wheel import Wheel


def speed_response(
    wheel: Wheel,
    time: Float[Array, " samples"],
    current: Float[Array, " samples"],
    initial_speed: Scalar,
    *,
    hold: Literal["zero-order", "linear"] = "zero-order",
) -> tuple[Float[Array, " samples"], Bool[Array, ""]]:
    """Speed of a wheel at the sample times of its current.

    Every interval between samples is one fourth-order step, cut at zero crossings, at sticking and
    at breakaway, and shorter where the friction curve bends. Uneven sample times are taken as they
    are. Works under `jit`, `vmap` and forward-mode differentiation.

    Args:
        wheel: the wheel.
        time: sample times, s, not decreasing; an interval of zero length changes nothing.
        current: motor current at these times, A.
        initial_speed: at the first sample, rad/s.
        hold: "zero-order": sample k holds until sample k+1; "linear": straight lines between.

    Returns:
        The speed at the sample times, rad/s, exactly zero where the wheel rests; and whether every
        interval was resolved (False: the friction curve is too sharp for the sampling).

    Raises:
        ValueError: `hold` is neither of the two.
    """
    if hold not in ("zero-order", "linear"):
        raise ValueError(f"hold: found {hold!r}, expected 'zero-order' or 'linear'")
    duration = jnp.diff(time)
    step_current = jnp.diff(current)
    slope = jnp.where(duration > 0.0, step_current / jnp.where(duration > 0.0, duration, 1.0), 0.0)
    slope = slope if hold == "linear" else jnp.zeros_like(slope)

    def interval(carry, sample):
        speed, resolved = carry
        step = advance(wheel, speed, *sample)
        return (step.speed, resolved & step.resolved), step.speed

    start = jnp.asarray(initial_speed, dtype=float)
    (_, resolved), speeds = jax.lax.scan(
        interval, (start, jnp.array(True)), (current[:-1], slope, duration)
    )
    return jnp.concatenate([start[None], speeds]), resolved
