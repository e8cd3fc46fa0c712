"""Table of the runs column by column, and what is computed from it, against whole arrays."""

import json
import shutil
from functools import partial
from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.stats import rankdata

from gyrostat.campaigns import campaign_runs, ranks, run_table, worst_runs
from gyrostat.campaigns.drivers import drivers_of, find_drivers
from gyrostat.campaigns.ranks import Ranks, doubled_ranks
from gyrostat.campaigns.run_table import RunTable
from gyrostat.reports import campaign_content
from gyrostat.reports.campaign import write_campaign
from gyrostat.reports.campaign_charts import histograms
from gyrostat.reports.run_table import _extremes


@pytest.fixture
def written(tmp_path):
    """A table of 1000 runs in row groups of 64, and its columns."""
    random = np.random.default_rng(4)
    columns = {"run": np.arange(1000), "status": (random.random(1000) < 0.1).astype(np.int8)}
    columns |= {name: random.normal(size=1000) for name in "abc"}
    columns["c"][::3] = np.nan
    table = pa.table({**columns, "a.profile": [[1.0, 2.0]] * 1000})
    pq.write_table(table, tmp_path / "runs.parquet", row_group_size=64)
    return tmp_path / "runs.parquet", columns


@pytest.mark.parametrize("kept", [0, 10_000, 1_000_000])
def test_columns_are_those_of_the_file_whatever_stays_in_memory(written, monkeypatch, kept):
    monkeypatch.setattr(run_table, "KEPT", kept)
    path, columns = written
    table = RunTable(path)
    assert list(table) == list(columns)
    for _ in range(2):
        for name, values in columns.items():
            np.testing.assert_array_equal(table[name], values, strict=True)
            assert table.dtype(name) == values.dtype
    assert sum(each.nbytes for each in table._columns.values()) <= kept
    for count in (1, 64, 65, 1000, 5000):
        for name, values in table.head(count).items():
            np.testing.assert_array_equal(values, columns[name][:count])
    for run in (0, 63, 64, 999):
        expected = {name: values[run].item() for name, values in columns.items()}
        np.testing.assert_equal(table.row(run), expected)
    with pytest.raises(KeyError):
        table["a.profile"]


def test_a_column_cannot_be_changed(written):
    with pytest.raises(ValueError, match="read-only"):
        RunTable(written[0])["a"][0] = 1.0


@pytest.mark.parametrize("rows", [3, 10, 1000])
def test_ranks_in_parts_and_in_a_file_are_those_of_whole_arrays(monkeypatch, rows):
    monkeypatch.setattr(ranks, "ROWS", rows)
    monkeypatch.setattr(ranks, "IN_MEMORY", 100)
    random = np.random.default_rng(2)
    columns = [random.normal(size=97), np.round(random.normal(size=97)), np.ones(97)]
    with Ranks(97) as table:
        for values in columns:
            np.testing.assert_array_equal(doubled_ranks(values), 2.0 * rankdata(values))
            table.add(partial(np.copy, values))
        found = np.concatenate([*table.centred(range(3))])
    np.testing.assert_array_equal(found, np.transpose([rankdata(c) - 49.0 for c in columns]))


def test_drivers_of_columns_in_parts_are_those_of_matrices(monkeypatch):
    random = np.random.default_rng(3)
    drawn = random.normal(size=(500, 4))
    metrics = np.round(drawn[:, :3] + random.normal(size=(500, 3)), 1)
    metrics[random.random(500) < 0.3, 1] = np.nan
    whole = find_drivers(drawn, metrics)
    monkeypatch.setattr(ranks, "ROWS", 64)
    parts = drivers_of([*drawn.T], [*metrics.T])
    for found, expected in zip(parts, whole, strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-13)


