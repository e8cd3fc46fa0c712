"""Surroundings of a run along an orbit, for its 3D replay: Earth, Sun, velocity, ground target."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float
from numpy.typing import NDArray

from gyrostat.campaigns.orbits import orbit_of_run, planned_orbit
from gyrostat.campaigns.scenario import Scenario
from gyrostat.core.jax64 import jax
from gyrostat.spacecraft.orbit.earth import EARTH_RADIUS
from gyrostat.spacecraft.torques.eclipse import sunlight

if TYPE_CHECKING:
    import xarray as xr

GROUND = "ground_target"
"""Kind of a reference or mode that tracks a ground target."""


def world_data(
    scenario: Scenario, values: Mapping[str, float], history: "xr.Dataset", frames: NDArray[np.intp]
) -> dict[str, Any] | None:
    """Surroundings at the samples that the page shows; None without an orbit.

    All vectors are in inertial axes (GCRS). `position` and `ground` are from the centre of the
    Earth, in equatorial radii; `ground` is None where no ground target is tracked. `sun` and
    `velocity` are unit vectors, `sun` from the spacecraft. `earth` is the attitude of the ITRF, a
    quaternion, `light` the visible share of the Sun's disc, `mode` the name of the mode.

    Args:
        scenario: Scenario of the run.
        values: Key -> value of the run.
        history: Histories of the run.
        frames: Indices of the samples.
    """
    orbit = orbit_of_run(values, planned_orbit(scenario))
    if orbit is None:
        return None
    time = history.time.values[frames]

    def along(function: Any) -> Float[np.ndarray, "frames ..."]:
        return np.asarray(jax.vmap(function)(time))

    position, sun = along(orbit.position), along(orbit.sun)
    modes = [part for part in scenario.parts if part.section == "reference.mode"]
    if modes:
        number = np.nan_to_num(history["mode"].values[frames]).astype(int)
        names = [modes[k].name for k in number]
        targets = {k: f"reference.mode.{p.name}" for k, p in enumerate(modes) if p.kind == GROUND}
    else:
        number, names = np.zeros(len(time), dtype=int), [scenario.reference] * len(time)
        targets = {0: "reference"} if scenario.reference == GROUND else {}
    ground: list[Any] = [None] * len(time)
    for k, key in targets.items():
        a, b, c = (values[f"{key}.{name}"] for name in ("latitude", "longitude", "height"))
        points = along(lambda t, a=a, b=b, c=c: orbit.ground(a, b, c, t)) / EARTH_RADIUS
        for frame in np.flatnonzero(number == k):
            ground[frame] = np.round(points[frame], 6).tolist()
    return {
        "position": np.round(position / EARTH_RADIUS, 6).tolist(),
        "velocity": np.round(_directions(along(orbit.velocity)), 5).tolist(),
        "sun": np.round(_directions(sun - position), 5).tolist(),
        "earth": np.round(along(orbit.earth), 6).tolist(),
        "light": np.round(along(lambda t: sunlight(orbit.position(t), orbit.sun(t))), 3).tolist(),
        "ground": ground,
        "mode": names,
    }


def _directions(vectors: Float[np.ndarray, "frames 3"]) -> Float[np.ndarray, "frames 3"]:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
