"""Zero crossings with a noisy tachometer and a wrong model: comparison of controllers.

In every run the controller's model is at a corner of c, b ±10 %, k_m ±2 %, T_s ±20 %, table inertia
±3 %. The initial wheel speed is within ±40 rpm; there is one period of command delay and gyro
noise.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from gyrostat.control import CurrentMode, DynamicModelCompensator, EstimatingCompensator, SpeedMode
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.papers.carrara_kuga import setup
from gyrostat.papers.carrara_kuga import table_figures as figures
from gyrostat.papers.carrara_kuga.table import crossings, fly, peaks, settled, wander
from gyrostat.papers.claims import Value
from gyrostat.papers.figures import Drawing
from gyrostat.papers.reproduction import Part, Run
from gyrostat.simulation import Batch, stack
from gyrostat.spacecraft import AirBearingTable, Gyro, TableSensors
from gyrostat.wheel import LowPass, PulseTachometer, Tachometer, Wheel
from gyrostat.wheel.friction import AnyFriction, DirectionalStribeck, LuGre

if TYPE_CHECKING:
    import xarray as xr

RUNS = 200
DURATION = 312.0
"""Duration, s: a minute after the latest crossing."""
ERRORS = np.array([0.10, 0.10, 0.02, 0.20, 0.03])
"""Relative errors of c, b, k_m, T_s and table inertia in the controller's model."""
SPEED_SPREAD = 40.0 * RPM
"""Largest deviation of the initial wheel speed, rad/s."""
STEP = 0.3
"""Relative change of the friction at the crossing."""
BRISTLE_LENGTH = 0.1
"""Deflection at which bristles under the Coulomb torque slip, rad."""
BRISTLE_DAMPING = 0.3
"""Damping ratio of the rotor on its bristles."""
CLAIMED = (
    *("peak95_white_deg", "peak_max_white_deg", "peak95_hall_deg", "peak_max_hall_deg"),
    *("peak95_step30_deg", "peak95_lugre_deg", "chatter95_A", "sign_changes95_per_s", "hunt_deg"),
)
"""Quantities in the claims on the compensator."""
SHOWN = ("pid", "dmc_raw", "speed_mode", "compensator")
"""Controllers in the figure of one crossing."""
GYRO = Gyro(sigma=np.radians(0.002))
WHITE = TableSensors(GYRO, Tachometer(setup.SPEED_SIGMA))
HALL = TableSensors(GYRO, PulseTachometer(24.0))
FILTERED = TableSensors(GYRO, LowPass(Tachometer(setup.SPEED_SIGMA), 0.5))
FILTERED_HALL = TableSensors(GYRO, LowPass(PulseTachometer(24.0), 0.5))


def _table(
    friction: AnyFriction,
    motor_constant: Any = setup.WHEEL.motor_constant,
    inertia: Any = setup.TABLE_INERTIA,
) -> AirBearingTable:
    """Table with fan: the plant, or a controller's model of it; the rotor inertia is known."""
    wheel = Wheel(setup.WHEEL.inertia, motor_constant, friction)
    return AirBearingTable(inertia, wheel, external_torque=setup.FAN_TORQUE)


WRONG = _table(
    setup.scaled(1.1, 1.2, 0.9), 0.98 * setup.WHEEL.motor_constant, 1.03 * setup.TABLE_INERTIA
)
"""A corner of the dispersed runs: c 10 % and T_s 20 % too large, k_m too small."""


@dataclass(frozen=True)
class Candidate:
    """A controller of the comparison.

    Attributes:
        key: Name in the ids of its claims.
        name: Name in figures.
        colour: Colour of its lines.
        make: Builds the controller from its plant model.
        white: Sensors with white tachometer noise.
        hall: Sensors with a pulse-counting tachometer.
    """

    key: str
    name: str
    colour: str
    make: Callable[[AirBearingTable], Any]
    white: TableSensors = field(default=WHITE)
    hall: TableSensors = field(default=HALL)


