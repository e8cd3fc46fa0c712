"""Wheel model for the temperature and date of a prediction."""

import numpy as np

from gyrostat.core.types import Matrix
from gyrostat.identification.pool.joint import nearest_correlation
from gyrostat.identification.pool.pool_text import conditions_text
from gyrostat.identification.pool.result import Pool
from gyrostat.wheel.friction import FRICTION_MODELS
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
    for name, limit in law.vanishing_at.items():
        # by chance below its limit, where the records do not tell them apart
        error = parameters[name].prediction.sigma if name in parameters else 0.0
        if values[name] < values[limit] < values[name] + 2.0 * error:
            values[name] = values[limit]
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
