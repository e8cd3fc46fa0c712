"""Plan of a campaign: imitated tables, the estimate, and the command."""

import json
import time

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.campaigns import Campaign, Store, campaign_runs
from gyrostat.campaigns.blocks import list_parts
from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.executors import threads
from gyrostat.campaigns.flown import Flown
from gyrostat.campaigns.imitation import imitated_runs, write_imitation
from gyrostat.campaigns.pointing.campaign import ERROR_PROFILE, PROFILED
from gyrostat.reports.campaign import write_campaign
from gyrostat.verbs import campaign_plan, plan_measurements


@pytest.fixture(scope="module")
def few(small, scenario):
    """Columns of the simulated runs, with the lists of some."""
    table = small.store.read_table()
    columns = {name: table[name].to_numpy() for name in table.column_names}
    with small.store.open_table() as file:
        profile = np.concatenate([*list_parts(file, ERROR_PROFILE, small.runs)])
    rows = np.arange(len(columns["run"])) % len(profile)
    return {**columns, ERROR_PROFILE: profile[rows].astype(np.float32)}


def test_imitated_runs_have_their_own_draws_and_the_same_kinds_of_values(scenario, few):
    runs = np.arange(PROFILED - 50, PROFILED + 150)
    imitated = imitated_runs(scenario, 16, runs, few)
    expected = draw(scenario, 16, runs)[0]
    for k, key in enumerate(scenario.dispersed):
        np.testing.assert_array_equal(imitated[key], expected[:, k])
    errors = imitated["error_rms"][np.isfinite(imitated["error_rms"])]
    assert 150 < len(np.unique(errors)) == len(errors)
    assert set(imitated["status"]) == set(few["status"])
    has_profile = np.any(np.isfinite(imitated[ERROR_PROFILE]), axis=1)
    np.testing.assert_array_equal(has_profile, runs < PROFILED)


def test_an_imitated_campaign_has_a_report_and_is_a_table_of_runs(tmp_path, small, scenario, few):
    known = small.store.known()
    campaign = Campaign(known.scenario, known.digest, 16, 300, 64, known.engine)
    store = Store(tmp_path)
    with store.locked():
        write_imitation(store, scenario, campaign, few)
        store.merge(campaign)
    content = json.loads(write_campaign(tmp_path, command="test", say=lambda text: None))
    assert content["runs"] == 300
    # its drawn values are those of the scenario, otherwise there would be no effects
    assert "draws" not in str(content["metrics"]["error_max"]["effects"]["why"])
    assert campaign_runs(tmp_path).sizes["run"] == 300


def linear(runs, wall, processor, memory, disk, write):
    """Measurements of a table of runs."""
    numbers = {"wall": wall, "processor": processor, "memory": memory, "disk": disk}
    return {"runs": runs, "write": write, **numbers}


def measurements(**changes):
    """Measurements of a machine with simple numbers, two workers."""
    return {
        "few": 64,
        "block": 64,
        "workers": 2,
        "in_threads": False,
        "whole": {"wall": 5.0, "processor": 4.0, "memory": 1e8, "disk": 65_000},
        "pace": {
            "wall": 0.1,
            "processor": 0.1,
            "job": 0.064,
            "start": 3.0,
            "memory": 2e8,
            "memory_here": 1.5e8,
        },
        "draws": 1e-4,
        "tables": [
            linear(64, 0.2, 0.1, 1.2e8, 64_000, 0.064),
            linear(20_000, 2.2, 2.1, 1.4e8, 20_000_000, 20.0),
            linear(100_000, 10.2, 10.1, 2.2e8, 100_000_000, 100.0),
        ],
        **changes,
    }


def test_the_estimate_adds_what_each_further_run_costs(monkeypatch):
    monkeypatch.setattr(campaign_plan, "usable_cores", lambda: 2)
    runs = 64 + 60 * 64
    plan = campaign_plan.estimate(measurements(), runs)
    further = runs - 64
    slope = further / (20_000 - 64)
    late = 2.0 * slope
    here = (20.0 - 0.064) * slope + 60 * 0.064
    processor = 4.0 + 0.1 * further + here + late + 1e-4 * further + 3.0
    assert plan["core_hours"] * 3600.0 == pytest.approx(processor)
    flights = max(0.1 * further / 2, (0.1 * further + here) / 2)
    assert plan["seconds"] == pytest.approx(5.0 + flights + late + 1e-4 * further)
    assert plan["disk"] == pytest.approx(1000 + 64_000 + (20_000_000 - 64_000) * slope)
    assert plan["memory"] == pytest.approx(1.5e8 + 2 * 2e8)
    assert plan["workers"] == 2


