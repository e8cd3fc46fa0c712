"""Torques along an orbit against closed forms, momentum balances and point masses."""

from pathlib import Path

import equinox as eqx
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.codegen.simd import compiler
from gyrostat.codegen.simd.batch import lanes
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import (
    AerodynamicTorque,
    CircularOrbit,
    GravityGradient,
    ResidualDipole,
    SolarPressureTorque,
    Spacecraft,
    Surfaces,
)
from gyrostat.spacecraft.orbit.earth import EARTH
from gyrostat.spacecraft.torques.eclipse import sunlight
from gyrostat.wheel import WheelArray, orthogonal_axes
from gyrostat.wheel.friction import ViscousCoulomb

ATTITUDES = Rotation.random(12, rng=3)
TIMES = np.linspace(0.0, 5900.0, 12)
FLAT = np.array([0.0, 0.0, 1.0])
WHEELS = WheelArray(
    orthogonal_axes(), np.full(3, 2e-5), friction=ViscousCoulomb(np.full(3, 1e-6), np.full(3, 1e-5))
)
INERTIA = np.array([[0.9, 0.1, -0.05], [0.1, 1.1, 0.08], [-0.05, 0.08, 1.3]])


@pytest.fixture(scope="module")
def case(module_at):
    return module_at(Path(__file__).with_name("orbit_case.py"))


@pytest.fixture(scope="module")
def orbit(case):
    return case.environment()


def craft(surfaces=None, centre_of_mass=(0.0, 0.0, 0.0)):
    return Spacecraft(INERTIA, WHEELS, 10.0, np.array(centre_of_mass), surfaces)


@eqx.filter_jit
def _along(torque, spacecraft, attitudes, times):
    return jax.vmap(torque, (None, 0, 0))(spacecraft, attitudes, times)


def along(torque, spacecraft, attitudes=ATTITUDES, times=TIMES):
    """Torques at attitudes and times, (rows, 3)."""
    given = torque, spacecraft, attitudes.as_quat(scalar_first=True), times
    return np.array(_along(*jax.tree.map(lambda x: jnp.asarray(x, dtype=float), given)))


_rows = eqx.filter_jit(lambda function, *given: jax.vmap(function)(*given))


def rows(function, *given):
    """Values of a function of a part at several times; the part is an argument of the program."""
    return np.array(_rows(function, *given))


def seen(vectors, attitudes=ATTITUDES):
    """Inertial vectors in body axes."""
    return attitudes.inv().apply(np.array(vectors))


def forces(torque, surfaces, **given):
    """Total force: the torque about a centre of mass c is less by c x F; body axes."""
    origin, *moved = (
        along(torque, craft(surfaces, centre), **given) for centre in (np.zeros(3), *np.eye(3))
    )
    x, y, _ = (each - origin for each in moved)  # -e x F
    return np.stack([y[:, 2], -x[:, 2], x[:, 1]], axis=1)


def test_the_pull_on_point_masses_is_the_gravity_gradient(orbit):
    """Six masses at 10 m: the torque of their weights about the centre of mass."""
    places = 10.0 * np.concatenate([np.eye(3) * [1.0, 1.2, 0.7], np.eye(3) * [-1.0, -1.2, -0.7]])
    inertia = np.sum(places**2) * np.eye(3) - places.T @ places
    rotors = orthogonal_axes() * 2e-5 @ orthogonal_axes().T
    body = eqx.tree_at(lambda each: each.inertia, craft(), inertia - rotors)
    found = along(GravityGradient(orbit), body)
    centre = seen(rows(orbit.position, TIMES))
    at = centre[:, None] + places
    pull = -EARTH * at / np.linalg.norm(at, axis=-1, keepdims=True) ** 3
    expected = np.sum(np.cross(places, pull), axis=1)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6 * np.max(np.abs(expected)))


def test_on_a_circle_the_tables_give_the_torque_of_the_circular_orbit(case):
    """Rows of a circular orbit; between rows, the splines are exact to about (n step)^4 / 100."""
    circle = CircularOrbit(0.0011, inclination=0.7, ascending_node=0.3, latitude=-0.2)
    place = rows(circle.zenith, case.ROWS) * np.cbrt(EARTH / 0.0011**2)
    orbit = case.environment(case.samples()._replace(position=place))
    theirs, ours = (along(GravityGradient(each), craft()) for each in (circle, orbit))
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=3e-8 * np.max(np.abs(theirs)))


def test_a_principal_axis_at_the_zenith_is_in_equilibrium(orbit):
    axes = np.linalg.eigh(INERTIA + 2e-5 * np.eye(3))[1].T
    zenith = rows(orbit.zenith, TIMES)[:3]
    turned = [
        Rotation.align_vectors([up], [axis])[0] for up, axis in zip(zenith, axes, strict=True)
    ]
    turned = Rotation.concatenate([*turned, ATTITUDES[3:]])  # as many as elsewhere
    found = along(GravityGradient(orbit), craft(), turned)
    np.testing.assert_allclose(found[:3], 0.0, atol=1e-20)


