"""The verb `pool`: files, models that campaigns read, what is refused, left out and noted."""

import json
import shutil
from datetime import date, timedelta
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.campaigns.draws import draw
from gyrostat.identification.pool.oil import Walther

SCENARIOS = Path(__file__).parents[2] / "examples" / "scenarios"
SCENARIO = """[run]
duration = "10 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "three_axis"
[[dispersion]]
fit = "out/pool.json"
wheel = "a"
"""
NAMES = ("motor_constant", "viscous", "coulomb", "static")
UNITS = ("N·m/A", "N·m·s/rad", "N·m", "N·m")
SIGMA = np.array([0.0005, 0.02, 0.005, 0.02])
CORRELATION = np.array(
    [[1.0, -0.2, 0.9, 0.6], [-0.2, 1.0, -0.5, -0.4], [0.9, -0.5, 1.0, 0.7], [0.6, -0.4, 0.7, 1.0]]
)
OIL = Walther((40.0, 100.0), (108.0, 14.6))


def content(random, number):
    """Content of a fit.json at some temperature: Coulomb torque grows by 15 % a year."""
    temperature, days = random.uniform(5.0, 35.0), 60 * number
    dry = (1.0 - 0.003 * (temperature - 20.0)) + 0.15 * days / 365.25
    thick = np.exp(0.75 * OIL.log_ratio(np.array([temperature]), 20.0)[0])
    values = np.array([0.0228, 4.83e-6 * thick, 0.88e-3 * dry, 0.93e-3 * dry])
    values *= 1.0 + np.array([0.001, 0.03, 0.03, 0.03]) * random.standard_normal(4)
    sigma = SIGMA * values
    values = values + sigma * (np.linalg.cholesky(CORRELATION) @ random.standard_normal(4))
    return {
        "model": "stribeck",
        "converged": True,
        "held": {"inertia": 1.5e-3, "stribeck_speed": 0.4189, "current_bias": 0.0},
        "parameters": {
            name: {"value": value, "sigma": error, "unit": unit}
            for name, value, error, unit in zip(
                NAMES, values.tolist(), sigma.tolist(), UNITS, strict=True
            )
        },
        "correlation": {"names": list(NAMES), "matrix": CORRELATION.tolist()},
        "mean_temperature": [temperature],
        "metadata": [{"serial": "RW-07", "date": str(date(2026, 1, 1) + timedelta(days))}],
    }


@pytest.fixture
def folder(tmp_path):
    """Folder with 8 fits of one wheel."""
    random = np.random.default_rng(920150)
    for k in range(8):
        path = tmp_path / "fits" / f"r{k}"
        path.mkdir(parents=True)
        (path / "fit.json").write_text(json.dumps(content(random, k)))
    return tmp_path / "fits"


def change(folder, number, **entries):
    """Replace entries of one fit.json."""
    path = folder / f"r{number}" / "fit.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), **entries}))


def test_the_files_of_pooled_records(run, folder, tmp_path):
    out = tmp_path / "out"
    words = ("pool", folder, "--temperature", "45 degC", "--date", "2027-06-01", "--out", out)
    code, printed, said = run(*words, "--json")
    assert code == 0
    names = sorted(p.name for p in out.iterdir() if p.name[0] != ".")
    assert names == ["model.toml", "pool.html", "pool.json"]
    result = json.loads(printed)
    assert result["serial"] == "RW-07"
    assert result["conditions"]["temperature_degC"] == 45.0
    coulomb = result["parameters"]["coulomb"]
    true = 0.88e-3 * (1.0 - 0.003 * 25.0 + 0.15 * 516.0 / 365.25)
    assert coulomb["prediction"]["low"] < true < coulomb["prediction"]["high"]
    assert coulomb["per_year"]["value"] == pytest.approx(0.88e-3 * 0.15, rel=0.5)
    assert coulomb["per_year"]["determined"]
    viscous = result["parameters"]["viscous"]
    true = 4.83e-6 * np.exp(0.75 * OIL.log_ratio(np.array([45.0]), 20.0)[0])
    assert viscous["prediction"]["low"] < true < viscous["prediction"]["high"]
    assert max(viscous["log_scores"], key=viscous["log_scores"].get) == "oil"
    assert "45 °C is outside the temperatures of the records" in said
    page = (out / "pool.html").read_text(encoding="utf-8")
    assert page.count('<div class="charts') == 2
    assert "2026-03-02" in page
    assert run(*words)[0] == 0


