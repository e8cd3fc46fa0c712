"""Base of the parts that `export` designs from a wheel and writes, whose classes are in `parts`.

Their modules import what is slow to load in their methods, because the help of the command line
names the options of every part.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import in_si, numbers

if TYPE_CHECKING:
    from gyrostat.control import AttitudePID, FieldLimits
    from gyrostat.exports import Target
    from gyrostat.wheel import Wheel

GAINS, CURRENT_LIMIT, SPEED_SIGMA = "--gains", "--current-limit", "--speed-sigma"


@dataclass(frozen=True)
class Given:
    """Options of a design, as given.

    Attributes:
        values: Option -> value, or None if it is not given.
    """

    values: Mapping[str, Any]

    def si(self, option: str, dimension: str) -> float:
        """Value of an option, SI."""
        return in_si(self.values[option], dimension, option)

    def number(self, option: str) -> float:
        """Value of an option without unit."""
        return float(numbers(self.values[option], 1, None, option)[0])

    def current_limit(self) -> float:
        """Limit of the motor current, A; infinite if it is not given."""
        from gyrostat.core.validation import require

        if self.values[CURRENT_LIMIT] is None:
            return math.inf
        limit = self.si(CURRENT_LIMIT, "current")
        require(CURRENT_LIMIT, limit, "A", positive=True)
        return limit

    def law(self) -> "AttitudePID":
        """Attitude law with the gains."""
        from gyrostat.control import AttitudePID
        from gyrostat.core.validation import LARGEST

        law = AttitudePID(*map(float, numbers(self.values[GAINS], 3, None, GAINS)))
        if not all(abs(g) <= LARGEST for g in (law.proportional, law.integral, law.derivative)):
            raise InputError(
                f"{GAINS}: found {self.values[GAINS]}, expected finite numbers of size below "
                f"{LARGEST:g}"
            )
        return law


class ExportedPart:
    """Part that can be designed from a wheel and options, and written as a flight module.

    Attributes:
        name: Name on the command line.
        needs: Options that its design needs.
        takes: Options that its design can have.
        fields: Measured fields whose values can have limits -> dimension; none: inputs are not
            validated.
    """

    name: ClassVar[str]
    needs: ClassVar[tuple[str, ...]] = ()
    takes: ClassVar[tuple[str, ...]] = ()
    fields: ClassVar[Mapping[str, str]] = {}

    @classmethod
    def type(cls) -> type | None:
        """Class of the parts that are exported as they are; None if a design is always needed."""
        return None

    @classmethod
    def design(cls, wheel: "Wheel", period: float, given: Given) -> Any:
        """Part from a wheel, the control period, s, and the options.

        Raises:
            InputError: An option has a value that is not possible.
        """
        raise NotImplementedError

    @classmethod
    def module(
        cls, part: Any, period: float, limits: "Mapping[str, FieldLimits]", on_bad: str
    ) -> "Target":
        """Flight module of a part.

        Args:
            part: The part.
            period: Control period, s.
            limits: Field -> limits of its values.
            on_bad: Safe command after a rejected sample: "hold" or "zero".
        """
        raise NotImplementedError
