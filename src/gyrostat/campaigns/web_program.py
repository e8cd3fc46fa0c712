"""Program of a scenario as WebAssembly, with what a page needs to call it.

The program is that of the native engine, from the same text. A third function computes the metrics
of a run from what was accumulated, a fourth one says which relations its values fulfil. Products
and sums are not fused, and it has another library of functions: results differ from those of the
native engine in the last digits.
"""

import hashlib
import pickle
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.native import program_name, trace
from gyrostat.campaigns.web_relations import about_relations, possible_function
from gyrostat.codegen.numpy_tracing import with_jax
from gyrostat.codegen.simd.batch import Traced, traced
from gyrostat.codegen.simd.call import Layout, Place
from gyrostat.codegen.simd.web import require_web_compiler, web_assembly
from gyrostat.codegen.simd.words_read import words_read
from gyrostat.core.cache import private_cache
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.core.threefry import Words
from gyrostat.core.types import Matrix
from gyrostat.runs.designs import Plans, plan
from gyrostat.runs.metrics.observer import Seen, concluded, ended
from gyrostat.runs.metrics.percentiles import FoundPercentiles
from gyrostat.runs.plans import plans_of
from gyrostat.runs.run_loop import Drawn, runner_of
from gyrostat.scenario.kinds.orbits import own_orbits
from gyrostat.scenario.kinds.registry import is_shipped
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.structure import Structure, structure_of
from gyrostat.simulation.labels import labelled


class Functions(NamedTuple):
    """Functions of a program as C: begin, chunk and conclude.

    Attributes:
        texts: Function -> text of its C module.
        layouts: Function -> layout of its arguments and results.
        seen: See `gyrostat.campaigns.native.Stored`.
        records: See `gyrostat.campaigns.native.Stored`.
        designed: See `WebProgram`.
    """

    texts: dict[str, str]
    layouts: dict[str, Layout]
    seen: Any
    records: Any
    designed: frozenset[str]


class WebProgram(NamedTuple):
    """Program of a scenario as WebAssembly.

    Attributes:
        module: Module, see `gyrostat.codegen.simd.web.web_assembly`, with the functions begin,
            chunk, conclude and possible.
        about: Places of inputs, signals and results in the memory of these functions, for JSON.
        read: Keys of the scenario that the program reads.
        designed: Keys on which the designs of the controller depend, its model of the spacecraft
            included. They stay those of the scenario when a value of a run changes.
        shared: Words that all runs share, (words,); the nominal values come first.
        layout: Layout of `begin`.
    """

    module: bytes
    about: dict[str, Any]
    read: tuple[str, ...]
    designed: frozenset[str]
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


def web_program(scenario: Scenario, relations: Iterable[Relation]) -> WebProgram:
    """Program of a scenario as WebAssembly: from the cache, or traced and compiled.

    Args:
        scenario: Scenario.
        relations: Relations that the values of its runs must fulfil.

    Raises:
        InputError: There is no compiler for WebAssembly, or the scenario contains an operation that
            compiled code does not support.
    """
    require_web_compiler()
    structure, plans = structure_of(scenario), plans_of(scenario)
    functions = _functions(scenario, structure, plans)
    layout = functions.layouts["begin"]
    read = _words_read(functions.texts, layout.words["made"])
    nominal = np.array([*scenario.values.values()])
    # what is not read, such as the nominal orbit of runs with their own ones, needs no room
    designs = [
        leaf if is_read else np.zeros_like(leaf)
        for leaf, is_read in zip(*_designs(scenario, plans, read[0]), strict=True)
    ]
    arguments = iter([nominal, *designs])
    shared = layout.shared_words([None if o else next(arguments) for o in layout.own])
    keys = _keys_read(structure, read)
    concerned = [each for each in relations if not {*keys}.isdisjoint(each.keys)]
    possible = possible_function(structure.keys, concerned)
    return WebProgram(
        web_assembly({**functions.texts, "possible": possible.text}),
        _about(scenario, structure, functions) | about_relations(structure.keys, concerned),
        keys,
        functions.designed,
        shared,
        layout,
    )


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
    shared, _ = _words_read(texts, begin.layout.words["made"])
    functions = Functions(texts, layouts, seen, records, _designed(scenario, plans, shared))
    if cache is not None:
        cache.write(name, pickle.dumps(functions))
    return functions


