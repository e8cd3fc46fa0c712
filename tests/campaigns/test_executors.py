"""Executors: one that stays open, and workers whose parent is killed."""

import contextlib
import multiprocessing.spawn
import os
import pickle
import subprocess
import threading
from concurrent.futures import BrokenExecutor

import numpy as np
import pytest

from gyrostat.campaigns.executors import _Worker, kept_open, processes
from gyrostat.campaigns.flown import Flown


@pytest.fixture
def opener():
    """An opener that records which executors were opened and how they were closed."""
    events = []

    @contextlib.contextmanager
    def opened():
        number = sum(1 for what, *_ in events if what == "opened")
        events.append(("opened", number))
        try:
            yield number
        except BaseException as error:
            events.append(("failed", number, type(error)))
            raise
        events.append(("closed", number))

    opened.events = events
    return opened


def test_the_same_executor_is_given_until_the_end(opener):
    with kept_open(opener) as kept:
        for _ in range(3):
            with kept() as pool:
                assert pool == 0
        assert opener.events == [("opened", 0)]
    assert opener.events == [("opened", 0), ("closed", 0)]


def test_one_that_failed_is_closed_and_replaced(opener):
    with kept_open(opener) as kept:
        with pytest.raises(BrokenExecutor), kept():
            raise BrokenExecutor
        assert opener.events[1:] == [("failed", 0, BrokenExecutor)]
        with kept() as pool:
            assert pool == 1
    assert opener.events[2:] == [("opened", 1), ("closed", 1)]


def test_ctrl_c_reaches_the_executor_between_two_parts(opener):
    def interrupted():
        with kept_open(opener) as kept:
            with kept():
                pass
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert opener.events[1:] == [("failed", 0, KeyboardInterrupt)]


def test_the_thread_of_a_pool_that_failed_ends_with_it():
    threads = set(threading.enumerate())
    with pytest.raises(BrokenExecutor), processes(2)() as pool:
        pool.submit(os._exit, 1).result()
    assert set(threading.enumerate()) <= threads


def test_a_worker_whose_parent_is_killed_before_it_sends_anything_is_silent(monkeypatch):
    commands = []
    read, write = os.pipe()
    os.close(write)  # as the death of the parent does

    def launched(process):
        commands.append(multiprocessing.spawn.get_command_line(tracker_fd=read, pipe_handle=read))
        raise InterruptedError

    monkeypatch.setattr(_Worker, "_Popen", staticmethod(launched))
    with pytest.raises(InterruptedError):
        _Worker(target=print).start()
    done = subprocess.run(commands[0], pass_fds=[read], capture_output=True, text=True)
    os.close(read)
    assert (done.stdout, done.stderr) == ("", "")


def test_results_of_runs_arrive_as_they_were_sent():
    """Arrays of several types and shapes, in their order, NaN among them."""
    columns = {
        "run": np.arange(3),
        "a": np.array([1.0, np.nan, -0.0]),
        "status": np.array([0, 1, 0], np.int8),
        "axes": np.ones((3, 2)),
        "b": np.array([5e-324, np.inf, 2.0]),
    }
    sent = Flown(columns, None)
    arrived = pickle.loads(pickle.dumps(sent))
    assert [*arrived.columns] == [*columns]
    for name, column in columns.items():
        assert arrived.columns[name].dtype == column.dtype
        assert arrived.columns[name].tobytes() == column.tobytes()
    assert arrived.histories is None
