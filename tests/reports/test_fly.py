"""Page that flies a run again: in a browser, from a file, without a network."""

import json
import re
import time

import numpy as np
import pytest

from gyrostat import verbs
from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.engine import fly, fly_given
from gyrostat.codegen.simd.web import web_compiler
from gyrostat.core.errors import InputError
from gyrostat.reports.campaign_run import run_page
from gyrostat.reports.fly import CLOUD, fly_content
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario_files import read_scenario

SCALE = 1e-10
"""Largest difference from the native engine, in sizes of each metric."""


SCENARIO = """
name = "fly"
[run]
duration = "20 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat_with_tank.toml"
[start]
attitude_error = ["0.2 deg", 0.0, "-0.1 deg"]
wheel_speed = ["30 rpm", "-200 rpm", "200 rpm", "-30 rpm"]
[controller]
kind = "three_axis"
turn_gain = 0.4
[compensator]
kind = "friction_model"
[sensors]
attitude_sigma = "0.003 deg"
rate_sigma = "0.002 deg/s"
[[event]]
name = "loss"
kind = "torque_lost"
wheel = "c"
time = "8 s"
detected_after = "1 s"
[[event]]
name = "gap"
kind = "sensor_dropout"
sensor = "rate"
time = "5 s"
until = "5.5 s"
[metrics]
after = "2 s"
crossing_window = "3 s"
[[dispersion]]
key = "wheel.*.coulomb"
distribution = "log_normal"
sigma = "30 %"
[[dispersion]]
key = "event.loss.time"
distribution = "uniform"
low = "6 s"
high = "10 s"
[[metrics.window]]
name = "late"
event = "loss"
from = "3 s"
until = "9.5 s"
exposure = "1.5 s"
boresight = [0.0, 1.0, 0.0]
[[requirement]]
index = "APE"
level = 0.9
value = "0.2 deg"
"""
TANK = """
[[slosh]]
name = "tank"
mass = "100 g"
frequency = "0.5 Hz"
damping = 0.05
position = [0.0, 0.0, "5 cm"]
direction = [1.0, 0.0, 0.0]
"""


@pytest.fixture(scope="module")
def scenario(folder):
    spacecraft = (folder / "cubesat.toml").read_text()
    spacecraft = spacecraft.replace("inertia = [0.06", 'mass = "8 kg"\ninertia = [0.06', 1)
    (folder / "cubesat_with_tank.toml").write_text(spacecraft + TANK)
    path = folder / "fly.toml"
    path.write_text(SCENARIO)
    return read_scenario(path)


@pytest.fixture(scope="module")
def flown(scenario):
    return fly(scenario, 3, None, keep=[0], engine="native")


@pytest.fixture(scope="module")
def page(scenario, flown, tmp_path_factory):
    """Page of the nominal run and of run 5."""
    if web_compiler() is None:
        pytest.skip("neither zig (ziglang) nor clang with wasi-libc and lld")
    values = {name: column[0] for name, column in flown.columns.items()}
    history = flown.histories.of_run(0).arrays()
    runs = {"nominal": (0, None), "run 5": (5, draw(scenario, 3, [5])[0][0])}
    content = fly_content(scenario, 3, runs, print)
    path = tmp_path_factory.mktemp("page") / "run.html"
    path.write_text(run_page(scenario, values, history, "small", "x", content))
    return path


@pytest.fixture(autouse=True, scope="module")
def no_network(chromium):
    chromium.call("Network.enable")
    offline = {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0}
    chromium.call("Network.emulateNetworkConditions", **offline)


def show(browser, page, fragment=""):
    """Open the page anew and wait for its first picture."""
    browser.open("about:blank")
    browser.open(page.as_uri() + fragment)
    return flight(browser, 0)


def flight(browser, before):
    """Wait for a picture after a number of them; returns what was flown."""
    panel = "document.querySelector('.fly')"
    for _ in range(600):
        if browser.ask(f"{panel}.dataset.state") == "failed":
            pytest.fail(browser.ask("document.querySelector('.fault').textContent"))
        if int(browser.ask(f"{panel}.dataset.picture")) > before:
            text = browser.ask(
                f"JSON.stringify({panel}.flown, (k, v) => Number.isNaN(v) ? 'NaN' : v)"
            )
            return json.loads(text)
        time.sleep(0.05)
    return pytest.fail("no picture")


