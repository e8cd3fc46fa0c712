"""Air density: NRLMSIS 2.1 by the library pymsis.

The model gives the mean density for given solar and geomagnetic activity; the actual one differs by
tens of percent. J. T. Emmert et al. (2022), "NRLMSIS 2.1: an empirical model of nitric oxide
incorporated into MSIS", Journal of Geophysical Research: Space Physics 127. The library computes in
single precision, so that its density is noisy in the sixth digit.
"""

from typing import NamedTuple

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.validation import require
from gyrostat.spacecraft.orbit.libraries import library
from gyrostat.spacecraft.orbit.time_scales import DAY, Epoch, Times

LOWEST = 100e3
"""Least height of an orbit, m: below, a spacecraft does not complete a revolution."""


class Activity(NamedTuple):
    """Solar and geomagnetic activity, constant over a run.

    Attributes:
        f107: Solar radio flux at 10.7 cm of the previous day, in solar flux units, 1e-22 W/(m² Hz).
        f107a: Its mean over 81 days, centred on the day.
        ap: Daily geomagnetic index Ap.
    """

    f107: float
    f107a: float
    ap: float

    def check(self) -> None:
        """Validate the values.

        Raises:
            InputError: A flux is not above 0, or the index is negative.
        """
        require("solar flux f107", self.f107, "sfu", positive=True)
        require("solar flux f107a", self.f107a, "sfu", positive=True)
        require("geomagnetic index ap", self.ap)


def air_density(
    epoch: Epoch, times: Times, latitude: Times, longitude: Times, height: Times, activity: Activity
) -> Times:
    """Air density at geodetic coordinates.

    The library takes whole seconds and whole days of the year, so that its density jumps at
    midnight, by about a percent. Here the logarithm of the density is interpolated linearly between
    the two seconds, and between the two days as if their noons had the library's own values.

    Args:
        epoch: Epoch of the run.
        times: Times, s.
        latitude: Geodetic latitude, rad.
        longitude: Longitude to the east, rad.
        height: Height above the ellipsoid, m.
        activity: Solar and geomagnetic activity.

    Returns:
        Density, (rows,), kg/m³.

    Raises:
        InputError: A height is below `LOWEST`.
    """
    if np.min(height) < LOWEST:
        row = int(np.argmin(height))
        raise InputError(
            f"orbit: found a height of {height[row] / 1e3:.4g} km at {times[row]:.6g} s, expected "
            f"{LOWEST / 1e3:g} km or more"
        )
    dates = epoch.calendar(times)
    second = dates.astype("datetime64[s]")
    share_of_second = (dates - second) / np.timedelta64(1, "s")
    # days since the last noon: at noon, the day of the library counts alone
    since_midnight = (dates - dates.astype("datetime64[D]")) / np.timedelta64(1, "s") / DAY
    late = since_midnight >= 0.5
    share_of_day = since_midnight - np.where(late, 0.5, -0.5)
    step, day = np.timedelta64(1, "s"), np.timedelta64(1, "D")
    logarithm = np.zeros(len(times))
    for seconds, weight in ((second, 1.0 - share_of_second), (second + step, share_of_second)):
        if not np.any(weight):
            continue
        for offset, share in ((0, 1.0 - share_of_day), (1, share_of_day)):
            # the time of day of `seconds`, on the days whose noons are before and after it
            clock = seconds - seconds.astype("datetime64[D]").astype("datetime64[s]")
            noon = (second - np.where(late, 0, 1) * day).astype("datetime64[D]") + offset * day
            values = _msis(noon + clock, latitude, longitude, height, activity)
            logarithm += weight * share * np.log(values)
    return np.exp(logarithm)


def _msis(
    dates: np.ndarray, latitude: Times, longitude: Times, height: Times, activity: Activity
) -> Times:
    """Density of the library, kg/m³. With the indices given, it needs no network."""
    rows = len(dates)
    values = library("pymsis").calculate(
        dates,
        np.degrees(longitude),
        np.degrees(latitude),
        height / 1e3,
        np.full(rows, activity.f107),
        np.full(rows, activity.f107a),
        np.full((rows, 7), activity.ap),
        version=2.1,
    )
    return np.asarray(values).reshape(rows, -1)[:, 0].astype(float)