def test_a_dipole_is_turned_down_the_slope_of_its_energy(orbit):
    """Energy -m·B; the torque is its decrease with a rotation of the body."""
    dipole = np.array([0.02, -0.05, 0.1])
    field = rows(orbit.field, TIMES)
    found = along(ResidualDipole(orbit, dipole), craft())
    assert np.max(np.abs(np.sum(found * seen(field), axis=1))) < 1e-20
    step = 1e-3

    def energy(turn):
        return -seen(field, ATTITUDES * Rotation.from_rotvec(turn)) @ dipole

    slope = np.stack([energy(-step * e) - energy(step * e) for e in np.eye(3)], axis=1)
    np.testing.assert_allclose(slope / (2.0 * step), found, rtol=0.0, atol=1e-12)
    assert np.min(np.linalg.norm(found, axis=1)) > 1e-7


BOX = Surfaces.box([0.2, 0.3, 0.5], specular=0.3, diffuse=0.2)


def test_a_face_in_the_air_flow(orbit):
    """Head-on: arm times 1/2 rho C A v²; the box about its centre: none at any attitude."""
    drag = AerodynamicTorque(orbit, 2.2, 0.7)
    velocity = rows(drag.relative_velocity, TIMES)
    turned = Rotation.concatenate(
        [Rotation.align_vectors([each], [[1.0, 0.0, 0.0]])[0] for each in velocity]
    )
    density = rows(orbit.density, TIMES)
    force = 0.5 * 0.7 * density * 2.2 * 0.15 * np.sum(velocity**2, axis=1)
    found = along(drag, craft(BOX, [0.01, 0.02, -0.03]), turned)
    expected = force[:, None] * np.cross([0.0, 0.02, -0.03], [1.0, 0.0, 0.0])
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-18)
    scale = np.max(force)
    np.testing.assert_allclose(along(drag, craft(BOX)), 0.0, atol=1e-16 * scale)
    side = forces(drag, BOX)
    wind = seen(velocity)
    area = np.abs(wind) @ [0.15, 0.1, 0.06]
    expected = -0.5 * 0.7 * 2.2 * (density * area)[:, None] * wind
    np.testing.assert_allclose(side, expected, rtol=1e-9, atol=1e-12 * scale)


def test_the_atmosphere_turns_with_the_earth(orbit):
    """The wind is that of a point fixed to the Earth, by differences of its position."""
    drag, step = AerodynamicTorque(orbit, 2.2), 5.0

    def earth(times):
        return Rotation.from_quat(rows(orbit.earth, times), scalar_first=True)

    def fixed(later):
        return (earth(later) * earth(TIMES).inv()).apply(rows(orbit.position, TIMES))

    wind = (fixed(TIMES + step) - fixed(TIMES - step)) / (2.0 * step)
    found = rows(orbit.velocity, TIMES) - rows(drag.relative_velocity, TIMES)
    np.testing.assert_allclose(found[2:-2], wind[2:-2], rtol=0.0, atol=1e-3)
    assert np.all(np.linalg.norm(found, axis=1)[2:-2] > 250.0)


def plate(specular, diffuse):
    return Surfaces.facet(2.0, FLAT, [0.0, 0.0, 0.0], specular=specular, diffuse=diffuse)


def light(orbit):
    """Direction to the Sun in body axes and pressure, N/m²."""
    position, sun = (rows(each, TIMES) for each in (orbit.position, orbit.sun))
    distance = np.linalg.norm(sun - position, axis=1)
    share = rows(sunlight, position, sun)
    pressure = 1361.0 / 299792458.0 * (149597870700.0 / distance) ** 2 * share
    return seen(sun - position) / distance[:, None], pressure


@pytest.mark.parametrize(("specular", "diffuse"), [(0, 0), (1, 0), (0, 1), (0.3, 0.5)])
def test_light_leaves_its_momentum(orbit, specular, diffuse):
    """Photons arrive along -s and leave along the mirrored direction or by Lambert's law."""
    direction, pressure = light(orbit)
    assert np.any(pressure == 0.0)  # in the umbra
    cosine = np.clip(direction @ FLAT, 0.0, None)
    assert np.count_nonzero(cosine * pressure) >= 3
    mirrored = 2.0 * cosine[:, None] * FLAT - direction
    angle = (np.arange(2000) + 0.5) / 2000 * np.pi / 2
    flux = np.cos(angle) * np.sin(angle)
    lambert = np.sum(flux * np.cos(angle)) / np.sum(flux) * FLAT
    momentum = direction + specular * mirrored + diffuse * lambert
    expected = -(1.5 * 2.0 * pressure * cosine)[:, None] * momentum
    found = forces(SolarPressureTorque(orbit, 1.5), plate(specular, diffuse))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6 * np.max(np.abs(expected)))


def test_a_mirror_is_pushed_along_its_normal(orbit):
    direction, pressure = light(orbit)
    cosine = np.clip(direction @ FLAT, 0.0, None)
    found = along(SolarPressureTorque(orbit), craft(plate(1, 0), [0.0, -0.1, 0.0]))
    expected = np.outer(2.0 * pressure * 2.0 * cosine**2, np.cross([0.0, 0.1, 0.0], -FLAT))
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-20)


