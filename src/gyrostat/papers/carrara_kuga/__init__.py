"""Carrara and Kuga: friction of a reaction wheel, and its compensation on an air-bearing table.

V. Carrara and H. K. Kuga, "Estimating friction parameters in reaction wheels for attitude control".
"""

from gyrostat.papers.carrara_kuga.dispersed import dispersed_runs
from gyrostat.papers.carrara_kuga.identification import recovery, stribeck_speed, table1
from gyrostat.papers.carrara_kuga.table import crossing_zero
from gyrostat.papers.reproduction import Paper

CARRARA_KUGA = Paper.of(
    __name__, table1, recovery, stribeck_speed, crossing_zero, full=(dispersed_runs,)
)

__all__ = ["CARRARA_KUGA"]
