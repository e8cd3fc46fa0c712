"""Base of the orbits that a scenario can name, whose classes are in kinds/orbit."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, tau
from typing import Annotated, Any

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.component import ORBIT, Kind
from gyrostat.scenario.schema import Key, positive, size

INCLINATION = size("angle", 0.0, "Inclination to the equator of the GCRS.", most=pi)
ASCENDING_NODE = Key("angle", 0.0, "Right ascension of the ascending node.")


@dataclass(frozen=True, eq=False)
class OrbitKind(Kind):
    """Orbit from an epoch on."""

    provides = frozenset({ORBIT})
    phase: Annotated[
        Scalar,
        size(
            "angle",
            0.0,
            "Delay of the start of the run, 360 deg for one orbital period; Earth and Sun are "
            "those of the delayed time.",
            most=tau,
        ),
    ]
    f107: Annotated[Scalar, positive("1", 150.0, "Solar radio flux F10.7 of the day before, sfu.")]
    f107a: Annotated[Scalar, positive("1", 150.0, "Mean of F10.7 over 81 days, sfu.")]
    ap: Annotated[Scalar, size("1", 15.0, "Daily geomagnetic index Ap.")]
    ut1_utc: Annotated[Scalar, Key("time", 0.0, "UT1 - UTC.", least=-0.9, most=0.9)]

    def elements(self, texts: Mapping[str, str]) -> Any:
        """Definition of the orbit, see `gyrostat.spacecraft.orbit`.

        Args:
            texts: Texts of the section by name.
        """
        raise NotImplementedError

    def named(self, *names: str) -> dict[str, float]:
        """Values of some keys."""
        return {name: float(getattr(self, name)) for name in names}
