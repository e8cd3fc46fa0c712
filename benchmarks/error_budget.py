"""Budgets by source of three linear loops against variances computed without a simulation of them.

python benchmarks/error_budget.py [--seeds 100] [--runs 32]

Each scenario has a known truth: the covariance of its closed loop in discrete time, one axis. For
every line of a budget the table gives the truth, the mean over seeds, and how often the 95 %
interval covers the truth. `noise`: attitude and rate with white noise, a constant torque that is
dispersed, and a torque that varies as a cosine. `delay`: the same noise, and commands one period
late. `filter`: star tracker and gyro with the Kalman filter.
"""

import argparse
import shutil
import tempfile
import time
from pathlib import Path

import numpy as np

import gyrostat as gs

EXAMPLES = Path(__file__).parents[1] / "examples" / "scenarios"
PERIOD, AFTER, COUNT = 0.25, 40.0, 400
INERTIA, KP, KD = np.array([0.06, 0.12, 0.14]), 0.02, 0.08
TILT, RATE = np.radians(0.003), np.radians(0.002)
TORQUE, SPREAD, WAVE, WAVE_RATE = 2e-7, 1e-7, 3e-7, 0.4
ANGLE_WALK, BIAS_WALK, BIAS_SIGMA = 1e-5, 1e-6, 1e-5
HEAD = f"""
[run]
duration = "{COUNT * PERIOD} s"
control_period = "{PERIOD} s"
DELAY
[spacecraft]
file = "body.toml"
[controller]
python = "own_controller.py:AttitudePD"
kp = {KP}
kd = {KD}
[metrics]
after = "{AFTER} s"
[[requirement]]
index = "APE"
level = 0.95
value = "20 arcsec"
axis = "x"
"""
WHITE = f"""
[sensors]
attitude_sigma = {TILT}
rate_sigma = {RATE}
"""
TORQUES = f"""
[environment]
external_torque = [{TORQUE}, 0.0, 0.0]
[[environment.torque]]
name = "wave"
kind = "harmonic"
rate = {WAVE_RATE}
cosine = [{WAVE}, 0.0, 0.0]
[[dispersion]]
key = "environment.external_torque.x"
distribution = "normal"
sigma = {SPREAD}
"""
FILTER = f"""
[sensors]
kind = "star_tracker_gyro"
attitude_sigma = {TILT}
angle_walk = {ANGLE_WALK}
bias_walk = {BIAS_WALK}
[estimator]
bias_sigma = {BIAS_SIGMA}
"""
SCENARIOS = {
    "noise": HEAD.replace("DELAY", "") + WHITE + TORQUES,
    "delay": HEAD.replace("DELAY", "command_delay = 1") + WHITE,
    "filter": HEAD.replace("DELAY", "") + FILTER,
}
WHEELS = "\n".join(
    f'[[wheel]]\nname = "{name}"\naxis = {axis}\ntorque_limit = 1.0\nmomentum_limit = 1.0\n'
    'model = "wheel.toml"\n'
    for name, axis in (("x", [1.0, 0, 0]), ("y", [0, 1.0, 0]), ("z", [0, 0, 1.0]))
)
WHEEL = """[wheel]
inertia = 2e-5
motor_constant = 0.005
[friction]
model = "viscous-coulomb"
viscous = 0.0
coulomb = 0.0
"""
STEP = np.array([[1.0, PERIOD], [0.0, 1.0]])
PUSH = np.array([PERIOD**2 / 2.0, PERIOD]) / INERTIA[0]


def steady(closed, entry, sigma):
    """Variance of the first state from white noise that enters by a vector."""
    covariance = np.zeros_like(closed)
    for _ in range(4 * COUNT):
        covariance = closed @ covariance @ closed.T + sigma**2 * np.outer(entry, entry)
    return covariance[0, 0]


def with_noise(delay):
    """Variance from attitude and rate noise; with a delay the command is a third state."""
    gains = np.array([KP, KD])
    if not delay:
        closed = STEP - np.outer(PUSH, gains)
        return [steady(closed, g * PUSH, s) for g, s in ((KP, TILT), (KD, RATE))]
    closed = np.zeros((3, 3))
    closed[:2, :2], closed[:2, 2], closed[2, :2] = STEP, PUSH, -gains
    entry = np.array([0.0, 0.0, 1.0])
    return [steady(closed, g * entry, s) for g, s in ((KP, TILT), (KD, RATE))]


def wave_response():
    """Attitude under the torque that varies as a cosine, from rest, at the samples."""
    fine, state, angles = 200, np.zeros(2), [0.0]
    step = PERIOD / fine
    for k in range(COUNT):
        control = -KP * state[0] - KD * state[1]
        for j in range(fine):
            torque = WAVE * np.cos(WAVE_RATE * (k * fine + j + 0.5) * step)
            turn = (control + torque) / INERTIA[0]
            state = state + np.array([state[1] * step + turn * step**2 / 2.0, turn * step])
        angles.append(state[0])
    return np.array(angles)


def write_parts(folder):
    """Write what the scenarios name: body, wheel and controller."""
    (folder / "body.toml").write_text(f"[body]\ninertia = {INERTIA.tolist()}\n{WHEELS}")
    (folder / "wheel.toml").write_text(WHEEL)
    shutil.copy(EXAMPLES / "own_controller.py", folder)


