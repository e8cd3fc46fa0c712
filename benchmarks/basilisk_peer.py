"""Basilisk (package bsk) as a peer in an interpreter of its own: a line of JSON asks, one answers.

    python benchmarks/basilisk_peer.py

It needs Basilisk and nothing of gyrostat, since Basilisk bounds the versions of packages that
gyrostat uses too. `three_wheels.py` and `docs/make_wheels_that_stop.py` talk to it. The first line
that it writes says the version. A question names one of the functions below, `what`, its first
argument for every run, `runs`, and its others, `given`; the answer has what each run found, and the
seconds and the processor's seconds that worker processes took, which had been started and had
Basilisk loaded before.
"""

import functools
import json
import multiprocessing
import sys
import time

import numpy as np
from Basilisk import __version__
from Basilisk.architecture import messaging
from Basilisk.fswAlgorithms import attTrackingError, inertial3D, mrpFeedback, rwMotorTorque
from Basilisk.simulation import (
    MtbEffector,
    extForceTorque,
    reactionWheelStateEffector,
    simpleNav,
    spacecraft,
)
from Basilisk.utilities import SimulationBaseClass, macros, simIncludeRW

WORKERS = 2


def three_wheels(run, craft, step, duration, every=0.0):
    """Inertial pointing by three orthogonal wheels, with Basilisk's own modules.

    Args:
        run: `attitude` (4,) unit quaternion, scalar first, `rate` (3,), rad/s, `wheel_speed` (3,),
            rad/s, `friction` (3,) factors on the dry friction of each wheel; 0: no friction at all.
        craft: `inertia` (3, 3) with rotors locked, `rotor`, `viscous`, `coulomb`, `static`,
            `stribeck_speed`, `torque` (3,) of disturbance, `proportional`, `derivative`, SI.
        step: of integration and control, s; classical Runge-Kutta, Basilisk's default.
        duration: s.
        every: time between samples, s; 0: only the last.

    Returns:
        `mrp`, `rate`, rad/s, and `wheel_speed`, rad/s, at each sample.
    """
    simulation = SimulationBaseClass.SimBaseClass()
    process = simulation.CreateNewProcess("process")
    process.addTask(simulation.CreateNewTask("task", macros.sec2nano(step)))

    hub = spacecraft.Spacecraft()
    hub.hub.mHub, hub.hub.IHubPntBc_B = 100.0, craft["inertia"]
    scalar, *vector = run["attitude"]
    hub.hub.sigma_BNInit = [[x / (1.0 + scalar)] for x in vector]
    hub.hub.omega_BN_BInit = [[x] for x in run["rate"]]
    disturbance = extForceTorque.ExtForceTorque()
    disturbance.extTorquePntB_B = [[x] for x in craft["torque"]]
    hub.addDynamicEffector(disturbance)

    factory = simIncludeRW.rwFactory()
    for axis, speed, factor in zip(np.eye(3), run["wheel_speed"], run["friction"], strict=True):
        friction = {
            "cViscous": craft["viscous"],
            "fCoulomb": factor * craft["coulomb"],
            "fStatic": factor * craft["static"],
            "betaStatic": craft["stribeck_speed"] / 2.0**0.5,
        }
        named = {"useRWfriction": factor > 0.0, **(friction if factor > 0.0 else {})}
        made = {"Js": craft["rotor"], "Omega": speed / macros.RPM, "useMaxTorque": False, **named}
        factory.create("custom", axis, **made)
    wheels = reactionWheelStateEffector.ReactionWheelStateEffector()
    factory.addToSpacecraft("wheels", wheels, hub)

    seen = simpleNav.SimpleNav()
    seen.scStateInMsg.subscribeTo(hub.scStateOutMsg)
    target = inertial3D.inertial3D()
    target.sigma_R0N = [0.0, 0.0, 0.0]
    error = attTrackingError.attTrackingError()
    error.attNavInMsg.subscribeTo(seen.attOutMsg)
    error.attRefInMsg.subscribeTo(target.attRefOutMsg)
    law = mrpFeedback.mrpFeedback()
    law.K, law.P = craft["proportional"], craft["derivative"]
    law.Ki, law.controlLawType = -1.0, 0  # no integral; no feed-forward at a target that rests
    law.guidInMsg.subscribeTo(error.attGuidOutMsg)
    inertia = messaging.VehicleConfigMsgPayload(ISCPntB_B=np.ravel(craft["inertia"]).tolist())
    inertia = messaging.VehicleConfigMsg().write(inertia)
    law.vehConfigInMsg.subscribeTo(inertia)
    shared = rwMotorTorque.rwMotorTorque()
    shared.controlAxes_B = np.eye(3).ravel().tolist()
    shared.vehControlInMsg.subscribeTo(law.cmdTorqueOutMsg)
    known = factory.getConfigMessage()
    shared.rwParamsInMsg.subscribeTo(known)
    wheels.rwMotorCmdInMsg.subscribeTo(shared.rwMotorTorqueOutMsg)

    # a command acts from the sample that it is made from: the wheels take it in after the law
    for part in (hub, disturbance, seen, target, error, law, shared, wheels):
        simulation.AddModelToTask("task", part)
    between = macros.sec2nano(every or duration)
    body, rotors = (m.recorder(between) for m in (hub.scStateOutMsg, wheels.rwSpeedOutMsg))
    simulation.AddModelToTask("task", body)
    simulation.AddModelToTask("task", rotors)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(duration))
    simulation.ExecuteSimulation()
    return {
        "mrp": body.sigma_BN.tolist(),
        "rate": body.omega_BN_B.tolist(),
        "wheel_speed": rotors.wheelSpeeds[:, :3].tolist(),
    }


