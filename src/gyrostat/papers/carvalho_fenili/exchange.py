"""The same 14 cases on a body with wheels, which take up the momentum that they give the body."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat._jax import jnp
from gyrostat.body import (
    EulerAngles,
    EulerState,
    Gyrostat,
    GyrostatState,
    Spacecraft,
    SpacecraftMeasurement,
    SpacecraftSensor,
    WheelFailures,
    rotations,
)
from gyrostat.body.gyrostat import FASTEST
from gyrostat.body.torque_driven import LEAST_SINE
from gyrostat.friction import Scalar
from gyrostat.papers.carvalho_fenili.printed import (
    ANGLES,
    CASES,
    DURATION,
    FAILURE,
    INERTIA,
    LAWS,
    RATES,
    failure_of,
)
from gyrostat.papers.claims import Claim
from gyrostat.simulate import simulate, stack
from gyrostat.wheel import WheelArray

if TYPE_CHECKING:
    import xarray as xr

ROTOR = 0.01
"""kg·m², of each rotor about its axis: 3 N·m·s at 2900 rpm."""
PERIOD = 0.1
"""s, of control: the laws' own time constants are seconds."""
TARGET = EulerAngles(phi=0.0, theta=0.5 * np.pi, psi=0.0)
TORQUE, MOMENTUM = 0.1, 3.0
"""N·m and N·m·s, of each wheel where limits act."""


def _craft(torque: float, momentum: float) -> Spacecraft:
    wheels = WheelArray(
        axes=jnp.eye(3),
        inertia=jnp.full(3, ROTOR),
        torque_limit=jnp.full(3, torque),
        momentum_limit=jnp.full(3, momentum),
    )
    return Spacecraft(inertia=(INERTIA - ROTOR) * jnp.eye(3), wheels=wheels)


CRAFT, LIMITED = _craft(np.inf, np.inf), _craft(TORQUE, MOMENTUM)
SETTINGS = (
    f"Gyrostat: three wheels along x, y and z at rest at first, rotors of {ROTOR:g} kg·m²; with "
    "the rotors locked the body has the paper's inertia; no limits and no friction, as in the "
    f"paper; laws sampled each {PERIOD:g} s, rotor torque -M; a wheel that fails loses its torque "
    f"at {FAILURE:g} s and keeps its momentum.",
)


class AngleCommand(NamedTuple):
    """Motor torques, and the angles that they were computed from.

    Attributes:
        torque: (3,) of the motors, N·m.
        theta: rad.
        phi: rad, never reduced by whole turns.
        psi: rad, never reduced by whole turns.
        lawful: whether the angles have been clear of their singularity so far.
    """

    torque: Float[Array, "3"]
    theta: Scalar
    phi: Scalar
    psi: Scalar
    lawful: Bool[Array, ""]

    UNITS = {"torque": "N·m", "theta": "rad", "phi": "rad", "psi": "rad"}  # noqa: RUF012


def _nearest(angle: Scalar, before: Scalar) -> Scalar:
    """The angle, whole turns added, that is nearest to another."""
    return angle + 2.0 * jnp.pi * jnp.round((before - angle) / (2.0 * jnp.pi))


class WheelsOnAngles(eqx.Module):
    """A law of the paper that commands wheels: the rotor torque is the body torque's opposite.

    Once the angles have come to their singularity the law has ended, and the motors rest.

    Attributes:
        law: state -> body torque.
    """

    law: Any

    def start(self, period: Scalar) -> tuple[Any, Any, Any]:
        """Angles phi and psi of Table 2, and that the law is in force."""
        return jnp.asarray(ANGLES.phi), jnp.asarray(ANGLES.psi), jnp.array(True)

    def __call__(
        self, memory: tuple[Any, Any, Any], measurement: SpacecraftMeasurement
    ) -> tuple[tuple[Any, Any, Any], AngleCommand]:
        """Command."""
        phi, psi, lawful = memory
        angles, _ = rotations.to_euler(measurement.attitude)
        rates, _ = rotations.euler_rates(angles, measurement.rate)
        phi, psi = _nearest(angles.phi, phi), _nearest(angles.psi, psi)
        state = EulerState(angles.theta, phi, psi, rates.theta, rates.phi, rates.psi)
        torque = -self.law(state)
        lawful = lawful & (jnp.sin(angles.theta) >= LEAST_SINE) & jnp.all(jnp.isfinite(torque))
        torque = jnp.where(lawful, torque, 0.0)
        command = AngleCommand(torque, angles.theta, phi, psi, lawful)
        return (phi, psi, lawful), command


