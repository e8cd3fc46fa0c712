"""Every page: its policy, its width on a phone, the size of its letters, and its charts."""

import base64
import hashlib
import re
from importlib.resources import files

import numpy as np
import pytest

from gyrostat.reports.colours import MARK, MODEL
from gyrostat.reports.drawing import panels
from gyrostat.reports.figure_charts import figure_charts
from gyrostat.reports.template import render

READABLE = """(() => {
const root = document.documentElement, small = [];
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
for (let text = walker.nextNode(); text; text = walker.nextNode()) {
  const parent = text.parentElement;
  const drawn = parent.ownerSVGElement ? parent.getScreenCTM() : {a: 1};
  if (!text.data.trim() || parent.matches("script, style") || !parent.checkVisibility()) continue;
  const size = drawn.a * parseFloat(getComputedStyle(parent).fontSize);
  if (size < 11) small.push(`${parent.tagName} ${size.toFixed(1)} ${text.data.trim()}`);
}
const parts = [...document.querySelectorAll(".scroll")].filter(e => e.scrollWidth > e.clientWidth);
const missed = parts.filter(e => e.tabIndex < 0).length;
return [small.slice(0, 3), root.scrollWidth - root.clientWidth, missed];
})()"""
"""Texts below 11 px, what the page is too wide, and scrolling parts that the keyboard misses."""
FORBIDDEN = r"<[a-z][^>]*\s(?:style|on\w+)="
"""Styles and handlers in an element, which a policy with digests blocks."""


@pytest.fixture(scope="module")
def page():
    """A page with a picture of Matplotlib, a wide table and a name that must not be markup."""
    with panels(2, height=4.0, sharex=True) as (figure, (top, bottom)):
        x = np.linspace(0.0, 100.0, 400)
        top.plot(x, np.sin(x / 10.0), color=MODEL, label="model")
        bottom.plot(x, np.exp(-x / 10.0), color=MARK, label="<b>decay</b>")
        bottom.set(xlabel="time (s)", ylabel="error (deg)", yscale="log")
    cells = "".join(f"<td>{'0.00012345' + 20 * '0'} N·m</td>" for _ in range(8))
    table = f'<div class="scroll"><table><tr>{cells}</tr></table></div></main>'
    return render(
        "microvibration.html",
        title="Line of sight",
        command="gyrostat jitter",
        invalid=(),
        lines=["first", "second"],
        figure=figure_charts(figure),
        caption="Caption.",
    ).replace("</main>", table)


def digests(texts):
    every = (base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in texts)
    return {f"'sha256-{each}'" for each in every}


def test_a_policy_names_each_script_and_style_and_allows_no_connection(page):
    (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="(.*?)"', page)
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules["default-src"] == rules["connect-src"] == "'none'"
    scripts, styles = (
        re.findall(rf"<{n}>(.*?)</{n}>", page, re.DOTALL) for n in ("script", "style")
    )
    assert len(scripts) >= 2
    assert digests(scripts) <= {*rules["script-src"].split()}
    assert digests(styles) == {*rules["style-src"].split()}
    assert "@media print" in page
    assert not re.findall(FORBIDDEN, page)
    assert "<b>decay</b>" not in page


def test_no_template_has_styles_or_handlers_in_its_elements():
    for each in files("gyrostat.reports").joinpath("templates").iterdir():
        if each.name.endswith(".html"):
            assert not re.findall(FORBIDDEN, each.read_text(encoding="utf-8")), each.name


@pytest.fixture
def sized(browser):
    """The browser, which has its own size and colours again after the test."""
    browser.call("Emulation.setScrollbarsHidden", hidden=True)
    yield browser
    browser.call("Emulation.setScrollbarsHidden", hidden=False)
    browser.call("Emulation.setEmulatedMedia", features=[])
    browser.call("Emulation.clearDeviceMetricsOverride")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_page_can_be_read_and_used_at_each_width(page, scheme, sized, tmp_path):
    (tmp_path / "page.html").write_text(page, encoding="utf-8")
    emulated = [{"name": "prefers-color-scheme", "value": scheme}]
    sized.call("Emulation.setEmulatedMedia", features=emulated)
    for width in (390, 1200):
        size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
        sized.call("Emulation.setDeviceMetricsOverride", **size)
        sized.open((tmp_path / "page.html").as_uri())
        assert sized.ask(READABLE) == [[], 0, 0], width
        # the main chart is as wide as the page; its letters are not enlarged
        widths = "['.wide', 'main'].map(name => document.querySelector(name).clientWidth)"
        assert len({*sized.ask(widths)}) == 1
        scale = sized.ask("gyrostatCharts[0].svg.getScreenCTM().a")
        assert scale == pytest.approx(1.0 if width > 440 else 358 / 440, abs=0.01)
        # the cursor reads the values of both panels; the second is logarithmic
        sized.ask("gyrostatCharts.forEach(chart => chart.cursor(500))")
        told = sized.ask("[...document.querySelectorAll('.told')].map(e => e.textContent)")
        at, value = map(float, told[0].split(" s: model "))
        assert value == pytest.approx(np.sin(at / 10.0), abs=0.02)
        assert float(told[1].split()[-1]) == pytest.approx(np.exp(-at / 10.0), rel=0.03)
