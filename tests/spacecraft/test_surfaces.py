"""Facets of a spacecraft: areas and normals of closed bodies, and what is refused."""

import equinox as eqx
import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.spacecraft import Spacecraft, Surfaces
from gyrostat.wheel import WheelArray, orthogonal_axes

WHEELS = WheelArray(orthogonal_axes(), np.full(3, 0.01))
BOX = Surfaces.box([0.2, 0.3, 0.5], [0.01, -0.02, 0.03], specular=0.3, diffuse=0.2)


def test_a_box_is_closed_and_has_its_volume():
    """Divergence theorem: sum of A n is 0, sum of A n·c is three times the volume."""
    weighted = BOX.area[:, None] * BOX.normal
    np.testing.assert_allclose(weighted.sum(0), 0.0, atol=1e-16)
    assert np.sum(weighted * BOX.centre) == pytest.approx(3 * 0.2 * 0.3 * 0.5, rel=1e-14)
    moved = weighted.T @ BOX.centre - np.eye(3) * 0.03  # the volume in every direction
    np.testing.assert_allclose(moved, 0.0, atol=1e-16)


def test_a_panel_has_two_sides_of_one_place():
    wing = Surfaces.panel(2.0, [3.0, 0.0, 4.0], [1.0, 2.0, 3.0], specular=0.5)
    np.testing.assert_allclose(wing.normal, [[0.6, 0.0, 0.8], [-0.6, 0.0, -0.8]])
    np.testing.assert_allclose(wing.centre, [[1.0, 2.0, 3.0]] * 2)
    np.testing.assert_allclose([wing.area, wing.specular], [[2.0, 2.0], [0.5, 0.5]])


def test_rows_are_surfaces_again():
    rows = BOX.rows()
    assert rows.shape == (6, 9)
    np.testing.assert_array_equal(rows[2], [0.1, 0, 1, 0, 0.01, 0.13, 0.03, 0.3, 0.2])
    again = Surfaces.of_rows(rows)
    assert all(map(np.array_equal, jax.tree.leaves(again), jax.tree.leaves(BOX)))


def test_the_torque_of_uniform_pressure_on_a_closed_box_is_zero():
    force = -BOX.area[:, None] * BOX.normal
    np.testing.assert_allclose(BOX.torque(force), 0.0, atol=1e-16)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"area": np.full(6, -1.0)}, "facet area: found -1"),
        ({"normal": 2.0 * BOX.normal}, "facet normal: found a length of 2, expected unit vectors"),
        ({"normal": BOX.normal[:5]}, r"facet normal: found shape \(5, 3\), expected \(6, 3\)"),
        ({"centre": BOX.centre * np.nan}, "facet centre: found nan, expected a finite value"),
        ({"diffuse": np.full(6, 0.8)}, "specular and diffuse: found shares with the sum 1.1"),
        ({"specular": np.full(6, 1.5)}, "specular share of a facet: found 1.5, expected 0 to 1"),
        ({"specular": np.array(0.1)}, r"facet specular: found shape \(\), expected \(6,\)"),
    ],
)
def test_impossible_facets_are_refused(change, message):
    bad = eqx.tree_at(
        lambda each: [getattr(each, name) for name in change], BOX, [*change.values()]
    )
    with pytest.raises(InputError, match=message):
        Spacecraft(np.eye(3), WHEELS, surfaces=bad).check()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"mass": 0.0}, "mass: found 0, expected a finite value above 0 kg"),
        ({"centre_of_mass": np.array([0.0, np.nan, 0.0])}, "centre of mass: found .*nan"),
        ({"centre_of_mass": np.zeros(2)}, "centre of mass: found"),
    ],
)
def test_impossible_masses_are_refused(given, message):
    with pytest.raises(InputError, match=message):
        Spacecraft(np.eye(3), WHEELS, **given).check()


def test_a_batch_of_spacecraft_is_checked():
    many = [Spacecraft(np.eye(3), WHEELS, 12.0 + k, np.full(3, 0.1 * k), BOX) for k in range(2)]
    both = jax.tree.map(lambda *one: np.stack(one), *many)
    both.check()
    with pytest.raises(InputError, match="mass: found -1"):
        eqx.tree_at(lambda each: each.mass, both, np.array([12.0, -1.0])).check()


def test_without_surfaces_a_part_that_needs_them_says_so():
    with pytest.raises(
        InputError, match=r"air drag: found a spacecraft without surfaces, exp"
    ) as e:
        Spacecraft(np.eye(3), WHEELS).facets("air drag")
    assert "\n" not in str(e.value)
    assert Spacecraft(np.eye(3), WHEELS, surfaces=BOX).facets("air drag") is BOX


def test_lists_become_arrays():
    craft = Spacecraft(np.eye(3), WHEELS, centre_of_mass=[0.1, 0.0, 0.0], surfaces=BOX)
    np.testing.assert_allclose(craft.facets("x").centre, BOX.centre - [0.1, 0.0, 0.0])
    with pytest.raises(InputError, match="size of the box"):
        Surfaces.box([0.1, 0.0, 0.1])
    with pytest.raises(InputError, match="facet normal: found"):
        Surfaces.facet(1.0, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
