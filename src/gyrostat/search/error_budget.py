"""Budget of the pointing error by source: runs with sources switched off and on alone."""

from collections.abc import Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import permutations
from math import factorial
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.draws import check_draws, draw
from gyrostat.campaigns.pointing.campaign import size_name
from gyrostat.campaigns.pointing.collected import mean_names, mean_square_name
from gyrostat.campaigns.pointing.indices import parts_of
from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix
from gyrostat.scenario.error_sources import (
    MILLIONTH,
    ErrorSource,
    error_sources,
    values_without,
    with_switches,
)
from gyrostat.scenario.requirement import Requirement
from gyrostat.scenario.scenario import Scenario
from gyrostat.search.budget_indices import default_indices
from gyrostat.search.condition import known_metric
from gyrostat.search.contributions import Sets
from gyrostat.search.flights import Columns
from gyrostat.search.moves import FIRST, Answers, Moves

BUDGET = "budget"
"""Key of the options of a budget in campaign.json."""
FEWEST_ORDERS, MOST_ORDERS = 8, 1024
"""Smallest and largest number of orders in which the sources are switched on."""
FEWEST = 16
"""Fewest runs with each set of sources."""
DISPERSED, DELAY = "dispersed parameters", "delay of the command"
"""Properties of the loop that are no component: dispersions, and the delay of the command."""


class SourceSet(NamedTuple):
    """Sources with which the same runs are simulated.

    Attributes:
        off: Sources that are switched off, in the order of the scenario.
        property: Name of the property of the loop that is taken away; empty: none.
    """

    off: tuple[ErrorSource, ...]
    property: str = ""


