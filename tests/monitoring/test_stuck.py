"""Sensors that hold one value for a part of a window."""

from dataclasses import replace

import numpy as np
import pytest

from gyrostat.monitoring.blocks import Samples
from tests.monitoring.closed_loop import NOMINAL
from tests.monitoring.test_stream import WINDOW, flight, table_of

__all__ = ["flight"]


def held(values, share):
    """Values with a part of the first window in which they stay."""
    values, start = values.copy(), round(0.3 * WINDOW)
    values[start : start + round(share * WINDOW)] = values[start]
    return values


@pytest.mark.parametrize("column", ["drive", "speed"])
@pytest.mark.parametrize("share", [0.05, 0.5])
def test_minutes_of_a_stuck_sensor_are_left_out(flight, column, share):
    right = table_of(flight)
    table = table_of(replace(flight, **{column: held(getattr(flight, column), share)}))
    assert table["valid"].all()
    assert not right["stuck_blocks"].any()
    assert table["stuck_blocks"][0] == pytest.approx(360 * share, abs=2 + 9)
    assert not table["stuck_blocks"][1:].any()
    for name in ("coulomb", "viscous", "motor_constant"):
        sigma = table[f"{name}_sigma"][0]
        assert abs(table[name][0] - right[name][0]) < 1.5 * sigma
        assert sigma < right[f"{name}_sigma"][0] * 1.3 / np.sqrt(1.0 - share)


def test_one_value_that_the_motion_explains_is_not_stuck():
    # a constant current drives the wheel to its final speed; inertia and friction are 10 % off
    time = np.arange(0.0, 7200.0)
    speed, current = 100.0, 0.1
    torque, inertia = NOMINAL["motor_constant"] * current, 1.1 * NOMINAL["inertia"]
    speeds = []
    for _ in time:
        speeds.append(speed)
        speed += (torque - 0.9 * (NOMINAL["coulomb"] + NOMINAL["viscous"] * speed)) / inertia
    constant = Samples(time, np.array(speeds)[:, None], np.full((time.size, 1), current))
    assert not table_of(constant)["stuck_blocks"].any()
