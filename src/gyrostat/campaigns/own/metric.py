"""Earlier place of `gyrostat.scenario.user.metric`, so that older files still find it."""

from gyrostat.scenario.user.metric import RunMetric

__all__ = ["RunMetric"]
