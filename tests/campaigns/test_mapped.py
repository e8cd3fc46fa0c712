"""A function of many jobs."""

import time

from gyrostat.campaigns.executors import threads
from gyrostat.campaigns.mapped import mapped


def late_square(number):
    """Square of a number, the later the smaller it is."""
    time.sleep(0.05 / (1.0 + number))
    return number**2


def test_results_keep_the_order_of_the_jobs():
    expected = [number**2 for number in range(6)]
    assert mapped(late_square, range(6)) == expected
    assert mapped(late_square, range(6), threads(6)) == expected
    assert mapped(late_square, [], threads(2)) == []
