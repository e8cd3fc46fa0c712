"""Motion of an auxiliary drive in the same closed loop, without noise."""

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.stored_function import stored_function
from gyrostat.core.types import Vector
from gyrostat.identification.drive.control_law import Command, ControlLaw
from gyrostat.identification.drive.motion import Drive, Motion
from gyrostat.identification.fit.prediction import build_wheel, padded, wheel_dimensions
from gyrostat.wheel.friction import Friction
from gyrostat.wheel.response import advance

UNLIMITED = 1e12
"""Current of a drive without a limit, A."""


@lru_cache
def _program(model: type[Friction], kind: type[ControlLaw], differenced: bool):
    """Compile (wheel and bias, gains, time, commanded speed, first speed) -> speeds, currents."""
    names = tuple(wheel_dimensions(model))
    fields = tuple(kind().gains())
    law = kind()

    def simulate(theta, gains, time, reference, first, count):
        wheel = build_wheel(model, dict(zip(names, theta[:-1], strict=True)))
        settings = dict(zip(fields, gains, strict=True))

        def sample(k, carry):
            angle, before, speed, integral, commanded, last, speeds, currents = carry
            period = time[k + 1] - time[k]
            wanted = reference[k]
            change = jnp.where(k > 0, wanted - last, 0.0) / period
            command = Command(commanded, wanted, change)
            measured = (angle - before) / period if differenced else speed
            state = jnp.stack([angle, measured, integral])
            current, integral = law.step(settings, command, state, period)
            end = advance(wheel, speed, current + theta[-1], 0.0, period).speed
            after = angle + 0.5 * period * (speed + end)
            put = jax.lax.dynamic_update_index_in_dim
            outputs = put(speeds, end, k + 1, 0), put(currents, current, k, 0)
            return (after, angle, end, integral, commanded + period * wanted, wanted, *outputs)

        speeds = jnp.zeros_like(time).at[0].set(first)
        zero = jnp.zeros(())
        start = (zero, zero, first, zero, zero, zero, speeds, jnp.zeros_like(time))
        return jax.lax.fori_loop(0, count - 1, sample, start)[-2:]

    return stored_function(simulate, model, kind, differenced)


def simulate_loop(
    drive: Drive, model: type[Friction], values: Mapping[str, float], law: ControlLaw
) -> tuple[Motion, Vector] | None:
    """Motion and current of a drive that follows the reference of a segment.

    Args:
        drive: Segment.
        model: Friction law.
        values: Name -> parameters of the wheel, and current_bias, SI.
        law: Control law.

    Returns:
        Motion, and current of each interval, (n,), A; None if they are not finite.
    """
    names = wheel_dimensions(model)
    # no trial value may push the wheel
    theta = [values[n] if n in model.signed() else max(values[n], 0.0) for n in names]
    time = padded(drive.time - drive.time[0], repeat=True)
    reference = padded(np.append(drive.reference, drive.reference[-1]), repeat=True)
    gains = np.minimum(np.array(list(law.gains().values())), UNLIMITED)
    first, bias = float(drive.measured.speed[0]), values.get("current_bias", 0.0)
    arguments = (np.array([*theta, bias]), gains, time, reference, first, len(drive.time))
    speed, current = (
        np.asarray(part) for part in _program(model, type(law), drive.differenced)(*arguments)
    )
    speed, current = speed[: len(drive.time)], current[: len(drive.time) - 1]
    if not (np.all(np.isfinite(speed)) and np.all(np.isfinite(current))):
        return None
    return Motion(0.5 * (speed[1:] + speed[:-1]), speed), current
