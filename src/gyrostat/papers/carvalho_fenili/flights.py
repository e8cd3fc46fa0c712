"""The 14 runs: the law evaluated at every stage of a step, and sampled and held."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat._jax import jax, jnp
from gyrostat.body import EulerSensor, EulerState, TorqueDrivenBody
from gyrostat.body.torque_driven import LARGEST_SLIP
from gyrostat.papers.carvalho_fenili.laws import TorqueOnAngles
from gyrostat.papers.carvalho_fenili.printed import (
    ANGLES,
    CASES,
    DURATION,
    FAILURE,
    HEALTHY,
    INERTIA,
    RATES,
    STEP,
    failure_times,
)
from gyrostat.simulate import simulate, stack

if TYPE_CHECKING:
    import xarray as xr


LOST = 100.0
"""rad/s of slip in one step: it failed outright, in a run that spins up."""


@dataclass(frozen=True)
class Flight:
    """One run, as far as it is valid.

    Attributes:
        case: which torques fail.
        time: (N,) of the samples, s.
        angles: (N, 3) theta - pi/2, phi, psi, rad.
        rates: (N, 3) of them, rad/s.
        body_rate: (N, 3) in body axes, rad/s.
        complete: whether it is valid for the whole time.
        resolved_until: until when the steps are short enough for the motion, s.
    """

    case: str
    time: np.ndarray
    angles: np.ndarray
    rates: np.ndarray
    body_rate: np.ndarray
    complete: bool
    resolved_until: float

    @property
    def failed(self) -> list[int]:
        """Axes whose torque fails."""
        return list(CASES[self.case])

    @property
    def valid_until(self) -> float:
        """Time of the last valid sample, s."""
        return float(self.time[-1])

    @property
    def end(self) -> np.ndarray:
        """(3,) angles at the end of validity, rad."""
        return self.angles[-1]

    def after(self, when: float) -> np.ndarray:
        """(N, 3) angles from a time, s, to the end of validity, rad."""
        return self.angles[self.time >= when - 1e-9]

    def frozen_rate(self) -> np.ndarray:
        """Body rate about the failed axes when they failed, rad/s."""
        return self.body_rate[round(FAILURE / STEP), self.failed]

    def frozen_rate_drift(self, until: float | None = None) -> float:
        """Largest change of that rate from then on, to `until` or the end of validity, rad/s."""
        last = self.valid_until if until is None else until
        span = (self.time >= FAILURE - 1e-9) & (self.time <= last + 1e-9)
        change = self.body_rate[span][:, self.failed] - self.frozen_rate()
        return float(np.max(np.abs(change), initial=0.0))


@eqx.filter_jit
def _continuous(law: Any, failing: Float[Array, "cases 3"], start: EulerState, count: int) -> Any:
    def single(times):
        body = TorqueDrivenBody(INERTIA, times)

        def step(carried, k):
            state, valid = carried
            after, clear, slip = body.carry(state, law, k * STEP, STEP)
            # comparisons with NaN are false
            finite = jnp.all(jnp.isfinite(jnp.stack(after)))
            still = valid & clear & finite & ~body.diverged(after) & (slip <= LOST)
            kept = jax.tree.map(lambda new, old: jnp.where(still, new, old), after, state)
            row = (state, state.body_rate(), valid, slip <= LARGEST_SLIP)
            return (kept, still), row

        return jax.lax.scan(step, (start, jnp.array(True)), jnp.arange(count + 1))[1]

    return jax.vmap(single)(failing)


def continuous(law: Any, duration: float = DURATION) -> dict[str, Flight]:
    """Fly all cases with a law that is evaluated at every stage of a Runge-Kutta step.

    Args:
        law: state -> torque, (3,), N·m.
        duration: s.

    Returns:
        A flight for each case.
    """
    count = round(duration / STEP)
    start = HEALTHY.start(ANGLES, RATES)
    state, rate, valid, fine = jax.tree.map(
        np.asarray, _continuous(law, jnp.asarray(failure_times()), start, count)
    )
    flights = {}
    for run, case in enumerate(CASES):
        last = int(np.sum(valid[run]))
        coarse = np.flatnonzero(~fine[run, :last])
        fields = [part[run, :last] for part in state]
        flights[case] = _flight(
            case,
            fields,
            rate[run, :last],
            complete=last == count + 1,
            resolved=STEP * (coarse[0] if len(coarse) else last - 1),
        )
    return flights


def _flight(
    case: str, fields: list[np.ndarray], rate: np.ndarray, *, complete: bool, resolved: float
) -> Flight:
    theta, phi, psi, *rates = fields
    return Flight(
        case=case,
        time=STEP * np.arange(len(theta)),
        angles=np.stack([theta - 0.5 * np.pi, phi, psi], axis=1),
        rates=np.stack(rates, axis=1),
        body_rate=rate,
        complete=complete,
        resolved_until=float(resolved),
    )


def held(law: Any, duration: float = DURATION) -> Mapping[str, Flight]:
    """Fly all cases with a law that is sampled, and held for 0.01 s; see `continuous`."""
    plants: Any = stack([TorqueDrivenBody(INERTIA, times) for times in failure_times()])
    flown: xr.Dataset = simulate(
        plants,
        TorqueOnAngles(law),
        EulerSensor(),
        start=HEALTHY.start(ANGLES, RATES),
        duration=duration,
        control_period=STEP,
        runs=len(CASES),
    )
    flights = {}
    for run, case in enumerate(CASES):
        one = flown.isel(run=run)
        last = round(float(one.valid_until) / STEP) + 1
        flights[case] = _flight(
            case,
            [one[name].values[:last] for name in EulerState._fields],
            one.body_rate.values[:last],
            complete=int(one.status) == 0,
            resolved=float(one.valid_until),
        )
    return flights
