"""Comparison of the estimators of inverse dynamics on one record of a drive."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass

from gyrostat.core.pictured import Described, Listed
from gyrostat.core.text import measured

METHODS = {
    "instruments": "instruments (IDIM-IV)",
    "output_error": "output error (DIDIM)",
    "least_squares": "least squares (IDIM-LS)",
}
"""Estimator -> title; the first one gives the values of the fit."""


@dataclass(frozen=True)
class Estimates(Described):
    """Estimates of one method.

    Attributes:
        values: Name -> estimate, SI.
        sigma: Name -> standard deviation, SI.
        torque_error: Rms of the motor torque that is not explained, relative to its rms.
        converged: Whether the iteration converged.
    """

    values: Mapping[str, float]
    sigma: Mapping[str, float]
    torque_error: float
    converged: bool


@dataclass(frozen=True)
class InverseDynamics(Listed):
    """Identification of a drive in closed loop.

    Attributes:
        prediction: Source of the predicted motion: a control law, or "filtered reference".
        cutoff: Frequency at which the windows have half of their power response, Hz.
        windows: Number of windows.
        followed: Share of the variance of the measured speed that the prediction has.
        strength: F statistic of the weakest combination of instruments.
        methods: Key of `METHODS` -> estimates.
        torque_error: Record -> relative rms torque error of the fit.
        held_out: Record that was not fitted -> relative rms torque error.
        simulated: Record -> relative rms torque error of the simulated drive; empty without a
            control law.
    """

    prediction: str
    cutoff: float
    windows: int
    followed: float
    strength: float
    methods: Mapping[str, Estimates]
    torque_error: Mapping[str, float]
    held_out: Mapping[str, float]
    simulated: Mapping[str, float]

    def to_dict(self) -> dict[str, object]:
        """Content for fit.json."""
        return asdict(self)

    def rows(self) -> Iterator[tuple[str, ...]]:
        """Rows of the comparison: method, each estimate, torque error."""
        for name, title in METHODS.items():
            each = self.methods.get(name)
            if each is None:
                count = len(next(iter(self.methods.values())).values)
                yield title, *[""] * count, "not run: it needs the right control law (--loop)"
                continue
            cells = (measured(each.values[n], each.sigma[n]) for n in each.values)
            end = f"{100.0 * each.torque_error:.3g} %"
            yield title, *cells, end if each.converged else "did not converge"

    def header(self) -> tuple[str, ...]:
        """Header of `rows`."""
        return ("method", *next(iter(self.methods.values())).values, "torque error")

    def lines(self) -> list[str]:
        """Sentences on the prediction and on the torque errors."""
        lines = [
            f"motion predicted by {self.prediction}: it has {100.0 * self.followed:.4g} % of the "
            f"variance of the measured speed; {self.windows} windows, cutoff {self.cutoff:.3g} Hz"
        ]
        for what, errors in (
            ("torque error", self.torque_error),
            ("torque error of the simulated drive", self.simulated),
            ("torque error on held-out", self.held_out),
        ):
            for record, error in errors.items():
                lines.append(f"{what} {record}: {100.0 * error:.3g} % of the rms torque")
        return lines
