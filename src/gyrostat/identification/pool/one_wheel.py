"""Check of fits that are to be pooled."""

from collections.abc import Sequence

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.identification.result.stored_fit import StoredFit


def require_one_wheel(fits: Sequence[StoredFit]) -> None:
    """Check that several fits are of one wheel, with the same parameters, and different.

    Args:
        fits: Fits of records.

    Raises:
        InputError: There are fewer than two, or they do not belong together.
    """
    if len(fits) < 2:
        raise InputError(f"pool: records of one wheel: found {len(fits)}, expected at least 2")
    first = fits[0]
    serials = {fit.serial: fit.name for fit in fits if fit.serial}
    if len(serials) > 1:
        text = ", ".join(f"{serial} ({name})" for serial, name in serials.items())
        raise InputError(
            f"pool: found records of several wheels, serial {text}, expected one wheel: --serial "
            "takes those of one"
        )
    for k, fit in enumerate(fits):
        if fit.model != first.model or fit.names != first.names:
            found, expected = (
                f"{each.model} friction with {', '.join(each.names)}" for each in (fit, first)
            )
            raise InputError(f"{fit.name}: found {found}, expected {expected} as {first.name}")
        for name, value in first.given.items():
            if fit.given.get(name) != value:
                raise InputError(
                    f"{fit.name}: found an identification with {name} {_text(fit, name)}, expected "
                    f"{_text(first, name)} as {first.name}"
                )
        for before in fits[:k]:
            if np.array_equal(fit.values, before.values):
                raise InputError(
                    f"{fit.name}: found the same values as in {before.name}, expected another "
                    "record"
                )


def _text(fit: StoredFit, name: str) -> str:
    value = fit.given.get(name)
    return "estimated" if value is None else f"{value:.6g}"
