"""Content of lot.json."""

from dataclasses import asdict
from typing import Any

from gyrostat.core.text import or_none
from gyrostat.core.types import Matrix
from gyrostat.core.views import content as json_view
from gyrostat.identification.judge.fit_changes import FALSE_ALARMS
from gyrostat.identification.lot.result import Lot, LotParameter


@json_view.register
def content(lot: Lot) -> dict[str, object]:
    """Content of lot.json: numbers, text, lists and mappings.

    Args:
        lot: Result of the analysis.
    """
    one_sided, two_sided = lot.factors
    return {
        "wheels": len(lot.fits),
        "model": lot.fits[0].model,
        "shape": lot.shape,
        "content": lot.content,
        "confidence": lot.confidence,
        "classical_factors": {"one_sided": one_sided, "two_sided": two_sided},
        "parameters": {name: _parameter(p, lot) for name, p in lot.parameters.items()},
        "correlation": {
            "names": list(lot.parameters),
            "matrix": _rows(lot.correlation.value),
            "low": _rows(lot.correlation.low),
            "high": _rows(lot.correlation.high),
            "estimates": _rows(lot.correlation.estimates),
        },
        "outliers": [
            {"wheel": label, "parameter": name, "chance": chance}
            for label, name, chance in lot.outliers
        ],
        "false_alarms": FALSE_ALARMS,
        "best_set": asdict(lot.best) | {"wheels": [lot.labels[k] for k in lot.best.wheels]},
        "fits": [
            {
                "label": label,
                "serial": fit.serial,
                "date": None if fit.date is None else fit.date.isoformat(),
                "file": fit.name,
            }
            for label, fit in zip(lot.labels, lot.fits, strict=True)
        ],
        "notes": list(lot.notes),
    }


def _parameter(parameter: LotParameter, lot: Lot) -> dict[str, Any]:
    chart = parameter.chart
    return {
        "unit": parameter.unit,
        "median": asdict(parameter.median),
        "sigma": asdict(parameter.sigma),
        "shape": asdict(parameter.shape),
        "sigma_estimates": parameter.sigma_estimates,
        "sigma_errors": parameter.sigma_errors,
        "common_error": parameter.common_error,
        "limits": asdict(parameter.limits),
        "drift": None if parameter.drift is None else asdict(parameter.drift),
        "scores": chart.scores.tolist(),
        "beyond_shewhart_limits": [lot.labels[k] for k in chart.beyond],
        "cusum_signals": [lot.labels[k] for k in chart.shifts],
    }


def _rows(matrix: Matrix) -> list[list[float | None]]:
    return [[or_none(value) for value in row] for row in matrix.tolist()]