def coast(run, step, duration, every):
    """Speeds, rad/s, of a wheel that nothing drives, on a hub that cannot turn.

    Args:
        run: `kind` and `settings` of Basilisk's `rwFactory.create`, and `speed` at first, rad/s.
        step: of the integration, s.
        duration: s.
        every: time between samples, s.
    """
    simulation = SimulationBaseClass.SimBaseClass()
    process = simulation.CreateNewProcess("process")
    process.addTask(simulation.CreateNewTask("task", macros.sec2nano(step)))
    hub = spacecraft.Spacecraft()
    hub.hub.mHub, hub.hub.IHubPntBc_B = 1e6, (1e9 * np.eye(3)).tolist()
    factory = simIncludeRW.rwFactory()
    settings = {"Omega": run["speed"] / macros.RPM, "useRWfriction": True, **run["settings"]}
    factory.create(run["kind"], [0.0, 0.0, 1.0], **settings)
    wheels = reactionWheelStateEffector.ReactionWheelStateEffector()
    factory.addToSpacecraft("wheels", wheels, hub)
    simulation.AddModelToTask("task", hub)
    simulation.AddModelToTask("task", wheels)
    speeds = wheels.rwSpeedOutMsg.recorder(macros.sec2nano(every))
    simulation.AddModelToTask("task", speeds)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(duration))
    simulation.ExecuteSimulation()
    return speeds.wheelSpeeds[:, 0].tolist()


def torque_rods(run, axes, limit, field, step, duration, every):
    """Motion of a rigid body, with torque rods of constant command in a constant field.

    Args:
        run: `inertia` (3, 3), kg·m², and `dipole` (rods,), the commands, A·m².
        axes: of the rods, (3, rods), unit vectors.
        limit: of each rod, (rods,), A·m².
        field: in inertial axes, (3,), T.
        step: of integration, s.
        duration: s.
        every: time between samples, s.

    Returns:
        `mrp` and `rate`, rad/s, at each sample, from rest.
    """
    simulation = SimulationBaseClass.SimBaseClass()
    process = simulation.CreateNewProcess("process")
    process.addTask(simulation.CreateNewTask("task", macros.sec2nano(step)))
    hub = spacecraft.Spacecraft()
    hub.hub.mHub, hub.hub.IHubPntBc_B = 100.0, run["inertia"]
    rods = MtbEffector.MtbEffector()
    payload = messaging.MTBArrayConfigMsgPayload()
    payload.numMTB = len(limit)
    payload.GtMatrix_B, payload.maxMtbDipoles = np.ravel(axes).tolist(), limit
    known = messaging.MTBArrayConfigMsg().write(payload)
    commanded = messaging.MTBCmdMsgPayload()
    commanded.mtbDipoleCmds = run["dipole"]
    command = messaging.MTBCmdMsg().write(commanded)
    around = messaging.MagneticFieldMsgPayload(magField_N=field)
    around = messaging.MagneticFieldMsg().write(around)
    rods.mtbParamsInMsg.subscribeTo(known)
    rods.mtbCmdInMsg.subscribeTo(command)
    rods.magInMsg.subscribeTo(around)
    hub.addDynamicEffector(rods)
    simulation.AddModelToTask("task", hub)
    simulation.AddModelToTask("task", rods)
    body = hub.scStateOutMsg.recorder(macros.sec2nano(every))
    simulation.AddModelToTask("task", body)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(duration))
    simulation.ExecuteSimulation()
    return {"mrp": body.sigma_BN.tolist(), "rate": body.omega_BN_B.tolist()}


def timed(work, run):
    """Processor's seconds, and what a run found."""
    begun = time.process_time()
    found = work(run)
    return time.process_time() - begun, found


def main():
    """Answer the lines of standard input."""
    # Basilisk prints: answers have a stream of their own
    answers, sys.stdout = sys.stdout, sys.stderr
    with multiprocessing.Pool(WORKERS) as pool:
        print(json.dumps({"version": __version__}), file=answers, flush=True)
        for line in sys.stdin:
            asked = json.loads(line)
            work = functools.partial(globals()[asked["what"]], **asked["given"])
            begun = time.perf_counter()
            each = pool.map(functools.partial(timed, work), asked["runs"], chunksize=1)
            seconds = time.perf_counter() - begun
            processor, found = zip(*each, strict=True)
            answer = {"seconds": [seconds, sum(processor)], "found": found}
            print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()
