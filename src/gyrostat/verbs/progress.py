"""Progress of many runs in a script or notebook: a line in a terminal, a bar in a notebook."""

import sys
import time
from collections.abc import Callable

Update = Callable[[int, int], None]
"""Function of the number of runs done and the total number."""
PAUSE = 0.2
"""Least time between two updates, s."""
CELLS = 24
"""Width of the bar in a terminal, letters."""


def shown(on_progress: Update | None) -> Update | None:
    """Function that shows progress: the user's, a bar, or None where nobody would see one.

    Args:
        on_progress: The user's function, or None.
    """
    if on_progress is not None:
        return on_progress
    write = _in_notebook() or (_in_terminal if sys.stderr.isatty() else None)
    return None if write is None else _Bar(write)


class Pace:
    """Runs per second since the first update."""

    def __init__(self):
        self._start: tuple[float, int] | None = None

    def __call__(self, done: int, now: float) -> float:
        """Rate at a time of `time.monotonic`, s."""
        self._start = self._start or (now, done)
        return (done - self._start[1]) / max(now - self._start[0], 1e-9)


class _Bar:
    """Counts, rate and time left, written at most every `PAUSE`."""

    def __init__(self, write: Callable[[int, int, str], None]):
        self._write, self._pace, self._last = write, Pace(), 0.0

    def __call__(self, done: int, total: int) -> None:
        now = time.monotonic()
        rate = self._pace(done, now)
        if now - self._last < PAUSE and done < total:
            return
        self._last = now
        left = f", {(total - done) / rate:.0f} s left" if rate > 0.0 and done < total else ""
        self._write(done, total, f"{done} of {total} runs, {rate:.1f} per second{left}")


def _in_terminal(done: int, total: int, text: str) -> None:
    bar = "#" * (CELLS * done // max(total, 1))
    end = "\n" if done >= total else ""
    sys.stderr.write(f"\r[{bar:<{CELLS}}] {text}\x1b[K{end}")
    sys.stderr.flush()


def _in_notebook() -> Callable[[int, int, str], None] | None:
    """Function that shows a bar in the output of a cell; None outside of a notebook."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    if shell is None or not hasattr(shell, "kernel"):
        return None
    from IPython.display import HTML, display

    handle = display(HTML(""), display_id=True)
    assert handle is not None  # of a display with an id

    def write(done: int, total: int, text: str) -> None:
        handle.update(HTML(f'<progress value="{done}" max="{total}"></progress> {text}'))

    return write
