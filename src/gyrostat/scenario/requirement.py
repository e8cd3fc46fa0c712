"""Pointing requirement of a scenario, in the terms of ECSS-E-ST-60-10C.

The error of a sample is a vector, rad: the rotation from the target to the actual attitude
(performance), or from the actual to the known attitude (knowledge). An index is computed of this
vector; its size along an axis, about or across a boresight is compared with the required value.
"""

from dataclasses import dataclass

from gyrostat.core.pictured import Described

PERFORMANCE, KNOWLEDGE = "performance", "knowledge"
INDICES: dict[str, tuple[str, str, str]] = {
    "APE": (PERFORMANCE, "absolute", "Absolute performance error: the error at each time."),
    "MPE": (PERFORMANCE, "mean", "Mean performance error: the mean of the error over a window."),
    "RPE": (
        PERFORMANCE,
        "relative",
        "Relative performance error: the error at a time, minus its mean over a window with it.",
    ),
    "PDE": (
        PERFORMANCE,
        "drift",
        "Performance drift error: difference of the means over two windows of one observation "
        "period, `stability` apart.",
    ),
    "PRE": (
        PERFORMANCE,
        "reproducibility",
        "Performance reproducibility error: difference of the means over the first window of two "
        "observation periods.",
    ),
    "AKE": (KNOWLEDGE, "absolute", "Absolute knowledge error: the error at each time."),
    "MKE": (KNOWLEDGE, "mean", "Mean knowledge error: the mean of the error over a window."),
    "RKE": (
        KNOWLEDGE,
        "relative",
        "Relative knowledge error: the error at a time, minus its mean over a window with it.",
    ),
}
"""Index -> kind of its error, what is computed of it, and its meaning."""
INSTANTS = ("any", "end", "centre")
"""Places of the time t in the window of RPE and RKE."""
AXES_OF_ERROR = ("x", "y", "z", "full", "half_cone", "about")
"""Components of the error; the last two need a boresight."""
INTERPRETATIONS = {
    "temporal": "share of time, in each of `share` of the runs",
    "ensemble": "share of runs, at all times of a run",
    "mixed": "share of time and runs together",
}
"""Statistical interpretation -> what the level is a share of."""


@dataclass(frozen=True)
class ErrorSignal:
    """Error vector of a sample that the loop records, because a requirement needs it.

    Attributes:
        kind: "performance" or "knowledge".
        boresight: Body direction, (3,): the error is resolved into a rotation across it and one
            about it; None: the rotation vector of the error.
        estimate: Signal of command, measurement or record with the known attitude; None: the
            estimate of the controller if there is one, otherwise the measured attitude.
    """

    kind: str
    boresight: tuple[float, ...] | None
    estimate: str | None = None


@dataclass(frozen=True)
class Requirement(Described):
    """Pointing requirement: with probability `level`, an index is not above `value`.

    Attributes:
        name: Name, unique in the scenario.
        index: Key of `INDICES`.
        value: Required value, rad.
        level: Probability, above 0 and below 1.
        interpretation: Key of `INTERPRETATIONS`.
        axis: One of `AXES_OF_ERROR`.
        boresight: Body direction of "half_cone" and "about", (3,); None otherwise.
        window: Window time, s; 0 for APE and AKE.
        stability: Time between the windows of PDE, from start to start, s; 0 for the others.
        instant: Place of t in the window of RPE and RKE, one of `INSTANTS`.
        during: Windows of the metrics whose intervals are the observation periods; none: the run
            after `metrics.after`.
        estimate: See `ErrorSignal`.
        share: Share of the runs of which a temporal requirement holds.
    """

    name: str
    index: str
    value: float
    level: float
    interpretation: str = "mixed"
    axis: str = "full"
    boresight: tuple[float, ...] | None = None
    window: float = 0.0
    stability: float = 0.0
    instant: str = "any"
    during: tuple[str, ...] = ()
    estimate: str | None = None
    share: float = 0.95

    @property
    def operation(self) -> str:
        """What is computed of the error: "absolute", "mean", "relative", "drift", ...."""
        return INDICES[self.index][1]

    @property
    def signal(self) -> ErrorSignal:
        """Error vector that it needs."""
        return ErrorSignal(INDICES[self.index][0], self.boresight, self.estimate)

    @property
    def metric(self) -> str:
        """Name of its metric."""
        return f"requirement.{self.name}"

    @property
    def unit(self) -> str:
        """SI unit of its metric."""
        return "1" if self.interpretation == "mixed" else "rad"

    @property
    def meaning(self) -> str:
        """Meaning of its metric."""
        if self.interpretation == "mixed":
            return f"Share of time in which {self.index} is above the required value."
        if self.interpretation == "ensemble":
            return f"Largest {self.index} of the run."
        return f"{self.index} that is not exceeded in {100.0 * self.level:.12g} % of the time."


def signals_of(requirements: tuple[Requirement, ...]) -> tuple[ErrorSignal, ...]:
    """Error vectors that requirements need, each once."""
    return tuple(dict.fromkeys(each.signal for each in requirements))
