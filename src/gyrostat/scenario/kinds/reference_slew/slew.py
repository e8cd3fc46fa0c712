"""Slew of a reference."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.scenario.component import Kind
from gyrostat.scenario.reference_kind import AROUND, TARGET
from gyrostat.scenario.scenario import KEEP_OUT
from gyrostat.scenario.schema import size


@dataclass(frozen=True, eq=False)
class SlewKind(Kind):
    """Slew to `target` from `time` on."""

    name = "slew"
    links: ClassVar = {AROUND: KEEP_OUT}
    time: Annotated[Scalar, size("time", None, "Start of the slew.")]
    target: Annotated[Quaternion, TARGET]
