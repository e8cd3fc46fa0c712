"""Controller that switches to another design when the target changes or a wheel fails."""

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float, Int

from gyrostat.control.guidance import Guide, toward
from gyrostat.control.missing_sample import predicted
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.traced_once import traced_once
from gyrostat.core.validation import check_parts, check_period
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment


def in_orbit(controller: Any, orbit: OrbitEnvironment | None) -> Any:
    """Controller that gets the orbit of the run by its method `in_orbit`, if it has one."""
    get = getattr(controller, "in_orbit", None)
    return controller if orbit is None or get is None else get(orbit)


@traced_once
def _entry(number: Int[Array, ""], stacked: Float[Array, "phases ..."]) -> Float[Array, "..."]:
    """Entry of a stack of arrays."""
    return stacked[number]


class PhasesMemory(NamedTuple):
    """Memory between samples.

    Attributes:
        controller: Memory of the controller, which continues from phase to phase.
        sample: Index of the next sample.
        period: Control period, s.
    """

    controller: Any
    sample: Scalar
    period: Scalar


class Phases(eqx.Module):
    """Controller with several designs, each active from its start time.

    Attributes:
        starts: Start times of the phases, increasing from 0, (phases,), s.
        plans: Stacked controllers; each array has a leading axis of phases.
        guide: Reference at the sample; None for the targets of the designs.
        orbit: Orbit of the run; None without one.
    """

    starts: Float[Array, " phases"]
    plans: Any
    guide: Guide | None = None
    orbit: OrbitEnvironment | None = None

    def toward(self, guide: Guide) -> "Phases":
        """Controller whose designs follow a reference."""
        return replace(self, guide=guide)

    @property
    def takes_reference(self) -> bool:
        """Whether the designs are a user's part with a field `reference`."""
        return getattr(self.plans, "takes_reference", False)

    def check(self) -> None:
        """Validate parameters of all designs; raises `InputError`."""
        check_parts(self.plans)

    def check_period(self, period: float) -> None:
        """Validate the control period, s, for all designs; raises `InputError`."""
        check_period(period, self.plans)

    def at(self, time: Scalar) -> Any:
        """Controller that is active at a time, s."""
        # tolerance, because a multiple of the period has a rounding error
        number = jnp.sum(self.starts <= time + 1e-9) - 1
        plan = jax.tree.map(partial(_entry, number), self.plans)
        active = in_orbit(plan, self.orbit)
        return active if self.guide is None else toward(active, self.guide)

    def start(self, period: Scalar) -> PhasesMemory:
        """Memory before the first sample, for the first design."""
        period = jnp.asarray(period, dtype=float)
        return PhasesMemory(self.at(0.0).start(period), jnp.zeros(()), period)

    def predicted(self, memory: PhasesMemory, measurement: Any, command: Any) -> PhasesMemory:
        """Memory after a period without a sample.

        Args:
            memory: Memory from the last sample.
            measurement: Last accepted measurement.
            command: Command that is sent.
        """
        controller = self.at(memory.sample * memory.period)
        inner = predicted(controller, memory.controller, measurement, command)
        return PhasesMemory(inner, memory.sample + 1.0, memory.period)

    def __call__(self, memory: PhasesMemory, measurement: Any) -> tuple[PhasesMemory, Any]:
        """Compute the command by the active design."""
        controller = self.at(memory.sample * memory.period)
        inner, command = controller(memory.controller, measurement)
        return PhasesMemory(inner, memory.sample + 1.0, memory.period), command
