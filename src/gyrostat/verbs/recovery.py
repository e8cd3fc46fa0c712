"""Verb `recover`: the slew to a feasible attitude after wheel failures."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.verbs.arguments import (
    Named,
    Quantity,
    Say,
    in_si,
    named,
    numbers,
    one_attitude,
    silent,
    spacecraft_file,
)
from gyrostat.verbs.doubts import target_doubts
from gyrostat.verbs.failed_wheels import failures_of, in_words, losses_of, momenta_of
from gyrostat.verbs.required_options import require_options
from gyrostat.verbs.telemetry import TelemetryOptions

if TYPE_CHECKING:
    from gyrostat.failures import Recovery
    from gyrostat.spacecraft import Spacecraft, SpacecraftFile


def recover(
    spacecraft: "SpacecraftFile | Spacecraft | str | Path",
    failed: Named,
    wheels: str | Iterable[Quantity] | None = None,
    out: "str | Path | None" = None,
    *,
    brake: Named = None,
    attitude: str | Iterable[float] | None = None,
    attitude_euler: str | Iterable[Quantity] | None = None,
    rate: str | Iterable[Quantity] | None = None,
    telemetry: "str | Path | None" = None,
    target: str | Iterable[float] | None = None,
    euler: str | Iterable[Quantity] | None = None,
    duration: Quantity = 600.0,
    period: Quantity = 0.5,
    external_torque: str | Iterable[Quantity] | None = None,
    scalar_last: bool = False,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.recover",
) -> "Recovery":
    """Simulate the slew to the nearest feasible attitude after wheel failures.

    Args:
        spacecraft: Content or path of spacecraft.toml, or a spacecraft, whose wheels are named
            "0", "1" and so on.
        failed: Wheel -> None or "seized" (it stops), "frozen" (no torque, constant momentum),
            "rundown" or "rundown:TIME", or the momentum that a frozen wheel has in the telemetry
            too, N·m·s, or its speed with a unit.
        wheels: Momentum of every wheel at the failure, N·m·s, or speed with a unit.
        out: Folder for recover.json, run.nc and report.html; None writes no file.
        brake: Failed wheel -> what brakes it: the time constant of its short-circuited motor, s, or
            the torque with which the motor still brakes, N·m; as text with a unit.
        attitude: Attitude at the failure, quaternion (4,), scalar first. Give this or the next one.
        attitude_euler: Attitude at the failure, 3-1-3 angles (3,), rad.
        rate: Body rate at the failure, body axes, (3,), rad/s; zero by default.
        telemetry: Path of a file with attitude, rate and wheel speeds; see
            `gyrostat.verbs.telemetry`.
        target: Target attitude, quaternion (4,), scalar first. Give this or the next one.
        euler: Target attitude, 3-1-3 angles (3,), rad.
        duration: Duration of the simulation, s.
        period: Control period, s.
        external_torque: Constant external torque, body axes, (3,), N·m; zero by default.
        scalar_last: Whether quaternions have their scalar part last.
        force: Whether to replace files that gyrostat did not write.
        say: Function that receives each message for the user.
        command: Text that the report names as its origin.

    Returns:
        The recovery; `settle` is None if the spacecraft did not settle, and `reason` says why.

    Raises:
        InputError: A spacecraft, wheel or state cannot be used, or existing files would be
            replaced.
    """
    import numpy as np

    from gyrostat.core.outputs import check_outputs
    from gyrostat.failures import recover as simulate
    from gyrostat.failures import state_of
    from gyrostat.failures.query import unit_quaternion
    from gyrostat.reports.failure_inputs import Inputs
    from gyrostat.reports.recovery import FILES, write_recovery
    from gyrostat.scenario.unlikely import unlikely_spacecraft
    from gyrostat.simulation.labelled import Signal

    arguments = dict(locals())
    if out is not None:
        check_outputs(Path(out), FILES, by="recover", force=force)
    require_options("recover", arguments)
    file = spacecraft_file(spacecraft)
    options = {"--target": target, "--euler": euler}
    aim = unit_quaternion(one_attitude("target", options, scalar_last=scalar_last), "target")
    failures = failures_of(failed, file)
    source = TelemetryOptions(attitude, attitude_euler, rate, wheels, telemetry, scalar_last)
    state, doubts = source.read(file)
    doubts += target_doubts(target, euler, scalar_last=scalar_last)
    doubts += unlikely_spacecraft(file)
    torque = np.zeros(3)
    if external_torque is not None:
        torque = numbers(external_torque, 3, "torque", "--external-torque")
    losses = losses_of(failures, file, state, brake)
    start = state_of(file.spacecraft, state.attitude, state.rate, state.wheel_speed)
    failure_text = ", ".join(
        f"{name}{'' if how is None else f'={how}'}"
        for name, how in named(failed, "--failed", bare=True).items()
    )
    say(f"simulating {file.name or _source(spacecraft)} from the failure of {failure_text}")
    length, step = in_si(duration, "time", "--duration"), in_si(period, "time", "--period")
    recovery = simulate(
        file.spacecraft,
        start,
        losses,
        target=aim,
        duration=length,
        control_period=step,
        external_torque=torque,
    )
    histories = recovery.histories
    if histories is not None:
        names = Signal(("wheel",), np.array(file.wheel_names))
        histories = replace(histories, coordinates={**histories.coordinates, "wheel": names})
        recovery = replace(recovery, histories=histories)
    recovery = replace(recovery, case=(file, losses))
    if out is None:
        return recovery
    # a wheel that is braked ends at rest
    resting = {k: w for k, w in failures.items() if not losses[k].slows_down}
    momenta = dict.fromkeys(failures, 0.0) | momenta_of(resting, file, state)
    steps = []
    if isinstance(spacecraft, str | Path):
        from gyrostat.verbs.next_steps import Query, after_recover

        wheel_failures = named(failed, "--failed", bare=True)
        query = Query(
            *(spacecraft, wheel_failures, source, options, Path(out), named(brake, "--brake")),
            external_torque=external_torque,
        )
        total = state.total_momentum(file.spacecraft)
        by_name = {file.wheel_names[k]: value for k, value in momenta.items()}
        steps = after_recover(query, recovery, total, by_name, duration=length, period=step)
    inputs = Inputs(file.wheel_names, in_words(failures, file, momenta), aim, None, state, doubts)
    texts: dict[str, Any] = {"command": command, "say": say, "force": force}
    write_recovery(file, recovery, losses, Path(out), inputs=inputs, steps=steps, **texts)
    return recovery


def _source(spacecraft: object) -> str:
    """Path of a spacecraft, or its type if it has none, for a message."""
    return str(spacecraft) if isinstance(spacecraft, str | Path) else "the spacecraft"
