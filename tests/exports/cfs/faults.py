"""A flight with every fault that the application must survive, and what is expected of it.

The expected pointing is that of the simulation in Python, whose guard is given NaN where the
application has no valid sample. The expected housekeeping is counted here from the script.
"""

from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np

from gyrostat.control import AttitudePID, EstimatingCompensator, Guarded, MeasurementGuard
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import RPM
from gyrostat.exports import targets
from gyrostat.exports.cfs import application
from gyrostat.simulation import simulate
from gyrostat.spacecraft import AirBearingTable, Gyro, TableMeasurement, TableSensors
from gyrostat.wheel import Driver, Tachometer, Wheel
from gyrostat.wheel.friction import Stribeck

PERIOD, SEED, TICKS, TIMEOUT = 0.1, 3, 400, 5
GAIN = 0.0571
NEAR = 1e-9  # rad, A

Step = tuple[int, str, str]
"""Tick, action of the test application, argument."""

LOST = {
    "lost": (),
    "short": ("LengthErrors",),
    "long": ("LengthErrors",),
    "id": ("MessageIdErrors",),
    "checksum": ("ChecksumErrors",),
    "stale": ("StaleSamples",),
    "ahead": ("StaleSamples",),
    "order": ("StaleSamples",),
    "repeated": ("RepeatedSamples",),
}
"""Action in place of a sample -> counters of the rejected message."""
EVENT_OF = {
    "LengthErrors": 1,
    "MessageIdErrors": 2,
    "ChecksumErrors": 3,
    "StaleSamples": 4,
    "RepeatedSamples": 4,
    "Samples[2]": 5,
    "SensorTimeouts": 6,
    "TableErrors": 7,
    "TableLoadsInTick": 8,
}
"""Counter -> id of its limited event."""

SCRIPT: tuple[Step, ...] = (
    (0, "stale", "-"),  # no sample before it: its age alone
    (10, "short", "-"),
    (20, "long", "-"),
    (30, "id", "-"),
    (40, "checksum", "-"),
    (50, "nan", "-"),
    (60, "ahead", "-"),
    (70, "order", "-"),
    (80, "repeated", "-"),
    (90, "garbage", "5"),
    *((tick, "lost", "-") for tick in range(100, 107)),
    (107, "stale", "-"),
    (108, "clock", "-5"),  # set back during the time-out: the next samples are older than the last
    (120, "noop", "-"),
    (121, "command_length", "-"),
    (122, "command_code", "-"),
    (123, "command_checksum", "-"),
    (130, "reset_controller", "-"),
    (140, "load", "second"),
    (141, "activate", "-"),
    (160, "load", "wide"),
    (161, "refused", "-"),
    (165, "load", "narrow"),
    (166, "refused", "-"),
    (170, "load", "not_finite"),
    (171, "refused", "-"),
    (180, "overwrite", "nan"),
    (190, "in_tick_load", "third"),
    (195, "in_tick_activate", "-"),
    (205, "in_tick_overwrite", "1e9"),
    (210, "wakeup_length", "-"),
    (220, "reset_counters", "-"),
    (230, "short", "-"),
    *((tick, "checksum", "-") for tick in range(240, 250)),
    (270, "restart", "-"),
    (330, "restart_shared", "-"),  # the table of an application that shares it stays registered
)
RESTARTS = ("restart", "restart_shared")
GOOD = {"second": 1.5 * GAIN, "third": 0.5 * GAIN}
BAD = {"wide": 11.0 * GAIN, "narrow": 0.05 * GAIN, "not_finite": np.nan}
TABLES = GOOD | BAD
"""Name of a table -> proportional gain."""


