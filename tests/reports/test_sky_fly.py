"""Sky map on which target and momentum are dragged: in a browser, from a file."""

import json
import os
import re
import shlex
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.codegen.simd.web import web_compiler
from gyrostat.core.errors import InputError
from gyrostat.failures import holdable, holdable_sky
from gyrostat.failures.attitudes import matrix_of

SPACECRAFT = Path(__file__).parents[2] / "examples" / "three_wheels.toml"
QUESTION = {"failed": {"x": 0.28}, "boresight": (0.6, 0.0, 0.8), "towards": (0.9, -0.2, 0.1)}
MOMENTUM = (0.46, -0.04, 0.82)
LAST_WHEEL = "z'down';$HOME*"
PANEL = "document.querySelector('.skyfly')"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    if web_compiler() is None:
        pytest.skip("neither zig (ziglang) nor clang with wasi-libc and lld")
    out = tmp_path_factory.mktemp('it\'s a  "page" of $HOME')
    spacecraft = out / "three & wheels.toml"
    spacecraft.write_text(SPACECRAFT.read_text().replace('"z"', f'"{LAST_WHEEL}"'))
    gs.feasible(spacecraft, MOMENTUM, out / "feasible", fly=True, **QUESTION)
    return out / "feasible" / "report.html"


def answer(browser):
    """What the page shows, when it is ready."""
    for _ in range(300):
        if browser.ask(f"{PANEL}?.dataset.state") == "ready":
            return json.loads(browser.ask(f"JSON.stringify({PANEL}.answer)"))
        time.sleep(0.02)
    return pytest.fail(str(browser.ask("document.querySelector('.fault')?.textContent")))


def expected(shown):
    """Answer of `gyrostat feasible` to what the page shows."""
    file = gs.read_spacecraft(SPACECRAFT)
    failed = {k: [0.28, 0.0, 0.0][k] for k in range(3) if shown["failed"] >> k & 1}
    aim = QUESTION["boresight"], shown["towards"]
    return holdable(file.spacecraft, shown["momentum"], failed=failed, boresight=aim)


def same(shown):
    found = expected(shown)
    assert shown["reason"] == found.reason
    assert shown["fraction"] == pytest.approx(found.sky.fraction, abs=1e-12)
    if found.reason is None:
        assert shown["held"] == found.holdable
        np.testing.assert_allclose(shown["away"], found.angle, atol=1e-9)
        np.testing.assert_allclose(shown["direction"], found.direction, atol=1e-9)
    if not found.holdable:
        np.testing.assert_allclose(shown["rate"], found.at_target.rate, rtol=1e-9)
        np.testing.assert_allclose(shown["excess"], found.at_target.excess, rtol=1e-9)
        if found.reason is None:
            np.testing.assert_allclose(shown["attitude"], found.attitude, atol=1e-9)
    return found


def drag(browser, start, end):
    """Press on one place of the map, move to another one and let go; both in its own pixels."""
    browser.ask(
        f"""(() => {{ const svg = document.querySelector('.skymap svg'), m = svg.getScreenCTM();
        const send = (type, [x, y]) => {{ const p = new DOMPoint(x, y).matrixTransform(m);
          const at = {{ pointerId: 1, clientX: p.x, clientY: p.y }};
          svg.dispatchEvent(new PointerEvent(type, at)); }};
        svg.setPointerCapture = () => 0;
        send('pointerdown', {list(start)}); send('pointermove', {list(end)});
        send('pointerup', {list(end)});
        return 0; }})()"""
    )


def place(browser, mark):
    """Place of a mark on the map, its own pixels."""
    text = browser.ask(
        f"document.querySelector('[data-mark=\"{mark}\"]').getAttribute('transform')"
    )
    return [float(number) for number in re.findall(r"-?[\d.]+", text)[:2]]


