"""A Dask scheduler and workers as processes of their own, each worker with its own folder."""

import os
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from benchmarks.many_machines import address_in

SOURCE = Path(__file__).parents[2] / "src"


class Processes:
    """A scheduler, and workers that share nothing with each other but the address."""

    def __init__(self, folder: Path):
        self.folder, self._stack, self._count = folder, ExitStack(), 0
        file = folder / "scheduler.json"
        options = ("--scheduler-file", str(file), "--port", "0", "--no-dashboard")
        self.scheduler = self._start("dask_scheduler", *options)
        self.address = address_in(file, self.scheduler)

    def _start(self, what, *options, **environment):
        folder = self.folder / f"{self._count}"
        self._count += 1
        folder.mkdir()
        environment = {
            **{name: each for name, each in os.environ.items() if not name.startswith("JAX_")},
            **{"HOME": str(folder), "GYROSTAT_CACHE": str(folder / "cache")},
            **{"PYTHONPATH": str(SOURCE), "OMP_NUM_THREADS": "1"},
            **environment,
        }
        with (folder / "log.txt").open("w") as log:
            command = [sys.executable, "-m", f"distributed.cli.{what}", "--host", "127.0.0.1"]
            process = subprocess.Popen(
                [*command, *options], env=environment, cwd=folder, stdout=log, stderr=log
            )
        self._stack.callback(process.wait)
        self._stack.callback(process.kill)
        return process

    def worker(self, *options, **environment):
        """Start a worker."""
        more = ("--no-nanny", "--nthreads", "1", "--no-dashboard", "--local-directory", "scratch")
        return self._start("dask_worker", self.address, *more, *options, **environment)

    def wait(self):
        """Wait until all workers are registered."""
        for number in range(1, self._count):
            log = self.folder / f"{number}" / "log.txt"
            for _ in range(1200):
                if "Registered to" in log.read_text():
                    break
                time.sleep(0.05)
            else:
                raise AssertionError(log.read_text())

    def close(self):
        """End all processes."""
        self._stack.close()


@contextmanager
def processes(folder: Path):
    """Processes that end with the test; it is skipped without Dask."""
    pytest.importorskip("distributed", reason="distributed is not installed")
    folder.mkdir(exist_ok=True)
    cluster = Processes(folder)
    try:
        yield cluster
    finally:
        cluster.close()
