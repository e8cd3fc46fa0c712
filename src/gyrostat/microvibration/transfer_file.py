"""Reading of transfers to the line of sight: CSV, UFF58, and NASTRAN's OP2, OP4 and DMIG punch."""

import importlib
import re
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import eigh

from gyrostat.core.errors import InputError
from gyrostat.core.extras import missing
from gyrostat.microvibration.model import LOADS, TWO_PI
from gyrostat.microvibration.tables import factor_of, numbers, read_table
from gyrostat.microvibration.transfer import FrequencyResponse, ModalModel
from gyrostat.microvibration.universal_file import datasets, factor_of_label, unit_label
from gyrostat.telemetry.fault import damaged
from gyrostat.telemetry.read import require_readable

SIGHT = ("x", "y")
"""Axes about which the line of sight turns."""
UNIVERSAL, OP4, OP2, PUNCH = (".uff", ".unv"), (".op4",), (".op2",), (".pch", ".bdf", ".dat")
FREQUENCY_RESPONSE = 4
"""Function type of UFF58."""
_ANGLES = (8, 0, 1)
"""Data types of UFF58 of an angle: displacement, unknown and general."""
_OTHERS = {2: "stress", 3: "strain", 9: "force", 11: "velocity", 12: "acceleration"}
"""Names of other data types, for the error message."""
_NASTRAN = "a file of NASTRAN"
Transfer = FrequencyResponse | ModalModel


def read_transfer(
    path: Path,
    *,
    damping: float | None = None,
    nodes: tuple[int, ...] = (),
    sight_node: int | None = None,
) -> Transfer:
    """Read a frequency response or a modal model.

    Args:
        path: File .csv, .uff, .op2, .op4 or .pch; see the page on microvibration for its content.
        damping: Damping ratio of all modes, where the file has none.
        nodes: Nodes of the wheels, in their order; needed by a punch of stiffness and mass.
        sight_node: Node whose rotations about x and y are the line of sight; likewise.

    Raises:
        InputError: The file cannot be read or used, or a package is missing.
    """
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return _csv(path, damping)
    if suffix in UNIVERSAL:
        return _universal(path, nodes)
    if suffix in OP4:
        content = _call(path, "pyyeti.nastran.op4", "read")
        return _matrices(path, content, damping)
    if suffix in OP2:
        content = _call(path, "pyyeti.nastran.op2", "rdmats")
        return _matrices(path, content, damping)
    if suffix in PUNCH:
        content = _call(path, "pyyeti.nastran.bulk", "rddmig")
        return _reduced(path, content, damping, nodes, sight_node)
    raise InputError(f"{path}: found {suffix!r}, expected .csv, .uff, .op2, .op4 or .pch")


def _csv(path: Path, damping: float | None) -> Transfer:
    """Frequency response with columns Fx_re, Fx_im, ..., or modal model with Fx, ..., los_x."""
    header, rows = read_table(path, "a transfer to the line of sight")
    at, factor = factor_of(path, header, "frequency", "frequency")

    def column(name: str) -> Any:
        k = header.index(name)
        return numbers(path, name, [row[k] for row in rows])

    wheel = column("wheel").astype(int) if "wheel" in header else np.ones(len(rows), dtype=int)
    names, place = np.unique(wheel, return_inverse=True)
    frequency = factor * numbers(path, header[at], [row[at] for row in rows])
    if "los" in header:
        _require(path, header, [f"{load}_{part}" for load in LOADS for part in ("re", "im")])
        sight = [row[header.index("los")] for row in rows]
        if not set(sight) <= set(SIGHT):
            raise InputError(f"{path}: column los: found {sorted(set(sight))}, expected x or y")
        loads = np.array([column(f"{x}_re") + 1j * column(f"{x}_im") for x in LOADS]).T
        grid, line = np.unique(frequency, return_inverse=True)
        values = np.full((len(grid), len(names), 2, 6), np.nan, dtype=complex)
        values[line, place, [SIGHT.index(s) for s in sight]] = loads
        if np.isnan(values).any():
            raise InputError(
                f"{path}: expected one row for each frequency, wheel and axis x, y of the line of "
                "sight"
            )
        return FrequencyResponse(grid, values)
    _require(path, header, [*LOADS, "los_x", "los_y"])
    ratio = column("damping") if "damping" in header else np.full(len(rows), _ratio(path, damping))
    first = place == 0
    count = int(first.sum())
    if any(int((place == k).sum()) != count for k in range(len(names))):
        raise InputError(f"{path}: expected the same modes for each wheel")
    inputs = np.array(
        [np.array([column(x) for x in LOADS]).T[place == k] for k in range(len(names))]
    )
    outputs = np.array([column("los_x"), column("los_y")]).T[first]
    return ModalModel(frequency[first], ratio[first], inputs, outputs)


