"""Environment torques and eclipse at the same states: gyrostat beside Basilisk."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import (
    AerodynamicTorque,
    GravityGradient,
    ResidualDipole,
    SolarPressureTorque,
    Spacecraft,
    Surfaces,
)
from gyrostat.spacecraft.orbit.earth import EARTH, EARTH_RADIUS
from gyrostat.spacecraft.torques import eclipse
from gyrostat.wheel import WheelArray, orthogonal_axes

COUNT = 24
AGREEMENT = 1e-9
"""Largest difference relative to the largest torque. Basilisk moves for nanoseconds."""
INERTIA = np.array([[0.9, 0.1, -0.05], [0.1, 1.1, 0.08], [-0.05, 0.08, 1.3]])
DIPOLE = np.array([0.02, -0.05, 0.1])
DRAG = 2.2
WHEELS = WheelArray(orthogonal_axes(), np.full(3, 1e-9))
SURFACES = Surfaces.joined(
    Surfaces.box([0.2, 0.3, 0.5], [0.02, 0.0, -0.01], specular=0.3, diffuse=0.2),
    Surfaces.panel(0.3, [0.0, 0.3, 1.0], [0.0, 0.5, 0.0], specular=0.1, diffuse=0.6),
)
CENTRE = np.array([0.01, -0.02, 0.03])
BODY = Spacecraft(INERTIA, WHEELS, 10.0, CENTRE, SURFACES)
BASILISK_SUN, BASILISK_FLUX = 6.95e8, 1368.0
"""Basilisk's radius of the Sun, m, and its solar flux, W/m²; ours are those of IAU 2015, B3."""


@pytest.fixture(scope="module")
def case(module_at):
    """Orbit, times and attitudes; the middle third of the times is around a penumbra."""
    pytest.importorskip("Basilisk", reason="found no Basilisk (bsk), of the extra peers")
    orbit = module_at(Path(__file__).with_name("orbit_case.py")).environment()
    times = np.linspace(0.0, 5900.0, COUNT)
    share = jax.jit(jax.vmap(lambda t: eclipse.sunlight(orbit.position(t), orbit.sun(t))))
    entry = np.argmax(np.array(share(np.arange(5900.0))) < 0.5)
    third = COUNT // 3
    times[third : 2 * third] = entry + np.linspace(-8.0, 8.0, third)
    return orbit, times, Rotation.random(COUNT, rng=11)


def column(vector):
    return [[float(x)] for x in vector]


def basilisk(state):
    """Torques and illumination of Basilisk's own modules at one state.

    Args:
        state: position, velocity relative to the atmosphere, sun, field, inertial axes; density;
            attitude as MRP; SI.
    """
    from Basilisk.architecture import messaging
    from Basilisk.simulation import (
        GravityGradientEffector,
        MtbEffector,
        facetDragDynamicEffector,
        facetSRPDynamicEffector,
        spacecraft,
    )
    from Basilisk.simulation import eclipse as shadow
    from Basilisk.utilities import SimulationBaseClass, simIncludeGravBody

    simulation = SimulationBaseClass.SimBaseClass()
    process = simulation.CreateNewProcess("process")
    process.addTask(simulation.CreateNewTask("task", 1))  # ns
    hub = spacecraft.Spacecraft()
    hub.hub.mHub, hub.hub.IHubPntBc_B = 10.0, INERTIA.tolist()
    hub.hub.r_CN_NInit, hub.hub.v_CN_NInit = column(state["position"]), column(state["velocity"])
    hub.hub.sigma_BNInit, hub.hub.omega_BN_BInit = column(state["mrp"]), column(np.zeros(3))
    bodies = simIncludeGravBody.gravBodyFactory()
    earth = bodies.createEarth()
    earth.isCentralBody, earth.mu = True, EARTH
    bodies.addBodiesTo(hub)

    drag = facetDragDynamicEffector.FacetDragDynamicEffector()
    light = facetSRPDynamicEffector.FacetSRPDynamicEffector()
    for area, nx, ny, nz, cx, cy, cz, specular, diffuse in SURFACES.rows().tolist():
        arm = column(np.array([cx, cy, cz]) - CENTRE)
        normal = column([nx, ny, nz])
        drag.addFacet(area, DRAG, normal, arm)
        light.addFacet(area, np.eye(3), normal, column(np.eye(3)[0]), arm, diffuse, specular)
    light.setNumFacets(len(SURFACES.rows()))
    light.setNumArticulatedFacets(0)
    air = messaging.AtmoPropsMsg().write(
        messaging.AtmoPropsMsgPayload(neutralDensity=state["density"])
    )
    drag.atmoDensInMsg.subscribeTo(air)
    sun = messaging.SpicePlanetStateMsg().write(
        messaging.SpicePlanetStateMsgPayload(PositionVector=state["sun"].tolist())
    )
    light.sunInMsg.subscribeTo(sun)

    dark = shadow.Eclipse()
    dark.rEqCustom = EARTH_RADIUS
    planet = messaging.SpicePlanetStateMsg().write(
        messaging.SpicePlanetStateMsgPayload(PositionVector=[0.0] * 3, PlanetName="custom")
    )
    dark.addSpacecraftToModel(hub.scStateOutMsg)
    dark.addPlanetToModel(planet)
    dark.sunInMsg.subscribeTo(sun)
    light.sunEclipseInMsg.subscribeTo(dark.eclipseOutMsgs[0])

    gradient = GravityGradientEffector.GravityGradientEffector()
    gradient.addPlanetName(earth.planetName)

    rods = MtbEffector.MtbEffector()
    command = messaging.MTBCmdMsg().write(messaging.MTBCmdMsgPayload(mtbDipoleCmds=DIPOLE.tolist()))
    field = messaging.MagneticFieldMsg().write(
        messaging.MagneticFieldMsgPayload(magField_N=state["field"].tolist())
    )
    axes = messaging.MTBArrayConfigMsg().write(
        messaging.MTBArrayConfigMsgPayload(
            numMTB=3, GtMatrix_B=np.eye(3).ravel().tolist(), maxMtbDipoles=[1.0] * 3
        )
    )
    rods.mtbCmdInMsg.subscribeTo(command)
    rods.magInMsg.subscribeTo(field)
    rods.mtbParamsInMsg.subscribeTo(axes)

    effectors = {"drag": drag, "light": light, "gradient": gradient, "dipole": rods}
    for each in effectors.values():
        hub.addDynamicEffector(each)
    for each in (*effectors.values(), hub, dark):
        simulation.AddModelToTask("task", each)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(3)
    simulation.ExecuteSimulation()
    torques = {
        name: np.array(each.torqueExternalPntB_B).ravel() for name, each in effectors.items()
    }
    return {**torques, "share": dark.eclipseOutMsgs[0].read().shadowFactor}


