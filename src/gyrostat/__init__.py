"""Reaction wheels in spacecraft attitude control: identification, estimation, control, simulation.

Inside the package every quantity is in SI units and radians, in float64.
"""

__version__ = "0.1.0"

__all__ = ["__version__"]
