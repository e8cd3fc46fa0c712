"""Limits of the values of a run that the parts of the run refuse, found by asking them."""

import hashlib
import os
import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, product
from typing import NamedTuple

from gyrostat.core.cache import private_cache
from gyrostat.core.errors import InputError
from gyrostat.runs.fingerprint import FLAGS, engine_record
from gyrostat.runs.plans import check_run, plans_of
from gyrostat.scenario.kinds.registry import is_shipped
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.scenario import Scenario

WIDE = 1000.0
"""How far beyond its slider a typed value may be, in widths of the slider."""
_HALVINGS = 24


class Limit(NamedTuple):
    """End of the range of a value.

    Attributes:
        value: Last value that was accepted.
        why: Why a value beyond it is refused.
    """

    value: float
    why: str


class RunLimits(NamedTuple):
    """What the parts of a run accept.

    Attributes:
        ends: Key -> least and most value, while all others are those of the scenario.
        coupled: Pairs of keys whose limits depend on each other.
    """

    ends: Mapping[str, tuple[Limit, Limit]]
    coupled: Sequence[tuple[str, str]]


def run_limits(
    scenario: Scenario,
    ranges: Mapping[str, tuple[float, float, float, float]],
    relations: Sequence[Relation],
) -> RunLimits:
    """Ask the parts of a run which values they accept, with the designs of the scenario.

    The accepted values of a key are taken as one interval, whose ends are found by bisection.
    Where a relation ends the range before, the parts are asked within it.

    Args:
        scenario: Scenario.
        ranges: Key -> ends of its slider, and least and most value that its entry allows.
        relations: Relations between values, which are checked apart.
    """
    identity = engine_record("cpu", FLAGS["cpu"]), os.environ.get("JAX_PLATFORMS"), scenario.text()
    digest = hashlib.sha256(repr((identity, ranges)).encode()).hexdigest()
    cache = private_cache() if is_shipped(scenario) else None
    content = None if cache is None else cache.read(f"fly-limits-{digest}")
    if content is not None:
        return pickle.loads(content)
    plans = plans_of(scenario)

    def refusal(values: Mapping[str, float]) -> str:
        try:
            check_run(replace(scenario, values={**scenario.values, **values}), plans)
        except InputError as error:
            return str(error)
        return ""

    ends: dict[str, tuple[Limit, Limit]] = {}
    for key, (low, high, least, most) in ranges.items():
        nominal, width = scenario.values[key], high - low
        concerned = [each for each in relations if key in each.keys]

        def related(value: float, key: str = key, concerned: Sequence[Relation] = concerned) -> str:
            values = {**scenario.values, key: value}
            return next((each.message(values) for each in concerned if not each.holds(values)), "")

        far = max(least, low - WIDE * width), min(most, high + WIDE * width)
        first, last = (
            _limit(nominal, _limit(nominal, end, related).value, lambda v, k=key: refusal({k: v}))
            for end in far
        )
        ends[key] = _or_far(first, far[0]), _or_far(last, far[1])
    limited = [key for key, pair in ends.items() if any(end.why for end in pair)]
    apart = {frozenset(pair) for each in relations for pair in combinations(each.keys, 2)}
    coupled = [
        pair
        for pair in combinations(limited, 2)
        if frozenset(pair) not in apart
        and any(
            refusal(dict(zip(pair, (end.value for end in corner), strict=True)))
            for corner in product(*(ends[key] for key in pair))
        )
    ]
    limits = RunLimits(ends, coupled)
    if cache is not None:
        cache.write(f"fly-limits-{digest}", pickle.dumps(limits))
    return limits


def _or_far(limit: Limit, far: float) -> Limit:
    """Limit that the parts have; if they have none, the far end."""
    return limit if limit.why else Limit(far, "")


def _limit(accepted: float, end: float, refusal: Callable[[float], str]) -> Limit:
    """Last accepted value on the way from an accepted one to an end.

    Args:
        accepted: Accepted value.
        end: End of the way.
        refusal: Why a value is refused; empty: it is not.
    """
    why = refusal(end)
    if not why:
        return Limit(end, "")
    for _ in range(_HALVINGS):
        middle = 0.5 * (accepted + end)
        text = refusal(middle)
        accepted, end, why = (accepted, middle, text) if text else (middle, end, why)
    return Limit(accepted, why)
