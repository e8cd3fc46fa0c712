"""One 3000-sample record: gyrostat against scipy and lmfit through solve_ivp, from several starts.

    python benchmarks/against_scipy.py [--seeds 3] [--settings default events]

The peers do what an engineer would write: LSODA over the record with the model as printed, finite
differences for the Jacobian, in three ways. "default": one solve_ivp call with its default
settings. "expert": tight tolerances, a step cap so that no current step or Stribeck band is jumped
over, and a difference step above the integrator's noise. "events": what it takes to reach the
minimum: a call of its own for each constant current, ended by an event at every zero crossing. All
start from the same values; the cost is the sum of squared residuals over the stated noise, by the
event-exact model for everyone.
"""

import argparse
import time

import lmfit
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.identification.fit.prediction import SpeedPrediction
from gyrostat.simulation import CurrentRange, Telemetry, bench_record
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck

INERTIA = 1.5e-3
STRIBECK_SPEED = 0.418879
SIGMA = 5.0 * RPM
TRUE = np.array([0.0228, 4.83e-6, 0.8795e-3, 0.9055e-3])
NAMES = ("motor_constant", "viscous", "coulomb", "static")
STARTS = {
    "the paper's (15), T_s = 0": np.array([18.0, 0.00344, 0.5863, 0.0]) * INERTIA,
    "the paper's (15), T_s = c": np.array([18.0, 0.00344, 0.5863, 0.5863]) * INERTIA,
}


def record_of(seed):
    """A profile-2 record of the paper's wheel: 3000 samples at 10 Hz."""
    friction = Stribeck(*TRUE[1:], stribeck_speed=STRIBECK_SPEED)
    return bench_record(
        Wheel(inertia=INERTIA, motor_constant=TRUE[0], friction=friction),
        "steps",
        duration=299.9,
        telemetry=Telemetry(speed_sigma=SIGMA),
        amplitudes=CurrentRange(0.06, 0.15),
        seed=seed,
    )


def peer_residual(record, options):
    """Whitened residuals as a function of the scaled parameters, through LSODA."""
    last = len(record.time) - 1

    def residual(scaled):
        motor, viscous, coulomb, static = scaled * TRUE / INERTIA

        def rate(t, speed):
            current = record.current[min(int(t * 10.0 + 1e-9), last)]
            friction = coulomb + (static - coulomb) * np.exp(-((speed / STRIBECK_SPEED) ** 2))
            return motor * current - viscous * speed - np.sign(speed) * friction

        span = (record.time[0], record.time[-1])
        done = solve_ivp(rate, span, [0.0], method="LSODA", t_eval=record.time, **options)
        return (record.speed - done.y[0]) / SIGMA

    return residual


def peer_residual_with_events(record, options):
    """The same, each smooth piece integrated by itself: constant current, one sense of rotation."""
    starts = np.flatnonzero(np.diff(record.current, prepend=np.nan))
    bounds = [*record.time[starts], record.time[-1]]

    def crossing(_, speed, *__):
        return speed[0]

    crossing.terminal = True

    def rate(_, speed, drive, sense, theta):
        _, viscous, coulomb, static = theta
        friction = coulomb + (static - coulomb) * np.exp(-((speed / STRIBECK_SPEED) ** 2))
        return drive - viscous * speed - sense * friction

    def residual(scaled):
        theta = scaled * TRUE / INERTIA
        modelled, speed = np.zeros(len(record.time)), 0.0
        for k, first in enumerate(starts):
            now, end = bounds[k], bounds[k + 1]
            drive = theta[0] * record.current[first]
            while now < end:
                sense = np.sign(speed) or np.sign(drive)
                if speed == 0.0 and abs(drive) <= theta[3]:
                    break
                inside = (record.time >= now) & (record.time <= end)
                at = record.time[inside]
                done = solve_ivp(
                    rate,
                    (now, end),
                    [speed],
                    method="LSODA",
                    t_eval=at,
                    # a piece that starts at zero is not ended there
                    events=None if speed == 0.0 else crossing,
                    args=(drive, sense, theta),
                    **options,
                )
                modelled[np.flatnonzero(inside)[: len(done.t)]] = done.y[0]
                stopped = done.status == 1
                now = done.t_events[0][0] if stopped else end
                speed = 0.0 if stopped else done.y[0][-1]
        return (record.speed - modelled) / SIGMA

    return residual


SETTINGS = {
    "default": (peer_residual, {}, None),
    "expert": (peer_residual, {"rtol": 1e-7, "atol": 1e-8, "max_step": 0.1}, 1e-4),
    "events": (peer_residual_with_events, {"rtol": 1e-9, "atol": 1e-9}, 1e-5),
}


def run_scipy(record, start, model, options, step):
    """scipy.optimize.least_squares with finite differences."""
    done = least_squares(model(record, options), start / TRUE, diff_step=step)
    return done.x * TRUE, bool(done.success)


def run_lmfit(record, start, model, options, step):
    """lmfit.minimize, Levenberg-Marquardt with finite differences."""
    parameters = lmfit.Parameters()
    for name, value in zip(NAMES, start / TRUE, strict=True):
        parameters.add(name, value=value)
    residual = model(record, options)
    done = lmfit.minimize(
        lambda p: residual(np.array([p[n].value for n in NAMES])),
        parameters,
        **({} if step is None else {"epsfcn": step**2}),
    )
    return np.array([done.params[n].value for n in NAMES]) * TRUE, bool(done.success)


def run_gyrostat(record, start, *_):
    """gyrostat from the same start, with the same noise."""
    fit = identify(
        record,
        inertia=INERTIA,
        start=dict(zip(NAMES, start, strict=True)),
        hold={"initial_speed": 0.0},
        speed_sigma=SIGMA,
    )
    return fit.values, fit.converged


def cost_of(record, values):
    """Sum of squared whitened residuals under the event-exact model."""
    prediction = SpeedPrediction([record], Stribeck, "zero-order")
    every = dict(zip(NAMES, values, strict=True)) | {
        "inertia": INERTIA,
        "stribeck_speed": STRIBECK_SPEED,
        "current_bias": 0.0,
        "initial_speed": 0.0,
    }
    predicted = prediction(np.array([every[n] for n in prediction.names]))
    return (
        np.inf
        if predicted is None
        else float(np.sum(((record.speed - predicted[0][0]) / SIGMA) ** 2))
    )


def main():
    """Print one row per record, start, solver and setting."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--seeds", type=int, default=3)
    arguments.add_argument("--settings", nargs="*", choices=SETTINGS, default=list(SETTINGS))
    chosen = arguments.parse_args()
    run_gyrostat(record_of(0), STARTS["the paper's (15), T_s = c"])
    peers = [("scipy", run_scipy), ("lmfit", run_lmfit)]
    runs = [("gyrostat", "default", run_gyrostat)]
    runs += [(name, setting, run) for setting in chosen.settings for name, run in peers]
    print("| record | start | solver | settings | time (s) | ratio | cost | says success |")
    print("|---|---|---|---|---|---|---|---|")
    for seed in range(chosen.seeds):
        record = record_of(seed)
        for start_name, start in STARTS.items():
            ours = None
            for name, setting, run in runs:
                before = time.perf_counter()
                values, success = run(record, start, *SETTINGS[setting])
                elapsed = time.perf_counter() - before
                ours = ours or elapsed
                print(
                    f"| {seed} | {start_name} | {name} | {setting} | {elapsed:.2f} | "
                    f"{elapsed / ours:.0f} | {cost_of(record, values):.3f} | {success} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