def _estimating(model: AirBearingTable) -> EstimatingCompensator:
    return EstimatingCompensator.tune(
        setup.LAW, model.wheel, model.inertia, setup.SPEED_SIGMA, setup.PERIOD, delay=1
    )


def _model_compensator(model: Any) -> DynamicModelCompensator:
    return DynamicModelCompensator(setup.LAW, model.wheel.friction, model.wheel.motor_constant)


CANDIDATES = (
    Candidate("compensator", "estimating compensator", "#1f5fa8", _estimating),
    Candidate(
        "pid", "PID", "#c8461e", lambda model: CurrentMode(setup.LAW, model.wheel.motor_constant)
    ),
    Candidate("dmc_raw", "model compensator, raw tachometer", "#d99a2b", _model_compensator),
    Candidate(
        "dmc_filtered",
        "model compensator, filtered tachometer",
        "#8a8f98",
        _model_compensator,
        white=FILTERED,
        hall=FILTERED_HALL,
    ),
    Candidate(
        "speed_mode",
        "speed mode",
        "#3f8f5b",
        lambda model: SpeedMode(setup.LAW, setup.WHEEL.inertia, model.wheel.motor_constant),
    ),
)


def _corners(random: np.random.Generator, runs: int) -> AirBearingTable:
    factor = 1.0 + ERRORS * random.choice([-1.0, 1.0], size=(runs, len(ERRORS)))
    coulomb, viscous, motor, static, inertia = jnp.asarray(factor.T)
    return _table(
        setup.scaled(coulomb, static, viscous),
        setup.WHEEL.motor_constant * motor,
        setup.TABLE_INERTIA * inertia,
    )


def for_each(controller: Any, runs: int) -> Batch:
    """Controller with separate parameter values for each run."""
    return Batch(
        jax.tree.map(lambda x: jnp.broadcast_to(jnp.asarray(x, dtype=float), (runs,)), controller)
    )


def _stepped(factor: float) -> AirBearingTable:
    """Table whose wheel friction is multiplied by `factor` in the sense after the crossing."""
    friction = DirectionalStribeck(
        viscous_positive=setup.STATISTICAL.viscous * factor,
        viscous_negative=setup.STATISTICAL.viscous,
        coulomb_positive=setup.STATISTICAL.coulomb * factor,
        coulomb_negative=setup.STATISTICAL.coulomb,
        static_positive=setup.STATISTICAL.static * factor,
        static_negative=setup.STATISTICAL.static,
        stribeck_speed=setup.STRIBECK_SPEED,
    )
    return _table(friction)


def presliding() -> AirBearingTable:
    """Table whose wheel has bristle friction: 0.1 rad deflection before slip, damping ratio 0.3."""
    stiffness = setup.STATISTICAL.coulomb / BRISTLE_LENGTH
    damping = 2.0 * BRISTLE_DAMPING * math.sqrt(stiffness * setup.INERTIA)
    return _table(LuGre(setup.STATISTICAL.friction(), stiffness, damping))


def _chatter(histories: "xr.Dataset") -> tuple[Vector, Vector]:
    """Rms deviation of each current from its running mean, A, and sign changes per second."""
    current, time = histories.commanded_current.values, histories.time.values[None]
    crossing = crossings(histories)[:, None]
    near = (time > crossing - 10.0) & (time < crossing + 20.0)
    mean = np.stack([np.convolve(c, np.full(11, 1.0 / 11.0), "same") for c in current])
    rms = np.sqrt(np.mean((current - mean) ** 2, axis=1, where=near))
    changes = np.sign(current[:, 1:]) != np.sign(current[:, :-1])
    return rms, np.sum(changes & near[:, 1:], axis=1) / 30.0


