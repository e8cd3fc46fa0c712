"""What the conditions of modes get from the controller and the sensors of a run."""

from collections.abc import Callable, Mapping
from typing import Any

import equinox as eqx

from gyrostat.control.guidance import Guided
from gyrostat.control.missing_sample import predicted
from gyrostat.core.arrays import Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.core.named_tuples import with_fields
from gyrostat.runs.build import Setup
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.sensing import first_measurement
from gyrostat.scenario.timeline import TRANSITION

CONDITION = "condition_"
"""Start of the names of the fields that `Probe` adds; the number of the transition follows."""
NEEDED = {
    "wheels_lost": (
        "works",
        "a controller whose command has no works",
        "one whose command says with works whether each wheel works, such as wheel_array",
    ),
    "tracker_lost": (
        "attitude_measured",
        "a measurement without attitude_measured",
        "sensors whose measurement says whether the attitude was measured, such as star_tracker",
    ),
}
"""Key of a condition -> field that it needs, what is found without it, and what is expected."""


class Probe(eqx.Module):
    """Controller that follows a reference, and shows what the conditions of the modes get.

    Attributes:
        guided: The controller.
        see: Called with the names of the fields of measurement and command when it is traced.
    """

    guided: Guided
    see: Callable[..., None] = eqx.field(static=True)

    def start(self, period: Scalar) -> Any:
        """Memory before the first sample."""
        return self.guided.start(period)

    def predicted(self, memory: Any, measurement: Any, command: Any) -> Any:
        """Memory after a period without a sample."""
        return predicted(self.guided, memory, measurement, command)

    def __call__(self, memory: Any, measurement: Any) -> tuple[Any, Any]:
        """Compute the command, with the value of each condition of a user as a further field."""
        time = memory.sample * memory.period
        memory, command = self.guided(memory, measurement)
        self.see(measurement._fields, command._fields)
        conditions = {
            f"{CONDITION}{number}": user(measurement, time)
            for number, user in enumerate(self.guided.reference.changes.user)
            if user is not None
        }
        return memory, with_fields("Probed", command, conditions, {}) if conditions else command


def _see_nothing(*fields: Any) -> None:
    """Default of `probed`."""


def probed(controller: Any, see: Callable[..., None] = _see_nothing) -> Any:
    """Controller with a `Probe` around its part that follows the reference.

    Args:
        controller: Controller of a run.
        see: See `Probe`.
    """
    return jax.tree.map(
        lambda part: Probe(part, see) if isinstance(part, Guided) else part,
        controller,
        is_leaf=lambda part: isinstance(part, Guided),
    )


def condition_values(scenario: Scenario, command: Any) -> Mapping[str, Any]:
    """Name of each condition of a user -> its value.

    Args:
        scenario: Scenario.
        command: Command of a `probed` controller.
    """
    parts = [part for part in scenario.parts if part.section == TRANSITION]
    names = [f"{part.section}.{part.name} {part.kind}" for part in parts]
    return {
        names[int(name.removeprefix(CONDITION))]: value
        for name, value in command._asdict().items()
        if name.startswith(CONDITION)
    }


def check_conditions(scenario: Scenario, setup: Setup) -> None:
    """Check that the conditions on lost wheels and a lost star tracker get what they need.

    Raises:
        InputError: One can never hold.
    """
    keys = [
        f"{TRANSITION}.{part.name}.{key}"
        for part in scenario.parts
        if part.section == TRANSITION
        for key in NEEDED
    ]
    keys = [key for key in keys if scenario.values[key] != 0.0 or key in scenario.dispersed]
    if not keys:
        return
    fields: set[str] = set()

    def sample() -> Any:
        controller, period = (
            probed(setup.controller, fields.update),
            scenario.values["run.control_period"],
        )
        measurement = first_measurement(setup.sensor, setup.start, period)
        return jax.tree.leaves(controller(controller.start(period), measurement))

    jax.eval_shape(sample)
    for key in keys:
        field, found, expected = NEEDED[key.rpartition(".")[2]]
        if field not in fields:
            raise InputError(f"key {key}: found {found}, expected {expected}")
