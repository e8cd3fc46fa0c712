"""Simulation of one run or a batch, with labelled histories."""

import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import equinox as eqx
import numpy as np

from gyrostat.core.engines import engine_named
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.validation import MOST_PERIODS, check_parts, check_period, require_period
from gyrostat.simulation.labelled import Labelled
from gyrostat.simulation.labels import labelled
from gyrostat.simulation.loop import (
    Controller,
    Histories,
    Loop,
    Plant,
    Sensor,
    Status,
    control_loop,
)
from gyrostat.simulation.runner import LONGEST, Runner, by_engine

if TYPE_CHECKING:
    import xarray as xr


class Batch(eqx.Module):
    """Plants, controllers, sensors or states of several runs, stacked.

    Attributes:
        items: Stacked object; each of its arrays has a leading axis of runs.
    """

    items: Any

    def check(self) -> None:
        """Validate parameters of all runs; raises `InputError`."""
        check_parts(self.items)

    def check_period(self, period: float) -> None:
        """Validate the control period, s, for all runs; raises `InputError`."""
        check_period(period, self.items)


def stack(items: Sequence[Any]) -> Batch:
    """Stack plants, controllers, sensors or states of several runs into a batch.

    Args:
        items: Objects of one type, one for each run.
    """
    return Batch(jax.tree.map(lambda *leaves: jnp.stack([_as_array(x) for x in leaves]), *items))


def _as_array(leaf: Any) -> Any:
    # an array from a Python number has a weak type, which would cause another compilation
    array = jnp.asarray(np.asarray(leaf) if isinstance(leaf, float) else leaf)
    return jax.lax.convert_element_type(array, array.dtype) if array.weak_type else array


class _TracedAnew:
    """Wrapper of a user's object that JAX cannot inspect; it forces tracing in each call.

    JAX reuses compiled code for objects that compare equal. A plain object may have changed its
    attributes since, or may not be hashable; a new wrapper replaces it in each call of `simulate`.
    """

    def __init__(self, item: Any):
        self._item = item

    def __getattr__(self, name: str) -> Any:
        return getattr(self._item, name)

    def __call__(self, *arguments: Any) -> Any:
        return self._item(*arguments)


def _as_leaf(leaf: Any) -> Any:
    # Python numbers would be compile-time constants, and each new value would be compiled again
    if isinstance(leaf, float | np.ndarray | np.generic | jax.Array):
        return _as_array(leaf)
    return _TracedAnew(leaf) if callable(leaf) else leaf


def _refuse_other_counts(name: str, item: Any, runs: int | None) -> None:
    if not isinstance(item, Batch):
        return
    if runs is None:
        raise InputError(f"{name}: found a batch, expected one item for a single run")
    for leaf in jax.tree.leaves(item):
        if eqx.is_array(leaf) and leaf.shape[:1] != (runs,):
            raise InputError(
                f"{name}: found a batch of {leaf.shape[0] if leaf.ndim else 'one'}, "
                f"expected {runs}, one for each run"
            )


def _loop(plant, controller, sensor, start, period, counts, key) -> Loop:
    return control_loop(plant, controller, sensor, start, key, period, **counts)


def _count(duration: float, part: float, names: tuple[str, str]) -> int:
    """Ratio of two durations, s, which must be a whole number."""
    for name, number in zip(names, (duration, part), strict=True):
        if not (np.isfinite(number) and number > 0.0):
            raise InputError(f"{name}: found {number:g} s, expected more than 0 s")
    require_period(names[1], part)
    ratio = duration / part
    if ratio > MOST_PERIODS or round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-6 * ratio:
        raise InputError(
            f"{names[0]}: found {duration:g} s, expected a whole multiple of the {names[1]} "
            f"{part:g} s, at most {MOST_PERIODS} of them"
        )
    return round(ratio)


