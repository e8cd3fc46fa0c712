"""The page of a campaign: charts, embedded values of the runs, and work with it in a browser."""

import base64
import html
import json
import re
import shutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import gyrostat as gs
from gyrostat.campaigns.blocks import columns_of
from gyrostat.reports.axis import Axis, axis_of, scaled_unit
from gyrostat.reports.campaign import _campaign_page
from gyrostat.reports.campaign_charts import histograms
from gyrostat.reports.campaign_content import campaign_lines, driver_rows, headline
from gyrostat.reports.chart import Chart
from gyrostat.reports.requirements import required_in
from gyrostat.reports.run_charts import run_charts
from gyrostat.reports.run_table import packed, rounded, run_table


@pytest.fixture(scope="module")
def made(small):
    """Content, page and lines of the small campaign."""
    content, page, lines = _campaign_page(small.out, "x", str(small.out))
    columns = columns_of(small.store.read_table())
    return SimpleNamespace(content=content, page=page, lines=lines, columns=columns)


@pytest.fixture(scope="module")
def address(made, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "report.html"
    path.write_text(made.page)
    return path.as_uri()


def unpacked(text):
    parts = np.frombuffer(base64.b64decode(text), np.uint8).reshape(-1, 3).astype(np.uint32)
    words = parts[:, 0] << 24 | parts[:, 1] << 16 | parts[:, 2] << 8
    return words.astype(np.uint32).view(np.float32)


def embedded(page):
    (text,) = re.findall(r'<script type="application/json" id="runs">(.*?)</script>', page)
    return json.loads(text)


@given(st.lists(st.floats(-1e30, 1e30).filter(lambda v: v == 0 or abs(v) > 1e-30), min_size=1))
def test_values_in_a_page_have_five_digits(values):
    values = np.array(values)
    np.testing.assert_allclose(unpacked(packed(values)), values, rtol=2.0**-16)
    np.testing.assert_array_equal(unpacked(packed(values)), rounded(values))
    assert np.isnan(unpacked(packed(np.array([np.nan])))[0])


def test_the_page_has_the_values_of_all_runs(made, small):
    table = embedded(made.page)
    assert (table["runs"], table["count"]) == (None, small.runs)
    values = unpacked(table["values"]).reshape(len(table["columns"]), -1)
    for column, own in zip(table["columns"], values, strict=True):
        exact = made.columns[column["name"]]
        assert column["unit"] != "rad/s"
        exact = np.degrees(exact) if column["unit"].startswith("deg") else exact
        exact = exact * 30.0 / np.pi if column["unit"] == "rpm" else exact
        assert column["unit"] != "N·m"
        exact = 1e6 * exact if column["unit"] == "µN·m" else exact
        np.testing.assert_allclose(own, exact, rtol=2e-5)


def test_the_page_names_the_folder_as_it_was_given(made, small, tmp_path, monkeypatch):
    shutil.copytree(small.out, tmp_path / "c")
    monkeypatch.chdir(tmp_path)
    for name in ("./c", "c/"):
        gs.report(name, command="x")
        page = (tmp_path / "c" / "report.html").read_text()
        assert page == made.page.replace(str(small.out), name)


def test_a_large_campaign_keeps_its_extreme_runs_in_the_page(scenario, monkeypatch):
    random = np.random.default_rng(1)
    count, names, keys = 5000, ["error_max", "settling"], scenario.dispersed[:2]
    columns = {name: random.normal(size=count) for name in (*names, *keys)}
    columns["settling"][random.random(count) < 0.9] = np.nan
    columns["status"] = np.zeros(count)
    monkeypatch.setattr("gyrostat.reports.run_table.MOST_BYTES", 16 * 300)
    table = run_table(scenario, columns, names, keys)
    assert len(table["runs"]) == 300
    assert table["count"] == count
    kept = set(table["runs"])
    for name in names:
        order = [k for k in np.argsort(columns[name]) if np.isfinite(columns[name][k])]
        assert {*order[:20], *order[-20:]} <= kept
    assert set(range(200)) <= kept
    assert len(table["values"]) == 16 * 300


def test_bars_count_every_run(made, scenario):
    (chart,) = histograms(scenario, made.columns, {"error_max": ["wheel.a.coulomb"]})
    plot = re.search(r'class="plot".*?data-y="(\S+) (\S+)"', chart.svg())
    heights = re.findall(r"M\S+ 1000V(\S+?)H", chart.svg())
    total = sum((1000.0 - float(h)) / 1000.0 * float(plot[2]) for h in heights)
    assert total == pytest.approx(np.sum(np.isfinite(made.columns["error_max"])), abs=0.2)


def test_values_that_differ_in_the_last_digit_have_a_histogram(scenario):
    values = np.full(60, 0.3)
    values[7] = np.nextafter(0.3, 1.0)
    (chart,) = histograms(scenario, {"energy": values}, {"energy": []})
    assert chart.svg().count("1000V") == 1


def test_required_values_are_drawn_where_they_have_a_meaning(made, scenario):
    boresight = {"boresight": [0.0, 1.0, 0.0]}
    required = [
        {"index": "APE", "value": "0.1 deg", "level": 0.9, "name": "whole"},
        {"index": "APE", "value": "0.2 deg", "level": 0.9, "name": "part", "during": "imaging"},
        {"index": "MPE", "value": "0.3 deg", "level": 0.9, "window": "1 s", **boresight},
    ]
    changed = scenario.replace(requirements=required)
    whole, part = (0.1, "whole 0.1 deg"), (0.2, "part 0.2 deg")

    def values(metric, scale=180.0 / np.pi):
        return [(round(scale * v, 12), text) for v, text in required_in(changed, metric)]

    assert values("error_p99.7") == values("error_max") == [whole]
    assert values("imaging.error_p50") == values("imaging.error_end") == [part]
    assert values("turning.error_max") == values("error_rms") == values("settling") == []
    assert values("requirement.mpe", 1.0) == [(0.1, "allowed 10 %")]
    assert made.page.count('<path class="required"') > 5


def test_drivers_have_rank_correlations_and_shares_of_the_variance(made):
    metric = made.content["metrics"]["torque_rms"]
    assert metric["effects"]["runs_without_values"] == 1
    joint = {
        "keys": ["a", "b"],
        "first": {"value": 0.7, "low": 0.6, "high": 0.8},
        "total": {"value": 0.72, "low": 0.61, "high": 0.83},
    }
    small = {**joint, "keys": ["c"], "total": {"value": 0.002, "low": 0.001, "high": 0.003}}
    drivers = [
        {"key": key, "rank_correlation": rho, "beyond_chance": rho > 0.3}
        for key, rho in (("a", 0.8), ("c", 0.4), ("b", 0.1))
    ]
    effects = {"q2": 0.9, "why": None, "runs_without_values": 0, "inputs": [joint, small]}
    own = {**metric, "drivers": drivers, "effects": effects}
    rows = driver_rows(own)
    assert [row["keys"] for row in rows] == [["a", "b"], ["c"]]
    assert [row["rank_correlation"] for row in rows] == [None, 0.4]
    assert [row["first"] for row in rows] == [joint["first"], small["first"]]
    content = {**made.content, "metrics": {**made.content["metrics"], "torque_rms": own}}
    lines = campaign_lines(SimpleNamespace(name="x"), content)
    assert "  variance of torque_rms: a + b 70 % (72 %); Q² 0.90" in lines


def test_a_summary_begins_with_requirements_or_else_windows(made, scenario):
    begins = [
        "  requirement ",
        f"  {scenario.windows[0].name}.error_p99.7: 50 %",
        "  error_p99.7: ",
    ]
    without = replace(scenario, requirements=())
    for case, begin in zip((scenario, without, replace(without, windows=())), begins, strict=True):
        content = {**made.content, "headline": headline(case)}
        content["requirements"] = content["requirements"][: len(case.requirements)]
        assert campaign_lines(case, content)[1].startswith(begin)


def test_events_of_a_run_are_at_its_own_times(small, scenario):
    with xr.open_dataset(small.store.history(5), engine="h5netcdf") as history:
        error = run_charts(scenario, {"event.loss.time": 6.123}, history)[0].svg()
    assert 'data-x="6.123"' in error
    assert 'data-x="18"' in error
    assert 'data-x="8"' not in error


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (-3e-7, 9e-7), (99990.0, 100020.0)])
def test_ticks_are_round_and_within_the_axis(low, high):
    ticks = Axis(low, high, "").ticks()
    assert 3 <= len(ticks) <= 12
    assert low - 1e-12 <= ticks[0] <= ticks[-1] <= high * (1.0 + 1e-12)
    assert all(f"{tick:.9g}" == f"{float(f'{tick:.6g}'):.9g}" for tick in ticks)
    powers = Axis(1e-5, 20.0, "", is_log=True).ticks()
    np.testing.assert_allclose(powers, 10.0 ** np.arange(-5, 2))


