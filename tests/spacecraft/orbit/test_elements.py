"""Orbits from elements against Kepler's laws, secular rates and conserved quantities."""

import erfa
import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.spacecraft.orbit.earth import EARTH, EARTH_J2, EARTH_RADIUS
from gyrostat.spacecraft.orbit.elements import (
    CircularElements,
    KeplerElements,
    gravity,
    propagated,
)
from gyrostat.spacecraft.orbit.time_scales import Epoch

EPOCH = Epoch.of("2026-11-22T10:00:00Z")
POLE = np.array([0.0, 0.0, 1.0])


def drawn(seed):
    rng = np.random.default_rng(seed)
    eccentricity = rng.choice([0.0, rng.uniform(0.0, 0.9), 0.97])
    return KeplerElements(
        rng.uniform(6.6e6, 4e7) / (1.0 - eccentricity), eccentricity, *rng.uniform(0.1, 3.0, 4)
    )


@pytest.mark.parametrize("seed", range(8))
def test_two_bodies_keep_the_elements(seed):
    """Angular momentum, eccentricity vector and energy give back the elements at every time."""
    elements = drawn(seed)
    times = np.linspace(0.0, 2.3 * elements.period, 60)
    position, velocity = elements.two_bodies(times)
    distance = np.linalg.norm(position, axis=1)
    energy = 0.5 * np.sum(velocity**2, axis=1) - EARTH / distance
    np.testing.assert_allclose(-0.5 * EARTH / energy, elements.semi_major_axis, rtol=1e-11)
    momentum = np.cross(position, velocity)
    tilt, node = elements.inclination, elements.ascending_node
    normal = [np.sin(tilt) * np.sin(node), -np.sin(tilt) * np.cos(node), np.cos(tilt)]
    parameter = elements.semi_major_axis * (1.0 - elements.eccentricity**2)
    expected = np.sqrt(EARTH * parameter) * np.array(normal)
    np.testing.assert_allclose(momentum, np.tile(expected, (60, 1)), atol=1e-10 * parameter * 7e3)
    perigee = np.cross(velocity, momentum) / EARTH - position / distance[:, None]
    ahead = [np.cos(node), np.sin(node), 0.0]
    across = np.cross(normal, ahead)
    toward = np.cos(elements.perigee) * np.array(ahead) + np.sin(elements.perigee) * across
    np.testing.assert_allclose(perigee, np.tile(elements.eccentricity * toward, (60, 1)), atol=1e-9)
    # at the epoch, the true anomaly; later, Kepler's second law by the derivative of the position
    start = position[0] / distance[0]
    angle = np.arctan2(start @ np.cross(normal, toward), start @ toward)
    assert angle == pytest.approx(elements.true_anomaly, abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_integration_without_oblateness_is_the_motion_of_two_bodies(seed):
    elements = drawn(seed + 20)
    end = 3.0 * elements.period
    states = propagated(elements.two_bodies(np.zeros(1)), POLE, end, elements.period / 50.0, j2=0.0)
    times = np.linspace(0.0, end, 333)
    found, expected = states(times), elements.two_bodies(times)
    for near, true in zip(found, expected, strict=True):
        error = np.linalg.norm(near - true, axis=1) / np.max(np.linalg.norm(true, axis=1))
        assert np.max(error) < 1e-8


def test_gravity_is_the_gradient_of_its_potential():
    rng = np.random.default_rng(5)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    position = 7e6 * np.array([0.5, -0.6, 0.62])
    step = 50.0
    slope = [
        (potential(position + step * e, axis) - potential(position - step * e, axis)) / (2.0 * step)
        for e in np.eye(3)
    ]
    np.testing.assert_allclose(gravity(position, axis), slope, rtol=1e-9)


def potential(position, axis):
    distance = np.linalg.norm(position, axis=-1)
    sine = position @ axis / distance
    oblate = EARTH_J2 * (EARTH_RADIUS / distance) ** 2 * (1.5 * sine**2 - 0.5)
    return EARTH / distance * (1.0 - oblate)


def test_energy_and_momentum_about_the_intermediate_pole_are_conserved():
    elements = KeplerElements(7.2e6, 0.05, 1.2, 0.7, 0.3, 2.0)
    times = np.linspace(0.0, 86400.0, 1001)
    position, velocity = elements.trajectory(EPOCH, 86400.0).states(times)
    pole = erfa.c2i06a(*EPOCH.tt(np.zeros(1)))[0, 2]
    energy = 0.5 * np.sum(velocity**2, axis=1) - potential(position, pole)
    momentum = np.cross(position, velocity)
    assert np.ptp(energy) / abs(energy[0]) < 2e-11
    along = momentum @ pole
    assert np.ptp(along) / abs(along[0]) < 2e-11
    # not about the pole of the GCRS, 0.15 degrees away
    assert np.ptp(momentum[:, 2]) / abs(along[0]) > 1e-6


@pytest.mark.parametrize("inclination", [0.5, 1.1, 1.7])
def test_node_and_perigee_turn_at_the_secular_rates(inclination):
    # R. H. Battin, section 10.5: -1.5 n J2 (R/p)^2 cos i, and 0.75 n J2 (R/p)^2 (5 cos^2 i - 1)
    # with a thirtieth of the Earth's oblateness, whose second order is then below 2e-4 of the first
    j2 = EARTH_J2 / 30.0
    elements = KeplerElements(7.4e6, 0.1, inclination, 1.0, 0.5)
    turns = 12
    end = turns * elements.period
    states = propagated(elements.two_bodies(np.zeros(1)), POLE, end, elements.period / 50.0, j2)
    times = np.linspace(0.0, end, 200 * turns, endpoint=False)
    position, velocity = states(times)
    momentum = np.cross(position, velocity)
    distance = np.linalg.norm(position, axis=1)[:, None]
    toward = np.cross(velocity, momentum) / EARTH - position / distance
    node = np.unwrap(np.arctan2(momentum[:, 0], -momentum[:, 1]))
    ahead = np.stack([np.cos(node), np.sin(node), np.zeros_like(node)], axis=1)
    across = np.cross(momentum, ahead) / np.linalg.norm(momentum, axis=1)[:, None]
    perigee = np.unwrap(np.arctan2(np.sum(toward * across, axis=1), np.sum(toward * ahead, axis=1)))
    tilt = np.mean(np.arccos(momentum[:, 2] / np.linalg.norm(momentum, axis=1)))
    parameter = np.mean(np.sum(momentum**2, axis=1)) / EARTH
    energy = 0.5 * np.sum(velocity**2, axis=1) - EARTH / distance[:, 0]
    rate = np.sqrt(EARTH / np.mean(-0.5 * EARTH / energy) ** 3)
    scale = rate * j2 * (EARTH_RADIUS / parameter) ** 2
    means = [np.mean(angle.reshape(turns, -1), axis=1) for angle in (node, perigee)]
    found = [np.polyfit(np.arange(turns) * elements.period, mean, 1)[0] for mean in means]
    expected = [-1.5 * scale * np.cos(tilt), 0.75 * scale * (5.0 * np.cos(tilt) ** 2 - 1.0)]
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=3e-4 * scale)


