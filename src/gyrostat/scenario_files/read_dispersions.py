"""Read [[dispersion]] tables: distributions, the covariance of an identified wheel, or a lot."""

import difflib
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.distribution import RATIO, VALUE, Distribution, Parameter
from gyrostat.scenario.kinds.dispersion.covariance import Covariance
from gyrostat.scenario.kinds.distributions import DISTRIBUTIONS, NAMED, distribution_of
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.scenario import Dispersion, Scenario
from gyrostat.scenario.schema import Key
from gyrostat.scenario_files.read_lot import from_lot
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
    dispersions: list[Dispersion] = []
    entries = numbers_of(scenario)
    for row in top.tables("dispersion"):
        if "fit" in row.row:
            group = [_from_fit(row.known(("fit", "wheel")), scenario, force)]
        elif "lot" in row.row:
            group = from_lot(row.known(("lot", "wheel")), scenario)
        else:
            kind = DISTRIBUTIONS[row.one_of("distribution", NAMED)]
            row.known(("key", "distribution", *kind.parameters()))
            keys = _keys(row, scenario)
            group = [
                _single_key(row, kind, key, entries[key], scenario.values[key]) for key in keys
            ]
        dispersed_keys = {key for dispersion in dispersions for key in dispersion.keys}
        for key in (key for dispersion in group for key in dispersion.keys):
            if key in dispersed_keys:
                source = next((name for name in ("fit", "lot") if name in row.row), "key")
                raise row.refuse(source, key, "one dispersion of it")
        dispersions += group
    return tuple(dispersions)


def _keys(row: Table, scenario: Scenario) -> list[str]:
    """Keys of a dispersion; `wheel.*` stands for every wheel."""
    pattern = row.text("key", None)
    keys = [key for key in scenario.values if key.split(".")[0] not in ("run", "metrics")]
    start = "wheel.*."
    if pattern.startswith(start):
        wheel_keys = [f"wheel.{name}.{pattern.removeprefix(start)}" for name in scenario.wheels]
        if all(key in keys for key in wheel_keys):
            return wheel_keys
    if pattern in keys:
        return [pattern]
    patterns = {key.replace(f"wheel.{name}.", start) for name in scenario.wheels for key in keys}
    matches = difflib.get_close_matches(pattern, [*keys, *patterns], n=1)
    hint = f" (did you mean {matches[0]}?)" if matches else ""
    raise row.refuse("key", pattern, f"the key of a number of this scenario{hint}")


def _single_key(
    row: Table, kind: type[Distribution], key: str, entry: Key, nominal: float
) -> Dispersion:
    """Dispersion of a single key by a distribution."""
    if not math.isfinite(nominal):
        raise row.refuse("key", key, "a key whose value is finite")
    values = []
    for name, parameter in kind.parameters().items():
        value = _parameter(row, name, parameter, entry, nominal)
        if parameter.of == VALUE and math.isfinite(value) and not entry.allows(value):
            raise row.refuse(name, row.row.get(name, value), f"{key} {entry.range(value)}")
        values.append(value)
    dispersion = Dispersion((key,), kind.name, (tuple(values),))
    for name, expected in distribution_of(dispersion, {key: nominal}).faults():
        raise row.refuse(name, row.row.get(name, "none"), expected)
    return dispersion


def _parameter(row: Table, name: str, parameter: Parameter, entry: Key, nominal: float) -> float:
    """Parameter of a distribution, SI."""
    if name not in row.row and parameter.default is not None:
        return nominal if math.isnan(parameter.default) else parameter.default
    share = row.percentage(name)
    if parameter.of == RATIO:
        return row.quantity(name, "1", positive=False) if share is None else share
    if share is None:
        return row.quantity(name, entry.dimension, positive=False)
    return share * abs(nominal) + (nominal if parameter.of == VALUE else 0.0)


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
    return Dispersion(keys, Covariance.name, tuple(map(tuple, spread.tolist())))
