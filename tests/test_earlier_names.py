"""Names that moved between rooms can be imported from where they were."""

from importlib import import_module

import pytest

import gyrostat.campaigns

MOVED = {
    "campaigns": ("scenario", ("Dispersion", "Event", "Requirement", "Scenario", "Window")),
    "campaigns.own.metric": ("scenario.user.metric", ("RunMetric",)),
    "campaigns.own.contracts": (
        "scenario.user.contracts",
        (
            *("Actuator", "AddedSensor", "Change", "Compensator", "Controller", "Estimator"),
            *("Predicting", "TorqueModel"),
        ),
    ),
}
"""Earlier module -> the present one, and the names."""


@pytest.mark.parametrize("earlier", MOVED)
def test_names_are_found_at_their_earlier_place(earlier):
    present, names = MOVED[earlier]
    before, now = import_module(f"gyrostat.{earlier}"), import_module(f"gyrostat.{present}")
    for name in names:
        assert getattr(before, name) is getattr(now, name)
    assert set(names) <= set(before.__all__)


def test_names_of_campaigns_are_those_of_before():
    names = "Campaign Dispersion Event Job Requirement Scenario Store Window campaign_runs cluster"
    names += " processes replay run_campaign worst_runs"
    assert gyrostat.campaigns.__all__ == names.split()
