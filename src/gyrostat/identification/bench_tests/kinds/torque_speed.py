"""Torque against speed: friction curve, motor constant and capacity of the wheel."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import RPM
from gyrostat.identification.batch import identify
from gyrostat.identification.bench_tests.bench_sheet import BenchSheet
from gyrostat.identification.bench_tests.bench_test import (
    BenchTest,
    Measured,
    Motor,
    Outcome,
    Panel,
    PlannedRecord,
)
from gyrostat.identification.bench_tests.options import option
from gyrostat.identification.bench_tests.program import Program
from gyrostat.identification.judge.acceptance import accept
from gyrostat.identification.judge.validation import validate
from gyrostat.identification.result.fit import Fit
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import static_curve

LOWEST = 0.6
"""Current of the first stair over that of the last."""
EDGE = 1.02
"""Speed of the last stair over the largest speed that is judged."""


@dataclass(frozen=True)
class TorqueSpeed(BenchTest):
    """Stairs of current in both senses, to the speed limit: one record to fit, one to confirm.

    The wheel is identified from the first record, and accepted on the second, as `validate --sheet`
    does (`gyrostat.identification.judge.acceptance`).
    """

    name = "torque-speed"
    title = "Torque against speed"
    purpose = "motor constant, friction curve, largest torque, speed and momentum"
    place = 70
    quantities = (
        "motor_constant",
        "torque_limit",
        "speed_limit",
        "momentum_limit",
        "loss_torque",
        "coast_down_time",
        "zero_crossing_torque",
        "coulomb",
        "viscous",
        "static",
        "stribeck_speed",
        "inertia",
    )

    stairs: int = option(4, "count", "Number of speeds in each sense.")
    top_speed: float | None = option(None, "speed", "Speed of the last stair.")

    def records(self, sheet: BenchSheet) -> list[PlannedRecord]:
        """See `BenchTest.records`."""
        top = self.top_speed or EDGE * sheet.value("speed_limit")
        limit = sheet.bench.current_limit
        planned = []
        for sense, word in ((1.0, "fit"), (-1.0, "confirm")):
            program = Program(sheet, self.name, sheet.bench.rate)
            for k in range(1, self.stairs + 1):
                share = k / self.stairs
                current = limit * (LOWEST + (1.0 - LOWEST) * share)
                # the second record differs: a model must predict what it was not fitted to
                speed = top * (share if sense > 0.0 or k == self.stairs else 0.8 * share)
                program.drive(sense * current, sense * speed)
                program.drive(-sense * current, -sense * speed)
            program.drive(sense * limit, 0.0)
            program.coast()
            planned.append(PlannedRecord(f"{self.name}-{word}", *program.series()))
        return planned

    def evaluate(self, sheet: BenchSheet, records: Sequence[Record], motor: Motor) -> Outcome:
        """See `BenchTest.evaluate`."""
        first, second = records
        fit = self.fit(sheet, first)
        model = fit.wheel_model()
        if model is None or not fit.converged:
            raise InputError(f"{first.name}: found no valid fit, expected a wheel")
        check = validate(
            model.static_friction(), dict(model.values), second, covariance=model.covariance()
        )
        acceptance = accept(sheet.wheel, model, check)
        values = [Measured(n, fit.parameters[n], fit.sigma[n]) for n in self._estimated(fit)]
        notes = [check.verdict, *acceptance.notes]
        reached = float(np.max(np.abs(first.speed[first.valid])))
        grid = np.linspace(-reached, reached, 201)
        grid = grid[grid != 0.0]
        friction = static_curve(model.wheel().friction)
        torques = jax.vmap(friction.torque)(jnp.asarray(grid), jnp.sign(grid))
        panel = Panel(
            "Friction torque of the identified wheel",
            "speed (rpm)",
            "torque (N·m)",
            lines=(np.array([grid / RPM, np.asarray(torques)]),),
        )
        return Outcome(tuple(values), acceptance.lines, tuple(notes), (panel,))

    def fit(self, sheet: BenchSheet, record: Record) -> Fit:
        """Identify the wheel, with the tolerances of inertia and instruments."""
        return identify(
            record,
            inertia=sheet.value("inertia"),
            hold={"stribeck_speed": sheet.value("stribeck_speed")},
            tolerance=sheet.tolerances(),
        )

    def _estimated(self, fit: Fit) -> list[str]:
        """Observable parameters that are quantities of a sheet."""
        return [n for n in fit.names if n in self.quantities and fit.observability[n].observable]
