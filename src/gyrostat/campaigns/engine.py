"""Simulate runs of a scenario by one compiled program.

XLA's vectorised code does not treat every lane alike: the last ones may pass through other
instructions and end with another last bit. So run n always begins, and with the engine "jax"
continues, in lane n mod 64 beside the same 63 others, also where it alone is wanted, and through
the same machine code whether its history is kept or not. SIMD lanes of compiled C do not differ:
with the engine "native" a run may continue beside any others. The numbers of a run depend on
nothing but scenario, seed, n and engine.
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
"""Runs that are carried together: more do not run faster."""
LONGEST = 500
"""Most control periods whose samples are in memory at a time."""


class Flown(NamedTuple):
    """Some runs.

    Attributes:
        columns: name -> (runs,): "run", the drawn values, "status", "ended" and the metrics.
        histories: of the runs asked for, over `run` and `time`; None where none was.
    """

    columns: dict[str, Vector]
    histories: "xr.Dataset | None"


@dataclass(frozen=True)
class _Program:
    """A scenario, compiled.

    Attributes:
        scenario: That is simulated.
        nominal: Values of the keys that are not dispersed.
        plans: Of its controller.
        begin: (nominal, drawn values, plans, keys of the noise) -> carry, of 64 runs.
        runner: Of the same arguments.
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
    """Compile a scenario for the native engine; workers will find the library in the cache.

    Raises:
        InputError: there is no compiler, or the scenario has something that the engine does not
            know.
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
        scenario: That is simulated.
        seed: Of the campaign.
        runs: Their numbers, rising; None for one run with the nominal values.
        keep: Numbers, among them, of those whose histories are wanted.
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
    """Some of the runs of one group of 64, from values and noise of all of them."""
    scenario, plans, nominal = program.scenario, program.plans, program.nominal
    runner = program.runner
    picked = runs % LANES
    carry = program.begin(nominal, values, plans, noise)
    drawn = values[picked]
    if native:  # only what is wanted goes on
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
