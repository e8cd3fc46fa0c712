"""Simulate one run or a batch; labelled histories."""

import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import equinox as eqx
import numpy as np

from gyrostat.core.checked import declared_units
from gyrostat.core.engines import engine_named
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.validation import MOST_PERIODS, check_parts, check_period, require_period
from gyrostat.simulation.labels import (
    attributes,
    dimensions,
    status_attributes,
    with_coordinates,
)
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
    """Plants, controllers, sensors or states of several runs as one.

    Attributes:
        items: of one kind, each of its arrays with a leading axis of runs.
    """

    items: Any

    def check(self) -> None:
        """Refuse what any of them refuses, by `InputError`."""
        check_parts(self.items)

    def check_period(self, period: float) -> None:
        """Refuse what any of them refuses at a control period, s, by `InputError`."""
        check_period(period, self.items)


def stack(items: Sequence[Any]) -> Batch:
    """Join plants, controllers, sensors or states of several runs into one.

    Args:
        items: of one kind; one for each run.
    """
    return Batch(jax.tree.map(lambda *leaves: jnp.stack([_as_array(x) for x in leaves]), *items))


def _as_array(leaf: Any) -> Any:
    # an array made of a plain number has a weak type, and would be compiled for anew
    array = jnp.asarray(leaf)
    return jax.lax.convert_element_type(array, array.dtype) if array.weak_type else array


class _TracedAnew:
    """A user's own object, which JAX cannot look into.

    Compiled code is kept for objects that compare equal. A plain object may have changed its
    attributes since, or not be hashable; this stands for it in one call of `simulate`.
    """

    def __init__(self, own: Any):
        self._own = own

    def __getattr__(self, name: str) -> Any:
        return getattr(self._own, name)

    def __call__(self, *arguments: Any) -> Any:
        return self._own(*arguments)


def _as_leaf(leaf: Any) -> Any:
    # numbers left as they are would be compiled in, and every new value compiled again
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


def _whole(value: float, part: float, names: tuple[str, str]) -> int:
    """How often a part goes into a value, which must be a whole number of times."""
    for name, number in zip(names, (value, part), strict=True):
        if not (np.isfinite(number) and number > 0.0):
            raise InputError(f"{name}: found {number:g} s, expected more than 0 s")
    require_period(names[1], part)
    ratio = value / part
    if ratio > MOST_PERIODS or round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-6 * ratio:
        raise InputError(
            f"{names[0]}: found {value:g} s, expected a whole multiple of the {names[1]} "
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
    on_progress: Callable[[int, int], None] | None = None,
) -> "xr.Dataset":
    """Run a plant in closed loop.

    The sensor measures and the controller commands once in each control period; the command is held
    through it. Every run draws its own noise.

    Args:
        plant: what is controlled.
        controller: gives the commands.
        sensor: gives the measurements.
        start: state of the plant at time 0.
        duration: s, a whole number of control periods.
        control_period: s.
        step: longest integration step, s, of which the control period is a multiple; by default the
            control period itself.
        command_delay: Control periods from a sample to the start of the command made from it. It
            delays the fields of the command that the plant's motion depends on; the others, as a
            target or an estimate, stand at the sample that they were made at.
        seed: of the noise.
        runs: number of runs; None for a single one. Of plant, controller, sensor and start each may
            be one for all, or one for each as `stack` joins them.
        engine: "jax"; "native", compiled C with one run in each SIMD lane, which is faster for long
            runs and for many and agrees with JAX's to rounding; or "auto", native where it can run.
        on_progress: called with the runs done and the runs in all.

    Returns:
        Histories over `time` (and `run`): every field of state, record, measurement and command
        under its own name, with unit and long name; a measurement or command whose name the plant
        has taken has `measured_` or `commanded_` before it. Vectors are over `axis` ("x", "y",
        "z"), quaternions over `quaternion` ("w", "x", "y", "z"), numbers of wheels over `wheel`.
        `error` is the angle between `attitude` and `target`, rad, where the command has a target.
        `status` says how a run ended, `valid_until` when; later values are NaN, never numbers.

    Raises:
        InputError: a duration or step that does not fit, a batch of another number of runs,
            parameters that no plant has, or a command that is not finite: the message names the
            controller and the time.
    """
    count = _whole(duration, control_period, ("duration", "control period"))
    substeps = 1 if step is None else _whole(control_period, step, ("control period", "step"))
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
        engine, lambda text: warnings.warn(text, DeprecationWarning, stacklevel=4)
    )
    key = jax.random.key(seed)

    def flown(engine: str) -> Histories:
        native = engine == "native"
        keys = key if runs is None else jax.random.split(key, runs)
        keys = keys[None] if native and runs is None else keys
        own = (*(isinstance(item, Batch) for item in items), False, False, keys.ndim > 0)
        plain = (item.items if isinstance(item, Batch) else item for item in items)
        runner = Runner(_loop, own, count, engine=engine, longest=LONGEST if native else None)
        number = 1 if native and runs is None else runs
        found = runner.records(
            *plain,
            *(control_period, counts, keys),
            runs=number,
            on_progress=None if runs is None else on_progress,
        )
        return found if keys.ndim else jax.tree.map(lambda leaf: leaf[None], found)

    histories = by_engine(engine, flown)
    _refuse_bad_commands(histories, controller, control_period, runs)
    dataset = labelled(histories, control_period)
    return dataset if runs is not None else dataset.isel(run=0)


