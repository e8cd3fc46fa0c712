"""The co-simulation unit through its own interface, and through an independent tool."""

import ctypes
import zipfile
from collections import namedtuple
from xml.etree import ElementTree

import numpy as np
import pytest

from gyrostat.control import AttitudePID, CurrentMode, EstimatingCompensator, FieldLimits
from gyrostat.core.jax64 import jax, jnp
from gyrostat.exports import CompensatedWheel, targets, write_fmu
from gyrostat.exports.compensated_wheel import BodyMeasurement
from gyrostat.exports.target import flight_module
from gyrostat.exports.unit_text import base_exponents, unit_of
from gyrostat.wheel import Wheel, advance
from gyrostat.wheel.friction import Stribeck

STEPS, PERIOD = 600, 0.1
CURRENT = 0.08 * np.sin(0.3 * PERIOD * np.arange(STEPS))
ALLOCATE = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t)
RELEASE = ctypes.CFUNCTYPE(None, ctypes.c_void_p)


class Callbacks(ctypes.Structure):
    """What the simulator gives."""

    _fields_ = [
        ("log", ctypes.c_void_p),
        ("allocate", ALLOCATE),
        ("release", RELEASE),
        ("finished", ctypes.c_void_p),
        ("environment", ctypes.c_void_p),
    ]


class Unit:
    """An instance of a unit."""

    def __init__(self, path, folder, guid=None):
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        (library,) = (folder / "binaries").rglob(f"{path.stem}.*")
        self.library = ctypes.CDLL(str(library))
        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
        self.variables = {v.get("name"): v for v in root.iter("ScalarVariable")}
        self.blocks = {}
        c = ctypes.CDLL(None)
        c.calloc.restype, c.calloc.argtypes = ctypes.c_void_p, [ctypes.c_size_t] * 2
        c.free.restype, c.free.argtypes = None, [ctypes.c_void_p]

        def allocate(count, size):
            place = c.calloc(count, size)
            self.blocks[place] = size
            return place

        def release(place):
            del self.blocks[place]
            c.free(place)

        self.callbacks = Callbacks(None, ALLOCATE(allocate), RELEASE(release), None, None)
        make = self.library.fmi2Instantiate
        make.restype = ctypes.c_void_p
        key = (guid or root.get("guid")).encode()
        self.instance = make(b"one", 1, key, b"", ctypes.byref(self.callbacks), 0, 0)

    def call(self, name, *arguments):
        return getattr(self.library, name)(ctypes.c_void_p(self.instance), *arguments)

    def begin(self):
        nothing = ctypes.c_double(0.0)
        assert self.call("fmi2SetupExperiment", 0, nothing, nothing, 0, nothing) == 0
        assert self.call("fmi2EnterInitializationMode") == 0
        assert self.call("fmi2ExitInitializationMode") == 0

    def step(self, now, duration):
        return self.call("fmi2DoStep", ctypes.c_double(now), ctypes.c_double(duration), 1)

    def get(self, name):
        value, reference = ctypes.c_double(np.nan), self._reference(name)
        assert self.call("fmi2GetReal", reference, ctypes.c_size_t(1), ctypes.byref(value)) == 0
        return value.value

    def set(self, name, value):
        given, reference = ctypes.c_double(value), self._reference(name)
        assert self.call("fmi2SetReal", reference, ctypes.c_size_t(1), ctypes.byref(given)) == 0

    def _reference(self, name):
        return ctypes.byref(ctypes.c_uint(int(self.variables[name].get("valueReference"))))


@pytest.fixture(scope="module")
def wheel_unit(g2, tools, tmp_path_factory):
    """Path of a unit of the wheel."""
    tools.compiler()
    path = tmp_path_factory.mktemp("fmu") / "wheel.fmu"
    assert write_fmu(targets.wheel(g2.wheel, PERIOD), path) is not None
    return path


@pytest.fixture(scope="module")
def expected(g2):
    """Speeds of the wheel in Python, rad/s, after each step."""

    def step(speed, current):
        speed = advance(g2.wheel, speed, current, 0.0, PERIOD).speed
        return speed, speed

    return np.array(jax.jit(lambda: jax.lax.scan(step, jnp.array(-0.5), CURRENT)[1])())


def run(unit, first=0, last=STEPS):
    speeds = []
    for k in range(first, last):
        unit.set("current", CURRENT[k])
        assert unit.step(k * PERIOD, PERIOD) == 0
        speeds.append(unit.get("speed"))
    return np.array(speeds)


