"""The sections on torque mode and on the dynamic model compensator, each claim judged."""

import numpy as np

from gyrostat._jax import jax, jnp
from gyrostat.body import TableCommand, TableSensors
from gyrostat.papers.carrara_kuga.printed import SPEED_SIGMA, STATISTICAL
from gyrostat.papers.carrara_kuga.table import (
    PERIOD,
    PID,
    SPEED_MODE,
    TABLE,
    TableRun,
    compensator,
    fly,
    scaled,
    settled,
    wander,
)
from gyrostat.papers.carrara_kuga.table_drawings import attitude_drawing, current_drawing
from gyrostat.papers.claims import Claim
from gyrostat.papers.reproduction import Part, Say
from gyrostat.wheel import Delayed, Tachometer

DURATION, LONG = 400.0, 640.0
"""s: as far as the figures show; 400 s past the crossing."""
SEEDS, QUICK_SEEDS = 200, 20
LATE_SAMPLES = 10
"""Of a tachometer that is 1 s late."""

SETTINGS = (
    "Table: 0.495 kg·m², fan torque 0.46 mN·m, the wheel of the statistical column at -673.5 rpm, "
    "so that it crosses zero at 230 s.",
    "PID at 10 Hz: 0.0571 N·m/rad, 0.00234 N·m/(rad·s), 0.3126 N·m·s/rad on the true attitude and "
    "rate, from zero attitude; no noise and no delay where none is named.",
    "Peaks are taken from 2 s before to 60 s after the first crossing, start transients from 0 to "
    "100 s.",
    "Speed mode: inner loop of 1 rad/s, damping ratio 1.",
)


def crossing_zero(say: Say, *, quick: bool) -> Part:
    """Judge the paper's statements on crossing zero.

    Args:
        say: told about the progress.
        quick: fewer noise seeds.
    """
    say("carrara-kuga: the table crosses zero under PID, compensator and speed mode")
    pid, speed_mode = fly(PID, LONG), fly(SPEED_MODE, DURATION)
    exact = fly(compensator(STATISTICAL.friction()), DURATION)
    late = TableSensors(tachometer=Delayed(Tachometer(), LATE_SAMPLES))
    delayed = fly(compensator(STATISTICAL.friction()), DURATION, sensors=late)
    seeds = QUICK_SEEDS if quick else SEEDS
    noisy = fly(
        compensator(STATISTICAL.friction()),
        DURATION,
        sensors=TableSensors(tachometer=Tachometer(SPEED_SIGMA)),
        runs=seeds,
    )
    wrong = {
        error: peak(fly(compensator(scaled(1.0 + 0.01 * error)), DURATION)) for error in (-5, 5, 10)
    }
    return Part(
        claims=(
            *_pid_claims(pid),
            *_compensator_claims(exact, wrong, peak(pid)),
            Claim(
                id="table.dmc_peak_noise5rpm_deg",
                quantity="attitude peak at the crossing, compensator on a tachometer with 5 rpm "
                f"noise, median of {seeds} seeds",
                ours=float(np.median(_peaks(noisy))),
                unit="deg",
                why="The sign of the raw sample is wrong for seconds around the crossing: the gain "
                "over the PID falls to about "
                f"{peak(pid) / float(np.median(_peaks(noisy))):.1f}.",
            ),
            _ours("table.dmc_peak_delay1s_deg", "the same, tachometer 1 s late", peak(delayed)),
            _ours("table.speed_mode_peak_deg", "attitude peak, speed mode", peak(speed_mode)),
            *_limit_cycle(),
        ),
        drawings=(
            attitude_drawing("Attitude error under PID (Fig. 7)", pid),
            current_drawing("Motor current under PID (Fig. 8)", pid, parts=False),
            attitude_drawing("Attitude error with the compensator (Fig. 10)", exact),
            current_drawing("Motor current with the compensator (Fig. 11)", exact, parts=True),
            attitude_drawing("Attitude error in speed mode", speed_mode),
        ),
        settings=SETTINGS,
    )


def _peaks(flown: TableRun) -> np.ndarray:
    return np.degrees(flown.largest(flown.attitude, 2.0, 60.0))


def peak(flown: TableRun) -> float:
    """Largest attitude around the crossing of a single run, deg."""
    return float(_peaks(flown)[0])


def _start_transient(flown: TableRun) -> float:
    return float(np.degrees(np.max(np.abs(flown.attitude[0, flown.time < 100.05]))))


def _error_after(flown: TableRun, wait: float) -> float:
    index = round(float(flown.crossings()[0] + wait) / PERIOD)
    return float(np.degrees(abs(flown.attitude[0, index])))


def _ours(name: str, quantity: str, ours: float, why: str = "The paper gives no value.") -> Claim:
    return Claim(id=name, quantity=quantity, ours=ours, unit="deg", why=why)


