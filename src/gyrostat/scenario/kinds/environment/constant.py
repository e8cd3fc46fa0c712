"""Constant external torque."""

from dataclasses import dataclass

from gyrostat.scenario.environment_kind import EnvironmentKind


@dataclass(frozen=True, eq=False)
class ConstantTorque(EnvironmentKind):
    """Constant external torque."""

    name = "constant"
