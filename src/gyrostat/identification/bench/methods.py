"""Bench methods by name."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from gyrostat.core.errors import InputError
from gyrostat.identification.bench.coast import identify_coast
from gyrostat.identification.bench.steady import identify_steady
from gyrostat.identification.bench.torque_step import identify_torque_step
from gyrostat.identification.conclude import with_tolerances
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.uncertainty.tolerances import check_tolerances, propagate_dedicated
from gyrostat.telemetry import Record
from gyrostat.wheel.friction_laws import Law, friction_law

WITHOUT_MODEL: dict[str, Callable[..., Fit]] = {
    "coast": identify_coast,
    "torque-step": identify_torque_step,
}
"""Methods with a fixed friction model."""


def identify_dedicated(
    method: str,
    records: Sequence[Record],
    *,
    model: str | Law | None,
    inertia: float | None,
    hold: Mapping[str, float | None],
    speed_sigma: float | None,
    tolerance: Mapping[str, float] | None = None,
) -> Fit:
    """Identify by one of the bench methods.

    Args:
        method: "steady", "torque-step" or "coast".
        records: Records of one wheel.
        model: Friction model, only for "steady".
        inertia: Rotor inertia, kg·m².
        hold: Name -> value, SI, or None for its default.
        speed_sigma: Standard deviation of the measured speed, rad/s.
        tolerance: Name of a given quantity -> relative tolerance, one sigma, as for `identify`.

    Raises:
        InputError: A friction model is given for a method with a fixed one, or the method itself
            fails.
    """
    tolerances = check_tolerances(tolerance or {})
    identify = WITHOUT_MODEL.get(method, partial(identify_steady, model=model))
    if method in WITHOUT_MODEL and model is not None:
        raise InputError(
            f"--method {method}: found --model {friction_law(model).name}, expected no model: "
            "this method identifies viscous and Coulomb friction or the motor constant"
        )
    fit = identify(records, inertia=inertia, hold=hold, speed_sigma=speed_sigma)
    if not tolerances:
        return fit
    dimensions = [fit.dimensions[name] for name in fit.names]
    errors = propagate_dedicated(tolerances, fit.method, dimensions, fit.values)
    return with_tolerances(fit, errors, tolerances)