def test_what_is_dragged_is_answered_as_by_the_command(browser, page):
    browser.open(page.as_uri())
    first = answer(browser)
    assert same(first).holdable
    star, target = place(browser, "total momentum"), place(browser, "target")
    drag(browser, target, [star[0] + 25.0, star[1] + 3.0])  # onto a free place beside the momentum
    near = answer(browser)
    found = same(near)
    assert not found.holdable
    assert near["momentum"] == first["momentum"]
    assert near["towards"] != first["towards"]
    verdict = browser.ask(f"{PANEL}.querySelector('.verdict').textContent")
    assert f"{np.degrees(found.angle):.4g}"[:4] in verdict
    # the attitude puts the boresight there
    attitude = matrix_of(np.array(near["attitude"])) @ QUESTION["boresight"]
    np.testing.assert_allclose(attitude, near["direction"], atol=1e-9)
    drag(browser, star, [380.0, 120.0])
    moved = answer(browser)
    same(moved)
    assert np.linalg.norm(moved["momentum"]) == pytest.approx(np.linalg.norm(MOMENTUM), rel=1e-12)
    assert moved["momentum"] != near["momentum"]
    for wheels in ("y", LAST_WHEEL, "x", "y"):  # fails, fails, lives again, lives again
        browser.ask(
            f"([...{PANEL}.querySelectorAll('button')]"
            f".find(b => b.textContent === {json.dumps(wheels)}).click(), 0)"
        )
        same(answer(browser))
    state = answer(browser)
    check_command(browser, page, state)
    fragment = browser.ask("location.hash")
    browser.open("about:blank")
    browser.open(page.as_uri() + fragment)
    again = answer(browser)
    assert again["failed"] == state["failed"] == 4
    np.testing.assert_allclose(again["towards"], state["towards"], atol=1e-15)
    policy = browser.ask("document.querySelector('meta[http-equiv]').content")
    assert "connect-src 'none'" in policy


def check_command(browser, page, state):
    """A shell reads the command as it is shown; state: with the last wheel failed."""
    command = browser.ask(f"{PANEL}.querySelector('.command').innerText")
    shell = ["sh", "-c", f"gyrostat() {{ printf '%s\\0' \"$@\"; }}; {command}"]
    words = subprocess.run(shell, capture_output=True, text=True, check=True).stdout.split("\0")
    assert words[:4] == [
        "feasible",
        os.fspath(page.parents[1] / "three & wheels.toml"),
        "--failed",
        f"{LAST_WHEEL}=0",
    ]
    options = dict(word.removeprefix("--").split("=") for word in words[4:7])
    for name, numbers in {**state, "boresight": QUESTION["boresight"]}.items():
        if name in ("momentum", "towards", "boresight"):
            given = np.array(options.pop(name).split(","), float)
            np.testing.assert_allclose(given, numbers, atol=1e-14)
    assert (options, words[7:]) == ({}, ["--out", "feasible", ""])
    assert command == shlex.join(["gyrostat", *words[:-1]])


def test_the_drawn_bands_are_those_of_the_sky_map(browser, page):
    browser.open("about:blank")
    browser.open(page.as_uri())
    shown = answer(browser)
    sky = holdable_sky(
        gs.read_spacecraft(SPACECRAFT).spacecraft,
        shown["momentum"],
        failed={0: 0.28},
        boresight=QUESTION["boresight"],
    )
    area = browser.ask(
        """(() => { const path = new Path2D(document.querySelector('path.bands').getAttribute('d'));
        const pen = document.createElement('canvas').getContext('2d'); let inside = 0, all = 0;
        for (let y = 24.5; y < 370; ++y) for (let x = 34.5; x < 726; x += 2)
          if (((x - 380) / 346) ** 2 + ((y - 197) / 173) ** 2 < 1) {
            ++all; inside += pen.isPointInPath(path, x, y);
          }
        return inside / all; })()"""
    )
    assert area == pytest.approx(sky.fraction, abs=0.01)  # the projection preserves areas


def test_what_cannot_be_dragged_is_refused_in_one_line(tmp_path):
    with pytest.raises(InputError, match="fly: found no boresight with towards"):
        gs.feasible(
            SPACECRAFT, MOMENTUM, tmp_path / "a", failed={"x": 0.28}, target=(1, 0, 0, 0), fly=True
        )
    with pytest.raises(InputError, match="fly: found no momentum"):
        gs.feasible(SPACECRAFT, (0, 0, 0), tmp_path / "b", fly=True, **QUESTION)
    assert not (tmp_path / "a").exists()


def test_without_a_compiler_the_page_says_what_to_install(tmp_path, monkeypatch):
    from gyrostat.codegen.simd import web

    monkeypatch.setattr(web, "web_compiler", lambda: None)
    lines = []
    gs.feasible(SPACECRAFT, MOMENTUM, tmp_path / "c", fly=True, say=lines.append, **QUESTION)
    text = (tmp_path / "c" / "report.html").read_text()
    assert any("ziglang" in line for line in lines)
    assert "ziglang" in text
    assert "sky-module" not in text
