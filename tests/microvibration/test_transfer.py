"""Transfer to the line of sight against direct solutions, and its files."""

import importlib.util

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.microvibration.model import LOADS
from gyrostat.microvibration.transfer import FrequencyResponse, ModalModel
from gyrostat.microvibration.transfer_file import read_transfer

PYUFF = importlib.util.find_spec("pyuff") is None
PYYETI = importlib.util.find_spec("pyyeti") is None
GENERATOR = np.random.default_rng(2)
FREQUENCY = np.array([0.0, 40.0, 110.0])
DAMPING = np.array([0.01, 0.005, 0.02])
INPUTS = GENERATOR.normal(size=(2, 3, 6))
OUTPUTS = GENERATOR.normal(size=(3, 2))
MODEL = ModalModel(FREQUENCY, DAMPING, INPUTS, OUTPUTS)
GRID = np.linspace(1.0, 200.0, 40)


def both(transfer):
    return np.stack([transfer.at(GRID, wheel) for wheel in (0, 1)], axis=1)


def test_modal_model_is_the_solution_of_its_equations_of_motion():
    natural = 2.0 * np.pi * FREQUENCY
    for f in (3.0, 40.0, 90.0):
        w = 2.0 * np.pi * f
        matrix = np.diag(natural**2 - w**2) + 1j * w * np.diag(2.0 * DAMPING * natural)
        for wheel in (0, 1):
            q = np.linalg.solve(matrix, INPUTS[wheel])
            result = MODEL.at(np.array([f]), wheel)[0]
            np.testing.assert_allclose(result, OUTPUTS.T @ q, rtol=1e-12)


def test_response_is_linear_between_its_frequencies_and_zero_outside():
    response = FrequencyResponse(GRID, both(MODEL))
    middle = 0.5 * (GRID[3] + GRID[4])
    expected = 0.5 * (response.values[3, 0] + response.values[4, 0])
    np.testing.assert_allclose(response.at(np.array([middle]), 0)[0], expected, rtol=1e-12)
    np.testing.assert_array_equal(response.at(np.array([0.5, 300.0]), 1), 0.0)


def test_csv_of_a_frequency_response_is_read_as_it_is_written(tmp_path):
    values = both(MODEL)
    parts = [f"{load}_{part}" for load in LOADS for part in ("re", "im")]
    lines = [",".join(["frequency_Hz", "wheel", "los", *parts])]
    for f, row in zip(GRID, values, strict=True):
        for wheel in (0, 1):
            for k, sight in enumerate("xy"):
                numbers = np.array([row[wheel, k].real, row[wheel, k].imag]).T.ravel()
                cells = [repr(float(x)) for x in numbers]
                lines.append(",".join([repr(float(f)), str(wheel + 1), sight, *cells]))
    path = tmp_path / "frf.csv"
    path.write_text("\n".join(lines))
    np.testing.assert_allclose(both(read_transfer(path)), values, rtol=1e-12)
    path.write_text("\n".join(lines[:-1]))
    with pytest.raises(InputError, match="expected one row for each frequency"):
        read_transfer(path)


def test_csv_of_modes_is_read_as_it_is_written(tmp_path):
    lines = [",".join(["frequency_Hz", "damping", "wheel", *LOADS, "los_x", "los_y"])]
    for wheel in (0, 1):
        for k in range(3):
            numbers = [*INPUTS[wheel, k], *OUTPUTS[k]]
            cells = [repr(float(x)) for x in numbers]
            lines.append(",".join([repr(FREQUENCY[k].item()), str(DAMPING[k]), str(wheel), *cells]))
    path = tmp_path / "modes.csv"
    path.write_text("\n".join(lines))
    np.testing.assert_allclose(both(read_transfer(path)), both(MODEL), rtol=1e-12)


def write_universal(path, values, **keys):
    import pyuff

    file = pyuff.UFF(str(path))
    for wheel, node in ((0, 11), (1, 12)):
        for k in (0, 1):
            for load in range(6):
                sign = -1.0 if load == 2 else 1.0
                dataset = pyuff.prepare_58(
                    binary=0, func_type=4, rsp_node=99, rsp_dir=4 + k, ref_node=node,
                    ref_dir=int(sign) * (load + 1), data=sign * values[:, wheel, k, load], x=GRID,
                    ord_data_type=6, num_pts=len(GRID), abscissa_spacing=1,
                    abscissa_min=GRID[0], abscissa_inc=GRID[1] - GRID[0],
                    id1="", id2="", id3="", id4="", id5="",
                    **{"orddenom_spec_data_type": 0, **keys},
                )  # fmt: skip
                file._write_set(dataset, "add")


