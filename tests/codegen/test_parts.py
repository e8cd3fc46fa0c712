"""Every public part of the loop is compiled for SIMD lanes and for flight, or refused alike."""

import inspect
import re
from pathlib import Path

import numpy as np
import pytest

from gyrostat import control, estimation, spacecraft, wheel
from gyrostat.codegen import Lowering
from gyrostat.codegen.flight import Entry, emit
from gyrostat.codegen.program import Name
from gyrostat.codegen.scope import FLIGHT
from gyrostat.codegen.simd.batch import lanes
from gyrostat.codegen.simd.batch_scope import BATCH, batch_kind
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax

NOISE = re.compile(r"^\w+: gyrostat/.*: found random numbers \(\w+\), expected none: flight")
NOT_IN_THE_LOOP = {
    # steps of others, tested with them
    *("AttitudePID", "EulerCube", "MRPBody", "QuaternionBody", "ConditionedCompensator"),
    *("ThreeAxisLaw", "TwoWheelLaw", "WheelRateLoop", "TwoWheelSweeps", "WheelMap"),
    *("RateObserver", "WheelMomentumFilter", "FrictionTorqueFilter", "FrictionScaleFilter"),
    *("MomentumFilter", "WheelArrayFilter"),
    *("AttitudeFilter", "SteadyAttitudeFilter", "Driver", "Tachometer", "Wheel", "WheelArray"),
    *("FrictionSteps", "WheelFailures", "Imbalance", "CircularOrbit", "GravityGradient"),
    *(
        "HarmonicTorque",
        "Spacecraft",
        "StarTrackerHeads",
        "BearingEquation",
        "CoupledBearings",
        "Law",
        "SampledModel",
    ),
    *("AddedSensor", "ActuatorWithState", "FlexibleModes"),  # protocols, part of a plant
}


@pytest.fixture(scope="module")
def examples(module_at):
    return module_at(Path(__file__).with_name("parts.py")).examples()


def inputs(jaxpr):
    """Names for the arguments of a trace."""
    for variable in jaxpr.jaxpr.invars:
        names = np.empty(variable.aval.shape, dtype=object)
        for place in np.ndindex(names.shape):
            names[place] = Name(batch_kind(variable.aval.dtype))
        yield names


def test_every_part_is_compiled_or_draws_noise(examples):
    refused = {}
    for name, (function, arguments) in examples.items():
        traced = jax.make_jaxpr(function)(*arguments)
        try:
            Lowering(FLIGHT).graph(traced, list(inputs(traced)), [])
        except InputError as error:
            refused[name] = str(error)
            # lanes take more than flight code; lowering both would double the time of this test
            Lowering(BATCH).graph(traced, list(inputs(traced)), [])
    assert all(NOISE.match(message) for message in refused.values()), refused
    assert {name.split(",")[0] for name in refused} == {
        *("TableSensors", "TrueTurn", "MomentumSensor", "TrackerGyroSensors", "FaultySensor"),
        "AddedSensors",
        "PaddleAngle",
    }


def test_no_part_is_missing(examples):
    tried = {word for name in examples for word in re.split(r", | of ", name)}
    public = {
        name
        for module in (spacecraft, control, estimation, wheel)
        for name in module.__all__
        if inspect.isclass(getattr(module, name))
        and callable(getattr(getattr(module, name), "start", None))
    }
    assert public - tried - NOT_IN_THE_LOOP == set()


class WithGamma:
    """A step that no compiled code has."""

    def __call__(self, x):
        return jax.scipy.special.gammaln(x)


def test_lanes_and_flight_refuse_in_the_same_words():
    messages = []
    with pytest.raises(InputError) as caught:
        emit("bad", [Entry("bad", WithGamma(), {"x": np.eye(2)}, ("y",))])
    messages.append(str(caught.value))
    with pytest.raises(InputError) as caught:
        lanes(WithGamma(), (True,), (np.ones((3, 2, 2)),))
    messages.append(str(caught.value))
    assert messages[0] == messages[1]
    assert re.match(
        r"WithGamma: test_parts\.py:\d+: return jax\.scipy\.special\.gammaln\(x\): "
        r"found a primitive \(lgamma\), expected one that compiled code has: ",
        messages[0],
    )
