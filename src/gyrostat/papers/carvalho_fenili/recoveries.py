"""The paper's laws applied to wheels, and recovery after each failure.

The initial state is that of Table 2 with wheels at rest. The wheels absorb the momentum that they
give the body. The paper's law controls until the failure; then `gyrostat.failures.recover`, whose
law is notified of the failure, leads to the nearest feasible attitude.
"""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core import rotations
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.failures import Loss, Recovery, plan_recovery, recover
from gyrostat.papers.carvalho_fenili import setup
from gyrostat.papers.carvalho_fenili.figures import recovery_figure
from gyrostat.papers.carvalho_fenili.laws import laws
from gyrostat.papers.carvalho_fenili.torque_driven import EulerState
from gyrostat.papers.claims import Value
from gyrostat.papers.reproduction import Part, Run
from gyrostat.simulation import simulate, stack
from gyrostat.spacecraft import (
    Gyrostat,
    GyrostatState,
    Spacecraft,
    SpacecraftMeasurement,
    SpacecraftSensor,
    WheelFailures,
)
from gyrostat.spacecraft.gyrostat_state import WheelTorqueCommand

if TYPE_CHECKING:
    import xarray as xr

PERIOD = 0.1
"""Control period, s; the time constants of the laws are seconds."""
TARGET = np.array([np.cos(0.25 * np.pi), np.sin(0.25 * np.pi), 0.0, 0.0])
"""Attitude at phi = psi = 0, theta = pi/2: a quarter turn about x."""
LOSSES = {"frozen": Loss("frozen"), "seized": Loss("seized"), "rundown": Loss("rundown", 60.0)}
"""Kinds of failure: constant momentum, immediate stop, decay with 60 s."""
WITHOUT_REST = {**dict.fromkeys(("MxMy", "MxMz", "MyMz"), LOSSES), "My": ("frozen",)}
"""Recoveries with claims, by case: those that do not come to rest."""

Recoveries = Mapping[str, Mapping[str, Recovery]]
"""Recoveries by case and kind of loss."""


_BODY = (setup.INERTIA - setup.ROTOR) * jnp.eye(3)
CRAFT = Spacecraft(_BODY, setup.wheels_along_axes(np.inf, np.inf))
LIMITED = Spacecraft(_BODY, setup.wheels_along_axes())
"""The body of the paper with wheels, without and with limits."""


def _nearest(angle: Scalar, before: Scalar) -> Scalar:
    """Angle plus whole turns that is nearest to another angle."""
    return angle + 2.0 * jnp.pi * jnp.round((before - angle) / (2.0 * jnp.pi))


class WheelsOnAngles(eqx.Module):
    """A law of the paper that commands wheels: the rotor torque is the negative body torque.

    Attributes:
        law: Function from state to body torque.
    """

    law: Any

    def start(self, period: Scalar) -> tuple[Any, Any]:
        """Angles phi and psi of Table 2."""
        return jnp.asarray(setup.ANGLES.phi), jnp.asarray(setup.ANGLES.psi)

    def __call__(
        self, memory: tuple[Any, Any], measurement: SpacecraftMeasurement
    ) -> tuple[tuple[Any, Any], WheelTorqueCommand]:
        """Command; phi and psi are never reduced by whole turns."""
        angles, _ = rotations.to_euler(measurement.attitude)
        rates, _ = rotations.euler_rates(angles, measurement.rate)
        phi, psi = _nearest(angles.phi, memory[0]), _nearest(angles.psi, memory[1])
        state = EulerState(angles.theta, phi, psi, rates.theta, rates.phi, rates.psi)
        return (phi, psi), WheelTorqueCommand(-self.law(state))


class EitherLaw(eqx.Module):
    """Either law of the paper, so that a batch of runs can have both in one compiled program.

    Attributes:
        dependent: Whether SDRE commands, otherwise LQR.
    """

    dependent: Bool[Array, ""] | np.ndarray

    def __call__(self, state: EulerState) -> Vector3:
        """Commanded torque, N·m."""
        # made here: the weights of SDRE must have no axis of runs
        law_by_name = laws()
        return jnp.where(self.dependent, law_by_name["sdre"](state), law_by_name["lqr"](state))


def start() -> GyrostatState:
    """Initial state of Table 2, with wheels at rest."""
    return Gyrostat(CRAFT).start(
        attitude=rotations.from_euler(setup.ANGLES),
        rate=rotations.rate_of_euler(setup.ANGLES, setup.RATES),
    )


def failing(case: str, time: float = setup.FAILURE) -> Gyrostat:
    """Spacecraft without wheel limits; the wheels of a case lose their torque at a time, s."""
    return setup.without_torques(CRAFT, setup.CASES[case], time)