class Case(NamedTuple):
    """The air-bearing table with a compensator that assumes 3 % less friction.

    Attributes:
        plant: Table with its wheel.
        sensors: Gyro and tachometer, with noise.
        compensator: Compensator with a period of delay.
        start: State at time 0; the wheel passes zero after some 100 s.
    """

    plant: Any
    sensors: Any
    compensator: Any
    start: Any

    @classmethod
    def make(cls) -> "Case":
        """Case with the wheel and gains of Carrara and Kuga."""
        curve = (4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879)
        wheel = Wheel(1.5e-3, 0.0228, Stribeck(*curve))
        rubs = Stribeck(curve[0], 1.03 * curve[1], 1.03 * curve[2], curve[3])
        truth = Wheel(1.5e-3, 0.0228, rubs)
        plant = AirBearingTable(0.495, truth, Driver(current_limit=0.5), 0.46e-3)
        sensors = TableSensors(Gyro(sigma=np.radians(0.002)), Tachometer(sigma=5.0 * RPM))
        law = AttitudePID(GAIN, 0.00234, 0.3126)
        tuned = EstimatingCompensator.tune(law, wheel, 0.495, 5.0 * RPM, PERIOD, delay=1)
        return cls(plant, sensors, tuned, plant.start(attitude=0.01, speed=-290.0 * RPM))

    def texts(self, precision: Any = "double") -> dict[str, str]:
        """Files of the exported application."""
        texts = application(targets.compensator(self.compensator, PERIOD), precision, "A test.")
        return {name.removeprefix("compensator/"): text for name, text in texts.items()}

    def parameters(self) -> Any:
        """Compensator and guard, as the table contains them."""
        return targets.compensator(self.compensator, PERIOD).begin[0].function()

    def flight(self, flights: Any) -> Any:
        """Flight in C; the argument is the module flights.py."""
        parts = (self.plant, self.sensors, self.compensator, self.start)
        recorded = ("state.attitude", "command.current")
        return flights.Flight("compensator", *parts, PERIOD, 1, "attitude", recorded)

    def simulated(self, controller: Any, ticks: int, engine: str = "native") -> Any:
        """Simulation in Python."""
        return simulate(
            self.plant,
            controller,
            self.sensors,
            start=self.start,
            duration=ticks * PERIOD,
            control_period=PERIOD,
            command_delay=1,
            seed=SEED,
            engine=engine,
        )


class Scheduled(eqx.Module):
    """Guarded compensator with the script of faults.

    Attributes:
        compensator: Compensator as it was designed.
        gain: Proportional gain in each tick.
        lost: Whether a tick has no valid sample.
        starts: Whether the memory is that of the start.
    """

    compensator: Any
    gain: Any
    lost: Any
    starts: Any

    def _guarded(self, k: Any) -> Guarded:
        tuned = eqx.tree_at(lambda c: c.law.proportional, self.compensator, self.gain[k])
        return Guarded(tuned, MeasurementGuard.of(TableMeasurement(0.0, 0.0, 0.0)))

    def start(self, period: Any) -> Any:
        """Tick, memory and period."""
        return jnp.array(0), self._guarded(0).start(period), jnp.asarray(period)

    def __call__(self, memory: Any, measurement: Any) -> Any:
        """Command of a tick."""
        k, inner, period = memory
        first = self._guarded(0).start(period)
        inner = jax.tree.map(lambda a, b: jnp.where(self.starts[k], a, b), first, inner)
        missing = jax.tree.map(lambda x: jnp.where(self.lost[k], jnp.nan, x), measurement)
        inner, command = self._guarded(k)(inner, missing)
        return (k + 1, inner, period), command


def expected(case: Case, script: Iterable[Step], ticks: int) -> Any:
    """Simulation of a flight with a script."""
    gain, now, active = np.full(ticks + 1, GAIN), GAIN, GAIN
    lost, starts = np.zeros(ticks + 1, bool), np.zeros(ticks + 1, bool)
    for tick, action, name in script:
        now = TABLES.get(name, now)
        lost[tick] |= action in LOST or action == "nan"
        starts[tick] |= action in ("reset_controller", *RESTARTS)
        if action in ("activate", "in_tick_activate", *RESTARTS):
            active = GAIN if action in RESTARTS else now
            gain[tick + (action == "in_tick_activate") :] = active
    controller = Scheduled(case.compensator, *map(jnp.asarray, (gain, lost, starts)))
    return case.simulated(controller, ticks)