def filter_step(z, noise, gain):
    """State of loop and filter one period later, and the noise of tracker, gyro and bias.

    Args:
        z: Attitude, rate, gyro bias, estimated attitude and bias, control torque.
        noise: Standard normal numbers: tracker, angle walk, bias walk within the period, bias walk.
        gain: Gains of the filter for attitude and bias.
    """
    angle, rate, bias, estimate, known_bias, torque = z
    after, rate = STEP @ [angle, rate] + PUSH * torque
    later = bias + BIAS_WALK * np.sqrt(PERIOD) * noise[3]
    gyro = (after - angle) / PERIOD + 0.5 * (bias + later)
    gyro += ANGLE_WALK / np.sqrt(PERIOD) * noise[1]
    gyro += BIAS_WALK * np.sqrt(PERIOD / 12.0) * noise[2]
    predicted = estimate + PERIOD * (gyro - known_bias)
    innovation = after + TILT * noise[0] - predicted
    estimate, known_bias = predicted + gain[0] * innovation, known_bias + gain[1] * innovation
    torque = -KP * estimate - KD * (gyro - known_bias)
    return np.array([after, rate, later, estimate, known_bias, torque])


def with_filter():
    """Mean variance from tracker, angle walk and bias walk, by the covariance of loop and filter.

    The gains of the filter follow from its own covariance, which starts with the first sample.
    """
    walk = BIAS_WALK**2 * PERIOD
    angle = ANGLE_WALK**2 * PERIOD + walk * PERIOD**2 / 3.0
    process = np.array([[angle, -0.5 * walk * PERIOD], [-0.5 * walk * PERIOD, walk]])
    forward = np.array([[1.0, -PERIOD], [0.0, 1.0]])
    own = np.diag([TILT**2, BIAS_SIGMA**2])
    columns = {"tracker": [0], "angle": [1], "bias": [2, 3]}
    first = {
        "tracker": [np.array([0.0, 0.0, 0.0, TILT, 0.0, -KP * TILT])],
        "angle": [np.array([0.0, 0.0, 0.0, 0.0, 0.0, -KD * ANGLE_WALK / np.sqrt(PERIOD)])],
        "bias": [
            np.array([0.0, 0.0, 0.0, 0.0, 0.0, -KD * BIAS_WALK * np.sqrt(PERIOD / 12.0)]),
            np.array([0.0, 0.0, 1.0, 0.0, 0.0, -0.5 * KD]) * BIAS_WALK * np.sqrt(PERIOD),
        ],
    }
    covariance = {name: sum(np.outer(e, e) for e in entry) for name, entry in first.items()}
    variances = {name: [] for name in columns}
    for k in range(1, COUNT + 1):
        own = forward @ own @ forward.T + process
        gain = own[:, 0] / (own[0, 0] + TILT**2)
        own = own - np.outer(gain, own[0])
        move = np.column_stack([filter_step(e, np.zeros(4), gain) for e in np.eye(6)])
        enter = np.column_stack([filter_step(np.zeros(6), e, gain) for e in np.eye(4)])
        for name, which in columns.items():
            new = enter[:, which]
            covariance[name] = move @ covariance[name] @ move.T + new @ new.T
            if k * PERIOD >= AFTER:
                variances[name].append(covariance[name][0, 0])
    return [float(np.mean(each)) for each in variances.values()]


def truths():
    """Scenario -> line of its budget -> variance, rad²."""
    tilt, rate = with_noise(0)
    late_tilt, late_rate = with_noise(1)
    tracker, angle, bias = with_filter()
    constant = (TORQUE / KP) ** 2
    noise = {
        "bias (mean error)": constant,
        "attitude noise": tilt,
        "rate noise": rate,
        "external torque": (SPREAD / KP) ** 2,
        "environment.torque.wave": np.var(wave_response()[round(AFTER / PERIOD) :]),
    }
    delay = {"attitude noise": late_tilt, "rate noise": late_rate}
    with_gyro = {"star tracker noise": tracker, "gyro noise": angle, "gyro bias walk": bias}
    tables = {"noise": noise, "delay": delay, "filter": with_gyro}
    for name, table in tables.items():
        table["whole"] = sum(table.values())
        table["interactions"] = 0.0
        if name == "delay":
            table["missing without the delay"] = table["whole"] - tilt - rate
    return tables


def found(result):
    """Line of a budget -> its estimate, rad²."""
    (index,) = result.indices
    lines = {line.name: line.mean_square for line in index.lines()}
    lines["whole"] = index.split.whole
    if "delay of the command" in index.properties:
        lines["missing without the delay"] = index.properties["delay of the command"]
    return lines


def main():
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--seeds", type=int, default=100)
    arguments.add_argument("--runs", type=int, default=32)
    options = arguments.parse_args()
    print("| scenario | line | truth (arcsec²) | mean found | covered |\n|---|---|---|---|---|")
    square, worst = np.degrees(3600.0) ** 2, 1.0
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_parts(folder)
        for scenario, truth in truths().items():
            path = folder / f"{scenario}.toml"
            path.write_text(f'name = "{scenario}"\n{SCENARIOS[scenario]}')
            estimates = {line: [] for line in truth}
            for seed in range(options.seeds):
                result = gs.budget(path, folder / f"{scenario}{seed}", runs=options.runs, seed=seed)
                lines = found(result)
                for line, values in estimates.items():
                    values.append(lines[line])
            for line, expected in truth.items():
                value, low, high = square * np.array(estimates[line]).T
                expected *= square
                share = float(np.mean((low <= expected) & (expected <= high)))
                worst = min(worst, share)
                print(
                    f"| {scenario} | {line} | {expected:.4g} | {np.mean(value):.4g} "
                    f"| {100.0 * share:.0f} % |",
                    flush=True,
                )
    seconds = time.perf_counter() - begun
    print(f"\n{options.seeds} budgets of {options.runs} runs each, {seconds:.0f} s")
    return 0 if worst > 0.8 else 1


if __name__ == "__main__":
    raise SystemExit(main())
