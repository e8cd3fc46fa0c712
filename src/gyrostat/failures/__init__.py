"""What a spacecraft can still hold at rest when wheels have failed, and proof of what it cannot."""

from gyrostat.failures.certificate import Certificate
from gyrostat.failures.controllability import controllability_matrix
from gyrostat.failures.feasibility import Holdable, holdable, holdable_sky
from gyrostat.failures.sky_map import SkyMap

__all__ = [
    "Certificate",
    "Holdable",
    "SkyMap",
    "controllability_matrix",
    "holdable",
    "holdable_sky",
]
