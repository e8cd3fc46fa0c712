"""Placement of jobs on the workers of a Dask scheduler."""

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor, Future, InvalidStateError
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from typing import Any

from gyrostat.campaigns.cluster_connection import Connection, is_lost
from gyrostat.campaigns.handshake import Answer, Handshake, Outcome, carry_out_greeted, greet
from gyrostat.core.errors import InputError

LOOK = 0.5
"""Time between two looks at the list of workers, s."""
DEPTH = 2
"""Jobs that a worker has for each of its threads: one waits while another is computed."""
LOSSES = 3
"""Number of workers that one job may end before the computation fails."""
PATIENCE = 20.0
"""Time for which a lost worker may be started again if all others are refused, s."""
GONE = 10.0
"""Time without an answer after which the scheduler is lost, s."""
SLOW = 4.0
"""A job that takes this many times the median is given to a second worker that is free."""


@dataclass(eq=False)
class _Task:
    """Job with its future, and the workers that compute it."""

    function: Callable[[Any], Any]
    job: Any
    future: Future = field(default_factory=Future)
    copies: dict[str, Any] = field(default_factory=dict)
    begun: float = 0.0
    losses: int = 0


@dataclass(eq=False)
class _Worker:
    """Worker of the cluster; `tasks` are those that it has."""

    threads: int
    is_accepted: bool = False
    refusal: str = ""
    tasks: set[_Task] = field(default_factory=set)


