"""Executors: threads and local processes behind one interface; `cluster` adds those of Dask."""

import atexit
import contextlib
import gc
import multiprocessing
import multiprocessing.spawn
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import resource_tracker
from multiprocessing.connection import wait as wait_for_end
from multiprocessing.context import SpawnContext, SpawnProcess
from queue import SimpleQueue
from typing import Any

from gyrostat.core.errors import InputError

Opener = Callable[[], contextlib.AbstractContextManager[Executor]]
BARREN = 3
"""Number of worker pools that may fail in succession without a result."""
MOST_WORKERS = 1024
"""Largest number of worker processes, which are started together."""
ENDED = 10.0
"""Longest time in which the thread of a pool that failed is waited for, s."""
_STARTING = threading.Lock()


class _Worker(SpawnProcess):
    """Spawned process that does not run the main module of its parent.

    By default a spawned process runs `__main__` again, so that it can receive objects defined
    there. Workers need no such objects, and a script without a main guard, or from standard input,
    would start its campaign in each worker.
    """

    def start(self) -> None:
        """Start the process."""
        spawn: Any = multiprocessing.spawn
        with _STARTING:
            prepare, command_line = spawn.get_preparation_data, spawn.get_command_line

            def without_main(name: str) -> dict[str, Any]:
                data = prepare(name)
                if name == self.name:  # other threads may start other processes meanwhile
                    data = {k: v for k, v in data.items() if not k.startswith("init_main")}
                return data

            def quiet(**options: Any) -> list[str]:
                # a parent that is killed now sends nothing, which would print a traceback
                *before, program, flag = command_line(**options)
                return [*before, f"try:\n  {program}\nexcept EOFError:\n  pass", flag]

            spawn.get_preparation_data, spawn.get_command_line = without_main, quiet
            try:
                super().start()
            finally:
                spawn.get_preparation_data, spawn.get_command_line = prepare, command_line


class _WorkerContext(SpawnContext):
    """Multiprocessing context that starts workers."""

    Process = _Worker  # pyright: ignore[reportAssignmentType]


def _begin_worker() -> None:
    """Initialise a worker: it ignores Ctrl-C and exits when its parent process ends."""
    atexit.register(gc.freeze)  # the interpreter's last scan for garbage takes half a second
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        sentinel = parent.sentinel

        def follow() -> None:
            wait_for_end([sentinel])
            os._exit(1)

        threading.Thread(target=follow, daemon=True).start()


def _start_quiet_tracker() -> None:
    """Start the resource tracker, which frees semaphores after a kill, without its warnings."""
    before = os.environ.get("PYTHONWARNINGS")
    quiet = "ignore:resource_tracker"
    os.environ["PYTHONWARNINGS"] = quiet if before is None else f"{before},{quiet}"
    try:
        resource_tracker.ensure_running()
    finally:
        if before is None:
            del os.environ["PYTHONWARNINGS"]
        else:
            os.environ["PYTHONWARNINGS"] = before


def processes(workers: int) -> Opener:
    """Create an opener of a pool of worker processes.

    Args:
        workers: Number of workers.

    Raises:
        InputError: The number is not between 1 and `MOST_WORKERS`.
    """
    if not 1 <= workers <= MOST_WORKERS:
        raise InputError(f"workers: found {workers}, expected 1 to {MOST_WORKERS}")

    @contextlib.contextmanager
    def open_executor() -> Iterator[Executor]:
        # spawned, not forked: JAX has threads
        _start_quiet_tracker()
        pool = ProcessPoolExecutor(workers, mp_context=_WorkerContext(), initializer=_begin_worker)
        try:
            yield pool
        except BaseException:
            # the results of running jobs are not needed
            for process in list((pool._processes or {}).values()):
                process.terminate()
            # at exit Python wakes each pool's thread, and fails if it is closing its pipe; before
            # 3.11.5 it may wait for ever for a worker that died
            thread: Any = pool._executor_manager_thread
            pool.shutdown(wait=False, cancel_futures=True)
            if thread is not None:
                thread.join(ENDED)
            raise
        pool.shutdown()

    return open_executor


def threads(workers: int) -> Opener:
    """Create an opener of threads in this process, in which compiled C runs in parallel.

    Args:
        workers: Number of threads.
    """

    @contextlib.contextmanager
    def open_executor() -> Iterator[Executor]:
        pool = ThreadPoolExecutor(workers)
        try:
            yield pool
        finally:
            pool.shutdown(cancel_futures=True)

    return open_executor


@contextlib.contextmanager
def kept_open(opener: Opener) -> Iterator[Opener]:
    """Create an opener that gives the same executor again until it fails.

    A new worker imports the package and traces the scenario again, which takes seconds.

    Args:
        opener: Opens an executor.
    """
    stack, pools = contextlib.ExitStack(), []

    @contextlib.contextmanager
    def open_executor() -> Iterator[Executor]:
        nonlocal stack
        if not pools:
            pools.append(stack.enter_context(opener()))
        try:
            yield pools[0]
        except BaseException as error:
            old_stack, stack = stack, contextlib.ExitStack()
            pools.clear()
            old_stack.__exit__(type(error), error, error.__traceback__)
            raise

    try:
        yield open_executor
    except BaseException as error:
        stack.__exit__(type(error), error, error.__traceback__)
        raise
    stack.close()


def carry_out(
    jobs: Iterable[Any],
    work: Callable[[Any], Any],
    opener: Opener,
    take: Callable[[Any, Any], None],
    *,
    window: int,
) -> None:
    """Process every job once.

    If a worker is killed, its pool fails; the jobs in progress are given to a new pool.

    Args:
        jobs: Jobs, any number; each is taken from the iterable when another ends.
        work: Function that is applied to each job in a worker.
        opener: Opens the executor.
        take: Called in this process with each job and its result.
        window: Number of jobs in progress at a time.

    Raises:
        InputError: `BARREN` pools failed in succession without a result.
    """
    upcoming, retries, barren = iter(jobs), deque(), 0
    while True:
        running: dict[Any, Any] = {}
        ended: SimpleQueue[Any] = SimpleQueue()

        def give(
            pool: Executor, running: dict[Any, Any] = running, ended: SimpleQueue[Any] = ended
        ) -> None:
            job = retries.popleft() if retries else next(upcoming, None)
            if job is None:
                return
            try:
                future = pool.submit(work, job)
            except BrokenExecutor:
                retries.append(job)
                raise
            running[future] = job
            # to wait for any of thousands of futures takes a millisecond each time
            future.add_done_callback(ended.put)

        try:
            with opener() as pool:
                for _ in range(window):
                    give(pool)
                while running:
                    future = ended.get()
                    take(running[future], future.result())
                    del running[future]
                    barren = 0
                    give(pool)
            return
        except BrokenExecutor as error:
            retries.extend(running.values())
            barren += 1
            if barren == BARREN:
                raise InputError(
                    f"workers: found {BARREN} worker pools in a row that ended before their first "
                    "result, expected workers that keep running (is there enough memory?)"
                ) from error
