"""Angle of a paddle."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.component import PADDLE, Context, Kind
from gyrostat.scenario.schema import size
from gyrostat.spacecraft import PaddleAngle


@dataclass(frozen=True, eq=False)
class PaddleAngleKind(Kind):
    """Angle of the paddle of the controller `two_wheels_paddle`, a number.

    See `gyrostat.spacecraft.PaddleAngle`.
    """

    name = "paddle_angle"
    unit = "rad"
    needs = frozenset({PADDLE})
    sigma: Annotated[Scalar, size("angle", 0.0, "Standard deviation of the noise.", source="noise")]

    def make(self, context: Context) -> PaddleAngle:
        """Sensor."""
        assert context.spacecraft is not None
        return PaddleAngle(context.spacecraft.wheels.count - 1, self.sigma)
