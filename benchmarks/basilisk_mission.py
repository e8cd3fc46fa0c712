"""The plant of the Earth observation mission in Basilisk (package bsk), in its own interpreter.

    python benchmarks/basilisk_mission.py GIVEN.npz FOUND.npz

`mission_basilisk.py` writes GIVEN.npz and reads FOUND.npz. This file needs Basilisk and NumPy and
nothing of gyrostat. Two simulations share one spacecraft: hub, four balanced reaction wheels,
torque rods, residual dipole, gravity gradient, drag and solar pressure on facets.

`replayed` applies recorded commands. Orbit, Sun, field, density and wind are given: the orbit at
each step, the rest in the middle of the step. Basilisk holds messages for a step, which is of
second order for values of the middle.

`closed` is the simulation whose time is taken: Basilisk's own orbit, atmosphere, field, eclipse and
flight software, all compiled, without Python during the run.
"""

import sys
import time

import numpy as np
from Basilisk import __version__
from Basilisk.architecture import messaging, sysModel
from Basilisk.fswAlgorithms import attTrackingError, hillPoint, mrpFeedback, rwMotorTorque
from Basilisk.simulation import (
    GravityGradientEffector,
    MtbEffector,
    eclipse,
    exponentialAtmosphere,
    facetDragDynamicEffector,
    facetSRPDynamicEffector,
    magneticFieldCenteredDipole,
    reactionWheelStateEffector,
    simpleNav,
    spacecraft,
)
from Basilisk.utilities import (
    SimulationBaseClass,
    macros,
    simIncludeGravBody,
    simIncludeRW,
    simSetPlanetEnvironment,
)

TIMED = 5
"""Repetitions of a timed simulation, of which the fastest counts."""


def column(vector):
    """Vector as a column, as Basilisk wants it."""
    return [[float(x)] for x in vector]


def message(kind, **values):
    """Message of a kind with these values."""
    return getattr(messaging, kind)().write(getattr(messaging, kind + "Payload")(**values))


def rods(limit):
    """Torque rods along the body axes, and the message with their axes and limits."""
    made = MtbEffector.MtbEffector()
    axes = np.eye(3).ravel().tolist()
    known = {"numMTB": 3, "GtMatrix_B": axes, "maxMtbDipoles": [limit] * 3}
    return made, message("MTBArrayConfigMsg", **known)


class Craft:
    """Spacecraft with its effectors, whose inputs are not connected."""

    def __init__(self, given):
        self.hub = spacecraft.Spacecraft()
        self.hub.hub.mHub, self.hub.hub.IHubPntBc_B = float(given["mass"]), given["inertia"]
        self.hub.hub.r_CN_NInit = column(given["position"][0])
        self.hub.hub.v_CN_NInit = column(given["velocity"][0])
        self.hub.hub.sigma_BNInit = column(given["mrp"])
        self.hub.hub.omega_BN_BInit = column(given["rate"])
        bodies = simIncludeGravBody.gravBodyFactory()
        self.earth = bodies.createEarth()
        self.earth.isCentralBody, self.earth.mu = True, float(given["gravity"])
        bodies.addBodiesTo(self.hub)
        self.bodies = bodies

        self.factory = simIncludeRW.rwFactory()
        for axis, speed in zip(given["axes"].T, given["wheel_speed"], strict=True):
            self.factory.create(
                "custom",
                axis,
                Js=float(given["rotor"]),
                Omega=speed / macros.RPM,
                useMaxTorque=False,
            )
        self.wheels = reactionWheelStateEffector.ReactionWheelStateEffector()
        self.factory.addToSpacecraft("wheels", self.wheels, self.hub)

        self.drag = facetDragDynamicEffector.FacetDragDynamicEffector()
        self.light = facetSRPDynamicEffector.FacetSRPDynamicEffector()
        for area, *vectors, specular, diffuse in given["facets"].tolist():
            normal, arm = column(vectors[:3]), column(vectors[3:])
            self.drag.addFacet(area, float(given["drag"]), normal, arm)
            self.light.addFacet(
                area, np.eye(3), normal, column(np.eye(3)[0]), arm, diffuse, specular
            )
        self.light.setNumFacets(len(given["facets"]))
        self.light.setNumArticulatedFacets(0)
        self.gradient = GravityGradientEffector.GravityGradientEffector()
        self.gradient.addPlanetName(self.earth.planetName)
        # Basilisk does not keep a message alive
        self.rods, self.known = rods(float(given["limit"]))
        self.residual, self.fixed = rods(1.0)
        self.rods.mtbParamsInMsg.subscribeTo(self.known)
        self.residual.mtbParamsInMsg.subscribeTo(self.fixed)
        self.dipole = message("MTBCmdMsg", mtbDipoleCmds=given["dipole"].tolist())
        self.residual.mtbCmdInMsg.subscribeTo(self.dipole)
        self.shadow = eclipse.Eclipse()
        self.shadow.rEqCustom = float(given["earth_radius"])
        self.centre = message("SpicePlanetStateMsg", PositionVector=[0.0] * 3, PlanetName="custom")
        self.shadow.addSpacecraftToModel(self.hub.scStateOutMsg)
        self.shadow.addPlanetToModel(self.centre)
        self.light.sunEclipseInMsg.subscribeTo(self.shadow.eclipseOutMsgs[0])
        self.effectors = (self.drag, self.light, self.gradient, self.rods, self.residual)
        for each in self.effectors:
            self.hub.addDynamicEffector(each)


