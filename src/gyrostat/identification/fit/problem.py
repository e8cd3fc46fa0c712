"""What `identify` is asked: records of one wheel, and what is known of it."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gyrostat.core.validation import require
from gyrostat.identification.fit.prediction import CurrentHold
from gyrostat.identification.read.checks import as_records
from gyrostat.telemetry import Record
from gyrostat.wheel.friction_laws import Law


@dataclass(frozen=True, eq=False)
class Problem:
    """Problem of batch identification; its fields are the arguments of `identify`.

    Attributes:
        records: Records of one wheel, fitted together.
        model: Friction model: a name, a class or "FILE.py:CLASS".
        inertia: Rotor inertia, kg·m²; held unless `free` names it.
        hold: Name -> value at which it is held, SI, or None for its default.
        free: Names estimated in addition to the default ones.
        prior: Name -> a-priori mean and standard deviation, SI; the parameter is then estimated.
        start: Name -> start value, SI.
        speed_sigma: Standard deviation of the measured speed, rad/s, one for all records or one for
            each; None to estimate it from the residuals of each record.
        loss: "quadratic", "huber" or "student".
        current_hold: Current between samples, "zero-order" or "linear".
        max_iterations: Largest number of iterations from one start, over all stages; None for the
            default.
        tolerance: Name of a given value -> relative standard deviation.
        white_noise: Whether the friction model with white noise is taken as exact.
        include: Names of further effects to average over.
        ripple: Torque ripple at breakaways and zero crossings, rms over the dry friction torque;
            None to average over it.
        posterior: Whether to sample the posterior too.
        current_quantum: Step to which the current was rounded, A; 0: not rounded; None to find it.
        speed_quantum: Step to which the speed was rounded, rad/s; 0: not rounded; None to find it.
        loop: "open" or "closed", if stated; None to test the residuals for feedback.
    """

    records: tuple[Record, ...]
    model: str | Law = "stribeck"
    inertia: float | None = None
    hold: Mapping[str, float | None] = field(default_factory=dict)
    free: Collection[str] = ()
    prior: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    start: Mapping[str, float] = field(default_factory=dict)
    speed_sigma: float | Sequence[float] | None = None
    loss: str = "quadratic"
    current_hold: CurrentHold = "zero-order"
    max_iterations: int | None = None
    tolerance: Mapping[str, float] = field(default_factory=dict)
    white_noise: bool = False
    include: Collection[str] = ()
    ripple: float | None = None
    posterior: bool = False
    current_quantum: float | None = None
    speed_quantum: float | None = None
    loop: str | None = None

    @classmethod
    def of(cls, records: Record | Sequence[Record], **options: Any) -> "Problem":
        """Problem of one record or several; an option that is None has its default.

        Raises:
            InputError: There is no record.
        """
        settings = {name: value for name, value in options.items() if value is not None}
        for name, unit in (("current_quantum", "A"), ("speed_quantum", "rad/s")):
            require(name, settings.get(name, 0.0), unit)
        return cls(as_records(records), **settings)

    def named(self, rename: Mapping[str, str]) -> "Problem":
        """Problem about these parameters only.

        Args:
            rename: Name of a parameter that is kept -> its new name.
        """
        parts: dict[str, Any] = {
            part: {rename[n]: value for n, value in getattr(self, part).items() if n in rename}
            for part in ("hold", "prior", "start")
        }
        return replace(self, free=[rename[n] for n in self.free if n in rename], **parts)

    @property
    def asked(self) -> set[str]:
        """Names of the parameters that the problem mentions."""
        return {*self.hold, *self.free, *self.prior, *self.start}

    def alone(self, place: int) -> "Problem":
        """Problem of a single one of the records.

        Args:
            place: Index of the record.
        """
        initial_speed, several = f"initial_speed_{place + 1}", "initial_speed_"
        rename = {name: "initial_speed" if name == initial_speed else name for name in self.asked}
        rename = {name: new for name, new in rename.items() if not new.startswith(several)}
        sigma = self.speed_sigma
        if sigma is not None and np.size(sigma) == len(self.records) > 1:
            sigma = float(np.asarray(sigma)[place])
        return replace(self.named(rename), records=(self.records[place],), speed_sigma=sigma)