def test_a_minute_of_the_wheel_is_a_minute_in_python(wheel_unit, expected, tmp_path):
    unit = Unit(wheel_unit, tmp_path)
    unit.set("speed", -0.5)
    unit.begin()
    speeds = run(unit)
    np.testing.assert_allclose(speeds, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
    assert np.any(expected == 0.0)
    assert np.any(expected > 0.0)
    assert np.any(expected < 0.0)
    unit.call("fmi2FreeInstance")
    assert unit.blocks == {}


def test_a_state_is_kept_written_out_and_taken_up_again(wheel_unit, expected, tmp_path):
    unit = Unit(wheel_unit, tmp_path / "first")
    unit.set("speed", -0.5)
    unit.begin()
    half = STEPS // 2
    run(unit, 0, half)
    kept, size = ctypes.c_void_p(), ctypes.c_size_t()
    assert unit.call("fmi2GetFMUstate", ctypes.byref(kept)) == 0
    assert unit.call("fmi2SerializedFMUstateSize", kept, ctypes.byref(size)) == 0
    text = ctypes.create_string_buffer(size.value)
    assert unit.call("fmi2SerializeFMUstate", kept, text, size) == 0
    assert unit.call("fmi2SerializeFMUstate", kept, text, ctypes.c_size_t(1)) == 3
    first = run(unit, half)
    assert unit.call("fmi2SetFMUstate", kept) == 0
    np.testing.assert_array_equal(run(unit, half), first)
    assert unit.call("fmi2FreeFMUstate", ctypes.byref(kept)) == 0
    # another instance takes up what the first one wrote
    other = Unit(wheel_unit, tmp_path / "other")
    state = ctypes.c_void_p()
    assert other.call("fmi2DeSerializeFMUstate", text, size, ctypes.byref(state)) == 0
    assert other.call("fmi2SetFMUstate", state) == 0
    np.testing.assert_array_equal(run(other, half), first)
    assert other.call("fmi2FreeFMUstate", ctypes.byref(state)) == 0
    for each in (unit, other):
        each.call("fmi2FreeInstance")
        assert each.blocks == {}


def test_parameters_are_tunable_and_reset_brings_them_back(wheel_unit, g2, tmp_path):
    unit = Unit(wheel_unit, tmp_path)
    name = "wheel.friction.coulomb"
    assert unit.get(name) == g2.wheel.friction.coulomb
    assert unit.variables[name].get("variability") == "tunable"
    assert unit.variables[name].find("Real").get("unit") == "N·m"
    ends = []
    for coulomb in (0.8795e-3, 1.2e-3):
        assert unit.call("fmi2Reset") == 0
        unit.set(name, coulomb)
        unit.set("wheel.friction.static_", 1.3e-3)
        unit.set("speed", 20.0)
        unit.begin()
        unit.step(0.0, 0.7)  # of any length
        ends.append(unit.get("speed"))
    viscous, inertia = g2.wheel.friction.viscous, g2.wheel.inertia
    expected = (1.2e-3 - 0.8795e-3) / viscous * -np.expm1(-viscous / inertia * 0.7)
    assert ends[0] - ends[1] == pytest.approx(expected, rel=1e-9)
    assert unit.call("fmi2Reset") == 0
    assert unit.get(name) == g2.wheel.friction.coulomb


def test_a_wrong_key_a_wrong_variable_and_a_wrong_step_are_refused(g2, tools, wheel_unit, tmp_path):
    assert Unit(wheel_unit, tmp_path / "a", guid="{other}").instance is None
    tools.compiler()
    path = tmp_path / "controller.fmu"
    law = CurrentMode(AttitudePID(1.0, 0.0, 0.0), 0.02)
    write_fmu(targets.controller(law, PERIOD), path)
    unit = Unit(path, tmp_path / "b")
    unit.begin()
    unit.set("measurement.attitude", 0.03)
    assert unit.step(0.0, 0.15) == 3  # no whole number of its periods
    assert unit.step(0.0, 0.3) == 0
    assert unit.get("command.current") == pytest.approx(0.03 / 0.02, rel=1e-15)
    reference, value = ctypes.c_uint(999), ctypes.c_double()
    one = ctypes.c_size_t(1)
    assert unit.call("fmi2GetReal", ctypes.byref(reference), one, ctypes.byref(value)) == 3


def test_the_same_unit_is_the_same_file(g2, tools, tmp_path):
    tools.compiler()
    law = CurrentMode(AttitudePID(1.0, 0.0, 0.0), 0.02)
    for name in ("a", "b"):
        write_fmu(targets.controller(law, PERIOD), tmp_path / name)
    assert (tmp_path / "a").stat().st_size > 10_000
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_classes_of_a_user_may_have_the_names_of_the_interface(tools, tmp_path):
    tools.compiler()
    names = ("Status", "Log", "Values", "Instance", "Callbacks", "FINE", "step", "begin", "own")
    law = tuple(namedtuple(name, "gain")(1.0) for name in names)

    def step(law, rate):
        return sum(part.gain for part in law) * rate

    module = flight_module(
        "law",
        {"law": law},
        {},
        [],
        [("step", step, ("torque",))],
        title="Law",
        period=PERIOD,
        constants={},
        inputs={"rate": np.zeros(2)},
    )
    assert write_fmu(module, tmp_path / "law.fmu") is not None


def test_an_independent_tool_validates_and_simulates_it(wheel_unit, expected):
    fmpy = pytest.importorskip("fmpy", reason="found no fmpy, of the extra peers")
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(wheel_unit)) == []
    time = PERIOD * np.arange(STEPS)
    given = np.array(list(zip(time, CURRENT, strict=True)), [("time", "f8"), ("current", "f8")])
    found = fmpy.simulate_fmu(
        str(wheel_unit),
        stop_time=STEPS * PERIOD,
        step_size=PERIOD,
        output_interval=PERIOD,
        start_values={"speed": -0.5},
        input=given,
        output=["speed"],
    )
    assert found["speed"][0] == -0.5
    # the tool gives inputs as straight lines between their samples, sampled where a step begins
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found["speed"][1:], expected, rtol=0.0, atol=1e-12 * scale)