def test_the_model_is_that_of_the_prediction(folder, tmp_path):
    result = gs.pool(folder, tmp_path / "out")
    model = gs.read_model(tmp_path / "out" / "model.toml")
    for name in NAMES:
        prediction = result.parameters[name].prediction
        assert model.values[name] == pytest.approx(prediction.value)
        assert model.sigma[name] == pytest.approx(prediction.sigma)
    assert (model.values["inertia"], model.values["stribeck_speed"]) == (1.5e-3, 0.4189)
    assert model.wheel().friction.viscous == pytest.approx(model.values["viscous"])
    assert np.linalg.eigvalsh(model.covariance()[1]).min() > 0.0


def test_a_campaign_draws_the_wheel_of_a_further_record(folder, tmp_path):
    result = gs.pool(folder, tmp_path / "out")
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(SCENARIOS / name, tmp_path)
    (tmp_path / "scenario.toml").write_text(SCENARIO)
    scenario = gs.read_scenario(tmp_path / "scenario.toml")
    values, _ = draw(scenario, 1, np.arange(4000))
    columns = [scenario.dispersed.index(f"wheel.a.{name}") for name in ("viscous", "coulomb")]
    sigmas = [result.parameters[name].prediction.sigma for name in ("viscous", "coulomb")]
    np.testing.assert_allclose(values[:, columns].std(axis=0), sigmas, rtol=0.06)
    drawn = np.corrcoef(values[:, columns].T)[0, 1]
    assert drawn == pytest.approx(result.correlation[1, 2], abs=0.06)


def test_a_known_oil_narrows_the_prediction_elsewhere(folder):
    """Records at one temperature: an unknown oil is as uncertain as oils are."""
    for k in range(8):
        change(folder, k, mean_temperature=[20.0])
    result = gs.pool(folder, temperature=-10.0)
    assert any("do not determine the law over temperature of" in note for note in result.notes)
    known = gs.pool(folder, temperature=-10.0, oil="40:108,100:14.6")
    widths = [
        each.parameters["viscous"].prediction.sigma / each.parameters["viscous"].prediction.value
        for each in (result, known)
    ]
    assert widths[1] < 0.8 * widths[0]


def test_the_power_of_the_viscosity_is_said_and_that_of_a_wrong_oil_noted(folder):
    """The records have a power of 0.75; the viscosity of thin oils falls less."""
    said = []
    result = gs.pool(folder, oil="40:108,100:14.6", say=said.append)
    assert any("to the power 0.7" in line for line in said)
    assert not any("end of its range" in note for note in result.notes)
    flat = gs.pool(folder, oil="vogel:700,110")
    assert any("is at the end of its range, 0.5 to 1: another oil" in n for n in flat.notes)
    thin = gs.pool(folder, oil="40:10,100:5")
    assert any("parabola in temperature predicts the held-out" in note for note in thin.notes)


def test_the_error_of_the_inertia_is_common_and_moves_all_records(folder):
    """It is no scatter, and is in the prediction of the wheel but not in that of a record."""
    alone = gs.pool(folder).parameters["motor_constant"]
    for k in range(8):
        values = json.loads((folder / f"r{k}" / "fit.json").read_text())["parameters"]
        errors = {name: 0.02 * entry["value"] for name, entry in values.items()}
        for name, entry in values.items():
            entry["sigma"] = float(np.hypot(entry["sigma"], errors[name]))
        sigma = np.array([entry["sigma"] for entry in values.values()])
        own = CORRELATION * np.outer(SIGMA, SIGMA) + 0.02**2
        relative = sigma / np.array([entry["value"] for entry in values.values()])
        correlation = {
            "names": list(NAMES),
            "matrix": (own / np.outer(relative, relative)).tolist(),
        }
        tolerances = {"inertia": {"sigma": 0.02, "errors": errors}}
        change(folder, k, parameters=values, tolerances=tolerances, correlation=correlation)
    result = gs.pool(folder)
    common = result.parameters["motor_constant"]
    assert common.shared == pytest.approx(0.02)
    assert common.scatter.value == pytest.approx(alone.scatter.value, rel=0.02)
    assert common.record.sigma == pytest.approx(alone.record.sigma, rel=0.02)
    expected = np.hypot(alone.prediction.sigma, 0.02 * alone.prediction.value)
    assert common.prediction.sigma == pytest.approx(expected, rel=0.02)
    # a factor of the inertia is one of all torques
    viscous = result.parameters["viscous"].prediction
    expected = 0.02**2 * common.prediction.value * viscous.value
    expected /= common.prediction.sigma * viscous.sigma
    assert result.correlation[0, 1] == pytest.approx(expected, abs=0.1)


