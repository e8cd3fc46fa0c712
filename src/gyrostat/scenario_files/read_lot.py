"""Read the dispersion table of a lot of wheels, lot.toml of `gyrostat lot`."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import read_toml, refuse_unknown
from gyrostat.scenario.kinds.dispersion.lot import WheelLot
from gyrostat.scenario.scenario import Dispersion, Scenario
from gyrostat.scenario_files.tables import Table

KIND = "a lot.toml of gyrostat lot"
COLUMNS = ("location", "scale", "shape")
KEYS = ("model", "wheels", "names", *COLUMNS, "correlation")


def from_lot(row: Table, scenario: Scenario) -> list[Dispersion]:
    """Dispersions of a wheel, or of all wheels (`*`), that are drawn from a lot.

    Args:
        row: Table [[dispersion]] with `lot` and `wheel`.
        scenario: Scenario with the wheels.

    Raises:
        InputError: The file is not a lot.toml, its friction model is another one, or there is no
            such wheel.
    """
    # slow to import, and most scenarios have no lot
    from gyrostat.identification.uncertainty.sigmas import square_root

    path = row.path.parent / row.text("lot", None).replace("\0", "")
    wheel = row.text("wheel", None)
    if wheel not in (*scenario.wheels, "*"):
        raise row.refuse("wheel", wheel, f"one of {', '.join(scenario.wheels)}, or *")
    content = read_toml(path, KIND)
    refuse_unknown(path, "", content, KEYS)
    names = content.get("names", [])
    count = len(names) if isinstance(names, list) and names else 1
    columns = np.array([_numbers(path, content, key, (count,)) for key in COLUMNS])
    matrix = _numbers(path, content, "correlation", (count, count))
    if np.any(columns[1] <= 0.0) or not np.allclose(np.diag(matrix), 1.0):
        raise InputError(
            f"{path}: found a scale of 0 or less, or a correlation with itself that is not 1, "
            f"expected {KIND}"
        )
    if content.get("model") != scenario.friction:
        raise InputError(
            f"{path}: found friction model {content.get('model')!r}, expected that of the "
            f"scenario's wheels, {scenario.friction!r}"
        )
    dispersions = []
    for one in scenario.wheels if wheel == "*" else (wheel,):
        keys = [f"wheel.{one}.{name}" for name in names]
        chosen = [k for k, key in enumerate(keys) if key in scenario.values]
        if not chosen:
            raise InputError(f"{path}: found no parameter of wheel {one}, expected friction")
        root = square_root(matrix[np.ix_(chosen, chosen)])
        rows = np.column_stack([columns[:, chosen].T, root])
        dispersions.append(
            Dispersion(
                tuple(keys[k] for k in chosen), WheelLot.name, tuple(map(tuple, rows.tolist()))
            )
        )
    return dispersions


def _numbers(
    path: Path, content: Mapping[str, Any], key: str, shape: tuple[int, ...]
) -> NDArray[np.float64]:
    """Finite numbers of a key, as many as there are names."""
    try:
        array = np.array(content.get(key), dtype=float)
    except (TypeError, ValueError):
        array = np.zeros(0)
    if array.shape != shape or not np.all(np.isfinite(array)):
        size = " x ".join(map(str, shape))
        raise InputError(f"{path}: key {key}: found no {size} finite numbers, expected {KIND}")
    return array