def test_units_get_prefixes():
    assert scaled_unit(4.8e-5, "N·m") == (pytest.approx(1e6), "µN·m")
    assert scaled_unit(4.8e-5, "1") == (1.0, "1")
    assert scaled_unit(0.0, "J") == (1.0, "J")
    for unit in ("kg·m²", "m²", "1/s", "√s", "N²·m", "(N·m)²", "rpm", "°C", "%"):
        assert scaled_unit(3e-6, unit) == (1.0, unit)


@pytest.mark.parametrize("name", ["<script>alert(1)</script>", '"&', "$x$", "☃"])
def test_names_are_text_in_a_chart(name):
    chart = Chart(name, Axis(0.0, 1.0, name), axis_of(np.array([np.nan]), name))
    chart.line(np.array([0.0, 1.0]), np.array([0.0, np.nan]), name)
    chart.level(0.5, name, "required")
    text = chart.svg()
    assert html.escape(name, quote=False).replace('"', "&#34;") in text
    assert "<script" not in text


def test_nothing_is_fetched_and_the_page_is_small(made):
    assert not re.findall(r"""(?:src|href)=["']?(?:http|//)|url\(|@import|fetch\(""", made.page)
    assert len(made.page) < 1_000_000


def test_a_drag_over_bars_lists_the_runs_behind_them(made, address, browser):
    browser.open(address)
    place = json.loads(
        browser.ask("""(() => { const svg = document.querySelector("[data-metric='torque_rms']");
            const plot = svg.querySelector(".plot"); svg.scrollIntoView();
            const r = plot.getBoundingClientRect(), {bins, scale} = svg.dataset;
            return JSON.stringify([r.left, r.top, r.width, r.height, ...bins.split(" "),
                ...plot.dataset.x.split(" "), scale]) })()""")
    )
    left, top, wide, high, first, last, count, low, end, scale = map(float, place)
    step = (last - first) / count
    at = [left + wide * (first + k * step - low) / (end - low) for k in (4.5, count - 0.5)]
    browser.drag((at[0], top + high / 2), (at[1], top + high / 2))
    runs = json.loads(
        browser.ask("""JSON.stringify([...document.querySelectorAll("#selected tr")].slice(1)
            .map(row => [...row.cells].slice(0, 3).map(cell => cell.textContent)))""")
    )
    torque = 1e6 * made.columns["torque_rms"]  # µN·m
    expected = np.flatnonzero(scale * torque >= first + 4.0 * step)
    assert 5 < len(expected) < 95
    assert {int(run) for run, *_ in runs} == set(expected.tolist())
    values = [float(value) for *_, value in runs]
    assert values == sorted(values, reverse=True)
    np.testing.assert_allclose(values, torque[[int(run) for run, *_ in runs]], rtol=1e-3)
    told = browser.ask("document.querySelector('#selected p').textContent")
    assert browser.ask("document.querySelectorAll('.picked:not([d=\"\"])').length") > 10
    assert told.startswith(f"{len(expected)} of 100 runs: torque_rms from ")
    commands = [replay for _, replay, _ in runs if replay != "open"]
    assert all(command.startswith("gyrostat replay ") for command in commands)
    # the same runs are marked in the other histograms; Escape ends the selection
    marked = "document.querySelectorAll('.chosen:not([d=\"\"])').length"
    assert browser.ask(marked) > 10
    browser.call("Input.dispatchKeyEvent", type="keyDown", key="Escape")
    assert browser.ask("document.getElementById('selected').hidden") is True
    assert browser.ask(marked) == 0


