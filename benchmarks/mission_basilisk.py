"""The Earth observation mission without friction beside Basilisk: trajectories and times.

    python benchmarks/mission_basilisk.py --basilisk PYTHON [--steps 0.25,0.125,0.0625]

PYTHON is an interpreter with Basilisk (bsk). Three parts:

Trajectories: the nominal mission without wheel friction, noise and failure is simulated here, with
its controller. Basilisk replays the recorded motor torques and dipole moments in open loop, with
its own spacecraft, reaction wheels, torque rods, gravity gradient, drag and solar pressure, and
with the orbit, Sun, field, density and wind of the same tables. So the plants are compared, and no
feedback hides a difference. The solar irradiance is Basilisk's on both sides.

Times: processor time of a dispersed run here (native engine, 64 runs on one core, after compiling)
with its controller, and of a run of Basilisk with its own environment and flight software in nadir
pointing, all compiled, after its set-up.

Exits with 1 if the attitudes at the shortest step differ by more than 1e-6 rad. Takes minutes: two
programs are compiled.
"""

import argparse
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import gyrostat as gs
from gyrostat.campaigns.engine import fly
from gyrostat.campaigns.ready import prepare
from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp
from gyrostat.scenario.build_spacecraft import spacecraft_of
from gyrostat.scenario.kinds.orbits import planned_orbit
from gyrostat.scenario.structure import structure_of
from gyrostat.spacecraft import AerodynamicTorque
from gyrostat.spacecraft.orbit.earth import EARTH, EARTH_RADIUS

MISSION = Path(__file__).parents[1] / "examples" / "missions" / "earth_observation"
PEER = Path(__file__).with_name("basilisk_mission.py")
LARGEST = 1e-6
"""Largest difference of the attitudes, rad."""
RUNS, REPEATS = 64, 5
FLUX = 1368.0 / 1361.0
"""Basilisk's solar irradiance over that of this package."""
FRICTIONLESS = {
    r"^event = [^\n]*\n": "",
    r"^  \{ key = \"(event|wheel)\.[^\n]*\n": "",
    r"^\[compensator\].*?(?=^\[\[sensor\]\])": '[sensors]\nkind = "white_noise"\n',
    r"^sigma = [^\n]*\n": "",
    r'kind = "solar_pressure"': f'kind = "solar_pressure", scale = {FLUX!r}',
}
"""Pattern -> replacement in mission.toml: no seizure, no friction, no noise."""


def frictionless(folder):
    """Mission without friction, noise and failure, in a folder."""
    for path in MISSION.iterdir():
        if path.is_file():
            (folder / path.name).write_text(path.read_text(encoding="utf-8"), encoding="utf-8")
    text = (folder / "mission.toml").read_text(encoding="utf-8")
    for pattern, new in FRICTIONLESS.items():
        text, count = re.subn(pattern, new, text, flags=re.MULTILINE | re.DOTALL)
        assert count, pattern
    (folder / "mission.toml").write_text(text, encoding="utf-8")
    craft = (folder / "satellite.toml").read_text(encoding="utf-8")
    craft = craft.replace('model = "wheel.toml"', "inertia = 4.4e-5")
    (folder / "satellite.toml").write_text(craft, encoding="utf-8")
    return gs.read_scenario(folder / "mission.toml")


