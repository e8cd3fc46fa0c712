"""The wheel on a bench against closed forms, and what bench and sensor refuse."""

import numpy as np
import pytest

from gyrostat.control import ProportionalMomentumControl
from gyrostat.core.errors import InputError
from gyrostat.papers.moreira_lopes_kuga.bench_wheel import BenchWheel, MomentumSensor, TorqueCommand
from gyrostat.simulation import simulate
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import LuGre, Stribeck, ViscousCoulomb

J, B, C = 0.02, 1e-3, 5e-3
BENCH = BenchWheel(Wheel(J, 1.0, ViscousCoulomb(B, C)))
STRIBECK = {"viscous": B, "coulomb": C, "static": C, "stribeck_speed": 1.0}


def test_a_fading_torque_is_integrated():
    """J dw/dt = u + f exp(-g t) - b w - c, linear while the wheel turns."""
    u, f, g, w, t = 0.02, -0.03, 0.7, 50.0, 3.0
    state, resolved = BENCH(BENCH.start(speed=w), TorqueCommand(u, f, g), 0.0, t)
    rate, steady, forced = B / J, (u - C) / B, f / (B - g * J)
    expected = steady + forced * np.exp(-g * t) + (w - steady - forced) * np.exp(-rate * t)
    assert bool(resolved)
    # steps of a fifth of its time constant leave 3e-7 of what the fading torque does
    assert float(state.speed) == pytest.approx(expected, abs=1e-6 * abs(f) / (J * g))


@pytest.mark.parametrize(
    ("speed", "command", "friction"),
    [
        (50.0, TorqueCommand(0.0), B * 50.0 + C),
        (-50.0, TorqueCommand(0.0), -B * 50.0 - C),
        (0.0, TorqueCommand(1e-3, 2e-3, 1.0), 3e-3),
        (0.0, TorqueCommand(-1.0), -C),
        (0.0, TorqueCommand(0.0), 0.0),
    ],
)
def test_the_record_is_the_friction_that_acts(speed, command, friction):
    record = BENCH.record(BENCH.start(speed=speed), command)
    assert float(record.friction) == pytest.approx(friction, rel=1e-12)
    assert float(record.momentum) == J * speed


@pytest.mark.parametrize(
    ("plant", "sensor", "message"),
    [
        (BenchWheel(Wheel(0.0, 1.0, ViscousCoulomb(B, C))), {}, "wheel inertia: found 0"),
        (
            BenchWheel(Wheel(J, 1.0, ViscousCoulomb.of(viscous=-B, coulomb=C))),
            {},
            "viscous: found -0.001",
        ),
        (
            BenchWheel(Wheel(J, 1.0, Stribeck.of(**{**STRIBECK, "stribeck_speed": 0.0}))),
            {},
            "stribeck_speed: found 0",
        ),
        (
            BenchWheel(Wheel(J, 1.0, LuGre(Stribeck(**{**STRIBECK, "static": 0.5 * C}), 1.0, 0.0))),
            {},
            "bristle level at rest: found 0.0025 N·m",
        ),
        (BENCH, {"inertia": 0.0}, "sensor inertia: found 0"),
        (BENCH, {"inertia": np.nan}, "sensor inertia: found nan"),
        (BENCH, {"sigma": -1.0}, "momentum sigma: found -1"),
    ],
)
def test_what_no_bench_has_is_refused(plant, sensor, message):
    with pytest.raises(InputError, match=message):
        simulate(
            plant,
            ProportionalMomentumControl(0.02, lambda time: 1.0),
            MomentumSensor(**{"inertia": J, "sigma": 0.01, **sensor}),
            start=BENCH.start(),
            duration=2.0,
            control_period=1.0,
        )
