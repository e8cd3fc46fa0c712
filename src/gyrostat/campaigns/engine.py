"""Simulation of the runs of a scenario by one compiled program.

The results of a run depend only on scenario, seed, run number n and engine, to the last bit. XLA's
vectorised code does not treat all lanes alike: the last lanes may use other instructions and differ
in the last bit. With the engine "jax", run n is therefore always simulated in lane n mod 64
together with the same 63 other runs, even if only run n is requested, and by the same machine code
whether its history is kept or not. In compiled C all SIMD lanes give the same bits: with the engine
"native" runs are simulated in any combination. So they are on an accelerator, where each work item
has its own run; another device may give other bits.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.accelerated import AcceleratedProgram
from gyrostat.campaigns.draws import draw, noise_keys
from gyrostat.campaigns.flown import Flown
from gyrostat.campaigns.pointing.campaign import PointingBudget
from gyrostat.campaigns.ready import Ready, make_ready
from gyrostat.core.engines import ACCELERATED
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.core.threefry import Words
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.validation import check_seed
from gyrostat.runs.designs import Plans
from gyrostat.runs.metrics.observer import concluded, ended
from gyrostat.runs.metrics.percentiles import Percentiles, are_sorted, collectors
from gyrostat.runs.run_loop import Drawn
from gyrostat.scenario.kinds.orbits import own_orbits
from gyrostat.scenario.scenario import Scenario
from gyrostat.simulation import Status, labelled
from gyrostat.simulation.labelled import Labelled, Signal, joined
from gyrostat.simulation.labels import ERROR

LANES = 64
"""Number of runs that JAX simulates together; 128 take 10 % less time for each run, but as long for
fewer runs."""
ERROR_MEMORY = 500e6
"""Memory for the pointing errors of the runs that an accelerator computes together, bytes."""


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
        engine: "jax", "native" or one that uses an accelerator.

    Raises:
        InputError: The seed is out of range.
    """
    check_seed(seed)
    ready = make_ready(scenario, engine, 0)
    if runs is None:
        return _group(ready, np.zeros(1, np.int64), seed, keep, nominal=True)
    numbers = np.asarray(runs, dtype=np.int64)
    size = LANES if engine not in ACCELERATED else _runs_at_a_time(ready)
    results = [
        _group(ready, numbers[numbers // size == group], seed, keep)
        for group in np.unique(numbers // size)
    ]
    histories = [part.histories for part in results if part.histories is not None]
    return Flown(
        {name: np.concatenate([b.columns[name] for b in results]) for name in results[0].columns},
        joined(histories) if histories else None,
    )


def fly_nominal(scenario: Scenario, seed: int, engine: str) -> dict[str, NDArray[Any]]:
    """Signals of the nominal run by name.

    Args:
        scenario: Scenario.
        seed: Seed of its noise.
        engine: See `fly`.

    Raises:
        InputError: The seed is out of range, or the run ends early.
    """
    flown = fly(scenario, seed, None, keep=[0], engine=engine)
    status = Status(int(flown.columns["status"][0]))
    if status != Status.COMPLETE:
        raise InputError(
            f"{scenario.name}: found a nominal run that ends after "
            f"{float(flown.columns['ended'][0]):g} s ({status.name.lower().replace('_', ' ')}), "
            "expected a complete one"
        )
    assert flown.histories is not None
    return flown.histories.of_run(0).arrays()


def fly_changed(
    scenario: Scenario, values: Mapping[str, float], seed: int, run: int, engine: str
) -> Flown:
    """Simulate one run with values of its own, and keep its history; its number becomes 0.

    The designs of the controller, with its model of the spacecraft, stay those of the scenario.

    Args:
        scenario: Scenario.
        values: Key -> value, SI, of any key; the others have their nominal values.
        seed: Seed of the noise.
        run: Number of the run whose noise it has.
        engine: "jax" or "native".
    """
    every = {**scenario.values, **values}
    ready = replace(make_ready(scenario, engine, 0), nominal=np.array([*every.values()]))
    count = LANES if ready.program is None else 1
    drawn = np.tile([every[key] for key in scenario.dispersed], (count, 1))
    keys = noise_keys(seed, np.full(count, run))
    first = np.zeros(1, np.int64)
    flown = _simulate(ready, first, first, drawn, keys, [0])
    changed = {key: np.array([value]) for key, value in values.items()}
    return flown._replace(columns={**flown.columns, **changed})


def fly_given(
    scenario: Scenario,
    runs: Sequence[int] | NDArray[np.int64],
    values: Matrix,
    keys: Words,
    *,
    keep: Sequence[int] = (),
) -> Flown:
    """Simulate runs with given values and noise, by the native engine.

    The columns have the moments of the pointing indices too.

    Args:
        scenario: Scenario; its dispersed values are replaced.
        runs: Numbers of the runs, (n,), increasing; they only name the runs.
        values: Dispersed values, (n, keys), in the order of `scenario.dispersed`.
        keys: Random keys of the noise, (n,), or of each part of a run, (n, parts).
        keep: Numbers of the runs whose histories are requested.
    """
    parts = keys.shape[1] if keys.ndim == 2 else 0
    ready = make_ready(scenario, "native", parts)
    numbers = np.asarray(runs, dtype=np.int64)
    return _simulate(ready, numbers, np.arange(len(runs)), values, keys, keep, moments=True)


def _runs_at_a_time(ready: Ready) -> int:
    """Number of runs that an accelerator computes together, by the memory of their errors."""
    samples = len(ready.runner.starts) * ready.runner.length
    of_run = 8 * samples * (1 + len(ready.scenario.windows))
    return max(LANES, int(ERROR_MEMORY / of_run) // LANES * LANES)


def _group(
    ready: Ready, runs: NDArray[np.int64], seed: int, keep: Sequence[int], *, nominal: bool = False
) -> Flown:
    """Simulate the requested runs of a group of 64; `nominal`: run 0 with the nominal values."""
    scenario, is_exact = ready.scenario, ready.program is not None
    batch = runs if is_exact else runs[0] // LANES * LANES + np.arange(LANES)
    picked = np.arange(len(runs)) if is_exact else runs % LANES
    if nominal:
        means = [scenario.values[key] for key in scenario.dispersed]
        values, keys = np.tile(means, (len(batch), 1)), noise_keys(seed, 0 * batch)
    else:
        values, keys = draw(scenario, seed, batch)
    return _simulate(ready, runs, picked, values, keys, keep, lists=not nominal)


def _observe(
    ready: Ready,
    runs: NDArray[np.int64],
    arguments: tuple[Vector, Drawn, Plans, Words],
    record_indices: Sequence[int],
    budget: PointingBudget,
) -> tuple[Any, Sequence[Percentiles], list[Any]]:
    """Simulate runs; returns `Seen`, percentiles of the errors, and records chunk by chunk.

    Args:
        ready: Scenario.
        runs: Numbers of the runs.
        arguments: Nominal values, drawn ones, designs and random keys.
        record_indices: Indices of the runs whose records are requested.
        budget: Pointing budget, to which the errors are added.
    """
    scenario, program, count = ready.scenario, ready.program, len(arguments[-1])
    samples, signals = len(ready.runner.starts) * ready.runner.length, 1 + len(scenario.windows)
    stay = are_sorted(LANES, samples, signals) and not budget.needs_errors(runs)
    if isinstance(program, AcceleratedProgram) and not record_indices and stay:
        return *program.concluded(*arguments, scenario.percentiles), []
    errors, records, last = collectors(count, samples, LANES, signals), [], None
    fly_chunks = ready.fly_with_jax if program is None else program.chunks
    for observations, (counted, vectors), rows in fly_chunks(*arguments, record_indices):
        budget.add(counted, vectors)
        for collected, vectors_of_run in zip(errors, counted, strict=True):
            collected.add(vectors_of_run)
        if record_indices:
            records.append(rows)
        last = observations
    budget.finish()
    return last, errors, records


def _simulate(
    ready: Ready,
    runs: NDArray[np.int64],
    picked: NDArray[np.int64],
    values: Matrix,
    keys: Words,
    keep: Sequence[int],
    *,
    lists: bool = False,
    moments: bool = False,
) -> Flown:
    """Simulate runs with given values and noise.

    Args:
        ready: Scenario.
        runs: Numbers of the runs that are returned.
        picked: Their places among the simulated ones.
        values: Dispersed values of the simulated runs.
        keys: Random keys of their noise.
        keep: Numbers of the runs whose histories are requested.
        lists: Whether to return columns with several numbers for each run.
        moments: Whether to return mean square, mean and size of each pointing index.
    """
    scenario = ready.scenario
    is_kept = np.isin(runs, keep)
    record_indices = picked[is_kept].tolist()
    drawn = Drawn(values, own_orbits(scenario, values))
    arguments = (ready.nominal, drawn, ready.plans, keys)
    samples = len(ready.runner.starts) * ready.runner.length
    budget = PointingBudget(scenario, len(values), samples, LANES, moments=moments)
    last, errors, records = _observe(ready, runs, arguments, record_indices, budget)
    observations: Any = jax.tree.map(np.asarray, last)
    period = scenario.values["run.control_period"]
    values = values[picked]
    columns = {
        "run": runs,
        **{key: values[:, k] for k, key in enumerate(scenario.dispersed)},
        "status": observations.status[picked].astype(np.int8),
        "ended": ended(observations, period)[picked],
    }
    metrics = concluded(scenario, observations, errors, budget.metrics())
    columns |= {name: entry[picked] for name, entry in metrics.items()}
    if moments:
        columns |= {name: entry[picked] for name, entry in budget.moments().items()}
    if lists:
        columns |= budget.lists(runs, observations.status[picked], picked)
    if not records:
        return Flown(columns, None)
    rows, error = jax.tree.map(
        lambda *leaves: np.concatenate(leaves, axis=1)[:, : scenario.count + 1], *records
    )
    histories = labelled(rows, period)
    coordinates = {"run": runs[is_kept], "wheel": np.array(scenario.wheels)}
    axes = {name: Signal((name,), values) for name, values in coordinates.items()}
    fine = rows.status == Status.COMPLETE
    error_signal = Signal(("run", "time"), np.where(fine, error, np.nan), ERROR)
    return Flown(
        columns,
        Labelled({**histories.variables, "error": error_signal}, {**histories.coordinates, **axes}),
    )
