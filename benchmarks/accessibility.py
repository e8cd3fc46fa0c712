"""Accessibility of pages in Chromium, by the rules of axe-core.

    npm pack axe-core && tar xzf axe-core-*.tgz
    python benchmarks/accessibility.py package/axe.min.js PAGE.html ...

Each page is opened at 390 and 1200 pixels, in light and dark. The findings are printed; the exit
code is 1 if one is serious or critical.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from browser import Browser

FAULTS = ("serious", "critical")
RUN = """axe.run(document, {resultTypes: ["violations"]}).then(found => found.violations.map(
each => [each.impact, each.id, each.nodes.length, each.nodes[0].html.slice(0, 100)]))"""


def findings(browser, rules, page, width, scheme):
    """Impact, rule, number of elements and the first of them, of each finding."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.call("Emulation.setDeviceMetricsOverride", **size)
    emulated = [{"name": "prefers-color-scheme", "value": scheme}]
    browser.call("Emulation.setEmulatedMedia", features=emulated)
    browser.open(page.resolve().as_uri())
    browser.ask(f"{rules};0")
    return browser.ask(RUN)


def main(rules, *pages):
    """Print the findings; returns the exit code."""
    text, faults = Path(rules).read_text(encoding="utf-8"), 0
    with TemporaryDirectory() as profile, Browser(profile) as browser:
        for page in map(Path, pages):
            for width in (390, 1200):
                for scheme in ("light", "dark"):
                    every = findings(browser, text, page, width, scheme)
                    faults += sum(impact in FAULTS for impact, *_ in every)
                    print(page, width, scheme, *(every or ["no finding"]), sep="\n  ")
    print(f"{faults} serious or critical findings in {len(pages)} pages")
    return min(faults, 1)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
