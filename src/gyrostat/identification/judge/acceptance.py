"""Acceptance of a wheel: each quantity of a data sheet against its limits.

The measured values are those of an identified model, with its covariance, and the speed that the
record reaches. A quantity is judged only if the record confirms the model, and alone would
determine the quantity.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gyrostat.core.jax64 import jax
from gyrostat.core.text import plain
from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.identification.judge.acceptance_lines import (
    FAIL,
    NOT_JUDGED,
    Acceptance,
    Line,
    judged,
)
from gyrostat.identification.judge.validation import Validation
from gyrostat.identification.uncertainty.observability import CLEAR
from gyrostat.telemetry import Record
from gyrostat.wheel import WheelModel, WheelSheet
from gyrostat.wheel.sheet_limits import QUANTITIES, Limit

REACHED = 0.95
"""Smallest speed and current of a record, relative to those of a limit, that confirm it."""
HELD = 5
"""Number of samples over which a speed must be held to count as reached."""
NODES = 64
"""Nodes of the quadrature of a coast-down time."""
UNKNOWN = 1e-12
"""A-priori information on a parameter, relative to its value squared, that is as good as none."""

_Values = Mapping[str, Any]


def _largest_speed(record: Record, sense: int, noise: float) -> tuple[float, float]:
    """Largest speed in one sense held over `HELD` samples, and its standard deviation, rad/s.

    It is sought in every second sample and the speed is the mean of the others, so that the
    largest noise does not select itself.
    """
    speed = sense * record.speed[record.valid]
    pairs = speed[: 2 * (len(speed) // 2)].reshape(-1, 2)
    width = min(HELD, len(pairs))
    kernel = np.full(width, 1.0 / width)
    start = int(np.argmax(np.convolve(pairs[:, 0], kernel, mode="valid")))
    return float(pairs[start : start + width, 1].mean()), noise / np.sqrt(width)


class _Test:
    """Measured values of one model and record."""

    def __init__(self, sheet: WheelSheet, model: WheelModel, validation: Validation) -> None:
        self.sheet, self.model, self.validation = sheet, model, validation
        self.values = {name: float(value) for name, value in model.values.items()}
        self.names, self.covariance = model.covariance()
        record = validation.record
        self.speeds = {sense: _largest_speed(record, sense, validation.noise) for sense in (1, -1)}
        self.current = float(np.max(np.abs(record.current)))

    def parameter(self, values: _Values, name: str, sense: int) -> Any:
        """Parameter of the wheel, that of one sense if the model distinguishes them, or None."""
        side = "positive" if sense > 0 else "negative"
        return values.get(name, values.get(f"{name}_{side}"))

    def friction(self, values: _Values, speed: Any, sense: int) -> Any:
        """Friction torque against the motion at a speed of 0 or more, N·m."""
        parameters = {name: values[name] for name in self.model.friction.dimensions()}
        return sense * self.model.friction.of(**parameters).torque(sense * speed, sense)

    def quantity(self, limit: Limit, sense: int) -> Callable[[_Values], Any]:
        """Quantity of the wheel as a function of the parameters."""
        speed, current = (limit.conditions.get(n, 0.0) for n in ("speed", "current"))

        def loss(v: _Values) -> Any:
            return self.friction(v, speed, sense)

        def torque(v: _Values) -> Any:
            motor = v["motor_constant"] * current
            return motor - loss(v) if "speed" in limit.conditions else motor

        def step(v: _Values) -> Any:
            return self.friction(v, 0.0, 1) + self.friction(v, 0.0, -1)

        def coast_down(v: _Values) -> Any:
            # the substitution w = w_0 s² resolves the bend of the curve near rest
            nodes, weights = np.polynomial.legendre.leggauss(NODES)
            share, part = 0.5 * (nodes + 1.0), 0.5 * weights
            curve = jax.vmap(lambda w: self.friction(v, w, sense))(speed * share**2)
            return v["inertia"] * np.sum(part * 2.0 * speed * share / curve)

        special = {
            "loss_torque": loss,
            "torque_limit": torque,
            "zero_crossing_torque": step,
            "coast_down_time": coast_down,
        }
        return special.get(limit.quantity, lambda v: self.parameter(v, limit.quantity, sense))

    def absent(self, limit: Limit) -> str:
        """Reason why the model or the sheet does not define the quantity; empty if they do."""
        if limit.quantity in ("static_imbalance", "dynamic_imbalance"):
            return "a record of current and speed does not show it"
        test = QUANTITIES[limit.quantity].test
        if test:
            return f"the test {test} of gyrostat bench --tests shows it"
        name = "static" if limit.quantity == "zero_crossing_torque" else limit.quantity
        is_parameter = name in ("static", "stribeck_speed", "coulomb", "viscous", "inertia")
        if is_parameter and self.parameter(self.values, name, 1) is None:
            return f"the model ({self.model.friction.name}) has no {name.replace('_', ' ')}"
        if limit.quantity == "torque_limit" and "current" not in limit.conditions:
            return "the sheet states no current"
        return ""

    def unconfirmed(self, limit: Limit, slope: Vector, value: float, sense: int) -> str:
        """Reason why the record does not confirm a value of the model; empty if it does."""
        if not (self.validation.converged and self.validation.holds):
            return "the model does not predict this record"
        if not np.any(slope @ self.covariance @ slope):
            return "its value is given without a standard deviation, not identified"
        required_speed = REACHED * limit.conditions.get("speed", 0.0)
        largest_speed = max(s for n, (s, _) in self.speeds.items() if sense in (0, n))
        if largest_speed < required_speed:
            return f"the record reaches only {plain(largest_speed / RPM)} rpm"
        if self.current < REACHED * limit.conditions.get("current", 0.0):
            return f"the record reaches only {plain(self.current)} A"
        # the record gives torques and motor constant per inertia
        places = [k for k, n in enumerate(self.validation.names) if n != "inertia"]
        if limit.quantity == "inertia" or not np.any(slope[places]):
            return ""
        size = np.array([abs(self.values[self.validation.names[k]]) for k in places])
        size = np.where(size > 0.0, size, 1.0)
        information = self.validation.information[np.ix_(places, places)] * np.outer(size, size)
        part = size * slope[places]
        spread = part @ np.linalg.solve(information + UNKNOWN * np.eye(len(places)), part)
        if value**2 < CLEAR**2 * spread:
            return "the record alone does not determine it"
        return ""

    def of_model(self, limit: Limit, sense: int, *, symmetric: bool) -> Line:
        """Line of a quantity that follows from the model."""
        value, gradient = jax.value_and_grad(self.quantity(limit, sense))(self.values)
        slope = np.array([float(gradient[n]) for n in self.names])
        sigma = float(np.sqrt(max(slope @ self.covariance @ slope, 0.0)))
        line_sense = 0 if symmetric else sense
        why = self.unconfirmed(limit, slope, float(value), line_sense)
        verdict = NOT_JUDGED if why else judged(limit, float(value), sigma)
        return Line(limit, line_sense, float(value), sigma, verdict, why)

    def of_record(self, limit: Limit, sense: int) -> Line:
        """Line of a quantity that the record reaches: speed, or momentum at this speed."""
        speed, sigma = self.speeds[sense]
        value = speed
        if limit.quantity == "momentum_limit":
            inertia = self.values["inertia"]
            spread = self.model.sigma.get("inertia", 0.0)
            value, sigma = inertia * speed, float(np.hypot(inertia * sigma, spread * speed))
        verdict, why = judged(limit, value, sigma), ""
        fastest = [each.minimum for each in self.sheet.limits if each.quantity == "speed_limit"]
        full = limit.quantity == "momentum_limit" and any(speed >= least for least in fastest)
        if verdict == FAIL and value < limit.minimum and not full:
            verdict = NOT_JUDGED
            why = f"the record reaches only {plain(max(speed, 0.0) / RPM)} rpm"
        return Line(limit, sense, value, sigma, verdict, why)

    def lines(self, limit: Limit) -> list[Line]:
        """Lines of one limit: one, or one for each sense of rotation."""
        absent = self.absent(limit)
        if absent:
            return [Line(limit, 0, None, None, NOT_JUDGED, absent)]
        if limit.quantity in ("speed_limit", "momentum_limit"):
            return [self.of_record(limit, sense) for sense in (1, -1)]
        ahead, back = (float(self.quantity(limit, sense)(self.values)) for sense in (1, -1))
        symmetric = bool(np.isclose(ahead, back, rtol=1e-12, atol=0.0))
        senses = (1,) if symmetric else (1, -1)
        return [self.of_model(limit, sense, symmetric=symmetric) for sense in senses]


def accept(sheet: WheelSheet, model: WheelModel, validation: Validation) -> Acceptance:
    """Judge a wheel against its data sheet.

    Args:
        sheet: Data sheet with limits.
        model: Identified wheel, with the covariance of its parameters.
        validation: Validation of this model on the record of the acceptance test.

    Returns:
        Judgement, line by line in the order of the sheet.
    """
    test = _Test(sheet, model, validation)
    notes = []
    if "inertia" not in model.sigma:
        notes.append(
            "the inertia has no tolerance: motor constant, torques and momentum are measured "
            "relative to it"
        )
    every = (line for limit in sheet.limits for line in test.lines(limit))
    return Acceptance(sheet.name, tuple(every), tuple(notes))
