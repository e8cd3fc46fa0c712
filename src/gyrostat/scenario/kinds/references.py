"""Kinds of the reference attitude that a scenario can name, and its modes and slews."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import Any, NamedTuple

from jaxtyping import Array, Float

from gyrostat.control.guidance import (
    NEVER,
    Aim,
    Condition,
    Fixed,
    GroundTarget,
    Nadir,
    Pointing,
    Profile,
    Reference,
    SlewLimits,
    Slews,
    Table,
    WheelEnvelope,
    to_earth,
    to_sun,
)
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import normalised
from gyrostat.scenario.kinds.components import Component, Options
from gyrostat.scenario.kinds.environments import EITHER_ORBIT, orbit_of
from gyrostat.scenario.schema import Key, positive, size, vector
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment


class PlannedReference(NamedTuple):
    """Part of a reference that is computed once for a scenario.

    Attributes:
        envelope: Torque and momentum of the working wheels; None if no slew needs it.
        tables: Place of a table in the scenario -> interpolated table.
        orbit: Orbit of the run; None without one.
    """

    envelope: WheelEnvelope | None
    tables: Mapping[str, Table]
    orbit: OrbitEnvironment | None = None


class ReferenceCase(NamedTuple):
    """What the kinds of references are made of.

    Attributes:
        planned: Part that is computed once, with the momentum and the orbit of the run.
        attitude: Initial attitude of the scenario, (4,).
        modes: Attitude over time and end of each mode of a sequence.
        slews: Options of each slew, in their order in the file.
    """

    planned: PlannedReference
    attitude: Float[Array, "4"]
    modes: Sequence[tuple[Profile, Condition]]
    slews: Sequence[Options]


def _fixed(options: Options, planned: PlannedReference, **given: Any) -> Fixed:
    return Fixed(normalised(options["target"]))


def _nadir(options: Options, planned: PlannedReference, **given: Any) -> Profile:
    axes = options["to_earth"], options["along"]
    if planned.orbit is None:
        return Nadir.pointing(orbit_of(options), *axes)
    return _along(planned, to_earth, *axes)


def _sun(options: Options, planned: PlannedReference, **given: Any) -> Pointing:
    return _along(planned, to_sun, options["to_sun"], options["normal"])


def _ground_target(options: Options, planned: PlannedReference, **given: Any) -> Pointing:
    target = GroundTarget(*(options[name] for name in ("latitude", "longitude", "height")))
    return _along(planned, target, options["to_target"], options["along"])


def _along(planned: PlannedReference, aim: Aim, axis: Array, second: Array) -> Pointing:
    assert planned.orbit is not None  # `needs`
    return Pointing.of(planned.orbit, aim, axis, second)


def _table(options: Options, planned: PlannedReference, place: str, **given: Any) -> Table:
    return planned.tables[place]


def single(profile: Any) -> Any:
    """Function that makes the reference of one mode.

    Args:
        profile: Makes an attitude over time of the options, the planned reference and the place in
            the scenario.
    """

    def make(options: Options, case: ReferenceCase) -> Reference:
        return Reference.of(profile(options, planned=case.planned, place="reference"))

    return make


def mode(profile: Any) -> Any:
    """Function that makes the attitude over time of a mode, see `single`, and when it ends."""

    def make(options: Options, **given: Any) -> tuple[Profile, Condition]:
        return profile(options, **given), _condition(options)

    return make


def _limits(options: Options, case: ReferenceCase) -> SlewLimits:
    rate, acceleration, jerk = (options[name] for name in ("rate", "acceleration", "jerk"))
    return SlewLimits(rate, acceleration, jerk, case.planned.envelope)


def _slews(options: Options, case: ReferenceCase) -> Reference:
    times = jnp.stack([jnp.asarray(slew["time"]) for slew in case.slews])
    targets = jnp.stack([normalised(slew["target"]) for slew in case.slews])
    return Reference.of(Slews.to(case.attitude, times, targets, _limits(options, case)))


def _sequence(options: Options, case: ReferenceCase) -> Reference:
    envelope = case.planned.envelope
    return Reference.sequence(
        *case.modes,
        limits=_limits(options, case),
        spacecraft=None if envelope is None else envelope.spacecraft,
    )


def _condition(options: Options) -> Condition:
    """Conditions of a mode; without any, it never ends."""
    found = [options[name] for name in UNTIL]
    given = [value != UNTIL[name].default for name, value in zip(UNTIL, found, strict=True)]
    after = jnp.where(jnp.any(jnp.stack(given)), found[0], NEVER.after)
    return Condition(after, *found[1:])


_TARGET = {"target": Key("1", None, "Attitude, a quaternion, scalar first.", shape=(4,))}
_NADIR: dict[str, Key] = {
    **EITHER_ORBIT,
    "to_earth": vector("1", "Body axis that points to the Earth.", (0.0, 0.0, 1.0)),
    "along": vector(
        "1", "Body axis whose part across `to_earth` points along the velocity.", (1.0, 0.0, 0.0)
    ),
}
_SUN: dict[str, Key] = {
    "to_sun": vector("1", "Body axis that points to the Sun.", (1.0, 0.0, 0.0)),
    "normal": vector(
        "1", "Body axis whose part across `to_sun` points along the orbit normal.", (0.0, 1.0, 0.0)
    ),
}
_GROUND: dict[str, Key] = {
    "latitude": Key("angle", None, "Geodetic latitude (WGS 84)."),
    "longitude": Key("angle", None, "Longitude, to the east."),
    "height": Key("length", 0.0, "Height above the ellipsoid."),
    "to_target": vector("1", "Body axis that points to the target.", (0.0, 0.0, 1.0)),
    "along": vector(
        "1", "Body axis whose part across `to_target` points along the velocity.", (1.0, 0.0, 0.0)
    ),
}
_AUTO = '; none or `"auto"`: the fastest slew within the wheels.'
LIMITS: dict[str, Key] = {
    "rate": positive("speed", inf, f"Largest rate of a slew{_AUTO}"),
    "acceleration": positive("rad/s²", inf, f"Largest acceleration of a slew{_AUTO}"),
    "jerk": positive("rad/s³", inf, "Largest jerk of a slew."),
    "torque_share": positive(
        "1", 0.8, "Fraction of the wheels' torque limits that slews may use.", most=1.0
    ),
    "momentum_share": positive(
        "1", 0.9, "Fraction of the wheels' momentum limits that slews may use.", most=1.0
    ),
}
"""Keys of the limits of slews."""
UNTIL: dict[str, Key] = {
    "until_time": size("time", 0.0, "End condition: least time since the start of the mode."),
    "until_rate_below": positive("speed", inf, "End condition: body rate below this value."),
    "until_momentum_above": Key(
        "momentum", -1.0, "End condition: total momentum above this value.", least=-1.0
    ),
    "until_error_below": positive("angle", inf, "End condition: pointing error below this value."),
}
"""Keys of the conditions under which a mode ends."""
_PROFILES: dict[str, Component] = {
    "nadir": Component(
        "Nadir pointing along [orbit] (`gyrostat.control.guidance.Pointing`), or on a circular "
        "orbit (`gyrostat.control.guidance.Nadir`). Elements that are not given are those of the "
        "environment `orbit`.",
        _NADIR,
        _nadir,
    ),
    "sun": Component(
        "Sun pointing along [orbit] (`gyrostat.control.guidance.Pointing`).",
        _SUN,
        _sun,
        needs=("orbit",),
    ),
    "ground_target": Component(
        "Pointing at a ground target along [orbit] (`gyrostat.control.guidance.GroundTarget`). It "
        "is also followed below the horizon.",
        _GROUND,
        _ground_target,
        needs=("orbit",),
    ),
    "table": Component(
        "Attitude from a CSV `file` with the columns time, s, and quaternion, scalar first, "
        "interpolated by a cubic spline (`gyrostat.control.guidance.Table`).",
        {},
        _table,
        texts=("file",),
    ),
}
"""Kinds of an attitude over time, of the whole run or of a mode."""
MODES: dict[str, Component] = {
    "fixed": Component("Fixed attitude.", {**_TARGET, **UNTIL}, mode(_fixed)),
    **{
        kind: Component(
            f"As the reference `{kind}`.",
            {**each.keys, **UNTIL},
            mode(each.make),
            texts=each.texts,
            needs=each.needs,
        )
        for kind, each in _PROFILES.items()
    },
}
"""Kinds of [[reference.mode]]."""
SLEWS: dict[str, Component] = {
    "slew": Component(
        "Slew to `target` from `time` on.",
        {"time": size("time", None, "Start of the slew."), **_TARGET},
        lambda options, **given: options,
    )
}
"""Kinds of [[reference.slew]]."""
REFERENCES: dict[str, Component] = {
    "fixed": Component(
        "The target attitude of the controller, which events of the kind `slew` change; without "
        "rate and acceleration.",
        {},
        lambda options, case: None,
    ),
    **{kind: replace(each, make=single(each.make)) for kind, each in _PROFILES.items()},
    "slews": Component(
        "Eigenaxis slews, one for each table [[reference.slew]], from the initial attitude "
        "(`gyrostat.control.guidance.Slews`).",
        LIMITS,
        _slews,
    ),
    "sequence": Component(
        "Modes that follow each other, one for each table [[reference.mode]] "
        "(`gyrostat.control.guidance.Reference`). The limits are those of the rotation from mode "
        "to mode.",
        LIMITS,
        _sequence,
    ),
}
"""Kinds of [reference]; `make` takes the options and a `ReferenceCase`."""
POSITION_ERROR = "reference.position_error"
"""Key of the error of the position that the reference of the controller is computed from."""
ERROR = Key(
    "length",
    None,
    "Error of the position, GCRS, from which the controller computes the reference.",
    shape=(3,),
)
LISTS = {"slews": "reference.slew", "sequence": "reference.mode"}
"""Kind of the reference -> list of tables that it needs."""
