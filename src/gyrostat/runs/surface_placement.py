"""Best directions in body axes of a radiator and of a solar panel."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gyrostat.core.directions import spread_evenly
from gyrostat.core.types import Matrix, Vector
from gyrostat.runs.body_sky import BodySky
from gyrostat.runs.placement import DIRECTIONS, SEARCHED, Blocked, not_blocked

SOLAR_FLUX = 1361.0
"""Irradiance of the Sun at 1 au, W/m²."""
EARTH_FLUX = 240.0
"""Mean infrared exitance of the Earth, W/m²."""


class Surface(NamedTuple):
    """Direction of the normal of a surface.

    Attributes:
        direction: Outward normal, body axes, (3,).
        mean: Mean over time of what the surface is chosen by.
        worst: Largest value over time for a radiator, least share of the sunlit time for a panel.
    """

    direction: Vector
    mean: float
    worst: float


def place_radiator(
    sky: BodySky,
    absorptance: float,
    emittance: float,
    blocked: Sequence[Blocked] = (),
) -> Surface | None:
    """Find the normal with the least absorbed heat, W/m²; None if the body is in the way of all.

    The heat is that of the Sun and the infrared of the Earth, both with fixed mean values; sunlight
    that the Earth reflects is left out.

    Args:
        sky: Sun, Earth and Moon in body axes, at the times that count.
        absorptance: Absorptance of the surface for sunlight.
        emittance: Its emittance in the infrared.
        blocked: Directions that the body blocks.
    """
    directions = not_blocked(spread_evenly(DIRECTIONS), blocked)
    if len(directions) == 0:
        return None
    heat = absorbed(sky.thinned(SEARCHED), directions, absorptance, emittance)
    best = directions[np.argmin(np.mean(heat, axis=0))]
    heat = absorbed(sky, best[None], absorptance, emittance)
    return Surface(best, float(np.mean(heat)), float(np.max(heat)))


def absorbed(sky: BodySky, directions: Matrix, absorptance: float, emittance: float) -> Matrix:
    """Absorbed heat of surfaces, (times, directions), W/m²; see `place_radiator`."""
    sun = sunlit(sky, directions)
    earth = view_factor(np.clip(sky.earth @ directions.T, -1.0, 1.0), sky.radius[:, None])
    return absorptance * SOLAR_FLUX * sun + emittance * EARTH_FLUX * earth


def place_panel(sky: BodySky, blocked: Sequence[Blocked] = ()) -> Surface | None:
    """Find the normal with the most sunlight: mean cosine of incidence; None as `place_radiator`.

    Args:
        sky: Sun, Earth and Moon in body axes, at the times that count.
        blocked: Directions that the body blocks.
    """
    directions = not_blocked(spread_evenly(DIRECTIONS), blocked)
    if len(directions) == 0:
        return None
    light = sunlit(sky.thinned(SEARCHED), directions)
    best = directions[np.argmax(np.mean(light, axis=0))]
    light = sunlit(sky, best[None])[:, 0]
    least = np.min(light[sky.sunlight > 0.5], initial=1.0)
    return Surface(best, float(np.mean(light)), float(least))


def sunlit(sky: BodySky, directions: Matrix) -> Matrix:
    """Cosine of incidence times the visible share of the Sun, (times, directions)."""
    return np.maximum(sky.sun @ directions.T, 0.0) * sky.sunlight[:, None]


def view_factor(cosine: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """View factor from a small plane surface to a sphere.

    J. R. Howell, "A catalog of radiation heat transfer configuration factors", B-43.

    Args:
        cosine: Cosine of the angle between normal and direction to the centre.
        radius: Apparent radius of the sphere, rad, below 90 degrees.
    """
    sine = np.sqrt(1.0 - cosine**2)
    size, rest = np.sin(radius), np.cos(radius)
    cuts = np.abs(cosine) < size  # the horizon of the surface cuts the sphere
    sine = np.where(cuts, sine, 1.0)
    edge = np.sqrt(np.where(cuts, size**2 - cosine**2, 0.0))
    shown = np.arccos(np.clip(-cosine * rest / (sine * size), -1.0, 1.0))
    part = 0.5 - np.arcsin(np.clip(rest / sine, -1.0, 1.0)) / np.pi
    part = part + (cosine * size**2 * shown - rest * edge) / np.pi
    return np.where(cuts, part, np.maximum(size**2 * cosine, 0.0))