def test_without_dates_and_temperatures_there_is_no_law_and_notes_say_so(folder):
    change(folder, 3, metadata=[], mean_temperature=[])
    result = gs.pool(folder)
    viscous = result.parameters["viscous"]
    assert (viscous.trend, viscous.slope) == (None, None)
    assert any("no law over temperature: " in note and "r3" in note for note in result.notes)
    assert any("no trend over the date: " in note and "r3" in note for note in result.notes)
    # the effect of temperature is scatter then
    assert viscous.scatter.value > 0.15 * viscous.mean.value
    with pytest.raises(gs.InputError, match=r"^temperature: found one, but .*r3.* has none"):
        gs.pool(folder, temperature=30.0)
    with pytest.raises(gs.InputError, match=r"^date: found one, but .*r3.* has none"):
        gs.pool(folder, date="2027-01-01")
    warm = [20.0, 10.0, 30.0, 25.0, 5.0, 33.0, 20.0, 12.0]
    days = ",".join(f"2026-0{k + 1}-01" for k in range(8))
    stated = gs.pool(folder, temperatures=warm, dates=days)
    assert stated.conditions.temperatures.tolist() == warm
    assert stated.parameters["coulomb"].trend is not None
    with pytest.raises(gs.InputError, match=r"^dates: found 1, expected one for each of 8"):
        gs.pool(folder, dates="2026-01-01")
    assert gs.pool(folder, dates=["2026-01-01"] * 8).parameters["coulomb"].trend is None


def test_a_date_that_is_not_read_is_said(folder):
    change(folder, 3, metadata=[{"serial": "RW-07", "date": "10.03.26"}])
    text = "has the date '10.03.26', which is not one"
    assert any("r3" in note and text in note for note in gs.pool(folder).notes)


def test_a_prediction_far_from_the_records_is_noted_or_refused(folder):
    assert not any("years outside" in note for note in gs.pool(folder, date="2026-06-01").notes)
    notes = gs.pool(folder, date="2028-02-25").notes
    assert any("1 years outside those of the records" in note for note in notes)
    # a trend of 15 % a year leads below 0 before 2019
    with pytest.raises(gs.InputError, match=r"^date: found a prediction of \w+ of -"):
        gs.pool(folder, date="1999-01-01")


def test_a_static_torque_below_the_coulomb_torque_is_said(folder, tmp_path):
    for k in range(8):
        each = content(np.random.default_rng(k), k)
        values = each["parameters"]
        values["static"] = values["coulomb"] | {"value": values["coulomb"]["value"] * 0.99}
        change(folder, k, parameters=values)
    result = gs.pool(folder, tmp_path / "out")
    assert any("the prediction of static" in note for note in result.notes)
    values = gs.read_model(tmp_path / "out" / "model.toml").values
    assert values["static"] == values["coulomb"]


@pytest.mark.parametrize("words", [("--inertia", "2e-3"), ("--model", "stribeck")])
def test_options_of_identify_beside_fits_alone_are_refused(run, folder, tmp_path, words):
    code, _, said = run("pool", folder, *words, "--out", tmp_path / "out")
    assert code == 2
    assert f"{words[0]}: found identifications alone" in said


def test_temperatures_in_kelvin_need_their_unit(folder):
    kelvin = [293.15, 283.15, 303.15, 298.15, 278.15, 306.15, 293.15, 285.15]
    with pytest.raises(gs.InputError, match=r"found '293.15' without a unit, expected at most 200"):
        gs.pool(folder, temperatures=kelvin)
    stated = gs.pool(folder, temperatures=[f"{each} K" for each in kelvin])
    assert stated.conditions.temperatures[0] == pytest.approx(20.0)


