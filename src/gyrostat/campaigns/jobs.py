"""Jobs of a campaign and the executor that carries them out."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from gyrostat.campaigns.cluster import Cluster
from gyrostat.campaigns.description import Campaign
from gyrostat.campaigns.executors import Opener, processes, threads
from gyrostat.campaigns.handshake import handshake
from gyrostat.core.engines import ACCELERATED
from gyrostat.core.processors import usable_cores
from gyrostat.runs.fingerprint import use_engine
from gyrostat.scenario.scenario import Scenario

ELSEWHERE = 2048
"""Assumed number of workers of an executor if it is not given."""
FEW_PERIODS = 40_000_000
"""Control periods of all runs up to which the native engine simulates a campaign in threads of this
process: it takes a few seconds, as worker processes need to start."""


class Job(NamedTuple):
    """Job of a worker: runs to simulate.

    Attributes:
        campaign: Campaign of the runs.
        runs: Indices of the runs.
        keep: Indices of the runs whose histories are requested.
        block: Number of the block; -1 for a selection of runs.
        given: Dispersed values, (n, keys), and random keys, (n, parts), of the runs of a search;
            None for those that the runs of a campaign draw.
    """

    campaign: Campaign
    runs: tuple[int, ...]
    keep: tuple[int, ...]
    block: int
    given: tuple[Any, Any] | None = None


_scenario = lru_cache(maxsize=8)(Scenario.from_text)


def work(job: Job) -> Any:
    """Simulate the runs of a job in a worker; returns `gyrostat.campaigns.flown.Flown`."""
    use_engine(job.campaign.engine)
    if job.block >= 0:  # a run that is replayed is compared with the table of runs
        from gyrostat.runs.user.packages import refuse_other_packages

        refuse_other_packages(_scenario(job.campaign.scenario))
    return work_here(job)


def work_here(job: Job) -> Any:
    """Simulate the runs of a job in a process that is configured; see `work`."""
    from gyrostat.campaigns.engine import fly, fly_given

    campaign, engine = job.campaign, job.campaign.engine["engine"]
    scenario = _scenario(campaign.scenario)
    if job.given is not None:
        return fly_given(scenario, job.runs, *job.given, keep=job.keep)
    return fly(scenario, campaign.seed, job.runs, keep=job.keep, engine=engine)


def executor_for(
    campaign: Campaign,
    runs: int,
    opener: Opener | None = None,
    workers: int | None = None,
    fly_job: Callable[[Job], Any] | None = None,
) -> tuple[Opener, int, Callable[[Job], Any]]:
    """Choose the executor of a campaign: by default threads for a few runs of the native engine.

    Threads start at once; an accelerator has them for any number of runs. The engine JAX needs
    processes, because its flags are fixed at its start.

    Args:
        campaign: Campaign.
        runs: Number of runs to simulate.
        opener: Opens the executor; None for this machine.
        workers: Number of workers; None for one for each core, `ELSEWHERE` for another executor.
        fly_job: Function that is applied to each job; None for the simulation.

    Returns:
        The opener, the number of workers, and the function.
    """
    cores = usable_cores()
    if isinstance(opener, Cluster):
        asked = handshake(campaign.engine, [(_scenario(campaign.scenario), 0)])
        # the handshake has done what `work` does before
        return opener.with_handshake(asked), workers or ELSEWHERE, fly_job or work_here
    if opener is not None:
        return opener, workers or ELSEWHERE, fly_job or work
    if campaign.engine.get("engine") in ACCELERATED:
        from gyrostat.campaigns.ready import prepare

        prepare(_scenario(campaign.scenario), engine=campaign.engine["engine"])
        # threads prepare and conclude runs while the device computes those of others
        return threads(workers or cores), workers or cores, fly_job or work_here
    if campaign.engine.get("engine") == "native" and workers is None and fly_job is None:
        scenario = _scenario(campaign.scenario)
        if runs * scenario.count <= FEW_PERIODS:
            from gyrostat.campaigns.noise import parts_of
            from gyrostat.campaigns.ready import prepare

            parts = 0 if campaign.search is None else parts_of(scenario)
            prepare(scenario, parts=parts)  # once, not in each thread
            return threads(cores), cores, work_here
    return processes(workers or cores), workers or cores, fly_job or work
