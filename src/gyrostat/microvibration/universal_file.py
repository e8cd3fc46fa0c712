"""Datasets 58 of universal files, by pyuff, and the units that they name."""

import importlib
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.extras import missing
from gyrostat.core.units import known_unit
from gyrostat.telemetry.fault import damaged
from gyrostat.telemetry.read import require_readable

_WANTED = "a universal file"
_SI_CODES = (1, 9)
"""Codes of units in dataset 164 that can be SI: SI, and units of the user with factors of 1."""


def datasets(path: Path) -> list[dict[str, Any]]:
    """Datasets of type 58 of a universal file.

    Raises:
        InputError: pyuff is not installed, or the file cannot be read.
    """
    try:
        pyuff: Any = importlib.import_module("pyuff")
    except ImportError:
        raise missing(str(path), "pyuff", "structure") from None
    require_readable(path, _WANTED)
    try:
        file = pyuff.UFF(str(path))
        kinds = [int(kind) for kind in file.get_set_types()]
        found = [file.read_sets(k) for k, kind in enumerate(kinds) if kind == 58]
        units = [file.read_sets(k) for k, kind in enumerate(kinds) if kind == 164]
    except Exception as error:  # pyuff raises bare exceptions
        raise damaged(path, _WANTED, error) from None
    if not found:
        raise InputError(f"{path}: found no dataset 58, expected functions at nodal degrees")
    si = all(
        each["units_code"] in _SI_CODES and each["length"] == each["force"] == 1.0 for each in units
    )
    return [{**each, "si": si} for each in found]


def unit_label(path: Path, dataset: dict[str, Any], axis: str) -> str:
    """Unit of an axis by its label; empty without one.

    Args:
        path: File, for the error message.
        dataset: Dataset 58 of `datasets`.
        axis: "abscissa", "ordinate", "orddenom" (denominator of the ordinate) or "z_axis".

    Raises:
        InputError: There is no label, and dataset 164 of the file has units other than SI.
    """
    label = str(dataset.get(f"{axis}_axis_units_lab", "")).strip()
    if label.casefold() not in ("", "none", "unknown"):
        return label
    if not dataset["si"]:
        raise InputError(
            f"{path}: found units other than SI in dataset 164 and no unit label of the {axis}, "
            "expected SI units (code 1) or a label"
        )
    return ""


def factor_of_label(
    path: Path, dataset: dict[str, Any], axis: str, dimension: str, unit: str
) -> float:
    """SI value of the unit of an axis.

    Args:
        path: File, for the error message.
        dataset: Dataset 58 of `datasets`.
        axis: Axis, see `unit_label`.
        dimension: Dimension, a key of `gyrostat.core.unit_table.TABLE`.
        unit: Unit without a label.

    Raises:
        InputError: The label is no unit of the dimension, see also `unit_label`.
    """
    label = unit_label(path, dataset, axis) or unit
    known = known_unit(label, dimension)
    if known is None:
        raise InputError(
            f"{path}: found the unit label {label!r} of the {axis}, expected a unit of "
            f"{dimension}, such as {unit}, or none"
        )
    return known.factor