def counters(script: Iterable[Step], ticks: int) -> tuple[list[Counter], Counter, dict[int, int]]:
    """Housekeeping that each tick sends, that after the last one, and the events: id -> number."""
    by_tick: dict[int, list[Step]] = {}
    for step in script:
        by_tick.setdefault(step[0], []).append(step)
    counts: Counter = Counter(TableLoads=1)
    sent, run, rows = Counter(), 0, []
    since_reset: Counter = Counter()

    def count(*names: str) -> None:
        for name in names:
            counts[name] += 1
            event = EVENT_OF.get(name)
            if event is not None:
                sent[event] += since_reset[event] % 64 == 0
                since_reset[event] += 1

    for tick in range(ticks):
        actions = [(action, argument) for _, action, argument in by_tick.get(tick, [])]
        for action, _ in actions:  # before the request of housekeeping
            if action in RESTARTS:
                count("LengthErrors")  # the message that wakes it up, to end
                counts.clear()
                since_reset.clear()
                run, name = 0, "TableLoads" if action == "restart" else "TableServiceErrors"
                counts[name] += 1
            elif action == "reset_counters":
                counts.clear()
                since_reset.clear()
                sent[11] += 1
            elif action == "wakeup_length":
                count("LengthErrors")
            elif action in ("noop", "reset_controller"):
                count("CommandCounter", *["ControllerResets"] * (action != "noop"))
                sent[11] += 1
            elif action.startswith("command_"):
                reason = {"length": "LengthErrors", "checksum": "ChecksumErrors"}
                names = [reason[part] for part in reason if action.endswith(part)]
                count("CommandErrorCounter", *names)
                sent[12] += action == "command_code"
        rows.append(counts.copy())
        names = ["Ticks"]
        rejected = [LOST[action] for action, _ in actions if action in LOST]
        for action, argument in actions:
            names += ["TableLoads"] * (action == "activate")
            names += ["TableErrors"] * (argument in BAD or action == "overwrite")
            names += ["TableLoadsInTick"] * (action in ("in_tick_load", "in_tick_activate"))
            if action == "garbage":
                names += [("ChecksumErrors", "LengthErrors")[k % 2] for k in range(int(argument))]
        for _, action, _ in by_tick.get(tick - 1, []):
            names += ["TableLoads"] * (action == "in_tick_activate")
            names += ["TableErrors"] * (action == "in_tick_overwrite")
        count(*names, *(name for reasons in rejected for name in reasons))
        is_nan = any(action == "nan" for action, _ in actions)
        run = run + 1 if rejected else 0
        if rejected:
            count("MissingSamples", *["SensorTimeouts"] * (run == TIMEOUT))
        else:
            count("Samples[2]" if is_nan else "Samples[0]")
    return rows, counts, {event: number for event, number in sent.items() if number}


def table_size(case: Case) -> int:
    """Size of the table of the compensator, bytes; all its numbers are real."""
    return 8 * sum(np.size(leaf) for leaf in jax.tree.leaves(case.parameters()))


def write_tables(folder: Path, size: int) -> None:
    """Write the tables of the script beside the one of the build.

    Args:
        folder: Folder of the files of the flight system.
        size: Size of the table, bytes; its first number is the proportional gain.
    """
    content = (folder / "compensator.tbl").read_bytes()
    head, numbers = content[:-size], np.frombuffer(content[-size:])
    assert numbers[0] == GAIN
    for name, gain in TABLES.items():
        changed = np.concatenate([[gain], numbers[1:]])
        (folder / f"{name}.tbl").write_bytes(head + changed.tobytes())


def script_text(script: Iterable[Step], ticks: int) -> str:
    """Text of the script for the test application."""
    return "".join([f"{ticks}\n", *(f"{tick} {action} {name}\n" for tick, action, name in script)])


def fly_case(mission: Any, flight: Any, folder: Path, script: Any, ticks: int) -> Any:
    """Fly a script; rows of each tick, last housekeeping, events."""
    (folder / "compensator.script").write_text(script_text(script, ticks), encoding="utf-8")
    flight.noise(jax.random.key(SEED), ticks + 1).tofile(folder / "compensator.noise")
    mission.fly(folder, ["compensator"])
    return (*flight.rows(folder, ticks), flight.events(folder))


def differences(case: Case, flown: Any, script: Any, ticks: int, names: Iterable[str]) -> list[str]:
    """What differs between a flight and what is expected of it, as text; empty if nothing does."""
    rows, last, events = flown
    history = expected(case, script, ticks)
    counts, final, sent = counters(script, ticks)
    found = []
    error = np.abs(rows["state.attitude"] - history.attitude.values[:ticks])
    if not np.all(error <= NEAR):
        found.append(f"attitude: {np.max(error)} rad")
    # the command acts a period later
    error = np.abs(rows["command.current"][:-1] - history.commanded_current.values[1:ticks])
    if not np.all(error <= NEAR):
        found.append(f"current: {np.max(error)} A")
    computed = history.sample_status.values[:ticks]
    for name, signal in (("status", computed), ("missed", history.samples_missed.values[:ticks])):
        if not np.array_equal(rows[name], signal):
            found.append(f"{name}: tick {np.argmax(rows[name] != signal)}")
    for name in names:
        if name in ("WakeupTimeouts", "SampleStatus", "SamplesMissed"):
            continue  # the first depends on the machine, the others are in each command
        wanted = np.array([count[name] for count in counts])
        if not np.array_equal(rows[name], wanted):
            found.append(f"{name}: tick {np.argmax(rows[name] != wanted)}")
        if last[name] != final[name]:
            found.append(f"{name}: {last[name]} at the end")
    if last["WakeupTimeouts"] < 1:
        found.append("WakeupTimeouts: 0 without wake-ups")
    limited = {event: events.get(event, 0) for event in range(1, 9)}
    wanted_events = {event: sent.get(event, 0) for event in range(1, 9)}
    if limited != wanted_events:
        found.append(f"events: {limited}, expected {wanted_events}")
    return found