def _refuse_bad_commands(histories: Histories, controller: Any, period: float, runs: int | None):
    bad = histories.status == Status.BAD_COMMAND
    if not np.any(bad):
        return
    number = int(np.argmax(np.any(bad, axis=1)))
    where = int(np.argmax(bad[number]))
    which = "" if runs is None else f" of run {number}"
    raise InputError(
        f"{type(controller).__name__}: found a command that is not finite at {where * period:g} s"
        f"{which}, expected finite numbers"
    )


def labelled(histories: Histories, period: float) -> "xr.Dataset":
    """Histories as `simulate` returns them.

    Args:
        histories: each with axes (run, time).
        period: control period, s.
    """
    import xarray as xr

    count = histories.status.shape[1]
    fine = histories.status == Status.COMPLETE
    variables: dict[str, Any] = {}
    every = (histories.state, histories.measurement)
    speeds = [signals.wheel_speed for signals in every if hasattr(signals, "wheel_speed")]
    wheels = speeds[0].shape[-1] if speeds else None
    for prefix, signals in (
        ("", histories.state),
        ("recorded_", histories.record),
        ("measured_", histories.measurement),
        ("commanded_", histories.command),
    ):
        units = declared_units(type(signals))
        for name, values in signals._asdict().items():
            if values is None:
                continue
            before = prefix if name in variables else ""
            label = before + name
            extra = dimensions(name, label, values.shape[2:], wheels)
            mask = fine.reshape(*fine.shape, *(1,) * len(extra))
            values = values & mask if values.dtype == bool else np.where(mask, values, np.nan)
            variables[label] = (("run", "time", *extra), values, attributes(name, before, units))
    last = np.where(fine.all(axis=1), count, np.argmin(fine, axis=1)) - 1
    ended = histories.status.max(axis=1).astype(np.int8)
    variables["status"] = ("run", ended, status_attributes())
    # a run that is beyond all bounds from the start was never valid
    until = np.where(last >= 0, last * period, np.nan)
    lasts = {"units": "s", "long_name": "time of the last valid sample"}
    variables["valid_until"] = ("run", until, lasts)
    time = ("time", np.arange(count) * period, {"units": "s", "long_name": "time"})
    coordinates = {"time": time, "run": np.arange(len(fine))}
    return with_coordinates(xr.Dataset(variables, coords=coordinates))
