"""Check of a designed record: it is simulated and identified many times."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.text import aligned, plain
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.units import si_unit
from gyrostat.identification.batch import identify
from gyrostat.identification.experiment.design import Design
from gyrostat.identification.experiment.known_wheel import KnownWheel
from gyrostat.identification.fit.prediction import build_wheel
from gyrostat.identification.uncertainty.current_errors import ROUNDED
from gyrostat.telemetry import Record
from gyrostat.telemetry.signals import rounded
from gyrostat.wheel.uneven_wheel import Ripple, uneven_speeds

WEAK = 3.0
"""Prior sigma of the fit of the new record alone, in standard deviations of the earlier estimates.
It keeps the fit regular, and is taken out again."""
HEADER = ("parameter", "promised sigma", "rms error", "sigma/error", "inside 1.96 sigma", "unit")


@dataclass(frozen=True)
class Scatter:
    """Errors of one parameter or combination over the simulated records, SI.

    Attributes:
        name: Parameter or combination.
        dimension: Key of `gyrostat.core.units.SI_UNIT`.
        promised: Sigma that the design promises (median over wheels).
        rms: Root mean square of the errors.
        inside: Share of the errors inside 1.96 promised sigma.
    """

    name: str
    dimension: str
    promised: float
    rms: float
    inside: float


@dataclass(frozen=True)
class DesignCheck:
    """Simulated records of a design.

    Attributes:
        scatters: Errors of the wanted combinations and of all parameters.
        runs: Number of simulated records.
        failures: Reasons why some fits gave no valid result, one for each.
    """

    scatters: tuple[Scatter, ...]
    runs: int
    failures: tuple[str, ...]

    def rows(self) -> list[tuple[str, ...]]:
        """Rows of the table."""
        return [
            (
                each.name,
                plain(each.promised, 3),
                plain(each.rms, 3),
                f"{each.promised / each.rms:.2f}" if each.rms else "",
                f"{100.0 * each.inside:.0f} %",
                si_unit(each.dimension),
            )
            for each in self.scatters
        ]

    def lines(self) -> list[str]:
        """Lines that the command line prints."""
        lines = [self.summary]
        return [*lines, *(f"  {line}" for line in aligned(self.rows(), HEADER))]

    @property
    def summary(self) -> str:
        """Number of records, and of those without a valid fit with the first reason."""
        why = f": {self.failures[0]}" if self.failures else ""
        return f"{self.runs} simulated records, {len(self.failures)} without a valid fit{why}"


def check_design(
    known: KnownWheel,
    design: Design,
    *,
    runs: int,
    ripple: float | None,
    seed: int,
    say: Callable[[str], None] = lambda line: None,
) -> DesignCheck:
    """Simulate a designed record with wheels that agree with the earlier fit, and identify each.

    The wheels have the ripple, drifts and rounding that the design assumes. Each record is
    identified as `identify` does; its information is added to that of the earlier fit.

    Args:
        known: Estimated wheel with the covariance of its errors.
        design: The design.
        runs: Number of records.
        ripple: Torque ripple stated to `identify`, rms over the dry friction torque; None: not
            stated.
        seed: Seed of wheels, effects and noise.
        say: Function that receives progress.
    """
    random = np.random.default_rng([seed, 1])
    wheels = known.draws(runs, random)
    every = list(known.values)
    places = [every.index(name) for name in known.names]
    estimate = np.array([known.values[name] for name in known.names])
    errors, failures = [], []
    for k, record in enumerate(_records(known, design, wheels, random)):
        try:
            errors.append(_combined(known, record, estimate, ripple) - wheels[k, places])
        except InputError as error:
            failures.append(str(error))
        if (k + 1) % 10 == 0:
            say(f"  {k + 1} of {runs} records simulated")
    scatters = []
    if not errors:
        return DesignCheck((), runs, tuple(failures))
    for each in [*design.wanted, *(p for p in design.parameters if p.name not in design.names)]:
        misses = np.array(errors) @ known.contrast(each.name, "design")
        inside = float(np.mean(np.abs(misses) <= 1.96 * each.after))
        rms = float(np.sqrt(np.mean(misses**2)))
        scatters.append(Scatter(each.name, each.dimension, each.after, rms, inside))
    return DesignCheck(tuple(scatters), runs, tuple(failures))


def _records(
    known: KnownWheel, design: Design, wheels: Matrix, random: np.random.Generator
) -> list[Record]:
    """Records of the designed current with the wheels drawn, (d, m)."""
    count = len(wheels)
    values = dict(zip(known.values, wheels.T, strict=True))
    wheel = build_wheel(known.model, values)  # pyright: ignore[reportArgumentType]
    ripple = Ripple.usual(design.ripple, random.uniform(0.0, 2.0 * np.pi, (count, 2)))
    share = 2.0 * design.time / design.time[-1] - 1.0
    # one drift of all friction, as large as that of the dry friction, which is the larger torque
    drift = known.drifts[-1][0]
    growth = 1.0 + drift * random.standard_normal((count, 1)) * share
    speeds = uneven_speeds(wheel, design.time, design.current, growth, ripple)
    speeds = speeds + design.speed_sigma * random.standard_normal(speeds.shape)
    step = known.current_error / ROUNDED
    current = rounded(design.current, step)
    valid = np.ones(len(current), dtype=bool)
    return [Record(f"simulated {k}", design.time, current, w, valid) for k, w in enumerate(speeds)]


def _combined(known: KnownWheel, record: Record, estimate: Vector, ripple: float | None) -> Vector:
    """Estimates from the earlier fit and a record, (n,), SI; `InputError` without a valid fit."""
    sigma = WEAK * np.sqrt(np.diag(known.covariance))
    prior = dict(zip(known.names, zip(estimate.tolist(), sigma.tolist(), strict=True), strict=True))
    shared = set(known.values) - set(known.names) - {"current_bias", "inertia"}
    fit = identify(
        record,
        model=known.model,
        inertia=None if "inertia" in known.names else known.values["inertia"],
        hold={name: known.values[name] for name in shared},
        prior=prior,
        ripple=ripple,
    )
    if not fit.converged:
        raise InputError(f"{record.name}: found no fit that converges, expected one")
    index = [fit.names.index(name) for name in known.names]
    # in units of the prior, without which the record alone has this information
    inverse = np.linalg.inv(fit.covariance[np.ix_(index, index)] / np.outer(sigma, sigma))
    values, vectors = np.linalg.eigh(inverse - np.eye(len(sigma)))
    gained = (vectors * np.maximum(values, 0.0)) @ vectors.T
    pull = inverse @ ((fit.values[index] - estimate) / sigma)
    before = np.linalg.inv(known.covariance / np.outer(sigma, sigma))
    return estimate + sigma * np.linalg.solve(gained + before, pull)
