"""Program of a scenario as WebAssembly, with what a page needs to call it.

The program is that of the native engine, from the same text, and a third function that computes the
metrics of a run from what was accumulated. Its products and sums are not fused, and it has another
library of functions: results differ from those of the native engine in the last digits.
"""

import hashlib
import pickle
import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from gyrostat.campaigns.native import program_name, trace
from gyrostat.codegen.numpy_tracing import with_jax
from gyrostat.codegen.simd.batch import Traced, traced
from gyrostat.codegen.simd.call import Layout, Place
from gyrostat.codegen.simd.web import require_web_compiler, web_assembly
from gyrostat.core.cache import private_cache
from gyrostat.core.jax64 import jax
from gyrostat.core.threefry import Words
from gyrostat.core.types import Matrix
from gyrostat.runs.designs import Plans
from gyrostat.runs.metrics.observer import Seen, concluded, ended
from gyrostat.runs.metrics.percentiles import FoundPercentiles
from gyrostat.runs.plans import plans_of
from gyrostat.runs.run_loop import Drawn, runner_of
from gyrostat.scenario.kinds.orbits import own_orbits
from gyrostat.scenario.kinds.registry import is_shipped
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.structure import Structure, structure_of
from gyrostat.simulation.labels import labelled

RESULTS = ("status", "ended")
"""Results of a run before its metrics."""


class Functions(NamedTuple):
    """Functions of a program as C: begin, chunk and conclude.

    Attributes:
        texts: Function -> text of its C module.
        layouts: Function -> layout of its arguments and results.
        seen: See `gyrostat.campaigns.native.Stored`.
        records: See `gyrostat.campaigns.native.Stored`.
    """

    texts: dict[str, str]
    layouts: dict[str, Layout]
    seen: Any
    records: Any


class WebProgram(NamedTuple):
    """Program of a scenario as WebAssembly.

    Attributes:
        module: Module, see `gyrostat.codegen.simd.web.web_assembly`, with the functions begin,
            chunk and conclude.
        about: Places of inputs, signals and results in the memory of these functions, for JSON.
        read: Keys of the scenario that the program reads.
        shared: Words that all runs share, (words,); the nominal values come first.
        layout: Layout of `begin`.
    """

    module: bytes
    about: dict[str, Any]
    read: tuple[str, ...]
    shared: Words
    layout: Layout

    def own_words(self, scenario: Scenario, values: Matrix, keys: Words) -> Words:
        """Words of runs, (runs, words): dispersed values, tables of own orbits, random key.

        Args:
            scenario: Scenario of the runs.
            values: Dispersed values, (runs, keys).
            keys: Random keys of the noise, (runs,).
        """
        drawn = jax.tree.leaves(Drawn(values, own_orbits(scenario, values)))
        arguments = iter([*map(np.asarray, drawn), keys])
        return self.layout.own_words([next(arguments) if o else None for o in self.layout.own])


def web_program(scenario: Scenario) -> WebProgram:
    """Program of a scenario as WebAssembly: from the cache, or traced and compiled.

    Raises:
        InputError: There is no compiler for WebAssembly, or the scenario contains an operation that
            compiled code does not support.
    """
    require_web_compiler()
    structure, plans = structure_of(scenario), plans_of(scenario)
    functions = _functions(scenario, structure, plans)
    layout = functions.layouts["begin"]
    nominal = np.array([*scenario.values.values()])
    arguments = iter([nominal, *jax.tree.leaves(plans)])
    shared = layout.shared_words([None if o else next(arguments) for o in layout.own])
    about = _about(scenario, structure, functions)
    read = _keys_read(structure, functions.texts, about["carry"])
    return WebProgram(web_assembly(functions.texts), about, read, shared, layout)


def _functions(scenario: Scenario, structure: Structure, plans: Plans) -> Functions:
    """Functions of a program: from the cache, or traced."""
    cache = private_cache() if is_shipped(structure) else None
    period = scenario.values["run.control_period"]
    metrics = repr((scenario.percentiles, [*metrics_of(scenario)], period))
    digest = hashlib.sha256(metrics.encode()).hexdigest()
    name = f"{program_name(structure, plans, 0, 'kernel')}-{digest}"
    content = None if cache is None else cache.read(name)
    if content is not None:
        return pickle.loads(content)
    (begin, chunk), seen, records = trace(structure, plans, 0)
    parts = {"begin": begin, "chunk": chunk, "conclude": _conclusion(scenario, chunk, seen)}
    texts = {key: each.text for key, each in parts.items()}
    layouts = {key: each.layout for key, each in parts.items()}
    functions = Functions(texts, layouts, seen, records)
    if cache is not None:
        cache.write(name, pickle.dumps(functions))
    return functions


