"""The verb `lot`: files, scenarios that read them, and what it refuses."""

import json
import shutil
from datetime import date, timedelta
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

import gyrostat as gs
from gyrostat.campaigns.draws import draw

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
SCENARIO = """[run]
duration = "10 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "three_axis"
[[dispersion]]
lot = "lot.toml"
wheel = "WHEEL"
"""
NAMES = ("motor_constant", "viscous", "coulomb")
UNITS = ("N·m/A", "N·m·s/rad", "N·m")
MEDIAN = np.array([0.0228, 4.83e-6, 0.8795e-3])
SPREAD = np.array([0.01, 0.2, 0.1]) * MEDIAN
SIGMA = np.array([0.002, 0.05, 0.02]) * MEDIAN


def content(values, number):
    """Content of a fit.json."""
    return {
        "model": "viscous-coulomb",
        "converged": True,
        "parameters": {
            name: {"value": value, "sigma": sigma, "unit": unit}
            for name, value, sigma, unit in zip(NAMES, values, SIGMA.tolist(), UNITS, strict=True)
        },
        "correlation": {"names": list(NAMES), "matrix": np.eye(3).tolist()},
        "tolerances": {
            "current_scale": {
                "sigma": 0.0015,
                "errors": dict(zip(NAMES, 0.0015 * MEDIAN, strict=True)),
            }
        },
        "metadata": [
            {"serial": f"RW-{number:02}", "date": str(date(2026, 1, 1) + timedelta(number))}
        ],
    }


@pytest.fixture
def folder(tmp_path):
    """Folder with 24 fits."""
    values = MEDIAN + SPREAD * np.random.default_rng(910850).standard_normal((24, 3))
    for k, row in enumerate(values.tolist()):
        path = tmp_path / "lot" / f"w{k:02}"
        path.mkdir(parents=True)
        (path / "fit.json").write_text(json.dumps(content(row, k)))
    return tmp_path / "lot"


def scenario_of(folder, wheel):
    """Scenario whose wheels are drawn from the lot.toml beside it."""
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, folder)
    (folder / "scenario.toml").write_text(SCENARIO.replace("WHEEL", wheel))
    return folder / "scenario.toml"


def change(folder, number, **entries):
    """Replace entries of one fit.json."""
    path = folder / f"w{number:02}" / "fit.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), **entries}))


def test_the_files_of_a_lot(run, folder, tmp_path):
    out = tmp_path / "out"
    words = ("lot", folder, "--shape", "normal", "--best", "matched motor_constant")
    code, printed, said = run(*words, "--out", out, "--json")
    assert code == 0
    assert sorted(p.name for p in out.iterdir() if p.name[0] != ".") == [
        "lot.html",
        "lot.json",
        "lot.toml",
    ]
    result = json.loads(printed)
    assert result["wheels"] == 24
    assert result["best_set"]["rule"] == "matched"
    assert len(result["best_set"]["wheels"]) == 4
    coulomb = result["parameters"]["coulomb"]
    # the closed form with equal errors, at the median of chi-square with 23 degrees
    variance = 23 * coulomb["sigma_estimates"] ** 2 / 22.337 - SIGMA[2] ** 2
    assert coulomb["sigma"]["value"] == pytest.approx(np.sqrt(variance), rel=2e-3)
    assert "best set of 4" in said
    page = (out / "lot.html").read_text(encoding="utf-8")
    assert page.count('<div class="charts') == 2
    assert "RW-23" in page
    assert run(*words, "--out", out)[0] == 0


def test_an_error_that_all_wheels_share_moves_the_lot_and_is_no_spread(folder):
    alone = gs.lot(folder, shape="normal").parameters["motor_constant"]
    common = gs.lot(folder, shape="normal", same_bench=True).parameters["motor_constant"]
    assert common.common_error == pytest.approx(0.0015 * MEDIAN[0])
    # not taken out of the spread of the estimates, of which it is no part
    expected = np.hypot(alone.sigma.value, common.common_error)
    assert common.sigma.value == pytest.approx(expected, rel=1e-3)
    widths = [p.median.high - p.median.low for p in (alone, common)]
    assert widths[1] > widths[0]


