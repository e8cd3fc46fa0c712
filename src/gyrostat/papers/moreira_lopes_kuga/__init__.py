"""Moreira, Lopes and Kuga: Kalman filter for the friction torque of a wheel with bristle friction.

M. L. B. Moreira, R. V. F. Lopes and H. K. Kuga, "Estimation of torque in a reaction wheel using a
bristle model for friction".
"""

from gyrostat.papers.moreira_lopes_kuga.compute import loops, open_loop
from gyrostat.papers.reproduction import Paper

MOREIRA_LOPES_KUGA = Paper.of(__name__, loops, open_loop)

__all__ = ["MOREIRA_LOPES_KUGA"]
