"""Chromium without a window or a network, driven through its debugging pipe."""

import base64
import json
import os
import shutil
import subprocess

import pytest


class Browser:
    """A page in Chromium; skips the test where it is not installed.

    Args:
        folder: Empty folder for the profile of the browser.
        width: Width of the page, pixels.
        height: Height of the page, pixels.
    """

    def __init__(self, folder, width=900, height=800):
        found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
        if found is None:
            pytest.skip("chromium is not installed")
        (theirs, self._write), (self._read, answers) = os.pipe(), os.pipe()
        # the browser reads commands from descriptor 3 and writes answers to 4
        redirect = f'exec "$0" "$@" 3<&{theirs} 4>&{answers}'
        words = ["--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe"]
        words += [f"--user-data-dir={folder}", f"--window-size={width},{height}", "about:blank"]
        self._process = subprocess.Popen(
            ["bash", "-c", redirect, found, *words],
            pass_fds=(theirs, answers),
            stderr=subprocess.DEVNULL,
        )
        os.close(theirs)
        os.close(answers)
        self._rest, self._number, self._session = b"", 0, None
        self.errors = []
        targets = self.call("Target.getTargets")["targetInfos"]
        page = next(each["targetId"] for each in targets if each["type"] == "page")
        attached = self.call("Target.attachToTarget", targetId=page, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime"):
            self.call(f"{domain}.enable")

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self._process.kill()
        self._process.wait()
        os.close(self._write)
        os.close(self._read)

    def _message(self):
        while b"\0" not in self._rest:
            part = os.read(self._read, 1 << 20)
            assert part, "the browser has ended"
            self._rest += part
        first, _, self._rest = self._rest.partition(b"\0")
        message = json.loads(first)
        if message.get("method") == "Runtime.exceptionThrown":
            details = message["params"]["exceptionDetails"]
            self.errors.append(details.get("exception", details).get("description", str(details)))
        return message

    def call(self, method, **params):
        """Call a method of the DevTools protocol."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": params}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._message()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]

    def open(self, address):
        """Load a page, and wait for its scripts."""
        self.call("Page.navigate", url=address)
        while self._message().get("method") != "Page.loadEventFired":
            pass

    def ask(self, expression):
        """Value of an expression in the page."""
        found = self.call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def drag(self, start, end, *, shift=False):
        """Press the mouse at one place, move it and release it at another, pixels."""
        held = {"modifiers": 8 if shift else 0, "clickCount": 1}
        steps = [("Moved", start), ("Pressed", start), ("Moved", end), ("Released", end)]
        for k, (kind, place) in enumerate(steps):
            own = {"type": f"mouse{kind}", "x": place[0], "y": place[1]}
            button = "left" if k else "none"
            self.call("Input.dispatchMouseEvent", **own, button=button, **held)

    def picture(self, path):
        """Write a picture of what the window shows."""
        path.write_bytes(base64.b64decode(self.call("Page.captureScreenshot")["data"]))
