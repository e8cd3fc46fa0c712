"""Tables of the environment along an orbit, computed before a run by the extra `orbit`."""

from typing import NamedTuple, Protocol

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.validation import require
from gyrostat.spacecraft.orbit.atmosphere import Activity, air_density
from gyrostat.spacecraft.orbit.elements import Trajectory
from gyrostat.spacecraft.orbit.field import magnetic_field
from gyrostat.spacecraft.orbit.frames import (
    earth_attitude,
    gcrs_to_itrf,
    geodetic,
    rotated,
    transposed,
)
from gyrostat.spacecraft.orbit.orbit_environment import (
    CHANNELS,
    OrbitEnvironment,
    OrbitSamples,
    on_piece,
)
from gyrostat.spacecraft.orbit.sun import moon_position, sun_position
from gyrostat.spacecraft.orbit.time_scales import Epoch, Times

STEPS = (60, 40, 30, 20, 15, 12, 10, 8, 6, 5, 4, 3, 2, 1)
"""Times between rows, s, from which one is chosen."""
LEAST_ROWS = 4
PROBED = 150
"""Intervals between rows in which the interpolation error is measured."""
SHARES = (0.25, 0.5, 0.75)
"""Places in an interval at which it is measured."""
TOLERANCE = 1e-6
"""Largest interpolation error wanted, relative to the rms size of a quantity."""
LONGEST = 366 * 86400.0
"""Longest time of tables, s."""


class Orbit(Protocol):
    """Orbit that can be tabulated."""

    @property
    def period(self) -> float:
        """Period, s."""
        ...

    def trajectory(self, epoch: Epoch, end: float) -> Trajectory:
        """Orbit from the epoch until a time, s."""
        ...


class OrbitAccuracy(NamedTuple):
    """Accuracy of the tables.

    Attributes:
        step: Time between rows, s.
        rows: Number of rows.
        errors: Largest measured interpolation error of position, velocity, sun, field, earth and
            moon relative to the rms size of each, and of the density relative to itself.
        notes: Notes on the orbit.
    """

    step: float
    rows: int
    errors: dict[str, float]
    notes: tuple[str, ...]

    def __str__(self) -> str:
        """Accuracy in one line."""
        errors = ", ".join(f"{name} {error:.1e}" for name, error in self.errors.items())
        text = f"{self.rows} rows, {self.step:g} s apart; relative interpolation errors: {errors}"
        return "; ".join((text, *self.notes))


def orbit_environment(
    orbit: Orbit,
    epoch: str,
    duration: float,
    *,
    start: float = 0.0,
    step: int | None = None,
    f107: float = 150.0,
    f107a: float = 150.0,
    ap: float = 15.0,
    ut1_utc: float = 0.0,
    moon: bool = False,
) -> tuple[OrbitEnvironment, OrbitAccuracy]:
    """Tabulate an orbit and its environment.

    Without `step`, it is the longest of `STEPS` for which every quantity but the density is
    interpolated to `TOLERANCE`, measured against direct evaluations between rows.

    Args:
        orbit: Orbit, such as `KeplerElements`, `TwoLineElements` or `OrbitFile`.
        epoch: Time 0 of the orbit, UTC, such as "2026-11-22T10:00:00Z".
        duration: Time covered, s; the tables end up to two minutes (for short durations three)
            later, which the orbit must cover.
        start: First row and time 0 of the tables, after the epoch, s.
        step: Time between rows, s.
        f107: Solar radio flux at 10.7 cm of the previous day, in solar flux units.
        f107a: Its mean over 81 days.
        ap: Daily geomagnetic index Ap.
        ut1_utc: UT1 - UTC at the epoch, s.
        moon: Whether the tables hold the Moon.

    Raises:
        InputError: A library is not installed, an input is outside its range, or the interpolation
            error with a given `step` exceeds `TOLERANCE`.
    """
    require("orbit: duration", duration, "s", positive=True)
    if duration > LONGEST:
        raise InputError(
            f"orbit: found the duration {duration:g} s, expected {LONGEST:g} s or less"
        )
    begin, activity = Epoch.of(epoch, ut1_utc), Activity(f107, f107a, ap)
    activity.check()
    horizon = max((rows_of(duration, s) - 1) * s for s in STEPS)
    trajectory = orbit.trajectory(begin, start + horizon)

    def table(step: int) -> tuple[OrbitEnvironment, dict[str, float]]:
        times = float(step) * np.arange(rows_of(duration, step))
        samples = samples_at(trajectory, begin, start + times, activity, moon=moon)
        environment = OrbitEnvironment.of(float(step), samples, orbit.period)
        intervals = np.unique(np.linspace(0, len(times) - 2, PROBED).astype(int))
        between = (step * (intervals[:, None] + np.array(SHARES))).ravel()
        direct = samples_at(trajectory, begin, start + between, activity, moon=moon)
        return environment, errors_of(environment, direct, between)

    fixed_step, step = step, step or STEPS[0]
    while True:
        environment, errors = table(step)
        largest = max(error for name, error in errors.items() if name != "density")
        if largest <= TOLERANCE or (step == STEPS[-1] and fixed_step is None):
            break
        if fixed_step is not None:
            raise InputError(
                f"orbit: found the relative interpolation error {largest:.1e} between rows "
                f"{step} s apart, expected {TOLERANCE:g} or less"
            )
        # the error of cubic splines falls with the fourth power of the step
        promising = step * (0.9 * TOLERANCE / largest) ** 0.25
        step = max(s for s in STEPS if s < step and (s <= promising or s == STEPS[-1]))
    rows = len(np.asarray(environment.splines))
    return environment, OrbitAccuracy(float(step), rows, errors, trajectory.notes)


