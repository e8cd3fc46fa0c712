"""Read [[dispersion]] tables: distributions, or the covariance of an identified wheel."""

import difflib
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.scenario import Dispersion, Scenario
from gyrostat.scenario.schema import DISTRIBUTIONS, Key
from gyrostat.scenario_files.tables import Table


def read_dispersions(
    top: Table, scenario: Scenario, *, force: bool = False
) -> tuple[Dispersion, ...]:
    """Read the dispersions of a scenario file.

    Args:
        top: Top-level table of the file.
        scenario: Scenario from the rest of the file.
        force: Accept fits that are marked as impossible.

    Raises:
        InputError: A fit that did not converge or is impossible, an unknown key or one that is
            dispersed twice, or an invalid distribution.
    """
    found: list[Dispersion] = []
    entries = numbers_of(scenario)
    for row in top.tables("dispersion"):
        if "fit" in row.row:
            made = [_from_fit(row.known(("fit", "wheel")), scenario, force)]
        else:
            kind = row.one_of("distribution", DISTRIBUTIONS)
            row.known(("key", "distribution", *DISTRIBUTIONS[kind]))
            keys = _keys(row, scenario)
            made = [_alone(row, kind, key, entries[key], scenario.values[key]) for key in keys]
        taken = {key for dispersion in found for key in dispersion.keys}
        for key in (key for dispersion in made for key in dispersion.keys):
            if key in taken:
                raise row.refuse("fit" if "fit" in row.row else "key", key, "one dispersion of it")
        found += made
    return tuple(found)


def _keys(row: Table, scenario: Scenario) -> list[str]:
    """Keys of a dispersion; `wheel.*` stands for every wheel."""
    given = row.text("key", None)
    known = [key for key in scenario.values if key.split(".")[0] not in ("run", "metrics")]
    start = "wheel.*."
    if given.startswith(start):
        each = [f"wheel.{name}.{given.removeprefix(start)}" for name in scenario.wheels]
        if all(key in known for key in each):
            return each
    if given in known:
        return [given]
    every = {key.replace(f"wheel.{name}.", start) for name in scenario.wheels for key in known}
    near = difflib.get_close_matches(given, [*known, *every], n=1)
    hint = f" (did you mean {near[0]}?)" if near else ""
    raise row.refuse("key", given, f"the key of a number of this scenario{hint}")


def _alone(row: Table, kind: str, key: str, entry: Key, nominal: float) -> Dispersion:
    """Dispersion of a single key by a distribution."""
    if not math.isfinite(nominal):
        raise row.refuse("key", key, "a key whose value is finite")
    if kind == "log_normal":
        sigma = row.percentage("sigma")
        if sigma is None:
            sigma = row.quantity("sigma", "1", positive=False)
        if not 0.0 < sigma <= 10.0:
            raise row.refuse("sigma", row.row["sigma"], "a sigma of the logarithm, above 0 to 10")
        return Dispersion((key,), kind, ((sigma,),))
    if kind == "normal":
        sigma = _amount(row, "sigma", entry, nominal)
        if not sigma > 0.0:
            raise row.refuse("sigma", row.row["sigma"], "a sigma above 0, not in % of 0")
        return Dispersion((key,), kind, ((sigma,),))
    bounds = []
    for name in ("low", "high"):
        own = row.percentage(name)
        value = nominal + own * abs(nominal) if own is not None else _amount(row, name, entry, 0.0)
        if not entry.allows(value):
            raise row.refuse(name, row.row[name], f"{key} {entry.range(value)}")
        bounds.append(value)
    if not bounds[0] < bounds[1]:
        raise row.refuse("high", row.row["high"], f"more than low, {bounds[0]:g} {entry.unit}")
    return Dispersion((key,), kind, (tuple(bounds),))


def _amount(row: Table, name: str, entry: Key, nominal: float) -> float:
    share = row.percentage(name)
    if share is not None:
        return share * abs(nominal)
    return row.quantity(name, entry.dimension, positive=False)


def _from_fit(row: Table, scenario: Scenario, force: bool) -> Dispersion:
    """Dispersion of the parameters of a wheel by the covariance of its identification."""
    # slow to import, and most scenarios have no fit
    from gyrostat.identification.result.fit_json import read_fit
    from gyrostat.identification.uncertainty.sigmas import square_root

    path = row.path.parent / row.text("fit", None).replace("\0", "")
    wheel = row.text("wheel", None)
    if wheel not in scenario.wheels:
        raise row.refuse("wheel", wheel, f"one of {', '.join(scenario.wheels)}")

    def of_wheel(content: Mapping[str, Any]) -> tuple[list[str], Vector, Matrix]:
        parameters, correlation = content["parameters"], content["correlation"]
        names = [n for n in correlation["names"] if f"wheel.{wheel}.{n}" in scenario.values]
        sigma = np.array([float(parameters[n]["sigma"]) for n in names])
        order = [correlation["names"].index(n) for n in names]
        return names, sigma, np.array(correlation["matrix"], dtype=float)[np.ix_(order, order)]

    # a covariance may be written by hand, without a statement on convergence
    names, sigma, matrix = read_fit(path, of_wheel, force=force, stated=False)
    if not names:
        raise InputError(f"{path}: found no parameter of wheel {wheel}, expected friction")
    if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(sigma)) and np.all(sigma >= 0.0)):
        raise InputError(f"{path}: found a sigma or correlation not finite, expected finite ones")
    spread: Any = square_root(matrix * np.outer(sigma, sigma))
    keys = tuple(f"wheel.{wheel}.{name}" for name in names)
    return Dispersion(keys, "normal", tuple(map(tuple, spread.tolist())))