class Feeder(sysModel.SysModel):
    """Orbit, environment and commands for the step that starts at a tick."""

    def __init__(self, craft, given, step):
        super().__init__()
        self.given, self.step, self.seconds = given, step, 0.0
        self.every = round(float(given["period"]) / step)
        self.messages = {
            "sun": messaging.SpicePlanetStateMsg(),
            "field": messaging.MagneticFieldMsg(),
            "air": messaging.AtmoPropsMsg(),
            "wind": messaging.WindMsg(),
            "torque": messaging.ArrayMotorTorqueMsg(),
            "dipole": messaging.MTBCmdMsg(),
        }
        self.craft = craft
        craft.light.sunInMsg.subscribeTo(self.messages["sun"])
        craft.shadow.sunInMsg.subscribeTo(self.messages["sun"])
        craft.rods.magInMsg.subscribeTo(self.messages["field"])
        craft.residual.magInMsg.subscribeTo(self.messages["field"])
        craft.rods.mtbCmdInMsg.subscribeTo(self.messages["dipole"])
        craft.drag.atmoDensInMsg.subscribeTo(self.messages["air"])
        craft.drag.windVelInMsg.subscribeTo(self.messages["wind"])
        craft.wheels.rwMotorCmdInMsg.subscribeTo(self.messages["torque"])

    def Reset(self, now):  # noqa: N802
        """Nothing is kept."""

    def UpdateState(self, now):  # noqa: N802
        """Write the messages of the next step."""
        tick = round(now * macros.NANO2SEC / self.step)
        given = self.given
        middle = min(2 * tick + 1, len(given["position"]) - 1)
        sample = min(tick // self.every, len(given["torque"]) - 1)
        write = {
            "sun": {"PositionVector": given["sun"][middle].tolist()},
            "field": {"magField_N": given["field"][middle].tolist()},
            "air": {"neutralDensity": float(given["density"][middle])},
            "wind": {"v_air_N": given["wind"][middle].tolist()},
            "torque": {"motorTorque": given["torque"][sample].tolist()},
            "dipole": {"mtbDipoleCmds": given["torque_rods"][sample].tolist()},
        }
        for name, values in write.items():
            payload = type(self.messages[name]).__name__ + "Payload"
            self.messages[name].write(getattr(messaging, payload)(**values), now, self.moduleID)
        states = self.craft.hub.dynManager
        if tick:  # Basilisk has no states before its first step
            states.getStateObject("hubPosition").setState(column(given["position"][2 * tick]))
            states.getStateObject("hubVelocity").setState(column(given["velocity"][2 * tick]))


def simulation_of(step, parts):
    """Simulation of one task."""
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.process = simulation.CreateNewProcess("process")
    simulation.process.addTask(simulation.CreateNewTask("task", macros.sec2nano(step)))
    for part in parts:
        simulation.AddModelToTask("task", part)
    return simulation


def replayed(given, step):
    """`mrp`, `rate` and `wheel_speed` under recorded commands, at every control period.

    Args:
        given: Arrays of GIVEN.npz, with the environment at every half step.
        step: Of the integration, s; classical Runge-Kutta.
    """
    craft = Craft(given)
    feeder = Feeder(craft, given, step)
    # the hub integrates up to a tick; then all take in what holds for the next step
    parts = (craft.hub, feeder, craft.shadow, craft.wheels, *craft.effectors)
    simulation = simulation_of(step, parts)
    between = macros.sec2nano(float(given["period"]))
    body = craft.hub.scStateOutMsg.recorder(between)
    rotors = craft.wheels.rwSpeedOutMsg.recorder(between)
    for each in (body, rotors):
        simulation.AddModelToTask("task", each)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(float(given["duration"])))
    simulation.ExecuteSimulation()
    wheel_speed = rotors.wheelSpeeds[:, : len(craft.factory.rwList)]
    return {"mrp": body.sigma_BN, "rate": body.omega_BN_B, "wheel_speed": wheel_speed}


