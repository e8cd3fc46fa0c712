"""Progress of many runs on the terminal."""

from collections.abc import Callable

from gyrostat.cli.arguments import say
from gyrostat.verbs.progress import Pace


class Progress:
    """Progress of a campaign (runs done, rate, time left): a bar in a terminal, otherwise lines."""

    def __enter__(self) -> Callable[[int, int], None]:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TaskID,
            TextColumn,
            TimeRemainingColumn,
        )

        console = Console(stderr=True)
        self._bar = Progress(
            TextColumn("runs"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            console=console,
            disable=not console.is_terminal,
        )
        self._bar.__enter__()
        self._task: TaskID | None = None
        self._pace = Pace()
        return self._update

    def _update(self, complete_runs: int, total: int) -> None:
        import time

        now = time.monotonic()
        rate = self._pace(complete_runs, now)
        if self._task is None:
            self._last_report = now
            self._task = self._bar.add_task("runs", total=total, completed=complete_runs, rate="")
            return
        self._bar.update(self._task, completed=complete_runs, rate=f"{rate:.1f} per second")
        if self._bar.disable and (now - self._last_report > 10.0 or complete_runs == total):
            self._last_report = now
            remaining = (total - complete_runs) / max(rate, 1e-9)
            say(f"{complete_runs} of {total} runs, {rate:.1f} per second, {remaining:.0f} s left")

    def __exit__(self, kind: type[BaseException] | None, *details: object) -> None:
        self._bar.__exit__(kind, *details)  # pyright: ignore[reportArgumentType]
        if kind is KeyboardInterrupt:
            say("stopped: completed blocks are kept; run the same command again to resume")