TABLE, FAN, START = 0.495, 0.46e-3, -10.0


@pytest.fixture(scope="module")
def compensated(g2):
    """A wheel with 3 % more friction than its compensator was told, and a period of delay."""
    curve = g2.wheel.friction
    rubs = Stribeck(curve.viscous, 1.03 * curve.coulomb, 1.03 * curve.static, curve.stribeck_speed)
    tuned = EstimatingCompensator.tune(g2.law, g2.wheel, TABLE, 0.5, PERIOD, delay=1)
    return CompensatedWheel(tuned, Wheel(g2.wheel.inertia, g2.wheel.motor_constant, rubs))


@pytest.fixture(scope="module")
def compensated_unit(compensated, tools, tmp_path_factory):
    """Path of a unit of the wheel with its compensator."""
    tools.compiler()
    path = tmp_path_factory.mktemp("fmu") / "compensated_wheel.fmu"
    assert write_fmu(targets.compensated_wheel(compensated, PERIOD), path) is not None
    return path


@pytest.fixture(scope="module")
def in_python(compensated):
    """One control period in Python: (state, attitude, rate) -> (state, output)."""
    return jax.jit(lambda state, *seen: compensated(state, BodyMeasurement(*seen)))


def on_a_table(step, steps=STEPS, attitude=0.0, rate=0.0):
    """Attitudes, rad, of a table that a fan drives and a wheel holds."""
    attitudes = []
    for k in range(steps):
        acceleration = (step(k, attitude, rate) + FAN) / TABLE
        attitude += PERIOD * (rate + 0.5 * PERIOD * acceleration)
        rate += PERIOD * acceleration
        attitudes.append(attitude)
    return np.array(attitudes)


def through(unit, speeds):
    """A control period of the unit; keeps the speeds."""

    def step(k, attitude, rate):
        unit.set("measurement.attitude", attitude)
        unit.set("measurement.rate", rate)
        assert unit.step(k * PERIOD, PERIOD) == 0
        speeds.append(unit.get("output.speed"))
        return unit.get("output.torque")

    return step


def begun(path, folder):
    unit = Unit(path, folder)
    unit.set("initial_speed", START)
    unit.begin()
    return unit


