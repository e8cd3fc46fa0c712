"""Unloading by thrusters: momentum balance, hysteresis, and what the wheels compensate."""

import numpy as np
import pytest

from gyrostat.control import AttitudeRegulator, ThrusterUnloading
from gyrostat.core.errors import InputError
from gyrostat.simulation import simulate, stack
from gyrostat.spacecraft import Gyrostat, Spacecraft, SpacecraftSensor, Thrusters
from gyrostat.wheel import WheelArray, orthogonal_axes

ROTOR, PERIOD = 1e-4, 0.25
WHEELS = WheelArray(orthogonal_axes(), np.full(3, ROTOR), np.full(3, 5e-3), np.full(3, 0.2))
CRAFT = Spacecraft(np.diag([0.24, 0.22, 0.12]), WHEELS)
ARM, FORCE, MINIMUM = 0.1, 0.02, 0.01
BEGIN, END, IMPULSE = 4e-3, 5e-4, 2e-4
STORED = np.array([8e-3, -3e-3, 6e-3])
"""Momentum of the wheels at the start: y is below the threshold."""


@pytest.fixture(scope="module")
def flown(frictionless):
    """Histories with and without compensation."""
    plant = Gyrostat(
        CRAFT, actuators={"thrusters": Thrusters.couples(ARM, FORCE, PERIOD, minimum=MINIMUM)}
    )
    regulator = AttitudeRegulator(CRAFT, np.array([1.0, 0.0, 0.0, 0.0]), torque_weight=1e4).linear()
    laws = [
        ThrusterUnloading(
            regulator, WHEELS, ARM, FORCE, BEGIN, END, IMPULSE, MINIMUM, compensation=share
        )
        for share in (0.0, 1.0)
    ]
    return simulate(
        frictionless(plant),
        stack(laws),
        SpacecraftSensor(plant),
        start=stack([plant.start(wheel_speed=STORED / ROTOR)] * 2),
        duration=30.0,
        control_period=PERIOD,
        runs=2,
    )


def test_the_momentum_changes_by_the_impulse_of_the_thrusters(flown):
    """dH = sum of 2 a F t over the pairs; the wheels end inside the threshold, y is left alone."""
    for run in (0, 1):
        found = flown.isel(run=run)
        on_time = found.thrusters.values[:-1]
        pairs = on_time[:, ::2]
        np.testing.assert_array_equal(pairs, on_time[:, 1::2])
        given = ARM * FORCE * 2.0 * np.sum(pairs[:, ::2] - pairs[:, 1::2], axis=0)
        assert np.all((on_time == 0.0) | (on_time >= MINIMUM))
        assert np.max(2.0 * ARM * FORCE * pairs) == pytest.approx(IMPULSE)
        total = found.momentum.values
        # the body stays within a few degrees, so that body axes are nearly inertial ones
        np.testing.assert_allclose(total[-1] - total[0], given, atol=(5e-4, 2e-6)[run])
        # without compensation the wheels give up the momentum late, and the thrusters overshoot
        left = np.abs(ROTOR * found.wheel_speed.values[-1, [0, 2]])
        assert np.all(left < (BEGIN, 1.1 * END)[run])
        assert not np.any(pairs[:, 2:4])


def test_compensation_removes_most_of_the_disturbance(flown):
    rate = np.linalg.norm(flown.rate.values, axis=-1).max(axis=-1)
    assert rate[1] < 0.1 * rate[0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"end": 5e-3}, "end of the unloading: found 0.005 N·m·s, expected below its begin"),
        ({"end": 1e-5}, "end of the unloading: found 1e-05 N·m·s, expected at least the impulse"),
        ({"impulse": 1e-5}, "impulse of the unloading: found 1e-05 N·m·s, expected at least"),
        ({"force": 0.0}, "thrust: found 0, expected"),
    ],
)
def test_thresholds_that_never_work_are_refused(change, message):
    told = {"arm": ARM, "force": FORCE, "begin": BEGIN, "end": END}
    told |= {"impulse": IMPULSE, "minimum": MINIMUM}
    with pytest.raises(InputError, match=message):
        ThrusterUnloading(None, WHEELS, **(told | change)).check()
