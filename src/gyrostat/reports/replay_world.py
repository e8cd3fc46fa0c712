"""Surroundings of a run along an orbit, for its 3D replay: Earth, Sun, velocity, ground target."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy.typing import NDArray

from gyrostat.codegen.evaluation import evaluated
from gyrostat.core.jax64 import jax
from gyrostat.scenario.kinds.orbits import orbit_of
from gyrostat.scenario.scenario import Scenario
from gyrostat.spacecraft.orbit.earth import EARTH_RADIUS
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.torques.eclipse import sunlight

GROUND = "ground_target"
"""Kind of a reference or mode that tracks a ground target."""


def world_data(
    scenario: Scenario,
    values: Mapping[str, float],
    history: Mapping[Any, Any],
    frames: NDArray[np.intp],
    planned: OrbitEnvironment | None,
) -> dict[str, Any] | None:
    """Surroundings at the samples that the page shows; None without an orbit.

    All vectors are in inertial axes (GCRS). `position` and `ground` are from the centre of the
    Earth, in equatorial radii; `ground` is None where no ground target is tracked. `sun` and
    `velocity` are unit vectors, `sun` from the spacecraft. `earth` is the attitude of the ITRF, a
    quaternion, `light` the visible share of the Sun's disc, `mode` the name of the mode.

    Args:
        scenario: Scenario of the run.
        values: Key -> value of the run.
        history: Histories of the run: name -> array, or what can be converted to one.
        frames: Indices of the samples.
        planned: Orbit of the scenario, as from `planned_orbit`; None without an orbit.
    """
    orbit = orbit_of(scenario, values, planned)
    if orbit is None:
        return None
    # one trace for all runs, whose numbers differ
    orbit = jax.tree.map(np.asarray, orbit)
    time = np.asarray(history["time"])[frames]
    position, velocity, sun, earth, light = map(np.asarray, _surroundings(orbit, time))
    modes = [part for part in scenario.parts if part.section == "reference.mode"]
    if modes:
        number = np.nan_to_num(np.asarray(history["mode"])[frames]).astype(int)
        names = [modes[k].name for k in number]
        targets = {k: f"reference.mode.{p.name}" for k, p in enumerate(modes) if p.kind == GROUND}
    else:
        number, names = np.zeros(len(time), dtype=int), [scenario.reference] * len(time)
        targets = {0: "reference"} if scenario.reference == GROUND else {}
    ground: list[Any] = [None] * len(time)
    for k, key in targets.items():
        site = np.array([values[f"{key}.{name}"] for name in ("latitude", "longitude", "height")])
        points = np.asarray(_points(orbit, site, time)) / EARTH_RADIUS
        for frame in np.flatnonzero(number == k):
            ground[frame] = np.round(points[frame], 6).tolist()
    return {
        "position": np.round(position / EARTH_RADIUS, 6).tolist(),
        "velocity": np.round(_directions(velocity), 5).tolist(),
        "sun": np.round(_directions(sun - position), 5).tolist(),
        "earth": np.round(earth, 6).tolist(),
        "light": np.round(light, 3).tolist(),
        "ground": ground,
        "mode": names,
    }


@evaluated
def _surroundings(orbit: OrbitEnvironment, time: Any) -> Any:
    """Position, velocity, Sun, attitude of the ITRF and sunlight at times, each (times, ...)."""

    def at(t):
        position, sun = orbit.position(t), orbit.sun(t)
        return position, orbit.velocity(t), sun, orbit.earth(t), sunlight(position, sun)

    return jax.vmap(at)(time)


@evaluated
def _points(orbit: OrbitEnvironment, site: Any, time: Any) -> Any:
    """A site on the ground (latitude, longitude, height) at times, GCRS, (times, 3), m."""
    latitude, longitude, height = site
    return jax.vmap(lambda t: orbit.ground(latitude, longitude, height, t))(time)


def _directions(vectors: Float[np.ndarray, "frames 3"]) -> Float[np.ndarray, "frames 3"]:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