def _require(path: Path, header: list[str], names: list[str]) -> None:
    lacking = [name for name in names if name not in header]
    if lacking:
        raise InputError(f"{path}: found no column {lacking[0]}, expected {', '.join(names)}")


def _ratio(path: Path, damping: float | None) -> float:
    if damping is None:
        raise InputError(f"{path}: found no damping, expected it in the file or by the key damping")
    return damping


def _universal(path: Path, nodes: tuple[int, ...]) -> FrequencyResponse:
    """Functions of type 4: reference directions 1 to 6, response directions 4 and 5, about x, y."""
    found = {}
    for each in datasets(path):
        if each["func_type"] == FREQUENCY_RESPONSE:
            key = int(each["ref_node"]), int(each["rsp_dir"]), int(each["ref_dir"])
            hertz = factor_of_label(path, each, "abscissa", "frequency", "Hz")
            data = np.asarray(each["data"], dtype=complex)
            found[key] = hertz * np.asarray(each["x"]), _factor(path, each) * data
    wheels = nodes or tuple(sorted({key[0] for key in found}))
    lines = []
    for node in wheels:
        for sight in (4, 5):
            for load in range(1, 7):
                signs = [(s * t, (node, s * sight, t * load)) for s in (1, -1) for t in (1, -1)]
                match = [(sign, found[key]) for sign, key in signs if key in found]
                if not match:
                    raise InputError(
                        f"{path}: found no frequency response of direction {sight} to direction "
                        f"{load} of node {node}"
                    )
                sign, (frequency, data) = match[0]
                lines.append((frequency, sign * data))
    frequency = lines[0][0]
    if any(len(x) != len(frequency) or np.any(x != frequency) for x, _ in lines):
        raise InputError(f"{path}: expected the same frequencies in all functions")
    values = np.array([data for _, data in lines]).reshape(len(wheels), 2, 6, -1)
    return FrequencyResponse(frequency, np.moveaxis(values, -1, 0))


def _factor(path: Path, dataset: dict[str, Any]) -> float:
    """SI value of the unit of a frequency response to the line of sight."""
    response = int(dataset["ordinate_spec_data_type"])
    if response not in _ANGLES:
        name = _OTHERS.get(response, "another quantity")
        raise InputError(
            f"{path}: found responses of {name} (data type {response}), expected "
            "angles of the line of sight (data type 8, or 0 or 1)"
        )
    label, below = (unit_label(path, dataset, axis) for axis in ("ordinate", "orddenom"))
    if not below and "/" in label:
        label, _, below = label.partition("/")
        dataset = {**dataset, "ordinate_axis_units_lab": label}
    turns = abs(int(dataset["ref_dir"])) > 3
    plain = re.sub(r"[\s.·*()\[\]]", "", below).casefold()
    if plain not in ("", "nm" if turns else "n"):
        raise InputError(
            f"{path}: found the unit {below!r} of a load in direction {dataset['ref_dir']}, "
            f"expected {'N·m' if turns else 'N'} or none"
        )
    return factor_of_label(path, dataset, "ordinate", "angle", "rad")