@pytest.mark.skipif(PYUFF, reason="not run: pyuff is not installed")
@pytest.mark.parametrize(("label", "unit"), [("NONE", 1.0), ("µrad", 1e-6), ("arcsec", 4.8481e-6)])
def test_universal_file_is_read_as_pyuff_writes_it(tmp_path, label, unit):
    values = both(MODEL)
    path = tmp_path / "frf.uff"
    write_universal(path, values / unit, ordinate_axis_units_lab=label)
    response = read_transfer(path)
    assert isinstance(response, FrequencyResponse)
    np.testing.assert_allclose(response.values, values, rtol=1e-4)


@pytest.mark.skipif(PYUFF, reason="not run: pyuff is not installed")
@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"ordinate_axis_units_lab": "mm"}, "found the unit label 'mm' of the ordinate"),
        ({"ordinate_axis_units_lab": "g/N"}, "found the unit label 'g' of the ordinate"),
        ({"ordinate_axis_units_lab": "rad/lbf"}, "the unit 'lbf' of a load in direction 1"),
        ({"orddenom_axis_units_lab": "N"}, "the unit 'N' of a load in direction 4, expected N·m"),
        ({"ordinate_spec_data_type": 12}, "found responses of acceleration"),
        ({"ordinate_spec_data_type": 9}, r"found responses of force \(data type 9\)"),
        ({"ordinate_spec_data_type": 16}, r"found responses of another quantity \(data type 16\)"),
        ({"abscissa_axis_units_lab": "rpm"}, "found the unit label 'rpm' of the abscissa"),
    ],
)
def test_other_units_of_a_universal_file_are_refused(tmp_path, keys, message):
    write_universal(tmp_path / "frf.uff", both(MODEL), **keys)
    with pytest.raises(InputError, match=message):
        read_transfer(tmp_path / "frf.uff")


@pytest.mark.skipif(PYYETI, reason="not run: pyyeti is not installed")
@pytest.mark.parametrize("suffix", [".op4", ".op2"])
def test_matrices_of_nastran_are_a_modal_model(tmp_path, suffix, monkeypatch):
    from pyyeti.nastran import op2, op4

    names = ["freq", "phiin", "phiout", "damp"]
    shapes = np.moveaxis(INPUTS, 1, 2).reshape(12, 3)
    path = tmp_path / f"modes{suffix}"
    op4.write(str(path), names, [FREQUENCY[None], shapes, OUTPUTS.T, DAMPING[None]])
    if suffix == ".op2":  # pyyeti writes no OP2: its reader is replaced
        monkeypatch.setattr(op2, "rdmats", lambda name: op4.read(name))
    np.testing.assert_allclose(both(read_transfer(path)), both(MODEL), rtol=1e-9)


@pytest.mark.skipif(PYYETI, reason="not run: pyyeti is not installed")
def test_a_punch_of_stiffness_and_mass_has_the_response_of_the_full_system(tmp_path):
    import pandas as pd
    from pyyeti.nastran import bulk

    rows = [(node, way) for node in (11, 99) for way in range(1, 7)]
    index = pd.MultiIndex.from_tuples(rows, names=["id", "dof"])
    factor = GENERATOR.normal(size=(12, 12))
    stiffness = 1e4 * (factor @ factor.T + 12.0 * np.eye(12))
    mass = np.diag(GENERATOR.uniform(1.0, 2.0, 12))
    matrices = {"KAAX": stiffness, "MAAX": mass}
    frames = {name: pd.DataFrame(m, index, index) for name, m in matrices.items()}
    path = tmp_path / "reduced.pch"
    with path.open("w") as file:
        bulk.wtdmig(file, frames)
    model = read_transfer(path, damping=1e-9, nodes=(11,), sight_node=99)
    for f in (0.5, 7.0):
        w = 2.0 * np.pi * f
        full = np.linalg.inv(stiffness - w**2 * mass)[9:11, :6]
        result = model.at(np.array([f]), 0)[0].real
        np.testing.assert_allclose(result, full, rtol=1e-4, atol=1e-6 * np.abs(full).max())
    with pytest.raises(InputError, match="sight_node"):
        read_transfer(path, damping=0.01)


@pytest.mark.parametrize("name", ["frf.uff", "modes.op4", "modes.op2", "modes.pch"])
def test_a_missing_package_is_named(tmp_path, name, monkeypatch):
    import importlib

    real = importlib.import_module

    def without(module, *rest):
        if module.split(".")[0] in ("pyuff", "pyyeti"):
            raise ImportError(module)
        return real(module, *rest)

    monkeypatch.setattr(importlib, "import_module", without)
    with pytest.raises(InputError, match="extra structure: pip install"):
        read_transfer(tmp_path / name)
