"""Table 1, consequences of its model, and estimates from virtual records."""

from collections.abc import Sequence

import numpy as np

from gyrostat.core.units import RPM
from gyrostat.papers.carrara_kuga import figures, setup
from gyrostat.papers.carrara_kuga.bench import (
    Trial,
    breakaway_current,
    estimate,
    modelled_speed,
    profile2,
    rms,
    stop_time,
    trials,
)
from gyrostat.papers.claims import Value
from gyrostat.papers.reproduction import Part, Run
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck

COAST_FROM = 100.0 * RPM
"""Initial speed of the coast-down, rad/s."""
VARIED, QUICK_VARIED = 20, 4
"""Number of records for which the Stribeck speed is varied."""
FACTORS = (0.5, 2.0)
"""Factors on the held Stribeck speed."""
GOOD = 0.5
"""Largest ratio of sigma to value of a good estimate."""
BARELY = 0.5
"""Largest shift, in standard deviations, that counts as barely affected."""


def table1(run: Run) -> Part:
    """Compute Table 1 from eqs. (15) and (16), and properties of the wheel model."""
    run.say("Table 1, and properties of the wheel model")
    drop = 100.0 * (1.0 - setup.STATISTICAL.motor_constant / setup.DETERMINISTIC.motor_constant)
    friction = setup.STATISTICAL.friction()
    _, viscous, coulomb, _ = setup.CONVERGED
    coasting = Stribeck(
        setup.INERTIA * viscous,
        setup.INERTIA * coulomb,
        setup.INERTIA * coulomb,
        setup.STRIBECK_SPEED,
    )
    values: dict[str, Value] = {
        **{
            f"table1.{name}_det": setup.INERTIA * x
            for name, x in zip(setup.NAMES[:3], setup.START, strict=False)
        },
        **{
            f"table1.{name}": setup.INERTIA * x
            for name, x in zip(setup.NAMES, setup.CONVERGED, strict=True)
        },
        "table1.motor_constant_drop_percent": drop,
        "coulomb_over_km_A": setup.STATISTICAL.coulomb / setup.STATISTICAL.motor_constant,
        "breakaway.current_A": breakaway_current(setup.STATISTICAL.wheel()),
        "coast.stop_time_s": stop_time(
            Wheel(setup.INERTIA, setup.STATISTICAL.motor_constant, coasting), COAST_FROM
        ),
        "stribeck.jump_at_zero_speed": (
            float(friction.torque(0.0, 1.0)) - float(friction.torque(0.0, -1.0))
        ),
        "inertia.not_separable": _not_separable(1.1),
    }
    facts = {
        "drop": drop,
        "before": setup.DETERMINISTIC.coulomb / setup.DETERMINISTIC.motor_constant,
        "breakaway": setup.STATISTICAL.static / setup.STATISTICAL.motor_constant,
        "coast": np.log1p(viscous * COAST_FROM / coulomb) / viscous,
    }
    return Part(values, facts, (figures.friction(),))


def _not_separable(factor: float) -> bool:
    """Whether a common factor on inertia, motor constant and friction changes no speed."""
    parameters = [factor * getattr(setup.STATISTICAL, name) for name in setup.NAMES]
    larger = setup.Column(*parameters)
    wheels = (
        setup.STATISTICAL.wheel(),
        Wheel(factor * setup.INERTIA, larger.motor_constant, larger.friction()),
    )
    record = profile2(0)
    speed, scaled_speed = (modelled_speed(w, record.time, record.current, 0.0) for w in wheels)
    return bool(np.max(np.abs(scaled_speed - speed)) < 1e-6 * setup.SPEED_SIGMA)


