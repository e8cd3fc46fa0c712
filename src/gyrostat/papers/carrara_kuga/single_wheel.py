"""What follows from the model of the wheel alone: breakaway, coasting, the jump at zero speed."""

from collections.abc import Callable

import numpy as np

from gyrostat.friction import Stribeck
from gyrostat.papers.carrara_kuga.drawings import friction_drawing
from gyrostat.papers.carrara_kuga.printed import (
    CONVERGED,
    INERTIA,
    SPEED_SIGMA,
    STATISTICAL,
    STRIBECK_SPEED,
)
from gyrostat.papers.carrara_kuga.virtual_bench import modelled_speed, profile2
from gyrostat.papers.claims import Claim
from gyrostat.papers.reproduction import Part
from gyrostat.units import RPM
from gyrostat.wheel import Wheel

HALVINGS = 60
"""Of an interval: to the last bit."""
COAST_FROM = 100.0 * RPM
"""rad/s."""


def breakaway_current(wheel: Wheel) -> float:
    """Smallest held current at which the wheel leaves rest within a second, A."""

    def leaves(current: float) -> bool:
        held = np.array([current, current])
        return bool(modelled_speed(wheel, np.array([0.0, 1.0]), held, 0.0)[-1] != 0.0)

    return _threshold(leaves, 0.0, 1.0)


def stop_time(wheel: Wheel, initial_speed: float) -> float:
    """Time after which a coasting wheel rests, s."""

    def rests(duration: float) -> bool:
        time = np.array([0.0, duration])
        return bool(modelled_speed(wheel, time, np.zeros(2), initial_speed)[-1] == 0.0)

    return _threshold(rests, 0.0, 1000.0)


def single_wheel() -> Part:
    """Judge what the model says of one wheel."""
    return Part(
        claims=(_breakaway(), _coast(), _jump(), _inertia()), drawings=(friction_drawing(),)
    )


def _threshold(reached: Callable[[float], bool], low: float, high: float) -> float:
    """Where a condition that holds at `high` and not at `low` begins to hold."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if reached(middle) else (middle, high)
    return high


def _breakaway() -> Claim:
    found = breakaway_current(STATISTICAL.wheel())
    expected = STATISTICAL.static / STATISTICAL.motor_constant
    return Claim(
        id="breakaway.current_A",
        quantity="held current at which the simulated wheel leaves rest",
        ours=found,
        unit="A",
        why=f"Found by halving the held current; T_s / k_m of Table 1 is {expected:.6g} A.",
    )


def _coast() -> Claim:
    _, viscous, coulomb, _ = CONVERGED
    friction = Stribeck(INERTIA * viscous, INERTIA * coulomb, INERTIA * coulomb, STRIBECK_SPEED)
    found = stop_time(Wheel(INERTIA, STATISTICAL.motor_constant, friction), COAST_FROM)
    expected = np.log1p(viscous * COAST_FROM / coulomb) / viscous
    return Claim(
        id="coast.stop_time_s",
        quantity="time in which the wheel coasts from 100 rpm to rest, T_s = c",
        ours=found,
        unit="s",
        why=f"Found by simulation, b and c of eq. (16); the closed form gives {expected:.8g} s.",
    )


def _jump() -> Claim:
    friction = STATISTICAL.friction()
    jump = float(friction.torque(0.0, 1.0)) - float(friction.torque(0.0, -1.0))
    return Claim(
        id="stribeck.jump_at_zero_speed",
        quantity="jump of the friction torque where the rotation reverses",
        paper=0.0,
        ours=jump,
        unit="N·m",
        tolerance=0.0,
        why="The introduction says that the Stribeck term presents no discontinuity, but eq. (1) "
        "jumps by 2 T_s at zero speed, so a rule for sticking is needed.",
    )


def _inertia() -> Claim:
    factor = 1.1
    friction = Stribeck(
        viscous=factor * STATISTICAL.viscous,
        coulomb=factor * STATISTICAL.coulomb,
        static=factor * STATISTICAL.static,
        stribeck_speed=STRIBECK_SPEED,
    )
    scaled = Wheel(factor * INERTIA, factor * STATISTICAL.motor_constant, friction)
    record = profile2(0)
    speeds = [
        modelled_speed(wheel, record.time, record.current, 0.0)
        for wheel in (STATISTICAL.wheel(), scaled)
    ]
    return Claim(
        id="inertia.not_separable",
        quantity="the inertia cannot be estimated apart from the other parameters",
        paper=True,
        ours=bool(np.max(np.abs(speeds[1] - speeds[0])) < 1e-6 * SPEED_SIGMA),
        unit="",
        tolerance=0.0,
        why="Inertia, motor constant and all friction torques 10 % larger together give the same "
        "speed on profile 2.",
    )
