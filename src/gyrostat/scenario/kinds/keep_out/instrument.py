"""Instrument that must not see bright bodies."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.component import ORBIT, Context, Kind
from gyrostat.scenario.schema import direction, size
from gyrostat.spacecraft.sensors.keep_out import KeepOut


@dataclass(frozen=True, eq=False)
class Instrument(Kind):
    """Boresight that keeps angles; `check` and `simulate` list the times in which it does not.

    See `gyrostat.spacecraft.sensors.keep_out.KeepOut`.
    """

    name = "instrument"
    needs = frozenset({ORBIT})
    boresight: Annotated[Vector3, direction("Boresight in body axes, of any length.", None)]
    sun: Annotated[Scalar, size("angle", 0.0, "Smallest angle to the Sun.")]
    earth: Annotated[
        Scalar, size("angle", 0.0, "Smallest angle to the limb of the Earth; 0: it may be seen.")
    ]
    moon: Annotated[Scalar, size("angle", 0.0, "Smallest angle to the centre of the Moon.")]

    def make(self, context: Context) -> KeepOut:
        """See `Kind.make`."""
        assert context.orbit is not None  # it is needed
        return KeepOut(context.orbit, **self.options())
