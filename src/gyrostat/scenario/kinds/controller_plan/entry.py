"""Entry of the momentum plan of a wheel array."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.component import NULL_SPACE, Kind
from gyrostat.scenario.relation import Relation, less
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.schema import Key, size


@dataclass(frozen=True, eq=False)
class PlanEntry(Kind):
    """Momentum of the wheels from a time on, see `gyrostat.control.MomentumPlan`."""

    name = "entry"
    needs = frozenset({NULL_SPACE})
    time: Annotated[Scalar, size("time", None, "Start of the entry, later than the one before.")]
    unloads: Annotated[
        Scalar, size("time", 0.0, "Time from there in which the external actuator works.")
    ]
    momentum: Annotated[
        Vector3,
        Key(
            "momentum",
            0.0,
            "Total momentum of spacecraft and wheels after the unloading, inertial axes.",
            shape=(3,),
        ),
    ]
    null_space: Annotated[
        Scalar, Key("momentum", None, "Null-space momentum z of four or more wheels.")
    ]
    momentum_rate: Annotated[
        Vector3,
        Key(
            "torque",
            0.0,
            "Rate of the wanted total momentum during the unloading, inertial axes.",
            shape=(3,),
        ),
    ]
    torque: Annotated[
        Vector3,
        Key(
            "torque",
            0.0,
            "Feed-forward torque of the external actuator during the unloading, inertial axes: "
            "`momentum_rate` less the external torques that the plan expects.",
            shape=(3,),
        ),
    ]

    @classmethod
    def relations(cls, place: str, scenario: Scenario) -> Iterator[Relation]:
        """The entry is later than the one before."""
        section, _, name = place.rpartition(".")
        names = [part.name for part in scenario.parts if part.section == section]
        number = names.index(name)
        if number > 0:
            before, time = (f"{section}.{each}.time" for each in (names[number - 1], name))
            yield less(
                before,
                time,
                f"{section}[{name}].time: found {{{time}}} s, expected more than that of the entry "
                f"before, {{{before}}} s",
            )
