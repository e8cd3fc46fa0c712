"""Friction curve from steady speeds."""

from collections.abc import Mapping, Sequence

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.identification.bench.bench_methods import held_values, require_held, result
from gyrostat.identification.bench.friction_curve import (
    FrictionCurve,
    bend_speeds,
    fit_curve,
    plateau_torques,
    preferred,
)
from gyrostat.identification.fit.prediction import wheel_dimensions
from gyrostat.identification.judge.plausibility import Scatter
from gyrostat.identification.read.checks import as_records, check_sigma, check_signals, place
from gyrostat.identification.read.plateaus import MIN_SAMPLES, Plateau, find_plateaus
from gyrostat.identification.result.fit import Fit, FrictionPoints
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import Friction, Stribeck, ViscousCoulomb
from gyrostat.wheel.friction_laws import Law, friction_law


def _choose(
    model: str | Law | None, hold: Mapping[str, float | None]
) -> tuple[type[Friction], type[Friction] | None]:
    """Friction model to fit, and one to prefer if the plateaus clearly support it."""
    if model is not None:
        return friction_law(model), None
    if set(hold) & set(Stribeck.dimensions()) - set(ViscousCoulomb.dimensions()):
        return Stribeck, None
    return ViscousCoulomb, Stribeck


def _require_points(records: Sequence[Record], plateaus: Sequence[Plateau], count: int) -> None:
    if not count:
        raise InputError("hold: found every friction parameter, expected one to estimate")
    if len(plateaus) < max(count, 1):
        text = f"{len(plateaus) or 'no'} plateau{'s' * (len(plateaus) != 1)} of steady speed"
        raise InputError(
            f"{place(records)}: found {text}, expected at least {count} for {count} friction "
            f"parameters: turning, settled, and held long enough, {MIN_SAMPLES} samples or more, "
            "to show that the speed does not drift"
        )


def _warnings(curve: FrictionCurve, plateaus: Sequence[Plateau]) -> list[str]:
    warnings = []
    if curve.excess > 2.0:
        warnings.append(
            f"the plateaus scatter {curve.excess:.1f} times more about the curve than the samples "
            "within them explain: the friction changed, or has another shape; sigma allows for it"
        )
    senses = {np.sign(p.speed) for p in plateaus}
    if len(senses) == 1 and "viscous_positive" in curve.values:
        warnings.append("all plateaus have one sense of rotation: the other one is not observed")
    return warnings


def _cure(name: str) -> str:
    if name.startswith(("static", "stribeck")):
        return "hold steady speeds near zero, where the friction still falls"
    return "hold more steady speeds, longer and over a wider range, in both senses"


def identify_steady(
    records: Record | Sequence[Record],
    *,
    inertia: float | None = None,
    hold: Mapping[str, float | None] | None = None,
    model: str | Law | None = None,
    speed_sigma: float | None = None,
) -> Fit:
    """Identify the friction curve from steady speeds, where k_m I = F(w).

    The friction experiment of Carrara and Milani (2007), one of those that Carrara and Kuga,
    "Estimating friction parameters in reaction wheels for attitude control", call deterministic
    methods. It can also be used with a drive in speed mode. `gyrostat.identification.read.plateaus`
    finds the plateaus. Each gives one point of the curve; its uncertainty follows from the scatter
    of its samples, with correlation and quantisation taken into account. If the points scatter
    about the curve by more than this uncertainty, all sigmas are increased accordingly.

    The speed is not modelled (`Fit.predicted` is empty). Between samples, the current of a speed
    loop differs from the recorded one and would not reproduce the speed.

    Args:
        records: Records of one wheel.
        inertia: Rotor inertia, kg·m²; if given, the torque of the remaining drift is subtracted.
        hold: Name -> value, SI, or None for its default. It must contain motor_constant, because
            currents and speeds determine friction only as a multiple of it.
        model: Friction model, as for the batch method; by default "viscous-coulomb", or "stribeck"
            if `hold` or clear evidence at low speeds requires it. The Stribeck speed is estimated
            unless it is held. If the plateaus do not determine it, it is held at its default.
        speed_sigma: Standard deviation of the measured speed, rad/s; by default from the records.

    Returns:
        The fit, with its points in `friction_points`.

    Raises:
        InputError: motor_constant is not held, a held value is impossible for a wheel, or the
            records have fewer plateaus than the friction model has parameters.
    """
    records = as_records(records)
    check_sigma(speed_sigma)
    check_signals(records)
    hold = hold or {}
    law, richer = _choose(model, hold)
    held = held_values(law, inertia, hold, tuple(wheel_dimensions(law)))
    require_held(held, "motor_constant", "steady currents show friction only as a multiple of it")
    plateaus = [p for r in records for p in find_plateaus(r, speed_sigma)]
    constants = {**held, **bend_speeds(law, held)}
    _require_points(records, plateaus, len(set(law.dimensions()) - set(constants)))

    curve, by_default = fit_curve(law, held, plateaus)
    if richer is not None and curve is not None and len(plateaus) > len(richer.dimensions()):
        candidate, silent = fit_curve(richer, held, plateaus)
        if candidate is not None and not silent and preferred(curve, candidate, len(plateaus)):
            curve = candidate
    if curve is None:
        raise InputError(
            f"{place(records)}: found no {law.title} friction curve through the plateaus, "
            "expected held values closer to this wheel"
        )
    count = np.array([p.count for p in plateaus], dtype=float)
    rms_scatter = float(np.sqrt(np.average([p.scatter**2 for p in plateaus], weights=count)))
    return result(
        curve.model,
        "steady",
        {n: curve.values[n] for n in curve.names},
        held | by_default,
        {n: _cure(n) for n in curve.names},
        covariance=curve.excess**2 * curve.solution.covariance(),
        reason=curve.solution.reason,
        scatter=[Scatter(place(records), rms_scatter, speed_sigma)],
        warnings=_warnings(curve, plateaus),
        iterations=curve.solution.iterations,
        samples=int(count.sum()),
        speed_sigma=speed_sigma or rms_scatter,
        records=records,
        whiteness=None,
        friction_points=FrictionPoints(
            speed=np.array([p.speed for p in plateaus]),
            torque=plateau_torques(plateaus, held),
            sigma=curve.excess * curve.sigma,
        ),
    )
