"""Pointing at another spacecraft."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gyrostat.control.guidance import OtherSpacecraft
from gyrostat.scenario.aimed_kind import AimedKind
from gyrostat.scenario.reference_kind import PlannedReference
from gyrostat.spacecraft.orbit.orbit_environment import spline_of
from gyrostat.spacecraft.orbit.orbit_file import OEM, OrbitFile
from gyrostat.spacecraft.orbit.tables import LEAST_ROWS, Orbit
from gyrostat.spacecraft.orbit.time_scales import Epoch
from gyrostat.spacecraft.orbit.two_line_elements import TwoLineElements

LONGEST_STEP = 10.0
"""Largest time between rows of the position, s; interpolated to 0.01 m in a low orbit."""


@dataclass(frozen=True, eq=False)
class SpacecraftTarget(AimedKind):
    """Pointing at another spacecraft, whose orbit is in a `file`.

    The file is an OEM of the CCSDS, a CSV file with the header time,x,y,z,vx,vy,vz (GCRS; s after
    the epoch of [orbit], m, m/s), or two-line elements. See
    `gyrostat.control.guidance.OtherSpacecraft`.
    """

    name = "spacecraft"
    texts = ("file",)

    @classmethod
    def read_file(cls, where: str, text: str) -> Orbit:
        """See `ProfileKind.read_file`."""
        if text.lstrip().startswith(OEM) or "," in text.partition("\n")[0]:
            return OrbitFile.read(text, where=where)
        return TwoLineElements.read(text, where)

    @classmethod
    def tabulated(cls, content: Orbit, span: Callable[[], tuple[Epoch, float]]) -> OtherSpacecraft:
        """See `ProfileKind.tabulated`: positions at equidistant times."""
        epoch, end = span()
        rows = max(LEAST_ROWS, int(np.ceil(end / LONGEST_STEP)) + 1)
        times = np.linspace(0.0, end, rows)
        positions = content.trajectory(epoch, end).states(times).position
        return OtherSpacecraft(spline_of(positions), float(times[1]))

    def target(self, planned: PlannedReference, place: str) -> OtherSpacecraft:
        """See `AimedKind.target`."""
        return planned.tables[place]
