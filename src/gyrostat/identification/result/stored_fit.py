"""Identified parameters with their provenance, from a fit, its fit.json or a model.toml."""

import math
import os
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described, Listed
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.units import si_unit
from gyrostat.identification.result.fit_json import parsed, read_fit
from gyrostat.wheel.model_file import KNOWN_BEFOREHAND, WheelModel, read_model

if TYPE_CHECKING:
    from gyrostat.identification.result.fit import Fit

DATE_FORMATS = ("%d.%m.%Y", "%Y/%m/%d", "%d %B %Y", "%d %b %Y", "%B %d, %Y")
"""Formats of dates beside ISO 8601; those with day and month as bare numbers are ambiguous."""


@dataclass(frozen=True)
class Tolerance(Described):
    """Contribution of one stated tolerance to the errors of the parameters.

    Attributes:
        sigma: Relative tolerance, one sigma.
        errors: Errors of the n parameters for an error of one sigma, (n,), SI.
    """

    sigma: float
    errors: Vector


@dataclass(frozen=True)
class StoredFit(Listed):
    """Identified parameters of one wheel at one date.

    Attributes:
        name: Path of the file, or name of the records.
        model: Friction model.
        names: Identified parameters of wheel and drive, without initial speeds and given values.
        units: SI unit of each parameter.
        values: Values, (n,), SI.
        covariance: Covariance of their errors, (n, n), SI.
        tolerances: Name of a given quantity -> contribution of its tolerance.
        inertia: Inertia that the identification was given, kg·m²; None if it was estimated.
        serial: Serial number of the wheel; empty if unknown.
        date: Date of the first record, UTC where it has a time zone; None if unknown.
        temperature: Mean temperature of the records, °C; None if unknown.
        held: Values of the parameters that were not estimated, SI.
        unread_date: Date that is none that is read, or is ambiguous; empty without one.
    """

    name: str
    model: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Vector
    covariance: Matrix
    tolerances: Mapping[str, Tolerance]
    inertia: float | None
    serial: str
    date: datetime | None
    temperature: float | None
    held: Mapping[str, float] = field(default_factory=dict)
    unread_date: str = ""

    @property
    def given(self) -> dict[str, float | None]:
        """Values of the wheel that were given; the inertia is None if it was estimated."""
        bench = ("current_bias", "initial_speed")
        held = {name: value for name, value in self.held.items() if not name.startswith(bench)}
        return {**held, "inertia": self.inertia}


def parse_date(text: str) -> datetime | None:
    """Date and time from text, without time zone; None if it is not an unambiguous date."""
    date = None
    with suppress(ValueError):
        date = datetime.fromisoformat(text.strip())
    for form in DATE_FORMATS:
        with suppress(ValueError):
            date = date or datetime.strptime(text.strip(), form)
    if date is not None and date.tzinfo is not None:
        date = date.astimezone(UTC).replace(tzinfo=None)
    return date


def stored_fit(fit: "Fit | str | os.PathLike[str]", *, force: bool = False) -> StoredFit:
    """Read fit.json or model.toml, or take the same content from a fit.

    Args:
        fit: Result of an identification, or path of its fit.json; or path of a model.toml, of which
            serial, date and temperature are those in [origin]; what is `known_beforehand` there is
            left out.
        force: Whether to accept a wheel that its identification marked as impossible.

    Raises:
        InputError: The file is neither, or has no uncertainty; the fit did not converge, its wheel
            is impossible, or its records belong to several wheels.
    """
    if isinstance(fit, str | os.PathLike):
        path = Path(fit)
        if path.suffix == ".toml":
            return _of_model(path, read_model(path, force=force))
        return read_fit(path, partial(_parse, str(path)), force=force)
    name = ", ".join(record.name for record in fit.records)
    return parsed(name, fit.to_dict(), partial(_parse, name), force=force)


