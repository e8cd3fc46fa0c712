"""Speed response of a wheel on a fixed bench to a sampled current."""

from typing import Any, Literal, NamedTuple

from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.bearing_equation import BearingEquation, Motion
from gyrostat.wheel.stepping import step_dry_friction
from gyrostat.wheel.wheel import Wheel


class WheelStep(NamedTuple):
    """Where one interval ends.

    Attributes:
        speed: rad/s; exactly zero while the wheel rests.
        resolved: False when the interval needed too many segments.
    """

    speed: Float[Array, ""]
    resolved: Bool[Array, ""]


class _FixedBench(BearingEquation):
    """A wheel whose carrier does not move, with a current on a straight line in time."""

    friction: Any
    wheel: Wheel
    current: Scalar
    slope: Scalar

    def inertia(self) -> Scalar:
        return self.wheel.inertia

    def load(self, carrier: tuple[()], time: Scalar) -> Scalar:
        return self.wheel.motor_constant * (self.current + self.slope * time)

    def carrier_rate(
        self, carrier: tuple[()], speed: Scalar, friction: Scalar, time: Scalar
    ) -> tuple[()]:
        return ()

    def longest_segment(self, time: Scalar) -> Scalar:
        return jnp.inf


def advance(
    wheel: Wheel, speed: Scalar, current: Scalar, slope: Scalar, duration: Scalar
) -> WheelStep:
    """Advance a wheel over one interval in which its current is linear in time.

    Args:
        wheel: the wheel.
        speed: at the start, rad/s; exactly zero is at rest.
        current: at the start, A.
        slope: of the current, A/s; zero for a held current.
        duration: s.

    Returns:
        The speed at the end. Differentiable in forward mode in every argument and parameter.
    """
    bench = _FixedBench(wheel.friction, wheel, current, slope)
    motion, resolved = step_dry_friction(
        bench, Motion(jnp.asarray(speed, dtype=float), ()), duration
    )
    return WheelStep(motion.speed, resolved)


def sample_intervals(
    time: Float[Array, " samples"],
    current: Float[Array, " samples"],
    hold: Literal["zero-order", "linear"],
) -> tuple[Float[Array, " intervals"], Float[Array, " intervals"]]:
    """Length and current slope of the intervals between samples.

    Args:
        time: sample times, s, not decreasing.
        current: motor current at these times, A.
        hold: "zero-order": sample k holds until sample k+1; "linear": straight lines between.

    Returns:
        Lengths, s, and slopes, A/s: zero for a held current or an interval of zero length.

    Raises:
        ValueError: `hold` is neither of the two.
    """
    if hold not in ("zero-order", "linear"):
        raise ValueError(f"hold: found {hold!r}, expected 'zero-order' or 'linear'")
    duration = jnp.diff(time)
    if hold == "zero-order":
        return duration, jnp.zeros_like(duration)
    finite = duration > 0.0
    slope = jnp.where(finite, jnp.diff(current) / jnp.where(finite, duration, 1.0), 0.0)
    return duration, slope


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
    duration, slope = sample_intervals(time, current, hold)

    def interval(carry, sample):
        speed, resolved = carry
        step = advance(wheel, speed, *sample)
        return (step.speed, resolved & step.resolved), step.speed

    start = jnp.asarray(initial_speed, dtype=float)
    (_, resolved), speeds = jax.lax.scan(
        interval, (start, jnp.array(True)), (current[:-1], slope, duration)
    )
    return jnp.concatenate([start[None], speeds]), resolved
