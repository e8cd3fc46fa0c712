"""Speed response of a wheel on a fixed bench to a sampled current."""

from typing import Any, Literal, NamedTuple

from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.bearing_equation import BearingEquation, Motion
from gyrostat.wheel.stepping import step_dry_friction
from gyrostat.wheel.wheel import Wheel


class WheelStep(NamedTuple):
    """Result of one interval.

    Attributes:
        speed: Wheel speed at the end, rad/s; exactly zero while the wheel rests.
        resolved: Whether the interval was resolved; False if it needed too many segments.
    """

    speed: Float[Array, ""]
    resolved: Bool[Array, ""]


class _FixedBench(BearingEquation):
    """Wheel on a carrier that does not move, with a current that is linear in time."""

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

    def is_steady(self) -> bool:
        return isinstance(self.slope, float) and self.slope == 0.0


def advance(
    wheel: Wheel, speed: Scalar, current: Scalar, slope: Scalar, duration: Scalar
) -> WheelStep:
    """Advance a wheel over one interval in which its current is linear in time.

    Args:
        wheel: Wheel.
        speed: Speed at the start, rad/s; exactly zero is at rest.
        current: Current at the start, A.
        slope: Slope of the current, A/s; the number 0.0 for a constant current, for which the wheel
            cannot turn back within the interval.
        duration: Length of the interval, s.

    Returns:
        Speed at the end, and whether the interval was resolved. Differentiable in forward mode in
        every argument and parameter.
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
    """Lengths and current slopes of the intervals between samples.

    Args:
        time: Sample times, (samples,), s, not decreasing.
        current: Motor current at these times, (samples,), A.
        hold: "zero-order": sample k is held until sample k+1; "linear": linear interpolation.

    Returns:
        Lengths, (intervals,), s, and slopes, (intervals,), A/s. A slope is zero for a held current
        or an interval of zero length.

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


def slope_within(slope: Scalar, hold: Literal["zero-order", "linear"]) -> Scalar:
    """Slope of the current within an interval, for `advance`: the number 0.0 of a held current."""
    return 0.0 if hold == "zero-order" else slope


def speed_response(
    wheel: Wheel,
    time: Float[Array, " samples"],
    current: Float[Array, " samples"],
    initial_speed: Scalar,
    *,
    hold: Literal["zero-order", "linear"] = "zero-order",
) -> tuple[Float[Array, " samples"], Bool[Array, ""]]:
    """Speed of a wheel at the sample times of its current.

    Every interval between samples is one fourth-order step. It is divided at zero crossings, at
    sticking and at breakaway, and into shorter steps where the friction curve bends. Sample times
    need not be uniform. Works under `jit`, `vmap` and forward-mode differentiation.

    Args:
        wheel: Wheel.
        time: Sample times, (samples,), s, not decreasing; an interval of zero length has no effect.
        current: Motor current at these times, (samples,), A.
        initial_speed: Speed at the first sample, rad/s.
        hold: "zero-order": sample k is held until sample k+1; "linear": linear interpolation.

    Returns:
        Speed at the sample times, (samples,), rad/s, exactly zero while the wheel rests; and
        whether every interval was resolved. False means that the friction curve is too steep for
        the sampling.

    Raises:
        ValueError: `hold` is neither of the two.
    """
    duration, slope = sample_intervals(time, current, hold)

    def interval(carry, sample):
        speed, resolved = carry
        start, change, length = sample
        step = advance(wheel, speed, start, slope_within(change, hold), length)
        return (step.speed, resolved & step.resolved), step.speed

    start = jnp.asarray(initial_speed, dtype=float)
    (_, resolved), speeds = jax.lax.scan(
        interval, (start, jnp.array(True)), (current[:-1], slope, duration)
    )
    return jnp.concatenate([start[None], speeds]), resolved
