"""Which parameters are estimated, from where, and with what a-priori knowledge."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from gyrostat._types import Vector
from gyrostat.errors import InputError
from gyrostat.identify.deterministic import StartValues
from gyrostat.identify.least_squares import Prior
from gyrostat.identify.prediction import SpeedPrediction
from gyrostat.units import SI_UNIT

SMALLEST_INERTIA, LARGEST_INERTIA = 1e-12, 1e6
"""kg·m²: beyond any rotor; a number outside is a slip of units."""
WEAK = 10.0
"""A-priori sigma, as a multiple of the start value, of a parameter about which nothing is said: it
keeps the problem regular where the record is silent and moves nothing where it is not."""


@dataclass(frozen=True)
class Selection:
    """The estimation problem in terms of parameter names.

    Attributes:
        free: names that are estimated, in the order of the prediction.
        values: (n,) held values and starts of all parameters of the prediction.
        fallback: the same with the records' own starts in place of the user's.
        prior: of the free parameters.
        informed: names of the free parameters whose a-priori the user gave.
    """

    free: tuple[str, ...]
    values: Vector
    fallback: Vector
    prior: Prior
    informed: frozenset[str]

    def index(self, prediction: SpeedPrediction) -> list[int]:
        """Places of the free parameters among all of the prediction."""
        return [prediction.names.index(name) for name in self.free]


def _known(names: Collection[str], prediction: SpeedPrediction, what: str) -> None:
    unknown = [name for name in names if name not in prediction.names]
    if unknown:
        raise InputError(
            f"{what}: found parameter {unknown[0]!r}, expected one of {', '.join(prediction.names)}"
        )


def _free_names(
    prediction: SpeedPrediction, hold: Mapping[str, float | None], free: Collection[str]
) -> tuple[str, ...]:
    both = sorted(set(hold) & set(free))
    if both:
        raise InputError(f"{both[0]}: found both held and free, expected one of the two")
    held = {"inertia", "current_bias", *prediction.model.held_by_default, *hold} - set(free)
    return tuple(name for name in prediction.names if name not in held)


def _check_scale(prediction: SpeedPrediction, free: Collection[str], prior: Collection[str]):
    """Currents and speeds give torques only relative to the inertia: one of them must be known."""
    torques = [n for n, d in prediction.model.dimensions().items() if d in ("torque", "viscous")]
    scale = {"inertia", "motor_constant", *torques}
    if scale <= set(free) and not scale & set(prior):
        raise InputError(
            "inertia: found free together with motor_constant and all friction torques, expected "
            "one of them held or with an a-priori: a record of current and speed shows only their "
            "ratios"
        )


def _check_values(prediction: SpeedPrediction, given: Mapping[str, float], what: str) -> None:
    positive = {"inertia", *prediction.model.held_by_default}
    for name, value in given.items():
        unit = SI_UNIT[prediction.dimensions[name]]
        if not np.isfinite(value):
            raise InputError(f"{what} {name}: found {value}, expected a finite number in {unit}")
        if name == "inertia" and value > 0.0 and not SMALLEST_INERTIA < value < LARGEST_INERTIA:
            raise InputError(
                f"{what} {name}: found {value:g}, expected {SMALLEST_INERTIA:g} to "
                f"{LARGEST_INERTIA:g} {unit}"
            )
        if name in positive and value <= 0.0:
            raise InputError(f"{what} {name}: found {value:g}, expected more than 0 {unit}")


def select(
    prediction: SpeedPrediction,
    deterministic: StartValues,
    *,
    inertia: float | None,
    hold: Mapping[str, float | None],
    free: Collection[str],
    prior: Mapping[str, tuple[float, float]],
    start: Mapping[str, float],
) -> Selection:
    """Decide what is estimated.

    Args:
        prediction: the records and the friction model.
        deterministic: start values from the records alone.
        inertia: kg·m², held unless "inertia" is in `free`.
        hold: name -> held value, SI, or None for the default.
        free: names estimated in addition to the default ones.
        prior: name -> a-priori mean and sigma, SI.
        start: name -> first value, SI; otherwise the a-priori mean, otherwise `deterministic`.

    Raises:
        InputError: unknown names, values that no wheel can have, no inertia, or a torque scale
            that is left entirely free.
    """
    for what, names in (("hold", hold), ("free", free), ("prior", prior), ("start", start)):
        _known(names, prediction, what)
    given_hold = {n: v for n, v in hold.items() if v is not None}
    if inertia is not None:
        _check_values(prediction, {"inertia": inertia}, "parameter")
    _check_values(prediction, given_hold, "held")
    _check_values(prediction, {n: m for n, (m, _) in prior.items()}, "a-priori mean of")
    _check_values(prediction, start, "start of")
    for name, (_, sigma) in prior.items():
        if not sigma > 0.0:
            raise InputError(f"a-priori sigma of {name}: found {sigma:g}, expected more than 0")
    names = _free_names(prediction, hold, free)
    _check_scale(prediction, names, prior)

    means = {n: mean for n, (mean, _) in prior.items()}
    fixed = {**({} if inertia is None else {"inertia": inertia}), **given_hold}
    known = {**fixed, **means, **start}
    first = deterministic.parameters(prediction, known)
    if "inertia" not in first:
        raise InputError(
            "inertia: found none, expected the wheel's inertia in kg·m² (--inertia), or "
            "motor_constant held and inertia free"
        )
    values = {**first, **known, **fixed}
    own = {**first, **fixed}
    sizes = prediction.dimensions
    mean = {n: means.get(n, values[n]) for n in names}
    sigma = {
        n: prior[n][1]
        if n in prior
        else WEAK * max(abs(first[n]), deterministic.size(n, sizes[n], first["inertia"]))
        for n in names
    }
    return Selection(
        free=names,
        values=np.array([values[n] for n in prediction.names], dtype=float),
        fallback=np.array([own[n] for n in prediction.names], dtype=float),
        prior=Prior(
            np.array([mean[n] for n in names]), np.array([sigma[n] for n in names], dtype=float)
        ),
        informed=frozenset(prior),
    )
