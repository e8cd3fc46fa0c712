"""The C of flight pieces: bit by bit as a separate interpreter has it, and as compiled JAX."""

import shutil
import subprocess
from functools import partial
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.codegen.tracing import as_arrays
from gyrostat.control import (
    DynamicModelCompensator,
    EstimatingCompensator,
    FieldLimits,
    Guarded,
    MeasurementGuard,
    SpeedMode,
)
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import FrictionScaleFilter
from gyrostat.exports import entries
from gyrostat.spacecraft import TableMeasurement
from gyrostat.wheel import advance

LANES = 10_000
MEASUREMENT = TableMeasurement(0.01, 0.003, 3.0)
STEPS = 100_000


def command(controller, memory, measurement):
    """Command a current."""
    return controller(memory, measurement)


def track(filter, estimate, current, period, speed):
    """Carry over a period and take in a speed."""
    return filter.correct(filter.predict(estimate, current, period), speed)


def pieces(g2):
    """Name -> function, arguments and results of what is emitted here."""
    wheel, law = g2.wheel, g2.law
    compensator = EstimatingCompensator.tune(law, wheel, 0.495, 0.5, 0.1, delay=1)
    paper = DynamicModelCompensator(law, wheel.friction, wheel.motor_constant, 0.4)
    speed = SpeedMode(law, wheel.inertia, wheel.motor_constant, current_limit=0.4)
    scale = FrictionScaleFilter(wheel, 0.5, 1e-3)

    def loop(controller):
        arguments = {"controller": controller, "memory": controller.start(0.1)}
        return command, {**arguments, "measurement": MEASUREMENT}, ("memory", "command")

    limits = {"attitude": FieldLimits(-0.02, 0.02), "rate": FieldLimits(-0.01, 0.01, 0.05)}
    guard = MeasurementGuard.of(MEASUREMENT, limits, "zero")
    known = {"controller": compensator, "guard": guard}
    memory = Guarded(compensator, guard).start(0.1)
    guarded = {**known, "memory": memory, "measurement": MEASUREMENT}
    moved = {"wheel": wheel, "speed": 0.05, "current": 0.05, "slope": 0.1, "duration": 0.1}
    seen = {"filter": scale, "estimate": scale.start(3.0), "current": 0.05}
    return {
        "compensator": loop(compensator),
        "guarded": (entries.command, guarded, ("memory", "command", "report")),
        "paper": loop(paper),
        "speed_mode": loop(speed),
        "wheel": (advance, moved, ("speed", "resolved")),
        "scale": (track, {**seen, "period": 0.1, "measured": 3.0}, ("estimate",)),
    }


NAMES = ("compensator", "guarded", "paper", "speed_mode", "wheel", "scale")


@pytest.fixture(scope="module")
def piece(g2, tools, tmp_path_factory):
    """Everything about one piece, made once."""
    known = {}

    def make(name):
        if name not in known:
            function, arguments, results = pieces(g2)[name]
            arguments = {key: as_arrays(tree) for key, tree in arguments.items()}
            module = emit(name, [Entry(f"{name}_step", function, arguments, results)])
            compiled = tools.Compiled(module, tmp_path_factory.mktemp(name))
            call = partial(compiled, f"{name}_step")
            jaxpr = jax.make_jaxpr(function)(*arguments.values())
            known[name] = SimpleNamespace(
                function=function, arguments=arguments, results=results, call=call, jaxpr=jaxpr,
                module=module,
            )  # fmt: skip
        return known[name]

    return make


