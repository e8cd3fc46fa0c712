"""Files of waterfalls and of wheels on a structure."""

import importlib.util
from dataclasses import replace

import h5py
import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.microvibration.disturbance_file import (
    disturbance_text,
    read_disturbance,
    read_structure,
)
from gyrostat.microvibration.model import Harmonic, Mode, Noise, WheelDisturbance
from gyrostat.microvibration.waterfall import Waterfall, Window
from gyrostat.microvibration.waterfall_file import read_waterfall

PYUFF = importlib.util.find_spec("pyuff") is None
RPM = np.pi / 30.0
SPEED = np.array([600.0, 900.0, 1500.0]) * RPM
FREQUENCY = np.arange(1.0, 21.0, 0.5)
DENSITY = {
    load: np.random.default_rng(k).gamma(3.0, 1e-6, (3, 40)) for k, load in enumerate(("Fx", "Tz"))
}
WATERFALL = Waterfall("w", SPEED, FREQUENCY, DENSITY, Window.named("hann"))


def assert_same(found):
    np.testing.assert_allclose(found.speed, SPEED, rtol=1e-6)
    np.testing.assert_allclose(found.frequency, FREQUENCY, rtol=1e-6)
    assert set(found.density) == set(DENSITY)
    for load, values in DENSITY.items():
        np.testing.assert_allclose(found.density[load], values, rtol=1e-6)


def long_form(scale=1.0, power=1.0):
    lines = ["speed_rpm,frequency_Hz,Fx_N^2/Hz,Tz"]
    for k in (2, 0, 1):
        for j, f in enumerate(FREQUENCY):
            cells = [scale * DENSITY[load][k, j] ** power for load in DENSITY]
            lines.append(
                f"{float(SPEED[k] / RPM)!r},{f},{cells[0]!r},{cells[1]!r}".replace("np.float64", "")
                .replace("(", "")
                .replace(")", "")
            )
    return "\n".join(lines)


def wide_form():
    lines = ["load,speed_rad/s," + ",".join(str(f) for f in FREQUENCY)]
    for load, values in DENSITY.items():
        for speed, row in zip(SPEED, values, strict=True):
            lines.append(f"{load},{speed!s}," + ",".join(str(x) for x in row))
    return "\n".join(lines)


@pytest.mark.parametrize("text", [long_form(), wide_form()])
def test_csv_is_read_in_long_and_wide_form(tmp_path, text):
    path = tmp_path / "waterfall.csv"
    path.write_text(text)
    assert_same(read_waterfall(path))


@pytest.mark.parametrize("unit", ["_mN^2/Hz", " (mN²/Hz)", "_lbf"])
def test_loads_in_other_units_are_refused(tmp_path, unit):
    path = tmp_path / "waterfall.csv"
    path.write_text(long_form().replace("_N^2/Hz", unit))
    with pytest.raises(InputError, match="Fx: found the unit"):
        read_waterfall(path)


@pytest.mark.parametrize("unit", ["", " [N²/Hz]", "_N", " (N^2/Hz)"])
def test_units_without_a_factor_are_read(tmp_path, unit):
    path = tmp_path / "waterfall.csv"
    path.write_text(long_form().replace("_N^2/Hz", unit))
    assert_same(read_waterfall(path))


@pytest.mark.parametrize("quantity", ["amplitude", "rms"])
def test_amplitudes_are_turned_into_densities(tmp_path, quantity):
    """A line of density S in a bin has the mean square S times the noise bandwidth."""
    square = 1.5 * 0.5 * (2.0 if quantity == "amplitude" else 1.0)
    path = tmp_path / "waterfall.csv"
    path.write_text(long_form(np.sqrt(square), 0.5))
    assert_same(read_waterfall(path, quantity))


def test_hdf5_is_read(tmp_path):
    path = tmp_path / "waterfall.h5"
    with h5py.File(path, "w") as file:
        file["speed"], file["frequency"] = SPEED / RPM, FREQUENCY
        file["speed"].attrs["unit"] = "rpm"
        for load, values in DENSITY.items():
            file[load] = values
    assert_same(read_waterfall(path))
    with h5py.File(path, "a") as file:
        file["Tz"].attrs["unit"] = "(mN·m)²/Hz"
    with pytest.raises(InputError, match="Tz: found the unit"):
        read_waterfall(path)


def test_damaged_hdf5_is_told_in_one_line(tmp_path):
    path = tmp_path / "waterfall.h5"
    with h5py.File(path, "w") as file:
        file["speed"] = SPEED
    content = path.read_bytes()
    # the signature of the node that lists the names
    path.write_bytes(content.replace(b"SNOD", b"none"))
    with pytest.raises(InputError, match="expected an HDF5 file of numbers"):
        read_waterfall(path)


def write_universal(path, factor=1.0, **labels):
    import pyuff

    file = pyuff.UFF(str(path))
    for load, direction in (("Fx", 1), ("Tz", -6)):
        for speed, row in zip(SPEED, DENSITY[load], strict=True):
            dataset = pyuff.prepare_58(
                binary=0, func_type=9, rsp_node=1, rsp_dir=direction, ref_node=0, ref_dir=0,
                data=row, x=FREQUENCY / factor, ord_data_type=4, num_pts=40, abscissa_spacing=1,
                abscissa_min=1.0 / factor, abscissa_inc=0.5 / factor, z_axis_value=speed / RPM,
                id1="", id2="", id3="", id4="", id5="",
                orddenom_spec_data_type=0,
                **{f"{axis}_axis_units_lab": label for axis, label in labels.items()},
            )  # fmt: skip
            file._write_set(dataset, "add")


