"""Crossing zero with a noisy tachometer and a wrong model: the controllers side by side.

Every run has the controller's model at a corner of c, b ±10 %, k_m ±2 %, T_s ±20 %, table inertia
±3 %, a wheel that starts within ±40 rpm, one period of command delay and a noisy gyro.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gyrostat._jax import jax, jnp
from gyrostat._types import Matrix, Vector
from gyrostat.body import AirBearingTable, Gyro, TableSensors
from gyrostat.control import (
    CurrentMode,
    DynamicModelCompensator,
    EstimatingCompensator,
    SpeedMode,
)
from gyrostat.friction import DirectionalStribeck, Friction, LuGre
from gyrostat.papers.carrara_kuga.printed import INERTIA, SPEED_SIGMA, STATISTICAL, STRIBECK_SPEED
from gyrostat.papers.carrara_kuga.table import (
    FAN_TORQUE,
    INITIAL_SPEED,
    LAW,
    PERIOD,
    TABLE,
    TABLE_INERTIA,
    WHEEL,
    TableRun,
    fly,
    scaled,
    settled,
    wander,
)
from gyrostat.simulate import Batch, stack
from gyrostat.units import RPM
from gyrostat.wheel import LowPass, PulseTachometer, Tachometer, Wheel

RUNS = 200
DURATION = 312.0
"""s: a minute past the latest crossing."""
ERRORS = np.array([0.10, 0.10, 0.02, 0.20, 0.03])
"""Of c, b, k_m, T_s and table inertia in the controller's model."""
SPEED_SPREAD = 40.0 * RPM
"""rad/s: of the initial wheel speed."""
PULSES = 24.0
STEP = 0.3
"""Share by which the friction changes at the crossing."""
BRISTLE_LENGTH = 0.1
"""rad: deflection at which bristles under the Coulomb torque slip."""
BRISTLE_DAMPING = 0.3
"""Damping ratio of the rotor on its bristles."""
FILTER_TIME = 0.5
"""s: of the filtered tachometer."""
GYRO = Gyro(sigma=np.radians(0.002))
WHITE = TableSensors(GYRO, Tachometer(SPEED_SIGMA))
HALL = TableSensors(GYRO, PulseTachometer(PULSES))
FILTERED = TableSensors(GYRO, LowPass(Tachometer(SPEED_SIGMA), FILTER_TIME))
FILTERED_HALL = TableSensors(GYRO, LowPass(PulseTachometer(PULSES), FILTER_TIME))
GOAL = 0.04
"""deg, in 95 % of the runs."""

SETTINGS = (
    f"Dispersed runs: {RUNS} for each case and controller; every run at a corner of c, b ±10 %, "
    "k_m ±2 %, T_s ±20 %, table inertia ±3 % in the controller's model, initial wheel speed within "
    "±40 rpm, one period of command delay, gyro noise 0.002 deg/s a sample.",
    "Their peak is the largest attitude integrated from the gyro, from 5 s before to 60 s after "
    "the crossing; chatter is the rms of the current minus its centred 11-sample mean, from 10 s "
    "before to 20 s after.",
    "Hunting: no fan, wheel at rest, from 0.5 deg, c and T_s over-estimated by 10 %, 5 rpm noise; "
    "largest deviation from the mean over 600 s after the first 100 s.",
    "Presliding: LuGre friction whose bristles bend by 0.1 rad under the Coulomb torque, damping "
    "ratio 0.3.",
    "The compensator has one tuning for all cases: that of EstimatingCompensator.tuned for 5 rpm.",
)


@dataclass(frozen=True)
class Known:
    """What a controller believes.

    Attributes:
        friction: its friction model.
        motor_constant: N·m/A.
        table_inertia: kg·m².
    """

    friction: Friction
    motor_constant: Any
    table_inertia: Any

    def wheel(self) -> Wheel:
        """Its wheel: the inertia is known."""
        return Wheel(WHEEL.inertia, self.motor_constant, self.friction)


@dataclass(frozen=True)
class Contender:
    """A controller of the comparison.

    Attributes:
        key: in the ids of its claims.
        name: for a person.
        colour: of its lines.
        make: builds it from what it believes.
        white: sensors with white tachometer noise.
        hall: sensors with counted pulses.
    """

    key: str
    name: str
    colour: str
    make: Callable[[Known], Any]
    white: TableSensors = field(default=WHITE)
    hall: TableSensors = field(default=HALL)


def _estimating(known: Known) -> EstimatingCompensator:
    return EstimatingCompensator.tuned(
        LAW, known.wheel(), known.table_inertia, SPEED_SIGMA, PERIOD, delay=1
    )


def _model_compensator(known: Known) -> DynamicModelCompensator:
    return DynamicModelCompensator(LAW, known.friction, known.motor_constant)


CONTENDERS = (
    Contender("compensator", "estimating compensator", "#1f5fa8", _estimating),
    Contender("pid", "PID", "#c8461e", lambda known: CurrentMode(LAW, known.motor_constant)),
    Contender("dmc_raw", "model compensator, raw tachometer", "#d99a2b", _model_compensator),
    Contender(
        "dmc_filtered",
        "model compensator, filtered tachometer",
        "#8a8f98",
        _model_compensator,
        white=FILTERED,
        hall=FILTERED_HALL,
    ),
    Contender(
        "speed_mode",
        "speed mode",
        "#3f8f5b",
        lambda known: SpeedMode(LAW, WHEEL.inertia, known.motor_constant),
    ),
)


