"""Validated designs of a scenario, kept in the private cache."""

import hashlib
import os
import pickle
from functools import lru_cache
from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.core.cache import private_cache
from gyrostat.core.jax64 import jax
from gyrostat.core.validation import check_parts, check_period
from gyrostat.runs.build import build
from gyrostat.runs.designs import Plans, plan
from gyrostat.runs.fingerprint import FLAGS, engine_record
from gyrostat.runs.user.trial import check_first_sample, first_sample
from gyrostat.scenario.kinds.registry import is_shipped
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.structure import structure_of

# The program runs once, for milliseconds: optimising it takes seconds. `filter_jit` passes the
# options to `jax.jit`, which its type does not show.
_filter_jit: Any = eqx.filter_jit
_RUN_ONCE = {"xla_backend_optimization_level": 0, "xla_llvm_disable_expensive_passes": True}
# scenarios that differ in numbers only share these programs
_build = _filter_jit(build, compiler_options=_RUN_ONCE)
_first_sample = _filter_jit(first_sample, compiler_options=_RUN_ONCE)


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
    numbers: Any = {key: np.asarray(value) for key, value in scenario.values.items()}
    # one program compiles in less time than the single operations
    arguments = structure_of(scenario), numbers, plans
    if scenario.sources:
        setup, *first = _first_sample(*arguments)
        check_first_sample(scenario, *first)
    else:
        setup = _build(*arguments)
    check_parts(setup.plant, setup.controller, setup.sensor, *setup.metrics.values())
    setup.plant.check_state(setup.start)
    check_period(scenario.values["run.control_period"], setup.controller)
    plans = jax.tree.map(np.asarray, plans)
    if cache is not None:
        cache.write(name, pickle.dumps(plans))
    return plans
