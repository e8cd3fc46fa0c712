"""Pages that fly: weight, time from a slider to the picture, and difference from the native engine.

For each ready scenario and the mission: the page of `simulate --fly` is opened from a file by
Chromium without a network; a slider is moved 30 times (median, and the least), then 64 runs are
flown. Metrics are compared with those of the native engine, relative to the largest of each: of the
nominal run, and of how many of 64 dispersed runs they are within 1e-10 and 1e-7.

    python benchmarks/fly.py                           # all
    python benchmarks/fly.py examples/scenarios/zero_crossing.toml
"""

import argparse
import importlib.util
import statistics
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.engine import fly, fly_given
from gyrostat.core.errors import InputError
from gyrostat.reports.campaign_run import run_page
from gyrostat.reports.fly import fly_content
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario_files import read_scenario

ROOT = Path(__file__).parents[1]
READY = [
    *("zero_crossing", "wheel_failure", "wheel_failure_found", "nadir_and_slew"),
    *("science_windows", "wheel_array", "stiff_wheel", "own_controller"),
    *("carrara_kuga", "carvalho_fenili", "endo_sekiguchi_nonaka", "moreira_lopes_kuga"),
]
MISSION = ROOT / "examples/missions/earth_observation/mission.toml"
PANEL = "document.querySelector('.fly')"
MOVES = 30


def browser_class():
    """Chromium of the tests."""
    spec = importlib.util.spec_from_file_location("browser", ROOT / "tests/browser.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.Browser


def wait(browser, before):
    """Wait for the next picture."""
    for _ in range(6000):
        if browser.ask(f"{PANEL}.dataset.state") == "failed":
            sys.exit(browser.ask("document.querySelector('.fault').textContent"))
        if int(browser.ask(f"{PANEL}.dataset.picture")) > before:
            return browser.ask(f"JSON.parse(JSON.stringify({PANEL}.flown, {NUMBERS}))")
        time.sleep(0.01)
    return sys.exit("no picture")


HEADER = (
    "| scenario | page, kB | numbers, kB | flight, ms | picture, ms | 64 runs, ms | difference | "
    "runs within 1e-10, 1e-7 |"
)
NUMBERS = "(k, v) => k === 'error' ? 0 : Number.isNaN(v) ? 'NaN' : v"


def differences(scenario, results, columns):
    """Largest difference of a metric of each run, relative to its largest value in all runs."""
    worst = np.zeros(len(results))
    for k, name in enumerate(("status", "ended", *metrics_of(scenario))):
        if name.startswith("requirement."):
            continue
        mine = np.array([float(row[k]) for row in results])
        theirs = np.array(columns[name], float)
        scale = np.nanmax(np.abs(theirs), initial=0.0) or 1.0
        gap = np.abs(mine - theirs) / scale
        gap[np.isnan(mine) & np.isnan(theirs)] = 0.0
        if name == "crossings":
            gap[mine != theirs] = np.inf
        worst = np.maximum(worst, np.where(np.isnan(gap), np.inf, gap))
    return worst


def measured(path, browser, folder):
    """One row of the table."""
    scenario = read_scenario(path)
    nominal = fly(scenario, 0, None, keep=[0], engine="native")
    row = {name: column[0] for name, column in nominal.columns.items()}
    history = nominal.histories.of_run(0).arrays()
    began = time.perf_counter()
    content = fly_content(scenario, 0, {"nominal": (0, None)}, print)
    made = time.perf_counter() - began
    if "lacking" in content:
        return None
    arguments = scenario, row, history, scenario.name, "benchmarks/fly.py"
    text = run_page(*arguments, content)
    weight = len(text.encode()) - len(run_page(*arguments).encode()) - len(content["words"])
    page = folder / "run.html"
    page.write_text(text)
    browser.open("about:blank")
    browser.open(page.as_uri())
    first = wait(browser, 0)
    worst = differences(scenario, [first["results"]], nominal.columns)[0]
    times = []
    for k in range(MOVES):
        slider = f"{PANEL}.querySelectorAll('input[type=range]')[0]"
        browser.ask(f"({slider}.value = {400 + 5 * k}, {slider}.oninput(), 0)")
        flown = wait(browser, k + 1)
        times.append((flown["flight"], flown["picture"]))
    flight, picture = (
        f"{statistics.median(each):.1f} ({min(each):.1f})" for each in zip(*times, strict=True)
    )
    many, alike = float("nan"), "-"
    if scenario.dispersions:
        browser.ask(f"({PANEL}.querySelector('.reset').onclick(), 0)")
        wait(browser, MOVES + 1)
        box = f"{PANEL}.querySelector('input.cloud')"
        browser.ask(f"({box}.checked = true, {box}.onchange(), 0)")
        wait(browser, MOVES + 2)
        browser.ask(f"({box}.onchange(), 0)")  # the second time the workers are there
        answer = wait(browser, MOVES + 3)
        many = answer["many"]
        values, keys = draw(scenario, 0, np.arange(64))
        if not any(key.startswith("orbit.") for key in scenario.dispersed):
            expected = fly_given(scenario, np.arange(64), values, keys).columns
            gaps = differences(scenario, answer["cloud"], expected)
            alike = f"{np.sum(gaps <= 1e-10)}, {np.sum(gaps <= 1e-7)}"
    return weight, len(content["words"]), flight, picture, many, worst, alike, made


def main():
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenarios", nargs="*", type=Path)
    paths = parser.parse_args().scenarios
    paths = paths or [*(ROOT / f"examples/scenarios/{name}.toml" for name in READY), MISSION]
    print(HEADER)
    print("|---" * HEADER.count(" | ") + "|---|")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        (folder / "profile").mkdir()
        with browser_class()(folder / "profile", 1200, 900) as browser:
            browser.call("Network.enable")
            offline = {"offline": True, "latency": 0}
            offline |= {"downloadThroughput": 0, "uploadThroughput": 0}
            browser.call("Network.emulateNetworkConditions", **offline)
            for path in paths:
                try:
                    row = measured(path, browser, folder)
                except InputError as error:
                    print(f"| {path.stem} | {error} | | | | | | |", flush=True)
                    continue
                if row is None:
                    print(f"| {path.stem} | cannot fly | | | | | | |", flush=True)
                    continue
                weight, words, flight, picture, many, worst, alike, made = row
                print(
                    f"| {path.stem} | {weight / 1e3:.0f} | {words / 1e3:.0f} | {flight} | "
                    f"{picture} | {many:.0f} | {worst:.1e} | {alike} |",
                    flush=True,
                )
                print(f"{path.stem}: program made in {made:.1f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
