"""Test-bench record of a wheel."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.telemetry.fault import counted


@dataclass(frozen=True, eq=False)
class Record:
    """Motor current and wheel speed over time, as measured, neither resampled nor smoothed.

    Arrays are copied, made read-only and checked when a record is built.

    Attributes:
        name: Name of the record in messages and reports.
        time: Time, (N,), s, strictly increasing, N >= 2; any start and spacing.
        current: Motor current, (N,), A, signed.
        speed: Wheel speed, (N,), rad/s; NaN exactly where the sample is missing.
        valid: Whether the speed sample is present, (N,), bool.
        temperature: Temperature, (N,), °C, or None.
        setpoint: Commanded speed, (N,), rad/s, or None. If the file gave no unit, only its sign is
            used.
        notes: Remarks of the reader on how it changed the data.

    Raises:
        InputError: An array violates one of these conditions.
    """

    name: str
    time: NDArray[np.float64]
    current: NDArray[np.float64]
    speed: NDArray[np.float64]
    valid: NDArray[np.bool_]
    temperature: NDArray[np.float64] | None = None
    setpoint: NDArray[np.float64] | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self):
        fields = ["time", "current", "valid", "speed", "temperature", "setpoint"]
        present = [field for field in fields if getattr(self, field) is not None]
        for field in present:
            self._own(field)
        if self.time.size < 2:
            raise self._fault("time", counted(self.time.size), "at least 2")
        for field in present:
            series = getattr(self, field)
            if series.shape != self.time.shape:
                raise self._fault(
                    field, counted(series.size, "value"), f"{self.time.size}, as in time"
                )
            if field == "speed":
                bad = np.isinf(series) | (np.isnan(series) == self.valid)
                self._refuse(bad, field, "a finite number where valid is True, NaN elsewhere")
            else:
                self._refuse(~np.isfinite(series), field, "a finite number")
        late = np.append(False, np.diff(self.time) <= 0.0)
        self._refuse(late, "time", "more than the time before it")

    def scaled(
        self, *, current_scale: float = 1.0, speed_scale: float = 1.0, clock: float = 1.0
    ) -> "Record":
        """Copy of the record with corrected sensor scales.

        Args:
            current_scale: True current over measured current.
            speed_scale: True speed over measured speed.
            clock: True time over recorded time.
        """
        factors = {"current": current_scale, "speed": speed_scale, "time": clock}
        changed = {field: factor for field, factor in factors.items() if factor != 1.0}
        if not changed:
            return self
        return replace(
            self,
            **{field: factor * getattr(self, field) for field, factor in changed.items()},
            notes=(*self.notes, *(f"{f} scaled by {k:g} as requested" for f, k in changed.items())),
        )

    def _own(self, field: str) -> None:
        """Replace an array by a read-only copy: bool for valid, float64 otherwise."""
        series = np.array(getattr(self, field))
        kinds, wanted = ("b", "truth values") if field == "valid" else ("iuf", "real numbers")
        if series.ndim != 1 or series.dtype.kind not in kinds:
            found = f"shape {series.shape} of {series.dtype}"
            raise self._fault(field, found, f"shape (N,) of {wanted}")
        series = series.astype(bool if field == "valid" else np.float64)
        series.setflags(write=False)
        object.__setattr__(self, field, series)

    def _refuse(self, bad: NDArray[np.bool_], field: str, expected: str) -> None:
        if np.any(bad):
            index = int(np.argmax(bad))
            found = repr(float(getattr(self, field)[index]))
            raise self._fault(f"{field}[{index}]", found, expected)

    def _fault(self, where: str, found: str, expected: str) -> InputError:
        return InputError(f"{self.name}: {where}: found {found}, expected {expected}")
