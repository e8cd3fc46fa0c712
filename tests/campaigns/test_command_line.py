"""The verbs as an engineer meets them, on the small campaign."""

import dataclasses
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import gyrostat as gs
from gyrostat.campaigns import campaign_runs, engine
from gyrostat.core.units import RPM
from gyrostat.reports import campaign as report_module
from gyrostat.runs import fingerprint


def test_a_finished_campaign_flies_nothing_and_reports(run, small, folder):
    words = ("--runs", small.runs, "--seed", small.seed, "--keep", "5", "--worst", "1")
    code, out, err = run("campaign", folder / "scenario.toml", *words, "--out", small.out)
    assert (code, out) == (0, "")
    assert f"{small.runs} of {small.runs} runs are already complete" in err
    assert "99 complete, 1 diverged" in err
    page = (small.out / "report.html").read_text()
    # errors over time, metrics of the run and of two windows, over their drivers, a kept run
    assert page.count('<svg class="chart"') > 60
    assert "Window imaging" in page
    assert "From 1 s to 6.9 s after worn; boresight 0, 1, 0 in body axes." in page
    assert "diverged after" in page
    assert not re.findall(r"""(?:src|href)=["']?(?:http|//)|url\(http|@import""", page)


def test_a_report_is_made_without_pandas_and_xarray(small):
    code = (
        "import sys; from gyrostat.cli import main; main(); "
        "print(*{'pandas', 'xarray'} & {*sys.modules})"
    )
    words = [sys.executable, "-c", code, "report", str(small.out)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert done.stdout == "\n"


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (("--runs", 99, "--seed", 16), "found a campaign with another number of runs, 100"),
        (("--runs", 100, "--seed", 1), "found a campaign with another seed, 16"),
        (("--runs", 100, "--seed", 16, "--keep", "100"), "kept run: found 100, expected 0 to 99"),
        (("--runs", 100, "--seed", 16, "--keep", "a"), "--keep: found 'a'"),
        (("--runs", 100, "--seed", 16, "--worst-by", "luck"), "worst by: found 'luck', expected"),
        (("--runs", 100, "--seed", 16, "--device", "tpu"), "--device: found 'tpu', expected one"),
    ],
)
def test_another_campaign_in_the_folder_is_refused(run, small, folder, words, found):
    code, _, err = run("campaign", folder / "scenario.toml", *words, "--out", small.out)
    assert code == 2
    assert found in err


def test_the_report_says_what_drives_the_error(run, small):
    code, out, _ = run("report", small.out, "--json")
    assert code == 0
    told = json.loads(out)
    assert told == json.loads((small.out / "report.json").read_text())
    assert told["ended"] == {"complete": 99, "diverged": 1}
    table = small.store.read_table()
    (bad,) = told["not_complete"]
    assert table["status"][bad["run"]].as_py() == 1
    own = told["metrics"]["error_end"]
    median = own["percentiles"][0]
    values = np.sort(table["error_end"].to_numpy())[:99]
    assert median["value"] == values[49]
    assert median["low"] < median["value"] < median["high"]
    ended = table["status"].to_numpy() == 0
    for driver in (own["drivers"][0], own["drivers"][-1]):
        rank = table[driver["key"]].to_numpy()[ended].argsort().argsort()
        error = table["error_end"].to_numpy()[ended].argsort().argsort()
        assert driver["rank_correlation"] == pytest.approx(np.corrcoef(rank, error)[0, 1])
    assert own["window"] is None
    assert told["metrics"]["imaging.smear"]["window"] == "imaging"
    window = told["windows"]["turning"]
    assert window["worst_by"] == "turning.error_p99.7"
    largest = np.nanmax(table["turning.error_p99.7"].to_numpy())
    assert [each["value"] for each in window["worst"][:2]] == [None, largest]
    sizes = [abs(driver["rank_correlation"]) for driver in own["drivers"]]
    assert sizes == sorted(sizes, reverse=True)
    assert len(sizes) == 15  # one for each dispersed value


