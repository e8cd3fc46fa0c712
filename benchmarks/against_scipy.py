"""One 3000-sample record: gyrostat against scipy and lmfit through solve_ivp, from several starts.

    python benchmarks/against_scipy.py [--seeds 3]

The peers do what an engineer would write: LSODA over the record with the model as printed, finite
differences for the Jacobian. With default settings, and with settings that an expert needs to reach
the minimum: tight tolerances, a step cap so that no current step or Stribeck band is jumped over,
and a difference step above the integrator's noise. All start from the same values; the cost is the
sum of squared residuals over the stated noise, by the event-exact model for everyone.
"""

import argparse
import time

import lmfit
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from gyrostat.friction import Stribeck
from gyrostat.identify import identify
from gyrostat.identify.prediction import SpeedPrediction
from gyrostat.simulate import CurrentRange, Telemetry, bench_record
from gyrostat.units import RPM
from gyrostat.wheel import Wheel

INERTIA = 1.5e-3
STRIBECK_SPEED = 0.418879
SIGMA = 5.0 * RPM
TRUE = np.array([0.0228, 4.83e-6, 0.8795e-3, 0.9055e-3])
NAMES = ("motor_constant", "viscous", "coulomb", "static")
STARTS = {
    "the paper's (15), T_s = 0": np.array([18.0, 0.00344, 0.5863, 0.0]) * INERTIA,
    "the paper's (15), T_s = c": np.array([18.0, 0.00344, 0.5863, 0.5863]) * INERTIA,
}
SETTINGS = {
    "default": ({}, None),
    "expert": ({"rtol": 1e-7, "atol": 1e-8, "max_step": 0.1}, 1e-4),
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


def run_scipy(record, start, options, step):
    """scipy.optimize.least_squares with finite differences."""
    done = least_squares(peer_residual(record, options), start / TRUE, diff_step=step)
    return done.x * TRUE, bool(done.success)


def run_lmfit(record, start, options, step):
    """lmfit.minimize, Levenberg-Marquardt with finite differences."""
    parameters = lmfit.Parameters()
    for name, value in zip(NAMES, start / TRUE, strict=True):
        parameters.add(name, value=value)
    residual = peer_residual(record, options)
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
    seeds = arguments.parse_args().seeds
    run_gyrostat(record_of(0), STARTS["the paper's (15), T_s = c"])
    peers = [("scipy", run_scipy), ("lmfit", run_lmfit)]
    runs = [("gyrostat", "default", run_gyrostat)]
    runs += [(name, setting, run) for setting in SETTINGS for name, run in peers]
    print("| record | start | solver | settings | time (s) | ratio | cost | says success |")
    print("|---|---|---|---|---|---|---|---|")
    for seed in range(seeds):
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
