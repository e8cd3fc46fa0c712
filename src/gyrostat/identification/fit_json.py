"""Content of fit.json."""

from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from gyrostat.core.units import SI_UNIT

if TYPE_CHECKING:
    from gyrostat.identification.fit import Fit


def content(fit: "Fit") -> dict[str, object]:
    """Content of fit.json: numbers, text, lists and mappings.

    Args:
        fit: Result of an identification.
    """
    sigma, shares = fit.sigma, fit.variance_shares
    found = {
        "model": fit.model.name,
        "method": fit.method,
        "converged": fit.converged,
        "iterations": fit.iterations,
        "samples": fit.samples,
        "crossings": fit.crossings,
        "rms_speed": fit.rms_speed,
        "speed_sigma": fit.speed_sigma,
        "speed_sigmas": list(fit.speed_sigmas),
        "parameters": {
            name: {
                "value": float(fit.values[k]),
                "sigma": float(sigma[k]),
                "unit": SI_UNIT[fit.dimensions[name]],
                "observable": fit.observability[name].observable,
                "significance": fit.observability[name].significance,
                "sigma_noise": float(fit.noise_sigma[k]),
                "sigma_serial": float(sigma[k]),
                "least_squares": float(fit.least_squares[k]),
                "variance_shares": {n: float(s[k]) for n, s in shares.items()},
                "given": fit.observability[name].given,
            }
            for k, name in enumerate(fit.names)
        },
        "tolerances": _tolerances(fit),
        "correlation": {"names": list(fit.names), "matrix": fit.correlation.tolist()},
        "held": dict(fit.held),
        "effects": [effect.to_dict() for effect in fit.effects],
        "candidates": [asdict(score) for score in fit.scores],
        "diagnosis": [finding.to_dict() for finding in fit.findings],
        "residuals": None if fit.whiteness is None else fit.whiteness.to_dict(),
        "choices": list(fit.choices),
        "records": [r.name for r in fit.records],
        "metadata": [dict(r.metadata) for r in fit.records],
        "mean_temperature": [
            None if r.temperature is None else float(np.mean(r.temperature)) for r in fit.records
        ],
        "notes": [list(r.notes) for r in fit.records],
        "impossible": list(fit.impossible),
        "warnings": list(fit.warnings),
    }
    if fit.comparison:
        found["comparison"] = [row.to_dict() for row in fit.comparison]
    if fit.temperatures:
        found["temperature"] = [trend.to_dict() for trend in fit.temperatures]
    if fit.posterior is not None:
        found["posterior"] = fit.posterior.to_dict()
    return found


def _tolerances(fit: "Fit") -> dict[str, dict[str, object]]:
    """Error of each parameter, SI, per standard deviation of each stated tolerance."""
    if fit.tolerances is None:
        return {}
    return {
        name: {
            "sigma": fit.tolerances.sigmas[k],
            "errors": dict(zip(fit.names, fit.tolerances.roots[:, k].tolist(), strict=True)),
        }
        for k, name in enumerate(fit.tolerances.names)
    }
