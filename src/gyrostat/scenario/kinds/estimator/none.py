"""Absence of an estimator."""

from gyrostat.scenario.component import NoPart


class NoEstimator(NoPart):
    """No estimator."""

    name = "none"
