"""Placement of jobs on the workers of a Dask scheduler."""

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor, Future
from queue import Empty, SimpleQueue
from typing import Any

from gyrostat.campaigns.cluster_connection import Connection, is_lost
from gyrostat.campaigns.cluster_tasks import Batch, Task, Worker, settle
from gyrostat.campaigns.handshake import Answer, Handshake, Outcome, carry_out_greeted, greet
from gyrostat.core.errors import InputError, reason_of

LOOK = 1.0
"""Time between two looks at the list of workers, s."""
DEPTH = 2
"""Calls that a worker has for each of its threads: one waits while another is computed."""
CALL = 1.0
"""Time of a call, into which short jobs are joined, s: Dask needs some milliseconds for each."""
GREETINGS = 4
"""Number of greetings without an answer after which a worker is refused."""
LOSSES = 3
"""Number of workers that one job may end before the computation fails."""
PATIENCE = 20.0
"""Time for which a lost worker may be started again if all others are refused, s."""
GONE, SILENT = 10.0, 180.0
"""Time without an answer after which the scheduler is lost: if the connection is broken, and if the
scheduler may be busy, s."""
SLOW = 4.0
"""A call that takes this many times the median is given to a second worker that is free."""


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
        self._workers: dict[str, Worker] = {}
        self._waiting: deque[Task] = deque()
        self._batches: set[Batch] = set()
        self._free: deque[str] = deque()  # one entry for each call that a worker can take
        self._calls_at_once = 0
        self._seconds: deque[float] = deque(maxlen=101)  # of a job in its worker
        self._turnarounds: deque[float] = deque(maxlen=101)  # of a call
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
        task = Task(fn, job)
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
        self._connection.cancel([call for batch in self._batches for call in batch.calls.values()])

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
                self._double_slow_calls()
            self._place()

    def _listed(self, listed: dict[str, int]) -> None:
        self._answered = time.monotonic()
        for address in set(self._workers) - set(listed):
            worker = self._workers.pop(address)
            self._withdraw(address, worker)
            # those that wait in the worker did not end it
            order = sorted(worker.batches, key=lambda batch: batch.begun)
            for place, batch in enumerate(order):
                self._lose(batch, address, counted=place < worker.threads)
        for address in set(listed) - set(self._workers):
            self._workers[address] = Worker(max(1, listed[address]))
            self._greet(address, {})
        if not (listed or self._has_told or self._failure):
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
        if worker is None:
            return
        worker.greetings += 1
        if error is not None and is_lost(error) and worker.greetings < GREETINGS:
            self._greet(address, {})  # if it is lost, the list of workers will say so
            return
        if error is not None:  # whatever a worker without this version of gyrostat raises
            expected = f"expected gyrostat {self._asked.record['gyrostat']}"
            answer = Answer(f"worker {address}: found {reason_of(error)}, {expected}")
        if answer.missing:
            self._greet(address, {each: self._asked.contents[each] for each in answer.missing})
        elif answer.refusal:
            worker.refusal = answer.refusal
            self._say(f"{answer.refusal}: the worker is not used")
        else:
            worker.is_accepted = self._had_worker = True
            worker.greetings = 0
            self._calls_at_once += DEPTH * worker.threads
            self._free.extend([address] * (DEPTH * worker.threads - len(worker.batches)))

    def _withdraw(self, address: str, worker: Worker) -> None:
        """Give a worker no further jobs."""
        if worker.is_accepted:
            worker.is_accepted = False
            self._calls_at_once -= DEPTH * worker.threads
            self._free = deque(each for each in self._free if each != address)

    def _judge(self) -> None:
        """Fail if the scheduler is lost or no worker can be used."""
        now = time.monotonic()
        patience = GONE if self._connection.is_broken else SILENT
        if now - self._answered > patience or self._connection.is_closed:
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
        started = (task for batch in self._batches for task in batch.tasks)
        for task in (*self._waiting, *started):
            settle(task, error=self._failure)
        self._batches.clear()
        self._waiting.clear()

    def _submitted(self, task: Task) -> None:
        if self._failure is not None:
            settle(task, error=self._failure)
            return
        self._waiting.append(task)

    def _place(self) -> None:
        """Give waiting jobs to free workers."""
        while self._waiting and self._free:
            batch = Batch(self._next_tasks())
            self._batches.add(batch)
            self._start(batch, self._free.popleft())

    def _next_tasks(self) -> list[Task]:
        """Waiting jobs for one call: as many as take its time, while every worker gets some."""
        tasks = [self._waiting.popleft()]
        size = 1
        if self._seconds and not tasks[0].losses:
            usual = sorted(self._seconds)[len(self._seconds) // 2]
            size = min(int(CALL / max(usual, 1e-3)), len(self._waiting) // self._calls_at_once)
        while len(tasks) < size and not self._waiting[0].losses:
            tasks.append(self._waiting.popleft())
        return tasks

    def _start(self, batch: Batch, address: str) -> None:
        batch.begun = batch.begun or time.monotonic()
        jobs = [(task.function, task.job) for task in batch.tasks]
        call = self._connection.send(address, carry_out_greeted, self._asked.identity, jobs)
        batch.calls[address] = call
        self._workers[address].batches.add(batch)
        self._connection.when_done(
            call, lambda result: self._events.put(("done", (batch, address, call, *result)))
        )

    def _done(self, event: tuple[Batch, str, Any, Outcome | None, Exception | None]) -> None:
        batch, address, call, outcome, error = event
        if batch.calls.get(address) is not call:
            return
        if error is not None and is_lost(error):
            # a slow transfer is no fault of the job
            self._lose(batch, address, counted=not isinstance(error, TimeoutError))
            return
        self._release(batch, address)
        if outcome is not None and not outcome.was_greeted:
            self._repeat(batch)
            worker = self._workers.get(address)
            if worker is not None and worker.is_accepted:
                self._withdraw(address, worker)
                self._greet(address, {})
            return
        if batch not in self._batches:
            return
        self._batches.discard(batch)
        self._turnarounds.append(time.monotonic() - batch.begun)
        if outcome is not None and outcome.error is not None:
            error = outcome.error
        if outcome is None or error is not None:
            for task in batch.tasks:
                settle(task, error=error)
        else:
            self._seconds.append(outcome.seconds / len(batch.tasks))
            for task, result in zip(batch.tasks, outcome.results, strict=True):
                settle(task, result)

    def _release(self, batch: Batch, address: str) -> None:
        """A worker has finished a call and can take another."""
        batch.calls.pop(address, None)
        worker = self._workers.get(address)
        if worker is not None:
            worker.batches.discard(batch)
            if worker.is_accepted:
                self._free.append(address)

    def _repeat(self, batch: Batch) -> None:
        """Let another worker compute the jobs of a call that has no result, unless one does."""
        if batch in self._batches and not batch.calls:
            self._batches.discard(batch)
            self._waiting.extendleft(reversed(batch.tasks))

    def _lose(self, batch: Batch, address: str, *, counted: bool) -> None:
        """A worker was lost with a call."""
        call = batch.calls.get(address)
        self._release(batch, address)
        if call is not None:
            self._connection.cancel([call])
        if batch not in self._batches:
            return
        for task in batch.tasks:
            task.losses += counted  # it is not joined with others any more
        if max(task.losses for task in batch.tasks) >= LOSSES:
            self._fail(
                f"--scheduler: found {LOSSES} workers that ended during one job, expected workers "
                "that keep running (is there enough memory?)"
            )
        self._repeat(batch)

    def _double_slow_calls(self) -> None:
        """Give calls of slow workers to idle ones too; the first result counts, all are equal."""
        if self._waiting or not self._free or not self._turnarounds:
            return
        usual = sorted(self._turnarounds)[len(self._turnarounds) // 2]
        now = time.monotonic()
        idle = {address for address in self._free if not self._workers[address].batches}
        for batch in sorted(self._batches, key=lambda each: each.begun):
            if not idle:
                return
            if len(batch.calls) == 1 and now - batch.begun > max(SLOW * usual, LOOK):
                address = idle.pop()
                self._free.remove(address)
                self._start(batch, address)
