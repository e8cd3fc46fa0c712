"""Executors that stay open between the parts of a campaign."""

import contextlib
from concurrent.futures import BrokenExecutor

import pytest

from gyrostat.campaigns.executors import kept_open


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
