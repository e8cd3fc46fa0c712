"""Compare the health monitor with the Cramer-Rao bound of its fleets, and its "not observable".

    python benchmarks/monitor_bound.py [--vehicle large --orbit low --noise 0.02 --known sheet]

The bound shares no code with the monitor. With the loop closed, a wheel's current follows its
friction noise, so that currents and speeds as flown are no exact regressors. The likelihood of
speeds and currents is Gaussian, and its mean is the flight without friction and sensor noise: the
same flight is flown twice, with and without them. From r = K i - J (dw/dt + a . dW/dt), whose mean
is sign C + b w + o, and whose noise is sign C x + e (x: Ornstein-Uhlenbeck; e: noise and rounding
of the telemetry), the information is D' R^-1 D with the columns sign, w, -i and 1 of the flight
without noise in D, and the change of w with temperature, which is not known beforehand. What the
covariance itself tells of the parameters (transients of the loop, which the rounding of the speeds
hides) is left out. The truth is the mean of the realised Coulomb torque, whose bound is that of a
prediction. What is known of a wheel beforehand counts in the error; for "observable", what is known
of the parameter itself does not.
"""

import argparse
from collections import defaultdict
from dataclasses import replace

import numpy as np
from monitor import KNOWN, known_wheels
from monitor_fleet import ORBITS, POINTINGS, VEHICLES

from gyrostat.monitoring.fleet.flight import Cell, Fleet, Flight
from gyrostat.monitoring.fleet.sampling import Sampling, sample
from gyrostat.monitoring.rehearsal import samples_of
from gyrostat.monitoring.stream import WheelMonitor

FIRST = 400_000
"""Number of the first flight."""
BLOCK = 60
NAMES = ("coulomb", "viscous", "motor_constant", "offset")
WARMING = 0.05
"""Standard deviation of the change of the viscous coefficient with temperature, 1/K."""
UNOBSERVABLE, CLEAR, LIMIT = 0.6, 0.15, 0.3
"""Bounds over the value: not observable; clearly observable; the limit between them."""


def noise_covariance(count, sigma, time):
    """Covariance of means of an Ornstein-Uhlenbeck process over blocks, (count, count)."""
    share = BLOCK / time
    lag = np.abs(np.subtract.outer(np.arange(count), np.arange(count))) * share
    apart = np.exp(-lag) * (np.exp(share) + np.exp(-share) - 2.0)
    same = 2.0 * (share - 1.0 + np.exp(-share))
    return sigma**2 / share**2 * np.where(lag == 0.0, same, apart)


def bounds(quiet, truth, wheel, vehicle, cell, sampling, prior):
    """Bounds of one wheel-day: error of each parameter, and error without knowledge of its own.

    Args:
        quiet: Day of the flight without friction noise.
        truth: True values of the wheel.
        wheel: Place of the wheel.
        vehicle: Spacecraft.
        cell: Conditions.
        sampling: Telemetry chain.
        prior: Standard deviation of what is known of each parameter, (4,).
    """
    nominal = vehicle.wheel
    speed = quiet.speed[:, wheel].astype(float).reshape(-1, BLOCK)
    current = quiet.torque[:, wheel].astype(float).reshape(-1, BLOCK) / nominal.motor_constant
    warm = quiet.temperature.reshape(-1, BLOCK) - 20.0
    firing = quiet.firing.reshape(-1, BLOCK).any(axis=1)
    sign = np.sign(speed)
    used = (np.abs(sign.mean(axis=1)) == 1.0) & ~firing
    used &= np.abs(speed).min(axis=1) > 5.0 * nominal.stribeck_speed
    factors = [
        np.exp(-a * warm) for a in (nominal.coulomb_temperature, nominal.viscous_temperature)
    ]
    factors = [each / each.mean() for each in factors]
    design = np.column_stack(
        [
            (sign * factors[0]).mean(axis=1),
            (speed * factors[1]).mean(axis=1),
            -current.mean(axis=1),
            np.ones(len(speed)),
            (speed * (warm - warm.mean())).mean(axis=1),
        ]
    )
    slow = noise_covariance(len(speed), cell.noise_sigma, cell.noise_time)
    torque = truth["coulomb"]
    sense = np.where(used, sign[:, 0], 0.0)
    rounding = sampling.speed_step**2 / 12.0 * (nominal.inertia / BLOCK) ** 2
    white = vehicle.current_sigma**2 + sampling.current_step**2 / 12.0
    noise = torque**2 * slow * np.outer(sense, sense)
    noise += np.diag(
        np.full(len(speed), truth["motor_constant"] ** 2 * white / BLOCK + 2.0 * rounding)
    )
    noise -= rounding * (np.eye(len(speed), k=1) + np.eye(len(speed), k=-1))
    if used.sum() < 10:
        return None
    root = np.linalg.cholesky(noise[np.ix_(used, used)])
    scale = np.array([torque, truth["viscous"], truth["motor_constant"], torque, truth["viscous"]])
    whitened = np.linalg.solve(root, design[used] * scale)
    information = whitened.T @ whitened
    # the mean of the realised Coulomb torque: error of its prediction from the rows
    mean_noise = torque * slow.mean(axis=0)[used] * sense[used]
    seen = np.linalg.solve(root, torque * mean_noise) / torque
    known = np.append((scale[:4] / prior) ** 2, WARMING**-2)
    rank = np.linalg.matrix_rank(information[:4, :4], tol=UNOBSERVABLE**-2)
    errors = np.sqrt(_variances(information + np.diag(known), whitened, seen, slow.mean()))
    alone = [
        _variances(information + np.diag(np.where(np.arange(5) == p, 0.0, known)), whitened, seen,
                   slow.mean())[p]
        for p in range(4)
    ]  # fmt: skip
    return errors, np.sqrt(alone), rank