def _conclusion(scenario: Scenario, chunk: Traced, seen: Any) -> Traced:
    """Function of `Seen` and percentiles, (signals, percentages), that gives `RESULTS` and metrics.

    The metrics of pointing requirements, which need all errors, are NaN.
    """

    def conclude(seen: Seen, values: Any) -> list[Any]:
        signals = range(1 + len(scenario.windows))
        percents = scenario.percentiles
        errors = [
            FoundPercentiles({p: values[signal, k] for k, p in enumerate(percents)})
            for signal in signals
        ]
        budget: dict[str, Any] = {each.metric: np.nan for each in scenario.requirements}
        metrics = concluded(scenario, seen, errors, budget)
        period = scenario.values["run.control_period"]
        return [seen.status * 1.0, ended(seen, period), *metrics.values()]

    places = chunk.layout.places
    example = jax.tree.map(
        lambda index: np.zeros((1, *places[index].type.shape), places[index].type.dtype), seen
    )
    percents = np.zeros((1, 1 + len(scenario.windows), len(scenario.percentiles)))
    return traced(with_jax(conclude), (True, True), (example, percents))


def _about(scenario: Scenario, structure: Structure, functions: Functions) -> dict[str, Any]:
    """Places in the memory of the functions; see `WebProgram`."""
    begin, chunk, conclude = (functions.layouts[n] for n in ("begin", "chunk", "conclude"))
    runner = runner_of(structure)
    seen = [chunk.places[index] for index in jax.tree.leaves(functions.seen)]
    places = chunk.places[len(begin.places) :]
    (counted, _), (rows, error) = functions.records
    carry = begin.words["made"]
    first = seen[0].start
    assert [place.memory for place in seen] == ["made"] * len(seen)
    return {
        "carry": carry,
        "seen": [first, carry - first],
        "words": {
            "shared": _words(chunk, own=False),
            "own": _words(begin, own=True),
            "results": conclude.words["made"],
            **{name: chunk.words[name] for name in ("made", "every", "asked")},
        },
        "dispersed": len(structure.dispersed),
        "length": runner.length,
        "starts": [*runner.starts],
        "samples": structure.count + 1,
        "period": scenario.values["run.control_period"],
        "counted": [[places[k].memory, places[k].start] for k in counted],
        "percentiles": [*scenario.percentiles],
        "signals": _signals(places, rows, error),
    }


def _words(layout: Layout, *, own: bool) -> int:
    shapes = [t.shape for t, each in zip(layout.types, layout.own, strict=True) if each == own]
    return sum(int(np.prod(shape)) for shape in shapes)


def _signals(places: Sequence[Place], rows: Any, error: int) -> dict[str, list[Any]]:
    """Name of each signal, as in histories -> memory, first word and number of words of a sample.

    The words of a signal are numbered as if they were its values at the first sample.
    """

    def numbered(index: int) -> Any:
        place = places[index]
        shape = place.type.shape[1:]
        return place.start + np.arange(float(np.prod(shape))).reshape(1, 1, *shape)

    memory = places[error].memory
    first = jax.tree.map(numbered, rows)._replace(status=np.zeros((1, 1), int))
    signals = {name: each.values for name, each in labelled(first, 1.0).variables.items()}
    signals["error"] = numbered(error)
    return {
        name: [memory, int(words.flat[0]), words.size]
        for name, words in signals.items()
        if words.ndim > 1 and words.dtype == float
    }


def _keys_read(structure: Structure, texts: dict[str, str], carry: int) -> tuple[str, ...]:
    """Keys of which `begin` or `chunk` read the value."""
    keys = set()
    # the first word that the runs share is the first sample of the chunk
    for name, shared, own in (("begin", 0, 0), ("chunk", 1, carry)):
        for pattern, offset, names in (
            (r"\bSHARED\((\d+)( \+)?", shared, structure.keys),
            (r"\bOWN\(real, (\d+)( \+)?", own, structure.dispersed),
        ):
            for place in re.finditer(pattern, texts[name]):
                index = int(place[1]) - offset
                if place[2] and index == 0:
                    keys |= {*names}
                elif 0 <= index < len(names):
                    keys.add(names[index])
    return tuple(key for key in structure.keys if key in keys)