def rows_of(duration: float, step: int) -> int:
    """Number of rows that cover a duration, s, and an interval more."""
    return max(LEAST_ROWS, int(np.ceil(duration / step)) + 2)


def samples_at(
    trajectory: Trajectory,
    epoch: Epoch,
    times: Times,
    activity: Activity,
    *,
    moon: bool = False,
) -> OrbitSamples:
    """Evaluate the orbit and its environment, without interpolation.

    Args:
        trajectory: Orbit.
        epoch: Epoch of the run.
        times: Times, s, ascending.
        activity: Solar and geomagnetic activity.
        moon: Whether the Moon is computed.

    Raises:
        InputError: The orbit is too low, or a model does not cover the times.
    """
    position, velocity = trajectory.states(times)
    matrices = gcrs_to_itrf(epoch, times)
    fixed = rotated(matrices, position)
    density = air_density(epoch, times, *geodetic(fixed), activity)
    field = rotated(transposed(matrices), magnetic_field(epoch, times, fixed))
    return OrbitSamples(
        *(position, velocity, sun_position(epoch, times), field, density, earth_attitude(matrices)),
        moon_position(epoch, times) if moon else None,
    )


def errors_of(
    environment: OrbitEnvironment, direct: OrbitSamples, times: Times
) -> dict[str, float]:
    """Largest relative errors of interpolated values; see `OrbitAccuracy`.

    Args:
        environment: Interpolated tables.
        direct: Values without interpolation.
        times: Times of the values, s, within the tables.
    """
    rows = np.asarray(environment.splines)
    share = times / float(environment.step)
    row = np.minimum(share.astype(int), len(rows) - 2)
    ends = np.moveaxis(rows[[row, row + 1]], 2, 1)
    values = on_piece(ends, (share - row)[:, None])
    near = {
        name: values[:, first:end]
        for name, (first, end) in CHANNELS.items()
        if end <= values.shape[1]
    }
    quaternions = near["earth"] / np.linalg.norm(near["earth"], axis=1, keepdims=True)
    near["earth"] = quaternions * np.sign(np.sum(quaternions * direct.earth, axis=1, keepdims=True))
    density = np.exp(near.pop("density")[:, 0]) / direct.density
    errors = {}
    for name, rows in near.items():
        true = getattr(direct, name)
        off = np.max(np.linalg.norm(rows - true, axis=1))
        errors[name] = float(off / np.sqrt(np.mean(true**2) * 3.0))
    return errors | {"density": float(np.max(np.abs(density - 1.0)))}