def test_beyond_the_largest_table_the_estimate_goes_on_in_a_straight_line():
    million = campaign_plan.estimate(measurements(), 1_000_000)
    assert million["command_memory"] == pytest.approx(2.2e8 + 9e5 * 1e3)
    assert million["disk"] == pytest.approx(1000 + 1e9)


def test_threads_are_in_the_memory_of_the_command():
    plan = campaign_plan.estimate(measurements(in_threads=True), 1000)
    assert (plan["worker_memory"], plan["memory"]) == (0.0, plan["command_memory"])


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (("--rare", "error_max > 1"), "--plan: found --rare, expected these with a campaign only"),
        (("--scheduler", "tcp://a:1"), "--plan: found --scheduler, expected these with"),
        (("--engine", "cuda"), "--plan: found --engine cuda, expected the engine native or jax"),
    ],
)
def test_options_without_a_plan_are_refused(run, folder, tmp_path, words, found):
    scenario = folder / "scenario.toml"
    code, out, err = run("campaign", scenario, "--runs", 100, "--plan", *words)
    assert (code, out) == (2, "")
    assert found in err


def test_the_command_prints_the_plan_and_writes_nothing(run, folder, tmp_path, monkeypatch):
    monkeypatch.setattr(campaign_plan, "measured", lambda request: measurements())
    monkeypatch.setattr("gyrostat.campaigns.execute.chosen_engine", lambda engine, *rest: "jax")
    words = ("campaign", folder / "scenario.toml", "--runs", 5000, "--out", tmp_path / "out")
    code, out, err = run(*words, "--plan", "--json")
    assert code == 0
    content = json.loads(out)
    assert (content["runs"], content["engine"], content["units"]["seconds"]) == (5000, "jax", "s")
    assert "5000 runs of small, engine jax:" in err
    assert "for the command, 191 MiB for each of 2 workers" in err
    assert not (tmp_path / "out").exists()
    plan = gs.campaign(folder / "scenario.toml", 5000, plan=True)
    assert plan["seconds"].attrs["units"] == "s"
    assert plan["seconds"].item() == content["seconds"]


def test_the_pace_is_of_jobs_after_the_first_of_each_worker(monkeypatch, small):
    monkeypatch.setattr(plan_measurements, "_STEADY", 0.0)
    columns, given = {"run": np.arange(64)}, []

    def simulate(job):
        given.append(job)
        time.sleep(0.02 if len(given) <= 2 else 0.001)
        return Flown(columns, None)

    work = plan_measurements.TimedWork(simulate, in_threads=True)
    campaign = small.store.known()
    found, pace = plan_measurements.pace_of(campaign, threads(2), 2, work)
    assert found is columns
    assert len(given) == 8
    assert all(job.runs == tuple(range(campaign.runs)) for job in given)
    assert 0.001 <= campaign.runs * pace["wall"] < 0.02
    assert pace["start"] == 0.0
    assert pace["memory"] > 1e8


def test_tables_are_measured_up_to_the_number_of_runs(tmp_path, monkeypatch, small, scenario, few):
    monkeypatch.setattr(plan_measurements, "SIZES", (100, 1000))
    known = small.store.known()
    campaign = Campaign(known.scenario, known.digest, 16, 130, 64, known.engine)
    tables = plan_measurements.tables_of(tmp_path, scenario, campaign, few)
    assert [table["runs"] for table in tables] == [64, 100, 130]
    for table in tables:
        folder = tmp_path / f"{table['runs']}"
        assert table["disk"] == sum(p.stat().st_size for p in folder.rglob("*") if p.is_file())
        assert table["processor"] > 0.0


def test_a_process_that_fails_is_reported_by_its_last_line():
    request = {"text": "{", "runs": 65, "seed": 1, "engine": "jax", "workers": 1, "block": None}
    with pytest.raises(gs.InputError, match=r"^--plan: found runs that fail \(.*JSON"):
        campaign_plan.measured(request)
