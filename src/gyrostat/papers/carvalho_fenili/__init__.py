"""Carvalho and Fenili: LQR and SDRE attitude control with failures of one or two of three wheels.

C. A. de Carvalho Junior and A. Fenili, "Nonlinear attitude control of artificial satellites
considering failure in momentum wheels".
"""

from gyrostat.papers.carvalho_fenili.recoveries import every_recovery, without_rest
from gyrostat.papers.carvalho_fenili.requirements import every_set
from gyrostat.papers.carvalho_fenili.statements import EXPERIMENTS
from gyrostat.papers.reproduction import Paper

CARVALHO_FENILI = Paper.of(__name__, *EXPERIMENTS, without_rest, full=(every_recovery, every_set))

__all__ = ["CARVALHO_FENILI"]