def fly_on_wheels(
    law: Any,
    plants: list[Gyrostat],
    duration: float,
    *,
    each: bool = False,
    begin: GyrostatState | None = None,
) -> "xr.Dataset":
    """Simulate the body with wheels, one run for each plant.

    Args:
        law: Function from state to body torque, (3,), N·m.
        plants: Spacecraft.
        duration: Duration, s.
        each: Whether `law` is a list with one law for each plant.
        begin: Initial state; None for that of Table 2.
    """
    every: Any = stack(plants)
    controller: Any = stack([WheelsOnAngles(item) for item in law]) if each else WheelsOnAngles(law)
    return simulate(
        every,
        controller,
        SpacecraftSensor(Gyrostat(CRAFT)),
        start=start() if begin is None else begin,
        duration=duration,
        control_period=PERIOD,
        runs=len(plants),
        stored=True,
    )


def recovered(onset: GyrostatState, cases: Mapping[str, Collection[str]]) -> Recoveries:
    """Simulate recoveries from failures.

    Args:
        onset: State at the failure.
        cases: Kinds of loss for each case.
    """
    return {
        case: {
            kind: recover(
                LIMITED,
                onset,
                dict.fromkeys(setup.CASES[case], LOSSES[kind]),
                target=TARGET,
                duration=600.0,
            )
            for kind in kinds
        }
        for case, kinds in cases.items()
    }


def without_limits(state: GyrostatState) -> Mapping[str, str]:
    """Case -> description of the feasible attitude, in a run without limits before the failure.

    Args:
        state: State at the failure in the run without limits.
    """
    momenta = setup.ROTOR * np.asarray(state.wheel_speed + Gyrostat(CRAFT).rate(state))
    texts = {}
    for case in WITHOUT_REST:
        wheel_momenta = {wheel: float(momenta[wheel]) for wheel in setup.CASES[case]}
        plan = plan_recovery(LIMITED, state.momentum, failed=wheel_momenta, target=TARGET)
        angle = plan.answer.angle
        texts[case] = "none" if angle is None else f"one at {np.degrees(angle):.4g} deg"
    return texts


def before_failure(run: Run) -> "Mapping[str, xr.Dataset]":
    """Runs with healthy wheels up to the time of the failure, by law: run 0 without limits, 1 with.

    Both laws are in one batch, because compiling takes longer than simulating.
    """
    run.say("simulating healthy wheels until the failure under each law")
    run_laws = [EitherLaw(np.array(law == "sdre")) for law in setup.LAWS for _ in range(2)]
    healthy = [Gyrostat(craft, WheelFailures.none(3)) for craft in (CRAFT, LIMITED)]
    histories = fly_on_wheels(run_laws, 2 * healthy, setup.FAILURE, each=True)
    return {law: histories.isel(run=slice(2 * k, 2 * k + 2)) for k, law in enumerate(setup.LAWS)}


def at_failure(flown: "xr.Dataset") -> tuple[GyrostatState, GyrostatState]:
    """States at the end of the runs of a law, without and with limits; see `before_failure`."""
    final = [flown[name].values[:, -1] for name in GyrostatState._fields[:3]]
    unlimited, limited = (GyrostatState(*(jnp.asarray(x[k]) for x in final)) for k in range(2))
    return unlimited, limited


def without_rest(run: Run) -> Part:
    """Failures after which the body does not come to rest."""
    values: dict[str, Value] = {}
    facts: dict[str, Any] = {"recover": {}, "free": {}}
    for law, histories in run.once(before_failure).items():
        run.say(f"recovery after each failure under {law.upper()}")
        unlimited, limited = at_failure(histories)
        recoveries = recovered(limited, WITHOUT_REST)
        facts["recover"][law], facts["free"][law] = recoveries, without_limits(unlimited)
        for case, kinds in recoveries.items():
            for kind, recovery in kinds.items():
                values[f"recover.{law}.{case}.{kind}.settle_s"] = recovery.settle
            angle = kinds["frozen"].plan.answer.angle
            degrees = None if angle is None else float(np.degrees(angle))
            values[f"recover.{law}.{case}.frozen.nearest_deg"] = degrees
    return Part(values, facts)


def every_recovery(run: Run) -> Part:
    """All recoveries, and the end of one run with wheels and without recovery."""
    run.say("simulating all recoveries")
    healthy = run.once(before_failure)
    recoveries = {
        law: recovered(at_failure(dataset)[1], dict.fromkeys(setup.FAILING, LOSSES))
        for law, dataset in healthy.items()
    }
    histories = fly_on_wheels(laws()["lqr"], [failing("MxMy")], setup.DURATION)
    attitude = jnp.asarray(histories.attitude.values[0, -1])
    error = float(rotations.error_angle(attitude, jnp.asarray(TARGET)))
    return Part({"gyrostat.lqr.MxMy.pointing_error": error}, {}, (recovery_figure(recoveries),))
