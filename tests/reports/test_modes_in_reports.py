"""Modes in the reports: rows of a run, and shares of a campaign."""

import re

import numpy as np
import pytest

from gyrostat.reports.mode_chart import mode_chart
from gyrostat.reports.mode_diagram import mode_diagram, modes_content, percent_of
from gyrostat.scenario.timeline import change_names, modes
from gyrostat.scenario_files.scenario_file import read_scenario

NAMES = ["safe", "science", "spare"]


def test_rows_of_modes_have_the_times_of_their_stays():
    """Safe for 3 s, science for 2 s, safe for the other 5 s, at a period of 0.5 s."""
    time = np.arange(21) * 0.5
    mode = np.where((time >= 3.0) & (time < 5.0), 1, 0)
    chart = mode_chart(NAMES, {"time": time, "mode": mode})
    assert chart is not None
    page = str(chart.svg())
    assert re.findall(r"<title>(.*?)</title>", page) == [
        "safe: 8 s",
        "science: 2 s",
        "spare: never",
    ]
    bars = re.findall(r'class="stay \w+" d="(.*?)"', page)
    ends = [re.findall(r"M([\d.]+) [\d.]+H([\d.]+)", bar) for bar in bars]
    assert ends == [[("0.0", "300.0"), ("500.0", "1000.0")], [("300.0", "500.0")], []]
    # the script finds the name of the row under the cursor by the value of the curve
    assert 'data-rows="spare|science|safe"' in page
    (curve,) = re.findall(r'class="line s7" data-name="" d="(.*?)"', page)
    low, high = (float(end) for end in re.search(r'data-y="(\S+) (\S+)"', page).groups())
    heights = [float(y) for y in re.findall(r"[ML][\d.]+ ([\d.]+)", curve)]
    rows = [high - height / 1000.0 * (high - low) for height in heights]
    np.testing.assert_allclose(rows, [2, 2, 1, 1, 2, 2], atol=1e-3)


def test_one_mode_or_none_has_no_chart():
    assert mode_chart(["safe"], {"time": np.arange(3.0), "mode": np.zeros(3)}) is None
    assert mode_chart(NAMES, {"time": np.arange(3.0)}) is None
    assert mode_chart(NAMES, {"time": np.zeros(1), "mode": np.zeros(1)}) is None


@pytest.mark.parametrize(
    ("share", "text"),
    [(0.0, "never"), (1.0, "100 %"), (0.9999, "> 99.9 %"), (0.0012, "0.12 %"), (0.469, "46.9 %")],
)
def test_never_and_always_are_exact(share, text):
    assert percent_of(share) == text


def test_shares_of_a_campaign_are_those_of_its_columns():
    scenario = read_scenario("safe_mode")
    columns = {f"mode.{name}.time": np.zeros(4) for name in modes(scenario.parts)}
    columns |= {f"change.{name}": np.zeros(4) for name in change_names(scenario.parts)}
    columns["mode.safe.time"] = np.array([0.0, 10.0, 20.0, 30.0])
    columns["change.to_safe"] = np.array([0.0, 1.0, 1.0, 4.0])
    columns["change.to_detumble"] = np.array([0.0, np.nan, 2.0, 0.0])
    content = modes_content(scenario, columns)
    assert content is not None
    rows = {row["name"]: row for row in content["modes"]}
    assert rows["safe"] == {"name": "safe", "share": 0.75, "time": [20.0, 11.0, 29.0]}
    assert rows["science"] == {"name": "science", "share": 0.0, "time": [None] * 3}
    changes = {change["name"]: change for change in content["changes"]}
    assert changes["to_safe"]["start"] == ["search_x", "search_y"]
    assert [changes["to_safe"][key] for key in ("share", "mean", "most")] == [0.75, 1.5, 4]
    assert changes["to_detumble"]["share"] == pytest.approx(1.0 / 3.0)
    page = str(mode_diagram(scenario, content))
    titles = re.findall(r"<title>(.*?)</title>", page)
    assert "search_y to safe; to_safe: 75 %" in titles
    assert "safe to search_x; to_search_x_3: never" in titles
    # an arc for each pair of modes, not for each transition
    pairs = {(start, change["to"]) for change in content["changes"] for start in change["start"]}
    assert page.count('class="arc') == len(pairs)
