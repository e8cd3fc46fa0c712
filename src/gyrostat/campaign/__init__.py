"""A scenario, flown once or ten thousand times with what is uncertain drawn anew."""

from gyrostat.campaign.description import Campaign
from gyrostat.campaign.execute import Job, replay, run_campaign, worst_runs
from gyrostat.campaign.executors import cluster, processes
from gyrostat.campaign.scenario import Dispersion, Event, Scenario
from gyrostat.campaign.store import Store

__all__ = [
    "Campaign",
    "Dispersion",
    "Event",
    "Job",
    "Scenario",
    "Store",
    "cluster",
    "processes",
    "replay",
    "run_campaign",
    "worst_runs",
]
