"""Result of an experiment design."""

from collections.abc import Mapping
from dataclasses import dataclass

from gyrostat.core.pictured import Described, Pictured
from gyrostat.core.types import Vector
from gyrostat.core.views import lines
from gyrostat.identification.experiment.current_profiles import Limits, Shape


@dataclass(frozen=True)
class Combination(Described):
    """Predicted uncertainty of one parameter or linear combination, SI.

    Attributes:
        name: Text such as "static-coulomb".
        dimension: Key of `gyrostat.core.units.SI_UNIT`.
        value: Estimate before the record.
        before: Standard deviation before the record.
        after: Median over the wheels drawn of the standard deviation after the record.
        reliable: The standard deviation that nine of ten wheels reach.
        target: Wanted standard deviation; None without one.
        clear: Fraction of the wheels drawn whose value then exceeds three standard deviations.
    """

    name: str
    dimension: str
    value: float
    before: float
    after: float
    reliable: float
    target: float | None = None
    clear: float | None = None


@dataclass(frozen=True, repr=False)
class Design(Pictured):
    """Designed record.

    Attributes:
        shape: Family and numbers of the profile.
        numbers: Name -> number of the profile, SI.
        time: Sample times, (N,), s.
        current: Current, held from sample to sample, (N,), A.
        speed: Speed of the estimated wheel, (N,), rad/s.
        wanted: The combinations that the design is for.
        parameters: All uncertain parameters.
        reached: Time at which nine of ten wheels have all wanted standard deviations, s; None if
            not within the record or without a target.
        history: Times, (k,), s, and standard deviation of the first combination that nine of ten
            wheels have then, (k,).
        events: Median number of breakaways from rest.
        angles: Median number of breakaways at independent angles of the rotor that are worth these.
        ripple: Torque ripple assumed, N·m rms.
        needed: Number of breakaways at different angles of the rotor at which the ripple alone
            allows the targets; None without a target or ripple.
        at_rest: Whether a torque ripple affects what is wanted.
        limits: Limits of driver, wheel and record.
        speed_sigma: Standard deviation of the measured speed, rad/s.
        candidates: Number of profiles tried.
    """

    shape: Shape
    numbers: Mapping[str, float]
    time: Vector
    current: Vector
    speed: Vector
    wanted: tuple[Combination, ...]
    parameters: tuple[Combination, ...]
    reached: float | None
    history: tuple[Vector, Vector]
    events: float
    angles: float
    ripple: float
    needed: int | None
    at_rest: bool
    limits: Limits
    speed_sigma: float
    candidates: int

    @property
    def names(self) -> list[str]:
        """Wanted combinations, as text."""
        return [each.name for each in self.wanted]

    def __repr__(self) -> str:
        """Table that the command line prints."""
        return "\n".join(lines(self))
