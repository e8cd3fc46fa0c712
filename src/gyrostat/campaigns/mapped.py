"""A function of many jobs, here or by the workers of a cluster, with the same results."""

import os
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, TypeVar

from gyrostat.campaigns.cluster import Cluster
from gyrostat.campaigns.executors import Opener, carry_out
from gyrostat.campaigns.handshake import handshake
from gyrostat.campaigns.jobs import ELSEWHERE

Job = TypeVar("Job")


def mapped(
    work: Callable[[Job], Any], jobs: Iterable[Job], opener: Opener | None = None
) -> list[Any]:
    """Results of a function for each of a few jobs, in their order.

    Args:
        work: Function of a module, with results that can be pickled.
        jobs: Jobs.
        opener: Opens the executor; None for this process, one job after the other.

    Raises:
        InputError: See `gyrostat.campaigns.executors.carry_out`.
    """
    jobs = [*jobs]
    if opener is None:
        return [work(job) for job in jobs]
    if isinstance(opener, Cluster):
        from gyrostat.runs.fingerprint import engine_record

        # the flags of this process, which a campaign would set
        flags = os.environ.get("XLA_FLAGS", "")
        opener = opener.with_handshake(handshake(engine_record("cpu", flags)))
    results: dict[int, Any] = {}

    def take(numbered: Any, result: Any) -> None:
        results[numbered[0]] = result

    carry_out(enumerate(jobs), partial(_numbered, work), opener, take, window=2 * ELSEWHERE)
    return [results[number] for number in range(len(jobs))]


def _numbered(work: Callable[[Any], Any], numbered: tuple[int, Any]) -> Any:
    """Result of a function of a job with its number."""
    return work(numbered[1])