def pictures(browser):
    return int(browser.ask("document.querySelector('.fly').dataset.picture"))


def move(browser, key, value):
    """Move a slider to a place between 0 and 1000; returns what was flown."""
    count = pictures(browser)
    slider = f"document.querySelector('.slider[data-key=\"{key}\"] input[type=range]')"
    browser.ask(f"({slider}.value = {value}, {slider}.oninput(), {slider}.onchange(), 0)")
    return flight(browser, count)


def same(scenario, results, columns, row=0):
    """Compare results of the page, status and end first, with columns of the native engine."""
    names = ["status", "ended", *metrics_of(scenario)]
    pairs = [
        (float(mine), float(columns[name][row]))
        for name, mine in zip(names, results, strict=True)
        if not name.startswith("requirement.")  # needs all errors; the page says so
    ]
    mine, theirs = np.transpose(pairs)
    np.testing.assert_array_equal(np.isnan(mine), np.isnan(theirs))
    np.testing.assert_allclose(mine, theirs, rtol=SCALE, atol=1e-15)


def test_the_page_flies_what_the_native_engine_flies(scenario, flown, browser, page):
    same(scenario, show(browser, page)["results"], flown.columns)
    policy = browser.ask("document.querySelector('meta[http-equiv]').content")
    assert "connect-src 'none'" in policy
    assert "unsafe-inline" not in policy
    assert re.findall(r"https?://[\w.]+", page.read_text()) == ["http://www.w3.org"] * 2


def test_a_moved_slider_gives_what_the_scenario_gives_with_this_number(scenario, browser, page):
    show(browser, page)
    for key in ("controller.turn_gain", "event.loss.time", "start.attitude_error.x"):
        result = move(browser, key, 700)
        value = float(dict(moved(browser))[key])
        assert value != scenario.values[key]
        changed = scenario.replace(**{key: value})
        same(changed, result["results"], fly(changed, 3, None, engine="native").columns)
        browser.ask("(document.querySelector('.reset').onclick(), 0)")


def test_values_on_which_the_design_depends_are_marked(page):
    rows = re.findall(r'data-key="([\w.]+)".*\n<span class="name">.*?</span>', page.read_text())
    marked = re.findall(r'data-key="([\w.]+)".*\n<span class="name">[^<]*<sup', page.read_text())
    assert {"controller.turn_gain", "event.loss.time", "wheel.a.speed"} <= {*rows}
    assert {"wheel.a.inertia", "wheel.b.torque_limit", "body.inertia.xx"} <= {*marked}
    assert not {"controller.turn_gain", "event.loss.time", "wheel.a.speed"} & {*marked}


def moved(browser):
    """Keys and values of the address."""
    from urllib.parse import parse_qsl

    return parse_qsl(browser.ask("location.hash").removeprefix("#"))


def test_the_file_of_a_run_is_flown_by_simulate(scenario, browser, page, tmp_path):
    key = scenario.dispersed[0]
    address = f"#run=run+5&{key}={1.1 * scenario.values[key]!r}&event.loss.time=7.5"
    result = show(browser, page, address)
    path = tmp_path / "run.json"
    path.write_text(browser.ask("gyrostatRunFile()"))
    again = verbs.simulate(path, engine="native")
    columns = {name: [again.attrs[name]] for name in ("ended", *metrics_of(scenario))}
    same(scenario, result["results"], {**columns, "status": [int(again.status)]})
    content = json.loads(path.read_text())
    assert (content["values"]["event.loss.time"], content["run"]) == (7.5, 5)
    for name, value, message in (
        ("values", {"event.loss.time": "soon"}, r"values.event.loss.time: found 'soon', expected"),
        ("values", {"no.key": 1.0}, r"values.no.key: found no such key"),
        ("run", -1, "and run -1, expected whole numbers"),
        ("gyrostat", "fit", "expected the file of a run"),
    ):
        path.write_text(json.dumps({**content, name: value}))
        with pytest.raises(InputError, match=message):
            verbs.simulate(path)