def test_a_circular_orbit_is_circular_at_the_epoch():
    elements = CircularElements(500e3, 0.9, 0.4, 0.8)
    position, velocity = elements.trajectory(EPOCH, 10.0).states(np.zeros(1))
    assert np.linalg.norm(position) == pytest.approx(EARTH_RADIUS + 500e3, rel=1e-12)
    assert np.linalg.norm(velocity) == pytest.approx(
        2.0 * np.pi * np.linalg.norm(position) / elements.period, rel=1e-12
    )
    # the height of the position over the equator is that of the argument of latitude
    assert position[0, 2] / np.linalg.norm(position) == pytest.approx(np.sin(0.8) * np.sin(0.9))
    assert velocity[0, 2] > 0.0
    assert elements.epoch is None


@pytest.mark.parametrize(
    ("elements", "words"),
    [
        ((-7e6,), "semi_major_axis"),
        ((float("nan"),), "semi_major_axis"),
        ((7e6, 1.0), "eccentricity 1, expected 0 to below 1"),
        ((7e6, 1.5), "eccentricity"),
        ((7e6, float("nan")), "eccentricity"),
        ((7e6, 0.2), "perigee at an altitude of -778.1 km"),
        ((7e6, 0.0, float("inf")), "inclination"),
    ],
)
def test_refuses_elements_of_no_orbit(elements, words):
    with pytest.raises(InputError, match=words):
        KeplerElements(*elements)


@pytest.mark.parametrize("given", [(0.0,), (-1e3,), (5e5, float("nan"))])
def test_refuses_a_circle_in_the_earth(given):
    with pytest.raises(InputError, match="orbit: "):
        CircularElements(*given)