def closed(given, step):
    """Run with Basilisk's own environment and flight software, in nadir pointing.

    Args:
        given: Arrays of GIVEN.npz.
        step: Of integration and environment, s; the control period is that of the mission.

    Returns:
        Processor times of set-up and run, s, and the pointing error at the end as an MRP.
    """
    made = time.process_time()
    craft = Craft(given)
    air = exponentialAtmosphere.ExponentialAtmosphere()
    simSetPlanetEnvironment.exponentialAtmosphere(air, "earth")
    field = magneticFieldCenteredDipole.MagneticFieldCenteredDipole()
    simSetPlanetEnvironment.centeredDipoleMagField(field, "earth")
    for each in (air, field):
        each.addSpacecraftToModel(craft.hub.scStateOutMsg)
    craft.drag.atmoDensInMsg.subscribeTo(air.envOutMsgs[0])
    for each in (craft.rods, craft.residual):
        each.magInMsg.subscribeTo(field.envOutMsgs[0])
    sun = message("SpicePlanetStateMsg", PositionVector=given["sun"][0].tolist())
    for each in (craft.light, craft.shadow):
        each.sunInMsg.subscribeTo(sun)
    command = message("MTBCmdMsg", mtbDipoleCmds=[0.1, -0.1, 0.1])
    craft.rods.mtbCmdInMsg.subscribeTo(command)

    seen = simpleNav.SimpleNav()
    seen.scStateInMsg.subscribeTo(craft.hub.scStateOutMsg)
    target = hillPoint.hillPoint()
    target.transNavInMsg.subscribeTo(seen.transOutMsg)
    error = attTrackingError.attTrackingError()
    error.attNavInMsg.subscribeTo(seen.attOutMsg)
    error.attRefInMsg.subscribeTo(target.attRefOutMsg)
    law = mrpFeedback.mrpFeedback()
    law.K, law.P, law.Ki, law.controlLawType = 0.02, 0.1, -1.0, 0
    law.guidInMsg.subscribeTo(error.attGuidOutMsg)
    known = message("VehicleConfigMsg", ISCPntB_B=given["inertia"].ravel().tolist())
    law.vehConfigInMsg.subscribeTo(known)
    shared = rwMotorTorque.rwMotorTorque()
    shared.controlAxes_B = np.eye(3).ravel().tolist()
    shared.vehControlInMsg.subscribeTo(law.cmdTorqueOutMsg)
    arranged = craft.factory.getConfigMessage()
    shared.rwParamsInMsg.subscribeTo(arranged)
    craft.wheels.rwMotorCmdInMsg.subscribeTo(shared.rwMotorTorqueOutMsg)

    parts = (craft.hub, air, field, craft.shadow, craft.wheels, *craft.effectors)
    simulation = simulation_of(step, parts)
    control = macros.sec2nano(float(given["period"]))
    simulation.process.addTask(simulation.CreateNewTask("control", control))
    for part in (seen, target, error, law, shared):
        simulation.AddModelToTask("control", part)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(float(given["duration"])))
    begun = time.process_time()
    simulation.ExecuteSimulation()
    ended = time.process_time()
    turned = np.linalg.norm(error.attGuidOutMsg.read().sigma_BR)
    return begun - made, ended - begun, turned


def main():
    """Answer the file of the first argument by that of the second."""
    with np.load(sys.argv[1]) as file:
        given = dict(file)
    found = {"version": __version__, **replayed(given, float(given["step"]))}
    for name in ("setup", "seconds", "turned"):
        found[name] = []
    for step in given["timed"].tolist():
        least = np.min([closed(given, step) for _ in range(TIMED)], axis=0)
        for name, value in zip(("setup", "seconds", "turned"), least, strict=True):
            found[name].append(value)
    np.savez(sys.argv[2], **found)


if __name__ == "__main__":
    main()