def recovery(run: Run) -> Part:
    """Errors and residuals of the estimates from profile 2."""
    results: Sequence[Trial] = run.once(trials)
    errors = np.array([trial.error for trial in results])
    covariances = np.array([trial.covariance for trial in results])
    sigmas = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    efficiency = np.std(errors / sigmas, axis=0, ddof=1)
    iterations = [trial.fit.iterations for trial in results]
    contrast = np.array([0.0, 0.0, -1.0, 1.0])
    static_sigma = np.mean(
        [np.sqrt(contrast @ covariance @ contrast) for covariance in covariances]
    )
    sines = [trial.profile1 for trial in results]
    steps = [trial.profile2 for trial in results]
    values: dict[str, Value] = {
        **{
            f"recovery.{name}_std": float(std)
            for name, std in zip(setup.NAMES, np.std(errors, axis=0, ddof=1), strict=True)
        },
        "recovery.efficiency_min": float(np.min(efficiency)),
        "convergence.fraction": float(np.mean([trial.recovered for trial in results])),
        "convergence.iterations_max": float(max(iterations)),
        "rms.profile2_rpm": _mean_rpm([p.residual for p in steps]),
        "rms.profile1_rpm": _mean_rpm([p.residual for p in sines]),
        "rms.deterministic_profile2_rpm": _mean_rpm([p.deterministic_residual for p in steps]),
        "crossings.profile2": float(np.median([p.crossings for p in steps])),
        "crossings.profile1": float(np.median([p.crossings for p in sines])),
    }
    facts = {
        "records": len(results),
        "bias": dict(zip(setup.NAMES, errors.mean(axis=0), strict=True)),
        "chance": 1.0 / np.sqrt(2.0 * (len(results) - 1)),
        "least_efficient": setup.NAMES[int(np.argmin(efficiency))],
        "largest_efficiency": float(np.max(efficiency)),
        "median_iterations": np.median(iterations),
        "significance": (setup.STATISTICAL.static - setup.STATISTICAL.coulomb) / static_sigma,
        "deterministic_profile1": _mean_rpm([p.deterministic_residual for p in sines]),
        "wins": 100.0 * np.mean([rms(p.residual) < rms(p.deterministic_residual) for p in steps]),
    }
    drawings = (
        figures.profiles(results[0]),
        figures.speeds(results[0]),
        figures.residuals(results[0]),
    )
    return Part(values, facts, drawings)


def _mean_rpm(series: Sequence[np.ndarray]) -> float:
    """Root mean square of each series, averaged, rpm."""
    return float(np.mean([rms(residual) for residual in series])) / RPM


def stribeck_speed(run: Run) -> Part:
    """Estimates with free Stribeck speed, and with half and twice its value."""
    subset: Sequence[Trial] = run.once(trials)[: QUICK_VARIED if run.quick else VARIED]
    run.say(f"the Stribeck speed free, halved and doubled on {len(subset)} records")
    fits = [estimate(trial.profile2.record, stribeck_speed=None) for trial in subset]
    places = [fit.names.index("stribeck_speed") for fit in fits]
    relative = [float(f.sigma[k] / f.values[k]) for f, k in zip(fits, places, strict=True)]
    largest = np.max([_shifts(trial) for trial in subset], axis=(0, 1))
    other_shift, static = float(largest[:3].max()), float(largest[3])
    values: dict[str, Value] = {
        "stribeck_speed.not_observable": float(np.median(relative)) > GOOD,
        "stribeck_speed.barely_affects_motor_viscous_coulomb": other_shift < BARELY,
        "stribeck_speed.barely_affects_static": static < BARELY,
    }
    facts = {
        "varied": len(subset),
        "seen": sum(fit.observability["stribeck_speed"].observable for fit in fits),
        "relative_sigma": float(np.median(relative)),
        "others_shift": other_shift,
        "static_shift": static,
    }
    return Part(values, facts)


def _shifts(trial: Trial) -> np.ndarray:
    """Absolute shift of each parameter in its standard deviations, (len(FACTORS), 4)."""
    sigma = np.sqrt(np.diag(trial.covariance))
    base = np.array([trial.fit.parameters[n] for n in setup.NAMES])
    rows = []
    for factor in FACTORS:
        fit = estimate(trial.profile2.record, stribeck_speed=factor * setup.STRIBECK_SPEED)
        rows.append(np.abs(np.array([fit.parameters[n] for n in setup.NAMES]) - base) / sigma)
    return np.array(rows)
