"""Content of pool.json."""

from dataclasses import asdict
from typing import Any

from gyrostat.core.units import si_unit
from gyrostat.core.views import content as json_view
from gyrostat.identification.pool.pool_model import pooled_model
from gyrostat.identification.pool.result import Pool, PooledParameter, Quantity


@json_view.register
def content(pool: Pool) -> dict[str, object]:
    """Content of pool.json: numbers, text, lists and mappings.

    Value, sigma and correlation of the parameters are those of a further record, as in fit.json.

    Args:
        pool: Pooled records.
    """
    conditions, wheel = pool.conditions, pooled_model(pool)
    parameters = {name: _parameter(p) for name, p in pool.parameters.items()}
    names, matrix = tuple(parameters), pool.correlation
    if wheel is not None and wheel.correlation is not None:
        names, matrix = wheel.correlation
    if wheel is not None and "inertia" not in parameters and "inertia" in wheel.sigma:
        inertia = {"value": wheel.values["inertia"], "sigma": wheel.sigma["inertia"]}
        parameters["inertia"] = {"unit": si_unit("inertia"), **inertia, "given": True}
    return {
        "records": len(pool.fits),
        "model": pool.fits[0].model,
        "serial": next((fit.serial for fit in pool.fits if fit.serial), ""),
        "conditions": {
            "temperature_degC": None if conditions.temperatures is None else conditions.temperature,
            "years_after_first_record": None if conditions.years is None else conditions.year,
        },
        "parameters": parameters,
        "correlation": {"names": list(names), "matrix": matrix.tolist()},
        "fits": [
            {
                "label": label,
                "file": fit.name,
                "serial": fit.serial,
                "date": None if fit.date is None else fit.date.isoformat(),
                "temperature_degC": fit.temperature,
                "parameters": {
                    name: {
                        "alone": float(p.values[k]),
                        "sigma_alone": float(p.errors[k]),
                        "pooled": asdict(p.pooled[k]),
                        "held_out_score": _at(p.held_out.scores, k),
                        "held_out_chance": _at(p.held_out.chances, k),
                        "unit": p.unit,
                    }
                    for name, p in pool.parameters.items()
                },
            }
            for k, (label, fit) in enumerate(zip(pool.labels, pool.fits, strict=True))
        ],
        "notes": list(pool.notes),
    }


def _parameter(parameter: PooledParameter) -> dict[str, Any]:
    return {
        "unit": parameter.unit,
        "value": parameter.prediction.value,
        "sigma": parameter.prediction.sigma,
        "prediction": asdict(parameter.prediction),
        "estimate_of_a_record": asdict(parameter.record),
        "mean": asdict(parameter.mean),
        "sigma_between_records": asdict(parameter.scatter),
        "common_error": parameter.shared * abs(parameter.prediction.value),
        "per_degC": _change(parameter.slope, parameter.slope_known),
        "per_year": _change(parameter.trend, parameter.trend_known),
        "log_scores": dict(parameter.held_out.log_scores),
    }


def _change(change: Quantity | None, is_known: bool) -> dict[str, object] | None:
    return None if change is None else {**asdict(change), "determined": is_known}


def _at(values: Any, k: int) -> float | None:
    return float(values[k]) if len(values) else None