def test_a_scenario_draws_its_wheels_from_the_lot(folder, tmp_path):
    result = gs.lot(folder, tmp_path / "out", shape="normal")
    text = (tmp_path / "out" / "lot.toml").read_text()
    (tmp_path / "lot.toml").write_text(text.replace("viscous-coulomb", "stribeck"))
    scenario = gs.read_scenario(scenario_of(tmp_path, "*"))
    values, _ = draw(scenario, 1, np.arange(4000))
    column = scenario.dispersed.index("wheel.b.coulomb")
    lot = result.parameters["coulomb"]
    assert np.median(values[:, column]) == pytest.approx(lot.draws.typical()[0], rel=0.005)
    assert values[:, column].std() == pytest.approx(lot.draws.typical()[1], rel=0.05)
    columns = [scenario.dispersed.index(f"wheel.a.{name}") for name in ("viscous", "coulomb")]
    drawn = np.corrcoef(values[:, columns].T)[0, 1]
    assert drawn == pytest.approx(result.correlation.value[1, 2], abs=0.05)
    assert abs(np.corrcoef(values[:, column], values[:, columns[1]])[0, 1]) < 0.06


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("names", "wheel_names", "wheel_names.*did you mean"),
        ("scale = [", "scale = [0.0, ", "key scale: found no 3 finite numbers"),
        ('"viscous-coulomb"', '"coulomb"', "friction model 'coulomb', expected .* 'stribeck'"),
    ],
)
def test_a_lot_that_cannot_be_is_refused(folder, tmp_path, before, after, message):
    gs.lot(folder, tmp_path / "out", shape="normal")
    text = (tmp_path / "out" / "lot.toml").read_text()
    (tmp_path / "lot.toml").write_text(text.replace(before, after, 1))
    with pytest.raises(gs.InputError, match=f"lot.toml.*{message}"):
        gs.read_scenario(scenario_of(tmp_path, "a"))


def test_without_dates_there_is_no_drift_and_a_note_says_so(folder, tmp_path):
    change(folder, 3, metadata=[{"serial": "RW-03"}])
    result = gs.lot(folder, shape="normal")
    assert result.days is None
    assert all(parameter.drift is None for parameter in result.parameters.values())
    assert any("a date is unknown" in note for note in result.notes)
    change(folder, 3, metadata=[{"serial": "RW-03", "date": "13.13.2026"}])
    notes = gs.lot(folder, shape="normal").notes
    assert any("w03" in note and "'13.13.2026' is not one that is read" in note for note in notes)
    manifest = tmp_path / "dates.csv"
    manifest.write_text("\n".join(["serial,date", *(f"RW-{k:02},2026-03-01" for k in range(24))]))
    notes = gs.lot(folder, shape="normal", manifest=manifest).notes
    assert not any("is not one that is read" in note for note in notes)


def test_a_motor_constant_of_another_sign_is_refused(folder):
    parameters = content(MEDIAN.tolist(), 5)["parameters"]
    parameters["motor_constant"]["value"] *= -1.0
    change(folder, 5, parameters=parameters)
    with pytest.raises(gs.InputError, match=r"w05.*found motor_constant of another sign"):
        gs.lot(folder)


def test_values_that_are_not_held_alike_are_noted(folder):
    for number in range(24):
        bench = {"current_bias": 1e-4 * number, "inertia": 1e-3 * (1 + number)}
        change(folder, number, held={**bench, "stribeck_speed": 0.4})
    assert not any("is held at" in note for note in gs.lot(folder, shape="normal").notes)
    change(folder, 5, held={"inertia": 1e-3, "stribeck_speed": 2.0})
    notes = gs.lot(folder, shape="normal").notes
    assert any("stribeck_speed is held at 0.4 in" in note and "w05" in note for note in notes)