def _variances(information, whitened, seen, mean_variance):
    """Relative variances of the four parameters; the first is the mean realised Coulomb torque."""
    values, axes = np.linalg.eigh(information)
    inverse = (axes / np.maximum(values, 1e-9)) @ axes.T
    variances = np.diag(inverse).copy()
    left = np.eye(len(information))[0] - whitened.T @ seen
    variances[0] = mean_variance - seen @ seen + left @ inverse @ left
    return variances


def judge(arguments):
    """Fly, monitor and compare."""
    vehicle, orbit = VEHICLES[arguments.vehicle], ORBITS[arguments.orbit]
    sampling, random = Sampling(), np.random.default_rng(9)
    nominal = vehicle.wheel
    sizes = (nominal.motor_constant, nominal.viscous, nominal.coulomb)
    motor, viscous, offset = np.array(KNOWN[arguments.known]) * sizes
    prior = np.array([np.inf, viscous, motor, offset])
    print(
        f"{arguments.vehicle} {arguments.orbit} {arguments.noise:g} known from {arguments.known}: "
        f"{arguments.flights} flights of {arguments.days} days"
    )
    for name in arguments.pointings:
        flights = [Flight(FIRST + k) for k in range(arguments.flights)]
        silent = replace(vehicle, attitude_sigma=0.0, rate_sigma=0.0)
        cells = [
            Cell(craft, orbit, POINTINGS[name], noise_sigma=sigma, seed=FIRST)
            for craft, sigma in ((vehicle, arguments.noise), (silent, 0.0))
        ]
        monitors, found = [None] * len(flights), {}
        pairs = zip(*(Fleet(cell, flights).days(arguments.days) for cell in cells), strict=True)
        for number, (flown, quiet) in enumerate(pairs):
            for b, day in enumerate(flown):
                if monitors[b] is None:
                    known = known_wheels(vehicle, day.truth, arguments.known, random)
                    if arguments.known == "sheet":
                        known = _drawn(known, day.truth, prior, random)
                    monitors[b] = WheelMonitor(known)
                monitors[b].add(samples_of(sample(day, vehicle, sampling), vehicle))
                for k in range(4):
                    truth = {n: float(day.truth[n][k]) for n in NAMES}
                    bound = bounds(quiet[b], truth, k, vehicle, cells[0], sampling, prior)
                    found[b, k, number] = truth, bound
        report(name, monitors, found)


def _drawn(known, truth, prior, random):
    """Wheels whose stated values have the errors that are stated for them."""
    wheels = []
    for k, wheel in enumerate(known.wheels):
        exact = [float(truth[n][k]) for n in NAMES[1:]]
        viscous, motor, offset = exact + prior[1:] * random.standard_normal(3)
        values = {"viscous": abs(viscous), "motor_constant": motor, "offset": offset}
        wheels.append(type(wheel)(**{**vars(wheel), **values}))
    return type(known)(**{**vars(known), "wheels": tuple(wheels)})


def report(pointing, monitors, found):
    """Print one line for each parameter."""
    lines = defaultdict(list)
    for b, monitor in enumerate(monitors):
        table = monitor.windows()
        for row in range(len(table)):
            place = b, int(str(table["wheel"][row])[-1]) - 1, int(table["start"][row] // 86400)
            truth, bound = found.get(place, (None, None))
            if bound is None:
                continue
            errors, alone, rank = bound
            for p, name in enumerate(NAMES):
                scale = truth["coulomb"] if name in ("coulomb", "offset") else truth[name]
                error = (table[name][row] - truth[name]) / scale
                said = bool(table[f"{name}_observable"][row]) and bool(table["valid"][row])
                stated = table[f"{name}_sigma"][row] / scale
                lines[name].append((error / errors[p], stated / errors[p], alone[p], said, rank))
    for name, rows in lines.items():
        ratio, stated, alone, said, rank = np.array(rows, float).T
        never, clear = alone > UNOBSERVABLE, alone < CLEAR
        shares = [
            f"{np.sum(where & (said == 0)):.0f} of {np.sum(where)}" for where in (never, clear)
        ]
        good = alone < LIMIT
        rms = f"{np.sqrt(np.mean(ratio[good] ** 2)):.2f}" if good.any() else "-"
        ranks = np.bincount(rank.astype(int), minlength=5)
        every = np.sqrt(np.nanmean(ratio**2))
        print(
            f"  {pointing:10s} {name:15s} bound {100 * np.median(alone):8.2f} %  not observable: "
            f"{shares[0]} above 60 %, {shares[1]} below 15 %  rms error / bound {rms} ({every:.2f} "
            f"of all)  stated / bound {np.nanmedian(stated):.2f}  rank {ranks}",
            flush=True,
        )


def main():
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--vehicle", choices=VEHICLES, default="large")
    parser.add_argument("--orbit", choices=ORBITS, default="low")
    parser.add_argument("--noise", type=float, default=0.02)
    parser.add_argument("--known", choices=KNOWN, default="sheet")
    parser.add_argument("--flights", type=int, default=6)
    parser.add_argument("--days", type=int, default=2)
    parser.add_argument("--pointings", nargs="+", choices=POINTINGS, default=list(POINTINGS))
    judge(parser.parse_args())


if __name__ == "__main__":
    main()
