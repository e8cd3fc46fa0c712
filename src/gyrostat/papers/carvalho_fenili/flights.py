"""Simulations of the 14 cases, with the law evaluated at every stage of a Runge-Kutta step."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.jax64 import jax, jnp
from gyrostat.papers.carvalho_fenili import setup
from gyrostat.papers.carvalho_fenili.torque_driven import LARGEST_SLIP, EulerState, TorqueDrivenBody

LOST = 100.0
"""Error of the rate change in one step, rad/s, at which a run ends."""
BAND, FROM = 0.05, 50.0
"""Angle, rad, and time, s: an angle is controlled if it stays this close to its goal from this time
on. Without a failure, both laws control all angles."""


@dataclass(frozen=True)
class Flight:
    """One run, up to the end of its validity.

    Attributes:
        case: Key of the case: which torques fail.
        time: Sample times, (N,), s.
        angles: theta - pi/2, phi, psi, (N, 3), rad.
        rates: Rates of the angles, (N, 3), rad/s.
        body_rate: Body rate in body axes, (N, 3), rad/s.
        complete: Whether the run is valid to its end.
        resolved_until: Time until which the steps are short enough for the motion, s.
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
        return list(setup.CASES[self.case])

    @property
    def valid_until(self) -> float:
        """Time of the last valid sample, s."""
        return float(self.time[-1])

    @property
    def end(self) -> np.ndarray:
        """Angles at the end of validity, (3,), rad."""
        return self.angles[-1]

    def excursion(self, angle: int) -> float:
        """Largest distance of an angle from its goal from `FROM` on, rad."""
        return float(np.max(np.abs(self.angles[self.time >= FROM - 1e-9, angle])))

    def stays(self, angle: int) -> bool:
        """Whether an angle stays within `BAND` of its goal while the run is valid."""
        return self.excursion(angle) <= BAND

    @property
    def controlled(self) -> bool:
        """Whether all angles are controlled to the end."""
        return self.complete and all(self.stays(angle) for angle in range(3))

    @property
    def excursions(self) -> str:
        """Sentence on the largest distances of the angles from their goals."""
        far = [f"{name} {self.excursion(k):.3g}" for k, name in enumerate(setup.ANGLE_NAMES)]
        span = f"from {FROM:g} s to {self.valid_until:.5g} s"
        return f"Largest distance from the goal {span}: {', '.join(far)} rad."

    def frozen_rate(self) -> np.ndarray:
        """Body rate about the failed axes at the failure, rad/s."""
        return self.body_rate[round(setup.FAILURE / setup.STEP), self.failed]

    def frozen_rate_drift(self, until: float) -> float:
        """Largest change of that rate between the failure and a time, s; rad/s."""
        span = (self.time >= setup.FAILURE - 1e-9) & (self.time <= until + 1e-9)
        change = self.body_rate[span][:, self.failed] - self.frozen_rate()
        return float(np.max(np.abs(change), initial=0.0))

    @property
    def frozen_argument(self) -> str:
        """Sentence on why no law can bring this body to rest, with the numbers of the run."""
        rates = [
            f"{rate:.5f} rad/s about {setup.AXES[axis]}"
            for axis, rate in zip(self.failed, self.frozen_rate(), strict=True)
        ]
        drift = self.frozen_rate_drift(self.resolved_until)
        return (
            f"I dw/dt = M freezes {' and '.join(rates)} from {setup.FAILURE:g} s on (changed by "
            f"{drift:.1g} rad/s in the run): no law can bring the body to rest."
        )

    @property
    def refuted(self) -> str:
        """Sentence of `frozen_argument`, followed by the errors at the end."""
        pairs = zip(setup.ANGLE_NAMES, self.end, strict=True)
        ends = ", ".join(f"{angle} {value:.3g}" for angle, value in pairs)
        return f"{self.frozen_argument} Errors at {self.valid_until:.5g} s: {ends} rad."

    def spread(self, until: float) -> float:
        """Root mean square of the three angles from the failure to a time, rad."""
        angles = self.angles[(self.time >= setup.FAILURE - 1e-9) & (self.time <= until + 1e-9)]
        return float(np.sqrt(np.mean(np.sum(angles**2, axis=1))))


Flights = Mapping[str, Mapping[str, Flight]]
"""Runs by law and case."""


@eqx.filter_jit
def _continuous(law: Any, failing: Float[Array, "cases 3"], start: EulerState, count: int) -> Any:
    def single(times):
        body = TorqueDrivenBody(setup.INERTIA, times)

        def step(carried, k):
            state, valid = carried
            after, clear, slip = body.carry(state, law, k * setup.STEP, setup.STEP)
            # comparisons with NaN are false
            finite = jnp.all(jnp.isfinite(jnp.stack(after)))
            still = valid & clear & finite & ~body.diverged(after) & (slip <= LOST)
            # a run that has ended stays where the Riccati equation converges fast
            next_state = jax.tree.map(lambda new, old: jnp.where(still, new, old), after, start)
            row = (state, state.body_rate(), valid, slip <= LARGEST_SLIP)
            return (next_state, still), row

        return jax.lax.scan(step, (start, jnp.array(True)), jnp.arange(count + 1))[1]

    return jax.vmap(single)(failing)


def flights(law: Any) -> dict[str, Flight]:
    """Simulate all cases with a law.

    Args:
        law: Function from the state to the torque, (3,), N·m.

    Returns:
        Run of each case.
    """
    count = round(setup.DURATION / setup.STEP)
    state, rate, valid, fine = jax.tree.map(
        np.asarray, _continuous(law, jnp.asarray(setup.failure_times()), setup.START, count)
    )
    runs = {}
    for run, case in enumerate(setup.CASES):
        length = int(np.sum(valid[run]))
        coarse = np.flatnonzero(~fine[run, :length])
        theta, phi, psi, *rates = (part[run, :length] for part in state)
        runs[case] = Flight(
            case=case,
            time=setup.STEP * np.arange(length),
            angles=np.stack([theta - 0.5 * np.pi, phi, psi], axis=1),
            rates=np.stack(rates, axis=1),
            body_rate=rate[run, :length],
            complete=length == count + 1,
            resolved_until=float(setup.STEP * (coarse[0] if len(coarse) else length - 1)),
        )
    return runs
