"""Directed nonsense in the files and options beside a scenario: refused where it stands."""

from pathlib import Path

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.search.condition import quantity
from gyrostat.spacecraft.orbit.time_scales import Epoch
from gyrostat.telemetry import read_record
from gyrostat.verbs.arguments import numbers
from gyrostat.wheel import read_model, read_wheel_sheet
from gyrostat.wheel.data_sheet import FOLDER

SHEET = (FOLDER / "bct-rwp015.toml").read_text()
MODEL = (Path(__file__).parents[2] / "examples/scenarios/cubesat_wheel.toml").read_text()
TORQUE = 'value = "4 mN·m"'


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        *(
            ('"15 mN·m·s"', text, "momentum_limit")
            for text in (
                *('"-15 mN·m·s"', '"0 N·m·s"', '"15 mN·m"', '"１５ mN·m·s"', '"15_0 mN·m·s"'),
                *('"15 kN·m·s"', "1e400", "nan", "-inf", "true", '"1 5 mN·m·s"', '""', "[15]"),
            )
        ),
        *(('"6000 rpm"', text, "inertia") for text in ('"60 rpm"', "6000", '"6000000 rpm"')),
        ("2.38732e-5 kg·m²", "2.38732 kg·m²", "inertia"),
        ('"0.05 mN·m"', '"-0.05 mN·m"', "coulomb"),
        ("value = 0.0", "value = -1.0", "viscous"),
        *(
            (TORQUE, f'{TORQUE}\ntolerance = "{text}"', "torque_limit.tolerance")
            for text in ("-3 %", "３ %", "1_0 %", "nan %", "inf %", "three %")
        ),
        (TORQUE, f'{TORQUE}\nminimum = "5 mN·m"', "torque_limit"),
    ],
)
def test_an_impossible_data_sheet_is_refused(tmp_path, old, new, key):
    assert old in SHEET
    path = tmp_path / "sheet.toml"
    path.write_text(SHEET.replace(old, new, 1))
    with pytest.raises(InputError, match=rf"sheet\.toml: key {key}.*found .*expected"):
        read_wheel_sheet(path)


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("2.0e-05  ", '"２ kg·m²"', "wheel.inertia"),
        *(("5.0e-03", text, "wheel.motor_constant") for text in ("-5e-3", "0", "nan", "inf")),
        ("= 3.0e-05", "= inf", "friction.static"),
        ("= 2.0\n", "= -2.0\n", "friction.stribeck_speed"),
        ('"stribeck"', '"stribek"', "friction.model"),
    ],
)
def test_an_impossible_wheel_model_is_refused(tmp_path, old, new, key):
    text = MODEL.replace("stribeck_speed = 2.0 ", "stribeck_speed = 2.0\n")
    assert old in text
    path = tmp_path / "model.toml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=rf"model\.toml: key {key}.*found .*expected"):
        read_model(path)


@pytest.mark.parametrize(
    "row",
    [
        *("nan,1,1", "inf,1,1", "0.1,1,1", "0.4,1,1", "-5,1,1"),
        *("0.5,x,1", "0.5,１２,1", "0.5,٣,1", "0.5,1_2,1", "0.5,0x12,1", "0.5,1 2,1"),
        *("0.5,inf,1", "0.5,1,1,1", "0.5,1", "0.5,1e400,1", "0.5,--1,1"),
    ],
)
def test_an_impossible_row_of_a_record_is_refused(tmp_path, row):
    rows = [f"{0.1 * k:.1f},{100 * np.sin(k):.4f},0.1" for k in range(20)]
    rows[5] = row
    path = tmp_path / "record.csv"
    path.write_text("\n".join(["time_s,speed_rpm,current_A", *rows, ""]))
    with pytest.raises(InputError, match=r"record\.csv: row 7.*found .*expected"):
        read_record(path)


@pytest.mark.parametrize(
    "text",
    [
        *("２０26-06-21T10:12:00Z", "٢٠٢٦-06-21T10:12:00Z", "2026-06-21T１0:12:00Z"),
        *("2026-06-21T10:12:00.５Z", "2026-13-21T10:12:00Z", "2026-02-30T10:12:00Z"),
        *("2026-06-21T25:12:00Z", "2026-06-21T10:12:61Z", "1026-06-21T10:12:00Z"),
        *("9026-06-21T10:12:00Z", "2026-06-21 10:12:00Z", "2026-06-21T10:12:00", "2026-367T0:0:0Z"),
    ],
)
def test_an_impossible_epoch_is_refused(text):
    with pytest.raises(InputError, match=r"epoch: found .*expected"):
        Epoch.of(text)


@pytest.mark.parametrize("text", ["１,0,0,0", "1,0,0", "1,0,0,x", "1_0,0,0,0", "1 0,0,0,0", ""])
def test_an_impossible_list_of_numbers_is_refused(text):
    with pytest.raises(InputError, match=r"--attitude: found .*expected 4"):
        numbers(text, 4, None, "--attitude")


@pytest.mark.parametrize("text", ["５", "1_0", "nan", "5 0", ""])
def test_an_impossible_value_of_a_condition_is_refused(text):
    with pytest.raises(InputError, match=r"--rare: found .*expected"):
        quantity(text, "1/K", "--rare")
