"""Content of fit.json: from an identification, and read again."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import read_text
from gyrostat.core.units import si_unit
from gyrostat.core.views import content as json_view
from gyrostat.identification.result.fit import Fit

T = TypeVar("T")


@json_view.register
def content(fit: Fit) -> dict[str, object]:
    """Content of fit.json: numbers, text, lists and mappings.

    Args:
        fit: Result of an identification.
    """
    sigma, shares = fit.sigma, fit.variance_shares
    document = {
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
                "unit": si_unit(fit.dimensions[name]),
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
        "effects": [asdict(effect) for effect in fit.effects],
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
    if fit.feedback is not None:
        document["feedback"] = fit.feedback.to_dict()
    if fit.inverse is not None:
        document["inverse"] = fit.inverse.to_dict()
    if fit.comparison:
        document["comparison"] = [row.to_dict() for row in fit.comparison]
    if fit.temperatures:
        document["temperature"] = [trend.to_dict() for trend in fit.temperatures]
    if fit.posterior is not None:
        document["posterior"] = fit.posterior.to_dict()
    return document


def _tolerances(fit: Fit) -> dict[str, dict[str, object]]:
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


def read_fit(
    path: Path, parse: Callable[[Mapping[str, Any]], T], *, force: bool = False, stated: bool = True
) -> T:
    """Read a fit.json; for the arguments and errors see `parsed`."""
    text = read_text(path, "a fit.json")
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(
            f"{path}: found invalid JSON ({error}), expected a fit.json of gyrostat identify"
        ) from None
    return parsed(str(path), content, parse, force=force, stated=stated)


def parsed(
    name: str,
    content: Mapping[str, Any],
    parse: Callable[[Mapping[str, Any]], T],
    *,
    force: bool = False,
    stated: bool = True,
) -> T:
    """Take what is needed from the content of a fit.json, if the fit is valid.

    Args:
        name: Path of the file or name of the fit, for messages.
        content: Content of fit.json.
        parse: Function that takes what is needed from the content.
        force: Whether to accept a wheel that its identification marked as impossible.
        stated: Whether the content must state that the fit converged.

    Returns:
        Result of `parse`.

    Raises:
        InputError: The content is not that of a fit.json, the fit did not converge, or its wheel is
            impossible.
    """
    try:
        result = parse(content)
        converged = content["converged"] if stated else content.get("converged", True)
        impossible = [str(reason) for reason in content.get("impossible", ())]
    except InputError:
        raise
    except (ValueError, TypeError, KeyError, IndexError, AttributeError) as error:
        where = f"key {error}" if isinstance(error, KeyError) else "its content"
        raise InputError(
            f"{name}: found no parameters with sigma and correlation ({where}: found none or "
            "another type), expected a fit.json of gyrostat identify"
        ) from None
    if not converged:
        raise InputError(f"{name}: found a fit that did not converge, expected one that did")
    if impossible and not force:
        raise InputError(
            f"{name}: found a wheel that is not valid ({'; '.join(impossible)}), expected a valid "
            "one, or --force"
        )
    return result
