"""Which friction model a record supports: candidates fitted, ranked, tried on another record."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.errors import InputError
from gyrostat.friction import FRICTION_MODELS
from gyrostat.identify.batch import identify
from gyrostat.identify.fit import Fit
from gyrostat.identify.validation import validate
from gyrostat.telemetry import Record


@dataclass(frozen=True)
class Candidate:
    """One friction model in a comparison.

    Attributes:
        fit: of this model.
        aic: Akaike's information criterion, relative to the best of the comparison.
        bic: Schwarz's, relative to the best.
        held_out_rms: residual on the records held out, rad/s; None without any.
    """

    fit: Fit
    aic: float
    bic: float
    held_out_rms: float | None

    def to_dict(self) -> dict[str, object]:
        """A row of the comparison in fit.json."""
        return {
            "model": self.fit.model.name,
            "parameters": len(self.fit.names),
            "converged": self.fit.converged,
            "rms_speed": self.fit.rms_speed,
            "aic": self.aic,
            "bic": self.bic,
            "held_out_rms": self.held_out_rms,
        }


def compare(
    records: Sequence[Record],
    held_out: Sequence[Record] = (),
    *,
    models: Sequence[str] | None = None,
    hold: Mapping[str, float | None] | None = None,
    **options: Any,
) -> list[Candidate]:
    """Fit candidate friction models to the same records and rank them by BIC.

    Args:
        records: fitted together.
        held_out: predicted by every candidate, never fitted.
        models: names; all known ones by default.
        hold: as for `identify`; names that a candidate does not have are left out for it.
        options: further arguments of `identify`, the same for all.

    Returns:
        The candidates, best BIC first. The criteria take the noise of the best fit as known, which
        makes them comparable under every loss.

    Raises:
        InputError: an unknown model or a record that cannot be fitted.
    """
    names = list(models or FRICTION_MODELS)
    fits = []
    for name in names:
        if name not in FRICTION_MODELS:
            raise InputError(f"model: found {name!r}, expected one of {', '.join(FRICTION_MODELS)}")
        others = {p for m in FRICTION_MODELS.values() for p in m.dimensions()}
        absent = others - set(FRICTION_MODELS[name].dimensions())
        kept = {n: v for n, v in (hold or {}).items() if n not in absent}
        fits.append(identify(records, model=name, hold=kept, **options))
    noise = options.get("speed_sigma") or min(f.speed_sigma for f in fits)
    deviance = np.array(
        [sum(float(np.nansum((r / noise) ** 2)) for r in f.residuals) for f in fits]
    )
    count = np.array([len(f.names) for f in fits])
    aic = deviance + 2.0 * count
    bic = deviance + count * np.log(fits[0].samples)
    rows = [
        Candidate(fit, float(a - aic.min()), float(b - bic.min()), _held_out(fit, held_out))
        for fit, a, b in zip(fits, aic, bic, strict=True)
    ]
    return sorted(rows, key=lambda row: row.bic)


def _held_out(fit: Fit, records: Sequence[Record]) -> float | None:
    if not records:
        return None
    wheel = {n: v for n, v in fit.parameters.items() if not n.startswith("initial_speed")}
    squares = [
        (v.rms_speed**2, v.samples) for v in (validate(fit.model, wheel, r) for r in records)
    ]
    total = sum(n for _, n in squares)
    return float(np.sqrt(sum(s * n for s, n in squares) / total))
