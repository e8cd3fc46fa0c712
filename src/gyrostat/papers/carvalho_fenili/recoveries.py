"""The paper's experiment done right: after the failure, a law that knows of it.

Table 2 on wheels with limits, at rest at first. The paper's law flies them to the failure; from
there on `gyrostat.recovery.recover` goes to the nearest attitude that can be held.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gyrostat._jax import jnp
from gyrostat._types import Vector
from gyrostat.body import Gyrostat, GyrostatState, rotations
from gyrostat.holdable import Holdable
from gyrostat.papers.carvalho_fenili.exchange import (
    CRAFT,
    LIMITED,
    MOMENTUM,
    PERIOD,
    ROTOR,
    TARGET,
    TORQUE,
    start,
)
from gyrostat.papers.carvalho_fenili.printed import (
    AXES,
    CASES,
    FAILURE,
    LAWS,
    failure_of,
)
from gyrostat.papers.claims import Claim
from gyrostat.recovery import Loss, Recovery, plan_recovery, recover

if TYPE_CHECKING:
    import xarray as xr

DURATION = 600.0
"""s from the failure on."""
LOSSES = {
    "frozen": (Loss("frozen"), "the failed wheels keep their momentum"),
    "seized": (Loss("seized"), "the failed wheels stop at once"),
    "rundown": (Loss("rundown", 60.0), "the failed wheels run down with 60 s"),
}
"""How wheels fail, and in words."""
SETTINGS = (
    f"Recovery: wheels of {TORQUE:g} N·m, {MOMENTUM:g} N·m·s and {ROTOR:g} kg·m² along x, y and z, "
    "at rest at first. The limits act from the start, and the paper's laws ask for several times "
    f"that torque: at {FAILURE:g} s the body is still on its way, unlike in the paper's plant.",
    "From the failure on, a law that knows of it goes to the nearest attitude that can be held. "
    "Settled: below 0.05 deg from it and 1e-4 rad/s for good, counted from the failure, within "
    f"{DURATION:g} s.",
)


@dataclass(frozen=True)
class Onset:
    """A law's flight on healthy wheels to the failure.

    Attributes:
        state: at the failure.
        demand: largest torque that the law asks of a wheel, N·m.
        limited: how long a limit cuts it, s.
    """

    state: GyrostatState
    demand: float
    limited: float


def onset(one: "xr.Dataset") -> Onset:
    """A run without a failure, to the time of the failure.

    Args:
        one: of `flown_on_wheels`.
    """
    count = round(FAILURE / PERIOD)
    then = (jnp.asarray(one[name].values[count]) for name in GyrostatState._fields)
    before = one.isel(time=slice(None, count))
    return Onset(
        state=GyrostatState(*then),
        demand=float(np.max(np.abs(before.torque.values))),
        limited=PERIOD * float(np.sum(np.any(before.saturated.values, axis=1))),
    )


@dataclass(frozen=True)
class Recovered:
    """Recoveries from one law.

    Attributes:
        onset: where they start.
        flown: case, then kind of failure -> recovery.
        unlimited: case -> what could be held if the failed wheels kept their momentum and no limit
            had acted before.
    """

    onset: Onset
    flown: Mapping[str, Mapping[str, Recovery]]
    unlimited: Mapping[str, Holdable]


def recovered(flown: "xr.Dataset") -> Recovered:
    """Recover from all failures.

    Args:
        flown: of `flown_on_wheels`, by the law that flies before.
    """
    target = np.asarray(rotations.from_euler(TARGET))
    limited, free = onset(flown.sel(run="limited")), onset(flown.sel(run="none")).state
    recoveries = {
        case: {
            kind: recover(
                LIMITED,
                limited.state,
                dict.fromkeys(failed, loss),
                target=target,
                duration=DURATION,
            )
            for kind, (loss, _) in LOSSES.items()
        }
        for case, failed in CASES.items()
        if failed
    }
    held = _rotor_momentum(free)
    unlimited = {
        case: plan_recovery(
            LIMITED,
            free.momentum,
            failed={wheel: float(held[wheel]) for wheel in CASES[case]},
            target=target,
        ).answer
        for case in recoveries
    }
    return Recovered(limited, recoveries, unlimited)


def _rotor_momentum(state: GyrostatState) -> Vector:
    """Of each rotor about its axis in inertial space, N·m·s."""
    return ROTOR * np.asarray(state.wheel_speed + Gyrostat(CRAFT).rate(state))


def momentum_claims() -> tuple[Claim, ...]:
    """The total momentum, which nothing changes."""
    momentum = np.asarray(start().momentum)
    why = "R I w of Table 2 in inertial axes; wheels at rest at first, and no torque from outside."
    return tuple(
        Claim(f"recover.momentum_{axis}", f"total momentum along {axis}", float(part), "N·m·s", why)
        for axis, part in zip(AXES, momentum, strict=True)
    )


def recovery_claims(runs: Mapping[str, Recovered]) -> tuple[Claim, ...]:
    """Torque asked for before, and where, whether and how soon each recovery comes to rest."""
    return (
        *momentum_claims(),
        *(_demand_claim(law, found.onset) for law, found in runs.items()),
        *(
            claim
            for law, found in runs.items()
            for case, kinds in found.flown.items()
            for kind, recovery in kinds.items()
            for claim in _claims(law, case, kind, recovery, found.unlimited[case])
        ),
    )


def _demand_claim(law: str, found: Onset) -> Claim:
    return Claim(
        f"recover.{law}.largest_demand",
        f"largest torque that {LAWS[law]} asks of a wheel before the failure",
        found.demand,
        "N·m",
        f"The limit of {TORQUE:g} N·m acts for {found.limited:.1f} of the {FAILURE:g} s.",
    )


def sentence(reason: str) -> str:
    """A reason as a sentence of its own."""
    return f"{reason[:1].upper()}{reason[1:]}."


def _claims(
    law: str, case: str, kind: str, recovery: Recovery, unlimited: Holdable
) -> tuple[Claim, ...]:
    answer, prefix = recovery.plan.answer, f"recover.{law}.{case}.{kind}"
    of = f"{LAWS[law]} before, {failure_of(case)}, {LOSSES[kind][1]}"
    directions = "one direction" if answer.rank == 1 else "two directions"
    where = f"The wheels that work turn the body in {directions}."
    moves = "Some attitudes can be held, and rest is possible there."
    if answer.angle is None:
        where = f"No attitude can be held: {answer.reason}."
        moves = f"{where} At any attitude and with any law the body turns at least so fast."
    if kind == "frozen":
        instead, free = "Had no limit acted before the failure", unlimited.angle
        found = "none" if free is None else f"one at {np.degrees(free):.4g} deg"
        where += f" {instead}, there would be {found}."
        moves += f" {instead}, it would be {unlimited.for_ever.rate:.4g} rad/s."
    settles = sentence(recovery.reason)
    if recovery.settle is not None:
        settles = f"By {type(recovery.plan.controller).__name__}, counted from the failure."
    nearest = None if answer.angle is None else float(np.degrees(answer.angle))
    rows = (
        ("nearest_deg", "angle to the nearest attitude that can be held", nearest, "deg", where),
        ("min_rate_rad_s", "least body rate for ever", answer.for_ever.rate, "rad/s", moves),
        ("settle_s", "time to settle there", recovery.settle, "s", settles),
    )
    return tuple(
        Claim(f"{prefix}.{key}", f"{what}, {of}", value, unit, why)
        for key, what, value, unit, why in rows
    )