def _conclusion(scenario: Scenario, chunk: Traced, seen: Any) -> Traced:
    """Function of `Seen` and percentiles, (signals, percentages): status, end and metrics.

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
            "shared": _words(begin, own=False),
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


def _designed(scenario: Scenario, plans: Plans, read: set[int]) -> frozenset[str]:
    """Keys on which designs depend: those whose small change changes a design, or is refused.

    The components of a vector are changed together, and so are the values of all wheels.

    Args:
        scenario: Scenario.
        plans: Its designs.
        read: Words that the runs share and the program reads, after the nominal values the designs.
    """
    groups: dict[str, list[str]] = {}
    for key in scenario.values:
        name = re.sub(r"^wheel\.[^.]+", "wheel", key)
        groups.setdefault(re.sub(r"\.[xyz]{1,2}$", "", name), []).append(key)
    leaves, are_read = _designs(scenario, plans, read)
    keys: set[str] = set()
    for group in groups.values():
        values = {key: 1.001 * scenario.values[key] or 1e-6 for key in group}
        try:
            changed = plan(replace(scenario, values={**scenario.values, **values}))
        except InputError:
            keys |= {*group}
            continue
        every = zip(are_read, leaves, jax.tree.leaves(changed), strict=True)
        if not all(np.array_equal(*pair, equal_nan=True) for is_read, *pair in every if is_read):
            keys |= {*group}
    return frozenset(keys)


def _designs(
    scenario: Scenario, plans: Plans, read: set[int]
) -> tuple[list[NDArray[Any]], list[bool]]:
    """Arrays of the designs, and whether a program reads each; see `_designed`."""
    leaves = [*map(np.asarray, jax.tree.leaves(plans))]
    ends = (len(scenario.values) + np.cumsum([0, *(leaf.size for leaf in leaves)])).tolist()
    return leaves, [not read.isdisjoint(range(*pair)) for pair in pairwise(ends)]


def _words(layout: Layout, *, own: bool) -> int:
    shapes = [t.shape for t, each in zip(layout.types, layout.own, strict=True) if each == own]
    return sum(int(np.prod(shape)) for shape in shapes)


def _signals(places: Sequence[Place], rows: Any, error: int) -> dict[str, list[Any]]:
    """Name of each signal, as in histories -> memory, first word, size, and whether it is whole.

    The words of a signal are numbered as if they were its values at the first sample; those of
    whole numbers are complex, to tell them from the others.
    """

    def numbered(index: int) -> Any:
        place = places[index]
        shape = place.type.shape[1:]
        words = place.start + np.arange(float(np.prod(shape))).reshape(1, 1, *shape)
        return words if place.type.dtype == "float64" else words + 0j

    memory = places[error].memory
    first = jax.tree.map(numbered, rows)._replace(status=np.zeros((1, 1), int))
    signals = {name: each.values for name, each in labelled(first, 1.0).variables.items()}
    signals["error"] = numbered(error)
    return {
        name: [memory, int(words.flat[0].real), words.size, np.iscomplexobj(words)]
        for name, words in signals.items()
        if words.ndim > 1
    }


def _words_read(texts: dict[str, str], carry: int) -> tuple[set[int], set[int]]:
    """Words that the runs share, and those of a run, that `begin` or `chunk` read and use.

    They are numbered as in `begin`.
    """
    shared, own = words_read(texts["begin"])
    # the first word that the runs share is the first sample of the chunk
    later, state = words_read(texts["chunk"])
    return shared | {word - 1 for word in later}, own | {word - carry for word in state}


def _keys_read(structure: Structure, read: tuple[set[int], set[int]]) -> tuple[str, ...]:
    """Keys of which a program reads the value."""
    keys = {
        names[k]
        for names, words in zip((structure.keys, structure.dispersed), read, strict=True)
        for k in words
        if 0 <= k < len(names)
    }
    return tuple(key for key in structure.keys if key in keys)
