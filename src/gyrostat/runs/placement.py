"""Best directions in body axes of the heads of a star tracker.

The directions are searched on a grid of the sphere, then nearby. For three heads, the best pairs
are extended by every third direction: the best triple may be missed where it contains none of them.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from gyrostat.core.directions import across, spread_evenly
from gyrostat.core.types import Matrix, Vector
from gyrostat.runs.body_sky import BodySky

DIRECTIONS = 4000
"""Number of directions of the grid, about 3 degrees apart."""
SEARCHED = 1500
"""Largest number of times in the search; the result is evaluated at all times."""
FINEST = np.radians(0.25)
"""Last step of the search nearby, rad."""
KEPT = 200
"""Number of pairs or triples that are compared by their margin, and of pairs that are extended."""


class Exclusion(NamedTuple):
    """What blinds a head: angles, rad, and the largest body rate, rad/s."""

    sun: float
    earth: float
    moon: float
    rate: float = np.inf


class Blocked(NamedTuple):
    """Directions in which a part of the body is in the way.

    Attributes:
        direction: Middle, body axes, unit vector, (3,).
        angle: Half angle of the cone, rad.
    """

    direction: Vector
    angle: float


class Heads(NamedTuple):
    """Directions of star tracker heads.

    Attributes:
        directions: Boresights, body axes, (heads, 3).
        availability: Fraction of time in which at least one is not blind.
        in_view: Mean number of heads that are not blind.
        each: Fraction of time in which each is not blind, (heads,).
        sees: Whether each is not blind, (times, heads).
    """

    directions: Float[np.ndarray, "heads 3"]
    availability: float
    in_view: float
    each: Vector
    sees: Bool[np.ndarray, "times heads"]


def margins(sky: BodySky, directions: Matrix, exclusion: Exclusion) -> Matrix:
    """Angle by which a head in each direction is clear of what blinds it, (times, directions), rad.

    Negative: it is blind, see `gyrostat.spacecraft.StarTrackerHead`.

    Args:
        sky: Sun, Earth and Moon in body axes.
        directions: Unit vectors in body axes.
        exclusion: What blinds a head.
    """

    def angle(to: Matrix) -> Matrix:
        return np.arccos(np.clip(to @ directions.T, -1.0, 1.0))

    shows = np.where(sky.sunlight > 0.0, 0.0, np.inf)[:, None]
    margin = angle(sky.sun) - exclusion.sun + shows
    limb = angle(sky.earth) - sky.radius[:, None] - exclusion.earth
    risen = np.where(sky.moonlit, 0.0, np.inf)[:, None]
    margin = np.minimum(np.minimum(margin, limb), angle(sky.moon) - exclusion.moon + risen)
    return np.where(sky.rate[:, None] > exclusion.rate, -np.inf, margin)


def place_heads(
    sky: BodySky,
    exclusion: Exclusion,
    count: int,
    *,
    apart: float = 0.0,
    blocked: Sequence[Blocked] = (),
    directions: Matrix | None = None,
) -> Heads | None:
    """Find the directions of one to three heads; None if the body is in the way of all.

    The first aim is the fraction of time in which at least one head sees, to 0.1 %; then the mean
    number of heads that see, to 0.1 % of the heads; then the least margin to what blinds them.

    Args:
        sky: Sun, Earth and Moon in body axes, at the times that count.
        exclusion: What blinds a head.
        count: Number of heads, 1 to 3.
        apart: Least angle between two heads, rad.
        blocked: Directions that the body blocks.
        directions: Grid of directions, (n, 3); a finer or coarser one than the default.
    """
    searched = sky.thinned(SEARCHED)
    allowed = not_blocked(spread_evenly(DIRECTIONS) if directions is None else directions, blocked)
    if len(allowed) == 0:
        return None
    found = _on_grid(margins(searched, allowed, exclusion), allowed, count, np.cos(apart))
    if found is None:
        return None
    heads = allowed[found]
    step = 2.0 * np.sqrt(np.pi / len(allowed))
    while directions is None and step > FINEST:
        heads = _nearby(searched, heads, exclusion, step, np.cos(apart), blocked)
        step *= 0.5
    return evaluated(sky, heads, [exclusion] * count)


def evaluated(sky: BodySky, directions: Matrix, exclusions: Sequence[Exclusion]) -> Heads:
    """Heads in given directions, (heads, 3), each with what blinds it.

    Args:
        sky: Sun, Earth and Moon in body axes, at the times that count.
        directions: Boresights, unit vectors in body axes.
        exclusions: What blinds each head.
    """
    each_margin = [
        margins(sky, direction[None], exclusion)
        for direction, exclusion in zip(directions, exclusions, strict=True)
    ]
    sees = np.hstack(each_margin) >= 0.0
    each = np.mean(sees, axis=0)
    return Heads(directions, float(np.mean(np.any(sees, axis=1))), float(np.sum(each)), each, sees)


def not_blocked(directions: Matrix, blocked: Sequence[Blocked]) -> Matrix:
    """Directions in which the body is not in the way."""
    for cone in blocked:
        directions = directions[directions @ cone.direction < np.cos(cone.angle)]
    return directions


def _on_grid(margin: Matrix, directions: Matrix, count: int, cosine: float) -> list[int] | None:
    """Places in the grid of the best heads."""
    blind = (margin < 0.0).astype(np.float32)
    shares = np.mean(blind, axis=0)
    sets = [(k,) for k in range(len(directions))]
    scores = _score(shares, shares, 1)
    together = directions @ directions.T <= cosine + 1e-12 if count > 1 else None
    for number in range(2, count + 1):
        best = [
            sets[k] for k in np.argsort(-scores, kind="stable")[: None if number == 2 else KEPT]
        ]
        bases = np.stack([np.prod(blind[:, each], axis=1) for each in best], axis=1)
        both = bases.T @ blind / len(blind)  # time in which the set and a further head are blind
        mean = np.array([sum(shares[k] for k in each) for each in best])
        scores = _score(both, (mean[:, None] + shares) / number, number)
        assert together is not None
        fits = np.all([together[[each[k] for each in best]] for k in range(number - 1)], axis=0)
        scores = np.where(fits, scores, -np.inf)
        order = np.argpartition(-scores, min(KEPT, scores.size - 1), axis=None)[: KEPT + 1]
        scores = scores.ravel()[order]
        sets = [(*best[place // len(directions)], int(place % len(directions))) for place in order]
    if not np.isfinite(np.max(scores)):
        return None
    ranked = [sets[k] for k in np.argsort(-scores, kind="stable")[:KEPT] if np.isfinite(scores[k])]
    return list(max(ranked, key=lambda each: _rank(margin[:, list(each)])))


def _score(blind: np.ndarray, mean_blind: np.ndarray, count: int) -> np.ndarray:
    """One number for the first two aims."""
    return np.round(1.0 - blind, 3) * 1e3 + np.round(1.0 - mean_blind, 3)


def _rank(margin: Matrix) -> tuple[float, float, float]:
    """The three aims of `place_heads`, for the margins of a set of heads, (times, heads)."""
    sees = margin >= 0.0
    least = float(np.min(np.max(margin, axis=1)))
    return round(float(np.mean(np.any(sees, axis=1))), 3), round(float(np.mean(sees)), 3), least


def _nearby(
    sky: BodySky,
    heads: Matrix,
    exclusion: Exclusion,
    step: float,
    cosine: float,
    blocked: Sequence[Blocked],
) -> Matrix:
    """Heads after each of them was moved to the best of eight directions around it, or stayed."""
    heads = heads.copy()
    for k in range(len(heads)):
        own = heads[k]
        side = across(own)
        around = np.arange(8) * np.pi / 4.0
        ring = np.outer(np.cos(around), side) + np.outer(np.sin(around), np.cross(own, side))
        tried = not_blocked(np.vstack([own, np.cos(step) * own + np.sin(step) * ring]), blocked)
        others = np.delete(heads, k, axis=0)
        tried = tried[np.all(tried @ others.T <= cosine + 1e-12, axis=1)]
        if len(tried) == 0:
            continue
        rest, own_margins = margins(sky, others, exclusion), margins(sky, tried, exclusion)
        ranks = [_rank(np.column_stack([rest, column])) for column in own_margins.T]
        heads[k] = tried[max(range(len(tried)), key=ranks.__getitem__)]
    return heads
