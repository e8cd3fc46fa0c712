"""Linear quadratic regulator, and the regulator of the state-dependent Riccati equation."""

from dataclasses import dataclass, replace
from typing import Annotated

from gyrostat.control import AttitudeRegulator
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.controller_kind import IGNORED, Beginning, ControllerKind, DesignCase
from gyrostat.scenario.kinds.controller.three_axis import TORQUE_TIME
from gyrostat.scenario.schema import positive


@dataclass(frozen=True, eq=False)
class Sdre(ControllerKind):
    """As `lqr`, with the state-dependent Riccati equation (SDRE), solved at each sample."""

    name = "sdre"
    losses = IGNORED
    attitude_weight: Annotated[
        Scalar,
        positive(
            "1", 16.0, "Weight on the squared modified Rodrigues parameters (small angle / 4)."
        ),
    ]
    rate_weight: Annotated[Scalar, positive("s²/rad²", 16.0, "Weight on the squared body rate.")]
    torque_weight: Annotated[
        Scalar, positive("1/(N·m)²", 1.0, "Weight on the squared body torque.")
    ]
    torque_time: Annotated[Scalar, TORQUE_TIME]

    @classmethod
    def plan(cls, case: DesignCase) -> AttitudeRegulator:
        """See `ControllerKind.plan`."""
        return AttitudeRegulator(case.spacecraft, jnp.asarray(case.target))

    def controller(self, design: AttitudeRegulator, beginning: Beginning) -> AttitudeRegulator:
        """See `ControllerKind.controller`."""
        return replace(design, **self.options())


@dataclass(frozen=True, eq=False)
class Lqr(Sdre):
    """Linear quadratic regulator: state feedback of attitude and rate, without a rate limit.

    See `gyrostat.control.AttitudeRegulator`. Failed wheels and drag are not taken into account.
    """

    name = "lqr"

    def controller(self, design: AttitudeRegulator, beginning: Beginning) -> AttitudeRegulator:
        """See `ControllerKind.controller`."""
        return super().controller(design, beginning).linear()
