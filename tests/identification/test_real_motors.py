"""Real motors of a robot against their published friction."""

from pathlib import Path

import pytest

from gyrostat.identification.batch import identify
from gyrostat.identification.bench.steady import identify_steady
from gyrostat.telemetry import read_record
from gyrostat.wheel.friction import ViscousCoulomb

ROOT = Path(__file__).resolve().parents[2]
ROBOTINO = Path("shared", "data", "robotino_dc_motor")
PUBLISHED = [(1, 2.37e-5, 8.13e-3), (2, 2.03e-5, 6.97e-3), (3, 2.36e-5, 8.09e-3)]
"""Motor, viscous friction in N·m·s/rad, Coulomb friction in N·m."""


@pytest.fixture
def robotino():
    for parent in (ROOT, *ROOT.parents):
        if (parent / ROBOTINO).is_dir():
            return parent / ROBOTINO
    pytest.skip(f"the real records are not here: no {ROBOTINO} in or above the repository")


@pytest.mark.parametrize("setpoint", [True, False], ids=["setpoint", "speed alone"])
@pytest.mark.parametrize(("motor", "viscous", "coulomb"), PUBLISHED)
def test_real_motors_have_their_published_friction(robotino, motor, viscous, coulomb, setpoint):
    columns = {"time": "t", "current": f"m{motor}cur", "speed": f"m{motor}vel"}
    if setpoint:
        columns["setpoint"] = f"m{motor}setvel"
    record = read_record(
        robotino / "data_for_identification_with_integral.csv",
        columns=columns,
        unsigned_current=True,
    )
    fit = identify_steady(record, hold={"motor_constant": 0.0514})
    assert fit.model is ViscousCoulomb
    assert fit.parameters["coulomb"] == pytest.approx(coulomb, rel=0.05)
    assert fit.parameters["viscous"] == pytest.approx(viscous, rel=0.10)
    published = {"coulomb": coulomb, "viscous": viscous}
    for name, sigma in zip(fit.names, fit.sigma, strict=True):
        assert abs(fit.parameters[name] - published[name]) < 2.0 * sigma
        assert sigma < 0.2 * published[name]
    assert 14 <= len(fit.friction_points.speed) <= 20
    assert fit.warnings == ()


@pytest.mark.parametrize(("motor", "viscous", "coulomb"), PUBLISHED)
def test_a_record_that_the_published_fit_did_not_use_agrees(robotino, motor, viscous, coulomb):
    names = {"time": "t", "current": f"m{motor}cur", "speed": f"m{motor}vel"}
    columns = {**names, "setpoint": f"m{motor}setvel"}
    path = robotino / "validation_data.csv"
    record = read_record(path, columns=columns, unsigned_current=True)
    fit = identify_steady(record, hold={"motor_constant": 0.0514})
    published = {"coulomb": coulomb, "viscous": viscous}
    for name, sigma in zip(fit.names, fit.sigma, strict=True):
        assert abs(fit.parameters[name] - published[name]) < 2.0 * sigma


@pytest.mark.parametrize(("motor", "given"), [(1, {}), (2, {"free": ["inertia"]})])
def test_a_motor_faster_than_the_samples_is_not_believed(robotino, motor, given):
    """It follows its current within 3 ms, sampled each 31 ms; the published inertia is 1.14e-6.

    The estimates are wrong by 30 to 1000 sigma, so that no result may count as valid.
    """
    path = robotino / "data_for_identification_with_integral.csv"
    columns = {"time": "t", "current": f"m{motor}cur", "speed": f"m{motor}vel"}
    record = read_record(path, columns=columns, unsigned_current=True)
    known = {"inertia": 1.1407e-6, "hold": {"motor_constant": 0.0514}}
    fit = identify(record, model="viscous-coulomb", **known, **given)
    assert not fit.converged or fit.impossible
    if fit.converged and motor == 2:
        assert any("--method steady uses held speeds alone" in text for text in fit.impossible)
