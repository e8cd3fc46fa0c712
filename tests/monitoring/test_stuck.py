"""Sensors that hold one value for a part of a window, and what only looks like it."""

from dataclasses import replace

import numpy as np
import pytest

from gyrostat.monitoring.blocks import Samples
from gyrostat.monitoring.stream import WheelMonitor
from tests.monitoring.closed_loop import NOMINAL
from tests.monitoring.test_stream import WINDOW, flight, known, table_of

__all__ = ["flight"]
TIME = np.arange(WINDOW + 3.0)


def held(values, share):
    """Values with a part of the first window in which they stay."""
    values, start = values.copy(), round(0.3 * WINDOW)
    values[start : start + round(share * WINDOW)] = values[start]
    return values


@pytest.mark.parametrize("column", ["drive", "speed"])
@pytest.mark.parametrize("share", [0.15, 0.5])
def test_minutes_of_a_stuck_sensor_are_left_out(flight, column, share):
    right = table_of(flight)
    values = held(getattr(flight, column), share)
    table = table_of(replace(flight, **{column: values}))
    assert table["valid"].all()
    assert table["stuck_blocks"][0] == pytest.approx(360 * share, abs=3)
    assert not table["stuck_blocks"][1:].any()
    for name in ("coulomb", "viscous", "motor_constant"):
        sigma = table[f"{name}_sigma"][0]
        assert abs(table[name][0] - right[name][0]) < 1.5 * sigma
        assert sigma < right[f"{name}_sigma"][0] * 1.3 / np.sqrt(1.0 - share)


def coasted(current, speed, viscous=1.0):
    """A wheel of which the current is given, from a speed on."""
    speeds = []
    for i in np.broadcast_to(current, TIME.shape):
        speeds.append(speed)
        torque = NOMINAL["motor_constant"] * i - viscous * NOMINAL["viscous"] * speed
        free = speed + torque / NOMINAL["inertia"]
        drop = NOMINAL["coulomb"] / NOMINAL["inertia"]
        speed = np.sign(free) * max(abs(free) - drop, 0.0)
    drive = np.broadcast_to(current, TIME.shape)
    return Samples(TIME, np.array(speeds)[:, None], np.array(drive)[:, None])


def grown(growth):
    """A wheel that holds its speed while its friction changes."""
    drag = (growth * NOMINAL["coulomb"] + 150.0 * NOMINAL["viscous"]) / NOMINAL["motor_constant"]
    drive = np.round(np.broadcast_to(drag, TIME.shape), 3)
    return Samples(TIME, np.full((TIME.size, 1), 150.0), drive[:, None])


@pytest.mark.parametrize(
    "samples",
    [
        coasted(0.0, 200.0),
        coasted(0.0, 200.0, viscous=3.0),
        coasted(0.4, 10.0, viscous=3.0),
        coasted(np.where(TIME < 3000.0, 0.06, -0.06), 100.0),
        grown(np.where(TIME < 9000.0, 1.0, 2.0)),
        grown(1.0 + 0.5 * np.sin(TIME / 600.0)),
        grown(1.0 + 0.8 * (TIME % 3600.0 < 300.0)),
        grown(1.0 + 2.0 * (TIME % 1800.0 < 120.0)),
        grown(1.0 + 1.5 * np.random.default_rng(1).standard_normal(TIME.size)),
    ],
)
def test_ordinary_operation_has_no_stuck_sensor(samples):
    assert not table_of(samples)["stuck_blocks"].any()


def test_a_flight_with_slews_has_no_stuck_sensor(flight):
    assert not table_of(flight)["stuck_blocks"].any()


def test_a_commanded_torque_has_no_sensor(flight):
    monitor = WheelMonitor(known(), window=WINDOW, drive="torque")
    monitor.add(replace(flight, drive=held(flight.drive, 0.5)))
    assert not monitor.windows()["stuck_blocks"].any()


@pytest.mark.parametrize("minutes", [1, 2, 3])
def test_windows_of_a_few_minutes_have_a_row(flight, minutes):
    start = round(WINDOW) - 60 * minutes
    table = table_of(flight.part(slice(start, round(WINDOW) + 7200)))
    assert table["valid"].tolist() == [False, True]
    assert f"{minutes} of {minutes} blocks are usable, at least 30 are" in table["why"][0]