def inputs(scenario, run, step):
    """Inputs of Basilisk: spacecraft, start, commands, and the environment at each half step."""
    craft = spacecraft_of(structure_of(scenario), scenario.values)
    wheels, orbit, values = craft.wheels, planned_orbit(scenario), scenario.values
    drag = AerodynamicTorque(orbit, values["environment.torque.aerodynamic.drag_coefficient"])
    times = 0.5 * step * np.arange(round(2.0 * scenario.duration / step) + 1)
    tables = {
        "position": orbit.position,
        "velocity": orbit.velocity,
        "sun": orbit.sun,
        "field": orbit.field,
        "density": orbit.density,
        "wind": lambda time: orbit.velocity(time) - drag.relative_velocity(time),
    }
    facets = craft.facets("drag")
    dipole = "environment.torque.residual_dipole.dipole"
    return {
        **{name: np.asarray(jax.jit(jax.vmap(table))(times)) for name, table in tables.items()},
        "mass": craft.mass,
        "inertia": np.asarray(craft.inertia_locked()),
        "axes": np.asarray(wheels.axes),
        "rotor": float(np.ravel(wheels.inertia)[0]),
        "facets": np.asarray(facets.rows()),
        "drag": drag.drag_coefficient,
        "dipole": np.array([values[f"{dipole}.{axis}"] for axis in "xyz"]),
        "limit": values["actuator.torque_rods.limit.x"],
        "gravity": EARTH,
        "earth_radius": EARTH_RADIUS,
        "mrp": np.asarray(rotations.to_mrp(jnp.asarray(run.attitude.values[0]))),
        "rate": run.rate.values[0],
        "wheel_speed": run.wheel_speed.values[0],
        "torque": run.torque.values,
        "torque_rods": run.torque_rods.values,
        "period": values["run.control_period"],
        "duration": scenario.duration,
        "step": step,
    }


def basilisk(python, given):
    """Arrays that Basilisk finds for its inputs."""
    with tempfile.TemporaryDirectory() as made:
        asked, answered = Path(made) / "given.npz", Path(made) / "found.npz"
        np.savez(asked, **given)
        subprocess.run([python, PEER, asked, answered], check=True)
        with np.load(answered) as file:
            return dict(file)


def differences(run, theirs):
    """Largest differences of attitude, rad, body rate and wheel speed, rad/s."""
    turned = jax.vmap(rotations.error_angle)(
        jnp.asarray(run.attitude.values), jax.vmap(rotations.from_mrp)(jnp.asarray(theirs["mrp"]))
    )
    rate = np.abs(run.rate.values - theirs["rate"])
    speed = np.abs(run.wheel_speed.values - theirs["wheel_speed"])
    return [float(np.max(each)) for each in (turned, rate, speed)]


def run_time(scenario):
    """Processor time of one of 64 runs, s."""
    prepare(scenario)
    fly(scenario, 2, range(RUNS), engine="native")
    taken = []
    for _ in range(REPEATS):
        begun = time.process_time()
        flown = fly(scenario, 2, range(RUNS), engine="native")
        taken.append(time.process_time() - begun)
        assert not np.any(flown.columns["status"])
    return min(taken) / RUNS


def numbers(text):
    """Numbers with commas between them."""
    return [float(each) for each in text.split(",")]


def main():
    """Compare trajectories and times."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--basilisk", required=True, help="interpreter with Basilisk")
    parser.add_argument(
        "--steps", type=numbers, default=[0.25, 0.125, 0.0625], help="s, descending"
    )
    parser.add_argument("--timed", type=numbers, default=[0.125, 0.1, 0.05], help="steps, s")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        scenario = frictionless(Path(made))
        run = gs.simulate(scenario)
        own = {"frictionless": run_time(scenario)}
        own["as flown"] = run_time(gs.read_scenario(MISSION / "mission.toml"))
    for step in chosen.steps:
        is_last = step == chosen.steps[-1]
        timed = np.array(chosen.timed if is_last else [])
        theirs = basilisk(chosen.basilisk, {**inputs(scenario, run, step), "timed": timed})
        attitude, rate, speed = differences(run, theirs)
        print(f"step {step:g} s: {attitude:.2e} rad, {rate:.1e} rad/s, wheels {speed:.1e} rad/s")
    for name, seconds in own.items():
        print(f"gyrostat, {name}: {1e3 * seconds:.2f} ms a run")
    for step, setup, seconds, turned in zip(
        chosen.timed, theirs["setup"], theirs["seconds"], theirs["turned"], strict=True
    ):
        ratios = ", ".join(f"{seconds / each:.1f} ({name})" for name, each in own.items())
        print(
            f"Basilisk {theirs['version']}, step {step:g} s: {1e3 * seconds:.0f} ms a run, set-up "
            f"{1e3 * setup:.0f} ms, pointing error at the end {4.0 * turned:.1e} rad; over "
            f"gyrostat {ratios}"
        )
    sys.exit(not attitude <= LARGEST)


if __name__ == "__main__":
    main()