def test_a_page_without_temperatures_and_a_law_that_is_not_of_this_package(folder, tmp_path):
    """There is no friction surface then, and no model.toml."""
    for k in range(8):
        change(folder, k, metadata=[], mean_temperature=[], model="mine")
    gs.pool(folder, tmp_path / "out")
    assert not (tmp_path / "out" / "model.toml").exists()
    page = (tmp_path / "out" / "pool.html").read_text(encoding="utf-8")
    assert page.count('<div class="charts') == 1
    assert "dates are unknown" in page


def test_a_wrong_record_is_named(folder):
    parameters = json.loads((folder / "r5" / "fit.json").read_text())["parameters"]
    parameters["coulomb"]["value"] *= 2.0
    change(folder, 5, parameters=parameters)
    notes = gs.pool(folder).notes
    assert any(note.startswith("2026-10-28 does not agree with") for note in notes)


def test_an_invalid_fit_is_left_out_and_said(folder):
    change(folder, 2, converged=False)
    change(folder, 4, impossible=["viscous is negative"])
    said = []
    result = gs.pool(folder, say=said.append)
    assert len(result.fits) == 6
    assert next(line for line in said if line.startswith("left out: ")).endswith("one that did")
    assert len(gs.pool(folder, force=True).fits) == 7


def test_one_serial_number_of_a_folder_of_wheels(folder):
    change(folder, 1, metadata=[{"serial": "RW-08", "date": "2026-02-01"}])
    with pytest.raises(gs.InputError, match="found records of several wheels, serial RW-07"):
        gs.pool(folder)
    assert len(gs.pool(folder, serial="RW-07").fits) == 7


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ({"held": {"inertia": 1.6e-3}}, "inertia 0.0016, expected 0.0015 as"),
        ({"held": {"inertia": 1.5e-3, "stribeck_speed": 1.0}}, "stribeck_speed 1, expected 0.4189"),
        ({"model": "other"}, "found other friction with motor_constant, .*, expected stribeck"),
    ],
)
def test_fits_that_do_not_belong_together_are_refused(folder, entries, message):
    change(folder, 1, **entries)
    with pytest.raises(gs.InputError, match=message):
        gs.pool(folder)


def test_one_record_and_the_same_record_twice_are_refused(folder):
    with pytest.raises(gs.InputError, match="of one wheel: found 1, expected at least 2"):
        gs.pool([folder / "r0"])
    with pytest.raises(gs.InputError, match=r"none\.csv: found no file"):
        gs.pool([folder / "r0", folder / "none.csv"])
    with pytest.raises(gs.InputError, match="found the same values as in"):
        gs.pool([folder / "r0", folder / "r0"])


def test_two_records_have_wide_intervals_and_no_held_out_check(folder):
    result = gs.pool([folder / "r0", folder / "r1"])
    assert any(note.startswith("2 records hardly show the scatter") for note in result.notes)
    coulomb = result.parameters["coulomb"]
    assert len(coulomb.held_out.scores) == 0
    assert coulomb.prediction.high - coulomb.prediction.low > 0.1 * coulomb.prediction.value
    json.dumps(result.to_dict(), allow_nan=False)


def test_records_are_identified_first(tmp_path):
    wheel = gs.Wheel(
        inertia=1.5e-3,
        motor_constant=0.0228,
        friction=gs.ViscousCoulomb(viscous=4.83e-6, coulomb=0.88e-3),
    )
    records = [
        gs.bench(wheel, duration="60 s", speed_sigma="5 rpm", low=0.06, high=0.15, seed=seed)
        for seed in (1, 2)
    ]
    options = {"inertia": "1.5e-3 +- 1 %", "model": "viscous-coulomb", "temperatures": [20.0, 30.0]}
    result = gs.pool(records, tmp_path / "out", **options)
    assert sorted(p.name[:2] for p in (tmp_path / "out" / "fits").iterdir()) == ["01", "02"]
    model = gs.read_model(tmp_path / "out" / "model.toml")
    assert model.sigma["inertia"] == pytest.approx(1.5e-5)
    assert set(model.values) == {"inertia", "motor_constant", "viscous", "coulomb"}
    again = gs.pool(tmp_path / "out" / "fits", temperatures=[20.0, 30.0])
    for name, parameter in result.parameters.items():
        assert again.parameters[name].prediction.low == pytest.approx(parameter.prediction.low)
    with pytest.raises(gs.InputError, match="inertia"):
        gs.pool(records)