class ClusterPool(Executor):
    """Executor that gives jobs to the workers of a Dask scheduler which accept a handshake.

    Args:
        connection: Connection to the scheduler.
        asked: Handshake.
        say: Called with a message about each worker that is refused.
    """

    def __init__(self, connection: Connection, asked: Handshake, say: Callable[[str], None]):
        self._connection, self._asked, self._say = connection, asked, say
        self._events: SimpleQueue[tuple[str, Any]] = SimpleQueue()
        self._workers: dict[str, _Worker] = {}
        self._waiting: deque[_Task] = deque()
        self._tasks: set[_Task] = set()
        self._free: deque[str] = deque()  # one entry for each job that a worker can take
        self._durations: deque[float] = deque(maxlen=101)
        self._failure: InputError | None = None
        self._answered = self._useful = time.monotonic()
        self._had_worker, self._has_told = False, False
        self._manager = threading.Thread(target=self._manage, daemon=True)
        self._manager.start()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future:
        """Give a job, the only argument, to a worker that is free.

        Raises:
            InputError: No worker can be used any more.
        """
        if self._failure is not None:
            raise self._failure
        (job,) = args
        task = _Task(fn, job)
        self._events.put(("submit", task))
        return task.future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Stop; results of running jobs are not needed."""
        self._events.put(("stop", None))
        self._manager.join()

    def _manage(self) -> None:
        """Handle events until the end; an error fails all jobs, which would wait for ever."""
        try:
            self._handle_events()
        except Exception as error:
            self._fail(f"--scheduler: found {type(error).__name__} ({error}), expected no error")
        self._connection.cancel([copy for task in self._tasks for copy in task.copies.values()])

    def _handle_events(self) -> None:
        """Handle one event after another, and look at the list of workers in between."""
        looked = 0.0
        handlers = {
            "submit": self._submitted,
            "workers": self._listed,
            "greeted": self._greeted,
            "done": self._done,
        }
        while True:
            with contextlib.suppress(Empty):
                kind, content = self._events.get(timeout=LOOK)
                if kind == "stop":
                    break
                handlers[kind](content)
            if time.monotonic() - looked > LOOK:
                looked = time.monotonic()
                self._connection.ask_for_workers(lambda found: self._events.put(("workers", found)))
                self._judge()
                self._double_slow_tasks()
            self._place()

    def _listed(self, listed: dict[str, int]) -> None:
        self._answered = time.monotonic()
        for address in set(self._workers) - set(listed):
            worker = self._workers.pop(address)
            # those that wait in the worker did not end it
            order = sorted(worker.tasks, key=lambda task: task.begun)
            for place, task in enumerate(order):
                self._lose(task, address, counted=place < worker.threads)
        for address in set(listed) - set(self._workers):
            self._workers[address] = _Worker(max(1, listed[address]))
            self._greet(address, {})
        if not listed and not self._has_told:
            self._has_told = True
            self._say("--scheduler: found no worker, waiting for one")

    def _greet(self, address: str, contents: dict[str, bytes]) -> None:
        copy = self._connection.send(address, greet, self._asked, f"worker {address}", contents)
        self._connection.when_done(
            copy, lambda result: self._events.put(("greeted", (address, *result)))
        )

    def _greeted(self, event: tuple[str, Answer, Exception | None]) -> None:
        address, answer, error = event
        worker = self._workers.get(address)
        if worker is None or (error is not None and is_lost(error)):
            return
        if error is not None:  # whatever a worker without this version of gyrostat raises
            found = " ".join(str(error).split()) or type(error).__name__
            version = self._asked.record["gyrostat"]
            answer = Answer(f"worker {address}: found {found}, expected gyrostat {version}")
        if answer.missing:
            self._greet(address, {each: self._asked.contents[each] for each in answer.missing})
        elif answer.refusal:
            worker.refusal = answer.refusal
            self._say(f"{answer.refusal}: the worker is not used")
        else:
            worker.is_accepted = self._had_worker = True
            self._free.extend([address] * (DEPTH * worker.threads))

    def _judge(self) -> None:
        """Fail if the scheduler is lost or no worker can be used."""
        now = time.monotonic()
        if now - self._answered > GONE or self._connection.is_closed:
            self._fail(
                f"--scheduler: found no answer from {self._connection.address} any more, "
                "expected the scheduler to stay: start one and repeat the command, which goes on "
                "with what is complete"
            )
        all_refused = all(worker.refusal for worker in self._workers.values())
        if not self._workers or not all_refused:
            self._useful = now
        elif not self._had_worker or now - self._useful > PATIENCE:
            self._fail(
                f"--scheduler: found {len(self._workers)} workers, all of them refused, expected "
                "one that gives the same results as this process"
            )

    def _fail(self, message: str) -> None:
        self._failure = InputError(message)
        for task in self._tasks:
            _settle(task, error=self._failure)
        self._tasks.clear()
        self._waiting.clear()

    def _submitted(self, task: _Task) -> None:
        if self._failure is not None:
            _settle(task, error=self._failure)
            return
        self._tasks.add(task)
        self._waiting.append(task)

    def _place(self) -> None:
        """Give waiting jobs to free workers."""
        while self._waiting and self._free:
            address = self._free.popleft()
            worker = self._workers.get(address)
            if worker is None or not worker.is_accepted:
                continue
            task = self._waiting.popleft()
            if task in self._tasks:
                self._start(task, address)
            else:
                self._free.append(address)

    def _start(self, task: _Task, address: str) -> None:
        task.begun = task.begun or time.monotonic()
        identity = self._asked.identity
        copy = self._connection.send(address, carry_out_greeted, identity, task.function, task.job)
        task.copies[address] = copy
        self._workers[address].tasks.add(task)
        self._connection.when_done(
            copy, lambda result: self._events.put(("done", (task, address, copy, *result)))
        )

    def _done(self, event: tuple[_Task, str, Any, Outcome | None, Exception | None]) -> None:
        task, address, copy, outcome, error = event
        if task.copies.get(address) is not copy:
            return
        worker = self._workers.get(address)
        if error is not None and is_lost(error):
            self._lose(task, address)
            return
        self._release(task, address)
        if outcome is not None and not outcome.was_greeted:
            if task in self._tasks and not task.copies:
                self._waiting.appendleft(task)
            if worker is not None and worker.is_accepted:
                worker.is_accepted = False
                self._greet(address, {})
            return
        if task in self._tasks:
            self._tasks.discard(task)
            self._durations.append(time.monotonic() - task.begun)
            _settle(task, None if outcome is None else outcome.result, error)

    def _release(self, task: _Task, address: str) -> None:
        """A worker has finished a job and can take another."""
        task.copies.pop(address, None)
        worker = self._workers.get(address)
        if worker is not None:
            worker.tasks.discard(task)
            if worker.is_accepted:
                self._free.append(address)

    def _lose(self, task: _Task, address: str, *, counted: bool = True) -> None:
        """A worker was lost with a job, which another one repeats."""
        copy = task.copies.get(address)
        self._release(task, address)
        if copy is not None:
            self._connection.cancel([copy])
        if task not in self._tasks:
            return
        task.losses += counted
        if task.losses >= LOSSES:
            self._fail(
                f"--scheduler: found {LOSSES} workers that ended during one job, expected workers "
                "that keep running (is there enough memory?)"
            )
        elif not task.copies:
            self._waiting.appendleft(task)

    def _double_slow_tasks(self) -> None:
        """Give jobs of slow workers to free ones too; the first result counts, all are the same."""
        if self._waiting or not self._free or not self._durations:
            return
        usual = sorted(self._durations)[len(self._durations) // 2]
        now = time.monotonic()
        idle = {a for a in self._free if a in self._workers and not self._workers[a].tasks}
        for task in sorted(self._tasks, key=lambda each: each.begun):
            if not idle:
                return
            if len(task.copies) == 1 and now - task.begun > max(SLOW * usual, LOOK):
                address = idle.pop()
                self._free.remove(address)
                self._start(task, address)


def _settle(task: _Task, result: Any = None, error: BaseException | None = None) -> None:
    with contextlib.suppress(InvalidStateError):
        if error is not None:
            task.future.set_exception(error)
        else:
            task.future.set_result(result)