@pytest.mark.parametrize(("power", "text"), [(1.0, ""), (4.0, "heavier"), (0.0, "shorter")])
def test_tails_that_are_not_those_of_the_model_are_named(folder, power, text):
    """Quantiles of a normal distribution, of one with heavier tails, and of two groups."""
    score = norm.ppf((np.arange(24) + 0.5) / 24)
    score = np.sign(score) * np.abs(score) ** power
    for number, value in enumerate(score.tolist()):
        values = MEDIAN * (1.0 + 0.05 * value)
        change(folder, number, parameters=content(values.tolist(), number)["parameters"])
    notes = [note for note in gs.lot(folder, shape="normal").notes if "tails" in note]
    assert bool(notes) == bool(text)
    assert all(text in note for note in notes)


def test_a_manifest_replaces_the_dates(folder, tmp_path):
    rows = [f"RW-{k:02}, {date(2026, 3, 1) - timedelta(2 * k)}" for k in range(24)]
    manifest = tmp_path / "dates.csv"
    manifest.write_text("\n".join(["serial, date", *rows]))
    result = gs.lot(folder, shape="normal", manifest=manifest)
    assert result.labels[0] == "RW-23"
    assert result.days[-1] == 46.0
    for text, message in (
        ("serial,when\nRW-00,2026-01-01", "found columns serial, when"),
        ("serial,date\nRW-00,soon", r"row 2: found date 'soon'"),
        ("serial,date\nRW-00,2026-01-01\nRW-00,2026-01-02", "row 3: found RW-00 twice"),
        ("serial,date\nRW-00,2026-01-01", "found no row of RW-01"),
    ):
        manifest.write_text(text)
        with pytest.raises(gs.InputError, match=message):
            gs.lot(folder, manifest=manifest)


def bad_fit(what):
    """Entries of a fit.json with one mistake."""
    entries = content(MEDIAN.tolist(), 5)
    if what == "model":
        return {"model": "stribeck"}
    if what == "covariance":
        return {"correlation": None}
    if what == "serial":
        return {"metadata": [{"serial": "RW-02"}]}
    if what == "unit":
        entries["parameters"]["coulomb"]["unit"] = "mN·m"
    elif what == "parameter":
        del entries["parameters"]["coulomb"]
    else:
        entries["parameters"]["coulomb"]["value"] = {"nan": float("nan"), "sign": -1e-3}[what]
    return {"parameters": entries["parameters"]}


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ("model", "friction model stribeck, expected viscous-coulomb"),
        ("covariance", "found no parameters with sigma and correlation"),
        ("serial", "found serial number RW-02, expected another"),
        ("unit", "found units N·m/A, N·m·s/rad, mN·m, expected"),
        ("parameter", "found parameters motor_constant, viscous, expected"),
        ("nan", "expected finite values"),
        ("sign", "found coulomb of another sign"),
    ],
)
def test_fits_of_no_lot_are_refused_in_one_line(run, folder, tmp_path, what, message):
    change(folder, 5, **bad_fit(what))
    code, printed, said = run("lot", folder, "--shape", "log-normal", "--out", tmp_path / "out")
    assert (code, printed) == (2, "")
    assert said.startswith("error: ")
    assert "w05" in said
    assert message in said
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"best": "cheapest"}, "best: found 'cheapest', expected one of lowest"),
        ({"best": "lowest price"}, "best: found 'price'"),
        ({"set_size": 24}, "set_size: found 24"),
        ({"content": "101 %"}, "content: found 101 %"),
        ({"confidence": 0.3}, "confidence: found 0.3"),
        ({"shape": "round"}, "shape: found 'round'"),
    ],
)
def test_arguments_that_cannot_be_are_refused(folder, options, message):
    with pytest.raises(gs.InputError, match=message):
        gs.lot(folder, **options)


def test_copies_of_a_fit_are_no_lot(folder):
    for number in range(24):
        change(folder, number, parameters=content(MEDIAN.tolist(), number)["parameters"])
    with pytest.raises(gs.InputError, match="found the same motor_constant in all fits"):
        gs.lot(folder)


def test_too_few_wheels_are_refused(folder, tmp_path):
    with pytest.raises(gs.InputError, match="found 19 wheels, expected at least 20"):
        gs.lot(sorted(folder.iterdir())[:19])
    (tmp_path / "empty").mkdir()
    with pytest.raises(gs.InputError, match=r"found no \*/fit.json"):
        gs.lot(tmp_path / "empty")
