"""Simulate runs of a scenario in blocks of 64 by one compiled program.

XLA's vectorised code does not treat every lane alike: the last ones may pass through other
instructions and end with another last bit. So run n always begins, and with the engine "jax"
flies, in lane n mod 64 beside the same 63 others, also where it alone is wanted, and through the
same machine code whether its history is kept or not. Lanes of compiled C do not differ: with the
engine "lanes" a run flies beside any others. Its numbers depend on nothing but scenario, seed, n
and engine.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.build import Plans, Setup, build, plan
from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.metrics import concluded, ended, observer
from gyrostat.campaigns.percentiles import collector
from gyrostat.campaigns.scenario import Scenario
from gyrostat.codegen.simd.batch import lanes
from gyrostat.codegen.simd.compiler import required
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.validation import check_seed
from gyrostat.simulation import Status, labelled, loop_parts, stretch

if TYPE_CHECKING:
    import xarray as xr

LANES = 64
"""Runs that are carried together: more do not run faster."""
LONGEST_SEGMENT = 500
"""Control periods whose samples are in memory at a time."""


class Flown(NamedTuple):
    """Some runs.

    Attributes:
        columns: name -> (runs,): "run", the drawn values, "status", "ended" and the metrics.
        histories: of the runs asked for, over `run` and `time`; None where none was.
    """

    columns: dict[str, Vector]
    histories: "xr.Dataset | None"


@dataclass(frozen=True)
class _Programs:
    """A scenario, compiled.

    Attributes:
        begin: (nominal, values, plans, noise) -> carry, of 64 runs.
        segment: (carry, first, nominal, values, plans, noise, asked) -> carry, the errors that
            count, and for the runs that are asked for the samples and all errors.
        length: control periods of a segment.
    """

    scenario: Scenario
    engine: str
    plans: Plans
    nominal: Vector
    begin: Callable[..., Any]
    segment: Callable[..., Any]
    length: int


@lru_cache(maxsize=8)
def _programs(text: str, engine: str) -> _Programs:
    scenario = Scenario.from_text(text)
    dispersed = scenario.dispersed
    fixed = [key for key in scenario.values if key not in dispersed]
    length = stretch(scenario.count, LONGEST_SEGMENT)

    def parts(nominal, drawn, plans, key) -> tuple[Any, ...]:
        values = dict(zip((*fixed, *dispersed), (*nominal, *drawn), strict=True))
        setup: Setup = build(scenario, values, plans)
        begin, tick = loop_parts(
            setup.plant,
            setup.controller,
            setup.sensor,
            key,
            values["run.control_period"],
            substeps=scenario.substeps,
            command_delay=scenario.command_delay,
        )
        return setup.start, begin, tick, observer(scenario, setup, values)

    def begin(nominal, drawn, plans, key):
        start, first, _, seeing = parts(nominal, drawn, plans, key)
        return first(start), seeing.start()

    def segment(carry, first, nominal, drawn, plans, key):
        _, _, tick, seeing = parts(nominal, drawn, plans, key)

        def step(carry, k):
            inner, seen = carry
            inner, row = tick(inner, k)
            seen, pointing = seeing(seen, row, k)
            return (inner, seen), (pointing.counted, (row, pointing.error))

        carry, (counted, rows) = jax.lax.scan(step, carry, first + jnp.arange(length))
        return carry, counted, rows

    nominal = np.array([scenario.values[key] for key in fixed])
    starting = jax.jit(jax.vmap(begin, in_axes=(None, 0, None, 0)))
    plans = plan(scenario)
    if engine == "lanes":
        values, noise = draw(scenario, 0, np.zeros(1))
        carry = jax.eval_shape(starting, nominal, values, plans, noise)
        example = (carry, 0, nominal, values, plans, noise)
        own = (True, False, False, True, False, True)
        carried = lanes(segment, own, example, on_demand=(False, False, True))
    else:
        batch = jax.jit(jax.vmap(segment, in_axes=(0, None, None, 0, None, 0)))

        def carried(*arguments, asked):
            carry, counted, rows = batch(*arguments)
            picked = np.asarray(asked, np.int64)
            kept = jax.tree.map(lambda leaf: np.asarray(leaf)[picked], rows) if asked else None
            return carry, np.asarray(counted), kept

    return _Programs(scenario, engine, plans, nominal, starting, carried, length)


def prepare(text: str) -> None:
    """Compile the lanes of a scenario; workers will find them in the cache.

    Raises:
        InputError: there is no compiler, or the scenario has something that lanes do not know.
    """
    required()
    _programs(text, "lanes")


def fly(
    text: str,
    seed: int,
    runs: Sequence[int] | None,
    *,
    keep: Sequence[int] = (),
    engine: str = "jax",
) -> Flown:
    """Fly runs of a scenario.

    Args:
        text: of the scenario.
        seed: of the campaign.
        runs: their numbers, rising; None for one run with the nominal values.
        keep: numbers, among them, of those whose histories are wanted.
        engine: "jax" or "lanes".

    Raises:
        InputError: The seed is out of range.
    """
    check_seed(seed)
    programs = _programs(text, engine)
    if runs is None:
        values, noise = draw(programs.scenario, seed, np.zeros(LANES))
        nominal = [programs.scenario.values[key] for key in programs.scenario.dispersed]
        drawn = (values * 0.0 + nominal, noise)
        return _block(programs, np.zeros(1, np.int64), *drawn, keep)
    wanted, flown = np.asarray(runs, dtype=np.int64), []
    for group in np.unique(wanted // LANES):
        whole = group * LANES + np.arange(LANES)
        own = wanted[wanted // LANES == group]
        flown.append(_block(programs, own, *draw(programs.scenario, seed, whole), keep))
    histories = [block.histories for block in flown if block.histories is not None]
    return Flown(
        {name: np.concatenate([b.columns[name] for b in flown]) for name in flown[0].columns},
        _joined(histories) if histories else None,
    )


def _block(
    programs: _Programs, runs: NDArray[np.int64], values: Matrix, noise: Any, keep: Sequence[int]
) -> Flown:
    """Some of the runs of one group of 64, from values and noise of all of them."""
    scenario, plans, nominal = programs.scenario, programs.plans, programs.nominal
    picked = runs % LANES
    carry = programs.begin(nominal, values, plans, noise)
    drawn = values[picked]
    if programs.engine == "lanes":  # only what is wanted flies
        carry = jax.tree.map(lambda leaf: np.asarray(leaf)[picked], carry)
        values, noise, picked = drawn, noise[picked], np.arange(len(runs))
    is_kept = np.isin(runs, keep)
    lanes_kept = picked[is_kept].tolist()
    segments = range(0, scenario.count + 1, programs.length)
    errors = collector(len(values), len(segments) * programs.length, LANES)
    kept = []
    for first in segments:
        carry, counted, rows = programs.segment(
            carry, first, nominal, values, plans, noise, asked=lanes_kept
        )
        errors.add(counted)
        if lanes_kept:
            kept.append(rows)
    seen = carry[1]
    period = scenario.values["run.control_period"]
    columns = {
        "run": runs,
        **{key: drawn[:, k] for k, key in enumerate(scenario.dispersed)},
        "status": np.asarray(seen.status)[picked].astype(np.int8),
        "ended": ended(seen, period)[picked],
    }
    columns |= {name: entry[picked] for name, entry in concluded(scenario, seen, errors).items()}
    if not kept:
        return Flown(columns, None)
    rows, error = jax.tree.map(
        lambda *leaves: np.concatenate(leaves, axis=1)[:, : scenario.count + 1], *kept
    )
    names = [*scenario.wheels]
    histories = labelled(rows, period).assign_coords(run=runs[is_kept], wheel=names)
    fine = rows.status == Status.COMPLETE
    about = {"units": "rad", "long_name": "pointing error"}
    histories["error"] = (("run", "time"), np.where(fine, error, np.nan), about)
    return Flown(columns, histories)


def _joined(histories: "list[xr.Dataset]") -> "xr.Dataset":
    import xarray as xr

    return xr.concat(histories, dim="run")
