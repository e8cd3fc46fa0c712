"""What a spacecraft can still hold at rest when wheels have failed, and proof of what it cannot."""

from gyrostat.holdable.answer import Holdable, holdable, holdable_sky
from gyrostat.holdable.certificate import Certificate
from gyrostat.holdable.controllability import controllability_matrix
from gyrostat.holdable.sky import SkyMap

__all__ = [
    "Certificate",
    "Holdable",
    "SkyMap",
    "controllability_matrix",
    "holdable",
    "holdable_sky",
]
