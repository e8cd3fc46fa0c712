"""Result of an identification, with its uncertainty."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.named_vector import NamedVector
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.averaging import Effect
from gyrostat.identification.findings import Finding, Score
from gyrostat.identification.fit_json import content
from gyrostat.identification.fit_text import table
from gyrostat.identification.observability import Observability
from gyrostat.identification.prediction import build_wheel, wheel_dimensions
from gyrostat.identification.statistics import Whiteness
from gyrostat.identification.tolerances import Propagated
from gyrostat.telemetry import Record
from gyrostat.wheel import Wheel, WheelModel
from gyrostat.wheel.friction import Friction

if TYPE_CHECKING:
    from gyrostat.identification.comparison import Candidate
    from gyrostat.identification.temperature import TemperatureTrend


@dataclass(frozen=True, eq=False)
class FrictionPoints:
    """Points of a friction curve, measured one by one.

    Attributes:
        speed: (m,) rad/s.
        torque: (m,) friction torque with the sign of the speed, N·m.
        sigma: (m,) standard deviations of the torque, N·m.
        when: (m,) mean time of the samples as a share of the record; None where it means nothing.
    """

    speed: Vector
    torque: Vector
    sigma: Vector
    when: Vector | None = None


@partial(jax.jit, static_argnums=0)
def _curve_and_slope(model: type[Friction], values, speeds):
    """Friction torque over speed, and its derivative with respect to each parameter."""
    names = tuple(model.dimensions())

    def torque(theta, speed):
        return model(**dict(zip(names, theta, strict=True))).torque(speed, jnp.sign(speed))

    over_speed = (None, 0)
    curve = jax.vmap(torque, over_speed)(values, speeds)
    return curve, jax.vmap(jax.jacfwd(torque), over_speed)(values, speeds)


@dataclass(frozen=True, repr=False)
class Fit:
    """An identified wheel; `print` shows it as a table.

    Attributes:
        model: friction model.
        method: "batch", "steady", "torque-step" or "coast".
        names: estimated parameters.
        dimensions: name -> dimension, for estimated and held parameters.
        values: (n,) estimates, SI.
        covariance: (n, n), SI: with what correlated residuals, effects beside the model and stated
            tolerances add.
        noise_sigma: (n,) standard deviations that white noise of the speed alone would cause, SI.
        least_squares: (n,) estimates of plain least squares, before effects beside the model were
            taken into account, SI.
        held: name -> value that was not estimated, SI.
        observability: name -> whether and how clearly the records show the parameter.
        converged: whether the iteration ended at a minimum.
        iterations: corrections tried.
        samples: speeds used.
        crossings: sign changes of the modelled speed; of the measured one where none is modelled.
        speed_sigma: standard deviation of the measured speed, rad/s: given, or from the residuals;
            the mean square of those of all samples where the records differ.
        speed_sigmas: the same for each record.
        records: what was fitted.
        predicted: modelled speed at the samples of each record, rad/s, with the effects found of
            definite shape; empty where the method models no speed.
        predicted_sigma: its standard deviation from the parameters alone, rad/s.
        whiteness: tests of the residuals of the least-squares fit, without any such effect, for
            independence; None with fewer than 10 samples, or where no speed was modelled.
        warnings: what a reader should know before using the result.
        friction_points: what a friction curve was fitted to; None for fits of the speed.
        effects: what the records say of effects beside the friction model.
        findings: effects that explain what the residuals of least squares show, best first.
        scores: test of each candidate effect of definite shape.
        tolerances: what stated tolerances add to `covariance`; None without any.
        impossible: values that no wheel has, one sentence each.
        choices: what an automatic choice of the model included; empty without one.
        comparison: ranking of the friction models, best first, where it was asked for.
        temperatures: trends of parameters over temperature, where the records show any.
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
    comparison: "tuple[Candidate, ...]" = ()
    temperatures: "tuple[TemperatureTrend, ...]" = ()

    def __repr__(self) -> str:
        """The table that the command line prints."""
        return "\n".join(table(self))

    @property
    def sigma(self) -> NamedVector:
        """Standard deviations of the estimates, (n,), SI; also by name: `sigma["coulomb"]`."""
        return NamedVector.of(self.names, np.sqrt(np.diag(self.covariance)))

    @property
    def variance_shares(self) -> dict[str, Vector]:
        """Shares of record and tolerances in the variance of each estimate, name -> (n,)."""
        if self.tolerances is None:
            return {}
        parts = self.tolerances.roots**2 / np.diag(self.covariance)[:, None]
        own = dict(zip(self.tolerances.names, parts.T, strict=True))
        return {"record": np.maximum(1.0 - parts.sum(axis=1), 0.0), **own}

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
        """Root mean square of the residuals, rad/s; None where no speed was modelled."""
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
            what = "friction" if friction else " and ".join(lacking).replace("_", " ")
            raise InputError(
                f"{self.method} does not identify the {what}: found no {', '.join(lacking)}, "
                "expected a value to hold, or another method"
            )

    def wheel(self) -> Wheel:
        """The identified wheel.

        Raises:
            InputError: a parameter of it was neither identified nor held.
        """
        self._require(wheel_dimensions(self.model))
        return build_wheel(self.model, self.parameters)

    @property
    def metadata(self) -> dict[str, str]:
        """What the records say of themselves (serial, date, operator, temperature), as one text."""
        names = dict.fromkeys(name for r in self.records for name in r.metadata)
        return {
            name: ", ".join(
                dict.fromkeys(r.metadata[name] for r in self.records if name in r.metadata)
            )
            for name in names
        }

    def _temperature(self) -> dict[str, str]:
        """Mean temperature of the records, to which the parameters belong, as text."""
        means = [float(np.mean(r.temperature)) for r in self.records if r.temperature is not None]
        return {"temperature": f"{np.mean(means):.4g} °C"} if means else {}

    def wheel_model(self) -> WheelModel | None:
        """What model.toml holds; None where the method does not identify the friction."""
        known = [*wheel_dimensions(self.model)]
        values = {n: v for n, v in self.parameters.items() if n in known}
        if not set(self.model.dimensions()) <= set(values):
            return None
        sigma = dict(zip(self.names, self.sigma.tolist(), strict=True))
        own = [k for k, n in enumerate(self.names) if n in known]
        return WheelModel(
            friction=self.model,
            values=values,
            sigma={n: s for n, s in sigma.items() if n in known},
            origin={
                "method": self.method,
                "records": ", ".join(r.name for r in self.records),
                "samples": str(self.samples),
                **self.metadata,
                **self._temperature(),
            },
            impossible="; ".join(self.impossible),
            correlation=(
                tuple(self.names[k] for k in own),
                self.correlation[np.ix_(own, own)],
            ),
        )

    def friction_curve(self, speed: Vector) -> tuple[Vector, Vector]:
        """Friction torque over speed with its standard deviation.

        Args:
            speed: (m,) rad/s, none of them zero.

        Returns:
            Torque and its standard deviation, N·m, each (m,).

        Raises:
            InputError: the friction was neither identified nor held.
        """
        self._require(self.model.dimensions())
        names = list(self.model.dimensions())
        values = jnp.array([self.parameters[n] for n in names])
        curve, slope = _curve_and_slope(self.model, values, jnp.asarray(speed))
        covariance = np.zeros((len(names), len(names)))
        own = [(i, self.names.index(n)) for i, n in enumerate(names) if n in self.names]
        for i, a in own:
            for j, b in own:
                covariance[i, j] = self.covariance[a, b]
        variance = np.einsum("mi,ij,mj->m", np.asarray(slope), covariance, np.asarray(slope))
        return np.asarray(curve), np.sqrt(variance)

    def to_dict(self) -> dict[str, object]:
        """The content of fit.json."""
        return content(self)
