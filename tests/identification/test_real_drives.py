"""Real drives in closed loop against their published parameters."""

from pathlib import Path

import pytest
from scipy.io import loadmat

import gyrostat as gs
from gyrostat.identification import identify_inverse
from gyrostat.telemetry import read_record

ROOT = Path(__file__).resolve().parents[2]
ROBOTINO = Path("shared", "data", "robotino_dc_motor")
EMPS = Path("shared", "data", "emps", "DATA_EMPS.mat")
MOTORS = [(1, 2.37e-5, 8.13e-3), (2, 2.03e-5, 6.97e-3), (3, 2.36e-5, 8.09e-3)]
"""Motor, viscous friction in N·m·s/rad, Coulomb friction in N·m."""
AXIS = {"inertia": 95.1089, "viscous": 203.5034, "coulomb": 20.3935}
"""Janot, Gautier and Brunot, Data Set and Reference Models of EMPS, 2019; kg, N·s/m, N."""


def data(place):
    for parent in (ROOT, *ROOT.parents):
        if (parent / place).exists():
            return parent / place
    pytest.skip(f"the real records are not here: no {place} in or above the repository")


@pytest.mark.parametrize(("motor", "viscous", "coulomb"), MOTORS)
def test_motors_in_a_speed_loop_have_their_published_friction(motor, viscous, coulomb):
    """They follow their current within 3 ms, sampled each 31 ms: no inertia can be seen."""
    columns = {"time": "t", "current": f"m{motor}cur", "speed": f"m{motor}vel"}
    columns["setpoint"] = f"m{motor}setvel"
    names = ("data_for_identification_with_integral.csv", "validation_data.csv")
    folder = data(ROBOTINO)
    record, other = (read_record(folder / n, columns=columns, unsigned_current=True) for n in names)
    held = {"motor_constant": 0.0514}
    fit = identify_inverse(record, inertia=1.1407e-6, hold=held, held_out=[other])
    assert not fit.impossible
    assert fit.parameters["coulomb"] == pytest.approx(coulomb, rel=0.05)
    published = {"viscous": viscous, "coulomb": coulomb}
    for name, value in published.items():
        assert abs(fit.parameters[name] - value) < 3.0 * fit.sigma[name]
    assert fit.sigma["coulomb"] < 0.05 * coulomb
    assert fit.inverse.held_out["validation_data.csv"] < 0.3
    free = identify_inverse(record, hold=held)
    assert not free.observability["inertia"].observable
    assert abs(free.parameters["inertia"] - 1.1407e-6) < 3.0 * free.sigma["inertia"]


def test_servo_axis_has_its_published_parameters(tmp_path):
    """By the words of the documentation; a metre is one radian of a pulley of radius 1 m."""
    path = data(EMPS)
    fit = gs.identify(
        path,
        tmp_path,
        method="inverse",
        columns={"time": "t", "current": "vir", "angle": "qm", "reference": "qg"},
        units={"time": "s", "current": "A", "angle": "rad", "reference": "rad"},
        hold={"motor_constant": float(loadmat(path)["gtau"].squeeze())},
    )
    assert not fit.impossible
    for name, value in AXIS.items():
        assert fit.parameters[name] == pytest.approx(value, rel=0.05)
        assert abs(fit.parameters[name] - value) < 3.0 * fit.sigma[name]
        assert fit.sigma[name] < 0.05 * value