def simulate(
    plant: Plant | Batch,
    controller: Controller | Batch,
    sensor: Sensor | Batch,
    *,
    start: Any,
    duration: float,
    control_period: float,
    step: float | None = None,
    command_delay: int = 0,
    seed: int = 0,
    runs: int | None = None,
    engine: str = "jax",
    stored: bool = False,
    on_progress: Callable[[int, int], None] | None = None,
) -> "xr.Dataset":
    """Simulate a plant in closed loop.

    The sensor measures and the controller commands once in each control period; the command is
    constant during the period. Each run has its own noise.

    Args:
        plant: Controlled system.
        controller: Controller.
        sensor: Sensor.
        start: State of the plant at time 0.
        duration: Duration, s, a whole number of control periods.
        control_period: Control period, s.
        step: Longest integration step, s; the control period must be a multiple of it. By default
            the control period.
        command_delay: Control periods from a sample to the start of the command computed from it.
            It delays the fields of the command on which the plant's motion depends; the others,
            such as a target or an estimate, are recorded at their own sample.
        seed: Seed of the noise.
        runs: Number of runs; None for a single run. Plant, controller, sensor and start can each be
            common to all runs, or a `Batch` from `stack` with one for each run.
        engine: "jax"; "native", compiled C with one run in each SIMD lane, which is faster for long
            runs and for many runs and agrees with JAX to rounding; or "auto", native if possible.
        stored: Whether the program of JAX is kept in the private cache, so that another process
            neither traces nor compiles it. Programs with parts of your own are never kept.
        on_progress: Called with the number of completed runs and the total number of runs.

    Returns:
        Histories over `time` (and `run`): every field of state, record, measurement and command
        under its own name, with unit and long name. If the plant has a field of the same name, a
        measurement or command has the prefix `measured_` or `commanded_`. Vectors are over `axis`
        ("x", "y", "z"), quaternions over `quaternion` ("w", "x", "y", "z"), values of wheels over
        `wheel`. If the command has a target, `error` is the angle between `attitude` and `target`,
        rad. `status` and `valid_until` give how and when a run ended; later values are NaN.

    Raises:
        InputError: A duration or step that does not fit, a batch with another number of runs,
            impossible parameters, or a command that is not finite; the message names the
            controller and the time.
    """
    return simulated(
        plant,
        controller,
        sensor,
        start=start,
        duration=duration,
        control_period=control_period,
        step=step,
        command_delay=command_delay,
        seed=seed,
        runs=runs,
        engine=engine,
        stored=stored,
        on_progress=on_progress,
    ).dataset()


def simulated(
    plant: Plant | Batch,
    controller: Controller | Batch,
    sensor: Sensor | Batch,
    *,
    start: Any,
    duration: float,
    control_period: float,
    step: float | None = None,
    command_delay: int = 0,
    seed: int = 0,
    runs: int | None = None,
    engine: str = "jax",
    stored: bool = False,
    on_progress: Callable[[int, int], None] | None = None,
) -> Labelled:
    """Labelled histories of `simulate`, which has the same arguments, without xarray."""
    count = _count(duration, control_period, ("duration", "control period"))
    substeps = 1 if step is None else _count(control_period, step, ("control period", "step"))
    if runs is not None and runs < 1:
        raise InputError(f"runs: found {runs}, expected 1 or more")
    if command_delay < 0:
        raise InputError(f"command delay: found {command_delay} periods, expected 0 or more")
    counts = {"substeps": substeps, "command_delay": command_delay}
    check_parts(plant, controller, sensor)
    check_period(control_period, plant, controller, sensor)
    if not all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(start)):
        raise InputError(f"start: found {start}, expected finite numbers")
    check_state = getattr(plant.items if isinstance(plant, Batch) else plant, "check_state", None)
    if check_state is not None:
        check_state(start.items if isinstance(start, Batch) else start)
    items = jax.tree.map(_as_leaf, (plant, controller, sensor, start))
    for name, item in zip(("plant", "controller", "sensor", "start"), items, strict=True):
        _refuse_other_counts(name, item, runs)
    engine = engine_named(
        engine, lambda text: warnings.warn(text, DeprecationWarning, stacklevel=5)
    )
    key = jax.random.key(seed)

    def execute(engine: str) -> Histories:
        native = engine == "native"
        keys = key if runs is None else jax.random.split(key, runs)
        keys = keys[None] if native and runs is None else keys
        batched = (*(isinstance(item, Batch) for item in items), False, False, keys.ndim > 0)
        arguments = (item.items if isinstance(item, Batch) else item for item in items)
        longest = LONGEST if native else None
        runner = Runner(_loop, batched, count, engine=engine, longest=longest, stored=stored)
        number = 1 if native and runs is None else runs
        records = runner.records(
            *arguments,
            *(control_period, counts, keys),
            runs=number,
            on_progress=None if runs is None else on_progress,
        )
        return records if keys.ndim else jax.tree.map(lambda leaf: leaf[None], records)

    histories = by_engine(engine, execute)
    _refuse_bad_commands(histories, controller, control_period, runs)
    signals = labelled(histories, control_period)
    return signals if runs is not None else signals.of_run(0)


def _refuse_bad_commands(histories: Histories, controller: Any, period: float, runs: int | None):
    mask = histories.status == Status.BAD_COMMAND
    if not np.any(mask):
        return
    number = int(np.argmax(np.any(mask, axis=1)))
    index = int(np.argmax(mask[number]))
    suffix = "" if runs is None else f" of run {number}"
    raise InputError(
        f"{type(controller).__name__}: found a command that is not finite at {index * period:g} s"
        f"{suffix}, expected finite numbers"
    )
