"""Names that moved between rooms can be imported from where they were."""

from importlib import import_module

import pytest

import gyrostat.campaigns
from gyrostat.control import (
    AttitudePID,
    BCross,
    EstimatingCompensator,
    EstimatingFeedForward,
)
from gyrostat.estimation import WheelArrayFilter

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


@pytest.mark.parametrize(
    ("kind", "earlier", "name"),
    [
        (AttitudePID, "designed", "design"),
        (BCross, "designed", "design"),
        (EstimatingCompensator, "designed", "design"),
        (EstimatingCompensator, "tuned", "tune"),
        (EstimatingFeedForward, "tuned", "tune"),
        (WheelArrayFilter, "tuned", "tune"),
    ],
)
def test_constructors_have_their_earlier_names(kind, earlier, name):
    assert getattr(kind, earlier) == getattr(kind, name)
