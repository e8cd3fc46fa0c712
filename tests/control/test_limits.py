"""Half a radian to turn with a tenth of the current that it asks for: nothing winds up."""

from collections import namedtuple

import numpy as np
import pytest

from gyrostat.control import (
    AttitudePID,
    CurrentMode,
    DynamicModelCompensator,
    EstimatingCompensator,
    SpeedMode,
)
from gyrostat.core.jax64 import jax
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck

PERIOD, LIMIT, MOTOR, INERTIA, WHEEL_INERTIA = 0.1, 0.1, 0.0228, 0.495, 1.5e-3
LAW = AttitudePID(0.0571, 0.00234, 0.3126)
FRICTION = Stribeck(1e-9, 1e-7, 1e-7, 0.4)
Measurement = namedtuple("Measurement", ["attitude", "rate", "speed"])


def turned(control):
    """Attitudes and currents on a table whose wheel has no friction worth the name."""

    def tick(carry, _):
        memory, (attitude, rate, speed) = carry
        memory, command = control(memory, Measurement(attitude, rate, speed))
        torque = MOTOR * command.current
        after = rate - torque / INERTIA * PERIOD
        moved = (
            attitude + 0.5 * (rate + after) * PERIOD,
            after,
            speed + torque * (1.0 / WHEEL_INERTIA + 1.0 / INERTIA) * PERIOD,
        )
        return (memory, moved), (attitude, command.current)

    start = (control.start(PERIOD), (0.5, 0.0, 0.0))
    return jax.jit(lambda: jax.lax.scan(tick, start, None, length=1500)[1])()


def limited(kind, limit):
    wheel = Wheel(WHEEL_INERTIA, MOTOR, FRICTION)
    if kind == "law":
        return CurrentMode(AttitudePID(0.0571, 0.00234, 0.3126, MOTOR * limit), MOTOR)
    if kind == "current":
        return CurrentMode(LAW, MOTOR, limit)
    if kind == "model":
        return DynamicModelCompensator(LAW, FRICTION, MOTOR, limit)
    if kind == "speed":
        return SpeedMode(LAW, WHEEL_INERTIA, MOTOR, current_limit=limit)
    return EstimatingCompensator.tune(LAW, wheel, INERTIA, 0.5, PERIOD, current_limit=limit)


@pytest.mark.parametrize("kind", ["law", "current", "model", "speed", "estimating"])
def test_a_limited_current_does_not_overshoot_more_than_a_free_one(kind):
    attitude, current = (np.asarray(x) for x in turned(limited(kind, LIMIT)))
    assert np.max(np.abs(current)) <= LIMIT * (1.0 + 1e-12)
    assert np.sum(np.abs(current) > 0.999 * LIMIT) > 30
    free, wished = (np.asarray(x) for x in turned(limited(kind, np.inf)))
    assert np.max(np.abs(wished)) > 5.0 * LIMIT
    assert np.min(free) < -0.03
    assert np.min(attitude) > np.min(free)
    assert abs(attitude[-1]) < 1e-3
