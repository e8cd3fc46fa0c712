"""Relations between the values of a run as a function of WebAssembly."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gyrostat.codegen.numpy_tracing import with_jax
from gyrostat.codegen.simd.batch import Traced, traced
from gyrostat.scenario.relation import Relation


def possible_function(keys: Sequence[str], relations: Sequence[Relation]) -> Traced:
    """Function of the values of a run, (keys,): whether it fulfils each relation, 1 or 0.

    Args:
        keys: Keys of the values.
        relations: Relations.
    """

    def possible(values: Any) -> list[Any]:
        of = {key: values[k] for k, key in enumerate(keys)}
        return [1.0 * each.holds(of) for each in relations]

    return traced(with_jax(possible), (True,), (np.zeros((1, len(keys))),))


def about_relations(keys: Sequence[str], relations: Sequence[Relation]) -> dict[str, Any]:
    """Keys, as their numbers, and message of each relation, for JSON."""
    numbers = {key: k for k, key in enumerate(keys)}
    return {"relations": [[[numbers[k] for k in each.keys], each.text] for each in relations]}
