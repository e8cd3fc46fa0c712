"""Reading of measured waterfalls: CSV in long or wide form, HDF5, UFF58."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.unit_table import RPM
from gyrostat.core.units import known_unit
from gyrostat.microvibration.model import LOADS
from gyrostat.microvibration.tables import factor_of, numbers, read_table
from gyrostat.microvibration.universal_file import datasets, factor_of_label, unit_label
from gyrostat.microvibration.waterfall import Waterfall, Window
from gyrostat.telemetry.fault import damaged
from gyrostat.telemetry.formats.hdf5 import unit_of
from gyrostat.telemetry.read import require_readable

QUANTITIES = ("density", "amplitude", "rms")
"""What the numbers are: one-sided density, or amplitude or rms of the line in each bin."""
SUFFIXES = {
    ".csv": "csv",
    ".txt": "csv",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".uff": "uff",
    ".unv": "uff",
}
_HDF5 = "an HDF5 file of numbers"
_SPECTRA = (2, 9, 12)
"""Function types of UFF58 that are taken: auto spectrum, power spectral density, spectrum."""
_SI = {"", "n", "nm", "n2/hz", "nm2/hz", "n2m2/hz"}
"""Units of loads without signs, in which a file may say what its numbers are."""
Cells = dict[str, dict[float, tuple[Vector, Vector]]]
"""Load -> speed, rad/s -> frequencies, Hz, and numbers."""


def read_waterfall(path: str | Path, quantity: str = "density", window: str = "hann") -> Waterfall:
    """Read a waterfall.

    Args:
        path: File .csv, .h5 or .uff; see the page on microvibration for its content.
        quantity: One of `QUANTITIES`.
        window: Window of the spectra, a name of `scipy.signal.get_window`.

    Raises:
        InputError: The file cannot be read or used, or a package is missing.
    """
    file, shape = Path(path), Window.named(window)
    if quantity not in QUANTITIES:
        raise InputError(f"--quantity: found {quantity!r}, expected one of {', '.join(QUANTITIES)}")
    kind = SUFFIXES.get(file.suffix.lower())
    if kind is None:
        raise InputError(f"{file}: found {file.suffix!r}, expected {', '.join(SUFFIXES)}")
    if kind == "hdf5":
        speed, frequency, values = _hdf5(file)
    else:
        cells = _csv(file) if kind == "csv" else _universal(file)
        speed, frequency, values = _grid(file, cells)
    order = np.argsort(speed)
    step = float(np.mean(np.diff(frequency)))
    scale = {"density": 1.0, "amplitude": 0.5, "rms": 1.0}[quantity]
    if quantity != "density":
        scale /= shape.noise_bandwidth * step
    power = 1.0 if quantity == "density" else 2.0
    density = {load: scale * each[order] ** power for load, each in values.items()}
    return Waterfall(file.name, speed[order], frequency, density, shape)


def _csv(path: Path) -> Cells:
    """Cells of a CSV file: one row for each speed and frequency, or one for each load and speed."""
    header, rows = read_table(path, "a waterfall")
    at, factor = factor_of(path, header, "speed", "speed")
    speed = np.abs(factor * numbers(path, header[at], [row[at] for row in rows]))
    cells: Cells = {}
    if "load" in header:
        place = header.index("load")
        columns = [k for k in range(len(header)) if k not in (at, place)]
        frequency = numbers(path, "of the header", [header[k] for k in columns])
        for value, row in zip(speed, rows, strict=True):
            data = numbers(path, f"of {row[place]}", [row[k] for k in columns])
            _add(path, cells, row[place], float(value), frequency, data)
        return cells
    along, hertz = factor_of(path, header, "frequency", "frequency")
    frequency = hertz * numbers(path, header[along], [row[along] for row in rows])
    found = [(k, _load(path, name)) for k, name in enumerate(header) if k not in (at, along)]
    for k, load in found:
        data = numbers(path, header[k], [row[k] for row in rows])
        for value in np.unique(speed):
            chosen = speed == value
            order = np.argsort(frequency[chosen])
            part = frequency[chosen][order], data[chosen][order]
            _add(path, cells, load, float(value), *part)
    return cells


def _load(path: Path, name: str) -> str:
    """Load of a column, without its unit."""
    load = re.split(r"[_(\[ ]", name.strip())[0]
    _check_unit(path, load, name.strip()[len(load) :])
    return load


def _check_unit(path: Path, load: str, unit: str) -> None:
    plain = re.sub(r"[\s_^*·()\[\]]", "", unit.replace("²", "2")).casefold()
    if plain not in _SI:
        raise InputError(
            f"{path}: {load}: found the unit {unit.strip(' _()[]')!r}, expected N and N·m, "
            "N²/Hz and (N·m)²/Hz, or none"
        )


def _add(
    path: Path, cells: Cells, load: str, speed: float, frequency: Vector, data: Vector
) -> None:
    if load not in LOADS:
        raise InputError(f"{path}: found the load {load!r}, expected one of {', '.join(LOADS)}")
    rows = cells.setdefault(load, {})
    if speed in rows:
        raise InputError(f"{path}: {load}: found {speed / RPM:.5g} rpm twice, expected it once")
    rows[speed] = frequency, data


def _grid(path: Path, cells: Cells) -> tuple[Vector, Vector, dict[str, Matrix]]:
    """Arrays of cells, which must have the same speeds and frequencies for all loads."""
    if not cells:
        raise InputError(f"{path}: found no load, expected some of {', '.join(LOADS)}")
    rows = next(iter(cells.values()))
    speed = np.array(sorted(rows))
    frequency = rows[speed[0]][0]
    values = {}
    for load, each in cells.items():
        if sorted(each) != speed.tolist():
            raise InputError(
                f"{path}: {load}: found other speeds than those of {next(iter(cells))}"
            )
        for value, (found, _) in each.items():
            if found.shape != frequency.shape or np.max(np.abs(found - frequency)) > 1e-6 * (
                1.0 + frequency[-1]
            ):
                raise InputError(
                    f"{path}: {load} at {value / RPM:.5g} rpm: found other frequencies than at "
                    f"{speed[0] / RPM:.5g} rpm, expected the same at all speeds"
                )
        values[load] = np.array([each[value][1] for value in speed])
    return speed, frequency, values


def _hdf5(path: Path) -> tuple[Vector, Vector, dict[str, Matrix]]:
    """Arrays of an HDF5 file: datasets speed, frequency and one for each load."""
    import h5py

    require_readable(path, _HDF5)
    try:
        with h5py.File(path) as file:
            content: dict[str, Any] = {
                name: np.asarray(item[()], dtype=float)
                for name, item in file.items()
                if isinstance(item, h5py.Dataset)
            }
            units = {name: unit_of(file[name]) for name in content}
    except Exception as error:  # h5py raises errors of many classes on damaged files
        raise damaged(path, _HDF5, error) from None
    for name in ("speed", "frequency"):
        if name not in content or content[name].ndim != 1:
            raise InputError(f"{path}: found no vector {name}, expected one, {name} of the loads")
    unit = units["speed"]
    known = known_unit(unit, "speed")
    if known is None:
        raise InputError(
            f"{path}: speed: found the unit {unit!r}, expected an attribute unit such as rpm"
        )
    values = {load: content[load] for load in LOADS if load in content}
    for load in values:
        _check_unit(path, load, units[load])
    return np.abs(known.factor * content["speed"]), content["frequency"], values


def _universal(path: Path) -> Cells:
    """Cells of a UFF58 file: response direction 1 to 6, speed in rpm as z axis value."""
    cells: Cells = {}
    for each in datasets(path):
        if each["func_type"] not in _SPECTRA:
            continue
        direction = abs(int(each["rsp_dir"]))
        if not 1 <= direction <= len(LOADS):
            raise InputError(f"{path}: found the direction {direction}, expected 1 to 6")
        load = LOADS[direction - 1]
        _check_unit(path, load, unit_label(path, each, "ordinate"))
        speed = factor_of_label(path, each, "z_axis", "speed", "rpm") * float(each["z_axis_value"])
        hertz = factor_of_label(path, each, "abscissa", "frequency", "Hz")
        _add(path, cells, load, speed, hertz * np.asarray(each["x"]), np.real(each["data"]))
    return cells
