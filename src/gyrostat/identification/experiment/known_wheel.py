"""Wheel with uncertain parameters, read from an identification or a model file."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.experiment.record_effects import (
    RIPPLE,
    ROUNDING,
    Drifts,
    RecordEffects,
    expected_size,
    found_drifts,
)
from gyrostat.identification.fit.prediction import wheel_dimensions
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.result.fit_json import read_fit
from gyrostat.identification.uncertainty.averaging import Effect
from gyrostat.identification.uncertainty.effects import dry_friction
from gyrostat.identification.uncertainty.sigmas import square_root
from gyrostat.wheel import WheelModel
from gyrostat.wheel.friction import Friction
from gyrostat.wheel.friction_laws import friction_law, law_below, static

_TRIALS = 50
"""Number of draws tried for each admissible one."""
_TERM = re.compile(r"([+-]?)(?:([0-9.]+(?:e[+-]?[0-9]+)?)\*)?([a-z_]+)")


@dataclass(frozen=True)
class KnownWheel:
    """Estimates of a wheel with the covariance of their errors.

    Attributes:
        model: Friction model.
        values: Name -> value of all parameters of the wheel and of `current_bias`, SI.
        names: Names of the n uncertain parameters among them.
        covariance: Covariance of their errors, (n, n), SI.
        speed_sigma: Standard deviation of the measured speed in the identified records, rad/s;
            None if unknown.
        ripple: Torque ripple that the records show, rms over the dry friction torque, root mean
            square over its posterior.
        drifts: Drifts of friction that the records show (`RecordEffects`).
        current_error: Standard deviation of the error of a held current, A; zero if the records do
            not show that it was rounded.
    """

    model: type[Friction]
    values: Mapping[str, float]
    names: tuple[str, ...]
    covariance: Matrix
    speed_sigma: float | None = None
    ripple: float = 0.0
    drifts: Drifts = RecordEffects.drifts
    current_error: float = 0.0

    @classmethod
    def from_fit(cls, fit: Fit) -> Self:
        """Take the wheel of an identification.

        Raises:
            InputError: The fit is not valid, or a parameter of the wheel is unknown.
        """
        fit.wheel()
        if not fit.converged:
            raise InputError("fit: found one that did not converge, expected a valid one")
        effects = {effect.name: effect for effect in fit.effects}
        return cls._of_parts(
            fit.model, fit.parameters, fit.names, fit.covariance, fit.speed_sigma, effects
        )

    @classmethod
    def from_model(cls, model: WheelModel) -> Self:
        """Take the wheel of a model file.

        Raises:
            InputError: The model has no uncertainty, or a parameter of the wheel is missing.
        """
        model.wheel()
        if not model.sigma:
            raise InputError(
                "wheel model: found no table [sigma], expected a model.toml or fit.json of "
                "gyrostat identify"
            )
        names, covariance = model.covariance()
        return cls._of_parts(model.static_friction(), model.values, names, covariance, None, {})

    @classmethod
    def read(cls, path: Path, *, force: bool = False) -> Self:
        """Read a fit.json.

        Args:
            path: Path of the file.
            force: Whether to accept a wheel that its identification marked as impossible.

        Raises:
            InputError: The file is not a fit.json of a wheel with friction, or the fit is not
                valid.
        """
        parse = partial(_content, path)
        model, values, names, covariance, noise, effects = read_fit(path, parse, force=force)
        missing = set(wheel_dimensions(model)) - set(values)
        if missing:
            raise InputError(f"{path}: found no {min(missing)}, expected its value")
        finite = np.isfinite(covariance).all() and np.isfinite([*values.values(), noise]).all()
        if not finite or covariance.shape != (len(names), len(names)):
            raise InputError(f"{path}: found numbers that are not finite, expected finite ones")
        return cls._of_parts(model, values, names, covariance, noise, effects)

    @classmethod
    def _of_parts(
        cls,
        model: type[Friction],
        values: Mapping[str, float],
        names: tuple[str, ...],
        covariance: Matrix,
        speed_sigma: float | None,
        effects: Mapping[str, Effect],
    ) -> Self:
        """Keep the parameters that any record of the wheel has."""
        wheel_names = (*wheel_dimensions(model), "current_bias")
        places = [k for k, n in enumerate(names) if n in wheel_names]
        rounding = effects.get(ROUNDING)
        return cls(
            model=model,
            values={n: values.get(n, 0.0) for n in wheel_names},
            names=tuple(names[k] for k in places),
            covariance=covariance[np.ix_(places, places)],
            speed_sigma=speed_sigma or None,
            ripple=expected_size(effects, RIPPLE),
            drifts=found_drifts(effects),
            current_error=(rounding.prior or 0.0)
            if rounding is not None and rounding.likely
            else 0.0,
        )

    def effects(self, ripple: float) -> RecordEffects:
        """Effects that a further record has.

        Args:
            ripple: Torque ripple, rms, N·m.
        """
        return RecordEffects(ripple, self.drifts, self.current_error)

    def dry_torque(self) -> float:
        """Mean of the dry friction torques, N·m; the reference of `ripple`."""
        return dry_friction(self.model, self.values)

    def contrast(self, text: str, where: str) -> Vector:
        """Coefficients of a linear combination of the uncertain parameters, (n,).

        Args:
            text: A parameter, or a combination such as "static-coulomb" or "2*viscous+coulomb".
            where: Option, for the message.

        Raises:
            InputError: The text is no combination of uncertain parameters.
        """
        compact = text.replace(" ", "")
        terms = list(_TERM.finditer(compact))
        if not terms or "".join(t.group() for t in terms) != compact:
            raise InputError(f"{where}: found {text!r}, expected one such as static-coulomb")
        coefficients = np.zeros(len(self.names))
        for sign, factor, name in (t.groups() for t in terms):
            if name not in self.names:
                raise InputError(
                    f"{where}: found {name!r}, expected a parameter that the fit estimates: "
                    f"{', '.join(self.names)}"
                )
            coefficients[self.names.index(name)] += float(f"{sign}{factor or 1}")
        if not coefficients.any():
            raise InputError(f"{where}: found {text!r}, which is always zero, expected another")
        return coefficients

    def dimension(self, text: str, where: str) -> str:
        """Dimension of a linear combination, a key of `gyrostat.core.units.SI_UNIT`.

        Args:
            text: As for `contrast`.
            where: Option, for the message.

        Raises:
            InputError: The text is no combination of parameters of one dimension.
        """
        dimensions = {**wheel_dimensions(self.model), "current_bias": "current"}
        names = np.array(self.names)[self.contrast(text, where) != 0.0]
        term_dimensions = {dimensions[name] for name in names}
        if len(term_dimensions) > 1:
            raise InputError(f"{where}: found {text!r}, expected parameters of one unit")
        return term_dimensions.pop()

    def draws(self, count: int, random: np.random.Generator, ripple: float = 0.0) -> Matrix:
        """Draw wheels from the distribution of the estimates, without impossible ones.

        Args:
            count: Number of wheels.
            random: Random generator.
            ripple: Standard deviation of the breakaway torque over the angle of the rotor, N·m,
                added to each draw of a static torque.

        Returns:
            Parameters in the order of `values`, (count, all), SI. A limit that few draws meet is
            imposed on the others: friction of 0 or more, static torque not below the Coulomb
            torque.
        """
        every = list(self.values)
        samples = np.tile([self.values[n] for n in every], (_TRIALS * count, 1))
        places = [every.index(n) for n in self.names]
        noise = random.standard_normal((len(samples), len(places)))
        samples[:, places] += noise @ square_root(self.covariance).T
        nearest = self.nearest_possible(samples)
        possible = np.flatnonzero(np.all(nearest == samples, axis=1))
        order = np.concatenate([possible, np.setdiff1d(np.arange(len(samples)), possible)])
        wheels = nearest[order[:count]]
        for name, reference in self.model.vanishing_at.items():
            index = every.index(name)
            wheels[:, index] += ripple * random.standard_normal(count)
            wheels[:, index] = np.maximum(wheels[:, index], wheels[:, every.index(reference)])
        return wheels

    def nearest_possible(self, drawn: Matrix) -> Matrix:
        """Nearest wheels that can exist.

        Args:
            drawn: Parameters in the order of `values`, (m, all), SI.
        """
        every, wheels = list(self.values), drawn.copy()
        for name in set(self.model.dimensions()) - set(self.model.signed()):
            least = 0.1 * self.values[name] if name in self.model.held_by_default else 0.0
            wheels[:, every.index(name)] = np.maximum(wheels[:, every.index(name)], least)
        for name in ("inertia", "motor_constant"):
            value, index = self.values[name], every.index(name)
            wheels[:, index] = value * np.maximum(wheels[:, index] / value, 0.1)
        for name, reference in self.model.vanishing_at.items():
            index = every.index(name)
            wheels[:, index] = np.maximum(wheels[:, index], wheels[:, every.index(reference)])
        return wheels


def _content(path: Path, content: Mapping[str, Any]) -> tuple[Any, ...]:
    """Model, values, names, covariance, speed noise and effects in a fit.json."""
    parameters, names = content["parameters"], tuple(content["correlation"]["names"])
    sigma = np.array([float(parameters[n]["sigma"]) for n in names])
    covariance = np.array(content["correlation"]["matrix"], dtype=float) * np.outer(sigma, sigma)
    values = {n: float(v) for n, v in content["held"].items()}
    values |= {n: float(row["value"]) for n, row in parameters.items()}
    law, noise = content.get("law"), float(content["speed_sigma"])
    if law is None:
        model = friction_law(content["model"], f"{path}: model")
    else:
        digests = {str(name): str(digest) for name, digest in law["sources"].items()}
        law_class, _ = law_below(path.parent, law["python"], f"{path}: law", digests)
        model = static(law_class, f"{path}: law")
    effects = {e["name"]: Effect(**e) for e in content.get("effects", ())}
    return model, values, names, covariance, noise, effects