def test_a_run_is_flown_again_bit_for_bit_by_another_process(run, small):
    with xr.open_dataset(small.store.history(5), engine="h5netcdf") as found:
        before = found.load()
    small.store.history(5).unlink()
    code, _, err = run("replay", small.out, 5)
    assert code == 0
    assert "bit for bit" in err
    with xr.open_dataset(small.store.history(5), engine="h5netcdf") as found:
        assert found.identical(before)
    assert (small.out / "runs" / "run_000005.html").read_text().count('class="plot"') == 4


def test_a_replay_that_differs_is_refused(run, small, tmp_path):
    shutil.copytree(small.out, tmp_path / "copy")
    other = {**small.campaign.engine, "instructions": "x86_64 sse2"}
    text = dataclasses.replace(small.campaign, engine=other).text()
    (tmp_path / "copy" / "campaign.json").write_text(text)
    code, _, err = run("replay", tmp_path / "copy", 5)
    assert code == 2
    assert "expected x86_64 sse2, as recorded" in err
    assert run("replay", tmp_path, 5)[0] == 2
    assert run("replay", small.out, 100)[0] == 2


def test_a_single_run_is_written_with_its_page(run, small, folder, tmp_path, monkeypatch):
    flown = small.fly(None, keep=(0,))
    # this process has computed already, with other flags: a worker has flown for it
    monkeypatch.setattr(fingerprint, "use_engine", lambda record: None)
    monkeypatch.setattr(engine, "fly", lambda scenario, seed, runs, keep, engine: flown)
    words = ("--engine", "jax", "--out", tmp_path / "a.nc", "--json")
    code, out, err = run("simulate", folder / "scenario.toml", *words)
    assert code == 0
    assert "complete, 30 s" in err
    told = json.loads(out)
    assert told["status"] == "complete"
    assert told["metrics"]["error_end"] == flown.columns["error_end"][0]
    with xr.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as found:
        assert found.error.attrs["units"] == "rad"
        assert found.sizes["time"] == 121
        assert float(found.wheel_speed[0, 1]) == pytest.approx(-200.0 * RPM)  # nothing is drawn
    assert (tmp_path / "a.html").read_text().count('class="plot"') == 4


def test_bad_words_are_one_line(run, folder, tmp_path, monkeypatch):
    monkeypatch.setattr(fingerprint, "use_engine", lambda record: None)
    path = folder / "scenario.toml"
    for words, found in (
        (("simulate", path, "--out", tmp_path / "run.csv"), "expected a name that ends in .nc"),
        (("simulate", tmp_path / "no.toml", "--out", tmp_path / "a.nc"), "found no such file"),
        (
            ("simulate", path, "--out", tmp_path / "a.nc", "--device", "tpu"),
            "--device: found 'tpu'",
        ),
        (
            ("simulate", path, "--out", tmp_path / "a.nc", "--engine", "c"),
            "--engine: found 'c', expected one of auto, native, jax",
        ),
        (("report", tmp_path), "found no campaign.json"),
    ):
        code, out, err = run(*words)
        assert (code, out) == (2, "")
        assert len(err.splitlines()) == 1
        assert found in err
    assert list(Path(tmp_path).iterdir()) == []


def test_a_scheduler_needs_dask(run, folder, tmp_path):
    try:
        import distributed  # noqa: F401
    except ImportError:
        words = ("--runs", 3, "--scheduler", "tcp://127.0.0.1:1", "--out", tmp_path / "x")
        code, _, err = run("campaign", folder / "scenario.toml", *words)
        assert code == 2
        assert "pip install 'dask>=2025.1' 'distributed>=2025.1'" in err
    else:
        pytest.skip("dask[distributed] is installed")


