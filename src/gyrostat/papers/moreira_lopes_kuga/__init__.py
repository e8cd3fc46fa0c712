"""Moreira, Lopes and Kuga: friction torque of a wheel on bristles, by Kalman filter.

M. L. B. Moreira, R. V. F. Lopes and H. K. Kuga, "Estimation of torque in a reaction wheel using a
bristle model for friction".
"""

from gyrostat.papers.moreira_lopes_kuga.compute import loops, open_loop
from gyrostat.papers.reproduction import Paper

MOREIRA_LOPES_KUGA = Paper.of(__name__, loops, open_loop)

__all__ = ["MOREIRA_LOPES_KUGA"]