REFUSED = [
    ("wheel.a.inertia", "-1", "expected above 0"),
    ("wheel.a.torque_limit", "0", "expected above 0"),
    ("body.inertia.xx", "10", "found that of no body"),
    ("wheel.a.speed", "5e4", "beyond its momentum limit"),
    ("event.loss.time", "1000", "before the end of the run, 20 s"),
    (
        "event.loss.time",
        "11",
        "metrics.window[late].until: found 9.5 s after 11 s, expected at most",
    ),
    ("event.gap.until", "3", "found 3 s, expected a time after its start, 5 s"),
]
"""Key, typed value, and what the page says."""


def test_a_value_that_simulate_refuses_is_not_flown(scenario, browser, page, tmp_path):
    first = show(browser, page)
    content = json.loads(browser.ask("gyrostatRunFile()"))
    path = tmp_path / "run.json"
    for key, value, expected in REFUSED:
        label = f"document.querySelector('.slider[data-key=\"{key}\"]')"
        box = f"{label}.querySelector('[type=number]')"
        browser.ask(f"({box}.value = '{value}', {box}.onchange(), 0)")
        assert expected in fault(browser)
        assert float(browser.ask(f"{box}.value")) != float(value)
        assert browser.ask(f"{label}.nextElementSibling.className") == "invalid fault"
        assert key not in dict(moved(browser))
        si = float(value) / float(browser.ask(f"{label}.dataset.factor"))
        path.write_text(json.dumps({**content, "values": {**content["values"], key: si}}))
        with pytest.raises(InputError):
            verbs.simulate(path)
        browser.ask("(document.querySelector('.fault').textContent = '', 0)")
    assert pictures(browser) == 1
    assert show(browser, page, "#event.gap.until=3")["results"] == first["results"]
    assert "expected a time after its start" in fault(browser)


def test_direction_that_is_dragged_to_zero_is_refused_as_by_simulate(browser, page, tmp_path):
    show(browser, page)
    key = "slosh.tank.direction.x"
    slider = f"document.querySelector('.slider[data-key=\"{key}\"] input[type=range]')"
    left, right, height = browser.ask(
        f"""(() => {{ {slider}.closest('details').open = true;
        {slider}.scrollIntoView({{ block: 'center' }});
        const box = {slider}.getBoundingClientRect();
        return [box.left, box.right, (box.top + box.bottom) / 2]; }})()"""
    )
    browser.drag(((left + right) / 2, height), (left - 10, height))
    message = "slosh.tank.direction: found no direction, expected a vector"
    assert message in fault(browser)
    path = tmp_path / "run.json"
    path.write_text(browser.ask("gyrostatRunFile()"))
    content = json.loads(path.read_text())
    assert content["values"].get(key, 1.0) == pytest.approx(1.0, abs=0.05)  # put back
    path.write_text(json.dumps({**content, "values": {**content["values"], key: 0.0}}))
    with pytest.raises(InputError, match=message):
        verbs.simulate(path)
    count = pictures(browser)
    move(browser, "slosh.tank.direction.z", 700)  # another component is the direction now
    browser.ask(f"({slider}.value = 0, {slider}.oninput(), 0)")
    assert all(np.isfinite(flight(browser, count + 1)["results"][:2]))
    assert json.loads(browser.ask("gyrostatRunFile()"))["values"][key] == 0.0


def fault(browser):
    """Wait for the line with which the page refuses a value."""
    for _ in range(200):
        text = browser.ask("document.querySelector('.fault').textContent")
        if text:
            assert not browser.ask("document.querySelector('.fault').hidden")
            return text
        time.sleep(0.02)
    return pytest.fail("nothing was refused")


WORKERS_THAT_FAIL = """
(() => { const Real = Worker; let count = 0;
window.Worker = class { constructor() {
  const good = document.getElementById('fly-worker').textContent;
  const text = count++ < 1 ? "throw new Error('no start')" : `${good}
    { const { fly } = Flight.prototype; let flights = 0;
      Flight.prototype.fly = function (...values) {
        if (++flights > 2) throw new Error("no memory");
        return fly.apply(this, values);
      }; }`;
  return new Real(URL.createObjectURL(new Blob([text])));
} } })()
"""
"""The first worker does not start; the others throw from their third flight on."""


