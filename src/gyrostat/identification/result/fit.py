"""Result of an identification, with its uncertainty."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.named_vector import NamedVector
from gyrostat.core.pictured import Described, Pictured
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.views import content, lines
from gyrostat.identification.fit.friction_torques import friction_torques
from gyrostat.identification.fit.prediction import build_wheel, wheel_dimensions
from gyrostat.identification.read.findings import Finding, Score
from gyrostat.identification.read.statistics import Whiteness
from gyrostat.identification.result.inverse_dynamics import InverseDynamics
from gyrostat.identification.result.temperature_trend import TemperatureTrend
from gyrostat.identification.uncertainty.averaging import Effect
from gyrostat.identification.uncertainty.feedback import Feedback
from gyrostat.identification.uncertainty.observability import Observability
from gyrostat.identification.uncertainty.tolerances import Propagated
from gyrostat.telemetry import Record
from gyrostat.wheel import Wheel, WheelModel
from gyrostat.wheel.friction import Friction

if TYPE_CHECKING:
    from gyrostat.identification.uncertainty.posterior import Posterior


@dataclass(frozen=True, eq=False)
class FrictionPoints(Described):
    """Measured points of a friction curve.

    Attributes:
        speed: Wheel speed, (m,), rad/s.
        torque: Friction torque with the sign of the speed, (m,), N·m.
        sigma: Standard deviations of the torque, (m,), N·m.
        when: Mean time of the samples as a fraction of the record, (m,); None if undefined.
    """

    speed: Vector
    torque: Vector
    sigma: Vector
    when: Vector | None = None


@dataclass(frozen=True)
class Candidate(Described):
    """Friction model in a comparison.

    Attributes:
        model: Name of the friction model.
        fit: Fit of this model; None if the records or the request do not allow one.
        aic: Akaike information criterion, relative to the best of the comparison; None without a
            valid fit. The same holds for `bic` and `held_out_rms`.
        bic: Bayesian (Schwarz) information criterion, relative to the best.
        held_out_rms: Root mean square residual on the held-out records, rad/s; None also without
            held-out records.
        failure: Reason why there is no valid fit or no residual on the held-out records; empty
            otherwise.
    """

    model: str
    fit: "Fit | None"
    aic: float | None
    bic: float | None
    held_out_rms: float | None
    failure: str = ""

    def to_dict(self) -> dict[str, object]:
        """Row of the comparison in fit.json."""
        return {
            "model": self.model,
            "parameters": None if self.fit is None else len(self.fit.names),
            "converged": self.fit is not None and self.fit.converged,
            "rms_speed": None if self.fit is None else self.fit.rms_speed,
            "aic": self.aic,
            "bic": self.bic,
            "held_out_rms": self.held_out_rms,
            "failure": self.failure,
        }


@dataclass(frozen=True, repr=False)
class Fit(Pictured):
    """Identified wheel; `print` shows it as a table.

    Attributes:
        model: Friction model.
        method: "batch", "steady", "torque-step", "coast" or "inverse".
        names: Estimated parameters.
        dimensions: Name -> dimension, for estimated and held parameters.
        values: Estimates, (n,), SI.
        covariance: Covariance of the estimates, (n, n), SI, including the contributions of
            correlated residuals, effects outside the model and stated tolerances.
        noise_sigma: Standard deviations caused by white noise of the speed alone, (n,), SI.
        least_squares: Estimates of plain least squares at the corrected current, (n,), SI.
        held: Name -> value that was not estimated, SI.
        observability: Name -> whether and how clearly the records show the parameter.
        converged: Whether the iteration ended at a minimum.
        iterations: Number of corrections tried.
        samples: Number of speeds used.
        crossings: Sign changes of the modelled speed; of the measured one if none is modelled.
        speed_sigma: Standard deviation of the measured speed, given or from the residuals, rad/s;
            the root mean square over all samples if the records differ.
        speed_sigmas: Standard deviation of the measured speed of each record, rad/s.
        records: Fitted records.
        predicted: Modelled speed at the samples of each record, with the deterministic effects
            found, rad/s; empty if the method models no speed.
        predicted_sigma: Standard deviation of `predicted` from the parameters alone, rad/s.
        whiteness: Independence tests of the residuals of the least-squares fit, without effects;
            None with fewer than 10 samples, or if no speed was modelled.
        warnings: Warnings, most serious first.
        friction_points: Points that a friction curve was fitted to; None for fits of the speed.
        effects: Posteriors of effects outside the friction model.
        findings: Effects that explain the least-squares residuals, best first.
        scores: Score test of each deterministic candidate effect.
        tolerances: Contribution of stated tolerances to `covariance`; None without any.
        impossible: Reasons why the estimates are not valid, one sentence each: values that no wheel
            can have, or a record that the model does not explain.
        choices: Choices of an automatic model selection; empty without one.
        comparison: Ranking of the friction models, best first, if requested.
        temperatures: Trends of parameters over temperature, if the records show any.
        posterior: Sampled posterior, if requested.
        feedback: Test for feedback from the speed to the current; None of other methods.
        inverse: Comparison of the estimators of a drive in closed loop; None of other methods.
    """

    model: type[Friction]
    method: str
    names: tuple[str, ...]
    dimensions: Mapping[str, str]
    values: Vector
    covariance: Matrix
    noise_sigma: Vector
    least_squares: Vector
    held: Mapping[str, float]
    observability: Mapping[str, Observability]
    converged: bool
    iterations: int
    samples: int
    crossings: int
    speed_sigma: float
    speed_sigmas: tuple[float, ...]
    records: tuple[Record, ...]
    predicted: tuple[Vector, ...]
    predicted_sigma: tuple[Vector, ...]
    whiteness: Whiteness | None
    warnings: tuple[str, ...] = field(default=())
    friction_points: FrictionPoints | None = None
    effects: tuple[Effect, ...] = ()
    findings: tuple[Finding, ...] = ()
    scores: tuple[Score, ...] = ()
    tolerances: Propagated | None = None
    impossible: tuple[str, ...] = ()
    choices: tuple[str, ...] = ()
    comparison: tuple[Candidate, ...] = ()
    temperatures: tuple[TemperatureTrend, ...] = ()
    posterior: "Posterior | None" = None
    feedback: Feedback | None = None
    inverse: InverseDynamics | None = None

    def __repr__(self) -> str:
        """Table that the command line prints."""
        return "\n".join(lines(self))

    @property
    def sigma(self) -> NamedVector:
        """Standard deviations of the estimates, (n,), SI; also by name: `sigma["coulomb"]`."""
        return NamedVector.of(self.names, np.sqrt(np.diag(self.covariance)))

    @property
    def variance_shares(self) -> dict[str, Vector]:
        """Fractions of record and tolerances in the variance of each estimate, name -> (n,)."""
        if self.tolerances is None:
            return {}
        parts = self.tolerances.roots**2 / np.diag(self.covariance)[:, None]
        shares = dict(zip(self.tolerances.names, parts.T, strict=True))
        return {"record": np.maximum(1.0 - parts.sum(axis=1), 0.0), **shares}

    @property
    def parameters(self) -> dict[str, float]:
        """Estimated and held parameters, name -> value, SI."""
        return {**self.held, **dict(zip(self.names, self.values.tolist(), strict=True))}

    @property
    def residuals(self) -> tuple[Vector, ...]:
        """Measured minus modelled speed of each record, rad/s; NaN at missing samples."""
        return tuple(r.speed - p for r, p in zip(self.records, self.predicted, strict=False))

    @property
    def rms_speed(self) -> float | None:
        """Root mean square of the residuals, rad/s; None if no speed was modelled."""
        if not self.predicted:
            return None
        every = np.concatenate(self.residuals)
        return float(np.sqrt(np.nanmean(every**2)))

    @property
    def correlation(self) -> Matrix:
        """Correlation of the estimates, (n, n)."""
        return self.covariance / np.outer(self.sigma, self.sigma)

    def _require(self, names: Iterable[str]) -> None:
        lacking = [n for n in names if n not in self.parameters]
        if lacking:
            friction = set(lacking) & set(self.model.dimensions())
            quantity = "friction" if friction else " and ".join(lacking).replace("_", " ")
            raise InputError(
                f"{self.method} does not identify the {quantity}: found no {', '.join(lacking)}, "
                "expected a value to hold, or another method"
            )

    def wheel(self) -> Wheel:
        """Identified wheel.

        Raises:
            InputError: A parameter of the wheel was neither identified nor held.
        """
        self._require(wheel_dimensions(self.model))
        return build_wheel(self.model, self.parameters)

    @property
    def metadata(self) -> dict[str, str]:
        """Metadata of the records (serial, date, operator, temperature), as text."""
        names = dict.fromkeys(name for r in self.records for name in r.metadata)
        return {
            name: ", ".join(
                dict.fromkeys(r.metadata[name] for r in self.records if name in r.metadata)
            )
            for name in names
        }

    def _temperature(self) -> dict[str, str]:
        """Mean temperature of the records, at which the parameters apply, as text."""
        means = [float(np.mean(r.temperature)) for r in self.records if r.temperature is not None]
        return {"temperature": f"{np.mean(means):.4g} °C"} if means else {}

    def wheel_model(self) -> WheelModel | None:
        """Content of model.toml; None if the method does not identify the friction."""
        wheel_names = [*wheel_dimensions(self.model)]
        values = {n: v for n, v in self.parameters.items() if n in wheel_names}
        if not set(self.model.dimensions()) <= set(values):
            return None
        sigma = dict(zip(self.names, self.sigma.tolist(), strict=True))
        places = [k for k, n in enumerate(self.names) if n in wheel_names]
        return WheelModel(
            friction=self.model,
            values=values,
            sigma={n: s for n, s in sigma.items() if n in wheel_names},
            origin={
                "method": self.method,
                "records": ", ".join(r.name for r in self.records),
                "samples": str(self.samples),
                **self.metadata,
                **self._temperature(),
            },
            impossible="; ".join(self.impossible),
            correlation=(
                tuple(self.names[k] for k in places),
                self.correlation[np.ix_(places, places)],
            ),
        )

    def friction_curve(self, speed: Vector) -> tuple[Vector, Vector]:
        """Friction torque over speed with its standard deviation.

        Args:
            speed: Wheel speeds, none of them zero, (m,), rad/s.

        Returns:
            Torque and its standard deviation, N·m, each (m,).

        Raises:
            InputError: The friction was neither identified nor held.
        """
        self._require(self.model.dimensions())
        names = list(self.model.dimensions())
        torques = friction_torques(self.model, self.parameters, speed)
        places = [k for k, n in enumerate(names) if n in self.names]
        columns = [self.names.index(names[k]) for k in places]
        covariance = np.zeros((len(names), len(names)))
        covariance[np.ix_(places, places)] = self.covariance[np.ix_(columns, columns)]
        slope = torques.by_parameters
        return torques.torque, np.sqrt(np.einsum("mi,ij,mj->m", slope, covariance, slope))

    def to_dict(self) -> dict[str, object]:
        """Content of fit.json."""
        return content(self)
