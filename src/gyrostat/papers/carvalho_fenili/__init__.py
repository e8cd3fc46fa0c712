"""Carvalho and Fenili: LQR and SDRE attitude control while one or two of three wheels fail.

C. A. de Carvalho Junior and A. Fenili, "Nonlinear attitude control of artificial satellites
considering failure in momentum wheels".
"""

from gyrostat.papers.carvalho_fenili.recoveries import every_recovery, recoveries
from gyrostat.papers.carvalho_fenili.requirements import requirements
from gyrostat.papers.carvalho_fenili.statements import (
    conclusion,
    dependent,
    design,
    drawn,
    linear,
    numbers,
)
from gyrostat.papers.reproduction import Paper

CARVALHO_FENILI = Paper.of(
    __name__,
    design,
    numbers,
    linear,
    dependent,
    conclusion,
    drawn,
    recoveries,
    full=(every_recovery, requirements),
)

__all__ = ["CARVALHO_FENILI"]