def scattered(arguments, lanes, seed=0):
    """Arguments about their values, with both signs where a number is no parameter."""
    random = np.random.default_rng(seed)

    def about(name, leaf):
        leaf, shape = np.asarray(leaf), (lanes, *np.shape(leaf))
        if leaf.dtype == bool:
            return random.random(shape) < 0.7
        values = np.where(leaf == 0.0, 1e-3 * np.abs(random.standard_normal(shape)), leaf)
        values = values * np.exp(0.5 * random.standard_normal(shape))
        if name in ("measurement", "speed", "current", "measured"):
            values = values * random.choice([-1.0, 0.0, 1.0], p=[0.45, 0.1, 0.45], size=shape)
        return values.astype(leaf.dtype)

    return {name: jax.tree.map(partial(about, name), tree) for name, tree in arguments.items()}


@pytest.mark.parametrize("name", NAMES)
def test_c_is_the_interpreter_bit_by_bit(name, piece, tools):
    this = piece(name)
    given = scattered(this.arguments, LANES)
    status, found = this.call(given)
    flat = [np.asarray(leaf) for leaf in jax.tree.leaves(list(given.values()))]
    expected = [array for array in tools.interpret(this.jaxpr, flat) if array.size]
    got = [leaf for result in this.results for leaf in found[result]]
    assert len(got) == len(expected)
    for ours, theirs in zip(got, expected, strict=True):
        np.testing.assert_array_equal(ours, theirs)
        assert np.isfinite(ours).mean() > 0.9
        if ours.dtype == float:  # a zero of the other sign is equal too
            there = ~np.isnan(ours)
            np.testing.assert_array_equal(np.signbit(ours[there]), np.signbit(theirs[there]))
    assert status.max() == 0


@pytest.mark.parametrize("name", NAMES)
def test_c_is_compiled_jax_within_rounding(name, piece):
    this = piece(name)
    given = scattered(this.arguments, LANES, seed=1)
    _, found = this.call(given)
    expected = jax.jit(jax.vmap(this.function))(*given.values())
    got = [leaf for result in this.results for leaf in found[result]]
    wide = [np.asarray(leaf) for leaf in jax.tree.leaves(expected) if np.size(leaf)]
    for ours, theirs in zip(got, wide, strict=True):
        if ours.dtype == bool:
            np.testing.assert_array_equal(ours, theirs)
            continue
        scale = np.max(np.abs(theirs))
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-14 * scale)


def test_the_wheels_of_these_lanes_rest_turn_and_cross(piece):
    this = piece("wheel")
    given = scattered(this.arguments, LANES)
    speed = this.call(given)[1]["speed"][0]
    for seen in (speed == 0.0, speed * given["speed"] < 0.0, speed * given["speed"] > 0.0):
        assert seen.mean() > 0.05


@pytest.mark.parametrize("name", ["guarded", "wheel"])
def test_the_static_analyser_finds_nothing(name, piece, tools, tmp_path):
    if "gcc" not in tools.compiler():
        pytest.skip(f"{tools.compiler()} has no -fanalyzer: found no gcc")
    tools.write(piece(name).module, tmp_path)
    tools.build(tmp_path, "-fanalyzer", "-c", f"{name}.c")