def test_a_box_is_not_turned_by_light_about_its_centre(orbit):
    found = along(SolarPressureTorque(orbit), craft(BOX))
    np.testing.assert_allclose(found, 0.0, atol=1e-20)
    moved = along(SolarPressureTorque(orbit), craft(BOX, [0.01, 0.0, 0.0]))
    assert np.max(np.abs(moved)) > 1e-9


def all_torques(orbit, attitude, time):
    """All torques on a body with a panel, and their derivatives along a motion, (4, 2, 3)."""
    wing = Surfaces.panel(0.3, [0.0, 0.3, 1.0], [0.0, 0.5, 0.0], specular=0.1)
    body = craft(wing, [0.01, 0.0, 0.02])
    torques = (
        GravityGradient(orbit),
        ResidualDipole(orbit, np.array([0.02, -0.05, 0.1])),
        AerodynamicTorque(orbit, 2.2),
        SolarPressureTorque(orbit),
    )
    motion = (0.01 * attitude[::-1] * jnp.array([-1.0, 1.0, -1.0, 1.0]), jnp.ones(()))

    def each(q, t):
        return jnp.stack([torque(body, q, t) for torque in torques])

    return jnp.stack(jax.jvp(each, (attitude, time), motion), axis=1)


@pytest.mark.skipif(compiler() is None, reason="needs a C compiler")
def test_the_native_engine_computes_the_same_torques_and_derivatives(case):
    """From sunlight through the penumbra into the umbra; the tables end after 21 s."""
    share = jax.jit(jax.vmap(lambda orbit, t: sunlight(orbit.position(t), orbit.sun(t)), (None, 0)))
    full = case.environment()
    entry = float(np.argmax(np.array(share(full, np.arange(5900.0))) < 0.5))
    given = case.environment(case.samples(entry - 10.0 + 7.0 * np.arange(4)), 7.0)
    orbit = jax.tree.map(lambda x: jnp.asarray(x, dtype=float), given)
    times = np.concatenate([np.linspace(0.0, 20.5, 42), [40.0]])
    shares = np.array(share(orbit, times))
    assert np.count_nonzero((shares > 0.0) & (shares < 1.0)) >= 3
    attitudes = Rotation.random(len(times), rng=5).as_quat(scalar_first=True)
    theirs = np.array(jax.jit(jax.vmap(all_torques, (None, 0, 0)))(orbit, attitudes, times))
    ours = lanes(all_torques, (False, True, True), (orbit, attitudes, times))
    found = np.array(ours(orbit, attitudes, times))
    scale = np.max(np.abs(theirs), axis=(0, 3), keepdims=True)
    np.testing.assert_allclose(found / scale, theirs / scale, rtol=0.0, atol=1e-12)
    assert np.all(scale > 1e-12)


def test_at_kinks_derivatives_are_those_of_the_side_without_force(case):
    """A plate with its edge to the flow, along y, and to the light, along x; it turns to both."""
    still = case.samples(case.ROWS[:4])._replace(
        position=np.tile([7e6, 0.0, 0.0], (4, 1)),
        velocity=np.tile([0.0, 7500.0, 0.0], (4, 1)),
        sun=np.tile([1.5e11, 0.0, 0.0], (4, 1)),
        earth=np.tile([1.0, 0.0, 0.0, 0.0], (4, 1)),
    )
    orbit, body = case.environment(still), craft(plate(0.3, 0.3), [0.1, 0.1, 0.0])

    @eqx.filter_jit
    def with_slope(torque, attitude, turn):
        return jnp.stack(jax.jvp(lambda q: torque(body, q, 0.0), (attitude,), (turn,)))

    level = np.array([1.0, 0.0, 0.0, 0.0])
    for torque, axis in ((AerodynamicTorque(orbit, 2.2), 1), (SolarPressureTorque(orbit), 2)):
        turn = np.eye(4)[axis]
        np.testing.assert_array_equal(with_slope(torque, level, turn), 0.0)
        tipped = [with_slope(torque, level + tip * turn, turn)[0] for tip in (-1e-3, 1e-3)]
        assert sorted(np.any(each != 0.0) for each in np.array(tipped)) == [False, True]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda orbit: ResidualDipole(orbit, [0.0, np.nan, 0.0]), "residual dipole: found"),
        (lambda orbit: AerodynamicTorque(orbit, -2.0), "drag coefficient: found -2"),
        (lambda orbit: AerodynamicTorque(orbit, 2.0, np.nan), "scale of the air density: found"),
        (lambda orbit: SolarPressureTorque(orbit, -1.0), "scale of the solar radiation pressure"),
    ],
)
def test_impossible_parameters_are_refused(orbit, make, message):
    with pytest.raises(InputError, match=message):
        make(orbit).check()


def test_without_surfaces_the_torque_says_so(orbit):
    for torque in (AerodynamicTorque(orbit, 2.2), SolarPressureTorque(orbit)):
        with pytest.raises(InputError, match="torque: found a spacecraft without surfaces"):
            torque(craft(), jnp.array([1.0, 0.0, 0.0, 0.0]), 0.0)
