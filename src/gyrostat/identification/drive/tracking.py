"""Tracking error of a drive, which shows the gains of its control law where the motion does not."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.identification.drive.control_law import ControlLaw
from gyrostat.identification.drive.motion import FEWEST, Drive, Motion
from gyrostat.identification.drive.parts import Part
from gyrostat.identification.drive.regression import covariance, regress

BELOW_LIMIT = 0.99
"""Largest current that is compared, relative to the limit."""


class Tracking(NamedTuple):
    """Tracking error of a record relative to that of the simulated loop.

    Attributes:
        ratio: Slope of the recorded over the simulated tracking error.
        sigma: Its standard deviation.
    """

    ratio: float
    sigma: float


def tracking(
    law: ControlLaw, parts: Sequence[Part], simulated: Sequence[Motion]
) -> Tracking | None:
    """Compare the tracking errors of the longest segment by a linear regression with an offset.

    A loop that follows its reference closely has nearly the same speed and current with other
    gains, and another tracking error. The simulated one is free of noise and disturbances, which
    therefore do not bias the slope. None if the segment is not most of the record, as each begins
    without an error in the simulation, or if its current is at its limit throughout.

    Args:
        law: Control law.
        parts: Segments.
        simulated: Motion of each in the simulated loop.
    """
    lengths = [len(part.drive.present) for part in parts]
    longest = int(np.argmax(lengths))
    drive, motion = parts[longest].drive, simulated[longest]
    # a current at its limit does not depend on the gains
    used = drive.present & (np.abs(drive.current) < BELOW_LIMIT * law.saturation)
    if 2 * lengths[longest] < sum(lengths) or used.sum() < FEWEST:
        return None
    predicted, recorded = (_error(law, drive, each)[used] for each in (motion, drive.measured))
    x, y = (predicted - np.mean(predicted))[:, None], recorded - np.mean(recorded)
    slope = regress(x, x, y)
    spread = covariance(x, x, y - x @ slope, [np.flatnonzero(used)])
    return Tracking(float(slope[0]), float(np.sqrt(spread[0, 0])))


def _error(law: ControlLaw, drive: Drive, motion: Motion) -> Vector:
    """Error of the quantity that the law follows, (n,), rad or rad/s, at the ends of intervals."""
    error = drive.reference - motion.mean_speed
    return np.cumsum(error * np.diff(drive.time)) if law.reference == "reference" else error
