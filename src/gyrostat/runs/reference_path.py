"""Reference attitude over a run, as if it were followed exactly: no plant, no controller."""

from collections.abc import Mapping
from functools import lru_cache, partial
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float, Int

from gyrostat.control.guidance import Mode, Pointing, Reference, Scanned, SecondAxis
from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Vector
from gyrostat.runs.build import Setup
from gyrostat.runs.followed import follow, without_constants
from gyrostat.runs.metrics.windows import WindowObserver
from gyrostat.runs.plans import plans_of, setup_of
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.structure import structure_of
from gyrostat.telemetry.signals import runs

ROWS = 100_000
"""Largest number of rows of a path; longer runs have a row for several control periods."""
SCREENED = 200
"""Times at which every mode is evaluated before a path is."""


class ReferencePath(NamedTuple):
    """Reference attitude at equidistant times, NumPy arrays.

    Attributes:
        step: Time between rows, s; the first row is at time 0.
        time: Times, (rows,), s.
        attitude: Attitude, (rows, 4), scalar first.
        rate: Body rate, body axes, (rows, 3), rad/s.
        windows: Name of a window -> whether each row is in it, (rows,).
    """

    step: float
    time: Vector
    attitude: Float[np.ndarray, "rows 4"]
    rate: Float[np.ndarray, "rows 3"]
    windows: dict[str, Bool[np.ndarray, " rows"]]


class _Row(NamedTuple):
    attitude: Quaternion
    rate: Vector3
    windows: dict[str, Any]


@lru_cache(maxsize=4)
def nominal_setup(scenario: Scenario) -> Setup:
    """Parts of the nominal run."""
    return setup_of(scenario, plans_of(scenario))


def _observers(
    scenario: Scenario, drawn: Mapping[str, float] | None = None
) -> tuple[WindowObserver, ...]:
    structure, values = structure_of(scenario), {**scenario.values, **(drawn or {})}
    return tuple(WindowObserver.of(each, structure, values) for each in scenario.windows)


def waits_for_measurement(setup: Setup) -> bool:
    """Whether a mode of the reference ends by a condition on measured quantities.

    Args:
        setup: Parts of the nominal run.
    """
    if setup.reference is None or len(setup.reference.modes) < 2:
        return False
    return bool(np.any(setup.reference.changes.conditions.needs_measurement))


@lru_cache(maxsize=4)
def reference_path(scenario: Scenario, rows: int = ROWS) -> ReferencePath:
    """Reference attitude of the nominal run.

    Conditions for the end of a mode are tested with the attitude and the rate of the reference and
    with the wheel speeds of the start: a mode that waits for the body to slow down ends at once.

    Args:
        scenario: Scenario.
        rows: Largest number of rows.
    """
    setup, observers = nominal_setup(scenario), _observers(scenario)
    period = scenario.values["run.control_period"]
    stride = -(-scenario.count // rows)
    first: Any = np.arange(0, scenario.count + 1, stride)
    if setup.reference is None:
        found = _fixed(setup.starts, setup.targets, observers, period, first)
    else:
        speed = jnp.asarray(setup.start.wheel_speed)
        rows_at = first, np.asarray(stride)
        found = _moving(*without_constants((setup.reference, speed, observers, period, *rows_at)))
    attitude, rate, windows = jax.tree.map(np.asarray, found)
    return ReferencePath(stride * period, first * period, attitude, rate, windows)


def check_directions(scenario: Scenario) -> None:
    """Check that a reference with targets has an attitude at all times of the nominal run.

    Raises:
        InputError: It has none: a tangent point above the spacecraft, or two directions that are
            parallel.
    """
    setup = nominal_setup(scenario)
    if setup.reference is None or not any(_may_fail(m) for m in setup.reference.modes):
        return
    times: Any = np.linspace(0.0, scenario.duration, SCREENED)
    every = [jax.jit(jax.vmap(mode))(times) for mode in setup.reference.modes if _may_fail(mode)]
    if np.all(np.isfinite(every)):
        return
    # a mode may have no attitude while it is not active
    path = reference_path(scenario)
    without = np.flatnonzero(~np.all(np.isfinite(path.attitude), axis=1))
    if len(without):
        raise InputError(
            f"key reference: found no attitude along the reference at {path.time[without[0]]:g} s, "
            "expected a tangent point below the spacecraft, and a second direction that is not "
            "that of the target"
        )


def _may_fail(mode: Any) -> bool:
    return isinstance(mode, Pointing) and isinstance(mode.aim, SecondAxis | Scanned)


def _in_windows(observers: tuple[WindowObserver, ...], time: Scalar, mode: Mode) -> dict[str, Any]:
    return {each.window.name: each.contains(time, mode)[1] for each in observers}


def flown_path(
    scenario: Scenario, history: Mapping[str, Any], drawn: Mapping[str, float] | None = None
) -> ReferencePath:
    """Path of a simulated run in place of the reference.

    Args:
        scenario: Scenario.
        history: Signals of the run by name, NumPy arrays: `attitude` (samples, 4), `rate`
            (samples, 3), and of a reference that moves `mode` and `mode_start`, (samples,).
        drawn: Values of the run that are not the nominal ones, SI, by key: windows follow from
            them. None: a nominal run.
    """
    attitude, rate = history["attitude"], history["rate"]
    period = scenario.values["run.control_period"]
    time: Any = period * np.arange(len(attitude))
    number, start = (history.get(name, np.zeros(len(time))) for name in ("mode", "mode_start"))
    rows = Mode(jnp.asarray(number, dtype=int), jnp.asarray(start))
    found = jax.vmap(partial(_in_windows, _observers(scenario, drawn)))(time, rows)
    windows = jax.tree.map(np.asarray, found)
    return ReferencePath(period, time, np.asarray(attitude), np.asarray(rate), windows)


@eqx.filter_jit
def _fixed(
    starts: Any,
    targets: Any,
    observers: tuple[WindowObserver, ...],
    period: Scalar,
    first: Int[np.ndarray, " rows"],
) -> _Row:
    """Rows of targets that change at the start of a phase."""

    def row(k: Any) -> _Row:
        time = k * period
        phase = jnp.sum(jnp.asarray(starts) <= time + 1e-9) - 1
        mode = Mode(jnp.zeros((), dtype=int), jnp.zeros(()))
        return _Row(jnp.asarray(targets)[phase], jnp.zeros(3), _in_windows(observers, time, mode))

    return jax.vmap(row)(first)


@eqx.filter_jit
def _moving(
    reference: Reference,
    speed: PerWheel,
    observers: tuple[WindowObserver, ...],
    period: Scalar,
    first: Int[np.ndarray, " rows"],
    stride: Int[np.ndarray, ""],
) -> _Row:
    """Rows of a reference that is followed, with a mode that is updated in each control period."""

    def entered(k: Any, mode: Mode) -> Mode:
        return follow(reference, mode, speed, k * period)[0]

    def row(mode: Mode, k: Any) -> tuple[Mode, _Row]:
        mode = jax.lax.fori_loop(jnp.maximum(k - stride + 1, 0), k + 1, entered, mode)
        at, time = reference.at(mode, k * period), k * period
        return mode, _Row(at.attitude, at.rate, _in_windows(observers, time, mode))

    return jax.lax.scan(row, reference.start(), first)[1]


def longest_outage(sees: Bool[np.ndarray, " rows"], step: float) -> float:
    """Longest time without sight, s.

    Args:
        sees: Whether there is sight at each of some equidistant times.
        step: Time between them, s.
    """
    return step * max((end - begin for begin, end in runs(~sees)), default=0)
