"""Identification of virtual drives in closed loop: coverage, bias of least squares, feedback test.

    python benchmarks/drives.py --loop position-pd --records 200 --seed 1000
    python benchmarks/drives.py --feedback --records 100

The drives are simulated by an integrator of their own, with disturbances of the torque, noise or
rounding of the measurement, and dispersed parameters.
"""

import argparse
import time
from dataclasses import dataclass, replace

import numpy as np

import gyrostat.identification as stage
from gyrostat.core.errors import InputError
from gyrostat.identification.drive.control_law import ControlLaw
from gyrostat.identification.drive.laws.position import PositionControl
from gyrostat.identification.drive.laws.speed import SpeedControl
from gyrostat.identification.uncertainty.feedback import feedback_in
from gyrostat.telemetry import Record


@dataclass(frozen=True)
class Case:
    """Drive, reference and disturbances.

    Attributes:
        law: Control law.
        interval: Sample interval, s.
        duration: Duration, s.
        inertia: Inertia, kg·m²; likewise the others, SI.
        disturbance: Rms disturbance torque over the Coulomb torque.
        correlation: Correlation time of the disturbance, s; 0 for white noise.
        noise: Noise of the measured speed, rad/s; or of the angle, rad.
        quantum: Step of the encoder, rad; 0 for none.
        offset: Constant torque, N·m.
        amplitude: Largest commanded speed, rad/s.
        period: Mean duration of a commanded speed, s.
        known: Parameter that the identification is told.
    """

    law: ControlLaw
    interval: float = 0.01
    duration: float = 120.0
    inertia: float = 1.5e-3
    motor_constant: float = 0.0228
    viscous: float = 1.2e-5
    coulomb: float = 0.9e-3
    offset: float = 0.0
    disturbance: float = 0.15
    correlation: float = 0.02
    noise: float = 0.0
    quantum: float = 0.0
    amplitude: float = 60.0
    period: float = 4.0
    known: str = "motor_constant"


WHEEL = 1.5e-3 / 0.0228
"""Current per acceleration of the wheel, A·s²/rad."""
CASES = {
    "speed-p": Case(SpeedControl(kp=8.0 * WHEEL, saturation=10.0), noise=0.05),
    "speed-pi": Case(SpeedControl(kp=6.0 * WHEEL, ki=9.0 * WHEEL, saturation=2.0), noise=0.05),
    "position-pd": Case(
        PositionControl(
            kp=225.0 * WHEEL, kd=21.0 * WHEEL, speed_feedforward=21.0 * WHEEL, saturation=10.0
        ),
        quantum=1e-3,
    ),
    "speed-pi-feedforward": Case(
        SpeedControl(kp=4.0 * WHEEL, ki=4.0 * WHEEL, feedforward=0.9 * WHEEL, saturation=10.0),
        noise=0.1,
        disturbance=0.3,
        correlation=0.2,
    ),
    "cascade": Case(
        PositionControl(kp=160.0 * 3.5, kd=3.5, saturation=10.0),
        interval=1e-3,
        duration=25.0,
        inertia=95.1,
        motor_constant=35.15,
        viscous=203.5,
        coulomb=20.4,
        offset=-3.16,
        disturbance=0.4,
        correlation=0.01,
        quantum=1e-6,
        amplitude=0.12,
        period=1.5,
    ),
    # invented when the method was fixed
    "position-pid": Case(
        PositionControl(
            kp=400.0 * WHEEL,
            ki=600.0 * WHEEL,
            kd=35.0 * WHEEL,
            speed_feedforward=30.0 * WHEEL,
            feedforward=0.8 * WHEEL,
            saturation=10.0,
        ),
        interval=5e-3,
        duration=60.0,
        offset=2e-4,
        disturbance=0.6,
        correlation=0.0,
        quantum=5e-4,
        amplitude=40.0,
        period=2.5,
        known="inertia",
    ),
    "speed-pi-slow": Case(
        SpeedControl(kp=3.0 * WHEEL, ki=2.0 * WHEEL, saturation=10.0),
        interval=0.02,
        duration=200.0,
        viscous=3e-5,
        offset=-3e-4,
        disturbance=0.2,
        correlation=1.0,
        noise=0.3,
        period=6.0,
    ),
}


