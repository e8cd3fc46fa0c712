"""Acceptance of a wheel against its data sheet."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from gyrostat.core.errors import InputError
from gyrostat.core.units import RPM
from gyrostat.identification import accept, validate
from gyrostat.identification.judge.acceptance_lines import (
    FAIL,
    NO_LIMIT,
    NOT_JUDGED,
    PASS,
    UNDECIDED,
    conformance,
)
from gyrostat.identification.judge.acceptance_text import acceptance_table
from gyrostat.wheel import WheelModel, read_wheel_sheet, write_model
from gyrostat.wheel.friction import FRICTION_MODELS

SIGMA = {
    "motor_constant": 2e-5,
    "viscous": 2e-7,
    "coulomb": 4e-6,
    "static": 2e-5,
}
CORRELATION = np.array(
    [[1.0, 0.5, 0.3, 0.1], [0.5, 1.0, -0.3, 0.0], [0.3, -0.3, 1.0, 0.2], [0.1, 0.0, 0.2, 1.0]]
)


def limits(tmp_path, text):
    """Sheet with these tables; each gets a source."""
    body = text.replace("]\n", ']\nsource = "spec"\n')
    path = tmp_path / "sheet.toml"
    path.write_text(f'name = "RW-1"\n{body}', encoding="utf-8")
    return read_wheel_sheet(path, partial=True)


@pytest.fixture(scope="module")
def wheel():
    """Stribeck wheel of the bench with the covariance of an identification."""
    values = {"motor_constant": 0.0228, "inertia": 1.5e-3, "viscous": 4.83e-6}
    values |= {"coulomb": 0.8795e-3, "static": 0.9055e-3, "stribeck_speed": 0.418879}
    names = tuple(SIGMA)
    return WheelModel(FRICTION_MODELS["stribeck"], values, SIGMA, correlation=(names, CORRELATION))


def validated(model, record):
    return validate(model.friction, dict(model.values), record, covariance=model.covariance())


@pytest.fixture(scope="module")
def usual(wheel, record):
    """Validation of the wheel on the record of the bench."""
    return validated(wheel, record())


@pytest.fixture
def judge(wheel, record, usual, tmp_path):
    """Judge a sheet for a wheel and a record, those of the bench by default."""

    def judge(text, model=wheel, measured=None):
        known = model is wheel and measured is None
        result = usual if known else validated(model, measured or record())
        return accept(limits(tmp_path, text), model, result)

    return judge


def test_a_quantity_passes_fails_or_stays_open_at_95_percent(judge, truth):
    """The one-sided 95 % point of a normal error is 1.645 sigma."""
    value, sigma = truth["stribeck"]["coulomb"], SIGMA["coulomb"]
    for z, verdict in ((1.65, PASS), (1.64, UNDECIDED), (-1.64, UNDECIDED), (-1.65, FAIL)):
        (line,) = judge(f"[coulomb]\nmaximum = {value + z * sigma!r}\n").lines
        assert line.verdict == verdict
        assert line.margin == pytest.approx(z * sigma)
    narrow = f"[coulomb]\nvalue = {value!r}\ntolerance = {sigma!r}\n"
    (line,) = judge(narrow).lines
    assert (line.verdict, line.to_dict()["conformance_probability"]) == (
        UNDECIDED,
        pytest.approx(0.6827, abs=1e-4),
    )
    exact = replace(line.limit, minimum=0.0, maximum=1.0)
    assert (conformance(exact, 1.0, 0.0), conformance(exact, 1.1, 0.0)) == (1.0, 0.0)


def test_a_derived_quantity_has_the_spread_of_correlated_wheels(judge, wheel, truth):
    values = truth["stribeck"]
    speed, current = 300.0 * RPM, 0.12
    found = judge(
        '[[loss_torque]]\nspeed = "300 rpm"\nmaximum = 1.0\n'
        "[zero_crossing_torque]\nmaximum = 1.0\n"
        '[torque_limit]\nminimum = 0.0\ncurrent = "120 mA"\nspeed = "300 rpm"\n'
        '[coast_down_time]\nminimum = 1.0\nspeed = "300 rpm"\n'
    )
    draws = np.random.default_rng(1).multivariate_normal(
        [values[n] for n in SIGMA], wheel.covariance()[1], 4000
    )
    motor, viscous, coulomb, static = draws.T

    def time(v):
        excess, bend = v["static"] - v["coulomb"], v["stribeck_speed"]

        def slowness(w):
            curve = v["viscous"] * w + v["coulomb"] + excess * np.exp(-((w / bend) ** 2))
            return v["inertia"] / curve

        return sum(quad(slowness, a, b, epsabs=1e-12)[0] for a, b in ((0, 2.0), (2.0, speed)))

    loss = viscous * speed + coulomb
    expected = (loss, 2.0 * static, motor * current - loss)
    for line, drawn in zip(found.lines, expected, strict=False):
        assert line.measured == pytest.approx(drawn.mean(), rel=2e-3)
        assert line.sigma == pytest.approx(drawn.std(), rel=0.05)
        assert line.verdict == PASS
    assert found.lines[3].measured == pytest.approx(time(values), rel=1e-6)
    slope = []
    for name in SIGMA:
        step = 1e-3 * values[name]
        low, high = (time({**values, name: values[name] + s}) for s in (-step, step))
        slope.append((high - low) / (2.0 * step))
    expected = np.sqrt(slope @ wheel.covariance()[1] @ slope)
    assert found.lines[3].sigma == pytest.approx(expected, rel=1e-4)


def test_what_the_record_does_not_hold_cannot_be_judged(judge, wheel, record, changed, truth):
    sheet = (
        '[[loss_torque]]\nspeed = "4000 rpm"\nmaximum = 1.0\n'
        '[torque_limit]\nminimum = 1e-3\ncurrent = "2 A"\n'
        '[speed_limit]\nvalue = "4000 rpm"\n'
        '[momentum_limit]\nvalue = "650 mN·m·s"\n'
        '[inertia]\nvalue = 1.5e-3\ntolerance = "1 %"\n'
        '[static_imbalance]\nmaximum = "1 g·cm"\n'
        '[stribeck_speed]\nmaximum = "8 rpm"\n'
    )
    found = judge(sheet)
    assert {line.verdict for line in found.lines} == {NOT_JUDGED}
    told = [line.why for line in found.lines]
    assert told[0].startswith("the record reaches only ")
    assert told[1].endswith(" A")
    assert told[2:6] == [line.why for line in found.lines[2:6]]
    assert all("rpm" in why for why in told[2:6])
    assert told[-1] == told[-3] == "its value is given without a standard deviation, not identified"
    assert "NOT YET ACCEPTED (8 cannot be judged" in found.verdict or "9 cannot" in found.verdict
    assert not found.failed

    static = "[static]\nmaximum = 1e-2\n[motor_constant]\nminimum = 1e-2\n"
    assert [line.verdict for line in judge(static).lines] == [PASS, PASS]
    one_way = record().time < 25.0
    names = ("time", "current", "speed", "valid")
    without = changed(record(), **{n: getattr(record(), n)[one_way][20:] for n in names})
    lines = judge(static, measured=without).lines
    assert lines[0].why == "the record alone does not determine it"

    wrong = replace(wheel, values={**truth["stribeck"], "coulomb": 2e-3})
    (line,) = judge("[coulomb]\nmaximum = 1.0\n", model=wrong).lines
    assert line.why == "the model does not predict this record"


def test_speed_and_momentum_are_those_that_the_record_reaches(judge, record, changed):
    clean = record().speed[record().valid]
    spiked = record().speed.copy()
    spiked[1234] = 3.0 * clean.max()
    measured = changed(record(), speed=spiked)
    found = judge("[speed_limit]\nvalue = 1.0\n[momentum_limit]\nvalue = 1.0\n", measured=measured)
    ahead, back, momentum, _ = found.lines
    smooth = np.convolve(clean, np.ones(10) / 10.0, mode="valid")
    assert ahead.measured == pytest.approx(smooth.max(), abs=3.0 * ahead.sigma)
    assert back.measured == pytest.approx(-smooth.min(), abs=3.0 * back.sigma)
    assert momentum.measured == pytest.approx(1.5e-3 * ahead.measured)
    # at full speed, too little momentum is a fault of the wheel
    assert momentum.verdict == FAIL
    assert found.verdict == "RW-1: REJECTED (2 pass, 2 fail)"


def test_a_bearing_with_two_senses_has_two_lines(judge, truth, record):
    values = truth["directional"]
    names = [n for n in values if n not in ("inertia", "stribeck_speed")]
    model = WheelModel(FRICTION_MODELS["directional"], values, {n: 1e-3 * values[n] for n in names})
    middle = 0.5 * (values["coulomb_positive"] + values["coulomb_negative"])
    found = judge(
        f'[coulomb]\nmaximum = {middle!r}\n[loss_torque]\nspeed = "200 rpm"\nvalue = 1.0\n',
        model=model,
        measured=record("directional"),
    )
    assert [(line.sense, line.verdict) for line in found.lines] == [
        (1, PASS),
        (-1, FAIL),
        (1, PASS),
        (-1, PASS),
    ]
    assert found.lines[3].title == "loss torque at 200 rpm, negative sense"
    expected = values["coulomb_negative"] + values["viscous_negative"] * 200.0 * RPM
    assert found.lines[3].measured == pytest.approx(expected, rel=1e-9)


def test_a_value_alone_is_a_limit_only_where_it_is_a_capacity_or_a_loss(judge):
    found = judge("[viscous]\nvalue = 4.8e-6\n[motor_constant]\nvalue = '22.8 mN·m/A'\n")
    assert [line.verdict for line in found.lines] == [NO_LIMIT, NO_LIMIT]
    assert found.verdict == "RW-1: NOT YET ACCEPTED (no line has a limit)"
    assert "mN·m/A" in acceptance_table(found)[2]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[coulomb]\nminimum = 2.0\nmaximum = 1.0\n", "minimum 2, maximum 1 N·m, expected them in"),
        ("[coulomb]\nvalue = 3.0\nmaximum = 1.0\n", "maximum 1, value 3"),
        ("[coulomb]\ntolerance = '1 %'\n", "coulomb.value: found None"),
        ("[coulomb]\nvalue = 1.0\nmaximum = 2.0\ntolerance = '1 %'\n", "coulomb.tolerance: found"),
        ("[coulomb]\nvalue = 1.0\ntolerance = 'x %'\n", "expected one such as '3 %'"),
        ("[coulomb]\nvalue = 1.0\ntolerance = -1.0\n", "expected one such as '3 %'"),
        ("[coulomb]\nmaximum = -1.0\n", "coulomb.maximum: found -1, expected 0 or more"),
        ("[coulomb]\nmaximum = '1 rpm'\n", "unit 'rpm'"),
        ("[coulomb]\nspeed = 1.0\nmaximum = 1.0\n", "coulomb.speed: found an unknown key"),
        ("[loss_torque]\nmaximum = 1.0\n", "loss_torque.speed: found none"),
        ("[[loss_torque]]\nmaximum = 1.0\nspeed = '1 A'\n", r"loss_torque\[0\].speed"),
        ("[[coulomb]]\nmaximum = 1.0\n", "found several tables"),
        ("", "found no quantity"),
    ],
)
def test_bad_limits_are_refused_by_their_key(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as caught:
        limits(tmp_path, text)
    assert str(caught.value).startswith(str(tmp_path / "sheet.toml"))


def test_the_command_prints_the_test_and_exits_1_where_a_line_fails(run, wheel, record, tmp_path):
    from gyrostat.telemetry import write_record

    write_model(tmp_path / "model.toml", wheel)
    write_record(record(), tmp_path / "record.csv")
    words = ("validate", tmp_path / "model.toml", tmp_path / "record.csv", "--out", tmp_path)
    sheet = tmp_path / "sheet.toml"
    limits(tmp_path, "[coulomb]\nmaximum = '0.9 mN·m'\n")
    code, out, err = run(*words, "--sheet", sheet, "--json")
    assert code == 0
    assert "RW-1: accepted (1 pass)" in err
    (line,) = json.loads(out)["acceptance"]["lines"]
    assert (line["verdict"], line["unit"], line["source"]) == ("pass", "N·m", "spec")
    assert line["margin_in_sigma"] == pytest.approx((0.9e-3 - 0.8795e-3) / SIGMA["coulomb"])
    page = (tmp_path / "validation.html").read_text(encoding="utf-8")
    assert "Acceptance test: RW-1" in page

    limits(tmp_path, "[coulomb]\nmaximum = '0.8 mN·m'\n")
    code, _, err = run(*words, "--sheet", sheet)
    assert code == 1
    assert "REJECTED (1 fail)" in err
    code, _, err = run(*words, "--sheet", "no-such-sheet")
    assert (code, err.count("\n")) == (2, 1)