def test_page_says_which_worker_fails_and_flies_again(scenario, flown, browser, page):
    added = browser.call("Page.addScriptToEvaluateOnNewDocument", source=WORKERS_THAT_FAIL)
    panel, box = "document.querySelector('.fly')", "document.querySelector('.fly input.cloud')"
    key = "controller.turn_gain"
    slider = f"document.querySelector('.slider[data-key=\"{key}\"] input[type=range]')"
    browser.open(page.as_uri())
    browser.call("Page.removeScriptToEvaluateOnNewDocument", **added)
    assert "no start" in fault(browser)
    browser.ask(f"({panel}.querySelector('.reset').onclick(), 0)")
    same(scenario, flight(browser, 0)["results"], flown.columns)
    assert browser.ask("document.querySelector('.fault').hidden")
    browser.ask(f"({slider}.value = 700, {slider}.oninput(), 0)")
    assert "no memory" in fault(browser)
    assert key not in dict(moved(browser))  # the values are again those of the charts
    assert browser.ask(f"{panel}.dataset.state") == "failed"
    result = move(browser, key, 600)
    changed = scenario.replace(**{key: float(dict(moved(browser))[key])})
    same(changed, result["results"], fly(changed, 3, None, engine="native").columns)
    browser.ask(f"({box}.checked = true, {box}.onchange(), 0)")
    assert "no memory" in fault(browser)


WORKER_THAT_HANGS = """
(() => { const Real = Worker, wait = setTimeout; let count = 0; window.hurry = 1;
window.setTimeout = (then, ms) => wait(then, ms / window.hurry);
window.Worker = class { constructor(address) {
  if (count++) return new Real(address);
  const good = document.getElementById('fly-worker').textContent;
  const text = `${good}
    { const { fly } = Flight.prototype; let flights = 0;
      Flight.prototype.fly = function (...values) {
        while (flights > 1);
        ++flights;
        return fly.apply(this, values);
      }; }`;
  return new Real(URL.createObjectURL(new Blob([text])));
} } })()
"""
"""The first worker never ends its third flight; the page waits `hurry` times shorter."""


def test_page_replaces_a_worker_that_never_answers(scenario, browser, page):
    added = browser.call("Page.addScriptToEvaluateOnNewDocument", source=WORKER_THAT_HANGS)
    key = "controller.turn_gain"
    slider = f"document.querySelector('.slider[data-key=\"{key}\"] input[type=range]')"
    browser.open(page.as_uri())
    browser.call("Page.removeScriptToEvaluateOnNewDocument", **added)
    flight(browser, 0)
    browser.ask("hurry = 100")
    browser.ask(f"({slider}.value = 700, {slider}.oninput(), 0)")
    assert "its worker gave no answer in 30 s. Move a slider" in fault(browser)
    assert key not in dict(moved(browser))
    browser.ask("hurry = 1")
    result = move(browser, key, 600)
    changed = scenario.replace(**{key: float(dict(moved(browser))[key])})
    same(changed, result["results"], fly(changed, 3, None, engine="native").columns)
    assert browser.ask("document.querySelector('.fault').hidden")


def test_the_cloud_is_the_first_runs_of_the_campaign(scenario, browser, page):
    show(browser, page)
    count = pictures(browser)
    box = "document.querySelector('.fly input.cloud')"
    browser.ask(f"({box}.checked = true, {box}.onchange(), 0)")
    cloud = flight(browser, count)["cloud"]
    values, keys = draw(scenario, 3, np.arange(CLOUD))
    expected = fly_given(scenario, np.arange(CLOUD), values, keys).columns
    assert len(cloud) == CLOUD
    for row in range(CLOUD):
        same(scenario, cloud[row], expected, row)


def test_without_a_compiler_the_page_says_what_to_install(scenario, flown, monkeypatch):
    from gyrostat.codegen.simd import web

    monkeypatch.setattr(web, "web_compiler", lambda: None)
    values = {name: column[0] for name, column in flown.columns.items()}
    history, lines = flown.histories.of_run(0).arrays(), []
    content = fly_content(scenario, 3, {"nominal": (0, None)}, lines.append)
    text = run_page(scenario, values, history, "small", "x", content)
    assert "ziglang" in lines[0]
    assert "ziglang" in text
    assert "fly-module" not in text
