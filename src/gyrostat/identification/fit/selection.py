"""Select estimated parameters, start values and a-priori information."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.core.units import si_unit
from gyrostat.core.validation import require
from gyrostat.identification.fit.least_squares import Prior
from gyrostat.identification.fit.parameters import check_parameter
from gyrostat.identification.fit.prediction import SpeedPrediction
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.fit.start_values import StartValues
from gyrostat.wheel.friction.contract import start_fault

SMALLEST_INERTIA, LARGEST_INERTIA = 1e-12, 1e6
"""Range of the inertia of rotors, kg·m²; a value outside has the wrong unit."""
WEAK = 10.0
"""A-priori sigma, as a multiple of the start value, of a parameter without a-priori knowledge. It
keeps the problem regular if the record does not show the parameter and is negligible otherwise."""


@dataclass(frozen=True)
class Selection:
    """Estimated parameters, start values and a-priori knowledge, by name.

    Attributes:
        free: Names of the estimated parameters, in the order of the prediction.
        values: Held values and start values of all parameters of the prediction, (n,).
        fallback: The same with start values from the records instead of the user's.
        prior: A-priori knowledge of the free parameters.
        told: Free names with a start value from the user.
        scale: Weak a-priori sigmas, (free,): plausible sizes of the parameters, independent of the
            user's a-priori knowledge.
    """

    free: tuple[str, ...]
    values: Vector
    fallback: Vector
    prior: Prior
    told: frozenset[str]
    scale: Vector

    def index(self, prediction: SpeedPrediction) -> list[int]:
        """Indices of the free parameters among all of the prediction."""
        return [prediction.names.index(name) for name in self.free]


def _require_names(names: Collection[str], prediction: SpeedPrediction, key: str) -> None:
    unknown = [name for name in names if name not in prediction.names]
    if unknown:
        raise InputError(
            f"{key}: found parameter {unknown[0]!r}, expected one of {', '.join(prediction.names)}"
        )


def _free_names(
    prediction: SpeedPrediction,
    hold: Collection[str],
    free: Collection[str],
    prior: Collection[str],
    start: Collection[str],
) -> tuple[str, ...]:
    """Names to estimate: the default ones, the requested ones and those with a-priori knowledge."""
    for names, role in ((free, "free"), (prior, "with an a-priori")):
        common = sorted(set(hold) & set(names))
        if common:
            raise InputError(f"{common[0]}: found both held and {role}, expected one of the two")
    constants = {"inertia", "current_bias", *prediction.model.held_by_default, *hold}
    constants -= {*free, *prior}
    idle = [name for name in start if name in constants]
    if idle:
        raise InputError(
            f"start of {idle[0]}: found a parameter that is held, expected one that is estimated "
            f"(free {idle[0]}, or hold it at this value)"
        )
    return tuple(name for name in prediction.names if name not in constants)


def _held_values(
    prediction: SpeedPrediction, hold: Mapping[str, float | None], inertia: float | None
) -> dict[str, float]:
    """Held values given by the user: name -> SI; a default is used only if it is documented."""
    constants = {} if inertia is None else {"inertia": inertia}
    default = {"current_bias", *prediction.model.held_by_default, *constants}
    for name, value in hold.items():
        if value is None:
            if name not in default:
                unit = si_unit(prediction.dimensions[name])
                raise InputError(f"held {name}: found no value, expected one in {unit}")
        elif constants.get(name, value) != value:
            raise InputError(
                f"inertia: found {constants[name]:g} and, held, {value:g} kg·m², expected one of "
                "the two"
            )
        else:
            constants[name] = value
    return constants


def _check_scale(
    prediction: SpeedPrediction,
    free: Collection[str],
    prior: Collection[str],
    constants: Mapping[str, float],
) -> None:
    """Check that a request determines the torque scale.

    Currents and speeds give torques only relative to the inertia: one of them must be known.
    """
    scale = {"inertia", "motor_constant", *prediction.model.coefficients()}
    # a torque of zero does not fix the scale
    references = {name for name in scale - set(free) if constants.get(name) != 0.0}
    if not references and not scale & set(prior):
        raise InputError(
            "inertia: found free together with motor_constant and all friction torques, expected "
            "one of them held or with an a-priori: a record of current and speed shows only their "
            "ratios"
        )


def _check_values(prediction: SpeedPrediction, values: Mapping[str, float], label: str) -> None:
    for name, value in values.items():
        unit = si_unit(prediction.dimensions[name])
        if name == "inertia" and value > 0.0 and not SMALLEST_INERTIA < value < LARGEST_INERTIA:
            raise InputError(
                f"{label} {name}: found {value:g}, expected {SMALLEST_INERTIA:g} to "
                f"{LARGEST_INERTIA:g} {unit}"
            )
        check_parameter(prediction.model, name, value, f"{label} {name}")


def select(prediction: SpeedPrediction, deterministic: StartValues, problem: Problem) -> Selection:
    """Select the estimated parameters.

    Args:
        prediction: Records and friction model.
        deterministic: Start values from the records alone; a start value or a-priori mean of the
            problem replaces them.
        problem: Held, free and a-priori values.

    Raises:
        InputError: Names are unknown, values are impossible for a wheel, requests contradict each
            other, the inertia is missing, or no torque scale is known.
    """
    hold, free, prior, start = problem.hold, problem.free, problem.prior, problem.start
    for key, names in (("hold", hold), ("free", free), ("prior", prior), ("start", start)):
        _require_names(names, prediction, key)
    constants = _held_values(prediction, hold, problem.inertia)
    _check_values(prediction, {n: v for n, v in constants.items() if n not in hold}, "parameter")
    _check_values(prediction, {n: v for n, v in constants.items() if n in hold}, "held")
    _check_values(prediction, {n: m for n, (m, _) in prior.items()}, "a-priori mean of")
    _check_values(prediction, start, "start of")
    for name, (_, sigma) in prior.items():
        require(f"a-priori sigma of {name}", sigma, positive=True)
    names = _free_names(prediction, hold, free, prior, start)
    _check_scale(prediction, names, prior, constants)

    means = {n: mean for n, (mean, _) in prior.items()}
    estimates = deterministic.parameters(prediction, {**start, **means, **constants}) | constants
    if "inertia" not in estimates:
        raise InputError(
            "inertia: found none, expected the wheel's inertia in kg·m² (--inertia), or "
            "motor_constant held and inertia free"
        )
    values = {**estimates, **means, **start}
    mean, scale, differences = {**estimates, **means}, [], {}
    for index, name in enumerate(names):
        size = deterministic.size(
            name, prediction.dimensions[name], estimates["inertia"], estimates["motor_constant"]
        )
        # a number that starts at zero and has no natural size
        scale.append(WEAK * (max(abs(estimates[name]), size) or 1.0))
        reference = prediction.model.vanishing_at.get(name)
        if reference is not None and name not in prior:
            # without information in the record it has no effect, and equals its reference
            mean[name] = mean[reference]
            if reference in names:
                differences[index] = names.index(reference)
    return Selection(
        free=names,
        values=np.array([values[n] for n in prediction.names], dtype=float),
        fallback=np.array([estimates[n] for n in prediction.names], dtype=float),
        prior=Prior(
            np.array([mean[n] for n in names], dtype=float),
            np.array([prior[n][1] if n in prior else s for n, s in zip(names, scale, strict=True)]),
            differences,
        ),
        told=frozenset(start),
        scale=np.array(scale),
    )


def check_start(prediction: SpeedPrediction, selection: Selection) -> None:
    """Validate the friction curve of a law of the user's at the start values.

    Raises:
        InputError: The curve is no friction; see `gyrostat.wheel.friction.contract`.
    """
    law = prediction.model
    if not law.is_shipped():
        start = dict(zip(prediction.names, selection.values, strict=True))
        fault = start_fault(law, law.possible(start))
        if fault:
            raise InputError(f"{law.__name__} at the start values: {fault}")