@pytest.mark.skipif(PYUFF, reason="not run: pyuff is not installed")
@pytest.mark.parametrize(
    ("factor", "labels"),
    [
        (1.0, {"z_axis": "rpm", "abscissa": "NONE"}),
        (1.0, {"ordinate": "(N)^2/Hz", "abscissa": "Hz"}),
        (1e-3, {"abscissa": "mHz"}),
    ],
)
def test_universal_file_is_read_with_its_units(tmp_path, factor, labels):
    write_universal(tmp_path / "waterfall.uff", factor, **labels)
    assert_same(read_waterfall(tmp_path / "waterfall.uff"))


@pytest.mark.skipif(PYUFF, reason="not run: pyuff is not installed")
@pytest.mark.parametrize(
    ("labels", "message"),
    [
        ({"ordinate": "g"}, "Fx: found the unit 'g', expected N and N·m"),
        ({"ordinate": "mN^2/Hz"}, "Fx: found the unit 'mN.2/Hz'"),
        ({"z_axis": "Hz"}, "found the unit label 'Hz' of the z_axis, expected a unit of speed"),
        ({"abscissa": "rpm"}, "found the unit label 'rpm' of the abscissa"),
    ],
)
def test_other_units_of_a_universal_file_are_refused(tmp_path, labels, message):
    write_universal(tmp_path / "waterfall.uff", **labels)
    with pytest.raises(InputError, match=message):
        read_waterfall(tmp_path / "waterfall.uff")


@pytest.mark.skipif(PYUFF, reason="not run: pyuff is not installed")
def test_units_of_dataset_164_count_where_a_label_is_absent(tmp_path):
    import pyuff

    path = tmp_path / "waterfall.uff"
    units = pyuff.prepare_164(
        units_code=5, units_description="mm, mN", temp_mode=1, length=1e3, force=1e3, temp=1.0,
        temp_offset=273.15,
    )  # fmt: skip
    pyuff.UFF(str(path))._write_set(units, "add")
    write_universal(path, ordinate="N^2/Hz", abscissa="Hz")
    with pytest.raises(InputError, match="units other than SI in dataset 164 and no unit label"):
        read_waterfall(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.replace("speed_rpm", "speed"), "column speed: found no unit of a speed"),
        (lambda t: t.replace("Tz", "Qz"), "found the load 'Qz', expected one of Fx"),
        (lambda t: t.replace(",20.0,", ",20.1,", 1), "found other frequencies than at 600 rpm"),
        (lambda t: t + ",5", "found 5 cells, expected 4"),
        (lambda t: "speed_rpm,frequency_Hz,Fx\n600,1,nan", "found 'nan', expected a finite number"),
    ],
)
def test_a_fault_of_the_file_is_named(tmp_path, change, message):
    path = tmp_path / "waterfall.csv"
    path.write_text(change(long_form()))
    with pytest.raises(InputError, match=message):
        read_waterfall(path)


def test_a_waterfall_that_cannot_be_is_refused():
    with pytest.raises(InputError, match="equal steps"):
        replace(WATERFALL, frequency=FREQUENCY**2)
    negative = {"Fx": -DENSITY["Fx"]}
    with pytest.raises(InputError, match="expected a density of 0 or more"):
        replace(WATERFALL, density=negative)


def test_loads_of_a_wheel_are_read_as_they_are_written(tmp_path):
    wheel = WheelDisturbance(
        'wheel "A" \\1',
        (Harmonic(1.0, {"force": 1e-6, "torsion": 2e-9}), Harmonic(2.5, {}, {"torque": 3e-8})),
        {"torque": Mode(500.0, 0.02, 1.7), "axial": Mode(900.0, 0.01)},
        {"torque": Noise(1e-9, 1.5, 300.0)},
    )
    path = tmp_path / "disturbance.toml"
    path.write_text(disturbance_text(wheel))
    found = read_disturbance(path)
    assert found.name == wheel.name
    assert found.harmonics == wheel.harmonics
    assert found.modes["torque"].frequency == pytest.approx(500.0, rel=1e-8)
    assert found.modes["torque"].inertia_ratio == 1.7
    assert found.noise["torque"].reference == pytest.approx(300.0, rel=1e-8)


def test_a_structure_names_what_it_lacks(tmp_path):
    (tmp_path / "disturbance.toml").write_text("[[harmonic]]\nnumber = 1\nforward = {force = 1e-6}")
    modes = "frequency_Hz,damping,Fx,Fy,Fz,Tx,Ty,Tz,los_x,los_y\n40,0.01,1,0,0,0,0,0,0.1,0"
    (tmp_path / "modes.csv").write_text(modes)
    text = (
        'disturbance = "disturbance.toml"\ntransfer = "modes.csv"\nexposure = "20 ms"\n'
        'limit = "0.1 arcsec"\nspeeds = ["300 rpm", "4000 rpm"]\n[[wheel]]\naxis = [1, 0, 0]\n'
    )
    path = tmp_path / "sight.toml"
    path.write_text(text)
    structure = read_structure(path)
    assert structure.exposure == 0.02
    assert structure.speeds == pytest.approx((300.0 * RPM, 4000.0 * RPM))
    for old, new, message in (
        ('"20 ms"', '"20 m"', "key exposure '20 m': found unit"),
        ('exposure = "20 ms"', "", "key exposure: found None"),
        ("axis = [1, 0, 0]", "axis = [0, 0, 0]", "expected a direction"),
        ("[[wheel]]", "[[whel]]", "did you mean wheel"),
        ('"300 rpm"', '"5000 rpm"', "expected the lower one first"),
    ):
        path.write_text(text.replace(old, new))
        with pytest.raises(InputError, match=message):
            read_structure(path)