def test_a_minute_with_the_compensator_is_a_minute_in_python(
    compensated, compensated_unit, in_python, tmp_path
):
    state, expected, speeds = compensated.start(START, PERIOD), [], []

    def step(k, attitude, rate):
        nonlocal state
        state, output = in_python(state, attitude, rate)
        assert output.resolved
        expected.append(float(output.speed))
        return float(output.torque)

    attitudes = on_a_table(step)
    unit = begun(compensated_unit, tmp_path)
    found = on_a_table(through(unit, speeds))
    np.testing.assert_allclose(speeds, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(found, attitudes, rtol=0.0, atol=1e-12 * np.abs(attitudes).max())
    # it goes through zero, holds the table there, and learns how much more friction there is
    assert min(speeds) < 0.0 < max(speeds)
    assert np.abs(found[300:]).max() < np.radians(0.05)
    assert unit.get("output.friction_scale") == pytest.approx(1.03, abs=0.01)
    assert unit.get("output.estimated_torque") == pytest.approx(FAN, rel=0.1)
    unit.call("fmi2FreeInstance")


def test_the_state_of_wheel_and_compensator_is_written_out_and_taken_up(compensated_unit, tmp_path):
    unit = begun(compensated_unit, tmp_path / "a")
    on_a_table(through(unit, []), 100)
    kept, size = ctypes.c_void_p(), ctypes.c_size_t()
    assert unit.call("fmi2GetFMUstate", ctypes.byref(kept)) == 0
    assert unit.call("fmi2SerializedFMUstateSize", kept, ctypes.byref(size)) == 0
    text = ctypes.create_string_buffer(size.value)
    assert unit.call("fmi2SerializeFMUstate", kept, text, size) == 0
    first = on_a_table(through(unit, []), 100, 1e-3)
    assert unit.call("fmi2SetFMUstate", kept) == 0
    np.testing.assert_array_equal(on_a_table(through(unit, []), 100, 1e-3), first)
    other = begun(compensated_unit, tmp_path / "b")
    assert not np.array_equal(on_a_table(through(other, []), 100, 1e-3), first)
    state = ctypes.c_void_p()
    assert other.call("fmi2DeSerializeFMUstate", text, size, ctypes.byref(state)) == 0
    assert other.call("fmi2SetFMUstate", state) == 0
    np.testing.assert_array_equal(on_a_table(through(other, []), 100, 1e-3), first)


def test_a_compensator_without_current_lets_its_wheel_coast(compensated_unit, g2, tmp_path):
    """Its limit is tuned to nothing on the way, the friction of the wheel alone is set before."""
    unit = Unit(compensated_unit, tmp_path)
    coulomb = 1.2e-3
    for name in ("coulomb", "static_"):
        unit.set(f"unit.wheel.friction.{name}", coulomb)
    unit.set("initial_speed", 20.0)
    unit.begin()
    through(unit, [])(0, 1e-3, 0.0)
    unit.set("unit.compensator.current_limit", 0.0)
    speeds = []
    for k in (1, 2, 3, 4, 5, 6):
        through(unit, speeds)(k, 0.0, 0.0)
    # the command of the period before is still under way in the first
    viscous, inertia = g2.wheel.friction.viscous, g2.wheel.inertia
    level, shrinks = coulomb / viscous, np.exp(-viscous / inertia * 5 * PERIOD)
    assert speeds[-1] == pytest.approx((speeds[0] + level) * shrinks - level, rel=1e-12)
    gained = inertia * (speeds[-1] - speeds[-2]) / PERIOD
    assert unit.get("output.torque") == pytest.approx(-gained, rel=1e-9)


def test_what_a_unit_of_both_says_of_itself(compensated_unit, tmp_path):
    unit = Unit(compensated_unit, tmp_path)
    told = {
        "output.torque": ("output", "continuous", "N·m"),
        "measurement.attitude": ("input", "continuous", "rad"),
        "measurement.rate": ("input", "continuous", "rad/s"),
        "initial_speed": ("parameter", "fixed", "rad/s"),
        "period": ("parameter", "fixed", "s"),
        "unit.wheel.friction.coulomb": ("parameter", "tunable", "N·m"),
        "unit.compensator.friction.coulomb": ("parameter", "tunable", "N·m"),
        "state.memory.controller.rate.torque": ("local", "continuous", "N·m"),
    }
    for name, (causality, variability, unit_name) in told.items():
        variable = unit.variables[name]
        assert variable.get("causality") == causality
        assert variable.get("variability") == variability
        assert variable.find("Real").get("unit") == unit_name


def test_an_independent_tool_simulates_both(compensated, compensated_unit, in_python):
    fmpy = pytest.importorskip("fmpy", reason="found no fmpy, of the extra peers")
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(compensated_unit)) == []
    time = PERIOD * np.arange(STEPS)
    attitude, rate = 1e-3 * np.sin(0.5 * time), 5e-4 * np.cos(0.5 * time)
    names = [(name, "f8") for name in ("time", "measurement.attitude", "measurement.rate")]
    found = fmpy.simulate_fmu(
        str(compensated_unit),
        stop_time=STEPS * PERIOD,
        step_size=PERIOD,
        output_interval=PERIOD,
        start_values={"initial_speed": -0.2},
        input=np.array(list(zip(time, attitude, rate, strict=True)), names),
        output=["output.speed"],
    )
    state, expected = compensated.start(-0.2, PERIOD), []
    for seen in zip(attitude, rate, strict=True):
        state, output = in_python(state, *seen)
        expected.append(float(output.speed))
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found["output.speed"][1:], expected, rtol=0.0, atol=1e-12 * scale)