def _call(path: Path, module: str, function: str) -> dict[str, Any]:
    """Matrices of a file by a reader of pyyeti."""
    try:
        reader = getattr(importlib.import_module(module), function)
    except ImportError:
        raise missing(str(path), "pyyeti", "structure") from None
    require_readable(path, _NASTRAN)
    try:
        content = reader(str(path))
    except Exception as error:  # as many kinds as the reader has faults
        raise damaged(path, _NASTRAN, error) from None
    return {str(name).upper(): value for name, value in content.items()}


def _matrices(path: Path, content: dict[str, Any], damping: float | None) -> ModalModel:
    """Modal model from matrices FREQ (Hz), PHIIN (6 for each wheel), PHIOUT (2), and DAMP."""
    for name in ("FREQ", "PHIIN", "PHIOUT"):
        if name not in content:
            raise InputError(
                f"{path}: found matrices {', '.join(content) or 'none'}, expected FREQ, PHIIN and "
                "PHIOUT"
            )
    frequency = np.ravel(np.real(content["FREQ"]))
    count = len(frequency)
    shapes = np.atleast_2d(np.real(content["PHIIN"]))
    if shapes.shape[0] % 6 or shapes.shape[1] != count:
        raise InputError(
            f"{path}: PHIIN: found shape {shapes.shape}, expected 6 rows for each wheel and "
            f"{count} columns"
        )
    inputs = np.moveaxis(shapes.reshape(-1, 6, count), 2, 1)
    outputs = np.atleast_2d(np.real(content["PHIOUT"])).T
    if "DAMP" in content:
        ratio = np.ravel(np.real(content["DAMP"]))
    else:
        ratio = np.full(count, _ratio(path, damping))
    return ModalModel(frequency, ratio, inputs, outputs)


def _reduced(
    path: Path,
    content: dict[str, Any],
    damping: float | None,
    nodes: tuple[int, ...],
    sight_node: int | None,
) -> ModalModel:
    """Modes of a reduced stiffness KAAX and mass MAAX, whose rows are nodes and directions."""
    if "KAAX" not in content or "MAAX" not in content:
        raise InputError(f"{path}: found {', '.join(content) or 'none'}, expected KAAX and MAAX")
    if not nodes or sight_node is None:
        raise InputError(
            f"{path}: found no nodes, expected the keys nodes (of the wheels) and sight_node"
        )
    stiffness, mass = content["KAAX"], content["MAAX"]
    rows = [(int(node), int(way)) for node, way in stiffness.index]
    mass = mass.reindex(index=stiffness.index, columns=stiffness.index, fill_value=0.0)
    wanted = [(node, way) for node in nodes for way in range(1, 7)]
    wanted += [(sight_node, 4), (sight_node, 5)]
    lacking = [pair for pair in wanted if pair not in rows]
    if lacking:
        raise InputError(f"{path}: found no direction {lacking[0][1]} of node {lacking[0][0]}")
    square: Any = np.real(np.asarray(stiffness, dtype=complex))
    inertia: Any = np.real(np.asarray(mass, dtype=complex))
    try:
        squares, shapes = eigh(0.5 * (square + square.T), 0.5 * (inertia + inertia.T))
    except np.linalg.LinAlgError:
        raise InputError(f"{path}: MAAX: expected a positive definite mass") from None
    largest = float(np.max(np.abs(squares)))
    squares = np.where(np.abs(squares) < 1e-9 * largest, 0.0, squares)
    place = [rows.index(pair) for pair in wanted]
    chosen = shapes[place]
    inputs = np.moveaxis(chosen[:-2].reshape(len(nodes), 6, -1), 2, 1)
    ratio = np.full(len(squares), _ratio(path, damping))
    return ModalModel(np.sqrt(np.maximum(squares, 0.0)) / TWO_PI, ratio, inputs, chosen[-2:].T)
