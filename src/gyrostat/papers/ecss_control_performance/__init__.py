"""ECSS-E-ST-60-10C, Space engineering: Control performance, 15 November 2008: its worked example.

Annex C compiles the pointing budgets of a spacecraft from error sources that are given, not flown.
Here each source is drawn over time and over its ensemble, and goes through the indices and the
statistics of gyrostat's requirements.
"""

from gyrostat.papers.ecss_control_performance.compute import budgets, rules
from gyrostat.papers.reproduction import Paper

ECSS_CONTROL_PERFORMANCE = Paper.of(__name__, budgets, rules)

__all__ = ["ECSS_CONTROL_PERFORMANCE"]
