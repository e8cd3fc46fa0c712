"""Slew of a reference."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.scenario.component import Kind
from gyrostat.scenario.reference_kind import TARGET
from gyrostat.scenario.schema import size


@dataclass(frozen=True, eq=False)
class SlewKind(Kind):
    """Slew to `target` from `time` on."""

    name = "slew"
    time: Annotated[Scalar, size("time", None, "Start of the slew.")]
    target: Annotated[Quaternion, TARGET]