@dataclass(frozen=True, eq=False)
class BudgetQuestion:
    """Budget of a scenario; see `gyrostat.search.execute.Question`.

    Attributes:
        base: Scenario with the pointing requirements whose indices are split.
        runs: Number of runs with each set of sources.
        metrics: Metrics of which the part that is missing without each source is given.
        orders: Number of orders in which the sources are switched on, even; 0: each source is
            switched on and off alone.
        is_required: Whether the pointing requirements are those of the scenario.
    """

    base: Scenario
    runs: int
    metrics: tuple[str, ...] = ()
    orders: int = 0
    is_required: bool = True

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        runs: int,
        metrics: Iterable[str] = (),
        orders: int = 0,
        windows: Sequence[str] = (),
    ) -> Self:
        """Create the question from its options.

        Args:
            scenario: Scenario. Without a pointing requirement, the error in its windows is split,
                see `gyrostat.search.budget_indices.default_indices`.
            runs: See `BudgetQuestion`.
            metrics: See `BudgetQuestion`.
            orders: See `BudgetQuestion`.
            windows: See `gyrostat.search.budget_indices.default_indices`.

        Raises:
            InputError: There are too few runs, the scenario has no source of pointing error, or
                there is no such metric.
        """
        if runs < FEWEST:
            raise InputError(f"--runs: found {runs}, expected at least {FEWEST} with budget")
        if orders != 0 and orders not in range(FEWEST_ORDERS, MOST_ORDERS + 1, 2):
            raise InputError(
                f"--orders: found {orders}, expected 0 or an even number from {FEWEST_ORDERS} to "
                f"{MOST_ORDERS}"
            )
        is_required = bool(scenario.requirements)
        if is_required and windows:
            raise InputError(
                f"--window: found it with pointing requirements of {scenario.name}, expected none: "
                "their key `during` names windows"
            )
        if not is_required:
            scenario = replace(scenario, requirements=default_indices(scenario, windows))
        names = tuple(known_metric(name, scenario, "--metric") for name in metrics)
        question = cls(scenario, runs, names, orders, is_required)
        if not question.sources:
            raise InputError(
                f"{scenario.name}: found no source of pointing error, expected noise, friction or "
                "torques with values above 0"
            )
        return question

    @cached_property
    def _all(self) -> tuple[ErrorSource, ...]:
        return error_sources(self.base)

    @cached_property
    def sources(self) -> tuple[ErrorSource, ...]:
        """Sources of error, whose contributions add up."""
        return tuple(source for source in self._all if not source.is_property)

    @cached_property
    def properties(self) -> tuple[str, ...]:
        """Properties of the loop, which change the error of the sources."""
        names = [source.name for source in self._all if source.is_property]
        names += [DISPERSED] if self.base.dispersions else []
        return (*names, *([DELAY] if self.base.command_delay else []))

    @cached_property
    def scenario(self) -> Scenario:
        """Scenario of the runs: every number that is switched is drawn."""
        return with_switches(self.base, self._all)

    @cached_property
    def sets(self) -> tuple[SourceSet, ...]:
        """Sets of sources: all, none, each alone, all but each, and all without each property."""
        sources = self.sources
        sets = [SourceSet(()), SourceSet(sources)]
        sets += [SourceSet(tuple(o for o in sources if o is not each)) for each in sources]
        sets += [SourceSet((each,)) for each in sources]
        sets += [each for order in self._orders for each in self._prefixes(order)]
        sets += [
            SourceSet(tuple(o for o in self._all if o.name == name), name)
            for name in self.properties
        ]
        return tuple(dict.fromkeys(sets))

    @property
    def places(self) -> Sets:
        """Places of the sets of each source."""
        sources = self.sources
        return Sets(
            tuple(source.name for source in sources),
            tuple(
                self.sets.index(SourceSet(tuple(o for o in sources if o is not each)))
                for each in sources
            ),
            tuple(self.sets.index(SourceSet((each,))) for each in sources),
            tuple(
                (order, tuple(self.sets.index(each) for each in self._prefixes(order)))
                for order in self._orders
            ),
            factorial(len(sources)) <= self.orders,
        )

    @cached_property
    def _orders(self) -> list[tuple[int, ...]]:
        """Orders in which the sources are switched on, each followed by its reverse."""
        numbers = range(len(self.sources))
        if len(numbers) < 2 or factorial(len(numbers)) <= self.orders:
            every = [*permutations(numbers)] if self.orders else []
            pairs = {min(order, order[::-1]): None for order in every}
        else:
            random = np.random.default_rng(0)
            pairs = [
                tuple(random.permutation(len(numbers)).tolist()) for _ in range(self.orders // 2)
            ]
        return [each for order in pairs for each in (order, order[::-1])]

    def _prefixes(self, order: tuple[int, ...]) -> list[SourceSet]:
        """Sets from none to all when the sources are switched on in an order."""
        return [
            SourceSet(tuple(s for k, s in enumerate(self.sources) if k not in order[:count]))
            for count in range(len(order) + 1)
        ]

    def options(self) -> dict[str, Any]:
        """Options that campaign.json stores."""
        return {
            BUDGET: self.runs,
            "dispersions": len(self.base.dispersions),
            "metrics": [*self.metrics],
            "orders": self.orders,
            "is_required": self.is_required,
        }

    @classmethod
    def stored(cls, scenario: Scenario, options: Mapping[str, Any]) -> Self:
        """Question of a stored search, from its scenario and options."""
        dispersions = scenario.dispersions[: options["dispersions"]]
        return cls(
            replace(scenario, dispersions=dispersions),
            options[BUDGET],
            tuple(options["metrics"]),
            options["orders"],
            options["is_required"],
        )

    @property
    def variants(self) -> list[Scenario]:
        """Scenarios of the runs, which differ by known friction and by the delay."""
        return [self._variant(*key) for key in self._variant_keys]

    @cached_property
    def _variant_keys(self) -> list[tuple[frozenset[str], bool]]:
        return [*dict.fromkeys(map(_variant_key, self.sets))]

    def _variant(self, off: frozenset[str], no_delay: bool) -> Scenario:
        scenario = self.scenario
        values = {key: MILLIONTH * scenario.values[key] for key in off}
        scenario = replace(scenario, values={**scenario.values, **values})
        return replace(scenario, command_delay=0) if no_delay else scenario

    def columns(self) -> dict[str, list[str]]:
        """Requirement or metric -> its columns in the response of a run, after the first."""
        columns = {each.metric: moment_columns(each) for each in self.base.requirements}
        return columns | {f"metric {name}": [name] for name in self.metrics}

    def response(self, columns: Columns) -> Matrix:
        """Whether runs ended, and what `columns` lists, (runs, columns); NaN if they did not."""
        names = [name for group in self.columns().values() for name in group]
        ended = columns["status"] == 0
        values = np.stack([ended, *(columns[name] for name in names)], axis=1)
        return np.where(ended[:, None], values, np.nan)

    def searches(
        self, runs: int, seed: int
    ) -> Sequence[Generator[Moves, Answers, NDArray[np.float64]]]:
        """The one search, which gives the responses, (sets, runs, columns); raises `InputError`."""
        if self.base.dispersions:
            check_draws(self.base, seed, self.runs)
        return [self._fly(seed)]

    def _fly(self, seed: int) -> Generator[Moves, Answers, NDArray[np.float64]]:
        base, scenario, count = self.base, self.scenario, self.runs
        drawn, _ = draw(base, seed, np.arange(count))
        nominal = [scenario.values[key] for key in scenario.dispersed]
        whole = np.tile(nominal, (count, 1))
        typical = whole.copy()
        whole[:, : drawn.shape[1]] = drawn
        names = scenario.dispersed

        def values(each: SourceSet) -> Matrix:
            return values_without(names, typical if each.property == DISPERSED else whole, each.off)

        first = yield Moves(None, np.full(count, FIRST), 1.0, count, values=whole)
        others = self.sets[1:]
        variants = [self._variant_keys.index(_variant_key(each)) for each in others]
        rest = yield Moves(
            None,
            np.tile(first.numbers, len(others)),  # the noise of the first ones
            0.0,
            count * len(others),
            values=np.concatenate([values(each) for each in others]),
            variants=np.repeat(variants, count),
        )
        return np.concatenate([first.response, rest.response]).reshape(len(self.sets), count, -1)


def _variant_key(each: SourceSet) -> tuple[frozenset[str], bool]:
    keys = {key for source in each.off if source.is_known for key in source.keys}
    return frozenset(keys), each.property == DELAY


def moment_columns(requirement: Requirement) -> list[str]:
    """Columns of the index of a requirement: mean square, parts of the mean, size."""
    metric = requirement.metric
    names = mean_names(metric, parts_of(requirement))
    return [mean_square_name(metric), *names, size_name(metric)]
