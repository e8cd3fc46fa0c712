"""Parts of a run while they are built, stage by stage."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from gyrostat.control.guidance import Reference
from gyrostat.runs.designs import Plans
from gyrostat.scenario.component import Context
from gyrostat.scenario.kinds.registry import chosen
from gyrostat.scenario.metrics.budget import Budget
from gyrostat.scenario.sensing import Values, arrays_of
from gyrostat.scenario.structure import Structure
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.sensors.keep_out import KeepOut


class Assembly(NamedTuple):
    """What a run is built from, and the parts that its stages have built.

    Attributes:
        structure: Structure of the scenario.
        values: Values of the run.
        plans: Plans of the scenario.
        law: Kind of the controller with its values.
        orbit: Orbit of the run; None without one.
        plant: Plant.
        motion: Motion at time 0, by the names of the arguments of `plant.start`.
        start: State of the plant at time 0.
        budget: Momentum budget; None unless it is requested.
        starts: Start times of the phases, (phases,), s.
        controller: Controller.
        reference: Reference attitude at the true position; None for the targets of the phases.
        guide: Reference that the controller computes; None if it has the targets of the phases.
        sensor: Sensor of the plant.
        metrics: User-defined metrics by name.
        keep_outs: Instruments that keep angles to bright bodies.
    """

    structure: Structure
    values: Values
    plans: Plans
    law: Any = None
    orbit: OrbitEnvironment | None = None
    plant: Any = None
    motion: Mapping[str, Any] = {}
    start: Any = None
    budget: Budget | None = None
    starts: Any = None
    controller: Any = None
    reference: Reference | None = None
    guide: Reference | None = None
    sensor: Any = None
    metrics: Mapping[str, Any] = {}
    keep_outs: tuple[KeepOut, ...] = ()

    def component(self, section: str) -> Any:
        """Kind of a section with its values."""
        kind = chosen(self.structure, section)
        return kind.of(arrays_of(self.values, section, kind.keys()))


def context_of(run: Assembly, *parts: str) -> Context:
    """What components are made with.

    Args:
        run: Parts of the run.
        parts: Names of the parts that the components get, such as "orbit".
    """
    return Context(
        spacecraft=run.plans.known,
        period=run.values["run.control_period"],
        delay=run.structure.command_delay,
        sensors=run.plans.sensors,
        tables=run.plans.tables,
        **{name: getattr(run, name) for name in parts},
    )


Stage = Callable[[Assembly], dict[str, Any]]
"""Stage of building a run: the fields of `Assembly` that it sets."""