@pytest.mark.parametrize("name", ["guarded", "wheel"])
def test_cppcheck_finds_nothing(name, piece, tools, tmp_path):
    """Nor does its addon for the rules of MISRA C, as far as that knows them."""
    if shutil.which("cppcheck") is None:
        pytest.skip("found no cppcheck")
    tools.write(piece(name).module, tmp_path)
    checks = "--enable=warning,style,performance,portability"
    # the constants of an enumeration are for the caller: 2.4, a tag that is not used, is advisory
    own = ["--addon=misra", "--suppress=misra-c2012-2.4:*.h"]
    command = ["cppcheck", "--std=c99", checks, *own, "--quiet", f"{name}.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.stderr + done.stdout == ""
    assert done.returncode == 0


@pytest.mark.parametrize("name", NAMES)
def test_what_becomes_of_nan_is_what_python_says(name, piece, tools):
    """Nothing stops at a NaN: it goes through, or is left out where the Python does that."""
    this = piece(name)
    given = scattered(this.arguments, 200, seed=2)
    random = np.random.default_rng(3)

    def broken(leaf):
        bad = random.choice([np.nan, np.inf, -np.inf], leaf.shape)
        return np.where(random.random(leaf.shape) < 0.1, bad, leaf) if leaf.dtype == float else leaf

    measured = [key for key in given if key in ("measurement", "speed", "current", "measured")]
    given |= {key: jax.tree.map(broken, given[key]) for key in measured}
    _, found = this.call(given)
    flat = [np.asarray(leaf) for leaf in jax.tree.leaves(list(given.values()))]
    expected = [array for array in tools.interpret(this.jaxpr, flat) if array.size]
    for ours, theirs in zip(
        [leaf for result in this.results for leaf in found[result]], expected, strict=True
    ):
        np.testing.assert_array_equal(ours, theirs)


def test_a_nan_measurement_gives_a_nan_command_and_a_filter_counts_it(piece):
    this = piece("compensator")
    given = scattered(this.arguments, 10)
    given["measurement"] = given["measurement"]._replace(attitude=np.full(10, np.nan))
    _, found = this.call(given)
    assert np.isnan(found["command"][0]).all()
    this = piece("scale")
    given = scattered(this.arguments, 10)
    before = given["estimate"].missed
    _, found = this.call(given | {"measured": np.full(10, np.nan)})
    state, *_, missed, _ = found["estimate"]
    assert np.isfinite(state).all()
    np.testing.assert_array_equal(missed, before + 1.0)


class Turning(NamedTuple):
    """A table and its wheel, in smooth friction."""

    attitude: float
    rate: float
    speed: float


def closed(controller, memory, state, noise):
    """One period of the whole loop: command, then plant."""
    measurement = TableMeasurement(state.attitude, state.rate, state.speed + noise)
    memory, command = controller(memory, measurement)
    friction = 9e-4 * jnp.tanh(state.speed / 0.3) + 5e-6 * state.speed
    torque = 0.0228 * command.current - friction
    rate = state.rate + 0.1 * (4.6e-4 - torque) / 0.495
    speed = state.speed + 0.1 * torque / 1.5e-3
    return memory, Turning(state.attitude + 0.1 * rate, rate, speed), command


def test_a_long_closed_loop_stays_with_python(g2, tools, tmp_path):
    """C keeps its own state and its own plant over 100 000 steps."""
    controller = as_arrays(EstimatingCompensator.tune(g2.law, g2.wheel, 0.495, 0.5, 0.1))
    memory, state = as_arrays((controller.start(0.1), Turning(0.005, 0.0, -30.0)))
    noise = 0.5 * np.random.default_rng(4).standard_normal(STEPS)
    arguments = {"controller": controller, "memory": memory, "state": state, "noise": 0.0}
    entry = Entry("closed", closed, arguments, ("memory", "state", "command"))
    compiled = tools.Compiled(emit("closed_loop", [entry]), tmp_path)
    given = {
        "controller": controller,
        "memory": memory,
        "state": state,
        "noise": noise,
        "command": None,
    }
    found = compiled.sequence("closed", given, moving=("noise",))

    def step(carry, noise):
        memory, state, command = closed(controller, *carry, noise)
        return (memory, state), (memory, state, command)

    last, (_, states, commands) = jax.jit(lambda: jax.lax.scan(step, (memory, state), noise))()
    assert np.any(states.speed > 0.0)
    assert np.any(states.speed < 0.0)
    scale = np.abs(np.asarray(commands)).max(axis=1)[:, None]
    np.testing.assert_allclose(
        np.array(found["command"]) / scale, np.array(commands) / scale, rtol=0.0, atol=1e-12
    )
    last = [leaf for leaf in jax.tree.leaves(last) if leaf.size]
    for ours, theirs in zip(found["memory"] + found["state"], last, strict=True):
        np.testing.assert_allclose(ours[0], theirs, rtol=1e-12, atol=1e-12)
