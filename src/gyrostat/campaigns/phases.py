"""Controller that is designed anew when the target changes or a wheel fails."""

from typing import Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.control.missing_sample import predicted
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.validation import check_parts, check_period


class PhasesMemory(NamedTuple):
    """Between two samples.

    Attributes:
        controller: its memory, which goes on from phase to phase.
        sample: number of the coming sample.
        period: control period, s.
    """

    controller: Any
    sample: Scalar
    period: Scalar


class Phases(eqx.Module):
    """Plans of one controller, each in force from its time on.

    Attributes:
        starts: (phases,) rising from 0, s.
        plans: the controllers as one, each of its arrays with a leading axis of phases.
    """

    starts: Float[Array, " phases"]
    plans: Any

    def check(self) -> None:
        """Refuse what any plan refuses, by `InputError`."""
        check_parts(self.plans)

    def check_period(self, period: float) -> None:
        """Refuse a control period, s, that any plan refuses, by `InputError`."""
        check_period(period, self.plans)

    def at(self, time: Scalar) -> Any:
        """The controller in force at a time, s."""
        # a multiple of the period is not exactly the time that it stands for
        number = jnp.sum(self.starts <= time + 1e-9) - 1
        return jax.tree.map(lambda leaf: leaf[number], self.plans)

    def start(self, period: Scalar) -> PhasesMemory:
        """Memory of the first plan."""
        period = jnp.asarray(period, dtype=float)
        return PhasesMemory(self.at(0.0).start(period), jnp.zeros(()), period)

    def predicted(self, memory: PhasesMemory, measurement: Any, command: Any) -> PhasesMemory:
        """Memory one period later without a sample.

        Args:
            memory: from the last sample.
            measurement: last one that was accepted.
            command: that is sent.
        """
        controller = self.at(memory.sample * memory.period)
        inner = predicted(controller, memory.controller, measurement, command)
        return PhasesMemory(inner, memory.sample + 1.0, memory.period)

    def __call__(self, memory: PhasesMemory, measurement: Any) -> tuple[PhasesMemory, Any]:
        """Command by the plan in force."""
        controller = self.at(memory.sample * memory.period)
        inner, command = controller(memory.controller, measurement)
        return PhasesMemory(inner, memory.sample + 1.0, memory.period), command
