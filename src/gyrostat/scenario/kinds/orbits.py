"""Tables along the orbit of a scenario."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from math import tau
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.core.types import Matrix
from gyrostat.scenario.kinds.registry import KINDS
from gyrostat.scenario.metrics.tracker_view import HEADS
from gyrostat.scenario.scenario import KEEP_OUT, Scenario
from gyrostat.scenario.sensing import Values, options_of
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.orbit.tables import STEPS, OrbitAccuracy, orbit_environment
from gyrostat.spacecraft.orbit.time_scales import Epoch

PHASE = "orbit.phase"
"""Key of the start along the orbit, which runs that share tables may differ in."""


def planned_orbit(scenario: Scenario) -> OrbitEnvironment | None:
    """Tables along the orbit of a scenario; None without an orbit.

    They are shared by all runs, each from its phase on. Where more than the phase is dispersed,
    they are those of the nominal run, with the rows of the tables of every run.

    Raises:
        InputError: The orbit is not possible, its file does not cover the run, or a library of the
            extra `orbit` is missing.
    """
    if scenario.orbit == "none":
        return None
    if has_own_orbits(scenario.dispersed):
        return _tables_of(scenario, scenario.values, _own_step(scenario))[0]
    values = {**scenario.values, PHASE: 0.0}
    return _tables_of(scenario, values, share=_shared_periods(scenario))[0]


def shared_span(scenario: Scenario) -> tuple[Epoch, float]:
    """Epoch of the tables that all runs share, and the time after it that the runs need, s.

    Raises:
        InputError: Each run has tables of its own.
    """
    own = [key for key in scenario.dispersed if key.startswith("orbit.") and key != PHASE]
    if own:
        raise InputError(
            f"key dispersion: found {own[0]} beside the position of another spacecraft, expected "
            "no element of the orbit but its phase"
        )
    orbit, epoch = _elements(scenario, scenario.values)
    end = scenario.duration + _shared_periods(scenario) * orbit.period
    return Epoch.of(epoch, float(scenario.values["orbit.ut1_utc"])), end


def _shared_periods(scenario: Scenario) -> float:
    """Largest phase of a run that shares tables with others, in periods."""
    return 1.0 if PHASE in scenario.dispersed else scenario.values[PHASE] / tau


def nominal_orbit(scenario: Scenario) -> OrbitEnvironment | None:
    """Tables of the nominal run from its phase, with the splines of the campaign; None without."""
    orbit = orbit_of_run(scenario.values, planned_orbit(scenario), scenario.dispersed)
    if orbit is None or has_own_orbits(scenario.dispersed):
        return orbit
    return orbit.until(scenario.duration)


def orbit_with_moon(scenario: Scenario) -> OrbitEnvironment | None:
    """Tables of the nominal run with the Moon; None without an orbit."""
    if scenario.orbit == "none":
        return None
    return _tables_of(scenario, scenario.values, moon=True)[0]


def has_own_orbits(dispersed: Sequence[str]) -> bool:
    """Whether each run has tables of its own: more of the orbit than its phase is dispersed."""
    return any(key.startswith("orbit.") and key != PHASE for key in dispersed)


def orbit_of_run(
    values: Values, planned: OrbitEnvironment | None, dispersed: Sequence[str]
) -> OrbitEnvironment | None:
    """Orbit of a run, from its phase; tables of its own start there.

    Args:
        values: Values of the run.
        planned: Tables that all runs share, or those of the run; None without an orbit.
        dispersed: Keys of the dispersed values.
    """
    if planned is None or has_own_orbits(dispersed):
        return planned
    return replace(planned, offset=values[PHASE] / tau * planned.period)


def own_orbits(scenario: Scenario, values: Matrix) -> OrbitEnvironment | None:
    """Tables of runs with own orbits, each leaf with a leading axis of runs; None without.

    Args:
        scenario: Scenario of the runs.
        values: Dispersed values, (runs, keys).

    Raises:
        InputError: An orbit is not possible, or its tables need more rows than those of the
            nominal run.
    """
    if not has_own_orbits(scenario.dispersed):
        return None
    orbits = [_own_orbit(scenario, tuple(row)) for row in values.tolist()]
    return jax.tree.map(lambda *leaves: np.stack(leaves), *orbits)


def check_own_orbits(scenario: Scenario, values: Matrix) -> None:
    """Check the orbits of the runs with the smallest and the largest value of each element.

    Args:
        scenario: Scenario of the runs.
        values: Dispersed values, (runs, keys).

    Raises:
        InputError: See `own_orbits`.
    """
    columns = [k for k, key in enumerate(scenario.dispersed) if key.startswith("orbit.")]
    ends = {int(end(values[:, k])) for k in columns for end in (np.argmin, np.argmax)}
    own_orbits(scenario, values[sorted(ends)])


@lru_cache(maxsize=8)
def _own_step(scenario: Scenario) -> int:
    """Step of the tables of every run, s; other orbits may need more rows than the nominal."""
    _, accuracy = _tables_of(scenario, scenario.values)
    return next((step for step in STEPS if step < accuracy.step), STEPS[-1])


def orbit_of(
    scenario: Scenario, values: Mapping[str, float], planned: OrbitEnvironment | None
) -> OrbitEnvironment | None:
    """Orbit of a run, which may have tables of its own.

    Args:
        scenario: Scenario of the run.
        values: Values of the run.
        planned: Tables as from `planned_orbit`.
    """
    if planned is not None and has_own_orbits(scenario.dispersed):
        return _own_orbit(scenario, tuple(float(values[key]) for key in scenario.dispersed))
    return orbit_of_run(values, planned, scenario.dispersed)


@lru_cache(maxsize=256)
def _own_orbit(scenario: Scenario, row: tuple[float, ...]) -> OrbitEnvironment:
    draw = dict(zip(scenario.dispersed, row, strict=True))
    try:
        return _tables_of(scenario, {**scenario.values, **draw}, _own_step(scenario))[0]
    except InputError as error:
        elements = {key: value for key, value in draw.items() if key.startswith("orbit.")}
        label = ", ".join(f"{key} {value:.6g}" for key, value in elements.items())
        raise InputError(f"run with {label}: {error}: use less spread") from None


def _tables_of(
    scenario: Scenario,
    values: Mapping[str, float],
    step: int | None = None,
    share: float = 0.0,
    moon: bool = False,
) -> tuple[OrbitEnvironment, OrbitAccuracy]:
    """Tables from the phase on, for a run and a share of a period more, and their accuracy."""
    orbit, epoch = _elements(scenario, values)
    names = ("f107", "f107a", "ap", "ut1_utc")
    indices = {name: float(values[f"orbit.{name}"]) for name in names}
    return orbit_environment(
        orbit,
        epoch,
        scenario.duration + share * orbit.period,
        start=float(values[PHASE]) / tau * orbit.period,
        step=step,
        moon=moon or any(part.section in (HEADS, KEEP_OUT) for part in scenario.parts),
        **indices,
    )


def _elements(scenario: Scenario, values: Mapping[str, float]) -> tuple[Any, str]:
    """Orbit with given values, and its epoch, UTC."""
    texts = {
        text.path.removeprefix("orbit."): text.text
        for text in scenario.texts
        if text.path.startswith("orbit.")
    }
    orbit = KINDS["orbit"][scenario.orbit].of(options_of(values, "orbit")).elements(texts)
    return orbit, texts.get("epoch") or orbit.epoch