@pytest.fixture(scope="module")
def theirs(case):
    """Basilisk's results at all states, name -> (COUNT, ...)."""
    orbit, times, attitudes = case
    drag = AerodynamicTorque(orbit, DRAG)
    given = {
        "position": orbit.position,
        "velocity": drag.relative_velocity,
        "sun": orbit.sun,
        "field": orbit.field,
        "density": orbit.density,
    }
    states = {name: np.array(jax.vmap(each)(times)) for name, each in given.items()}
    states["density"] = states["density"].tolist()
    states["mrp"] = attitudes.as_mrp()
    found = [basilisk({name: each[k] for name, each in states.items()}) for k in range(COUNT)]
    return {name: np.array([each[name] for each in found]) for name in found[0]}


def ours(case, torque):
    _, times, attitudes = case
    quaternions = jnp.asarray(attitudes.as_quat(scalar_first=True))
    return np.array(jax.vmap(torque, (None, 0, 0))(BODY, quaternions, times))


def difference(found, expected):
    """Largest difference relative to the largest value."""
    return np.max(np.abs(found - expected)) / np.max(np.abs(expected))


@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("gradient", GravityGradient),
        ("dipole", lambda orbit: ResidualDipole(orbit, DIPOLE)),
        ("drag", lambda orbit: AerodynamicTorque(orbit, DRAG)),
    ],
)
def test_torques_are_those_of_basilisk(case, theirs, name, make):
    assert difference(ours(case, make(case[0])), theirs[name]) < AGREEMENT


def test_sunlight_and_its_torque_are_those_of_basilisk(case, theirs, monkeypatch):
    orbit, times, _ = case
    monkeypatch.setattr(eclipse, "SUN_RADIUS", BASILISK_SUN)
    share = np.array(jax.vmap(lambda t: eclipse.sunlight(orbit.position(t), orbit.sun(t)))(times))
    assert np.count_nonzero((share > 0.0) & (share < 1.0)) >= 3
    torque = ours(case, SolarPressureTorque(orbit, BASILISK_FLUX / 1361.0))
    assert difference(share, theirs["share"]) < AGREEMENT
    assert difference(torque, theirs["light"]) < AGREEMENT


def test_a_ground_target_is_where_basilisk_has_it(case):
    """Position, and distance from the spacecraft; geodetic coordinates by pyerfa.

    Basilisk's own conversion is for a sphere.
    """
    erfa = pytest.importorskip("erfa", reason="the libraries of the extra orbit are not installed")
    from Basilisk.architecture import messaging
    from Basilisk.simulation import groundLocation
    from Basilisk.utilities import SimulationBaseClass

    orbit, times, _ = case
    latitude, longitude, height = np.radians(48.1), np.radians(11.6), 519.0
    for time in times:
        simulation = SimulationBaseClass.SimBaseClass()
        simulation.CreateNewProcess("process").addTask(simulation.CreateNewTask("task", 1))
        turned = Rotation.from_quat(np.asarray(orbit.earth(time)), scalar_first=True)
        planet = messaging.SpicePlanetStateMsg().write(
            messaging.SpicePlanetStateMsgPayload(J20002Pfix=turned.as_matrix().T.tolist())
        )
        place = np.asarray(orbit.position(time))
        craft = messaging.SCStatesMsg().write(
            messaging.SCStatesMsgPayload(r_BN_N=place.tolist(), v_BN_N=[0.0] * 3)
        )
        location = groundLocation.GroundLocation()
        location.specifyLocationPCPF(column(erfa.gd2gc(1, longitude, latitude, height)))
        location.planetInMsg.subscribeTo(planet)
        location.addSpacecraftToModel(craft)
        simulation.AddModelToTask("task", location)
        simulation.InitializeSimulation()
        simulation.TotalSim.SingleStepProcesses()
        ground = np.asarray(orbit.ground(latitude, longitude, height, time))
        theirs = np.ravel(location.currentGroundStateOutMsg.read().r_LN_N)
        np.testing.assert_allclose(ground, theirs, rtol=0.0, atol=1e-2)
        distance = location.accessOutMsgs[0].read().slantRange
        assert np.linalg.norm(ground - place) == pytest.approx(distance, rel=1e-9)