def commanded(case: Case, time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Commanded speed, rad/s: ramps between levels of random size and alternating sign."""
    times, levels, sign = [0.0], [0.0], 1.0
    while times[-1] < time[-1]:
        level = sign * case.amplitude * rng.uniform(0.3, 1.0)
        ramp, hold = case.period * rng.uniform(0.1, 0.4), case.period * rng.uniform(0.3, 0.9)
        times += [times[-1] + ramp, times[-1] + ramp + hold]
        levels += [level, level]
        sign = -sign
    return np.interp(time, times, levels)


def simulate(
    case: Case, seed: int, substeps: int = 10, programme: np.ndarray | None = None
) -> tuple[Record, dict[str, float]]:
    """Record of a dispersed drive, and its true parameters.

    Args:
        case: Drive.
        seed: Seed of parameters, reference and disturbances.
        substeps: Steps of the integrator in each sample interval.
        programme: Current, A, in place of that of the control law, and without a reference.
    """
    rng = np.random.default_rng(seed)
    names = ("inertia", "motor_constant", "viscous", "coulomb")
    true = {name: getattr(case, name) * rng.uniform(0.85, 1.15) for name in names}
    law, period = case.law, case.interval
    count = round(case.duration / period) + 1
    moments = period * np.arange(count)
    speed_r = commanded(case, moments, rng)
    angle_r = np.concatenate([[0.0], np.cumsum(speed_r[:-1])]) * period
    change = np.diff(speed_r, prepend=speed_r[0]) / period
    keep = np.exp(-period / case.correlation) if case.correlation else 0.0
    kicks = np.sqrt(1.0 - keep**2) * case.disturbance * true["coulomb"] * rng.normal(size=count)
    noise = case.noise * rng.normal(size=count)
    position = law.reference == "reference"
    step, speed, angle, integral, torque, before = period / substeps, 0.0, 0.0, 0.0, 0.0, 0.0
    angles, speeds, currents = (np.zeros(count) for _ in range(3))
    gains = law.gains()
    for k in range(count):
        seen = round(angle / case.quantum) * case.quantum if case.quantum else angle
        seen_speed = speed + noise[k]
        if position:
            error = angle_r[k] - seen
            demand = gains["kp"] * error + gains["ki"] * integral
            demand += gains["speed_feedforward"] * speed_r[k] + gains["feedforward"] * change[k]
            demand -= gains["kd"] * (seen - before) / period
        else:
            error = speed_r[k] - seen_speed
            demand = gains["kp"] * error + gains["ki"] * integral
            demand += gains["feedforward"] * change[k]
        command = min(max(demand, -law.saturation), law.saturation)
        integral += period * error if command == demand else 0.0
        command = command if programme is None else programme[k]
        angles[k], speeds[k], currents[k], before = seen, seen_speed, command, seen
        torque = keep * torque + kicks[k]
        drive = true["motor_constant"] * command + case.offset + torque
        for _ in range(substeps):
            if speed == 0.0 and abs(drive) <= true["coulomb"]:
                break
            free = speed + step * (drive - true["viscous"] * speed) / true["inertia"]
            brake = step * true["coulomb"] / true["inertia"]
            new = np.sign(free) * max(abs(free) - brake, 0.0) if free * speed >= 0.0 else 0.0
            angle += 0.5 * step * (speed + new)
            speed = new
    if position:
        measured = np.append(np.nan, np.diff(angles) / period)
        columns = {"reference": angle_r, "averaged": True}
    else:
        measured, columns = speeds, {} if programme is not None else {"setpoint": speed_r}
    record = Record(
        name=f"drive-{seed}",
        time=moments,
        current=currents,
        speed=measured,
        valid=np.isfinite(measured),
        **columns,
    )
    return record, true


def coverage(name: str, case: Case, records: int, seed: int, stated: bool) -> None:
    """Print the coverage of 95 % intervals, and the bias of least squares."""
    hits: dict[str, list[tuple[float, ...]]] = {}
    refused, began = 0, time.process_time()
    for k in range(records):
        record, true = simulate(case, seed + k)
        known = {case.known: true[case.known]}
        try:
            fit = stage.identify_inverse(
                record,
                inertia=known.get("inertia"),
                hold={n: v for n, v in known.items() if n != "inertia"},
                law=case.law if stated else None,
            )
        except InputError as error:
            print(error)
            refused += 1
            continue
        refused += bool(fit.impossible) or not fit.converged
        assert fit.inverse is not None
        for method, each in fit.inverse.methods.items():
            for n, value in each.values.items():
                if n in true:
                    error, sigma = value - true[n], each.sigma[n]
                    hits.setdefault(f"{method} {n}", []).append(
                        (error / sigma, error / true[n], sigma / true[n])
                    )
    spent = (time.process_time() - began) / records
    print(
        f"{name}, {'law stated' if stated else 'filtered reference'}: {records} records, "
        f"{refused} without a valid result, {spent:.2f} s each"
    )
    for key, rows in hits.items():
        score, error, sigma = np.array(rows).T
        print(
            f"  {key:30s} covered {100.0 * np.mean(np.abs(score) < 1.96):5.1f} %  "
            f"bias {100.0 * np.mean(error):+6.2f} %  "
            f"rms {100.0 * np.sqrt(np.mean(error**2)):5.2f} %  "
            f"median sigma {100.0 * np.median(sigma):5.2f} %"
        )


OPEN = ("steps", "walk", "telegraph", "sines")
"""Programmes of the current in open loop."""


def open_loop(programme: str, seed: int) -> tuple[Record, dict[str, float]]:
    """Record in open loop: 3000 samples at 20 Hz, with noise of the current and disturbances."""
    rng = np.random.default_rng(seed)
    case = replace(CASES["speed-p"], interval=0.05, duration=150.0, disturbance=0.1)
    moments = case.interval * np.arange(3001)
    if programme == "walk":
        current = np.zeros_like(moments)
        for k in range(1, len(moments)):
            current[k] = 0.97 * current[k - 1] + 0.02 * rng.normal()
    elif programme == "telegraph":
        current = 0.1 * np.where(np.cumsum(rng.random(len(moments)) < 0.02) % 2, 1.0, -1.0)
    elif programme == "steps":
        level = rng.uniform(0.05, 0.15, 11) * (-1.0) ** np.arange(11)
        current = level[(moments // 15.0).astype(int)] + 0.002 * rng.normal(size=len(moments))
    else:
        phases = rng.uniform(0.0, 2.0 * np.pi, 3)
        waves = [
            np.sin(2.0 * np.pi * moments / p + f) for p, f in zip((23, 11, 7), phases, strict=True)
        ]
        current = 0.07 * np.sum(waves, axis=0) + 0.002 * rng.normal(size=len(moments))
    return simulate(case, seed, programme=current)


def feedback(name: str, records: int, seed: int, fitted: int) -> None:
    """Print how often feedback is found, and the errors of least squares of the speed.

    Args:
        name: Programme of the current, or control law.
        records: Number of records.
        seed: Seed of the first one.
        fitted: Number of records that are fitted.
    """
    found, errors = 0, []
    for k in range(records):
        if name in OPEN:
            record, true = open_loop(name, seed + k)
        else:
            case = replace(CASES[name], offset=0.0, duration=4000.0 * CASES[name].interval)
            record, true = simulate(case, seed + k)
        found += feedback_in([record]).found
        if k < fitted:
            inertia = true["inertia"]
            fit = stage.identify(record, inertia=inertia, model="viscous-coulomb", white_noise=True)
            names = ("motor_constant", "viscous", "coulomb")
            errors.append([fit.parameters[n] / true[n] - 1.0 for n in names])
    print(f"{name:22s} feedback found in {found} of {records}", flush=True)
    if errors:
        bias, rms = 100.0 * np.mean(errors, axis=0), 100.0 * np.sqrt(np.mean(np.square(errors), 0))
        print(
            "  least squares of the speed, motor constant, viscous, Coulomb: bias "
            f"{np.round(bias, 1)} %, rms {np.round(rms, 1)} %",
            flush=True,
        )


def main() -> None:
    """Run the cases of the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--loop", choices=[*CASES, *OPEN, "all"], default="all")
    parser.add_argument("--records", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--stated", action="store_true", help="state the control law")
    parser.add_argument("--feedback", action="store_true", help="test for feedback instead")
    parser.add_argument("--fitted", type=int, default=0, help="records fitted by least squares")
    options = parser.parse_args()
    if options.feedback:
        for name in (*OPEN, *CASES):
            if options.loop in (name, "all"):
                feedback(name, options.records, options.seed, options.fitted)
        return
    for name, case in CASES.items():
        if options.loop in (name, "all"):
            coverage(name, case, options.records, options.seed, options.stated)


if __name__ == "__main__":
    main()