def test_the_same_from_python(small, folder):
    again = gs.campaign(folder / "scenario.toml", small.runs, small.out, seed=small.seed, worst=1)
    table = small.store.read_table()
    assert again.sizes["run"] == small.runs
    for name in table.column_names:
        np.testing.assert_array_equal(again[name].values, table[name].to_numpy())
    whole = table["status"].to_numpy() == 0
    assert float(again.error_max.where(again.status == 0).quantile(0.997)) == pytest.approx(
        np.quantile(table["error_max"].to_numpy()[whole], 0.997)
    )
    assert again.error_max.attrs["units"] == "rad"
    assert again["wheel.a.coulomb"].attrs["units"] == "N·m"
    assert again["event.loss.time"].attrs["units"] == "s"
    assert again["imaging.jitter"].attrs["units"] == "rad"
    assert again["turning.settling"].attrs["long_name"].startswith("Time from the start of the w")
    assert again.attrs == {"scenario": "small", "folder": str(small.out), "seed": small.seed}
    assert gs.report(small.out) == json.loads((small.out / "report.json").read_text())


def test_a_replay_is_labelled(small, monkeypatch):
    # the worker of the fixture has traced the scenario; `run("replay")` above starts its own
    monkeypatch.setattr("gyrostat.campaigns.processes", lambda workers: small.opener)
    history = gs.replay(campaign_runs(small.out), 5)
    assert history.wheel_speed.sel(wheel="b").dims == ("time",)
    assert history.rate.sel(axis="z").units == "rad/s"
    np.testing.assert_array_equal(history.wheel, ["a", "b", "c", "d"])
    assert float(history.error.max()) < 1.0


def test_a_run_from_python_says_how_it_ended(small, folder, monkeypatch):
    flown = small.fly(None, keep=(0,))
    monkeypatch.setattr(fingerprint, "use_engine", lambda record: None)
    monkeypatch.setattr(engine, "fly", lambda text, seed, runs, keep, engine: flown)
    run = gs.simulate(folder / "scenario.toml", engine="jax")
    assert int(run.status) == 0
    assert run.attrs["scenario"] == "small"
    assert run.attrs["error_end"] == flown.columns["error_end"][0]
    assert float(run.wheel_speed.sel(wheel="b")[0]) == pytest.approx(-200.0 * RPM)


def test_requirements_have_a_verdict_and_the_check_an_exit_code(run, small, scenario, monkeypatch):
    code, out, err = run("report", small.out, "--check", "--json")
    assert code == 1
    told = {each["name"]: each for each in json.loads(out)["requirements"]}
    verdicts = {name: each["verdict"] for name, each in told.items()}
    # one of the 100 runs diverged
    assert told["ape"]["runs"] == 100
    assert set(verdicts) == {"ape", "rpe", "pde", "between", "ake"}
    assert verdicts["pde"] == "fail"
    assert verdicts["between"] == "not decided"
    assert told["between"]["size"]["value"] is None
    assert "100 runs cannot show 99.7 %: at least 1228 are needed" in told["between"]["why"]
    for each in told.values():
        assert f"requirement {each['name']}: {each['verdict'].upper()}" in err
        if each["verdict"] == "pass":
            assert each["size"]["high"] <= each["required"]
            assert each["margin"]["low"] == pytest.approx(
                1.0 - each["size"]["high"] / each["required"]
            )
    assert "check: " in err
    page = (small.out / "report.html").read_text()
    assert "PDE at most 0.01 arcsec; about the boresight; window 1 s; stability time 2 s" in page
    said = []
    gs.check(scenario, say=said.append)
    assert any("requirement between: PRE at most 45 deg" in line for line in said)
    assert any("needs 1228 runs or more" in line for line in said)
    # a scenario whose requirements are met, and one without any
    for found, expected in (([{"name": "a", "verdict": "pass"}], 0), ([], 2)):
        text = json.dumps({"requirements": found})
        monkeypatch.setattr(report_module, "write_campaign", lambda *_, text=text, **__: text)
        code, _, err = run("report", small.out, "--check")
        assert code == expected
        assert ("without [[requirement]]" in err) == (expected == 2)
