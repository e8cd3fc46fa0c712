"""Sunlight against cones of shadow, areas by quadrature and rays."""

import numpy as np
import pytest

from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft.orbit.earth import EARTH_RADIUS
from gyrostat.spacecraft.torques.eclipse import SUN_RADIUS, sunlight, visible_share

DISTANCE = 1.5e11
SUN = np.array([DISTANCE, 0.0, 0.0])
SHARE = jax.jit(jax.vmap(visible_share))
LIGHT = jax.jit(jax.vmap(sunlight, (0, None)))


def behind(along, across):
    """Positions at a distance behind the Earth and from the axis of the shadow."""
    along, across = np.broadcast_arrays(along, np.asarray(across, dtype=float))
    turned = across[..., None] * [0.0, 0.6, 0.8]
    return turned - along[..., None] * [1.0, 0.0, 0.0]


def light(positions):
    return np.array(LIGHT(jnp.asarray(positions), jnp.asarray(SUN)))


def cone(along, sign):
    """Radius of the penumbra (sign 1) or the umbra (-1) by tangents common to Sun and Earth."""
    sine = (SUN_RADIUS + sign * EARTH_RADIUS) / DISTANCE
    return sign * (along + sign * EARTH_RADIUS / sine) * np.tan(np.arcsin(sine))


def test_covered_areas_are_those_of_a_quadrature():
    """Chords of both discs, integrated over the line of the centres."""
    draw = np.random.default_rng(1)
    own, other, distance = draw.uniform(0.2, 2.0, (3, 60))
    angle = (np.arange(20000) + 0.5) / 20000 * np.pi
    x = own[:, None] * np.cos(angle)
    chord = np.minimum(
        own[:, None] * np.sin(angle),
        np.sqrt(np.clip(other[:, None] ** 2 - (x - distance[:, None]) ** 2, 0.0, None)),
    )
    area = 2.0 * np.mean(chord * np.sin(angle), axis=1) * np.pi * own
    found = np.array(SHARE(own, other, distance))
    np.testing.assert_allclose(found, 1.0 - area / (np.pi * own**2), rtol=0.0, atol=1e-6)
    kinds = [distance > own + other, distance < other - own, distance < own - other]
    assert all(np.any(kind) for kind in kinds)
    assert not np.all(np.any(kinds, axis=0))


@pytest.mark.parametrize("along", [4e6, 7e6, 4.2e7, 4e8])
def test_the_shadow_has_the_cones_of_umbra_and_penumbra(along):
    edges = cone(along, -1), cone(along, 1)
    width = edges[1] - edges[0]
    assert width == pytest.approx(2.0 * along * SUN_RADIUS / DISTANCE, rel=0.01)
    share = light(behind(along, [0.0, edges[0] - 1e-6 * width, edges[0] + 1e-6 * width]))
    assert share[0] == share[1] == 0.0 < share[2]
    share = light(behind(along, [edges[1] - 1e-6 * width, edges[1] + 1e-6 * width]))
    assert share[0] < 1.0 == share[1]
    through = light(behind(along, np.linspace(*edges, 200)))
    assert np.all(np.diff(through) > 0.0)


def test_far_behind_the_earth_the_sun_is_a_ring():
    along = 3e9  # the umbra ends at 1.4e9 m
    ring = 1.0 - (np.arcsin(EARTH_RADIUS / along) / np.arcsin(SUN_RADIUS / (DISTANCE + along))) ** 2
    assert cone(along, -1) < 0.0
    np.testing.assert_allclose(light(behind(along, [0.0, 1e6])), ring, rtol=1e-6)


def test_before_the_earth_and_beside_it_the_sun_is_full():
    before = behind(-7e6, np.linspace(0.0, 6e6, 7))
    beside = behind(0.0, np.linspace(6.5e6, 4e7, 7))
    assert np.all(light(np.concatenate([before, beside])) == 1.0)


@pytest.mark.parametrize("altitude", [200e3, 3.6e7])
def test_the_share_is_that_of_rays_that_miss_the_sphere(altitude):
    radius, count = EARTH_RADIUS + altitude, 600
    middle = np.arcsin(EARTH_RADIUS / radius)
    angles = middle + np.linspace(-1.0, 1.0, 11) * 4.65e-3
    positions = behind(radius * np.cos(angles), radius * np.sin(angles))
    rings = np.sqrt((np.arange(count) + 0.5) / count)[:, None]
    turns = 2.0 * np.pi * (np.arange(count) + 0.5) / count
    disc = np.broadcast_arrays(0.0, rings * np.cos(turns), rings * np.sin(turns))
    points = SUN + SUN_RADIUS * np.stack(disc, axis=-1)
    for position, share in zip(positions, light(positions), strict=True):
        rays = points - position
        nearest = np.sum(np.cross(rays, position) ** 2, axis=-1) / np.sum(rays**2, axis=-1)
        missed = np.mean(nearest > EARTH_RADIUS**2)
        assert share == pytest.approx(missed, abs=3e-4)


def test_derivatives_are_finite_and_those_of_differences():
    across = np.concatenate(
        [[0.0, cone(7e6, -1), cone(7e6, 1)], np.linspace(6.2e6, 6.5e6, 301), [1e7]]
    )
    edges = np.nextafter(across[1:3, None], across[1:3, None] + [[-1.0, 1.0]]).ravel()
    places = behind(7e6, np.concatenate([across, edges]))
    places = np.concatenate([places, -places, 1e6 * np.eye(3)])
    ways = np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [0.0, 0.8, -0.6]])

    def slope(place, way):
        return jax.jvp(lambda x: sunlight(x, jnp.asarray(SUN)), (place,), (way,))[1]

    slopes = np.array(jax.jit(jax.vmap(jax.vmap(slope, (None, 0)), (0, None)))(places, ways))
    assert np.all(np.isfinite(slopes))
    step = 0.1
    for k, way in enumerate(ways):
        other = (light(places[:300] + step * way) - light(places[:300] - step * way)) / (2 * step)
        # the slope is about 2 / (60 km); it grows as a square root from the edges
        np.testing.assert_allclose(slopes[:300, k], other, rtol=1e-5, atol=2e-8)
    backward = jax.jit(jax.vmap(jax.grad(sunlight), (0, None)))(places, jnp.asarray(SUN))
    np.testing.assert_allclose(backward @ ways.T, slopes, rtol=1e-9, atol=1e-11)