def evaluate(candidate: Candidate, runs: int) -> dict[str, float]:
    """Simulate a controller in every case. Errors, speeds and noise are the same for all.

    Args:
        candidate: Controller with its sensors.
        runs: Number of runs of each case.

    Returns:
        Quantity -> value, in the unit of its claim; and `incomplete`, the number of runs that
        diverged or were not resolved.
    """
    random = np.random.default_rng(0)
    controller = for_each(candidate.make(_corners(random, runs)), runs)
    speeds = setup.INITIAL_SPEED + random.uniform(-SPEED_SPREAD, SPEED_SPREAD, runs)
    start = stack([setup.TABLE.start(speed=speed) for speed in speeds])
    options: dict[str, Any] = {"runs": runs, "command_delay": 1, "seed": 1}

    def fly_with(plant: AirBearingTable, sensors: TableSensors) -> "xr.Dataset":
        return fly(controller, DURATION, plant=plant, sensors=sensors, start=start, **options)

    white, hall = fly_with(setup.TABLE, candidate.white), fly_with(setup.TABLE, candidate.hall)
    plants = _stepped(1.0 - STEP), _stepped(1.0 + STEP), presliding()
    *stepped, lugre = [fly_with(plant, candidate.white) for plant in plants]
    worse = max(stepped, key=lambda flight: _ninety_five(peaks(flight, "measured_attitude", 5.0)))
    too_much = _table(setup.scaled(1.1, 1.1))
    hunts = settled(candidate.make(too_much), sensors=candidate.white, **options)
    cases = {"white": white, "hall": hall, "step30": worse, "lugre": lugre}
    largest = {case: peaks(flight, "measured_attitude", 5.0) for case, flight in cases.items()}
    chatter, changes = zip(*(_chatter(flight) for flight in (white, hall)), strict=True)
    every = (white, hall, *stepped, lugre, hunts)
    return {
        **{f"peak95_{case}_deg": _ninety_five(values) for case, values in largest.items()},
        **{f"peak_max_{case}_deg": float(np.max(largest[case])) for case in ("white", "hall")},
        **{
            f"true_peak95_{case}_deg": _ninety_five(peaks(flight, "attitude", 5.0))
            for case, flight in (("white", white), ("hall", hall))
        },
        "chatter95_A": max(map(_ninety_five, chatter)),
        "sign_changes95_per_s": max(map(_ninety_five, changes)),
        "hunt_deg": float(np.max(wander(hunts.measured_attitude))),
        "incomplete": float(sum(np.sum(flight.status.values != 0) for flight in every)),
    }


def _ninety_five(values: Vector) -> float:
    return float(np.percentile(values, 95.0))


def crossing_figure() -> Figure:
    """Plot attitude error and current around one crossing, for four controllers."""
    candidates, flights = [c for key in SHOWN for c in CANDIDATES if c.key == key], {}
    for c in candidates:
        histories = fly(c.make(WRONG), DURATION, sensors=c.white, command_delay=1, seed=1)
        flights[c.key] = histories.assign_coords(time=histories.time - crossings(histories)[0])
    return figures.crossing({c.key: (c.name, c.colour) for c in candidates}, flights)


def dispersed_runs(run: Run) -> Part:
    """Simulate the dispersed runs with every controller."""
    numbers = {}
    for candidate in CANDIDATES:
        run.say(f"{RUNS} dispersed runs in each case, {candidate.name}")
        numbers[candidate.key] = evaluate(candidate, RUNS)
    title = "Zero crossing under several controllers"
    return claimed(numbers, (Drawing(title, crossing_figure(), figures.CROSSING),))


def claimed(numbers: Mapping[str, Mapping[str, float]], drawings: tuple[Drawing, ...] = ()) -> Part:
    """Values for the claims on the estimating compensator; those of the others become facts.

    Args:
        numbers: Values of each controller, by its key.
        drawings: Figures.
    """
    ours = numbers["compensator"]
    values: dict[str, Value] = {f"compensator.{name}": ours[name] for name in CLAIMED}
    comparison = {
        name: "; ".join(f"{c.name} {numbers[c.key][name]:.3g}" for c in CANDIDATES[1:])
        for name in CLAIMED
    }
    return Part(values, {"beside": comparison, "compensator": ours}, drawings)