@pytest.mark.parametrize("metric", ["value", "settling"])
@pytest.mark.parametrize("count", [0, 1, 7, 60, 100])
def test_worst_runs_are_the_first_of_all_in_order(metric, count):
    random = np.random.default_rng(5)
    value = np.round(random.normal(size=60), 1)
    value[::5] = np.nan
    columns = {
        "run": np.arange(60),
        metric: value,
        "status": (random.random(60) < 0.2).astype(np.int8),
        "ended": random.integers(1, 4, 60).astype(float),
        "error_max": np.round(random.normal(size=60), 1),
    }

    def worse(run):
        """Key that sorts the worst run first."""
        none = np.inf if metric == "settling" else -np.inf
        size = none if np.isnan(value[run]) else value[run]
        is_incomplete = columns["status"][run] != 0
        size = np.inf if is_incomplete else size
        ended = columns["ended"][run] if is_incomplete else 0.0
        return -size, ended, -columns["error_max"][run], run

    store = SimpleNamespace(columns=lambda: columns)
    assert worst_runs(store, count, metric) == sorted(range(60), key=worse)[:count]


@pytest.mark.parametrize("runs", [0, 1, 5, 50, 500])
def test_the_most_extreme_runs_are_those_of_a_sorted_column(runs):
    random = np.random.default_rng(runs)
    values = np.round(random.normal(size=runs), 1)
    values[random.random(runs) < 0.2] = np.nan
    values[runs // 3 : runs // 3 + 1] = np.inf
    finite = np.flatnonzero(np.isfinite(values))
    small, large = (
        finite[np.argsort(sign * values[finite], kind="stable")][:20] for sign in (1.0, -1.0)
    )
    assert _extremes(values) == list(zip(large.tolist(), small.tolist(), strict=True))


def test_a_histogram_in_parts_is_that_of_all_runs(monkeypatch, small, scenario):
    columns = small.store.columns()
    (whole,) = histograms(scenario, columns, {"error_max": []})
    monkeypatch.setattr("gyrostat.reports.campaign_charts._AT_ONCE", 7)
    (in_parts,) = histograms(scenario, columns, {"error_max": []})
    assert in_parts.svg() == whole.svg()


def test_the_dataset_of_a_large_table_reads_a_variable_when_it_is_used(monkeypatch, small):
    read = []
    column = RunTable._read
    monkeypatch.setattr(
        RunTable,
        "_read",
        lambda table, name, count: (read.append(name), column(table, name, count))[1],
    )
    whole = campaign_runs(small.out)
    monkeypatch.setattr(run_table, "LARGE", 100)
    read.clear()
    lazy = campaign_runs(small.out)
    assert read == []
    np.testing.assert_array_equal(lazy["run"], np.arange(small.runs))
    assert lazy["error_max"].attrs == whole["error_max"].attrs
    assert lazy["error_max"].mean().item() == whole["error_max"].mean().item()
    assert lazy["energy"][5].item() == whole["energy"][5].item()
    assert set(read) == {"error_max", "energy"}
    np.testing.assert_array_equal(lazy["energy"].sel(run=[3, 1]), whole["energy"][[3, 1]])
    assert lazy.load().identical(whole)


def test_the_report_of_a_large_table_takes_its_statistics_from_report_json(
    monkeypatch, small, tmp_path
):
    """Unless other code computed them, or the file was changed."""
    monkeypatch.setattr(run_table, "LARGE", 100)
    out = tmp_path / "out"
    shutil.copytree(small.out, out)
    computed = []
    compute = campaign_content.metric_statistics

    def counted(*arguments):
        computed.append(arguments)
        return compute(*arguments)

    def report():
        return write_campaign(out, command="test", say=lambda text: None)

    monkeypatch.setattr(campaign_content, "metric_statistics", counted)
    first = report()
    assert len(computed) == 1
    assert report() == first
    assert len(computed) == 1
    monkeypatch.setattr(campaign_content, "source_digest", lambda: "another")
    assert report() != first
    assert report() == report()
    assert len(computed) == 2
    path = out / "report.json"
    path.write_text(path.read_text().replace("error_max", "error_min"))
    assert json.loads(report())["metrics"] == json.loads(first)["metrics"]
    assert len(computed) == 3