@dataclass(frozen=True)
class Exchange:
    """One run on wheels, as far as the angles are valid.

    Attributes:
        case: which wheels fail.
        time: (N,) s.
        angles: (N, 3) theta - pi/2, phi, psi, rad.
        body_rate: (N, 3) rad/s.
        wheel_momentum: (N, 3) relative to the body, N·m·s.
        pointing_error: angle to the target attitude at the end, rad.
        spun_up: whether it ends because the body turns too fast for any law.
    """

    case: str
    time: np.ndarray
    angles: np.ndarray
    body_rate: np.ndarray
    wheel_momentum: np.ndarray
    pointing_error: float
    spun_up: bool


def start() -> GyrostatState:
    """Table 2, wheels at rest."""
    return Gyrostat(CRAFT).start(
        attitude=rotations.from_euler(ANGLES), rate=rotations.rate_of_euler(ANGLES, RATES)
    )


def flown_on_wheels(law: Any) -> "xr.Dataset":
    """Fly Table 2 on wheels.

    Args:
        law: state -> body torque, (3,), N·m.

    Returns:
        Histories, `run` the case; and "limited", in which nothing fails but limits act.
    """
    plants: list[Any] = []
    for failed in CASES.values():
        failures = WheelFailures.none(3)
        for wheel in failed:
            failures = failures.torque_lost(wheel, FAILURE)
        plants.append(Gyrostat(CRAFT, failures))
    plants.append(Gyrostat(LIMITED, WheelFailures.none(3)))
    every: Any = stack(plants)
    flown = simulate(
        every,
        WheelsOnAngles(law),
        SpacecraftSensor(Gyrostat(CRAFT)),
        start=start(),
        duration=DURATION,
        control_period=PERIOD,
        runs=len(plants),
    )
    return flown.assign_coords(run=[*CASES, "limited"])


def exchanged(flown: "xr.Dataset") -> Mapping[str, Exchange]:
    """The cases, each as far as it is valid.

    Args:
        flown: of `flown_on_wheels`.
    """
    target = rotations.from_euler(TARGET)
    runs = {}
    for case in CASES:
        one = flown.sel(run=case)
        lawful, followed = int(one.lawful.sum()), round(float(one.valid_until) / PERIOD) + 1
        last = min(lawful, followed)
        attitude = jnp.asarray(one.attitude.values[last - 1])
        runs[case] = Exchange(
            case=case,
            time=one.time.values[:last],
            angles=np.stack([one.theta - 0.5 * np.pi, one.phi, one.psi], axis=1)[:last],
            body_rate=one.rate.values[:last],
            wheel_momentum=one.wheel_momentum.values[:last],
            pointing_error=float(rotations.error_angle(attitude, target)),
            spun_up=int(one.status) != 0 and followed <= lawful,
        )
    return runs


def exchange_claims(runs: Mapping[str, Mapping[str, Exchange]]) -> tuple[Claim, ...]:
    """The ends of all runs, by law and case."""
    return tuple(
        claim
        for law, flown in runs.items()
        for case, run in flown.items()
        for claim in _claims(law, case, run)
    )


def _claims(law: str, case: str, run: Exchange) -> list[Claim]:
    of = f"on wheels, {LAWS[law]}, {failure_of(case)}"
    until = float(run.time[-1])
    ended = f"Ends at {until:.1f} s in the singularity of the angles, sin(theta) < {LEAST_SINE:g}."
    if run.spun_up:
        ended = f"It spins up, and ends at {until:.1f} s beyond {FASTEST:g} rad/s."
    elif until >= DURATION - 0.5 * PERIOD:
        ended = f"Valid to {until:g} s."
    kept = [f"{run.wheel_momentum[-1, wheel]:.4f} N·m·s" for wheel in CASES[case]]
    still = f" Kept by what failed: {', '.join(kept)}." if kept else ""
    rate = float(np.linalg.norm(run.body_rate[-1]))
    rows = (
        ("theta_error", "theta - pi/2", float(run.angles[-1, 0]), "rad", ended),
        ("phi", "phi", float(run.angles[-1, 1]), "rad", ended),
        ("psi", "psi", float(run.angles[-1, 2]), "rad", ended),
        ("valid_until_s", "end of validity", until, "s", ended),
        ("body_rate", "body rate at the end", rate, "rad/s", f"{ended}{still}"),
        ("pointing_error", "angle to the target at the end", run.pointing_error, "rad", ended),
    )
    return [
        Claim(f"gyrostat.{law}.{case}.{key}", f"{what}, {of}", value, unit, why)
        for key, what, value, unit, why in rows
    ]
