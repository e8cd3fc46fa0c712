"""The module for Basilisk: by itself, and in Basilisk where that is installed."""

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.units import RPM
from gyrostat.exports import basilisk
from gyrostat.wheel import WheelModel
from gyrostat.wheel.friction import DirectionalStribeck, Stribeck, ViscousCoulomb

CURVE = {"viscous": 4.83e-6, "coulomb": 0.8795e-3, "static": 0.9055e-3, "stribeck_speed": 0.418879}
WHEEL = {"inertia": 1.5e-3, "motor_constant": 0.0228}


def module_of(friction, **values):
    found = {}
    exec(basilisk(WheelModel(friction, {**WHEEL, **values})), found)
    return found


class Factory:
    """Takes what Basilisk's would."""

    def create(self, kind, axis, **settings):
        return kind, axis, settings


def test_the_wheel_has_the_identified_numbers():
    made = module_of(Stribeck, **CURVE)
    kind, axis, settings = made["add_wheel"](Factory(), [0, 0, 1], Omega=100.0, useMaxTorque=True)
    assert (kind, axis) == ("custom", [0, 0, 1])
    assert settings == {
        "Js": 1.5e-3,
        "useRWfriction": True,
        "useMaxTorque": True,
        "cViscous": 4.83e-6,
        "fCoulomb": 0.8795e-3,
        "fStatic": 0.9055e-3,
        "betaStatic": pytest.approx(0.418879 / np.sqrt(2.0), rel=1e-15),
        "Omega": 100.0,
    }
    assert made["motor_torque"](0.5) == 0.5 * 0.0228


def test_it_says_what_is_lost():
    told = module_of(Stribeck, **CURVE)["__doc__"]
    assert "creeps" in told
    assert "2.6e-05 N·m" in told
    plain = module_of(ViscousCoulomb, viscous=5e-6, coulomb=9e-4)
    assert "Stribeck" not in plain["__doc__"]
    assert plain["FRICTION"]["betaStatic"] == -1.0
    names = DirectionalStribeck.dimensions()
    values = dict.fromkeys(names, 1e-3) | {"coulomb_positive": 8e-4, "coulomb_negative": 9e-4}
    uneven = module_of(DirectionalStribeck, **values)
    assert uneven["FRICTION"]["fCoulomb"] == pytest.approx(8.5e-4, rel=1e-15)
    assert "wrong by 5e-05 N·m in each" in uneven["__doc__"]
    assert "not valid" not in told
    marked = WheelModel(Stribeck, {**WHEEL, **CURVE}, impossible='"""b < 0')
    exec(basilisk(marked), found := {})
    assert "the wheel is not valid" in found["__doc__"]


def test_a_wheel_without_inertia_is_refused():
    with pytest.raises(InputError, match="inertia"):
        basilisk(WheelModel(Stribeck, {"motor_constant": 0.02, **CURVE}))


def test_basilisk_slows_the_wheel_as_the_model_says():
    """A wheel that coasts on a hub that cannot turn, above the bend of its friction curve."""
    pytest.importorskip("Basilisk", reason="found no Basilisk (bsk), of the extra peers")
    from Basilisk.simulation import reactionWheelStateEffector, spacecraft
    from Basilisk.utilities import SimulationBaseClass, macros, simIncludeRW

    simulation = SimulationBaseClass.SimBaseClass()
    task = simulation.CreateNewTask("task", macros.sec2nano(0.01))
    simulation.CreateNewProcess("process").addTask(task)
    hub = spacecraft.Spacecraft()
    hub.hub.mHub, hub.hub.IHubPntBc_B = 1e6, (1e9 * np.eye(3)).tolist()
    factory = simIncludeRW.rwFactory()
    module_of(Stribeck, **CURVE)["add_wheel"](factory, [0, 0, 1], Omega=100.0)
    wheels = reactionWheelStateEffector.ReactionWheelStateEffector()
    factory.addToSpacecraft("wheels", wheels, hub)
    for part in (hub, wheels):
        simulation.AddModelToTask("task", part)
    speeds = wheels.rwSpeedOutMsg.recorder()
    simulation.AddModelToTask("task", speeds)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(10.0))
    simulation.ExecuteSimulation()
    rate, level = CURVE["viscous"] / WHEEL["inertia"], CURVE["coulomb"] / CURVE["viscous"]
    expected = (100.0 * RPM + level) * np.exp(-10.0 * rate) - level
    assert expected > 10.0 * CURVE["stribeck_speed"]
    assert speeds.wheelSpeeds[-1][0] == pytest.approx(expected, rel=1e-10)