def test_units_are_taken_from_descriptions():
    assert unit_of("of the motor, A.") == "A"
    assert unit_of("K_i, N·m/(rad·s).") == "N·m/(rad·s)"
    assert unit_of("of both, N²·m²·s.") == "N²·m²·s"
    assert unit_of("gives the demanded wheel torque.") == ""
    assert unit_of("of the friction scale in the square root of a second, 1/√s.") == ""
    assert base_exponents("N·m/(rad·s)") == {"kg": 1, "m": 2, "s": -3, "rad": -1}
    assert base_exponents("V") == {"kg": 1, "m": 2, "s": -3, "A": -1}
    assert base_exponents("1") == {}


def test_a_unit_holds_its_command_over_a_bad_sample_and_says_so(g2, tools, tmp_path):
    tools.compiler()
    path = tmp_path / "controller.fmu"
    law = AttitudePID(1.0, 0.0, 0.0)
    limits = {"attitude": FieldLimits(-0.1, 0.1)}
    write_fmu(targets.controller(CurrentMode(law, 0.02), PERIOD, limits), path)
    unit = Unit(path, tmp_path)
    unit.begin()
    found = []
    for k, attitude in enumerate((0.02, np.nan, 0.2, 0.04)):
        unit.set("measurement.attitude", attitude)
        unit.step(k * PERIOD, PERIOD)
        status, reference = ctypes.c_int(-1), unit._reference("report.sample_status")
        got = unit.call("fmi2GetInteger", reference, ctypes.c_size_t(1), ctypes.byref(status))
        assert got == 0
        found.append((status.value, unit.get("command.current")))
    assert found == [(0, 1.0), (2, 1.0), (3, 1.0), (0, 2.0)]
    variable = unit.variables["report.sample_status"]
    assert variable.find("Integer") is not None
    assert variable.get("causality") == "output"
    assert unit.variables["guard.limits.attitude.upper"].get("causality") == "parameter"


def test_the_verb_writes_a_unit_and_refuses_single_precision(run, tools, tmp_path):
    tools.compiler()
    model = tmp_path / "model.toml"
    model.write_text(
        "[wheel]\ninertia = 0.0015\nmotor_constant = 0.0228\n"
        '[friction]\nmodel = "viscous-coulomb"\nviscous = 5e-6\ncoulomb = 9e-4\n',
        encoding="utf-8",
    )
    words = ("--to", "fmu", "--what", "controller", "--period", "0.1", "--gains", "1,0,0")
    code, printed, said = run("export", model, *words, "--out", tmp_path / "out", "--json")
    assert code == 0, said
    assert printed == '{"files": ["controller.fmu"]}\n'
    assert Unit(tmp_path / "out" / "controller.fmu", tmp_path / "unit").instance is not None
    both = (*words[:3], "compensated-wheel", *words[4:], "--table-inertia", "0.495")
    code, printed, said = run(
        "export", model, *both, "--speed-sigma", "5rpm", "--out", tmp_path / "out", "--json"
    )
    assert code == 0, said
    assert printed == '{"files": ["compensated_wheel.fmu"]}\n'
    path = tmp_path / "out" / "compensated_wheel.fmu"
    assert Unit(path, tmp_path / "both").instance is not None
    code, _, said = run("export", model, *words, "--out", tmp_path / "no", "--precision", "float")
    assert code == 2
    assert "--precision" in said
    assert not (tmp_path / "no").exists()


def test_without_a_compiler_a_unit_holds_its_sources(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    path = tmp_path / "controller.fmu"
    law = CurrentMode(AttitudePID(1.0, 0.0, 0.0), 0.02)
    assert write_fmu(targets.controller(law, PERIOD), path) is None
    names = zipfile.ZipFile(path).namelist()
    assert "sources/controller.c" in names
    assert not any(name.startswith("binaries") for name in names)
