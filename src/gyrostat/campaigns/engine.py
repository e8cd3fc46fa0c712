"""Simulation of the runs of a scenario by one compiled program.

The results of a run depend only on scenario, seed, run number n and engine, to the last bit. XLA's
vectorised code does not treat all lanes alike: the last lanes may use other instructions and differ
in the last bit. Therefore run n is always initialised in lane n mod 64 together with the same 63
other runs, even if only run n is requested. With the engine "jax" it is also simulated there, by
the same machine code whether its history is kept or not. In compiled C all SIMD lanes give the same
bits: with the engine "native" runs are simulated in any combination.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.build import Plans, build, plan
from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.metrics import Observer, concluded, ended
from gyrostat.campaigns.percentiles import collector
from gyrostat.campaigns.scenario import Scenario
from gyrostat.codegen.simd.compiler import required
from gyrostat.core.jax64 import jax
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.validation import check_seed
from gyrostat.simulation import Loop, Runner, Status, control_loop, labelled

if TYPE_CHECKING:
    import xarray as xr

LANES = 64
"""Number of runs that are simulated together; more are not faster."""
LONGEST = 500
"""Largest number of control periods whose samples are in memory at a time."""


class Flown(NamedTuple):
    """Results of simulated runs.

    Attributes:
        columns: Columns of the table, name -> (runs,): "run", the drawn values, "status", "ended"
            and the metrics.
        histories: Histories of the requested runs over `run` and `time`; None if none were
            requested.
    """

    columns: dict[str, Vector]
    histories: "xr.Dataset | None"


@dataclass(frozen=True)
class _Program:
    """Compiled scenario.

    Attributes:
        scenario: Scenario.
        nominal: Values of the keys that are not dispersed.
        plans: Controller designs.
        begin: Initialisation of 64 runs: (nominal, drawn values, plans, random keys) -> carry.
        runner: Runner with the same arguments.
    """

    scenario: Scenario
    nominal: Vector
    plans: Plans
    begin: Callable[..., Any]
    runner: Runner


@lru_cache(maxsize=8)
def _program(scenario: Scenario, engine: str) -> _Program:
    dispersed = scenario.dispersed
    fixed = [key for key in scenario.values if key not in dispersed]

    def make(nominal, drawn, plans, key) -> Loop:
        values = dict(zip((*fixed, *dispersed), (*nominal, *drawn), strict=True))
        setup = build(scenario, values, plans)
        observer = Observer.of(scenario, setup, values)
        loop = control_loop(
            *(setup.plant, setup.controller, setup.sensor, setup.start, key),
            values["run.control_period"],
            substeps=scenario.substeps,
            command_delay=scenario.command_delay,
        )

        def observed(seen, row, k):
            seen, pointing = observer(seen, row, k)
            return seen, (pointing.counted, (row, pointing.error))

        return loop.folded(observed, observer.start())

    runner = Runner(
        make,
        (False, True, False, True),
        scenario.count,
        engine=engine,
        longest=LONGEST,
        on_demand=(False, True),
    )
    begin = jax.jit(jax.vmap(lambda *given: make(*given).begin(), (None, 0, None, 0)))
    nominal = np.array([scenario.values[key] for key in fixed])
    return _Program(scenario, nominal, plan(scenario), begin, runner)


def prepare(scenario: Scenario) -> None:
    """Compile a scenario for the native engine; workers then use the library from the cache.

    Raises:
        InputError: There is no compiler, or the engine does not support the scenario.
    """
    required()
    program = _program(scenario, "native")
    values, noise = draw(scenario, 0, np.zeros(1))
    arguments = program.nominal, values, program.plans, noise
    program.runner.compiled(*arguments, carry=jax.eval_shape(program.begin, *arguments))


def fly(
    scenario: Scenario,
    seed: int,
    runs: Sequence[int] | None,
    *,
    keep: Sequence[int] = (),
    engine: str = "jax",
) -> Flown:
    """Simulate runs of a scenario.

    Args:
        scenario: Scenario.
        seed: Seed of the campaign.
        runs: Indices of the runs, increasing; None for one run with the nominal values.
        keep: Indices of the runs whose histories are requested.
        engine: "jax" or "native".

    Raises:
        InputError: The seed is out of range.
    """
    check_seed(seed)
    program = _program(scenario, engine)
    native = engine == "native"
    if runs is None:
        values, noise = draw(scenario, seed, np.zeros(LANES))
        nominal = [scenario.values[key] for key in scenario.dispersed]
        one = np.zeros(1, np.int64)
        return _group(program, one, values * 0.0 + nominal, noise, keep, native=native)
    wanted, flown = np.asarray(runs, dtype=np.int64), []
    for group in np.unique(wanted // LANES):
        whole = group * LANES + np.arange(LANES)
        own = wanted[wanted // LANES == group]
        drawn = draw(scenario, seed, whole)
        flown.append(_group(program, own, *drawn, keep, native=native))
    histories = [block.histories for block in flown if block.histories is not None]
    return Flown(
        {name: np.concatenate([b.columns[name] for b in flown]) for name in flown[0].columns},
        _joined(histories) if histories else None,
    )


def _group(
    program: _Program,
    runs: NDArray[np.int64],
    values: Matrix,
    noise: Any,
    keep: Sequence[int],
    *,
    native: bool,
) -> Flown:
    """Simulate the requested runs of a group of 64, from values and noise of the whole group."""
    scenario, plans, nominal = program.scenario, program.plans, program.nominal
    runner = program.runner
    picked = runs % LANES
    carry = program.begin(nominal, values, plans, noise)
    drawn = values[picked]
    if native:  # simulate the requested runs only
        carry = jax.tree.map(lambda leaf: np.asarray(leaf)[picked], carry)
        values, noise, picked = drawn, noise[picked], np.arange(len(runs))
    is_kept = np.isin(runs, keep)
    asked = picked[is_kept].tolist()
    errors = collector(len(values), len(runner.starts) * runner.length, LANES)
    kept = []
    for chunk in runner.chunks(nominal, values, plans, noise, carry=carry, asked=asked):
        carry, (counted, rows) = chunk
        errors.add(counted)
        if asked:
            kept.append(rows)
    _, seen = carry
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
