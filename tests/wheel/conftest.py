"""The wheel of Carrara and Kuga, its profile 2, and an independent solution."""

from pathlib import Path

import numpy as np
import pytest

from gyrostat.core.jax64 import jax
from gyrostat.wheel import Wheel, speed_response
from gyrostat.wheel.friction import Stribeck

_respond = jax.jit(speed_response, static_argnames="hold")


@pytest.fixture(scope="session")
def paper():
    """J, k_m, b, c, T_s, w_s of the paper's (16), SI."""
    inertia = 1.5e-3
    values = (15.205, 0.00322, 0.5863, 0.6037)
    return (inertia, *(inertia * value for value in values), 0.418879)


@pytest.fixture(scope="session")
def wheel(paper):
    """The paper's wheel."""
    return Wheel(inertia=paper[0], motor_constant=paper[1], friction=Stribeck(*paper[2:]))


@pytest.fixture(scope="session")
def response():
    """Speeds as numpy, after a check that every interval was resolved.

    Records are filled up with intervals of zero length, so that few lengths are compiled.
    """

    def call(wheel, time, current, initial=0.0, hold="zero-order"):
        count = len(time)
        padding = (0, (512 if count <= 512 else 32768) - count)
        time, current = (
            np.pad(np.asarray(v, float), padding, mode="edge") for v in (time, current)
        )
        wheel = jax.tree.map(np.float64, wheel)
        speeds, resolved = _respond(wheel, time, current, np.float64(initial), hold=hold)
        assert bool(resolved)
        return np.asarray(speeds)[:count]

    return call


@pytest.fixture(scope="session")
def reference(module_at):
    """The independent wheel of reference.py beside this file."""
    return module_at(Path(__file__).with_name("reference.py")).Reference


@pytest.fixture(scope="session")
def profile2():
    """Ten 30 s steps of alternating sign, 0.06 to 0.15 A: knots and the currents held from them."""
    amplitudes = np.random.default_rng(1).uniform(0.06, 0.15, 10) * (-1.0) ** np.arange(10)
    return np.arange(11) * 30.0, np.append(amplitudes, amplitudes[-1])
