"""Wheel model for the temperature and date of a prediction."""

from collections.abc import Mapping

import numpy as np

from gyrostat.core.types import Matrix
from gyrostat.identification.pool.joint import nearest_correlation
from gyrostat.identification.pool.pool_text import conditions_text
from gyrostat.identification.pool.result import Pool, PooledParameter
from gyrostat.wheel.friction import FRICTION_MODELS, Friction
from gyrostat.wheel.model_file import WheelModel


def pooled_model(pool: Pool) -> WheelModel | None:
    """Wheel model with the predicted parameters.

    Its standard deviations are those of a further record: what is not known of the wheel, and what
    varies from one record to the next. Parameters that no record identified are those of the first
    record. None if the friction model is not of this package, or if a parameter of it is missing.
    """
    first = pool.fits[0]
    law = FRICTION_MODELS.get(first.model)
    if law is None:
        return None
    parameters = pool.parameters
    known = {"motor_constant", *law.dimensions()}
    values = {name: value for name, value in first.held.items() if name in known}
    values |= {name: p.prediction.value for name, p in parameters.items()}
    if not known <= set(values):
        return None
    values |= {name: values[limit] for name, limit in below_limits(law, parameters, values)}
    sigma = {name: p.prediction.sigma for name, p in parameters.items()}
    correlation = pool.correlation
    if first.inertia is not None:
        values["inertia"] = first.inertia
        tolerance = first.tolerances.get("inertia")
        if tolerance is not None:
            sigma["inertia"] = first.inertia * tolerance.sigma
            correlation = _with_inertia(pool, correlation)
    known.add("inertia")
    places = [k for k, name in enumerate(sigma) if name in known]
    names = tuple(name for name in sigma if name in known)
    return WheelModel(
        friction=law,
        values={name: value for name, value in values.items() if name in known},
        sigma={name: sigma[name] for name in names},
        origin={
            "method": "pool",
            "records": ", ".join(fit.name for fit in pool.fits),
            "conditions": conditions_text(pool),
        },
        correlation=(names, correlation[np.ix_(places, places)]),
    )


def below_limits(
    law: type[Friction], parameters: Mapping[str, PooledParameter], values: Mapping[str, float]
) -> list[tuple[str, str]]:
    """Parameters that are by chance below another one, as the static below the Coulomb torque.

    Args:
        law: Friction model.
        parameters: Name -> parameter over the records.
        values: Name -> value, SI.

    Returns:
        Name of each, and of the other one, where the records do not tell them apart.
    """
    errors = {name: p.prediction.sigma for name, p in parameters.items()}
    return [
        (name, limit)
        for name, limit in law.vanishing_at.items()
        if name in values
        and limit in values
        and values[name] < values[limit] < values[name] + 2.0 * errors.get(name, 0.0)
    ]


def _with_inertia(pool: Pool, correlation: Matrix) -> Matrix:
    """Correlation with the error of the inertia, which all records share, in the last row."""
    errors = np.array(
        [
            np.mean([fit.tolerances["inertia"].errors[k] / fit.values[k] for fit in pool.fits])
            * p.prediction.value
            / p.prediction.sigma
            for k, p in enumerate(pool.parameters.values())
        ]
    )
    count = len(correlation)
    wider = np.eye(count + 1)
    wider[:count, :count] = correlation
    wider[count, :count] = wider[:count, count] = errors
    return nearest_correlation(wider)
