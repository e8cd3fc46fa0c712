"""Validated designs of a scenario, kept in the private cache."""

import hashlib
import os
import pickle
from functools import lru_cache
from typing import Any

import numpy as np

from gyrostat.codegen.evaluation import evaluated
from gyrostat.core.cache import private_cache
from gyrostat.core.jax64 import jax
from gyrostat.core.validation import check_parts, check_period
from gyrostat.runs.build import Setup, build
from gyrostat.runs.designs import Plans, plan
from gyrostat.runs.fingerprint import FLAGS, engine_record
from gyrostat.runs.mode_inputs import check_conditions
from gyrostat.runs.planned_slews import with_planned_slews
from gyrostat.runs.user.trial import check_first_sample, first_sample
from gyrostat.scenario.kinds.registry import is_shipped
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.sensing import Values
from gyrostat.scenario.structure import Structure, structure_of

# scenarios that differ in numbers only share these programs
_build = evaluated(build)
_first_sample = evaluated(first_sample)


@lru_cache(maxsize=8)
def designs_of(scenario: Scenario) -> Plans:
    """Design the controllers of a scenario; its parts are not validated.

    Raises:
        InputError: The working wheels do not suffice in a phase.
    """
    return plan(scenario)


@lru_cache(maxsize=8)
def plans_of(scenario: Scenario) -> Plans:
    """Design the controllers of a scenario and validate all its parts.

    The designs of a scenario with the same content, code and versions are taken from the cache,
    which has them only if the parts were valid. Designs by a controller that is not of this package
    are always computed.

    Raises:
        InputError: A part refuses its parameters, or the working wheels do not suffice in a phase.
    """
    identity = engine_record("cpu", FLAGS["cpu"]), os.environ.get("JAX_PLATFORMS"), scenario.text()
    name = f"scenario-{hashlib.sha256(repr(identity).encode()).hexdigest()}"
    cache = private_cache() if is_shipped(scenario) else None
    content = None if cache is None else cache.read(name)
    if content is not None:
        return pickle.loads(content)
    plans = designs_of(scenario)
    if scenario.sources:
        setup, *first = _first_sample(*_numbers(scenario, plans))
        check_first_sample(scenario, *first)
    else:
        setup = setup_of(scenario, plans)
    check_conditions(scenario, setup)
    _check_setup(scenario, setup)
    plans = with_planned_slews(scenario, plans, setup)
    plans = jax.tree.map(np.asarray, plans)
    if cache is not None:
        cache.write(name, pickle.dumps(plans))
    return plans


def check_run(scenario: Scenario, plans: Plans) -> None:
    """Check the parts that a run has with the designs of other values.

    Args:
        scenario: Scenario with the values of the run.
        plans: Designs of the scenario of the run.

    Raises:
        InputError: A part refuses its parameters.
    """
    _check_setup(scenario, setup_of(scenario, plans))


def _check_setup(scenario: Scenario, setup: Setup) -> None:
    check_parts(setup.plant, setup.controller, setup.sensor, *setup.metrics.values())
    setup.plant.check_state(setup.start)
    check_period(scenario.values["run.control_period"], setup.controller)


def setup_of(scenario: Scenario, plans: Plans) -> Setup:
    """Parts of a run of a scenario with its nominal values."""
    return _build(*_numbers(scenario, plans))


def _numbers(scenario: Scenario, plans: Plans) -> tuple[Structure, Values, Plans]:
    values: Any = {key: np.asarray(value) for key, value in scenario.values.items()}
    return structure_of(scenario), values, plans
