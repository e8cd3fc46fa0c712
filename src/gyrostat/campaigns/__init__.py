"""Monte Carlo campaigns: simulation of a scenario with dispersed parameters."""

from gyrostat.campaigns.cluster import cluster
from gyrostat.campaigns.description import Campaign
from gyrostat.campaigns.execute import replay, run_campaign
from gyrostat.campaigns.executors import processes
from gyrostat.campaigns.jobs import Job
from gyrostat.campaigns.labelled_runs import campaign_runs
from gyrostat.campaigns.store import Store
from gyrostat.campaigns.worst import worst_runs
from gyrostat.scenario.requirement import Requirement
from gyrostat.scenario.scenario import Dispersion, Event, Scenario, Window

__all__ = [
    "Campaign",
    "Dispersion",
    "Event",
    "Job",
    "Requirement",
    "Scenario",
    "Store",
    "Window",
    "campaign_runs",
    "cluster",
    "processes",
    "replay",
    "run_campaign",
    "worst_runs",
]