def _pid_claims(pid: TableRun) -> tuple[Claim, ...]:
    minute, final = _error_after(pid, 60.0), _error_after(pid, 400.0)
    return (
        Claim(
            id="table.pid_peak_deg",
            quantity="attitude peak at the crossing under PID in current mode",
            paper=1.5,
            ours=peak(pid),
            unit="deg",
            tolerance=0.1,
            why="The wheel sticks while the integral builds up twice the friction torque. The "
            "gains, which the paper does not print, were chosen to give this peak.",
        ),
        Claim(
            id="table.pid_error_60s_deg",
            quantity="attitude error 60 s after the crossing under PID",
            paper=0.2,
            ours=minute,
            unit="deg",
            tolerance=0.05,
            why="The 0.2 deg that the paper calls steady is met here, on the way down.",
        ),
        Claim(
            id="table.pid_error_final_deg",
            quantity="attitude error 400 s after the crossing under PID, which the paper calls "
            "0.2 deg in steady state",
            paper=0.2,
            ours=final,
            unit="deg",
            tolerance=0.05,
            why="Integral action leaves no such steady error: what is left follows the slow growth "
            "of viscous friction with speed.",
        ),
        Claim(
            id="table.pid_start_transient_deg",
            quantity="largest attitude error of the first 100 s under PID",
            ours=_start_transient(pid),
            unit="deg",
            why="The paper gives 0.6 deg for the compensator's start; the plain PID starts so.",
        ),
        Claim(
            id="table.stick_time_s",
            quantity="time for which the wheel sticks at the crossing under PID",
            ours=stick_time(pid),
            unit="s",
            why="From the moment the speed reaches zero to the control sample that breaks it away.",
        ),
    )


def _compensator_claims(exact: TableRun, wrong: dict[int, float], pid_peak: float):
    worst = max(wrong[-5], wrong[5])
    return (
        Claim(
            id="table.dmc_peak_exact_deg",
            quantity="attitude peak at the crossing with the compensator, friction known exactly",
            paper=0.1,
            ours=peak(exact),
            unit="deg",
            tolerance=0.03,
            why="With the exact friction almost nothing is left. The paper's 0.1 deg is what an "
            f"error of about {0.1 / wrong[5] * 5.0:.0f} % in c gives.",
        ),
        _ours("table.dmc_peak_coulomb_minus5_deg", "the same, c 5 % too small", wrong[-5]),
        _ours("table.dmc_peak_coulomb_plus5_deg", "the same, c 5 % too large", wrong[5]),
        _ours("table.dmc_peak_coulomb_plus10_deg", "the same, c 10 % too large", wrong[10]),
        Claim(
            id="table.dmc_start_transient_deg",
            quantity="largest attitude error of the first 100 s with the compensator",
            paper=0.6,
            ours=_start_transient(exact),
            unit="deg",
            tolerance=0.1,
            why="From zero attitude the compensator starts with less; the plain PID start gives "
            "the paper's 0.6 deg.",
        ),
        Claim(
            id="table.peak_ratio_coulomb5",
            quantity="peak under PID over peak with the compensator, c wrong by 5 %",
            paper=15.0,
            ours=pid_peak / worst,
            unit="",
            tolerance=3.0,
            why="1.5 deg over 0.1 deg in the paper. The ratio is a matter of how well c is known: "
            f"{pid_peak / wrong[10]:.0f} for 10 %.",
        ),
    )


def stick_time(flown: TableRun) -> float:
    """Time for which the wheel of a single run rests at its first crossing, s."""
    speed = flown.speed[0]
    before = int(np.argmax(speed >= 0.0)) - 1
    free = int(np.argmax(speed > 0.0)) - 1
    # the wheel's own motion over one period does not depend on attitude, rate or angle
    state = TABLE.start(speed=speed[before])._replace(current=jnp.asarray(flown.current[0, before]))
    step = jax.jit(TABLE.__call__)
    command = TableCommand(jnp.asarray(flown.current[0, before]))
    low, high = 0.0, PERIOD
    for _ in range(40):
        middle = 0.5 * (low + high)
        landed = float(step(state, command, 0.0, middle)[0].speed) >= 0.0
        low, high = (low, middle) if landed else (middle, high)
    return float(flown.time[free] - flown.time[before] - high)


def _limit_cycle() -> tuple[Claim, ...]:
    claims = []
    for name, what, friction in (
        ("overcompensated10", "c and T_s of the compensator 10 % too large", scaled(1.1, 1.1)),
        ("coulomb_only10", "c of the compensator 10 % too large, T_s exact", scaled(1.1)),
    ):
        flown = settled(compensator(friction))
        amplitude = float(wander(flown.attitude, flown.time)[0])
        hunts = "It hunts: the compensator moves a wheel that should rest, to and fro for ever."
        rests = "It does not hunt: below 0.02 deg, and dying away."
        claims.append(
            Claim(
                id=f"limit_cycle.{name}_deg",
                quantity="largest deviation from the mean attitude without external torque, "
                f"{what}; from 0.5 deg, after the first 100 s",
                ours=amplitude,
                unit="deg",
                why=hunts if amplitude > 0.02 else rests,
            )
        )
    return tuple(claims)