def _corners(random: np.random.Generator, runs: int) -> Known:
    factor = 1.0 + ERRORS * random.choice([-1.0, 1.0], size=(runs, len(ERRORS)))
    coulomb, viscous, motor, static, inertia = jnp.asarray(factor.T)
    return Known(
        scaled(coulomb, static, viscous), WHEEL.motor_constant * motor, TABLE_INERTIA * inertia
    )


def for_each(controller: Any, runs: int) -> Batch:
    """A controller with one value of every parameter for each run."""
    return Batch(
        jax.tree.map(lambda x: jnp.broadcast_to(jnp.asarray(x, dtype=float), (runs,)), controller)
    )


def _stepped(factor: float) -> AirBearingTable:
    """A wheel whose friction is `factor` times as large in the sense after the crossing."""
    friction = DirectionalStribeck(
        viscous_positive=STATISTICAL.viscous * factor,
        viscous_negative=STATISTICAL.viscous,
        coulomb_positive=STATISTICAL.coulomb * factor,
        coulomb_negative=STATISTICAL.coulomb,
        static_positive=STATISTICAL.static * factor,
        static_negative=STATISTICAL.static,
        stribeck_speed=STRIBECK_SPEED,
    )
    wheel = Wheel(WHEEL.inertia, WHEEL.motor_constant, friction)
    return AirBearingTable(TABLE_INERTIA, wheel, external_torque=FAN_TORQUE)


def presliding() -> AirBearingTable:
    """A wheel on bristles that bend by 0.1 rad before they slip, damping ratio 0.3."""
    stiffness = STATISTICAL.coulomb / BRISTLE_LENGTH
    damping = 2.0 * BRISTLE_DAMPING * math.sqrt(stiffness * INERTIA)
    wheel = Wheel(
        WHEEL.inertia, WHEEL.motor_constant, LuGre(STATISTICAL.friction(), stiffness, damping)
    )
    return AirBearingTable(TABLE_INERTIA, wheel, external_torque=FAN_TORQUE)


def _chatter(flown: TableRun) -> tuple[Vector, Vector]:
    """Rms of each current minus its running mean, A, and its changes of sign in a second."""
    crossing = flown.crossings()[:, None]
    near = (flown.time[None] > crossing - 10.0) & (flown.time[None] < crossing + 20.0)
    mean = np.stack([np.convolve(c, np.full(11, 1.0 / 11.0), "same") for c in flown.current])
    rms = np.sqrt(np.mean((flown.current - mean) ** 2, axis=1, where=near))
    changes = np.sign(flown.current[:, 1:]) != np.sign(flown.current[:, :-1])
    return rms, np.sum(changes & near[:, 1:], axis=1) / 30.0


@dataclass(frozen=True)
class Outcome:
    """What a controller did, each array over the runs.

    Attributes:
        peaks: case -> attitude peaks from the gyro, deg; "step30" holds the worse sign.
        true_peaks: case -> peaks of the true attitude, deg; of the white and Hall cases.
        chatter: of the white and Hall cases, A.
        changes: of sign of the current in these, 1/s.
        hunting: deg.
        incomplete: runs that diverged or were not resolved.
    """

    peaks: Mapping[str, Vector]
    true_peaks: Mapping[str, Vector]
    chatter: Matrix
    changes: Matrix
    hunting: Vector
    incomplete: int


def evaluate(contender: Contender, runs: int) -> Outcome:
    """Fly a controller through every case; equal errors, speeds and noise for every controller."""
    random = np.random.default_rng(0)
    controller = for_each(contender.make(_corners(random, runs)), runs)
    speeds = INITIAL_SPEED + random.uniform(-SPEED_SPREAD, SPEED_SPREAD, runs)
    start = stack([TABLE.start(speed=speed) for speed in speeds])
    options: dict[str, Any] = {"runs": runs, "command_delay": 1, "seed": 1}
    cases = {
        "white": fly(controller, DURATION, sensors=contender.white, start=start, **options),
        "hall": fly(controller, DURATION, sensors=contender.hall, start=start, **options),
    }
    peaks = {name: _gyro_peaks(flown) for name, flown in cases.items()}
    true = {name: np.degrees(f.largest(f.attitude, 5.0, 60.0)) for name, f in cases.items()}
    plants = [_stepped(1.0 - STEP), _stepped(1.0 + STEP), presliding()]
    *stepped, lugre = [
        fly(controller, DURATION, plant=plant, sensors=contender.white, start=start, **options)
        for plant in plants
    ]
    worse = max(stepped, key=lambda f: np.percentile(_gyro_peaks(f), 95.0))
    peaks |= {"step30": _gyro_peaks(worse), "lugre": _gyro_peaks(lugre)}
    noise = [_chatter(flown) for flown in cases.values()]
    too_much = Known(scaled(1.1, 1.1), WHEEL.motor_constant, TABLE_INERTIA)
    hunts = settled(contender.make(too_much), sensors=contender.white, **options)
    flights = (*cases.values(), *stepped, lugre, hunts)
    return Outcome(
        peaks,
        true,
        np.array([rms for rms, _ in noise]),
        np.array([changes for _, changes in noise]),
        wander(hunts.measured, hunts.time),
        sum(int(np.sum(~flown.valid)) for flown in flights),
    )


def _gyro_peaks(flown: TableRun) -> Vector:
    return np.degrees(flown.largest(flown.measured, 5.0, 60.0))
