"""Test-bench record of a wheel."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.annotations import notes_of
from gyrostat.core.errors import InputError
from gyrostat.core.pictured import PicturedText
from gyrostat.telemetry.fault import counted
from gyrostat.telemetry.role import Role


@dataclass(frozen=True, eq=False)
class Record(PicturedText):
    """Measured motor current and wheel speed over time, neither resampled nor smoothed.

    Arrays are copied, made read-only and checked when a record is built.

    Attributes:
        name: Name of the record in messages and reports.
        time: Time, strictly increasing with any start and spacing, (N,) with N >= 2, s.
        current: Motor current with sign, (N,), A.
        speed: Wheel speed, (N,), rad/s; NaN exactly where the sample is missing.
        valid: Whether the speed sample is present, (N,), bool.
        temperature: Temperature, (N,), °C, or None.
        setpoint: Commanded speed, (N,), rad/s, or only its direction if it has no unit; or None.
        reference: Commanded angle of a drive in position control, (N,), rad, or None.
        torque: Reaction torque about the spin axis that the bench measured, (N,), N·m, or None.
        notes: Changes that the reader made to the data, one note each.
        restart: Whether a segment with its own initial speed begins at the sample, because the
            motion since the previous sample is unknown, (N,), bool; None if the record was not
            searched for gaps (`gyrostat.telemetry.cut`).
        averaged: Whether the speed is the mean over the interval before each sample, as for
            differences of an angle and counts of pulses.
        metadata: Metadata from the file: serial, date, operator, temperature.

    Raises:
        InputError: An array violates one of these conditions.
    """

    name: str
    time: Annotated[
        NDArray[np.float64], Role("time", ("time", "t"), "time", required=True, written="time_s")
    ]
    current: Annotated[
        NDArray[np.float64],
        Role("current", ("current", "i"), "current", required=True, written="current_A"),
    ]
    speed: Annotated[
        NDArray[np.float64],
        Role(
            "speed",
            ("speed", "omega", "ω", "velocity", "w"),
            "speed",
            required=True,
            written="speed_rad/s",
        ),
    ]
    valid: NDArray[np.bool_]
    temperature: Annotated[
        NDArray[np.float64] | None,
        Role("temperature", ("temperature", "temp"), "temperature", written="temperature_degC"),
    ] = None
    # only the sign of a setpoint without unit is used
    setpoint: Annotated[
        NDArray[np.float64] | None,
        Role(
            "setpoint", ("setpoint", "direction"), "speed", unit_optional=True, written="setpoint"
        ),
    ] = None
    reference: Annotated[
        NDArray[np.float64] | None,
        Role("reference", ("reference_angle", "reference"), "angle", written="reference_angle_rad"),
    ] = None
    torque: Annotated[
        NDArray[np.float64] | None,
        Role("torque", ("torque", "reaction_torque"), "torque", written="torque_N·m"),
    ] = None
    notes: tuple[str, ...] = ()
    restart: NDArray[np.bool_] | None = None
    averaged: bool = False
    metadata: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self):
        names = ["time", "current", "valid", "speed", *CHANNELS, "restart"]
        present = [name for name in names if getattr(self, name) is not None]
        for name in present:
            self._freeze(name)
        if self.time.size < 2:
            raise self._fault("time", counted(self.time.size), "at least 2")
        for name in present:
            series = getattr(self, name)
            if series.shape != self.time.shape:
                raise self._fault(
                    name, counted(series.size, "value"), f"{self.time.size}, as in time"
                )
            if name == "speed":
                bad = np.isinf(series) | (np.isnan(series) == self.valid)
                self._refuse(bad, name, "a finite number where valid is True, NaN elsewhere")
            else:
                self._refuse(~np.isfinite(series), name, "a finite number")
        late = np.append(False, np.diff(self.time) <= 0.0)
        self._refuse(late, "time", "more than the time before it")

    @property
    def segments(self) -> list[slice]:
        """Index ranges of the segments, in order; there is no gap within a segment."""
        starts = [] if self.restart is None else np.flatnonzero(self.restart[1:]) + 1
        edges = [0, *(int(k) for k in starts), self.time.size]
        return [slice(a, b) for a, b in pairwise(edges)]

    def scaled(
        self, *, current_scale: float = 1.0, speed_scale: float = 1.0, clock: float = 1.0
    ) -> "Record":
        """Copy of the record with corrected sensor scales.

        Args:
            current_scale: True current divided by measured current.
            speed_scale: True speed divided by measured speed.
            clock: True time divided by recorded time.
        """
        factors = {"current": current_scale, "speed": speed_scale, "time": clock}
        scales = {name: factor for name, factor in factors.items() if factor != 1.0}
        if not scales:
            return self
        return replace(
            self,
            **{name: factor * getattr(self, name) for name, factor in scales.items()},
            notes=(*self.notes, *(f"{f} scaled by {k:g} as requested" for f, k in scales.items())),
        )

    def _freeze(self, name: str) -> None:
        """Replace an array by a read-only copy: bool for valid, float64 otherwise."""
        series = np.array(getattr(self, name))
        truth = name in ("valid", "restart")
        kinds, type_name = ("b", "truth values") if truth else ("iuf", "real numbers")
        if series.ndim != 1 or series.dtype.kind not in kinds:
            found = f"shape {series.shape} of {series.dtype}"
            raise self._fault(name, found, f"shape (N,) of {type_name}")
        series = series.astype(bool if truth else np.float64)
        series.setflags(write=False)
        object.__setattr__(self, name, series)

    def _refuse(self, bad: NDArray[np.bool_], name: str, expected: str) -> None:
        if np.any(bad):
            index = int(np.argmax(bad))
            found = repr(float(getattr(self, name)[index]))
            raise self._fault(f"{name}[{index}]", found, expected)

    def _fault(self, where: str, found: str, expected: str) -> InputError:
        return InputError(f"{self.name}: {where}: found {found}, expected {expected}")


COLUMNS = notes_of(Record, Role)
"""Field of a record that is a column of its file -> its role."""
CHANNELS = tuple(name for name, role in COLUMNS.items() if not role.required)
"""Columns beside time, current and speed, which a record need not have."""