def test_a_kept_run_opens_with_one_click(made, address, browser):
    assert [each["kept"] for each in made.content["worst"]].count(True) == 1
    browser.open(address)
    run = next(each["run"] for each in made.content["worst"] if each["kept"])
    opened = f"document.getElementById('run-{run}').checkVisibility()"
    assert browser.ask(opened) is False
    browser.ask(f"document.querySelector('a[href=\"#run-{run}\"]').click()")
    browser.ask("new Promise(done => setTimeout(done, 100))")
    assert browser.ask(opened) is True
    assert browser.ask(f"document.querySelectorAll('#run-{run} .chart .plot').length") == 4


def test_curves_are_zoomed_together_and_read_by_a_cursor(made, address, browser):
    browser.open(address)
    plots = "[...document.querySelectorAll('[data-group=time] .plot')]"
    left, top, wide, high = json.loads(
        browser.ask(f"""(() => {{ const plot = {plots}[0]; plot.scrollIntoView();
            const r = plot.getBoundingClientRect();
            return JSON.stringify([r.left, r.top, r.width, r.height]) }})()""")
    )
    middle = top + high / 2
    browser.drag((left + 0.25 * wide, middle), (left + 0.75 * wide, middle))
    views = json.loads(browser.ask(f"JSON.stringify({plots}.map(p => p.getAttribute('viewBox')))"))
    assert len(views) > 2
    for view in views:
        np.testing.assert_allclose(list(map(float, view.split())), [250, 0, 500, 1000], atol=3)
    first, last = map(float, browser.ask(f"{plots}[0].dataset.x").split())
    ticks = json.loads(
        browser.ask("""JSON.stringify([...document.querySelector('[data-group=time]')
            .querySelectorAll('.axes .x')].map(text => +text.textContent))""")
    )
    quarter = 0.25 * (last - first)
    assert len(ticks) > 2
    assert first + quarter - 0.1 <= min(ticks) < max(ticks) <= last - quarter + 0.1
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=left + wide / 2, y=middle)
    told = browser.ask("document.querySelector('output.told').textContent")
    time, median, _, largest = map(float, re.findall(r"(?<= )?-?\d+\.?\d*(?= s:|,|$)", told))
    assert time == pytest.approx((first + last) / 2, abs=0.2)
    assert 0.0 < median < largest
    for kind in ("Pressed", "Released", "Pressed", "Released"):
        own = {"x": left + 9, "y": middle, "button": "left", "clickCount": 2}
        browser.call("Input.dispatchMouseEvent", type=f"mouse{kind}", **own)
    assert browser.ask(f"{plots}[1].getAttribute('viewBox')") == "0 0 1000 1000"


def test_the_page_is_complete_without_scripts_and_on_paper(made, address, browser):
    browser.call("Emulation.setScriptExecutionDisabled", value=True)
    browser.open(address)
    shown = "document.querySelectorAll('.plot path[d]:not([d=\"\"])').length"
    assert browser.ask(shown) > 50
    assert browser.ask("getComputedStyle(document.getElementById('selected')).display") == "none"
    dark = [{"name": "prefers-color-scheme", "value": "dark"}]
    colour = "getComputedStyle(document.body).backgroundColor"
    browser.call("Emulation.setEmulatedMedia", features=dark)
    assert browser.ask(colour) == "rgb(21, 24, 28)"
    browser.call("Emulation.setEmulatedMedia", media="print", features=dark)
    assert browser.ask(colour) == "rgb(255, 255, 255)"
    browser.call("Emulation.setEmulatedMedia", media="", features=[])
    browser.call("Emulation.setScriptExecutionDisabled", value=False)


def test_no_page_is_wider_than_its_window(address, browser):
    for width in (400, 900, 1400):
        size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
        browser.call("Emulation.setDeviceMetricsOverride", **size)
        browser.open(address)
        assert browser.ask("document.documentElement.scrollWidth") <= width
