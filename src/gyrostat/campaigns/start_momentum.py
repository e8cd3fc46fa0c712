"""Momentum at the start of the runs against what the wheels can hold at rest."""

from collections.abc import Mapping, Sequence
from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from gyrostat.campaigns.draws import draw
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.text import plain
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.user_modules import is_user_kind
from gyrostat.failures.momentum_envelope import MOST_WHEELS, MomentumSet, largest
from gyrostat.scenario.kinds.events import kind_of
from gyrostat.scenario.kinds.orbits import nominal_orbit
from gyrostat.scenario.numbers import inertia_of
from gyrostat.scenario.scenario import AXES, Scenario

MOST_DRAWS = 1000
"""Largest number of draws whose momentum is computed."""
FIELD_POINTS = 256
"""Number of points of the orbit at which the magnetic field is evaluated."""


class MomentumRoom(NamedTuple):
    """What working wheels can hold, with the body at rest.

    Attributes:
        lost: Names of the wheels that do not work.
        every: Largest momentum that they hold in each attitude, in each draw, (draws,), N·m·s.
        axes: Unit axes of the working wheels, (3, wheels).
        limits: Momentum limits of the working wheels in each draw, (draws, wheels), N·m·s.
    """

    lost: tuple[str, ...]
    every: Vector
    axes: Matrix
    limits: Matrix

    def best(self, draw: int) -> float:
        """Largest momentum that they hold in the attitude that is best for it, N·m·s."""
        return largest(self.axes, self.limits[draw], np.zeros(3))


def start_momentum(scenario: Scenario, seed: int = 0, runs: int = MOST_DRAWS) -> Vector:
    """Size of the total momentum at the start of runs, N·m·s, one value without dispersions.

    Args:
        scenario: Scenario.
        seed: Seed of the draws.
        runs: Number of draws, of which the first `MOST_DRAWS` are used.
    """
    return _momenta(scenario, _draws(scenario, seed, runs))


def _draws(scenario: Scenario, seed: int, runs: int) -> list[dict[str, float]]:
    """Values of each draw, nominal ones without dispersions."""
    rows = np.zeros((1, 0))
    if scenario.dispersions:
        rows = draw(scenario, seed, np.arange(min(runs, MOST_DRAWS)))[0]
    return [{**scenario.values, **dict(zip(scenario.dispersed, row, strict=True))} for row in rows]


def _momenta(scenario: Scenario, draws: Sequence[Mapping[str, float]]) -> Vector:
    return np.array([float(np.linalg.norm(_momentum(scenario, values))) for values in draws])


def _momentum(scenario: Scenario, values: Mapping[str, float]) -> Vector:
    """Total momentum at the start in body axes, (3,), N·m·s."""
    axes = np.array(scenario.axes).T
    inertia, speed = (
        np.array([values[f"wheel.{wheel}.{name}"] for wheel in scenario.wheels])
        for name in ("inertia", "speed")
    )
    rate = np.array([values[f"start.rate.{axis}"] for axis in AXES])
    locked = inertia_of(values) + (axes * inertia) @ axes.T
    return locked @ rate + axes @ (inertia * speed)


def momentum_rooms(scenario: Scenario, seed: int = 0, runs: int = MOST_DRAWS) -> list[MomentumRoom]:
    """Room of all wheels, and of those that work after all events.

    It is empty if the wheels span no space, or if there are more than `MOST_WHEELS`.

    Args:
        scenario: Scenario.
        seed: Seed of the draws.
        runs: Number of draws, of which the first `MOST_DRAWS` are used.
    """
    return _rooms(scenario, _draws(scenario, seed, runs))


def _rooms(scenario: Scenario, draws: Sequence[Mapping[str, float]]) -> list[MomentumRoom]:
    wheels = scenario.wheels
    if len(wheels) > MOST_WHEELS:
        return []
    lost = [e.wheel for e in scenario.events if e.wheel is not None and kind_of(e).loses_wheel]
    axes = np.array(scenario.axes).T
    limits = np.array([[values[f"wheel.{w}.momentum_limit"] for w in wheels] for values in draws])
    rooms = []
    for gone in dict.fromkeys(((), tuple(sorted({*lost})))):
        works = np.array([wheel not in gone for wheel in range(len(wheels))])
        held = MomentumSet.of(axes[:, works], limits[0, works], np.zeros(3))
        if held.rank < 3 and not gone:
            return []
        every = np.zeros(len(limits))
        if held.rank == 3:
            every = np.min(held.supports_with(limits[:, works]), axis=-1)
        names = tuple(wheels[k] for k in gone)
        rooms.append(MomentumRoom(names, every, axes[:, works], limits[:, works]))
    return rooms


