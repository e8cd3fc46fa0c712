"""Base of the controllers that a scenario can name, whose classes are in kinds/controller."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from gyrostat.core.arrays import PerWheel, Vector3
from gyrostat.scenario.component import Kind
from gyrostat.spacecraft import Gyrostat, Spacecraft

NOTIFIED, DETECTED, IGNORED = "notified", "detected", "ignored"
"""Handling of wheel failures: the controller is notified, detects them itself, or ignores them."""


class DesignCase(NamedTuple):
    """Design case of a controller.

    Attributes:
        spacecraft: Nominal spacecraft, the model of the controller.
        working: Whether the controller may use each wheel, (wheels,).
        seized: Whether each failed wheel has seized, (wheels,).
        target: Target attitude, (4,), scalar first.
        delay: Control periods from a sample to the start of its command.
    """

    spacecraft: Spacecraft
    working: np.ndarray
    seized: np.ndarray
    target: np.ndarray
    delay: int


class Beginning(NamedTuple):
    """What a controller knows at the start of a run.

    Attributes:
        momentum: Total momentum, (3,), N·m·s.
        bands: Each [[controller.band]].
        plan: Each [[controller.plan]], in the order of their times.
        wear: Wear of the wheels; None if the scenario has none.
    """

    momentum: Vector3
    bands: Sequence[Any] = ()
    plan: Sequence[Any] = ()
    wear: PerWheel | None = None


@dataclass(frozen=True, eq=False)
class ControllerKind(Kind):
    """Controller that is designed once for each target and for each notified wheel failure.

    Attributes:
        losses: Handling of wheel failures: NOTIFIED, DETECTED or IGNORED.
        follows: Whether the controller can follow a reference that moves.
    """

    losses: ClassVar[str] = NOTIFIED
    follows: ClassVar[bool] = True

    @classmethod
    def plan(cls, case: DesignCase) -> Any:
        """Design, computed outside the loop; those of one scenario have the same structure.

        Raises:
            InputError: The wheels do not suffice.
        """
        raise NotImplementedError

    def controller(self, design: Any, beginning: Beginning) -> Any:
        """Controller with a design."""
        raise NotImplementedError

    def body(self, plant: Gyrostat) -> Any:
        """Plant with what belongs to the controller; by default, the plant itself."""
        return plant
