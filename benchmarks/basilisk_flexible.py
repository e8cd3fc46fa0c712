"""A hub with a hinged panel, a slosh mass and a wheel by Basilisk, for tests of flexible modes."""

import numpy as np
from Basilisk.architecture import messaging
from Basilisk.simulation import (
    hingedRigidBodyStateEffector,
    linearSpringMassDamper,
    reactionWheelStateEffector,
    spacecraft,
)
from Basilisk.utilities import SimulationBaseClass, macros, simIncludeRW


def column(values):
    return [[float(x)] for x in values]


def with_panel_and_slosh(craft, start, step, duration):
    """Free motion under a constant motor torque, which is sampled at every step.

    Args:
        craft: `hub_mass`, `hub_centre` (3,), `hub_inertia` (3, 3) about its centre; of the panel
            `panel_mass`, `panel_inertia` (3, 3) about its centre in hub axes, `hinge` (3,),
            `arm` from the hinge to its centre along -x, hinge line y, `panel_stiffness`,
            `panel_drag`; of the slosh `slosh_mass`, `tank` (3,), `line` (3,), `slosh_stiffness`,
            `slosh_drag`; `rotor` about z; SI.
        start: `rate` (3,), rad/s, `angle` of the panel, rad, `shift` of the mass, m, and motor
            torque `torque`, N·m.
        step: of the classical Runge-Kutta method, s.
        duration: s.

    Returns:
        `mrp` (samples, 3), `rate` (samples, 3), rad/s, and `angle` (samples,), rad.
    """
    simulation = SimulationBaseClass.SimBaseClass()
    process = simulation.CreateNewProcess("process")
    process.addTask(simulation.CreateNewTask("task", macros.sec2nano(step)))
    hub = spacecraft.Spacecraft()
    hub.hub.mHub, hub.hub.r_BcB_B = craft["hub_mass"], column(craft["hub_centre"])
    hub.hub.IHubPntBc_B = np.asarray(craft["hub_inertia"]).tolist()
    hub.hub.omega_BN_BInit = column(start["rate"])

    panel = hingedRigidBodyStateEffector.HingedRigidBodyStateEffector()
    panel.mass, panel.d = craft["panel_mass"], craft["arm"]
    panel.IPntS_S = np.asarray(craft["panel_inertia"]).tolist()
    panel.k, panel.c = craft["panel_stiffness"], craft["panel_drag"]
    panel.r_HB_B, panel.dcm_HB = column(craft["hinge"]), np.eye(3).tolist()
    panel.thetaInit, panel.thetaDotInit = start["angle"], 0.0
    tank = linearSpringMassDamper.LinearSpringMassDamper()
    tank.massInit, tank.k, tank.c = (craft[f"slosh_{n}"] for n in ("mass", "stiffness", "drag"))
    tank.r_PB_B, tank.pHat_B = column(craft["tank"]), column(craft["line"])
    tank.rhoInit, tank.rhoDotInit = start["shift"], 0.0
    for part in (panel, tank):
        hub.addStateEffector(part)

    factory = simIncludeRW.rwFactory()
    factory.create("custom", [0.0, 0.0, 1.0], Js=craft["rotor"], Omega=0.0, useMaxTorque=False)
    wheels = reactionWheelStateEffector.ReactionWheelStateEffector()
    factory.addToSpacecraft("wheels", wheels, hub)
    command = messaging.ArrayMotorTorqueMsgPayload(motorTorque=[start["torque"]])
    command = messaging.ArrayMotorTorqueMsg().write(command)
    wheels.rwMotorCmdInMsg.subscribeTo(command)

    for part in (wheels, panel, hub):
        simulation.AddModelToTask("task", part)
    body, angle = hub.scStateOutMsg.recorder(), panel.hingedRigidBodyOutMsg.recorder()
    simulation.AddModelToTask("task", body)
    simulation.AddModelToTask("task", angle)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(duration))
    simulation.ExecuteSimulation()
    return {
        "mrp": np.array(body.sigma_BN),
        "rate": np.array(body.omega_BN_B),
        "angle": np.array(angle.theta),
    }