def largest_torque(scenario: Scenario) -> tuple[str, float]:
    """Actuator that takes momentum off the wheels or the body, and a bound of its torque, N·m.

    The name is empty without one; a bound is infinite where a controller of the user commands the
    actuator.
    """
    values = scenario.values
    laws = [part.kind for part in scenario.parts if part.section == "controller.law"]
    kinds = {part.kind for part in scenario.parts if part.section == "actuator"}
    uses_rods = scenario.unloading == "torque_rods" or "detumbling" in (scenario.controller, *laws)
    limit = values.get("controller.external_torque_limit", 0.0)
    if scenario.unloading == "thrusters":
        impulse = values["unloading.impulse"] / values["run.control_period"]
        couple = 2.0 * values["unloading.arm"] * values["unloading.force"]
        return "thrusters", float(np.sqrt(3.0)) * min(impulse, couple)
    if uses_rods:
        return "torque rods", _rod_torque(scenario)
    if limit > 0.0:
        return "external torques", float(np.sqrt(3.0)) * limit
    if kinds and any(map(is_user_kind, (scenario.controller, scenario.unloading, *laws))):
        return "actuators that your controller commands", inf
    return "", 0.0


def _rod_torque(scenario: Scenario) -> float:
    """Bound of the torque of the rods in the strongest field along the nominal orbit, N·m."""
    orbit = nominal_orbit(scenario)
    place = "actuator.torque_rods"
    limit = [scenario.values.get(f"{place}.limit.{axis}", inf) for axis in AXES]
    if orbit is None or not isfinite(sum(limit)):
        return inf
    times = jnp.linspace(0.0, scenario.duration, FIELD_POINTS)
    field = np.linalg.norm(np.asarray(jax.jit(jax.vmap(orbit.field))(times)), axis=1)
    return float(np.linalg.norm(limit) * scenario.values[f"{place}.duty"] * np.max(field))


def momentum_lines(
    scenario: Scenario, seed: int = 0, runs: int = MOST_DRAWS
) -> tuple[list[str], list[str]]:
    """Line on the momentum at the start and the wheels, and lines that say "cannot".

    Args:
        scenario: Scenario.
        seed: Seed of the draws.
        runs: Number of draws.
    """
    draws = _draws(scenario, seed, runs)
    rooms = _rooms(scenario, draws)
    if not rooms or not np.all(np.isfinite(rooms[0].every)):
        return [], []
    momentum = _momenta(scenario, draws)
    count = len(momentum)
    size = f"{'' if count == 1 else 'up to '}{plain(float(np.max(momentum)))} N·m·s"
    drawn = "" if count == 1 else f" in {count} draws"
    is_above = any(np.any(momentum > room.every) for room in rooms)
    name, torque = largest_torque(scenario) if is_above else ("", 0.0)
    holds, warnings = [], []
    for room in rooms:
        is_drawn = bool(np.ptp(room.every) > 0.0)
        without = f" without wheel {', '.join(room.lost)}" if room.lost else ""
        least = "at least " if is_drawn else ""
        holds.append(f"{least}{plain(float(np.min(room.every)))} N·m·s{without}")
        missing = momentum - room.every
        worst = int(np.argmax(missing))
        if missing[worst] <= 0.0:
            continue
        share = (
            "" if count == 1 else f" ({plain(100.0 * float(np.mean(missing > 0.0)), 3)} % above)"
        )
        found = f"momentum at the start: found {size}{drawn}{share}"
        every, best = float(room.every[worst]), room.best(worst)
        is_any = momentum[worst] > best
        attitude = "any attitude" if is_any else "every attitude"
        most = f"{plain(best if is_any else every)} N·m·s{' in the worst draw' if is_drawn else ''}"
        cannot = f"the wheels{without} cannot hold it in {attitude}, only {most}"
        time = float(missing[worst]) / torque if torque > 0.0 else inf
        if not name:
            text = "nothing takes it off them; expected less, or torque rods or thrusters"
        elif time > scenario.duration:
            text = f"{name} need {plain(time, 3)} s or more for the rest, longer than the run"
        else:
            holds[-1] += f" ({name} take {plain(time, 3)} s or more for the rest)"
            continue
        warnings.append(f"warning: {found}; {cannot}, and {text}")
    line = f"momentum at the start: {size}{drawn}; the wheels hold {', '.join(holds)}, at rest"
    return [line], warnings