def _parse(name: str, content: Mapping[str, Any]) -> StoredFit:
    parameters = content["parameters"]
    names = tuple(
        n
        for n, entry in parameters.items()
        if not n.startswith("initial_speed") and not entry.get("given", False)
    )
    values = np.array([float(parameters[n]["value"]) for n in names])
    sigma = np.array([float(parameters[n]["sigma"]) for n in names])
    correlation_names = list(content["correlation"]["names"])
    places = [correlation_names.index(n) for n in names]
    matrix = np.array(content["correlation"]["matrix"], dtype=float)[np.ix_(places, places)]
    covariance = matrix * np.outer(sigma, sigma)
    _check_covariance(name, values, covariance)
    tolerances = {
        tolerance: Tolerance(
            float(entry["sigma"]), np.array([float(entry["errors"].get(n, 0.0)) for n in names])
        )
        for tolerance, entry in content.get("tolerances", {}).items()
    }
    metadata = content.get("metadata", ())
    serials = _each(metadata, "serial")
    if len(set(serials)) > 1:
        text = ", ".join(dict.fromkeys(serials))
        raise InputError(
            f"{name}: found records of several wheels (serial {text}), expected one wheel"
        )
    texts = _each(metadata, "date")
    dates = [date for date in map(parse_date, texts) if date is not None]
    means = [float(t) for t in content.get("mean_temperature", ()) if t is not None]
    inertia_entry = parameters.get("inertia", {})
    inertia = content.get("held", {}).get("inertia")
    inertia = float(inertia_entry["value"]) if inertia_entry.get("given", False) else inertia
    return StoredFit(
        name=name,
        model=str(content["model"]),
        names=names,
        units=tuple(str(parameters[n]["unit"]) for n in names),
        values=values,
        covariance=covariance,
        tolerances=tolerances,
        inertia=None if inertia is None else float(inertia),
        serial=serials[0] if serials else "",
        date=min(dates) if dates else None,
        temperature=math.fsum(means) / len(means) if means else None,
        held={str(n): float(v) for n, v in content.get("held", {}).items()},
        unread_date=_unread(texts),
    )


def _of_model(path: Path, model: WheelModel) -> StoredFit:
    """Parameters with a standard deviation; errors that they share with other files are unknown."""
    every, matrix = model.covariance()
    stated = re.split(r",\s*", model.origin.get(KNOWN_BEFOREHAND, ""))
    names = tuple(n for n in every if n not in stated)
    places = [every.index(n) for n in names]
    covariance = matrix[np.ix_(places, places)]
    values = np.array([model.values.get(n, np.nan) for n in names])
    _check_covariance(str(path), values, covariance)
    temperature = None
    with suppress(ValueError):
        temperature = float(model.origin.get("temperature", "").removesuffix("°C"))
    dimensions, stated_date = model.dimensions(), model.origin.get("date", "")
    return StoredFit(
        name=str(path),
        model=model.friction.name,
        names=names,
        units=tuple(si_unit(dimensions[n]) for n in names),
        values=values,
        covariance=covariance,
        tolerances={},
        inertia=None if "inertia" in names else model.values.get("inertia"),
        serial=model.origin.get("serial", ""),
        date=parse_date(stated_date),
        temperature=temperature,
        held={n: v for n, v in model.values.items() if n not in names},
        unread_date=_unread([stated_date]),
    )


def _unread(dates: Iterable[str]) -> str:
    """First date that is not read; empty without one."""
    return next((text for text in dates if text and parse_date(text) is None), "")


def _check_covariance(name: str, values: Vector, covariance: Matrix) -> None:
    """Refuse no parameters, and values and covariances that are impossible."""
    sigma = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    finite = np.all(np.isfinite(values)) and np.all(np.isfinite(covariance)) and np.all(sigma > 0)
    # with rounding errors, a stored correlation may be slightly indefinite
    if not (values.size and finite) or (
        np.linalg.eigvalsh(covariance / np.outer(sigma, sigma)).min() < -1e-6
    ):
        raise InputError(
            f"{name}: found no identified parameters or an impossible covariance, expected finite "
            "values with a positive semidefinite correlation"
        )


def _each(metadata: Iterable[Mapping[str, str]], name: str) -> list[str]:
    """Values of one entry in the metadata of several records."""
    return [str(entry[name]) for entry in metadata if name in entry]
