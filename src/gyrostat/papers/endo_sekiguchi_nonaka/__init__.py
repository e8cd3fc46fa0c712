"""Endo, Sekiguchi and Nonaka: two-wheel pointing, model error compensator with on-line tuning.

H. Endo, K. Sekiguchi and K. Nonaka, "Model error compensator for attitude control of 2-wheel
spacecraft with on-line FRIT based tuning".
"""

from gyrostat.papers.endo_sekiguchi_nonaka.compute import numbers, statements
from gyrostat.papers.endo_sekiguchi_nonaka.dispersed import dispersed_runs
from gyrostat.papers.reproduction import Paper

ENDO_SEKIGUCHI_NONAKA = Paper.of(__name__, numbers, statements, full=(dispersed_runs,))

__all__ = ["ENDO_SEKIGUCHI_NONAKA"]
